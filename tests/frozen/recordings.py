"""Recordings of many kinds, each written in another format, and all numbers that come of them."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from scipy import signal

from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.recording.clean import Entry, clean
from mocap_metrology.recording.noise import noise
from mocap_metrology.recording.verdict import diagnose, verdict
from mocap_metrology.settings import Settings
from tests.io.text import text_files as text

from .digest import Flat, of_folder

Make = Callable[[np.random.Generator, np.ndarray, np.ndarray], np.ndarray]  # x (6, n), t
RATE = 100.0
START = np.array([300.0, -200.0, 1000.0, 620.0, 160.0, 1100.0])
SETTINGS = Settings(noise={"estimators": ("likelihood",)})
WITH_S = Settings()  # with S's estimator, which takes as long as all the rest


def walk(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x + np.cumsum(8e-4 * rng.standard_normal(x.shape), axis=1)


def flicker(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    n = t.size
    shape = np.sqrt(1 / np.maximum(np.arange(n // 2 + 1), 1))
    return x + 0.03 * np.fft.irfft(np.fft.rfft(rng.standard_normal(x.shape)) * shape, n) * 20


def correlated(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x + signal.lfilter([0.004], [1, -0.98], rng.standard_normal(x.shape))


def events(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """A knock with its ring, a step, a shift that recovers, outliers and gaps."""
    since = t - 41.0
    ring = (since > 0) * np.exp(-np.maximum(since, 0) / 0.6) * np.sin(40 * since)
    x[:3] += 0.8 * ring
    x[4] += 0.12 * (t > 97)
    x[1] += np.where(t > 150, 0.3 * np.exp(-np.maximum(t - 150, 0) / 12), 0)
    some = rng.random(x.shape) < 4e-4
    x[some] += rng.choice([-1, 1], some.sum()) * rng.exponential(0.6, some.sum())
    x[:3, 12_000:12_150] = np.nan
    x[3:, rng.random(t.size) < 0.01] = np.nan
    return x


def lines(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Lines steady, of a fan that goes on and off, of wandering frequency, at Nyquist."""
    x[0] += 0.02 * np.sin(2 * np.pi * 12.34 * t)
    x[2] += 0.03 * (t % 100 < 60) * np.sin(2 * np.pi * 7.1 * t)
    x[3] += 0.02 * np.sin(2 * np.pi * (21.0 * t + 0.4 * np.sin(t / 15)))
    x[5] += 0.01 * (-1.0) ** np.arange(t.size)
    return x


def slow(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Warm-up, drift, cycle, two levels, creep, growth."""
    x[0] += 0.4 * np.exp(-t / 60)
    x[1] += 1e-3 * t
    x[2] += 0.08 * np.sin(2 * np.pi * t / 75)
    x[3] += 0.05 * (np.searchsorted(np.cumsum(rng.uniform(5, 40, 60)), t) % 2)
    x[4] += 0.05 * np.log1p(t / 10)
    x[5] += 0.6 * (t / t[-1]) ** 4
    return x


def levels(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return x * (1 + 0.5 * np.sin(2 * np.pi * t / 120)) * np.where(t < 200, 1.0, 1.6)


def repeated(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    kept = np.maximum.accumulate(np.where(rng.random(t.size) < 0.08, 0, np.arange(t.size)))
    return x[:, kept]


def filled(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    for first in rng.integers(100, t.size - 300, 25):
        last = first + rng.integers(20, 80)
        x[:3, first:last] = np.linspace(x[:3, first], x[:3, last], last - first, axis=1)
    return x


def shaken(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """A tripod that rings at 6 Hz, doors every 30 s."""
    b, a = signal.butter(1, [5.8, 6.2], "band", fs=RATE)
    x += 0.3 * signal.lfilter(b, a, rng.standard_normal(t.size))
    since = t % 30
    x[1] += 0.2 * np.exp(-since / 0.4) * np.sin(25 * since)
    return x


def exchanged(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    there = slice(9_000, 11_000)
    start = START[:, None]
    x = x + start
    x[:3, there], x[3:, there] = x[3:, there].copy(), x[:3, there].copy()
    return x - start


def coarse(rng: np.random.Generator, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    return np.round((x + START[:, None]) / 0.05) * 0.05 - START[:, None]


def c3d(path: Path, position: np.ndarray, **keys: object) -> Path:
    """position (frames, markers, 3)"""
    path = path.with_suffix(".c3d")
    labels = [*"AB"][: position.shape[1]]
    write_c3d(path, labels, RATE, [position.astype(np.float32)], len(position), **keys)
    return path


def typed(kind: Callable[..., str], suffix: str, path: Path, position: np.ndarray) -> Path:
    said = kind([*"AB"][: position.shape[1]], RATE, position)
    return text.make(path.parent, f"{path.name}.{suffix}", said)


TRC, MOTIVE = partial(typed, text.trc, "trc"), partial(typed, text.motive, "csv")
QUALISYS, NEXUS = partial(typed, text.qualisys, "tsv"), partial(typed, text.nexus, "csv")
TABLE, NDI = partial(typed, text.table, "csv"), partial(typed, text.first_principles, "tsv")
# Kind, format, sd of the white noise of a frame in mm, seconds
KINDS: dict[str, tuple[Make, Callable[..., Path], float, float]] = {
    "white": (lambda rng, x, t: x, TRC, 0.02, 60), "walk": (walk, c3d, 0.02, 240),
    "flicker": (flicker, MOTIVE, 0.02, 180), "correlated": (correlated, NEXUS, 0.03, 180),
    "events": (events, c3d, 0.02, 240), "lines": (lines, c3d, 0.02, 240),
    "slow": (slow, c3d, 0.02, 300), "levels": (levels, TABLE, 0.02, 240),
    "repeated": (repeated, NDI, 0.03, 120), "filled": (filled, QUALISYS, 0.02, 120),
    "shaken": (shaken, c3d, 0.02, 150), "exchanged": (exchanged, c3d, 0.03, 180),
    "coarse": (coarse, c3d, 0.02, 120), "brief": (lambda rng, x, t: x, c3d, 0.1, 2),
}  # fmt: skip
# With the first marker alone, as the second would be disturbed alike
ALONE = ("walk", "flicker", "correlated", "levels", "repeated", "filled", "shaken", "coarse")


def recording(kind: str, folder: Path) -> Flat:
    """From the file to the verdict, without figures."""
    make, write, sigma, seconds = KINDS[kind]
    markers = [*"AB"][: 1 if kind in ALONE else 2]
    rng = np.random.default_rng([len(kind), *kind.encode()])
    t = np.arange(round(seconds * RATE)) / RATE
    x = make(rng, sigma * rng.standard_normal((6, t.size)), t) + START[:, None]
    path = write(folder / kind, x.T.reshape(-1, 2, 3)[:, : len(markers)])
    results = folder / "results"
    origin = {"recording": kind, "source": "measured"}
    settings = WITH_S if kind == "brief" else SETTINGS
    steps(results, Entry([str(path)], markers), origin, settings)
    return of_folder(results)


def steps(
    results: Path, entry: Entry, origin: dict, settings: Settings, judged: bool = True
) -> None:
    """judged: to the verdict, else up to the noise."""
    results.mkdir()
    found = clean(entry, origin | {"twin": None}, settings, results, tell=lambda *_: None)
    noise(found, settings)
    if not judged:
        return
    diagnose(found, settings)
    named = {"recording": origin["recording"], "group": "g", "twin": None}
    verdict(found, named | {"camera_type": "", "n_cameras": None}, settings)
