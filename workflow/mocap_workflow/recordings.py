"""config/recordings.tsv: every row checked, and turned into plain values for rules."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from datetime import date, datetime
from typing import Any

from mocap_workflow import files, tsv
from mocap_workflow.faults import Faults, unknown
from mocap_workflow.tsv import Row


def load(
    path: str | None, schema: Mapping[str, Any], twins: Collection[str]
) -> dict[str, dict[str, Any]]:
    """Recordings by name, in the order of the sheet; `Faults` names everything wrong.

    Each has `recording`, `group`, `paths` (none for a twin), `twin` (or None), `markers`, `pairs`
    (lists of two labels), `camera_type`, `n_cameras`, `camera_ids`, `frame_rate_hz`,
    `accept_truncated`, `sha256` (one a file, or none), `date` (ISO text), `compare_with` (name of
    another), `covariate` (path), `place`; these four None where the cell is empty; `cluster`
    (labels) and `comment`.
    """
    if path is None:
        return {}
    rows = tsv.read(path, schema)
    tsv.check_patterns(rows, schema)
    tsv.check_names(rows)
    recordings = {row.name: _recording(row, twins) for row in rows}
    for row in rows:
        _check_comparison(row, recordings)
    faults = [fault for row in rows for fault in row.faults]
    if faults:
        raise Faults(faults)
    return recordings


def _recording(row: Row, twins: Collection[str]) -> dict[str, Any]:
    twin = files.check_twin(row, "path", twins)
    paths = _paths(row) if twin is None else []
    markers = _markers(row, twin)
    n_cameras, camera_ids = _cameras(row)
    return {
        "recording": row["recording"],
        "group": row["group"],
        "paths": paths,
        "twin": twin,
        "markers": markers,
        "pairs": _pairs(row, markers),
        "camera_type": row["camera_type"],
        "n_cameras": n_cameras,
        "camera_ids": camera_ids,
        "frame_rate_hz": _frame_rate(row),
        "accept_truncated": row["truncated"] == "accept",
        "sha256": _sha256(row, paths, twin),
        "date": _date(row),
        "compare_with": row["compare_with"] or None,
        "covariate": files.check_file(row, "covariate", row["covariate"])
        if row["covariate"]
        else None,
        "cluster": _cluster(row, markers),
        "place": row["place"] or None,
        "comment": row["comment"],
    }


def _paths(row: Row) -> list[str]:
    if "path" in row.wrong:
        return []
    parts = tsv.check_listed(row, "path", 'files separated by ";"')
    if "path" in row.wrong:
        return []
    if any(part.startswith(files.SIMULATE) for part in parts):
        row.blame("path", f"files, or {files.SIMULATE}<twin> by itself")
        return []
    # A folder is one refused recording; the others are computed all the same
    return [files.check_file(row, "path", part, any_kind=True) for part in parts]


def _markers(row: Row, twin: str | None) -> list[str]:
    markers = tsv.check_listed(row, "markers", 'labels of the markers, separated by ";"')
    if not markers and twin is None:
        row.blame("markers", 'the labels of one or more markers of the file, separated by ";"')
    return markers


def _cameras(row: Row) -> tuple[int | None, list[int]]:
    wrong = row.wrong & {"n_cameras", "camera_ids"}
    n_cameras = int(row["n_cameras"]) if row["n_cameras"] and "n_cameras" not in wrong else None
    if "camera_ids" in wrong:
        return n_cameras, []
    camera_ids = [int(part) for part in row.parts("camera_ids")]
    if len(set(camera_ids)) < len(camera_ids):
        row.blame("camera_ids", "each camera once")
    elif camera_ids and n_cameras is not None and len(camera_ids) != n_cameras:
        row.blame("camera_ids", f"as many as column n_cameras says ({n_cameras})")
    if camera_ids and not row["n_cameras"]:
        n_cameras = len(camera_ids)
    return n_cameras, camera_ids


def _pairs(row: Row, markers: list[str]) -> list[list[str]]:
    """The chosen pairs, else the first two markers. A label may itself hold a `-`."""
    if not row["pairs"] or "markers" in row.wrong:
        return [markers[:2]] if len(markers) > 1 else []
    pairs = []
    for text in row.parts("pairs"):
        cuts = [index for index, letter in enumerate(text) if letter == "-"]
        splits = [[text[:cut].strip(), text[cut + 1 :].strip()] for cut in cuts]
        splits = [pair for pair in splits if set(pair) <= set(markers)]
        if not splits:
            named = ", ".join(markers) or "none: column markers is empty"
            row.blame("pairs", f'two of the chosen markers ({named}) joined by "-"', text)
        elif len(splits) > 1:
            ways = " or ".join(" and ".join(pair) for pair in splits)
            row.blame("pairs", f"one way to read it, not several ({ways})", text)
        elif splits[0][0] == splits[0][1]:
            row.blame("pairs", "two different markers", text)
        elif splits[0] in pairs or splits[0][::-1] in pairs:
            row.blame("pairs", "each pair once", text)
        else:
            pairs += splits
    return pairs


def _cluster(row: Row, markers: list[str]) -> list[str]:
    """Markers of one rigid body, whose orientation is analysed."""
    cluster = tsv.check_listed(row, "cluster", 'labels of markers, separated by ";"')
    if "markers" in row.wrong or "cluster" in row.wrong or not cluster:
        return []
    if len(cluster) < 3 or not set(cluster) <= set(markers):
        named = ", ".join(markers) or "none: column markers is empty"
        row.blame("cluster", f"three or more of the chosen markers ({named})")
    return cluster


def _frame_rate(row: Row) -> float | None:
    if not row["frame_rate_hz"] or "frame_rate_hz" in row.wrong:
        return None
    rate = float(row["frame_rate_hz"])
    if not 0 < rate < 1e6:
        row.blame("frame_rate_hz", "a number of Hz > 0 and < 1,000,000, or nothing")
    return rate


def _sha256(row: Row, paths: list[str], twin: str | None) -> list[str]:
    sums = [part.lower() for part in row.parts("sha256")]
    if {"sha256", "path"} & row.wrong:
        return []
    if sums and twin is not None:
        row.blame("sha256", "nothing for a simulated recording")
    elif sums and len(sums) != len(paths):
        row.blame("sha256", f"one for each file of column path ({len(paths)})")
    return sums


def _date(row: Row) -> str | None:
    """As ISO 8601 has it; the schema's pattern leaves to be seen that there is such a day."""
    text = row["date"].replace(" ", "T")
    if not text or "date" in row.wrong:
        return None
    try:
        return (datetime if "T" in text else date).fromisoformat(text).isoformat()
    except ValueError as error:
        row.blame("date", f"a day and time that exist ({error})")
        return None


def _check_comparison(row: Row, names: Collection[str]) -> None:
    other = row["compare_with"]
    if other and other == row.name:
        row.blame("compare_with", "another recording than this one")
    elif other and other not in names:
        row.blame("compare_with", f"a recording of the sheet ({unknown(other, names)})")
