"""What is checked of a sentence: its numbers and series, in their order; its wording is read where
it stands."""

import re
import tomllib
from pathlib import Path

from mocap_metrology.present.text import sentence

FOUND = re.compile(
    r"(?<![\w.])(?:[xyz]\d(?!\w)|L(?!\w)"
    r"|[−+-]?\d+(?:\N{NARROW NO-BREAK SPACE}\d+)*(?:\.\d+)?"
    r"(?: ?(?:%|°)| (?:µm|mm/h|mm|m|s|min|Hz|ppm/m|ppm|µrad)(?!\w))?)"
)


def numbers_in(words: str) -> str:
    """`98.5 s, 0.771 mm, y2`."""
    return ", ".join(FOUND.findall(words.replace("\N{NARROW NO-BREAK SPACE}", "")))


def templates() -> dict[str, dict[str, object]]:
    """Those of sentences on a recording, by kind and case."""
    path = Path(sentence.__file__).with_name("recording.toml")
    return tomllib.loads(path.read_text(encoding="utf-8"))
