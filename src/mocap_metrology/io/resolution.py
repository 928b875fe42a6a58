"""The smallest step between two coordinates that a file can represent."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mocap_metrology.io.header import number
from mocap_metrology.io.units import largest_of

STEPS_MM = (1, 0.5, 0.1, 0.05, 0.01, 0.005, 0.001, 0.0005, 0.0001)
SAMPLE = 10_000  # values of each coordinate that are tested for rounding
LEAST_SPACINGS = 16  # of float32, of a step of any size
COARSER = 4.0  # of two steps that are nearly alike the decimals are named


@dataclass(frozen=True)
class Resolution:
    """`step_mm`, NaN where no coordinate is valid, and what limits it: `int16`, `float32`,
    `rounded` to multiples of something coarser, or the decimals of a `text`."""

    step_mm: float
    kind: str


def coarsest(resolutions: Sequence[Resolution]) -> Resolution:
    """The largest of some steps; of equal ones the decimals are named, else the first."""
    return max(
        resolutions, key=lambda r: (-1.0 if math.isnan(r.step_mm) else r.step_mm, r.kind == "text")
    )


def float_resolution(position_mm: npt.NDArray[np.floating], mm_per_unit: float) -> Resolution:
    """Resolution of coordinates that a file stores as float32: of an earlier rounding, or else the
    spacing of float32."""
    step = rounding_step_mm(position_mm, mm_per_unit)
    if step is not None:
        return Resolution(step, "rounded")
    return Resolution(float_step_mm(position_mm, mm_per_unit), "float32")


def text_resolution(
    position_mm: npt.NDArray[np.floating],
    mm_per_unit: float,
    written: Sequence[set[str]],
    sample: npt.NDArray[np.float64],
) -> Resolution:
    """Resolution of coordinates that a file writes as text: the coarsest of its possible limits.

    `written`: the cells of the first rows of each coordinate; `sample`: first values in the file's
    unit, of any shape. `text`: 10^-d of the unit, d the most decimals of each coordinate (the
    coordinate with the fewest counting); `rounded`: multiples of something coarser; `float32`: what
    was float32 before it was printed, where that is far coarser than its decimals.
    """
    step = 10.0 ** -_decimals_of_all(written) * mm_per_unit
    rounded = rounding_step_mm(position_mm, mm_per_unit)
    if rounded is not None and rounded > 1.001 * step:
        return Resolution(rounded, "rounded")
    if _was_float32(sample, step / mm_per_unit):
        stored = float_step_mm(position_mm, mm_per_unit)
        if stored > COARSER * step:
            return Resolution(stored, "float32")
    return Resolution(step, "text")


def float_step_mm(position_mm: npt.NDArray[np.floating], mm_per_unit: float) -> float:
    """Largest float32 spacing of the stored coordinates, in mm; `position_mm` may hold NaN.

    NaN where no coordinate is valid.
    """
    return float(np.spacing(np.float32(largest_of(position_mm) / mm_per_unit))) * mm_per_unit


def rounding_step_mm(position_mm: npt.NDArray[np.floating], mm_per_unit: float) -> float | None:
    """The coarsest of `STEPS_MM` that all sampled coordinates are multiples of, else a step of any
    other size (`_lattice_mm`), as that of half floats, or None.

    `position_mm` (n_points, 3, n_frames), NaN where invalid; of each coordinate the first 10,000
    valid values are tested, to within one float32 spacing of the stored number. A step counts as
    found only where chance is ruled out: a value v of arbitrary fraction passes with probability
    2 spacing(v) / step, and the product over all different values must be below 1e-9. That also
    rules out steps close to the spacing, and coordinates that hardly change.
    """
    values = [_first_values(axis) for point in position_mm for axis in point]
    distinct = np.concatenate(values)
    if len(distinct) == 0:
        return None
    tolerance = np.spacing(np.abs(distinct / mm_per_unit).astype(np.float32)) * mm_per_unit
    evidence = np.concatenate([v[1:] for v in values])  # a constant coordinate proves nothing
    chance = np.spacing(np.abs(evidence / mm_per_unit).astype(np.float32)) * mm_per_unit
    for step in STEPS_MM:
        if np.all(np.abs(distinct - step * np.round(distinct / step)) <= tolerance):
            odds = np.log10(np.minimum(1.0, 2 * chance / step)).sum()
            lattice = _lattice_mm(values, mm_per_unit) or 0.0
            return lattice if lattice > 1.5 * step else float(step) if odds < -9 else None
    return _lattice_mm(values, mm_per_unit)


def _lattice_mm(values: Sequence[npt.NDArray[np.float64]], mm_per_unit: float) -> float | None:
    """The least difference of the different, sorted values of each coordinate, if all differences
    are multiples of it, to within the spacing of float32 for each, and chance is ruled out, as
    above; the largest of coordinates that show two. None if any coordinate has no such step."""
    candidates, chance = [], 0.0
    for axis in values:
        steps = np.diff(axis)
        if not steps.size:
            continue
        spacing = float(np.spacing(np.float32(np.abs(axis).max() / mm_per_unit))) * mm_per_unit
        step = float(steps.min())
        if step < LEAST_SPACINGS * spacing:
            return None
        often = np.rint(steps / step)
        tolerance = (often + 1) * spacing
        if np.any(np.abs(steps - often * step) > tolerance):
            return None
        odds = np.log10(np.minimum(1.0, 2 * tolerance / step))
        chance += float(odds.sum() - odds[steps.argmin()])
        if steps.size > 1:
            candidates.append(float(steps.sum() / often.sum()))
    return max(candidates) if chance < -9 else None


def _first_values(series: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
    """Different values among the first `SAMPLE` valid ones, sorted."""
    # Valid frames may start late: skip gaps a piece at a time rather than copy the series.
    taken: list[npt.NDArray[np.floating]] = []
    for start in range(0, len(series), 4 * SAMPLE):
        piece = series[start : start + 4 * SAMPLE]
        taken.append(piece[np.isfinite(piece)])
        if sum(len(t) for t in taken) >= SAMPLE:
            break
    return np.unique(np.concatenate(taken)[:SAMPLE].astype(float))


def _was_float32(sample: npt.NDArray[np.float64], step: float) -> bool:
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


def _decimals_of_all(written: Sequence[set[str]]) -> int:
    """Decimals of the coordinate with the fewest.

    A coordinate that never changes has steps that are too coarse for the noise. It has the
    decimals that it is written with, or those that the file's significant digits would give it.
    """
    significant = max((digits(cell) for cells in written for cell in cells), default=0)
    counts = []
    for cells in written:
        most = max(map(decimals, cells), default=0)
        if len(cells) == 1:
            value = abs(number(next(iter(cells))) or 0.0)
            if value == 0:
                continue
            most = max(most, significant - 1 - math.floor(math.log10(value)))
        if cells:
            counts.append(most)
    widest = max((decimals(cell) for cells in written for cell in cells), default=0)
    return min(counts, default=widest)


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
