"""What the summary begins with: one answer on one's own recordings and calibrations."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

from mocap_metrology.present.plot.figure import VERDICT_WORDS
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text.numbers import duration_words
from mocap_metrology.present.verdict.overview import worst_frame

PAPERS = ("skurowski2019", "jansen2019")  # how groups of the papers' own begin
ORDER = list(VERDICT_WORDS)
SHORTER = (  # what a sentence loses in the table
    r" \([^()]*…[^()]*\)",
    r" about the mean of [^;]*",
    r", more than clean [^;]*",
    r"( \([^()]*\))?: its numbers .*(?=\.$)",
    r"; (the distance \S+ is still|still) valid.*(?=\.$)",
    r": (without a distance|nothing is measured there),.*(?=\.$)",
)


def of_paper(group: str) -> bool:
    return group.startswith(PAPERS)


def own(rows: Mapping[str, Sequence[Record]]) -> dict[str, list[Record]]:
    """Rows, by kind, of groups that are not a paper's, or all where there are no others; the worst
    first."""
    every = [row for of in rows.values() for row in of]
    all_of_papers = all(of_paper(row["group"]) for row in every)
    return {
        kind: sorted(
            (row for row in of if all_of_papers or not of_paper(row["group"])),
            key=badness,
            reverse=True,
        )
        for kind, of in rows.items()
    }


def verdict_of(row: Record) -> Record:
    """`word` and `reason` of a recording or of a calibration."""
    found: Record = row["pose"]["verdict"] if "pose" in row else row
    return found


def badness(row: Record) -> tuple[int, float]:
    """Key of an order in which the worst is last."""
    word = verdict_of(row)["word"]
    point = None if "pose" in row else worst_frame(row)
    return ORDER.index(word) if word in ORDER else len(ORDER), point[0] if point else 0.0


def groups(rows: Sequence[Record]) -> list[str]:
    return sorted({row["group"] for row in rows})


def title(rows: Sequence[Record]) -> str:
    """Whose system it is."""
    names = groups(rows)
    return f"Verdict on {', '.join(names)}" if 0 < len(names) <= 3 else "Verdicts"


def answer(kind: str, rows: Sequence[Record], refused: int = 0) -> str:
    """How many of some recordings or calibrations (worst first) are good, how many others were
    refused, which is worst, and why: `5 of 7 recordings are good, 2 usable. The worst is hall-7
    (usable): ...`."""
    counts = Counter(verdict_of(row)["word"] for row in rows)
    worst = verdict_of(rows[0])
    name, why = rows[0][kind], shorter(worst["reason"]).rstrip(".")
    others = [f"{counts[word]} {word}" for word in ORDER if counts[word] and word != "good"]
    others += [f"{refused} refused"] if refused else []
    total = len(rows) + refused
    if total == 1:
        return f"{name} is {worst['word']}: {why}."
    first = ", ".join([f"{counts['good']} of {total} {kind}s are good", *others]) + "."
    if worst["word"] != "good":
        return f"{first} The worst is {name} ({worst['word']}): {why}."
    return first if kind == "calibration" else f"{first} The least precise is {name}: {why}."


def source(rows: Sequence[Record]) -> str:
    """What the rows are, where some are simulated."""
    twins = [row for row in rows if row["source"] == "twin"]
    if not twins:
        return "Source: measured."
    lengths = sorted({row["duration_s"] for row in twins if row.get("duration_s")})
    of = f" of {' to '.join(dict.fromkeys(map(duration_words, (lengths[0], lengths[-1]))))}"
    kinds = [f"{len(twins)} simulated stand-ins (twins{of if lengths else ''})"]
    if len(twins) < len(rows):
        kinds.append(f"{len(rows) - len(twins)} measured")
    return f"Source: {', '.join(kinds)}."


def changes(words: Mapping[str, Sequence[str]], shown: Sequence[str]) -> list[str]:
    """What changed since the recordings that those of some groups are compared with: the sentence
    of one, of several how many became worse or better."""
    found = [sentence for group in shown for sentence in words.get(group, ())]
    if len(found) < 2:
        return found
    worse = sum(": worse " in sentence for sentence in found)
    better = sum("better in " in sentence for sentence in found)
    neither = sum("no significant change" in sentence for sentence in found)
    counts = f"{worse} worse, {better} better, {neither} without a significant change"
    return [f"Of {len(found)} recordings compared with another: {counts}."]


def shorter(sentence: str) -> str:
    """A reason without its interval and its explanation."""
    for pattern in SHORTER:
        sentence = re.sub(pattern, "", sentence, count=1)
    return re.sub(r"^(One frame of \S+) is uncertain by", r"\1:", sentence)
