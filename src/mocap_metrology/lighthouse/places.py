"""Places from CSV files: rows of a table, and labelled places."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mocap_metrology.common import spreadsheet
from mocap_metrology.common.errors import Refusal

COLUMNS = ("label", "x_m", "y_m", "z_m")


def csv_rows(path: str | Path, columns: Sequence[str]) -> list[list[str]]:
    """Cells of a CSV file without its header, which begins with these columns."""
    name, expected = Path(path).name, ",".join(columns)
    try:
        rows = spreadsheet.rows(Path(path).read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise Refusal(f"{name}: cannot be read ({error}); expected a CSV {expected}") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    if header[: len(columns)] != list(columns):
        raise Refusal(f"{name}: header is {','.join(header)!r}; expected {expected}")
    spreadsheet.check_width(rows, name)
    return rows[1:]


def read_places(
    path: str | Path, thing: str, largest_m: float, origin: str
) -> dict[str, np.ndarray]:
    """Label -> position (3,) in m, in file order, from a CSV with the columns label, x_m, y_m, z_m.

    thing: what has a label, in words; largest_m: no coordinate is larger, so that a file in mm is
    noticed; origin: of the frame, in words. Raises `Refusal` for a file that is no such thing.
    """
    name = Path(path).name
    rows = csv_rows(path, COLUMNS)
    places: dict[str, np.ndarray] = {}
    for number, row in enumerate(rows, start=2):
        if not row:
            continue
        label = row[0].strip()
        try:
            position = np.array([spreadsheet.number(cell) for cell in row[1:4]])
        except ValueError:
            position = np.empty(0)
        finite = position.size == 3 and np.isfinite(position).all()
        if not (label and label.isprintable() and finite):
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
