"""Disturbances of a diagnosis in twelve doses, each 1.3 times the one before, from none that is
found to all: a threshold that moves shows. Brief recordings, so that a dose costs milliseconds."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from scipy import ndimage, signal

from mocap_metrology.noise.diagnosis.fills import filled
from mocap_metrology.noise.diagnosis.findings import findings_of
from mocap_metrology.noise.diagnosis.levels import changes, trends
from mocap_metrology.noise.diagnosis.recording import diagnose
from mocap_metrology.noise.diagnosis.records import Recording
from mocap_metrology.noise.diagnosis.sides import blocks
from mocap_metrology.noise.diagnosis.signatures import signature
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.motion.exchange import put_right
from mocap_metrology.noise.motion.movement import movement

from .digest import Flat, flat

DOSES = 1.3 ** np.arange(12)
NAMES = [f"{axis}{k}" for k in range(1, 5) for axis in "xyz"]
Make = Callable[[np.random.Generator, np.ndarray, np.ndarray], np.ndarray]  # x of sd 1 (12, n), t


def step(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x + 0.3 * DOSES[:, None] * (t > 0.45 * t[-1])


def loud(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x * (1 + 0.6 * DOSES[:, None] * (abs(t / t[-1] - 0.4) < 0.03))


def outliers(length: int, rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    for k, dose in enumerate(DOSES):
        for at in range(100 + 9 * k, t.size - 20, 230):
            x[k, at : at + length] += 2.0 * dose
    return x


def tails(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x * np.where(rng.random(x.shape) < 0.01 * DOSES[:, None], 3.0, 1.0)


def line(f_0: float, rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x + 0.06 * DOSES[:, None] * np.sin(2 * np.pi * f_0 * t)


def broad(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """A line whose frequency varies, by more and more."""
    wave = np.cumsum(np.sin(2 * np.pi * t / 7)) * (t[1] - t[0])
    return x + np.sin(2 * np.pi * 11.0 * t + 0.5 * DOSES[:, None] * wave)


def resonance(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    b, a = signal.butter(1, [0.11, 0.13], "band")
    return x + 1.0 * DOSES[:, None] * signal.lfilter(b, a, 9 * rng.standard_normal(x.shape))


def pulses(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x + 0.5 * DOSES[:, None] * ((t % 0.9) < 0.06)


def passed(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    for k, dose in enumerate(DOSES):
        x[k] = signal.sosfiltfilt(signal.butter(2, 0.045 * dose, output="sos"), x[k])
    return x


def means(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return np.array([ndimage.uniform_filter1d(row, k + 1) for k, row in enumerate(x)])


def medians(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Of more and more of the frames."""
    of_five = ndimage.median_filter(x, (1, 5))
    return np.where(t < 0.04 * DOSES[:, None] * t[-1], of_five, x)


