"""Low-pass filters before the export: detected with their cutoff, and no false alarm.

One coordinate, ten minutes at 100 Hz (a third of the runs at 60, 120 or 240 Hz, some of one
minute), float32 steps or 0.01 mm. A cutoff is right within a factor of 1.3 or 1.4, as stated.
Published: the 154 series of S.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.sentences import _kinds as kinds

FORMS = ((100.0, 600.0),) * 6 + ((60.0, 600.0), (120.0, 60.0), (240.0, 300.0))
BASES: dict[str, kinds.Kind] = {
    "white": kinds.white,
    "walk": kinds.total(kinds.white, kinds.walk(0.02)),
    "flicker": kinds.total(kinds.white, kinds.coloured(-1.0)),
    "Gauss-Markov 1 s": kinds.total(kinds.white, kinds.gauss_markov(1.0, 0.2)),
}
STEPS = (1.5e-5, 0.01)


def rows(n: int) -> list[tuple[Any, ...]]:
    """(case, statistic, runs, reach, at 8b8d0af, measured)."""
    return [*unfiltered(n), *published(), *filtered(n)]


def unfiltered(n: int) -> list[tuple[Any, ...]]:
    from mocap_metrology.noise.diagnosis.export import bands, low_pass

    names, hits = list(kinds.PLAIN), 0
    runs = 5 * n
    for k in range(runs):
        name = names[k % len(names)]
        rate, seconds = FORMS[k % len(FORMS)]
        x = kinds.PLAIN[name](np.random.default_rng([5, k]), round(rate * seconds), rate) + 160.1
        step = next((q for q in (0.1, 0.05) if f"steps of {q} mm" in name), STEPS[k % 2])
        spectrum = bands(step * np.round(x / step), rate)
        hits += low_pass("x1", spectrum, rate, step) is not None
    case = f"unfiltered, {len(names)} kinds"
    return [(case, "called filtered", runs, "<= 1 %", "-", f"{hits} of {runs}")]


def published() -> list[tuple[Any, ...]]:
    """Every published series once, ten minutes at its rate."""
    from mocap_workflow.recording_twins import twin_from_mapping

    from mocap_metrology.noise.diagnosis.export import bands, low_pass
    from mocap_metrology.noise.series import all_series
    from mocap_metrology.noise.twins.published import published_keys
    from mocap_metrology.noise.twins.simulate import simulate

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
    return [("published series", "called filtered", total, "<= 1 %", "-", f"{hits} of {total}")]


def filtered(n: int) -> list[tuple[Any, ...]]:
    from mocap_metrology.noise.diagnosis.export import bands, low_pass

    told = []
    for name, apply in kinds.FILTERS.items():
        found = right = near = judged = 0
        for k in range(n):
            rate, seconds = FORMS[k % len(FORMS)]
            kind = list(BASES.values())[k % len(BASES)]
            x = apply(kind(np.random.default_rng([6, k]), round(rate * seconds), rate), rate) + 160
            step = STEPS[k % 2]
            one = low_pass("x1", bands(step * np.round(x / step), rate), rate, step)
            found += one is not None
            if one is not None and np.isfinite(one.cutoff_hz):
                judged += 1
                true = kinds.half_amplitude(apply, rate)
                right += true / 1.3 < one.cutoff_hz < 1.3 * true
                near += true / 1.4 < one.cutoff_hz < 1.4 * true
        told.append((name, "named", n, ">= 95 %", "-", f"{found} of {n}"))
        told.append((name, "cutoff within 1.3", judged, ">= 90 %", "-", f"{right} of {judged}"))
        told.append((name, "cutoff within 1.4", judged, ">= 95 %", "-", f"{near} of {judged}"))
    return told
