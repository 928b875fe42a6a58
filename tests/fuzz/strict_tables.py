"""Strict readers of tables with names, of First Principles and of N3D."""

import re
import struct
from collections.abc import Sequence

import numpy as np

from .strict_c3d import Values, need
from .strict_text import counted, lines_of, need_end, number, series, unit_mm, whole

NAME = re.compile(r"(\S+)[_ ]([xyz])")


def table(raw: bytes, labels: Sequence[str]) -> Values:
    """`time`, then three columns in mm a label, with commas between; the rate by the times."""
    lines = [line for line in lines_of(raw) if line.strip(" \t,")]
    names = [cell.strip() for cell in lines[0].split(",")]
    rows = [line.split(",") for line in lines[1:]]
    need(names[0] == "time" and len(rows) > 1 and len(rows[0]) == len(names))
    every, rows = _in_order([name.removesuffix(" [mm]") for name in names[1:]], rows)
    need(all(name.endswith(" [mm]") for name in names[1:]))
    return series(rows, labels, every, _rate([number(row[0]) for row in rows]), 1.0, False, True)


def first_principles(raw: bytes, labels: Sequence[str]) -> Values:
    lines = lines_of(raw)
    head = next(k for k, line in enumerate(lines) if line.startswith("Frame\t"))
    said = dict(line.split(": ") for line in lines[:head] if line.strip())
    need(head <= 20)
    rows = [line.split("\t") for line in lines[head + 1 :] if line.strip()]
    need_end(lines, rows)
    every, rows = _in_order(lines[head].rstrip("\t").split("\t")[1:], rows)
    rows = [["" if _missing(cell) else cell for cell in row] for row in rows]
    rate, mm = (
        number(said.get("Frequency", "").replace(",", ".", 1)),
        unit_mm(said.get("Units", "")),
    )
    found = series(rows, labels, every, rate, mm, True, False)
    return counted(found, len(rows), whole(said["Number of frames"]))


def n3d(raw: bytes, labels: Sequence[str]) -> Values:
    mark, k, numbers, n, rate = struct.unpack("<Bhhif", raw[:13])
    need(mark == 32 and k > 0 and numbers == 3 and n > 1 and 0 < rate < 1e6)
    need(len(raw) == 256 + 12 * k * n)
    stored = np.frombuffer(raw, "<f4", offset=256).reshape(n, k, 3).astype(float)
    gone = (stored < -3e28).any(axis=2) | (stored == 0).all(axis=2)
    stored[gone | ~np.isfinite(stored).all(axis=2)] = np.nan
    places = [int(label.removeprefix("Marker_")) - 1 for label in labels]
    need(max(places) < k)
    found = stored[:, places].transpose(1, 2, 0)
    need(np.isfinite(found).all(axis=1).any(axis=1).all())
    return {"position_mm": found, "rate": rate, "unit_assumed": False}


def _in_order(
    names: Sequence[str], rows: Sequence[Sequence[str]]
) -> tuple[list[str], list[list[str]]]:
    """Labels, and the rows with x, y, z of each label side by side after their first cell."""
    parts = [NAME.fullmatch(name) for name in names]
    need(all(parts))
    told = [(part[1], part[2]) for part in parts if part]
    labels = list(dict.fromkeys(label for label, _ in told))
    order = [(label, axis) for label in labels for axis in "xyz"]
    need(sorted(told) == sorted(order))
    need(all(len(row) < len(names) + 100 for row in rows))
    full = [[*row, *[""] * len(names)] for row in rows]
    need(all(not any(cell.strip() for cell in row[len(names) + 1 :]) for row in rows))
    return labels, [[row[0], *(row[1 + told.index(one)] for one in order)] for row in full]


def _rate(times: Sequence[float]) -> float:
    steps = np.diff(times)
    need(np.isfinite(times).all() and (steps > 0).all())
    rate = np.round(steps / np.median(steps)).sum() / (times[-1] - times[0])
    return float(f"{rate:.6g}")


def _missing(cell: str) -> bool:
    return bool(re.fullmatch(r"\s*-3\.697314E\+?0?28\s*", cell, re.I))
