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

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.model.components import FORMS, NoiseModel, Sinusoid
from mocap_metrology.noise.model.synthesis import circle_length, increment_spectrum
from mocap_metrology.noise.twins.published import published_keys, published_row
from mocap_metrology.noise.twins.simulate import simulate

RATE, HOUR, TEN_MINUTES = 120.0, 432_000, 72_000
TAU0 = 1 / RATE
M = (1, 2, 5, 10, 100, 1000)
DRAWN = (("T40", 2), ("Bonita", 5), ("Vantage", 9))
OFF = 0.05


def ratios(form: str, n: int = HOUR) -> dict[tuple[str, int, str], np.ndarray]:
    """Of every published series: ADEV of the twin over the printed curve, at `M`."""
    length = circle_length(n)
    u = np.arange(1, length // 2 + 1) / length
    one = np.sin(np.pi * u) ** 4
    gains = [np.sin(np.pi * u * m) ** 4 / (2 * m**2 * one) for m in M]
    return {
        (kind, count, series): _ratios(model, form, length, gains)
        for kind, count in published_keys()
        for series, model in published_row(kind, count).items()
    }


def _ratios(model: NoiseModel, form: str, length: int, gains: list[np.ndarray]) -> np.ndarray:
    spectrum = increment_spectrum(model, length, RATE, form=form) / (length * TAU0)
    spectrum[[0, -1]] /= 2
    m = np.array(M)
    avar = spectrum[0] * m**2 / 2 + np.array([spectrum[1:] @ gain for gain in gains])
    for line in model.lines:
        avar += Sinusoid(line.recorded(RATE, form), line.f_0).avar(m, RATE)
    return np.sqrt(avar / model.avar(m, RATE, "continuous"))


def _far(values: np.ndarray) -> str:
    return f"{np.sum(np.abs(values - 1) > OFF)} of {values.size}"


def of_published() -> Iterator[tuple]:
    found = {form: ratios(form) for form in FORMS}
    every = {form: np.array(list(of.values())) for form, of in found.items()}
    for k, m in enumerate(M):
        both = [every[form][:, k] for form in ("sampled", "continuous")]
        case = f"154 published series, m = {m}"
        yield case, "ADEV off by more than 5 %", 154, "0", *map(_far, both)
        ends = (f"{100 * np.abs(v - 1).max():.2g} %" for v in both)
        yield case, "ADEV of the twin, farthest from the printed one", 154, "<= 1 %", *ends
    name = "T40", 2, "y1"
    both = (f"{found[form][name][0]:.4g}" for form in ("sampled", "continuous"))
    yield "T40-2 y1, m = 1", "ADEV of the twin over the printed one", 1, "1", *both


def of_recordings(n: int) -> Iterator[tuple]:
    for kind, count in DRAWN:
        models = published_row(kind, count)
        entry = {"published": {"camera_type": kind, "n_cameras": count}, "seed": 1}
        said = {form: _bias(entry | {"form": form}, models, n) for form in FORMS}
        for k, m in enumerate(M[:5]):
            values = (said[form][k] for form in ("sampled", "continuous"))
            case = f"{kind}-{count}, ten minutes drawn, six coordinates, m = {m}"
            yield case, "mean of ADEV^2 over the printed, farthest from 1", n, "1", *values


def _bias(entry: dict, models: dict[str, NoiseModel], n: int) -> list[str]:
    """At `M`: of the six coordinates the mean ratio farthest from 1, with its standard error."""
    name = "{camera_type}-{n_cameras}".format(**entry["published"])
    twin, m = twin_from_mapping(entry, name), np.array(M[:5])
    places = [(s, int(s[1]) - 1, "xyz".index(s[0])) for s in ("x1", "y1", "z1", "x2", "y2", "z2")]
    found = np.empty((n, len(places), m.size))
    for run in range(n):
        position = simulate(replace(twin, seed=run), TEN_MINUTES * TAU0).position_mm
        for k, (series, marker, axis) in enumerate(places):
            expected = models[series].avar(m, RATE, "continuous")
            found[run, k] = allan_variance(position[marker, axis], m).variance / expected
    mean, error = found.mean(axis=0), found.std(axis=0) / math.sqrt(n)
    at = np.abs(mean - 1).argmax(axis=0)
    return [f"{mean[i, k]:.3f} ± {error[i, k]:.3f}" for k, i in enumerate(at)]


def of_speed() -> Iterator[tuple]:
    took = []
    for form in ("sampled", "continuous"):
        entry = {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 1, "form": form}
        begun = time.process_time()
        simulate(twin_from_mapping(entry, "nine-hours"))
        took.append(time.process_time() - begun)
    yield (
        "T40-10, nine hours",
        "time to simulate over that of points",
        1,
        "<= 1.3",
        "1",
        (f"{took[1] / took[0]:.2f}"),
    )


def rows(n: int) -> Iterator[tuple]:
    """Rows of the table; n recordings a case."""
    yield from of_published()
    yield from of_recordings(n)
    yield from of_speed()
