"""What is checked of a sentence: its numbers and series, in their order; its wording is read where
it stands."""

import re

FOUND = re.compile(
    r"(?<![\w.])(?:[xyz]\d(?!\w)|L(?!\w)"
    r"|[−+-]?\d+(?:\N{NARROW NO-BREAK SPACE}\d+)*(?:\.\d+)?"
    r"(?: ?(?:%|°)| (?:µm|mm/h|mm|m|s|min|Hz|ppm/m|ppm|µrad)(?!\w))?)"
)


def numbers_in(words: str) -> str:
    """`98.5 s, 0.771 mm, y2`."""
    return ", ".join(FOUND.findall(words.replace("\N{NARROW NO-BREAK SPACE}", "")))
