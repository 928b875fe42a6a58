"""S Table 2: data of the three types of cameras. Cited: nothing here can be regenerated."""

from __future__ import annotations

from collections.abc import Sequence

from mocap_metrology.noise.twins.published import published_cameras
from mocap_metrology.present.tables import Row

TYPES = ("T40", "Bonita", "Vantage")
CAPTION = (
    "Cited, as no recording tells a camera's weight. The web version of the article runs the three "
    "columns together (printed_line); ambiguity: none, units separate the values; resolved, only "
    "one split makes sense; open, the most natural split. The CSV has a row a number, in its "
    "column published."
)
SHOWN = ("camera_type", "quantity", "unit", "published", "source", "ambiguity", "note")


def table_2() -> list[Row]:
    """One row a number: the value as printed, its unit, and how sure its reading is."""
    return [
        {
            "camera_type": kind,
            "quantity": line["spec"],
            "unit": line["unit"],
            "published": line[kind],
            "regenerated": None,
            "source": "cited",
            "ambiguity": line["ambiguity"],
            "note": line["note"],
            "printed_line": line["printed_line"],
        }
        for line in published_cameras()
        for kind in TYPES
    ]


def side_by_side(rows: Sequence[Row]) -> list[Row]:
    """The rows of `table_2` to read: one a quantity, what is printed of each type in a column."""
    found: dict[str, Row] = {}
    for row in rows:
        start = {"quantity": row["quantity"], "unit": row["unit"]} | dict.fromkeys(TYPES)
        whole = found.setdefault(row["quantity"], start)
        whole[row["camera_type"]] = row["published"]
        whole |= {name: row[name] for name in ("source", "ambiguity", "note")}
    return list(found.values())
