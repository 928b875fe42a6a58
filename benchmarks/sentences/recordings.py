"""Whole recordings of kinds that labs make: what the findings say, from the file's values on.

Two markers, 10 min at 100 Hz, white noise of 0.02 mm a frame; the kind is in x1, or in all of a
marker where that is its nature. `named`: the finding of the kind is there; `false`: any finding
that the kind does not have.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from scipy import ndimage, signal
from scipy.interpolate import CubicSpline

from mocap_metrology.common.parallel import in_turn
from mocap_metrology.noise.diagnosis.fills import filled_frames
from mocap_metrology.noise.motion.exchange import put_right
from mocap_metrology.recording.clean import cleaned, exchanges
from mocap_metrology.recording.noise import allan_deviations, noise_coefficients, spectra
from mocap_metrology.recording.results import Table
from mocap_metrology.recording.verdict import Diagnosed, diagnosed
from mocap_metrology.settings import Settings

RATE, N = 100.0, 60_000
T = np.arange(N) / RATE
ORIGIN = {
    **{"recording": "r", "labels": ["A", "B"], "pairs": [[1, 2]], "frame_rate_hz": RATE},
    **{"resolution_mm": 4e-6, "resolution_kind": "float32", "n_filled_frames": {}},
}
Make = Callable[[np.random.Generator, np.ndarray], np.ndarray]  # of (6, N) white noise


def in_x1(wave: Callable[[np.random.Generator], np.ndarray]) -> Make:
    """Added to one coordinate."""

    def made(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
        x[0] += wave(rng)
        return x

    return made


def telegraph(rng: np.random.Generator) -> np.ndarray:
    ends = np.cumsum(rng.uniform(5, 120, 200))
    return 0.02 * rng.uniform(1, 3) * (np.searchsorted(ends, T) % 2)


def at_once(size: float, lasts_s: float, rng: np.random.Generator) -> np.ndarray:
    since = T - rng.uniform(120, 450)
    return size * ((since >= 0) & (since < lasts_s))


def recovering(rng: np.random.Generator) -> np.ndarray:
    since = T - rng.uniform(120, 400)
    return np.where(since > 0, 0.1 * np.exp(-np.maximum(since, 0) / rng.uniform(15, 40)), 0.0)


def fan(rng: np.random.Generator) -> np.ndarray:
    on = ((T + rng.uniform(0, 150)) % 150) < 90
    phase = rng.uniform(0, 2 * np.pi, 8)[((T + 60) // 150).astype(int)]
    return 0.03 * on * np.sin(2 * np.pi * 12.34 * T + phase)


def doors(rng: np.random.Generator) -> np.ndarray:
    since = (T - rng.uniform(0, 30)) % 30
    return 0.15 * np.exp(-since / 0.5) * np.sin(2 * np.pi * 4 * since)


def gain(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    return x * (1 + 0.25 * np.sin(2 * np.pi * (T / 240 + rng.uniform())))


def resampled(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    at = np.arange(N) * 100 / 120
    return np.array([np.interp(at, np.arange(N), row) for row in x])


def one_euro(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    share = 1 / (1 + RATE / (2 * np.pi * 1.2))
    start = signal.lfilter_zi([share], [1, share - 1])[None] * 0 * x[:, :1]
    return signal.lfilter([share], [1, share - 1], x, zi=start)[0]


def repeated(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    some = rng.random(N) < rng.uniform(0.01, 0.15)
    return x[:, np.maximum.accumulate(np.where(some, 0, np.arange(N)))]


def exchanged(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    x[3] += 60
    first = round(rng.uniform(100, 400) * RATE)
    there = slice(first, first + round(rng.uniform(5, 100) * RATE))
    x[:3, there], x[3:, there] = x[3:, there].copy(), x[:3, there].copy()
    return x


def several_levels(rng: np.random.Generator) -> np.ndarray:
    ends = np.cumsum(rng.uniform(10, 60, 200))
    positions = np.cumsum(rng.integers(1, 3, 200)) % 3
    return 0.03 * positions[np.searchsorted(ends, T, "right")]


def trucks(rng: np.random.Generator) -> np.ndarray:
    """Bursts at random times."""
    times = np.cumsum(rng.exponential(60, 40))
    return sum(
        0.1 * np.exp(-(((T - t) / 3) ** 2)) * np.sin(2 * np.pi * 3.1 * T + rng.uniform(0, 6))
        for t in times[times < T[-1]]
    )


def resonance(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    """An oscillator that white noise drives, in both markers."""
    f_0, damping = rng.uniform(3, 20), rng.uniform(0.01, 0.06)
    w_0 = 2 * RATE * np.tan(np.pi * f_0 / RATE)  # so that the bilinear transform leaves f_0
    b, a = signal.bilinear([w_0**2], [1, 2 * damping * w_0, w_0**2], RATE)
    shaken = signal.lfilter(b, a, rng.standard_normal(N))
    return x + np.tile([[1.0], [0.5], [0.2]], (2, 1)) * 0.02 * shaken / shaken.std()


def spline_fills(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    """Forty gaps of 15 to 60 frames of one marker, in steps of a micrometre."""
    for start in rng.integers(100, N - 200, 40):
        stop = start + rng.integers(15, 60)
        known = np.r_[start - 12 : start, stop : stop + 12]
        for axis in x[:3]:
            axis[start:stop] = CubicSpline(known, axis[known])(np.arange(start, stop))
    return np.round(x, 3)


# Drawn, findings of which one is the name, findings that may stand beside it
KINDS: dict[str, tuple[Make, set[str], set[str]]] = {
    "nothing": (lambda rng, x: x, set(), set()),
    "accelerating": (
        in_x1(lambda rng: 0.594 * np.expm1(T / 100) / np.expm1(6)),
        {"accelerating"},
        {"moves", "drift"},
    ),
    "two levels": (in_x1(telegraph), {"two_levels"}, {"event"}),
    "shift with recovery": (in_x1(recovering), {"shift"}, {"event", "moves"}),
    "step of 0.05 mm": (in_x1(partial(at_once, 0.05, 1e9)), {"step"}, {"event", "moves"}),
    "lift for 20 s": (in_x1(partial(at_once, 0.06, 20)), {"shift"}, {"event"}),
    "cycle of 420 s": (in_x1(lambda rng: 0.1 * np.sin(2 * np.pi * T / 420)), {"wander"}, set()),
    "cycle of 150 s": (in_x1(lambda rng: 0.05 * np.sin(2 * np.pi * T / 150)), {"cycle"}, {"line"}),
    "creep": (in_x1(lambda rng: 0.05 * np.log1p(T / rng.uniform(5, 30))), {"creep"}, set()),
    "warm-up and cycle": (
        in_x1(lambda rng: 0.2 * np.exp(-T / 150) + 0.05 * np.sin(2 * np.pi * T / 170)),
        {"warm_up", "cycle", "wander"},
        {"drift", "line"},
    ),
    "gain": (gain, {"level_changes"}, {"heavy_tails", "event"}),
    "fan on and off": (in_x1(fan), {"line"}, {"event", "level_changes"}),
    "doors": (in_x1(doors), {"recurring"}, {"event", "line", "heavy_tails"}),
    "resampled": (resampled, {"resampled"}, {"heavy_tails"}),
    "repeated": (repeated, {"repeated"}, {"heavy_tails"}),
    "one-euro": (one_euro, {"smoothed"}, set()),
    "median of five": (
        lambda rng, x: ndimage.median_filter(x, (1, 5)),
        {"running_median"},
        {"heavy_tails", "low_pass"},
    ),
    "exchanged": (exchanged, {"exchanged"}, set()),
    "several levels": (in_x1(several_levels), {"levels", "two_levels"}, set()),
    "three steps": (
        in_x1(lambda rng: 0.04 * sum(rng.uniform(t, t + 100) < T for t in (50, 250, 450))),
        {"step"},
        {"event", "moves"},
    ),
    "fourth power": (in_x1(lambda rng: 0.6 * (T / 600) ** 4), {"accelerating"}, {"moves"}),
    "trucks": (in_x1(trucks), {"event"}, {"heavy_tails", "line"}),
    "resonance": (resonance, {"resonance"}, set()),
    "spline fills": (spline_fills, {"gap_filled"}, set()),
}


def told(x: np.ndarray, rate: float = RATE, step: float = 0.0) -> Diagnosed:
    """Of (6, n) values in mm; step: of the file, where it is not that of float32."""
    position = x.astype(np.float32).reshape(2, 3, -1)
    swaps = exchanges(put_right(["A", "B"], position))
    step = step or ORIGIN["resolution_mm"]
    filled = filled_frames(position, step)
    position[np.repeat(filled[:, None], 3, axis=1)] = np.nan
    own = {"exchanged": swaps, "resolution_mm": step, "frame_rate_hz": rate}
    own["n_filled_frames"] = dict(zip("AB", filled.sum(axis=1).tolist(), strict=True))
    names = [f"{axis}{k}_mm" for k in (1, 2) for axis in "xyz"]
    columns = dict(zip(names, position.reshape(6, -1), strict=True))
    frame = np.arange(x.shape[1], dtype=np.int32)
    raw = Table({"frame": frame} | columns, ORIGIN | own)
    settings = Settings(noise={"estimators": ("likelihood",)})
    clean = cleaned(raw, settings.hampel)[0]
    allan = allan_deviations(clean.in_mm(), clean.origin, settings.allan, in_turn)
    noise = noise_coefficients(raw, allan.columns, settings, None, in_turn, lambda *_: None)[0]
    psd = spectra(clean.in_mm(), clean.origin, settings.psd)
    return diagnosed(raw, psd, noise, settings)


def codes(kind: str, seed: int) -> Counter[str]:
    """Findings of one recording."""
    rng = np.random.default_rng([list(KINDS).index(kind), seed])
    values = KINDS[kind][0](rng, 0.02 * rng.standard_normal((6, N)))
    if kind != "exchanged":
        values[4] += 500
    found = told(values, step=1e-3 if kind == "spline fills" else 0.0).findings
    return Counter(one.code for one in found)


def rows(runs: int) -> Iterator[tuple[str, str, int, str, str, str]]:
    """For docs/accuracy."""
    for kind, (_, names, beside) in KINDS.items():
        named = wrong = 0
        which: Counter[str] = Counter()
        for run in range(runs):
            said = set(codes(kind, run))
            named += bool(said & names) or not names
            wrong += bool(said - names - beside)
            which.update(said - names - beside)
        yield kind, "named", runs, ">= 0.7", "", f"{named / runs:.2f}"
        listed = ", ".join(f"{code} {count}" for code, count in which.items())
        yield kind, "false", runs, "<= 0.03", "", f"{wrong / runs:.2f} {listed}".strip()
