"""What the simple statistics say of a recording: rows of gaussian.csv."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np

from mocap_metrology.common.types import Row
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
from mocap_metrology.noise.series import pair_name, position

LONG_S = 60.0  # a recording from which a drift per hour is told of


def gaussian_rows(
    series: Mapping[str, np.ndarray],
    labels: Sequence[str],
    pairs: Sequence[tuple[int, int]],
    frame_rate_hz: float,
    n_bins: int = 30,
) -> list[Row]:
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
) -> Row:
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
