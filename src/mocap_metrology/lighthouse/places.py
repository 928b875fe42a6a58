"""Labelled places from a CSV file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mocap_metrology.common import spreadsheet
from mocap_metrology.common.errors import Refusal

COLUMNS = ("label", "x_m", "y_m", "z_m")


def read_places(
    path: str | Path, thing: str, largest_m: float, origin: str
) -> dict[str, np.ndarray]:
    """Label -> position (3,) in m, in file order, from a CSV with the columns label, x_m, y_m, z_m.

    thing: what has a label, in words; largest_m: no coordinate is larger, so that a file in mm is
    noticed; origin: of the frame, in words. Raises `Refusal` for a file that is no such thing.
    """
    name = Path(path).name
    try:
        rows = spreadsheet.rows(Path(path).read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise Refusal(f"{name}: cannot be read ({error}); expected label,x_m,y_m,z_m") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    if header[:4] != list(COLUMNS):
        raise Refusal(f"{name}: header is {','.join(header)!r}; expected label,x_m,y_m,z_m")
    spreadsheet.check_width(rows, name)
    places: dict[str, np.ndarray] = {}
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        label = row[0].strip()
        try:
            position = np.array([spreadsheet.number(cell) for cell in row[1:4]])
        except ValueError:
            position = np.empty(0)
        if (
            not label
            or not label.isprintable()
            or position.size != 3
            or not np.isfinite(position).all()
        ):
            raise Refusal(f"{name}: line {number} is {','.join(row)!r}; expected label,x_m,y_m,z_m")
        if label in places:
            raise Refusal(f"{name}: label {label} occurs twice; expected one line per {thing}")
        if np.abs(position).max() > largest_m:
            raise Refusal(
                f"{name}: {thing} {label} is {np.abs(position).max():g} m from {origin};"
                f" expected metres, below {largest_m:g} m (is the file in mm?)"
            )
        places[label] = position
    if len(places) < 3:
        raise Refusal(f"{name}: {len(places)} {thing}s; a pose needs at least three")
    return places


def narrowness_m(places: np.ndarray) -> float:
    """How far places (n, 3) spread off the line nearest to them: root of the sum of squares, m."""
    return float(np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[1])
