"""CPU seconds of every estimator of noise coefficients on one nine-hour series.

    python -m benchmarks.noise_times

The series is a T40 z1 of Skurowski & Pawlyta 2019 (four Gauss-Markov terms and a sinusoid) at
120 Hz. Best of five; the Allan variances and the masking, which estimators share, on their own.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np

from benchmarks import cpu_s, head, line
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


def main() -> None:
    """Measure and print."""
    model = published_row("T40", 10)["z1"]
    asked = panel("T40", 10, "z1")
    rng = np.random.default_rng(1)
    series = draw_pair(model, model, Cross(constant=0.0), FRAMES, RATE, rng)[0]
    wave = model.lines[0]
    series += wave.A_s * np.sin(2 * np.pi * wave.f_0 * TAU0 * np.arange(FRAMES))
    m = averaging_factors(FRAMES, 100, 1, 1 / 3)
    curve = allan_curve(series, RATE, m)
    known = (curve.m, curve.variance, RATE, asked)
    duration = FRAMES * TAU0
    steps: dict[str, Callable[[], object]] = {
        "masking of gross outliers (Hampel, 6 sigma)": lambda: hampel(series, 120, 6.0, "mask"),
        "Allan variances with intervals": lambda: allan_curve(series, RATE, m),
        "likelihood, components known, FFT included": lambda: likelihood(series, RATE, asked),
        "likelihood, components chosen": lambda: likelihood(series, RATE),
        "annealing-ant-colony, 10 starts": lambda: annealing_run(
            *known, Annealing(), 1, duration=duration
        ),
        "levenberg-marquardt, 10 starts": lambda: levenberg_marquardt(*known, 1, duration=duration),
        "slopes": lambda: slopes(curve.m, curve.variance, RATE),
    }
    head("step", "CPU s")
    for name, step in steps.items():
        line(name, f"{cpu_s(step):.2f}")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    main()
