"""A sheet of one recording out of a file alone: which markers, what name, which folder."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

HEADER = ("recording", "path", "markers", "group", "truncated", "comment")
WANTED = 2  # markers: with two there is a distance
LABELS_SHOWN = 60


def name_of(path: str | Path) -> str:
    """A name for a recording as sheets take it: `My file (2).c3d` is `My-file-2`."""
    name = re.sub(r"[^A-Za-z0-9_.-]+", "-", Path(path).stem).strip("-.")
    return name if re.match(r"[A-Za-z0-9]", name) else f"recording-{name}".strip("-_.")


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
    for label in labels:
        if not label.strip() or ";" in label or label.strip().startswith("*"):
            continue  # unlabelled trajectories of some makers begin with a star
        moved = movement(label)
        if moved is not None:
            ranges[label.strip()] = moved
        still = [name for name, value in ranges.items() if value <= limit_mm]
        if len(still) == WANTED:
            return still, "the first two that stand still"
    least = sorted(ranges, key=lambda name: ranges[name])[:WANTED]
    if least and all(ranges[name] <= limit_mm for name in least):
        return least, "all that stand still"
    from mocap_metrology.common.words import three

    moves = ", ".join(f"{name} by {three(ranges[name])} mm" for name in least)
    return least, f"those that move least ({moves}): no two stand still"


def write_sheet(
    folder: Path, path: Path, markers: Sequence[str], accept_truncated: bool = False
) -> str:
    """Write `<folder>/check.tsv`; return the recording's name."""
    cells = (name_of(path), str(path), ";".join(markers), "check")
    cells += ("accept" if accept_truncated else "", "")
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["\t".join(HEADER), "\t".join(cells)]
    (folder / "check.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return cells[0]
