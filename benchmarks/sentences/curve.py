"""Intervals of the Allan deviation (68.3 %) of published systems, and pairs of coarse exports.

Curves: twins of every published row, six coordinates each, nine hours (with fewer than 100 runs one
hour). The statistic is the share of points, in a range of averaging factors, whose interval holds
the deviation of the model. `shown`: the series as recorded without gross outliers
(allan_masked.parquet), as in figures, tables, verdict, compare and trend. `cleaned`: as in S
(allan.parquet). Its upper end is raised by the largest effect of the filter, so that it must hold
in 68.3 % or more.

Pairs: two recordings of ten minutes of the same white noise at different positions within a step,
and real changes by a tenth and by a half.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.sentences import Row, percent
from mocap_metrology.common.hampel import hampel, taken_at_most
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.changes.rows import coarse_steps, compare_rows
from mocap_metrology.noise.fit.estimators import NoiseSettings, masked_curve
from mocap_metrology.noise.series import allan_columns
from mocap_metrology.noise.twins.published import published_keys, published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.twin import COORDINATES, Twin
from mocap_metrology.present.changes import sentences

RATE = 120.0
RANGES = {"1 to 10": (1, 10), "11 to 100": (11, 100), "101 to 1000": (101, 1000)}
RANGES |= {"above": (1001, 10**9)}
COMPARE = {"margin": 0.05, "alpha": 0.01, "confidence": 0.95}
SIGMAS = (0.02, 0.03, 0.04, 0.05)


def rows(n: int) -> Iterator[Row]:
    """Both tables."""
    yield from _curves(9.0 if n >= 100 else 1.0)
    yield from _pairs(n)


def _curves(hours: float) -> Iterator[Row]:
    held = {kind: {name: [] for name in RANGES} for kind in ("shown", "cleaned")}
    for number, key in enumerate(published_keys()):
        models = published_row(*key)
        twin = Twin("curve", 100 + number, models, duration_s=3600 * hours)
        position = simulate(twin).position_mm
        for name in COORDINATES:
            series = position[int(name[1]) - 1, "xyz".index(name[0])]
            for kind, (m, inside) in _inside(series, models[name]).items():
                for label, (first, last) in RANGES.items():
                    held[kind][label] += inside[(m >= first) & (m <= last)].tolist()
    count = len(published_keys()) * len(COORDINATES)
    reach = {"shown": "63 to 75 %", "cleaned": ">= 68 %"}
    for kind, of in held.items():
        for label, inside in of.items():
            case = f"{kind} curve, {hours:g} h, m {label}"
            yield case, "68.3 % interval holds", count, reach[kind], percent(inside)


def _inside(series: np.ndarray, model) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    settings = NoiseSettings()
    _, shown = masked_curve(series, RATE, settings)
    cleaned = hampel(series, settings.half_window, 3.0, "replace").values
    curve = allan_curve(cleaned, RATE, shown.m)
    curves = {"shown": shown, "cleaned": curve.with_upper_raised(taken_at_most(3.0, 120))}
    found = {}
    for kind, one in curves.items():
        truth = np.sqrt(model.avar(one.m, RATE, "sampled"))
        found[kind] = one.m, (one.lower <= truth) & (truth <= one.upper)
    return found


def _pairs(n: int) -> Iterator[Row]:
    decides = "resolution decides, reported"
    for step in (0.05, 0.1):
        case = f"unchanged pairs, steps of {step} mm"
        yield case, "called changed", n, "0", f"{_called(n, step, 1.0)[0]}"
        told = _called(n, step, 1.0, [s for s in SIGMAS if s < 0.5 * step + 1e-9])[1]
        yield f"{case}, noise up to half a step", decides, n, "all", f"{told}"
    for factor in (1.1, 1.5):
        for step in (0.0, 0.01):
            changed, told = _called(n, step, factor)
            case = f"noise {factor:g} times, steps of {step} mm"
            yield case, "called changed", n, ">= 95 %", f"{changed}"
            yield case, decides, n, "0", f"{told}"


def _called(n: int, step: float, factor: float, sigmas=SIGMAS) -> tuple[int, int]:
    """Of n pairs: those called changed, and those of which the resolution is said to decide."""
    rng = np.random.default_rng(round(1000 * step + 10 * factor))
    changed = said = 0
    for k in range(n):
        sigma = sigmas[k % len(sigmas)]
        new, old = (_export(rng, f * sigma, step) for f in (factor, 1.0))
        coarse = coarse_steps(new, step) | coarse_steps(old, step)
        found = compare_rows("new", "old", new, old, **COMPARE, coarse=coarse)
        changed += any(row["word"] in ("better", "worse") for row in found)
        said += "the resolution of the export decides" in sentences(found)[0]
    return changed, said


def _export(rng: np.random.Generator, sigma: float, step: float) -> dict:
    position = sigma * rng.normal(size=60_000) + rng.uniform(0, step or 1.0)
    stored = np.round(position / step) * step if step else position
    m = averaging_factors(stored.size, 30, 1, 1 / 3)
    return allan_columns("x1", allan_curve(stored, 100.0, m))
