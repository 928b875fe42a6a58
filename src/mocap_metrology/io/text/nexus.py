"""Vicon Nexus and Tracker CSV: one section of an ASCII export, Trajectories if it is there.

Layout as Nexus 2 writes it: sections follow each other, each a line with its name, a line with
its rate in Hz, a line with names over their first column, `Frame, Sub Frame, X, Y, Z, ...`, a
line of units, numbers, an empty line. Labels are `subject:marker`, in quotes if there is a comma in
one; an empty cell is a gap. Bodies, which Tracker writes in Objects and Nexus in Segments, have the
columns `RX, RY, RZ, TX, TY, TZ`; their angles, helical or Euler as was set, are not read.
"""

from __future__ import annotations

import itertools
import mmap
import re
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.text.layout import (
    BODY,
    Layout,
    Line,
    Triple,
    lines,
    named,
    quoted_cells,
    rate,
    triples,
)
from mocap_metrology.io.units import read_unit

WHAT = "a Vicon Nexus export (CSV)"
MARKERS = "Trajectories"
OF_BODIES = ["RX", "RY", "RZ", "TX", "TY", "TZ"]
POSITIONS = {MARKERS: ["X", "Y", "Z"], "Objects": OF_BODIES, "Segments": OF_BODIES}  # first found
OTHERS = ("Devices", "Model Outputs", "Joints", "Events", "Force Plates")
OLD_SECTION = "TRAJECTORIES"
OLD_RATE = re.compile(r"\s*[0-9.]+[\s,;]*Hz", re.I)
INNER = re.compile("[YZ]'*|R[YZ]|T[XYZ]")  # titles of columns over which no label stands


def section(path: Path, title: str, start: int = 0) -> tuple[int, int] | None:
    """Byte and number (from 1) of the line `title` from byte `start` on; None where there is
    none."""
    name = title.encode()
    with (
        path.open("rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        at = content.find(name, start)
        while at >= 0:
            front, end = content[max(at - 4, 0) : at], content.find(b"\n", at)
            rest = content[at + len(name) : end if end >= 0 else len(content)]
            alone = front[-1:] in (b"\n", b'"') or at == 0 or (at == 3 and front[0] > 127)
            if alone and not rest.strip(b'\r,;\t "'):
                line_feeds = sum(
                    content[i : min(i + 2**24, at)].count(b"\n") for i in range(0, at, 2**24)
                )
                return at, line_feeds + 1
            at = content.find(name, at + 1)
    return None


def find_section(path: Path) -> tuple[str, tuple[int, int] | None]:
    """Title and place of the section that is read; `Trajectories` where there is none."""
    sections = ((title, section(path, title)) for title in POSITIONS)
    return next((one for one in sections if one[1]), (MARKERS, None))


def refuse_old(path: Path) -> None:
    """Refuse, by its name, what Vicon Workstation and iQ wrote: `TRAJECTORIES` alone on a line, the
    rate as `120.000000,Hz`, names under `Field #`."""
    place = section(path, OLD_SECTION)
    head = list(itertools.islice(lines(path, *place), 2)) if place else []
    if len(head) == 2 and OLD_RATE.match(head[1].text):
        raise Refusal(
            f"{path.name}: is an old Vicon ASCII export (Workstation or iQ, section"
            f" {OLD_SECTION}), which is not read: export C3D, or CSV from Nexus 2"
        )


def _rate(line: Line, delimiter: str, name: str) -> float:
    """The frame rate in Hz; it stands alone on its line, else a decimal comma would cut it."""
    first, *others = quoted_cells(line.text, delimiter) or [""]
    if any(cell.strip() for cell in others) or (delimiter == "," and "," in first):
        where = f"{name}: line {line.number} is {line.text.strip()!r}"
        raise Refusal(f"{where}; expected the frame rate in Hz alone")
    return rate(first, name)


def layout(path: Path) -> Layout:
    """Read the head of the section of markers, else of bodies; refuses what has none or contradicts
    itself."""
    title, place = find_section(path)
    if place is None:
        raise Refusal(f"{path.name}: is not {WHAT} of markers: it has no section {title}")
    if again := section(path, title, place[0] + 1):
        raise Refusal(f"{path.name}: line {again[1]} begins another section {title}")
    head = list(itertools.islice(lines(path, *place), 6))
    if len(head) < 5:
        raise Refusal(f"{path.name}: cut off: within the head of the section {title}")
    delimiter = _delimiter(head[3], path.name)
    axes, names, units = (quoted_cells(head[i].text, delimiter) for i in (3, 2, 4))
    _check_names(names, axes, f"{path.name}: line {head[2].number}")
    wanted = POSITIONS[title]
    columns, labels = _positions(axes, names, wanted, f"{path.name}: line {head[3].number}")
    if not labels:
        raise Refusal(f"{path.name}: line {head[3].number} has no columns {', '.join(wanted)}")
    if len(head) < 6 or not head[5].text.strip(f"{delimiter} "):
        raise Refusal(f"{path.name}: has no frames: nothing follows the head of {title}")
    listed = [units[i] for three in columns for i in three if i < len(units)]
    return Layout(
        path=path,
        encoding="Nexus text",
        labels=labels,
        columns=columns,
        frame_rate_hz=_rate(head[1], delimiter, path.name),
        unit=read_unit(listed, f"unit of {title}", path.name),
        delimiter=delimiter,
        first=head[5],
        n_columns=len(axes) if axes[-1] else len(axes) - 1,
        frame_column=0,
        ends_blank=True,
        remarks={} if title == MARKERS else dict.fromkeys(range(len(labels)), BODY),
    )


def _delimiter(line: Line, file: str) -> str:
    """What follows `Frame`: a comma, or a semicolon where the system's language asks for it."""
    text = line.text.replace('"', "").lstrip()
    if not text.startswith("Frame") or text[5:6] not in (",", ";", "\t"):
        raise Refusal(
            f"{file}: line {line.number} is {text[:30]!r}, expected Frame, Sub Frame, X, Y, Z ..."
        )
    return text[5]


def _check_names(names: list[str], axes: list[str], where: str) -> None:
    """Refuse labels that a delimiter inside one of them moved off their columns."""
    for i, name in enumerate(names):
        title = axes[i] if i < len(axes) else ""
        if name and (not title or INNER.fullmatch(title)):
            over = f"over {title}" if title else "over no column"
            raise Refusal(
                f"{where}: {name[:40]!r} in cell {i + 1} stands {over}, expected labels over X:"
                " a label with a comma must be in quotes"
            )


def _positions(
    axes: list[str], names: list[str], wanted: list[str], where: str
) -> tuple[tuple[Triple, ...], tuple[str, ...]]:
    """Columns and labels of positions: velocities (X') and counts have other titles. The label of a
    body stands over its first angle, as `Global Angle drone:drone` in Tracker."""
    n = len(wanted)
    starts = [i for i in range(2, len(axes) - n + 1) if axes[i : i + n] == wanted]
    taken = {i + k for i in starts for k in range(n)}
    for i, title in enumerate(axes):
        if title in wanted and i not in taken:
            what = f"column {i + 1} is {title}, not in a row of {', '.join(wanted)}"
            raise Refusal(f"{where}: {what}; export again, or correct the titles")
    padded = [*names, *[""] * len(axes)]
    labels = [padded[i].removeprefix("Global Angle ") for i in starts]
    return triples(i + n - 3 for i in starts), named(labels)