def held(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """All axes of a marker repeat their frame before, more and more often."""
    for k in range(4):
        again = rng.random(t.size) < 2e-4 * 3.0**k
        x[3 * k : 3 * k + 3] = x[3 * k : 3 * k + 3, np.maximum.accumulate(
            np.where(again, 0, np.arange(t.size))
        )]  # fmt: skip
    return x


def resampled(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    n = np.arange(t.size)
    return np.array([np.interp(n * (0.4 + 0.05 * k), n, row) for k, row in enumerate(x)])


def rounded(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Noise of less than a step to more, of a recording in steps."""
    return np.round(0.1 * DOSES[:, None] * x)


# The disturbance, frames, frames per second, step of the file in mm
KINDS: dict[str, tuple[Make, int, float, float]] = {
    "steps": (step, 2000, 100.0, 0.0),
    "loud seconds": (loud, 2000, 50.0, 0.0),
    "outliers": (partial(outliers, 1), 2000, 100.0, 0.0),
    "threes of outliers": (partial(outliers, 3), 2000, 100.0, 0.0),
    "tails": (tails, 9600, 480.0, 0.0),
    "line": (partial(line, 7.3), 2000, 100.0, 0.0),
    "folded mains": (partial(line, 20.0), 2000, 120.0, 0.0),
    "broad line": (broad, 2000, 100.0, 0.0),
    "resonance": (resonance, 2000, 100.0, 0.0),
    "pulses": (pulses, 2000, 100.0, 0.0),
    "low passes": (passed, 2000, 120.0, 0.0),
    "moving means": (means, 2000, 120.0, 0.0),
    "medians": (medians, 2400, 125.0, 0.0),
    "repeated frames": (held, 2000, 100.0, 0.0),
    "resampled": (resampled, 2400, 125.0, 0.0),
    "rounded": (rounded, 2000, 100.0, 0.02),
}


def doses(kind: str, folder: Path | None = None) -> Flat:
    make, n, rate, step_mm = KINDS[kind]
    rng = np.random.default_rng([len(kind), *kind.encode()])
    t = np.arange(n) / rate
    x = 0.02 * make(rng, rng.standard_normal((12, n)), t) + 500.0 + 100.0 * np.arange(12)[:, None]
    recording = Recording(
        dict(zip(NAMES, x, strict=True)), [*"ABCD"], [(1, 2), (3, 4)], rate, step_mm, "decimals"
    )
    spectra = [(name, welch(np.nan_to_num(x[k], nan=500.0), rate)) for k, name in enumerate(NAMES)]
    psd = {
        "series": np.repeat(NAMES, [one.f_hz.size for _, one in spectra]),
        "f_hz": np.concatenate([one.f_hz for _, one in spectra]),
        "psd_mm2_hz": np.concatenate([one.psd for _, one in spectra]),
        "n_segments": np.concatenate(
            [np.full(one.f_hz.size, one.n_segments) for _, one in spectra]
        ),
    }
    found = diagnose(recording, [], psd)
    rows = [one.as_dict() for one in findings_of(recording, found, [])]
    return dict(flat({"findings": rows, "diagnosis": found}))


SLOW_N, SLOW_RATE = 1200, 12.0
WAITS = np.random.default_rng(5).random(40)
SLOW: dict[str, Callable[[np.ndarray], np.ndarray]] = {  # of time, 0 to 1
    "drift": lambda t: 0.4 * t,
    "warm-up": lambda t: 0.6 * np.exp(-t / 0.12),
    "creep": lambda t: 0.3 * np.log1p(t / 0.02),
    "acceleration": lambda t: 0.8 * t**3,
    "slowing": lambda t: 0.6 * np.sqrt(t),
    "cycle": lambda t: 0.25 * np.sin(2 * np.pi * 4.3 * t),
    "step": lambda t: 0.3 * (t > 0.37),
    "shift": lambda t: 0.4 * (abs(t - 0.5) < 0.12),
    "fading shift": lambda t: 0.5 * (t > 0.3) * np.exp(-np.maximum(t - 0.3, 0) / 0.08),
    "two levels": lambda t: 0.8 * (np.searchsorted(np.cumsum(0.02 + 0.1 * WAITS), t) % 2),
    "levels": lambda t: 0.8 * (np.searchsorted(np.cumsum(0.04 + 0.1 * WAITS), t) % 3),
    "walk": lambda t: 0.012 * np.cumsum(np.random.default_rng(6).standard_normal(t.size)),
}


def slow(kind: str, folder: Path | None = None) -> Flat:
    """A curve under white noise of sd 1, in four doses."""
    noise = np.random.default_rng([7, *kind.encode()]).standard_normal(SLOW_N)
    curve = SLOW[kind](np.arange(SLOW_N) / SLOW_N)
    return dict(flat({f"{k}": signature(noise + 1.6**k * curve, SLOW_RATE) for k in range(4)}))


def of_levels() -> Flat:
    """Noise that grows, comes and goes, and is another from a moment on; 240 s."""
    rng, t = np.random.default_rng(8), np.arange(12_000) / 12_000
    curves = {"grows": t, "comes": np.sin(np.pi * t), "at once": t > 0.4, "wavy": np.sin(40 * t)}
    found: Flat = {}
    for name, curve in curves.items():
        noise = rng.standard_normal((12, t.size)) * np.exp(0.03 * DOSES[:, None] * curve)
        own = {str(k): blocks(row, 50.0) for k, row in enumerate(noise)}
        away = np.zeros(240, bool)
        away[100:106] = True
        found[f"{name}: changes"] = changes(own, away, 60.0, 0.01)
        found[f"{name}: trends"] = trends(own, away, [])
        found[f"{name}: trends beside a step"] = trends(own, away, [96.0])
    return dict(flat(found))


def of_fills() -> Flat:
    """Lines, parabolas and quintics of 3 to 24 frames in place of noise; files of several steps."""
    found: Flat = {}
    for step_mm in (0.0, 0.01, 0.05, 0.2, 0.4):
        x = np.random.default_rng(9).standard_normal((3, 6000))
        for degree, row in zip((1, 3, 5), x, strict=True):
            for k, length in enumerate(range(3, 25)):
                at = np.arange(200 + 230 * k, 200 + 230 * k + length + 2)
                nodes = np.linspace(at[0], at[-1], degree + 1)
                row[at] = np.polyval(np.polyfit(nodes - at[0], np.sin(nodes), degree), at - at[0])
        if step_mm:
            x = np.round(x / step_mm) * step_mm
        found |= {f"{step_mm} {k}": np.flatnonzero(filled(row, step_mm)) for k, row in enumerate(x)}
    return {key: "".join(f"{n} " for n in value) for key, value in found.items()}


def of_movement() -> Flat:
    """Jumps, ramps, walks and shakes of a marker, at 100 Hz for 60 s and for 3 s."""
    found: Flat = {}
    for n in (6000, 300):
        rng, t = np.random.default_rng(10), np.arange(n) / n
        kinds = {
            "jump": (t > 0.45) * 1.0,
            "two jumps": (t > 0.3) * 1.0 + 0.6 * (t > 0.7),
            "ramp": 4 * t,
            "bend": 4 * np.maximum(t - 0.5, 0),
            "shake": np.exp(-(((t - 0.5) / 0.05) ** 2)),
            "swing": np.sin(9 * t),
            "walk": np.cumsum(rng.standard_normal(n)) / math.sqrt(n),
        }
        for name, curve in kinds.items():
            for k, dose in enumerate(1.3 ** np.arange(-4, 14)):
                values = 0.05 * rng.standard_normal(n) + 0.1 * dose * curve
                found[f"{n} {name} {k}"] = movement(values, 100.0, 0.5, 40.0, 0.02)
    return dict(flat(found))


def of_exchanges() -> Flat:
    """Two markers 100 apart, labels exchanged for some frames, with noise from none to much."""
    found: Flat = {}
    for k, noise in enumerate(0.5 * DOSES):
        x = noise * np.random.default_rng(11).standard_normal((3, 3, 500))
        x += np.array([0.0, 100.0, 500.0])[:, None, None] * np.array([1.0, 0, 0])[:, None]
        x[:2, :, 100:130] = x[1::-1, :, 100:130].copy()
        x[2, :, 7] = np.nan
        found[f"{k}: "] = put_right(["A", "B", "C"], x)
    return dict(flat(found))


PARTS: dict[str, Callable[[], Flat]] = {
    "levels of noise": of_levels,
    "fills": of_fills,
    "movement": of_movement,
    "exchanges": of_exchanges,
}
CASES: dict[str, Callable[..., Flat]] = {
    **{f"doses of {kind}": partial(doses, kind) for kind in KINDS},
    **{f"doses of a {kind}": partial(slow, kind) for kind in SLOW},
    **{f"doses of {kind}": lambda folder, f=f: f() for kind, f in PARTS.items()},
}
