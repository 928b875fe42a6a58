"""S Table 2: data of the three types of cameras. Cited: nothing here can be regenerated."""

from __future__ import annotations

from mocap_metrology.noise.published import published_cameras
from mocap_metrology.present.tables import Row

TYPES = ("T40", "Bonita", "Vantage")
CAPTION = (
    "Cited, as no recording tells a camera's weight. The web version of the article runs the three "
    "columns together (printed_line); ambiguity: none, units separate the values; resolved, only "
    "one split makes sense; open, the most natural split."
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
