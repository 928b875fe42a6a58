"""h_0 of every published series: as printed, as S's estimator and the default one give it back."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from mocap_metrology.present.tables import Row

NEAR = 0.05  # what counts as the same white level
BOUNDS = 3.0  # or so many Cramer-Rao bounds, where they are wider
CAPTION = (
    "h_0 in mm²/Hz. expected: S's estimator (annealing-ant-colony, continuous-time formulas) on "
    "the Allan variances that the published model has, without chance; regenerated: "
    "the same on the recording; likelihood: this project's default. Columns in per cent say how "
    "far each is from what it should be: expected and likelihood from the published value (the "
    "latter may be off by likelihood_allowed_percent: 5 %, or three Cramer-Rao bounds), "
    "regenerated from expected. expected differs where components of other kinds take the white "
    "noise's place at hardly more cost and, of point samples, where the formulas do not hold; "
    "regenerated differs from it by chance and by what the 3-sigma filter takes."
)


def white_levels(rows: Sequence[Mapping[str, Any]]) -> list[Row]:
    """One row a published series, from the rows of `appendix.table_a`."""
    made = []
    for row in rows:
        if row["parameter"] != "h_0" or row["published"] is None:
            continue
        published = row["published"]
        relative = row["crlb_relative"]
        allowed = max(NEAR, BOUNDS * relative) if relative is not None else NEAR
        off = _percent(row["likelihood"], published)
        made.append(
            {k: row[k] for k in ("camera_type", "n_cameras", "series", "published", "expected")}
            | {"expected_percent": _percent(row["expected"], published)}
            | {"regenerated": row["regenerated"]}
            | {"regenerated_percent": _percent(row["regenerated"], row["expected"])}
            | {"likelihood": row["likelihood"], "likelihood_percent": off}
            | {"likelihood_allowed_percent": 100 * allowed}
            | {k: row[k] for k in ("source", "recording")}
        )
    return made


def summary(rows: Sequence[Row]) -> str:
    """The counts a reader looks for, in one sentence each."""
    known = [row for row in rows if row["recording"]]
    expected = _count(known, "expected_percent", 100 * NEAR)
    regenerated = _count(known, "regenerated_percent", 100 * NEAR)
    beyond = [
        f"{row['camera_type']}-{row['n_cameras']} {row['series']}"
        for row in known
        if not abs(_number(row["likelihood_percent"])) <= row["likelihood_allowed_percent"]
    ]
    listed = f" ({', '.join(beyond)})" if beyond else ""
    return (
        f"Of {len(known)} series, expected is off by more than 5 % in {expected}, regenerated is "
        f"off from expected by more than 5 % in {regenerated}, and likelihood is off by more than "
        f"5 % and {BOUNDS:g} bounds in {len(beyond)}{listed}."
    )


def _count(rows: Sequence[Row], column: str, limit: float) -> int:
    return sum(not abs(_number(row[column])) <= limit for row in rows)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _percent(value: float | None, reference: float | None) -> float | None:
    if value is None or reference is None or not reference > 0 or math.isnan(value):
        return None
    return 100 * (value / reference - 1)
