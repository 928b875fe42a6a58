"""config/calibrations.tsv: every row checked, and turned into plain values for rules."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import PurePath
from typing import Any

from mocap_workflow import files, tsv
from mocap_workflow.faults import Faults
from mocap_workflow.tsv import Row

LABELS = ("reference_labels_master", "reference_labels_slave")


def load(
    path: str | None, schema: Mapping[str, Any], twins: Collection[str]
) -> dict[str, dict[str, Any]]:
    """Calibrations by name, in the order of the sheet; `Faults` names everything wrong.

    Each has every column of the sheet, and `twin` (or None); `path` is None for a twin; file
    names are seen from the working folder; an empty cell is None, labels are lists.
    """
    if path is None:
        return {}
    rows = tsv.read(path, schema)
    tsv.check_patterns(rows, schema)
    tsv.check_names(rows)
    calibrations = {row.name: _calibration(row, twins) for row in rows}
    faults = [fault for row in rows for fault in row.faults]
    if faults:
        raise Faults(faults)
    return calibrations


def _calibration(row: Row, twins: Collection[str]) -> dict[str, Any]:
    twin = files.check_twin(row, "path", twins)
    file = row["path"] if twin is None and "path" not in row.wrong else ""
    master, slave = _labels(row)
    sha256 = row["sha256"].lower() or None
    if sha256 and twin is not None:
        row.blame("sha256", "nothing for a simulated calibration")
    return {
        "calibration": row["calibration"],
        "setup": row["setup"],
        "group": row["group"],
        "path": files.check_file(row, "path", file) if file else None,
        "twin": twin,
        "format": row["format"],
        "board": _board(row, twin),
        "factory": _file(row, "factory"),
        "reference": _file(row, "reference"),
        "reference_labels_master": master,
        "reference_labels_slave": slave,
        "mount": _file(row, "mount"),
        "check_against": _file(row, "check_against"),
        "sha256": sha256,
        "comment": row["comment"],
    }


def _file(row: Row, column: str) -> str | None:
    return files.check_file(row, column, row[column]) if row[column] else None


def _board(row: Row, twin: str | None) -> str | None:
    """A CSV of diodes, or for a libsurvive recording the name of the tracked object in it."""
    if row["format"] == "libsurvive-rec":
        if not row["board"] and twin is None:
            row.blame("board", "the name of the tracked object in the recording")
        return row["board"] or None
    if not row["board"] and twin is None:
        row.blame("board", "a CSV file x_m,y_m,z_m in diode order")
    return _file(row, "board")


def _labels(row: Row) -> tuple[list[str], list[str]]:
    """Labels of both housings; a C3D reference needs them, no other has a use for them."""
    wanted = PurePath(row["reference"]).suffix.lower() == ".c3d"
    for column in LABELS:
        if wanted and not row[column]:
            row.blame(column, 'labels separated by ";", as the reference is a C3D file')
        elif row[column] and not wanted:
            row.blame(column, "nothing, as the reference is no C3D file")
    master, slave = (tsv.check_listed(row, c, 'labels separated by ";"') for c in LABELS)
    return master, slave
