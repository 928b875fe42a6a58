"""Allan deviation of twins over the curve of the published coefficients, as S's formulas print it.

For all 154 published series (22 rows of Tables A1-A3, seven series each): the expectation, from the
discrete spectrum of the simulation (one hour at 120 Hz) and the recorded height of the sinusoid,
and recordings of ten minutes as simulated. The column at 8b8d0af is that of `form: sampled`, then
the only form. L has its own model, also where x1 and x2 contradict it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from mocap_workflow.recording_twins import twin_from_mapping

from benchmarks.sentences import Row
from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.model.components import NoiseModel, Sinusoid
from mocap_metrology.noise.model.synthesis import circle_length, increment_spectrum
from mocap_metrology.noise.twins.published import published_keys, published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.twin import COORDINATES, Twin

RATE, HOUR, TEN_MINUTES = 120.0, 432_000, 72_000
TAU0 = 1 / RATE
M = (1, 2, 5, 10, 100, 1000)
DRAWN = (("T40", 2), ("Bonita", 5), ("Vantage", 9))
FORM = "continuous"
OFF = 0.05


def ratios() -> dict[tuple[str, int, str], np.ndarray]:
    """Of every published series: ADEV of the twin over the printed curve, at `M`."""
    length = circle_length(HOUR)
    u = np.arange(1, length // 2 + 1) / length
    one = np.sin(np.pi * u) ** 4
    gains = [np.sin(np.pi * u * m) ** 4 / (2 * m**2 * one) for m in M]
    return {
        (kind, count, series): _ratios(model, length, gains)
        for kind, count in published_keys()
        for series, model in published_row(kind, count).items()
    }


def _ratios(model: NoiseModel, length: int, gains: list[np.ndarray]) -> np.ndarray:
    spectrum = increment_spectrum(model, length, RATE, form=FORM) / (length * TAU0)
    spectrum[[0, -1]] /= 2
    m = np.array(M)
    avar = spectrum[0] * m**2 / 2 + np.array([spectrum[1:] @ gain for gain in gains])
    for line in model.lines:
        avar += Sinusoid(line.recorded(RATE, FORM), line.f_0).avar(m, RATE)
    return np.sqrt(avar / model.avar(m, RATE, "continuous"))


def _far(values: np.ndarray) -> str:
    return f"{np.sum(np.abs(values - 1) > OFF)} of {values.size}"


def of_published() -> Iterator[Row]:
    found = ratios()
    for k, m in enumerate(M):
        off = np.abs(np.array([of[k] for of in found.values()]) - 1)
        case = f"154 published series, m = {m}"
        yield case, "ADEV off by more than 5 %", 154, "0", f"{np.sum(off > OFF)} of {off.size}"
        farthest = f"{100 * off.max():.2g} %"
        yield case, "ADEV of the twin, farthest from the printed one", 154, "<= 1 %", farthest
    told = f"{found['T40', 2, 'y1'][0]:.4g}"
    yield "T40-2 y1, m = 1", "ADEV of the twin over the printed one", 1, "1", told


def of_recordings(n: int) -> Iterator[Row]:
    """Of the six coordinates the mean ratio farthest from 1, with its standard error."""
    m = np.array(M[:5])
    for kind, count in DRAWN:
        models = published_row(kind, count)
        twin, found = twin_of(kind, count, FORM), np.empty((n, len(COORDINATES), m.size))
        for run in range(n):
            position = simulate(replace(twin, seed=run), TEN_MINUTES * TAU0).position_mm
            for k, series in enumerate(COORDINATES):
                values = position[int(series[1]) - 1, "xyz".index(series[0])]
                expected = models[series].avar(m, RATE, "continuous")
                found[run, k] = allan_variance(values, m).variance / expected
        mean, error = found.mean(axis=0), found.std(axis=0) / math.sqrt(n)
        for k, i in enumerate(np.abs(mean - 1).argmax(axis=0)):
            case = f"{kind}-{count}, ten minutes drawn, six coordinates, m = {M[k]}"
            told = f"{mean[i, k]:.3f} ± {error[i, k]:.3f}"
            yield case, "mean of ADEV^2 over the printed, farthest from 1", n, "1", told


def twin_of(kind: str, count: int, form: str) -> Twin:
    entry = {"published": {"camera_type": kind, "n_cameras": count}, "seed": 1, "form": form}
    return twin_from_mapping(entry, f"{kind}-{count}")


def of_speed() -> Iterator[Row]:
    took = []
    for form in ("sampled", FORM):
        begun = time.process_time()
        simulate(twin_of("T40", 10, form))
        took.append(time.process_time() - begun)
    told = f"{took[1] / took[0]:.2f}"
    yield "T40-10, nine hours", "time to simulate over that of points", 1, "<= 1.3", told


def rows(n: int) -> Iterator[Row]:
    """n recordings a case."""
    yield from of_published()
    yield from of_recordings(n)
    yield from of_speed()
