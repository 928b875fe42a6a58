"""The mean of all frames: independent frames and their interval, 15 min at 100 Hz.

White noise of 0.02 mm and Gauss-Markov noise; truth by the sum over all lags.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from benchmarks.sentences._kinds import gauss_markov
from mocap_metrology.noise.assess.uncertainty import Span, assess_series
from mocap_metrology.noise.fit.estimates import rows as noise_rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood

RATE, N, SIGMA = 100.0, 90_000, 0.02
KINDS: dict[str, list[tuple[float, float]]] = {  # T_c in s, standard deviation in mm
    "white": [],
    "0.03 mm of 0.1 s": [(0.1, 0.03)],
    "0.03 mm of 1 s": [(1.0, 0.03)],
    "0.02 mm of 10 s": [(10.0, 0.02)],
    "0.03 mm of 0.3 s, 0.02 mm of 5 s": [(0.3, 0.03), (5.0, 0.02)],
}
NO_CURVE = dict.fromkeys(
    ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf"), np.array([])
)


def truth(terms: list[tuple[float, float]]) -> float:
    """Independent frames."""
    k = np.arange(1, N)
    frame, mean = SIGMA**2, SIGMA**2 / N
    for T_c, sigma in terms:
        frame += sigma**2
        lags = float(np.sum((1 - k / N) * np.exp(-k / (T_c * RATE))))
        mean += sigma**2 / N * (1 + 2 * lags)
    return frame / mean


def rows(runs: int) -> Iterator[tuple[str, str, int, str, str, str]]:
    """For docs/accuracy."""
    for case, terms in KINDS.items():
        true, near, held = truth(terms), 0, 0
        for run in range(runs):
            rng = np.random.default_rng([run, 5])
            series = SIGMA * rng.normal(size=N)
            for T_c, sigma in terms:
                series = series + gauss_markov(T_c, sigma)(rng, N, RATE)
            fitted = noise_rows("x1", likelihood(series, RATE).estimate)
            found = assess_series(series, fitted, NO_CURVE, Span(RATE)).mean_of_all
            if math.isfinite(found.n_eff):
                near += abs(found.n_eff / true - 1) < 0.2
                held += found.n_eff_lower_95 <= true <= found.n_eff_upper_95
        yield case, "within 20 %", runs, ">= 0.9", "", f"{near / runs:.2f}"
        yield case, "interval holds", runs, ">= 0.9", "", f"{held / runs:.2f}"
