"""What the simple statistics say of a recording: rows of gaussian.csv, warnings of movement."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from mocap_metrology.common.words import three
from mocap_metrology.noise.gaussian import (
    ChiSquared,
    Drift,
    GaussianModel,
    along_pair,
    chi_squared_normal,
    drift,
    gaussian_model,
    gaussian_sample,
    median_drift,
)
from mocap_metrology.noise.series import AXES, pair_name, position

FAST_MM_H = 10_000.0
MOST_NAMED = 6
LONG_S = 60.0  # a recording from which a drift per hour is told of


def moving_markers(
    positions: Mapping[str, np.ndarray], frame_rate_hz: float, range_mm: float
) -> list[str]:
    """One line that names every marker, label -> (3, n), whose medians (`median_drift`) span more
    than `range_mm`, and what the one that moves most does; no line where none does.

    The Allan variance takes every change for noise, so it supposes a marker that does not move.
    """
    moving: dict[str, tuple[str, Drift]] = {}
    for label, values in positions.items():
        found = {
            a: median_drift(np.asarray(p, float), frame_rate_hz)
            for a, p in zip(AXES, values, strict=True)
        }
        axis, worst = max(found.items(), key=lambda item: np.nan_to_num(item[1].range))
        if worst.range > range_mm:
            moving[label] = axis, worst
    if not moving:
        return []
    label = max(moving, key=lambda name: moving[name][1].range)
    axis, worst = moving[label]
    first, *others = moving
    which = f" of {label}" if others else ""
    duration_s = len(positions[label][0]) / frame_rate_hz
    drifts = f" (drift {speed(worst.per_hour)})" if duration_s >= LONG_S else ""
    return [
        f"marker {first} seems to move{_and_others(others)}: medians over {worst.block_s:.2g} s"
        f"{which} span {length(worst.range)} along {axis} in {three(duration_s)} s{drifts}, more "
        f"than {range_mm:g} mm; the Allan variance supposes still markers"
    ]


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
