"""Calibrations in the summary: one row each, or one row a setup where there are many."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.lighthouse.published import QUANTITIES
from mocap_metrology.lighthouse.rotation import from_angles, log, mean, to_angles
from mocap_metrology.present.calibration.tables import calibration_rows
from mocap_metrology.present.numbers import three_digits
from mocap_metrology.present.pages.html_page import EMPTY, WORDS, link, paragraph, table, word

Row = Mapping[str, Any]

MM = ("x_mm", "y_mm", "z_mm")
DEG = ("rx_deg", "ry_deg", "rz_deg")  # of a vector in master axes
MANY = 20  # calibrations of a group beyond which a row is a setup
POSE = ("x (mm)", "y (mm)", "z (mm)", "α (°)", "β (°)", "γ (°)")
HEAD = ("calibration", "verdict", *POSE, "σ (mm)", "σ (°)", "why")
SETUP_HEAD = (
    *("setup", "calibrations", "verdicts", *POSE, "scatter (mm)", "scatter (°)"),
    "not right (in so many)",
)
NOTE = (
    "x, y, z and α, β, γ: translation and rotation of the slave in the master's frame. σ: one "
    "standard deviation as the estimator states it, largest of three axes."
)
UNDRAWN = (
    "A name without a link has no figure: of the twins of a setup, which look alike, only the "
    "first is drawn."
)
SETUP_NOTE = (
    "A row is a setup, of which every calibration repeats the same poses of the stations. x, y, "
    "z and α, β, γ: mean translation and rotation of the slave in the master's frame; scatter: "
    "standard deviation (n - 1) among the calibrations, largest of three axes."
)


def calibrations(rows: Sequence[Row], address: Callable[[str], str]) -> list[str]:
    """Table of the calibrations of a group and a note, as HTML.

    rows: `calibration`, `setup`, `source`, `pose` (contents of pose.json); address: of a name.
    """
    if len(rows) > MANY:
        setups = dict.fromkeys(row["setup"] for row in rows)
        cells = [setup_row(name, [r for r in rows if r["setup"] == name]) for name in setups]
        return [table(SETUP_HEAD, cells, html=(2,), long=(11,)), paragraph(SETUP_NOTE)]
    cells = [_row(row, flat, address) for row, flat in _flat(rows)]
    drawn = [bool(address(row["calibration"])) for row in rows]
    note = NOTE if all(drawn) or not any(drawn) else f"{NOTE} {UNDRAWN}"
    return [table(HEAD, cells, html=(0, 1), long=(10,)), paragraph(note)]


def _flat(rows: Sequence[Row]) -> list[tuple[Row, Row]]:
    return list(zip(rows, calibration_rows(rows), strict=True))


def _row(row: Row, flat: Row, address: Callable[[str], str]) -> list[Any]:
    name = row["calibration"]
    sigma = [max(flat[f"sigma_{axis}"] for axis in axes) for axes in (MM, DEG)]
    return [
        link(address(name), name),
        word(flat["verdict"]),
        *_pose([flat[quantity] for quantity in QUANTITIES]),
        *(three_digits(value) or EMPTY for value in sigma),
        flat["reason"],
    ]


def _pose(values: Sequence[float]) -> list[str]:
    if np.isnan(values).any():
        return [EMPTY] * 6
    return [f"{v:.{digits}f}" for v, digits in zip(values, (1, 1, 1, 3, 3, 3), strict=True)]


def setup_row(name: str, rows: Sequence[Row]) -> list[Any]:
    """Cells of a setup: how many of each verdict, mean pose, scatter, and what was not right."""
    flat = calibration_rows(rows)
    words = Counter(row["verdict"] for row in flat)
    shown = [word(w, words[w]) for w in dict.fromkeys((*WORDS, *words)) if words[w]]
    wrong = Counter(
        check["name"] for row in rows for check in row["pose"]["checks"] if check["ok"] is False
    )
    values = np.array([[row[quantity] for quantity in QUANTITIES] for row in flat])
    values = values[~np.isnan(values).any(axis=1)]
    centre, mm, deg = spread(values)
    return [
        name,
        len(rows),
        " ".join(shown),
        *_pose(centre),
        *(three_digits(value) or EMPTY for value in (mm, deg)),
        ", ".join(f"{what} ({count})" for what, count in wrong.most_common()) or EMPTY,
    ]


def spread(values: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Mean pose of rows x, y, z in mm and alpha, beta, gamma in deg, and the largest standard
    deviations (n - 1) of a translation's component and of a rotation vector's, NaN for one row."""
    if not len(values):
        return np.full(6, np.nan), np.nan, np.nan
    turns = np.array([from_angles(*np.radians(row[3:])) for row in values])
    centre = mean(turns)
    pose = np.concatenate([values[:, :3].mean(axis=0), np.degrees(to_angles(centre))])
    if len(values) < 2:
        return pose, np.nan, np.nan
    vectors = np.degrees([log(turn @ centre.T) for turn in turns])
    return pose, *(float(v.std(axis=0, ddof=1).max()) for v in (values[:, :3], vectors))
