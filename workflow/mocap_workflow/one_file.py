"""A sheet of one recording out of a file alone: which markers, what name, which folder."""

from __future__ import annotations

import csv
import hashlib
import io
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

LONGEST = 60  # letters of a name
REPEATED = re.compile(r"(.+?)\1{9,}")  # which Snakemake takes for a loop of rules
WANTED = 2  # markers: with two there is a distance
LABELS_SHOWN = 60


def name_of(path: str | Path) -> str:
    """A name for a recording as sheets take it: `My file (2).c3d` is `My-file-2`. What is too long,
    or has no letter or digit of ASCII, is told apart by a hash."""
    stem = Path(path).stem
    name = re.sub(r"[^A-Za-z0-9_.-]+", "-", stem).strip("-.")
    digest = hashlib.sha256(stem.encode("utf-8", "surrogateescape")).hexdigest()[:6]
    if not re.search(r"[A-Za-z0-9]", name):
        return f"recording-{digest}"
    if len(name) > LONGEST or REPEATED.search(name):
        name = f"{name[:12].rstrip('-._')}-{digest}"
    return name if re.match(r"[A-Za-z0-9]", name) else f"recording-{name}".rstrip("-_.")


def folder_of(path: str | Path) -> str:
    """Folder of its results: the name and the suffix, `take.c3d` beside `take.trc`."""
    return name_of(path) + Path(path).suffix.lower()


def numbered(labels: Sequence[str]) -> list[str]:
    """Labels as markers are chosen by, in order: one that stands twice is `A#1` and `A#2`."""
    stripped = [label.strip() for label in labels]
    counts: dict[str, int] = {}
    found = []
    for label in stripped:
        counts[label] = counts.get(label, 0) + 1
        found.append(f"{label}#{counts[label]}" if stripped.count(label) > 1 else label)
    return found


def listed(labels: Sequence[str]) -> str:
    """Labels for a message, not all of very many."""
    shown = [label.strip() for label in labels if label.strip()]
    more = len(shown) - LABELS_SHOWN
    return ", ".join(shown[:LABELS_SHOWN]) + (f" and {more} more" if more > 0 else "")


def choose(
    labels: Sequence[str], movement: Callable[[str], float | None], limit_mm: float
) -> tuple[list[str], str]:
    """Markers to judge by, and why these.

    The first two in the file that stand still: choosing the quietest would flatter the system.
    Where fewer do, the two that move least. movement: range in mm of a marker's one-second means,
    None if it is hardly seen; asked only until two are found.
    """
    ranges: dict[str, float] = {}
    for label in numbered(labels):
        if not label.split("#")[0] or ";" in label or label.startswith("*"):
            continue  # unlabelled trajectories of some makers begin with a star
        moved = movement(label)
        if moved is not None:
            ranges[label] = moved
        still = [name for name, value in ranges.items() if value <= limit_mm]
        if len(still) == WANTED:
            return still, "the first two that stand still"
    least = sorted(ranges, key=lambda name: ranges[name])[:WANTED]
    if least and all(ranges[name] <= limit_mm for name in least):
        return least, "all that stand still"
    from mocap_metrology.present.text.numbers import three

    moves = ", ".join(f"{name} by {three(ranges[name])} mm" for name in least)
    return least, f"those that move least ({moves}): no two stand still"


def write_sheet(folder: Path, path: Path, cells: Mapping[str, str | None]) -> str:
    """Write `<folder>/check.tsv`, if it is not that already; return the recording's name."""
    name = name_of(path)
    row = {"recording": name, "path": str(path), "group": "check", **cells}
    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n")
    writer.writerow(row)
    writer.writerow([value or "" for value in row.values()])
    sheet = folder / "check.tsv"
    folder.mkdir(parents=True, exist_ok=True)
    if not sheet.is_file() or sheet.read_text(encoding="utf-8") != text.getvalue():
        sheet.write_text(text.getvalue(), encoding="utf-8")
    return name
