"""Strict readers of tables with names, of First Principles and of N3D."""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence

import numpy as np

from .strict_c3d import Values, need
from .strict_text import counted, lines_of, number, series, unit_mm, whole

NAME = re.compile(r"(\S+)[_ ]([xyz])")


def table(raw: bytes, labels: Sequence[str]) -> Values:
    """`time`, then three columns in mm a label, with commas between; the rate by the times."""
    lines = [line for line in lines_of(raw) if line.strip(" \t,;")]
    names = [cell.strip() for cell in lines[0].split(",")]
    rows = [line.split(",") for line in lines[1:]]
    need(names[0] == "time" and len(rows) > 1)
    every = _labels([name.removesuffix(" [mm]") for name in names[1:]])
    need(all(name.endswith(" [mm]") for name in names[1:]) and len(rows[0]) == len(names))
    return series(rows, labels, every, _rate([number(row[0]) for row in rows]), 1.0, False, True)


def first_principles(raw: bytes, labels: Sequence[str]) -> Values:
    lines = lines_of(raw)
    said = dict(line.split(": ") for line in lines[:3])
    need(lines[4].startswith("Frame\t"))
    every = _labels(lines[4].rstrip("\t").split("\t")[1:])
    rows = [line.split("\t") for line in lines[5:] if line.strip()]
    rows = [["" if _missing(cell) else cell for cell in row] for row in rows]
    rate, mm = number(said.get("Frequency", "")), unit_mm(said.get("Units", ""))
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


def _labels(names: Sequence[str]) -> list[str]:
    """Of three columns each, in order."""
    parts = [NAME.fullmatch(name) for name in names]
    need(len(names) % 3 == 0 and all(parts))
    told = [(part[1], part[2]) for part in parts if part]
    need([axis for _, axis in told] == list("xyz") * (len(names) // 3))
    need(all(told[i][0] == told[i - i % 3][0] for i in range(len(told))))
    return [label for label, _ in told[::3]]


def _rate(times: Sequence[float]) -> float:
    steps = np.diff(times)
    need(np.isfinite(times).all() and (steps > 0).all())
    return float(np.round(steps / np.median(steps)).sum() / (times[-1] - times[0]))


def _missing(cell: str) -> bool:
    return bool(re.fullmatch(r"\s*-3\.697314E\+?0?28\s*", cell, re.I))
