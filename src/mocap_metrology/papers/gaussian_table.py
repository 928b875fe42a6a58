"""S Table 4, published beside regenerated: what chance allows, and relations within its rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mocap_metrology.common.hampel import white_level_kept
from mocap_metrology.common.types import Row
from mocap_metrology.noise.gaussian.moments import QUANTITIES, SLOW_SAMPLES, Cleaning, pair_moments
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, published_gaussian
from mocap_metrology.noise.twins.simulate import stream
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.papers.subsets import TABLE_4, source_of, standing_for

REPEATS = 200
LEVELS = (0.05, 0.5, 0.95)
MU_ERRORS = 3.0
TOLERANCE_MM = 1e-4
ROUNDING_MM = 1.5e-4  # of three numbers printed to four decimals
NINE_HOURS_S = 32400.0
UNITS = {"rho_12": "rho_12", "sigma_12": "sigma_12_mm2"}
RELATIONS = {
    "mu_e_mm": "|mu_2 - mu_1|",
    "sigma_12_mm2": "rho_12 sigma_1 sigma_2",
    "sigma_A1_mm": "sqrt(2) sigma_1",
    "sigma_A2_mm": "sqrt(2) sigma_2",
    "sigma_B_mm": "sqrt(sigma_1^2 + sigma_2^2)",
    "sigma_C_mm": "sqrt(sigma_1^2 + sigma_2^2 - 2 rho_12 sigma_1 sigma_2)",
}
BANDS = (
    *("standard_error", "lower_5", "median", "upper_95", "inside"),
    *("nine_hours_lower_5", "nine_hours_median", "nine_hours_upper_95", "published_inside"),
)
Numbers = Mapping[str, float]  # a row of Table 4 by quantity


def cleaning_of(hampel: Mapping[str, Any]) -> Cleaning:
    """What the configured filter (`half_window_s`, `n_sigma`, `action`) leaves at 120 Hz."""
    half_window_s = float(hampel["half_window_s"])
    half_window = round(half_window_s * FRAME_RATE_HZ)
    _, left = white_level_kept(float(hampel["n_sigma"]), half_window, hampel["action"])
    return Cleaning(left if math.isfinite(left) else 1.0, 0.5 / half_window_s)


def realisations(
    twin: Twin, repeats: int, cleaning: Cleaning | None = None, slow_samples: int = SLOW_SAMPLES
) -> dict[str, np.ndarray]:
    """(repeats,) of every quantity of Table 4 under its column's name; the twin's seed, a stream of
    its own, or of its take where twins share their slow noise, so that the k-th realisations of
    such twins belong together."""
    rng = stream(twin.slow.take if twin.slow else twin.name, twin.seed, "moments")
    moments = pair_moments(twin, repeats, rng, cleaning, slow_samples)
    return {UNITS.get(name, f"{name}_mm"): moments[name] for name in QUANTITIES}


def table_4(
    recordings: Mapping[str, Mapping[str, Any]],
    gaussian: Mapping[str, Numbers],
    twins: Mapping[str, Twin],
    cleaning: Cleaning | None = None,
    repeats: int = REPEATS,
) -> list[Row]:
    """S Table 4, long form: every number as published and as regenerated along x, with the bands of
    chance where a twin stands for the row, and residuals of the relations.

    gaussian: the row `axis = x` of gaussian.csv; twins: at the length they were simulated for; both
    by recording.
    """
    rows: list[Row] = []
    for kind, n_cameras in TABLE_4.items():
        name = standing_for(recordings, kind, n_cameras) or ""
        regenerated, published = gaussian.get(name, {}), published_gaussian(kind)
        bands = []  # realisations of the twin's own length, and of nine hours
        if twin := twins.get(name):
            lengths = twin.duration_s, NINE_HOURS_S
            of_length = {s: replace(twin, duration_s=s) for s in lengths}
            drawn = {s: realisations(one, repeats, cleaning) for s, one in of_length.items()}
            bands = [drawn[s] for s in lengths]
        for quantity, number in published.items():
            value = regenerated.get(quantity)
            row = {"camera_type": kind, "quantity": quantity, "published": number}
            row |= {"regenerated": value, "source": source_of(recordings.get(name))}
            row |= {"recording": name or None} | dict.fromkeys(BANDS)
            if bands:
                row |= _band(quantity, number, value, *(draws[quantity] for draws in bands))
            rows.append(row | _check(quantity, published, regenerated))
    return rows


def _band(
    quantity: str, published: float, value: float | None, drawn: np.ndarray, nine: np.ndarray
) -> Row:
    """Quantiles of one quantity; means are offsets from the first frame, where a twin is at the
    published mean, and have a standard error."""
    mean = quantity.startswith("mu_")
    start = published if mean else 0.0
    low, median, high = (start + np.quantile(drawn, LEVELS)).tolist()
    long_low, long_median, long_high = (start + np.quantile(nine, LEVELS)).tolist()
    error = float(np.sqrt(np.mean(drawn**2))) if mean else None
    inside = None
    if value is not None:
        near = low <= value <= high
        inside = near if error is None else abs(value - published) <= MU_ERRORS * error
    of_published = None if mean else long_low <= published <= long_high
    numbers = (error, low, median, high, inside, long_low, long_median, long_high, of_published)
    return dict(zip(BANDS, numbers, strict=True))


def by_relation(quantity: str, row: Numbers) -> float:
    """What the other numbers of a row of Table 4 make of one of `RELATIONS` (S 2.2)."""
    s_1, s_2 = row["sigma_1_mm"], row["sigma_2_mm"]
    common = row["rho_12"] * s_1 * s_2
    return {
        "mu_e_mm": abs(row["mu_2_mm"] - row["mu_1_mm"]),
        "sigma_12_mm2": common,
        "sigma_A1_mm": math.sqrt(2) * s_1,
        "sigma_A2_mm": math.sqrt(2) * s_2,
        "sigma_B_mm": math.hypot(s_1, s_2),
        "sigma_C_mm": math.sqrt(max(s_1**2 + s_2**2 - 2 * common, 0.0)),
    }[quantity]


def _check(quantity: str, published: Numbers, regenerated: Numbers) -> Row:
    """Residuals of the relation, of the regenerated and of the printed numbers."""
    columns = ("check", "residual", "consistent", "published_residual", "published_consistent")
    row: Row = dict.fromkeys(columns)
    if quantity in RELATIONS:
        row["check"] = RELATIONS[quantity]
        residual = published[quantity] - by_relation(quantity, published)
        row |= {"published_residual": residual}
        row |= {"published_consistent": abs(residual) <= ROUNDING_MM}
        if quantity in regenerated:
            residual = regenerated[quantity] - by_relation(quantity, regenerated)
            row |= {"residual": residual, "consistent": abs(residual) <= TOLERANCE_MM}
    return row
