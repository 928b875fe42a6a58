"""Low-pass filters before the export: detected with their cutoff, and no false alarm.

One coordinate, ten minutes at 100 Hz (a third of the runs at 60, 120 or 240 Hz, some of one
minute), float32 steps or 0.01 mm. A cutoff is right within a factor of 1.3 or 1.4, as stated.
Published: the 154 series of S.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from mocap_workflow.recording_twins import twin_from_mapping

from benchmarks.sentences import Row
from benchmarks.sentences import _kinds as kinds
from mocap_metrology.noise.diagnosis.export import LowPass, bands, low_pass
from mocap_metrology.noise.series import all_series
from mocap_metrology.noise.twins.published import published_keys
from mocap_metrology.noise.twins.simulate import simulate

FORMS = ((100.0, 600.0),) * 6 + ((60.0, 600.0), (120.0, 60.0), (240.0, 300.0))
BASES: list[kinds.Kind] = [
    kinds.white,
    kinds.total(kinds.white, kinds.walk(0.02)),
    kinds.total(kinds.white, kinds.coloured(-1.0)),
    kinds.total(kinds.white, kinds.gauss_markov(1.0, 0.2)),
]
STEPS = (1.5e-5, 0.01)


def rows(n: int) -> Iterator[Row]:
    """5 n unfiltered series, the published ones, n of each filter."""
    yield from unfiltered(5 * n)
    yield from published()
    yield from filtered(n)


def found_in(x: np.ndarray, rate_hz: float, step: float) -> LowPass | None:
    """The filter of a series that is rounded to steps."""
    return low_pass("x1", bands(step * np.round(x / step), rate_hz), rate_hz, step)


def unfiltered(runs: int) -> Iterator[Row]:
    names, hits = list(kinds.PLAIN), 0
    for k in range(runs):
        name = names[k % len(names)]
        rate, seconds = FORMS[k % len(FORMS)]
        x = kinds.PLAIN[name](np.random.default_rng([5, k]), round(rate * seconds), rate) + 160.1
        step = next((q for q in (0.1, 0.05) if f"steps of {q} mm" in name), STEPS[k % 2])
        hits += found_in(x, rate, step) is not None
    case = f"unfiltered, {len(names)} kinds"
    yield case, "called filtered", runs, "<= 1 %", f"{hits} of {runs}"


def published() -> Iterator[Row]:
    """Every published series once, ten minutes at its rate."""
    total = hits = 0
    for kind, count in published_keys():
        mapping = {"published": {"camera_type": kind, "n_cameras": count}, "seed": 1}
        made = simulate(twin_from_mapping(mapping, f"{kind}-{count}"), 600.0)
        position = np.float32(made.position_mm).reshape(6, -1)
        own = dict(zip(("x1", "y1", "z1", "x2", "y2", "z2"), position, strict=True))
        for name, x in all_series(own, [(1, 2)]):
            total += 1
            spectrum = bands(np.asarray(x, dtype=np.float64), made.frame_rate_hz)
            hits += low_pass(name, spectrum, made.frame_rate_hz, 1.5e-5) is not None
    yield "published series", "called filtered", total, "<= 1 %", f"{hits} of {total}"


def filtered(n: int) -> Iterator[Row]:
    for name, apply in kinds.FILTERS.items():
        found, ratios = 0, []
        for k in range(n):
            rate, seconds = FORMS[k % len(FORMS)]
            rng = np.random.default_rng([6, k])
            x = apply(BASES[k % len(BASES)](rng, round(rate * seconds), rate), rate) + 160
            one = found_in(x, rate, STEPS[k % 2])
            found += one is not None
            if one is not None and np.isfinite(one.cutoff_hz):
                ratios.append(abs(np.log(one.cutoff_hz / kinds.half_amplitude(apply, rate))))
        yield name, "named", n, ">= 95 %", f"{found} of {n}"
        for factor, reach in ((1.3, ">= 90 %"), (1.4, ">= 95 %")):
            near = f"{sum(np.array(ratios) < np.log(factor))} of {len(ratios)}"
            yield name, f"cutoff within {factor}", len(ratios), reach, near
