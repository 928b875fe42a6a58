"""CPU seconds of every estimator of noise coefficients on one nine-hour series.

    python benchmarks/noise_times.py

The series is a T40 z1 of Skurowski & Pawlyta 2019 (four Gauss-Markov terms and a sinusoid) at
120 Hz. Best of five; the Allan variances and the masking, which estimators share, on their own.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from mocap_metrology.common.hampel import hampel
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.fit.allan.annealing import annealing_run
from mocap_metrology.noise.fit.allan.baselines import levenberg_marquardt, slopes
from mocap_metrology.noise.fit.estimators import panel
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.model.synthesis import Cross, draw_pair
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.settings import Annealing

RATE, FRAMES = 120.0, 3_888_000
TAU0 = 1 / RATE


def cpu_s(function: Callable[[], object], repeats: int = 5) -> float:
    """Least CPU time of a call."""
    best = float("inf")
    for _ in range(repeats):
        start = time.process_time()
        function()
        best = min(best, time.process_time() - start)
    return best


def main() -> None:
    """Measure and print."""
    model = published_row("T40", 10)["z1"]
    asked = panel("T40", 10, "z1")
    rng = np.random.default_rng(1)
    series = draw_pair(model, model, Cross(constant=0.0), FRAMES, RATE, rng)[0]
    line = model.lines[0]
    series += line.A_s * np.sin(2 * np.pi * line.f_0 * TAU0 * np.arange(FRAMES))
    m = averaging_factors(FRAMES, 100, 1, 1 / 3)
    curve = allan_curve(series, RATE, m)
    known = (curve.m, curve.variance, RATE, asked)
    settings = Annealing()
    steps: dict[str, Callable[[], object]] = {
        "masking of gross outliers (Hampel, 6 sigma)": lambda: hampel(series, 120, 6.0, "mask"),
        "Allan variances with intervals": lambda: allan_curve(series, RATE, m),
        "likelihood, components known, FFT included": lambda: likelihood(series, RATE, asked),
        "likelihood, components chosen": lambda: likelihood(series, RATE),
        "annealing-ant-colony, 10 starts": lambda: (
            annealing_run(*known, settings, 1, duration=FRAMES * TAU0).estimate
        ),
        "levenberg-marquardt, 10 starts": lambda: levenberg_marquardt(
            *known, 1, duration=FRAMES * TAU0
        ),
        "slopes": lambda: slopes(curve.m, curve.variance, RATE),
    }
    print("| step | CPU s |\n|---|---|")
    for name, step in steps.items():
        print(f"| {name} | {cpu_s(step):.2f} |", flush=True)


if __name__ == "__main__":
    argparse.ArgumentParser(prog="noise_times.py", description=__doc__.splitlines()[0]).parse_args()
    main()
