"""Functions of one series: their results for series of many kinds, and of how many samples each
needs at least."""

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.ndimage import median_filter
from scipy.signal import lfilter

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.identification import noise_exponents
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.assess.measured import measured_spread, measured_within
from mocap_metrology.noise.cameras.covariance import covariance_rows
from mocap_metrology.noise.diagnosis import export, outliers, software
from mocap_metrology.noise.diagnosis.dynamic import dynamic_allan
from mocap_metrology.noise.diagnosis.fills import innovation
from mocap_metrology.noise.diagnosis.levels import trends
from mocap_metrology.noise.diagnosis.periodic import series_lines
from mocap_metrology.noise.diagnosis.recurring import pulses, recurring_bout
from mocap_metrology.noise.diagnosis.resonance import resonance
from mocap_metrology.noise.diagnosis.sides import blocks
from mocap_metrology.noise.fit.spectral.lines import find_lines
from mocap_metrology.noise.fit.spectral.periodogram import bins_of, edges
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.gaussian.two_markers import (
    correlation_time,
    drift,
    kernel_density,
    median_drift,
)
from mocap_metrology.noise.motion.movement import movement
from mocap_metrology.noise.motion.place import by_place, freedom
from mocap_metrology.noise.trace import axis_limits, columns, trace_of

from .digest import Flat, flat

N, RATE = 9000, 100.0
Floats = np.ndarray


def kinds() -> dict[str, Floats]:
    """Of standard deviation near one."""
    rng = np.random.default_rng(14)
    white, steps = rng.standard_normal((2, N))
    t = np.arange(N) / RATE
    return {
        "white": white,
        "walk": white + 0.03 * np.cumsum(steps),
        "correlated": lfilter([0.3], [1, -0.95], white),
        "gaps": np.where((rng.random(N) < 0.05) | (abs(t - 4) < 1.5), np.nan, white),
        "tails": white * np.where(rng.random(N) < 0.03, 5.0, 1.0),
        "steps": np.round(1.5 * white) / 1.5,
        "tone": white + 0.5 * np.sin(2 * np.pi * 7.3 * t) + 0.2 * t / t[-1],
        "knocks": white + 3.0 * ((t % 1.3) < 0.05),
        "jump": white + 3.0 * (t > 40),
    }


def spectrum(x: Floats) -> Mapping[str, Floats]:
    found = welch(x, RATE)
    return {"f_hz": found.f_hz, "psd_mm2_hz": found.psd, "n_segments": 0 * found.f_hz + 8}


def factors(x: Floats) -> np.ndarray:
    return averaging_factors(x.size, 12)


def place_of(x: Floats) -> list[Any]:
    middle = 300 * np.sin(np.arange(x.size) * np.array([[3e-3], [2e-3], [1e-3]]))
    return by_place(middle, 500 + x, 250.0)[0]


def axes(x: Floats) -> object:
    table = columns(500 + x, 40)
    return table.to_dict("list"), axis_limits(table, table)


def processed(x: Floats) -> object:
    return software.processed({"x1": x}, {"x1": export.bands(x, RATE)}, RATE, 0.0)


FUNCTIONS: dict[str, Callable[[Floats], object]] = {
    "curve": lambda x: allan_curve(x, RATE, factors(x)),
    "hdev": lambda x: allan_curve(x, RATE, factors(x), "hdev", 0.95),
    "exponents": lambda x: noise_exponents(x, factors(x)),
    "spread": lambda x: measured_spread(x, 7, 200),
    "within": lambda x: measured_within(x, 50),
    "covariance": lambda x: covariance_rows(
        {k: np.roll(x, j) for j, k in enumerate(("x1", "y1", "z1"))}, 1, RATE
    ),
    "tails": lambda x: outliers.heavy_tails({"x1": x}, 0.1),
    "off": lambda x: np.flatnonzero(outliers.off_frames(x, 5.0, 0.1)),
    "drawn in": lambda x: outliers.drawn_in({"x1": x}, 0.1)["x1"],
    "bands": lambda x: export.bands(x, RATE),
    "low pass": lambda x: export.low_pass(
        "x1", export.bands(lfilter([0.2], [1, -0.8], x), RATE), RATE, 0.01
    ),
    "repeats": lambda x: software.repeats("A", [x, x[::-1], -x], 0.1),
    "processed": lambda x: processed(lfilter([0.05], [1, -0.95], x)),
    "running median": lambda x: software.running_median({"x1": median_filter(x, 5), "y1": x}, 0.0),
    "dynamic": lambda x: dynamic_allan(x, RATE, 0.1, 20.0),
    "pulses": lambda x: pulses(x, RATE, 1e-3),
    "bout": lambda x: recurring_bout(x, RATE, 1e-3, blocks(x, RATE)),
    "innovation": innovation,
    "blocks": lambda x: blocks(x, RATE),
    "trends": lambda x: trends(
        {"x1": blocks(x * np.geomspace(1, 9, x.size), RATE)}, np.zeros(N, bool), []
    ),
    "lines": lambda x: ((y := series_lines(x, RATE, 5))[0], y[1].size / RATE),
    "all lines": lambda x: find_lines(x[np.isfinite(x)], RATE),
    "resonance": lambda x: resonance("x1", x, RATE, spectrum(x)),
    "bins": lambda x: bins_of(x.size, RATE),
    "edges": lambda x: edges(x.size),
    "Welch": lambda x: welch(x, RATE, 5.0),
    "correlation time": correlation_time,
    "density": lambda x: kernel_density(x[np.isfinite(x)]),
    "drift": lambda x: (drift(x, RATE), median_drift(x, RATE)),
    "movement": lambda x: movement(x, RATE, 1.0, 30.0, 0.1),
    "places": place_of,
    "freedom": freedom,
    "trace": lambda x: {
        name: np.asarray(value) if isinstance(value, pd.DataFrame | pd.Series) else value
        for name, value in vars(trace_of("x1", x, x, abs(x) > 0.06, RATE, 30)).items()
    },
    "axes": axes,
}


def result(function: Callable[[Floats], object], x: Floats) -> object:
    try:
        return function(x)
    except (Refusal, ValueError, IndexError) as refusal:
        return type(refusal).__name__


def nothing(value: object) -> bool:
    """Whether it says nothing: none, not a number, empty, a refusal."""
    if is_dataclass(value):
        return all(nothing(getattr(value, f.name)) for f in fields(value))
    if isinstance(value, Mapping | str | bytes) or value is None:
        return not value or isinstance(value, str | bytes) or all(map(nothing, value.values()))
    if isinstance(value, list | tuple | np.ndarray):
        return all(map(nothing, value)) if len(value) < 1000 else False
    return not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value)


def of(name: str) -> Callable[[Path | None], Flat]:
    function = FUNCTIONS[name]

    def run(folder: Path | None = None) -> Flat:
        found = {kind: result(function, 0.02 * x) for kind, x in kinds().items()}
        return dict(flat(found)) | {"least": least(function)}

    return run


def least(function: Callable[[Floats], object]) -> int:
    """Samples of white noise from which a function says something, by bisection."""
    x = 0.02 * kinds()["white"]
    low, high = 0, N
    while high - low > 1:
        middle = (low + high) // 2
        if nothing(result(function, x[:middle])):
            low = middle
        else:
            high = middle
    return high


CASES: dict[str, Callable[..., Flat]] = {f"function {name}": of(name) for name in FUNCTIONS}
