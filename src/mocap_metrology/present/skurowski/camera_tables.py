"""S Tables 2 to 4: types of cameras (cited: nothing there can be regenerated), subsets of
cameras, and the Gaussian model, published beside regenerated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mocap_metrology.noise.twins.published import (
    published_cameras,
    published_gaussian,
    published_subsets,
)
from mocap_metrology.present.tables import Record, Row, source_of

TYPES = ("T40", "Bonita", "Vantage")
TABLE_2_CAPTION = (
    "Cited, because no recording contains the weight of a camera. The web version of the article "
    "runs the three columns together (printed_line); ambiguity: none, units separate the values; "
    "resolved, only one split makes sense; open, the most plausible split. The CSV has one row "
    "per number, in its column published."
)


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


# The recording for each row of S Table 4. Its Vantage row agrees with nine cameras;
# the tenth was the failing one, which S 3.5 excludes.
TABLE_4 = {"T40": 10, "Bonita": 10, "Vantage": 9, "All": 30}

TABLE_3_CAPTION = (
    "Ids of the cameras of each subset; Vantage with 10 is deduced, not printed. Nothing is "
    "computed here: the regenerated ids are those of the sheet of recordings (camera_ids). S "
    "reconstructed one recording several times; the twins of a type share noise below 0.1 Hz, "
    "and faster noise is independent."
)

TABLE_4_CAPTION = (
    "Along x, in mm (sigma_12 in mm\u00b2). Vantage is the subset of nine, without the failing "
    "camera. The moments of a twin vary by chance because random walk dominates them, and more "
    "so the longer it is. rho_12 results from the spectra of x1, x2 and L, except in row All: no "
    "coefficients were printed for all thirty cameras, and its twin is T40-10 scaled to this "
    "row, rho_12 included."
)


def standing_for(recordings: Mapping[str, Record], camera_type: str, n_cameras: int) -> str | None:
    """Name of the recording of that subset: a measured one before a twin, then the first."""
    names = [
        name
        for name, row in recordings.items()
        if (row["camera_type"], row["n_cameras"]) == (camera_type, n_cameras)
    ]
    return min(names, key=lambda name: recordings[name]["twin"] is not None, default=None)


def table_3(recordings: Mapping[str, Record]) -> list[Row]:
    """S Table 3: the cameras of every subset, as published and as in the sheet."""
    rows = []
    for (camera_type, n_cameras), ids in published_subsets().items():
        row = recordings.get(standing_for(recordings, camera_type, n_cameras) or "")
        rows.append(
            {
                "camera_type": camera_type,
                "n_cameras": n_cameras,
                "published": ";".join(map(str, ids)),
                "regenerated": ";".join(map(str, row["camera_ids"])) if row else None,
                "source": source_of(row),
                "recording": row["recording"] if row else None,
            }
        )
    return rows


def table_4(
    recordings: Mapping[str, Record], gaussian: Mapping[str, Mapping[str, float]]
) -> list[Row]:
    """S Table 4, long form: every number as published and as regenerated along x.

    gaussian: the row `axis = x` of gaussian.csv, by recording.
    """
    rows = []
    for camera_type, n_cameras in TABLE_4.items():
        name = standing_for(recordings, camera_type, n_cameras)
        found = gaussian.get(name, {}) if name else {}
        for quantity, published in published_gaussian(camera_type).items():
            rows.append(
                {
                    "camera_type": camera_type,
                    "quantity": quantity,
                    "published": published,
                    "regenerated": found.get(quantity),
                    "source": source_of(recordings.get(name or "")),
                    "recording": name,
                }
            )
    return rows
