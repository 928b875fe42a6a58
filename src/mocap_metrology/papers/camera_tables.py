"""Rows of S Tables 2 and 3: types of cameras, of which nothing can be regenerated, and subsets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mocap_metrology.common.types import Record
from mocap_metrology.noise.twins.published import published_cameras, published_subsets
from mocap_metrology.papers.subsets import TYPES, source_of, standing_for

Row = dict[str, Any]


def table_2() -> list[Row]:
    """One row a number: the value as printed, its unit, and how sure its reading is."""
    return [
        {"camera_type": kind, "quantity": line["spec"], "unit": line["unit"]}
        | {"published": line[kind], "regenerated": None, "source": "cited"}
        | {name: line[name] for name in ("ambiguity", "note", "printed_line")}
        for line in published_cameras()
        for kind in TYPES
    ]


def side_by_side() -> list[Row]:
    """Table 2 to read: one row a quantity, what is printed of each type in a column."""
    return [
        {"quantity": line["spec"], "unit": line["unit"]}
        | {kind: line[kind] for kind in TYPES}
        | {"source": "cited", "ambiguity": line["ambiguity"], "note": line["note"]}
        for line in published_cameras()
    ]


def table_3(recordings: Mapping[str, Record]) -> list[Row]:
    """S Table 3: the cameras of every subset, as published and as in the sheet."""
    rows = []
    for (camera_type, n_cameras), ids in published_subsets().items():
        row = recordings.get(standing_for(recordings, camera_type, n_cameras) or "")
        subset = {"camera_type": camera_type, "n_cameras": n_cameras}
        regenerated = ";".join(map(str, row["camera_ids"])) if row else None
        cells = {"published": ";".join(map(str, ids)), "regenerated": regenerated}
        recording = row["recording"] if row else None
        rows.append(subset | cells | {"source": source_of(row), "recording": recording})
    return rows
