"""Offsets of two clocks at which a tracked board and markers on it move alike.

The normalised correlation of both speeds over what is known of both, at each lag (Padfield 2012).
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.calibrate.superpose import kabsch
from mocap_metrology.lighthouse.track.markers import Alignment, Markers, Tracked

CANDIDATES = 6  # offsets that are tried
LEAST_S = 3.0  # of common time
APART_S = 0.25  # between two offsets that are tried
SMOOTHED = 5  # moments of a speed
LEVERS_M = 0.12 * np.vstack([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


def offsets(track: Tracked, seen: Markers, known: np.ndarray) -> list[Alignment]:
    """Where the speeds of both are most alike: rough alignments, the best first. The speed is that
    of the board, and of places some way from it, as the markers may be."""
    step = float(np.median(np.diff(track.time_s)))
    grid = step * np.arange(int(seen.duration_s / step) + 1, dtype=np.float64)
    places, _ = seen.at(grid)
    its, n = speed(places.mean(axis=1), step), track.time_s.size
    own = [track.t_m + track.R @ lever for lever in LEVERS_M]
    likely = []
    for place in own:
        r, count = _correlation(speed(place, step), its)
        z = np.arctanh(np.clip(r, -0.999, 0.999)) * np.sqrt(count)
        likely.append(np.where(count * step >= LEAST_S, z, -np.inf))
    lever, score = np.argmax(likely, axis=0), np.max(likely, axis=0)
    found: list[Alignment] = []
    middle = float(np.median(track.time_s))
    for _ in range(CANDIDATES):
        best = int(np.argmax(score))
        if not np.isfinite(score[best]):
            break
        lag, which = best - (n - 1), int(lever[best])
        near = round(APART_S / step)
        score[max(best - near, 0) : best + near + 1] = -np.inf
        offset = lag * step - float(track.time_s[0])
        places, _ = seen.at(track.time_s + offset)
        both = known & np.isfinite(places).all(axis=(1, 2))
        if both.sum() * step < LEAST_S:
            continue
        A, b = kabsch(own[which][both], places[both].mean(axis=1))
        levers = np.tile(LEVERS_M[which], (len(seen.labels), 1))
        found.append(Alignment(A, b, offset, 0.0, levers, middle))
    return found


def speed(place: Floats, step_s: float) -> Floats:
    """Speed (n,), the mean of some moments of which most are known; NaN at gaps."""
    speed = np.linalg.norm(np.gradient(place, step_s, axis=0), axis=1)
    known, around = np.isfinite(speed), np.ones(SMOOTHED)
    count = np.convolve(known, around, mode="same")
    total = np.convolve(np.where(known, speed, 0.0), around, mode="same")
    return np.where(count > SMOOTHED / 2, total / np.maximum(count, 1), np.nan)


def _correlation(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Normalised correlation of b, later by each lag from 1 - len(a) on, with a, over the pairs
    that are known of both; and how many these are."""
    from scipy.signal import correlate

    ok = [np.isfinite(x) for x in (a, b)]
    x, y = (np.where(k, v - np.nanmean(v), 0.0) for k, v in zip(ok, (a, b), strict=True))

    def at_lags(first: Floats, second: Floats) -> Floats:
        return np.asarray(correlate(second, first, mode="full", method="fft"))

    w, v = (k.astype(float) for k in ok)
    n = np.round(at_lags(w, v))
    few = n < SMOOTHED
    n_ = np.where(few, 1.0, n)
    sx, sy = at_lags(x, v), at_lags(w, y)
    vx, vy = at_lags(x**2, v) - sx**2 / n_, at_lags(w, y**2) - sy**2 / n_
    floor = 1e-9 * max(float(x @ x), float(y @ y), 1e-30)
    r = (at_lags(x, y) - sx * sy / n_) / np.sqrt(np.maximum(vx, floor) * np.maximum(vy, floor))
    return np.where(few, -1.0, r), n
