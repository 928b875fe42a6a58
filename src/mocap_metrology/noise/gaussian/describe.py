"""What the simple statistics say of a recording: rows of gaussian.csv, warnings of movement."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from mocap_metrology.common.words import three
from mocap_metrology.noise.gaussian.series import AXES, pair_name, position
from mocap_metrology.noise.gaussian.two_markers import (
    ChiSquared,
    Drift,
    GaussianModel,
    along_pair,
    chi_squared_normal,
    drift,
    gaussian_model,
    gaussian_sample,
)
from mocap_metrology.noise.motion.movement import Movement, movement

FAST_MM_H = 10_000.0
MOST_NAMED = 6
LONG_S = 60.0  # a recording from which a drift per hour is told of


def moving_markers(
    positions: Mapping[str, np.ndarray],
    frame_rate_hz: float,
    range_mm: float,
    horizon_s: float,
    step_mm: float = 0.0,
) -> list[str]:
    """`movement_words` of markers, label -> (3, n), as `movement` has them."""
    given = frame_rate_hz, range_mm, horizon_s, step_mm
    found = {
        label: dict(zip(AXES, (movement(p, *given) for p in values), strict=True))
        for label, values in positions.items()
    }
    duration = max((len(values[0]) for values in positions.values()), default=0) / frame_rate_hz
    return movement_words(found, min(duration, horizon_s))


def movement_words(found: Mapping[str, Mapping[str, Movement]], within_s: float) -> list[str]:
    """One line that names every marker, label -> axis -> movement, that does what its noise cannot,
    and says what the one that moves most does; no line where none does.

    The Allan variance takes every change for noise, so it supposes a marker that does not move.
    """
    moving: dict[str, tuple[str, Movement]] = {}
    for label, axes in found.items():
        axis, worst = max(axes.items(), key=lambda item: np.nan_to_num(item[1].size_mm))
        if worst.moves:
            moving[label] = axis, worst
    if not moving:
        return []
    label = max(moving, key=lambda name: moving[name][1].size_mm)
    axis, worst = moving[label]
    first, *others = moving
    which = f"{label} " if others else ""
    return [
        f"marker {first} seems to move{_and_others(others)}: {which}{deed(axis, worst, within_s)}, "
        "which noise does not; the Allan variance supposes still markers"
    ]


def deed(axis: str, found: Movement, within_s: float) -> str:
    """What a marker does: `stands 2.05 mm elsewhere along x from 312 s on`."""
    size = length(found.size_mm)
    if math.isfinite(found.time_s):
        return f"stands {size} elsewhere along {axis} from {three(found.time_s)} s on"
    return f"covers {size} along {axis} within {three(within_s)} s"


def _and_others(names: Sequence[str]) -> str:
    """`, and so does B`; `, and so do B, C and D`; `, and so do 39 others`."""
    if len(names) > MOST_NAMED:
        return f", and so do {len(names)} others"
    if len(names) < 2:
        return "".join(f", and so does {name}" for name in names)
    return f", and so do {', '.join(names[:-1])} and {names[-1]}"


def length(mm: float) -> str:
    """Three digits, in m from a metre on."""
    return f"{three(mm / 1000)} m" if mm >= 1000 else f"{three(mm)} mm"


def speed(mm_per_h: float) -> str:
    """`+360 mm/h`, and `+928 m/h` from 10 m/h on: of what moves, not of what wanders."""
    if abs(mm_per_h) >= FAST_MM_H:
        return f"{three(mm_per_h / 1000, '+')} m/h"
    return f"{three(mm_per_h, '+')} mm/h"


def gaussian_rows(
    series: Mapping[str, np.ndarray],
    labels: Sequence[str],
    pairs: Sequence[tuple[int, int]],
    frame_rate_hz: float,
    n_bins: int = 30,
) -> list[dict[str, Any]]:
    """Rows of gaussian.csv from named series in mm: two a pair, along x and along the line.

    Columns are those of S Table 4; then the chi-squared test of L against N(mu_e, sigma_C) (S 4.2)
    and drift and drift range of either marker along the axis and of L. Without a pair, one row for
    each marker with what it alone can tell.
    """
    rows = []
    for number in range(1, len(labels) + 1) if not pairs else ():
        x = np.asarray(series[f"x{number}"], float)
        model = GaussianModel(float(np.nanmean(x)), float(np.nanstd(x, ddof=1)), *[math.nan] * 11)
        moves = (drift(x, frame_rate_hz), *[Drift(math.nan, math.nan, math.nan)] * 2)
        test = ChiSquared(math.nan, 0, math.nan, 0, 0)
        rows.append(_row("", labels[number - 1], "", "x", model, test, moves))
    for pair in pairs:
        first, second = (position(series, number) for number in pair)
        name = pair_name(pair, pairs)
        length = np.asarray(series[name], float)
        sample = gaussian_sample(length, n_bins)
        for axis, (a, b) in {"x": (first[0], second[0]), "pair": along_pair(first, second)}.items():
            model = gaussian_model(a, b, length)
            test = chi_squared_normal(length, model.mu_e, model.sigma_C, n_bins, sample)
            moves = tuple(drift(s, frame_rate_hz) for s in (a, b, length))
            ends = labels[pair[0] - 1], labels[pair[1] - 1]
            rows.append(_row(name, *ends, axis, model, test, moves))
    return rows


def _row(
    name: str,
    first: str,
    second: str,
    axis: str,
    model: GaussianModel,
    test: ChiSquared,
    moves: Sequence[Drift],
) -> dict[str, Any]:
    units = {"rho_12": "rho_12", "sigma_12": "sigma_12_mm2"}
    return {
        "pair": name,
        "marker_1": first,
        "marker_2": second,
        "axis": axis,
        **{units.get(key, f"{key}_mm"): value for key, value in asdict(model).items()},
        "chi2": test.statistic,
        "chi2_dof": test.dof,
        "chi2_p": test.p_value,
        "thinning_frames": test.step,
        "n_independent": test.n_independent,
        "drift_1_mm_per_h": moves[0].per_hour,
        "drift_2_mm_per_h": moves[1].per_hour,
        "drift_mm_per_h": moves[2].per_hour,
        "range_1_mm": moves[0].range,
        "range_2_mm": moves[1].range,
        "range_mm": moves[2].range,
    }
