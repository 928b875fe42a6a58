"""Movement: still markers with many kinds of noise, and moved ones.

White noise of 0.05 mm, 100 Hz, ten minutes unless stated; sigma is that of one frame. A walk of
d mm/h deviates by d (rms) in an hour. "At 8b8d0af": the earlier rule (medians over a second that
span more than 2 mm) on the same recordings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy.signal import butter, lfilter, sosfiltfilt

from benchmarks.sentences import Row
from mocap_metrology.noise.motion.movement import movement
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.twin import Crump, Twin

RATE, SIGMA, N = 100.0, 0.05, 60_000
T = np.arange(N) / RATE


def _walk(rng, mm, n=N):
    return np.cumsum(rng.normal(size=n)) * mm / np.sqrt(3600 * RATE)


def _slow(rng, sigma, T_c, n=N):
    phi = np.exp(-1 / (T_c * RATE))
    return lfilter([sigma * np.sqrt(1 - phi**2)], [1, -phi], rng.normal(size=n))


def _flicker(rng, sigma):
    f = np.fft.rfftfreq(N, 1 / RATE)
    f[0] = f[1]
    made = np.fft.irfft(np.fft.rfft(rng.normal(size=N)) / np.sqrt(f))
    return sigma * made / made.std()


def _telegraph(rng):
    return SIGMA * (-1.0) ** np.cumsum(rng.random(N) < 1 / (30 * RATE))


def _filtered(rng):
    return sosfiltfilt(
        butter(4, 6, fs=RATE, output="sos"), _walk(rng, 5.0) + 1.0 * rng.normal(size=N)
    )


def _filled(rng):
    """Two in a hundred frames, a second each, on a straight line."""
    made = _walk(rng, 1.0) + SIGMA * rng.normal(size=N)
    for start in rng.integers(0, N - 101, 12):
        made[start : start + 100] = np.linspace(made[start], made[start + 99], 100)
    return made


def _noise(rng):
    return SIGMA * rng.normal(size=N)


def _later(rng):
    return rng.uniform(60, 540) < T


def _step(rng):
    return _noise(rng) + 5 * SIGMA * _later(rng)


def _push(rng):
    return _noise(rng) + 2.0 * _later(rng)


STILL = {
    "white": _noise,
    "walk of 0.255 mm/h": lambda r: _noise(r) + _walk(r, 0.255),
    "walk of 10 mm/h": lambda r: _noise(r) + _walk(r, 10.0),
    "flicker of 0.5 mm": lambda r: _noise(r) + _flicker(r, 0.5),
    "correlated, 1 mm, 30 s": lambda r: _noise(r) + _slow(r, 1.0, 30),
    "correlated, 1 mm, 300 s": lambda r: _noise(r) + _slow(r, 1.0, 300),
    "drift of 0.3 mm": lambda r: _noise(r) + 0.3 * T / 600,
    "warm-up of 0.3 mm, 60 s": lambda r: _noise(r) + 0.3 * np.exp(-T / 60),
    "warm-up of 1 mm, 300 s, walk": lambda r: _noise(r) + np.exp(-T / 300) + _walk(r, 0.255),
    "cycle of 10 min, 0.5 mm": lambda r: _noise(r) + 0.5 * np.sin(0.0105 * T + r.uniform(0, 6)),
    "Student t4": lambda r: SIGMA * r.standard_t(4, N),
    "telegraph of 2 sigma": lambda r: _noise(r) + _telegraph(r),
    "level doubles": lambda r: _noise(r) * (1 + (T > 300)),
    "walk of 5 mm/h, 1 mm white, Butterworth 6 Hz": _filtered,
    "2 % filled on straight lines": _filled,
}
MOVED = {
    "pushed by 2 mm": _push,
    "pushed by 2 mm, walk of 3 mm/h": lambda r: _push(r) + _walk(r, 3.0),
    "pushed by 2 mm, correlated 0.5 mm, 300 s": lambda r: _push(r) + _slow(r, 0.5, 300),
    "step of 5 sigma": _step,
    "step of 5 sigma, walk of 0.255 mm/h": lambda r: _step(r) + _walk(r, 0.255),
    "step of 5 sigma, drift of 0.3 mm": lambda r: _step(r) + 0.3 * T / 600,
    "step of 5 sigma, warm-up of 0.3 mm": lambda r: _step(r) + 0.3 * np.exp(-T / 60),
    "by 3 mm within 60 s": lambda r: _noise(r) + 3 * np.clip((T - r.uniform(60, 480)) / 60, 0, 1),
    "by 4 mm over all of it": lambda r: _noise(r) + 4 * T / 600,
    "sways by 3 mm, 0.3 Hz": lambda r: _noise(r) + 3 * np.sin(1.885 * T + r.uniform(0, 6)),
    "walks to and fro": lambda r: _noise(r) + 1000 * abs(T % 20 - 10) + 20 * np.sin(11.3 * T),
    "carried about": lambda r: _noise(r) + np.cumsum(_slow(r, 30.0, 1.0)) / RATE,
    "gait of 3 s": lambda r: (_noise(r) + 1200 * T + 20 * np.sin(11.3 * T))[:300],
}


def rows(n: int) -> Iterator[Row]:
    """Still ones first; the shock is S's, an event and no movement."""
    for reach, kinds in (("0", STILL), (">= 95 %", MOVED)):
        for number, (case, draw) in enumerate(kinds.items()):
            rng = np.random.default_rng([number, len(reach)])
            yield _row(case, ([draw(rng)] for _ in range(n)), reach, RATE)
    few, rng, frames = max(n // 5, 1), np.random.default_rng(9), round(9 * 3600 * RATE)
    drawn = ([_walk(rng, 0.255, frames) + SIGMA * rng.normal(size=frames)] for _ in range(few))
    yield _row("walk of 0.255 mm/h, nine hours", drawn, "0", RATE)
    for cameras in (2, 3, 4, 5):
        yield _row(f"twin of Bonita-{cameras}", _twins(n, "Bonita", cameras), "0", 120.0)
    shaken = _twins(n, "Vantage", 9, Crump(0.5, 4.0, 3.0, time_share=0.5))
    yield _row("twin of Vantage-9 with a shock", shaken, "0", 120.0)


def _row(
    case: str, drawn: Iterable[Sequence[np.ndarray]], reach: str, rate_hz: float = RATE
) -> Row:
    """How many recordings, of one coordinate or six, are said to move."""
    found = [any(movement(x, rate_hz, 2.0, 3600.0).moves for x in one) for one in drawn]
    return case, "reported as moving", len(found), reach, f"{sum(found)}"


def _twins(n: int, kind: str, cameras: int, shock: Crump | None = None) -> Iterator[np.ndarray]:
    """Of a published row, ten minutes."""
    for seed in range(n):
        models = published_row(kind, cameras)
        twin = Twin("moves", seed, models, duration_s=600.0, crump=shock)
        yield simulate(twin).position_mm.reshape(6, -1)
