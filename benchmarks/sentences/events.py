"""Events: false alarms in undisturbed recordings, also with heavy tails, and detection.

Recordings of two markers (six coordinates and their distance), ten minutes at 100 Hz, 0.05 mm of
noise; the false-alarm rate is set to 1 %. `events` counts recordings with any event. Shocks swing
twice, with 0.5 to 1 of their size in every coordinate; bumps displace marker 1 permanently. Kinds
other than Student t4 have a fifth of `--runs`, detections a tenth.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from benchmarks.sentences import Row
from benchmarks.sentences import _kinds as kinds
from mocap_metrology.noise.diagnosis import outliers
from mocap_metrology.noise.diagnosis.events import inside_events
from mocap_metrology.noise.diagnosis.fills import filled_frames
from mocap_metrology.noise.diagnosis.levels import trends
from mocap_metrology.noise.diagnosis.recording import search_events
from mocap_metrology.noise.series import all_series

RATE, SECONDS = 100.0, 600.0
N = round(RATE * SECONDS)
NAMES = ("x1", "y1", "z1", "x2", "y2", "z2")
PLACE = np.array([160.0, 20.0, 300.0, -500.0, 40.0, 900.0])[:, None]
STEP = 1.5e-5

GAUSSIAN = [name for name in kinds.PLAIN if "0.005" not in name]
TAILS: dict[str, kinds.Kind] = {
    "Student t4": kinds.student(4.0),
    "Student t3": kinds.student(3.0),
    "Student t4, walk": kinds.total(kinds.student(4.0), kinds.walk(0.01)),
    "Laplace": kinds.laplace,
    "5 % five times as large": kinds.contaminated(0.05, 5.0),
    "1 % ten times as large": kinds.contaminated(0.01, 10.0),
    "telegraph, 1 a second": kinds.total(kinds.white, kinds.telegraph(1.0, 0.1)),
    "telegraph, 10 a second": kinds.total(kinds.white, kinds.telegraph(10.0, 0.05)),
}
BASE: dict[str, kinds.Kind] = {"white": kinds.white, "Student t4": kinds.student(4.0)}


def recorded(kind: kinds.Kind, seed: Iterable[int]) -> np.ndarray:
    """(6, n) mm."""
    rng = np.random.default_rng([7, *seed])
    return np.array([kind(rng, N, RATE) for _ in NAMES]) + PLACE


def found_in(position: np.ndarray, step: float = STEP) -> tuple[list, list, list]:
    """Events, slow changes of level and heavy tails, as in a diagnosis; fills are left out."""
    position = position.astype(np.float32).reshape(2, 3, -1)
    for own, mask in zip(position, filled_frames(position, step), strict=True):
        own[:, mask] = np.nan
    raw = dict(zip(NAMES, position.reshape(6, -1), strict=True))
    off = {k: outliers.off_frames(v, 6.0, step) for k, v in raw.items()}
    spikes = outliers.isolated_frames(off, {k: int(k[1]) for k in raw})
    known = {k: outliers.without(v, spikes[k]) for k, v in raw.items()}
    quiet = dict(all_series(known, [(1, 2)]))
    events, _, levels = search_events(quiet, [(1, 2)], RATE, step, 0.01, 300.0)
    out_of = inside_events(events, next(iter(levels.values())).mean.size, 1.0)
    steps = [e.time_s for e in events if e.kind == "level" or e.level_changed]
    return events, trends(levels, out_of, steps), outliers.heavy_tails(quiet, step)


def shocked(position: np.ndarray, size: float, lasts_s: float, seed: int) -> tuple:
    """Position with a shock of `size` sigma, and its time."""
    rng = np.random.default_rng([9, seed])
    at = rng.uniform(0.3, 0.7) * SECONDS
    t = np.arange(N) / RATE - at
    swing = np.sin(4 * np.pi * t / lasts_s) * np.sin(np.pi * t / lasts_s)
    swing[(t < 0) | (t >= lasts_s)] = 0.0
    return position + np.outer(rng.uniform(0.5, 1, 6) * size * kinds.SIGMA, swing), at


def bumped(position: np.ndarray, size: float, seed: int) -> tuple:
    """Position whose marker 1 is moved by `size` sigma, and when."""
    at = np.random.default_rng([9, seed]).uniform(0.3, 0.7) * SECONDS
    moved = position.copy()
    moved[:3, round(at * RATE) :] += size * kinds.SIGMA
    return moved, at


def rows(n: int) -> Iterator[Row]:
    """n recordings of Gaussian and Student t4 noise, fewer of others."""
    yield from sound(n, max(n // 5, 1))
    yield from detected(max(n // 10, 1))


def row(case: str, statistic: str, hits: list[bool], reach: str) -> Row:
    return case, statistic, len(hits), reach, f"{sum(hits)} of {len(hits)}"


def sound(n: int, few: int) -> Iterator[Row]:
    events, levels, tails = [], [], []
    for k in range(n):
        name = GAUSSIAN[k % len(GAUSSIAN)]
        step = next((q for q in (0.1, 0.05) if f"steps of {q} mm" in name), STEP)
        found = found_in(recorded(kinds.PLAIN[name], [k]), step)
        for kept, one in zip((events, levels, tails), found, strict=True):
            kept.append(bool(one))
    case = f"Gaussian noise of {len(GAUSSIAN)} kinds"
    yield row(case, "events", events, "<= 1 %")
    yield row(case, "level_changes", levels, "<= 2 %")
    yield row(case, "heavy_tails", tails, "<= 2 %")
    for name, kind in TAILS.items():
        found = [found_in(recorded(kind, [k])) for k in range(n if name == "Student t4" else few)]
        yield row(name, "events", [bool(e) for e, _, _ in found], "<= 1 %")
        yield row(name, "heavy_tails", [bool(t) for _, _, t in found], "")


def detected(n: int) -> Iterator[Row]:
    for name, kind in BASE.items():
        plain = [recorded(kind, [k]) for k in range(n)]
        for lasts_s in (0.1, 0.3, 1.0):
            for size in (3, 5, 10):
                hits = [_near(*shocked(x, size, lasts_s, k)) for k, x in enumerate(plain)]
                yield row(
                    f"{name}: shock of {size} sigma, {lasts_s:g} s", "found", hits, "as before"
                )
        for size in (3, 5, 10):
            hits = [_near(*bumped(x, size, k)) for k, x in enumerate(plain)]
            yield row(f"{name}: marker bumped by {size} sigma", "found", hits, "as before")
        for factor in (1.2, 2.0):
            changed = kinds.levelled(kind, lambda t, by=factor: np.where(t > 0.5, by, 1.0))
            hits = [_near(recorded(changed, [k]), SECONDS / 2, 25.0) for k in range(n)]
            case = f"{name}: level {factor:g} times from the middle on"
            yield row(case, "found", hits, "as before")


def _near(position: np.ndarray, at: float, within_s: float = 2.0) -> bool:
    return any(abs(event.time_s - at) < within_s for event in found_in(position)[0])
