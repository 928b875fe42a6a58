"""The smallest step that a text recording can tell."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mocap_metrology.io.c3d.resolution import SAMPLE, float_step_mm, rounding_step_mm
from mocap_metrology.io.text.layout import Layout, number
from mocap_metrology.io.text.rows import NULLS, Rows, cells_of

COARSER = 4.0  # of two steps that are nearly alike the decimals are named


def text_step_mm(
    layout: Layout, points: Sequence[int], rows: Rows, position_mm: np.ndarray
) -> tuple[float, str]:
    """Smallest step in mm, and its kind: the coarsest of what limits it.

    `text`: 10^-d of the unit, d the most decimals of each coordinate (of its first rows, the
    coordinate with the fewest counting); `rounded`: multiples of something coarser; `float32`: what
    was float32 before it was printed, where that is far coarser than its decimals.

    A coordinate that never changes says that its steps are too coarse for the noise. It has the
    decimals that it is written with, or those that the file's significant digits would give it.
    """
    step, kind = 10.0 ** -_decimals(layout, points, rows) * layout.mm_per_unit, "text"
    rounded = rounding_step_mm(position_mm, layout.mm_per_unit)
    if rounded is not None and rounded > 1.001 * step:
        return rounded, "rounded"
    sample = rows.blocks[0][:, :SAMPLE]
    if _was_single(sample, step / layout.mm_per_unit):
        stored = float_step_mm(position_mm, layout.mm_per_unit)
        if stored > COARSER * step:
            return stored, "float32"
    return step, kind


def _was_single(sample: np.ndarray, step: float) -> bool:
    """Whether numbers with steps of `step` are float32, printed; chance is ruled out to 1e-9.

    A float32 near v is a multiple of its spacing s(v), and printing it moves it by half a step. Any
    other number comes so near to one with probability step / s(v).
    """
    values = np.unique(sample[np.isfinite(sample) & (sample != 0)])
    spacing = np.spacing(np.abs(values).astype(np.float32)).astype(float)
    telling = spacing > step
    off = np.abs(values - values.astype(np.float32).astype(float))
    odds = np.log10(step / spacing[telling]).sum()
    return bool(odds < -9 and (off <= 0.501 * step)[telling].all())


def _decimals(layout: Layout, points: Sequence[int], rows: Rows) -> int:
    table = [cells_of(layout, line) for line in rows.head[:SAMPLE]]
    columns = [c for p in points for c in layout.columns[p]]
    written = [{row[c] for row in table if c < len(row)} - set(NULLS) for c in columns]
    significant = max((digits(cell) for cells in written for cell in cells), default=0)
    found = []
    for cells in written:
        most = max(map(decimals, cells), default=0)
        if len(cells) == 1:
            value = abs(number(next(iter(cells))) or 0.0)
            if value == 0:
                continue
            most = max(most, significant - 1 - math.floor(math.log10(value)))
        if cells:
            found.append(most)
    widest = max((decimals(cell) for cells in written for cell in cells), default=0)
    return min(found, default=widest)


def digits(cell: str) -> int:
    """Significant digits of a number as written."""
    mantissa = cell.lower().partition("e")[0]
    return len("".join(c for c in mantissa if c.isdigit()).lstrip("0"))


def decimals(cell: str) -> int:
    """Decimals of a number as written, the exponent included; 0 for anything else."""
    mantissa, _, exponent = cell.lower().replace(",", ".").partition("e")
    fraction = mantissa.partition(".")[2]
    shift = int(exponent) if exponent.lstrip("+-").isdigit() else 0
    return max(len(fraction) - shift, 0) if fraction.isdigit() or shift else 0
