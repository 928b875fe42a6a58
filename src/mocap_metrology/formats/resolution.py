"""The smallest step that a text recording can tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mocap_metrology.c3d.resolution import SAMPLE, float_step_mm, rounding_step_mm
from mocap_metrology.formats.layout import Layout
from mocap_metrology.formats.rows import Rows, cells_of


def text_step_mm(
    layout: Layout, points: Sequence[int], rows: Rows, position_mm: np.ndarray
) -> tuple[float, str]:
    """Smallest step in mm, and its kind: the coarsest of what limits it.

    `text`: 10^-d of the unit, d the most decimals of each coordinate (of its first rows, the
    coordinate with the fewest counting; one that never changes proves nothing); `rounded`:
    multiples of something coarser; `float32`: many decimals of numbers that were float32.
    """
    step, kind = 10.0 ** -_decimals(layout, points, rows) * layout.mm_per_unit, "text"
    rounded = rounding_step_mm(position_mm, layout.mm_per_unit)
    if rounded is not None and rounded > 1.001 * step:
        return rounded, "rounded"
    sample = rows.blocks[0][:, :SAMPLE]
    single = sample.astype(np.float32).astype(np.float64)
    if np.array_equal(single, sample, equal_nan=True):
        stored = float_step_mm(position_mm, layout.mm_per_unit)
        if stored > step:
            return stored, "float32"
    return step, kind


def _decimals(layout: Layout, points: Sequence[int], rows: Rows) -> int:
    table = [cells_of(layout, line) for line in rows.head[:SAMPLE]]
    changing, constant = [], []
    for column in (c for p in points for c in layout.columns[p]):
        cells = {row[column] for row in table if column < len(row)} - {""}
        most = max(map(decimals, cells), default=0)
        (changing if len(cells) > 1 else constant).append(most)
    return min(changing, default=max(constant, default=0))


def decimals(cell: str) -> int:
    """Decimals of a number as written, the exponent included; 0 for anything else."""
    mantissa, _, exponent = cell.lower().replace(",", ".").partition("e")
    fraction = mantissa.partition(".")[2]
    shift = int(exponent) if exponent.lstrip("+-").isdigit() else 0
    return max(len(fraction) - shift, 0) if fraction.isdigit() or shift else 0
