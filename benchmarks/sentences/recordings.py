"""Whole recordings of kinds that labs make: what the findings say, from the file's values on.

Two markers, 10 min at 100 Hz, white noise of 0.02 mm a frame; the kind is in x1, or in all of a
marker where that is its nature. `named`: the finding of the kind is there; `false`: any finding
that the kind does not have.
"""

from __future__ import annotations

from collections.abc import Iterator
from tempfile import TemporaryDirectory

import numpy as np
from scipy import ndimage, signal
from scipy.interpolate import CubicSpline

from benchmarks.sentences import Row
from benchmarks.sentences import _waves as w
from benchmarks.sentences._waves import in_x1, kind
from mocap_metrology.common.parallel import in_turn
from mocap_metrology.noise.diagnosis.fills import filled_frames
from mocap_metrology.noise.motion.exchange import put_right
from mocap_metrology.recording.clean import cleaned, exchanges
from mocap_metrology.recording.noise import allan_deviations, noise_coefficients, spectra
from mocap_metrology.recording.results import Results, Table
from mocap_metrology.recording.verdict import diagnose
from mocap_metrology.settings import Settings

ORIGIN = {
    **{"recording": "r", "source": "measured", "labels": ["A", "B"], "pairs": [[1, 2]]},
    **{"frame_rate_hz": 100.0, "resolution_mm": 4e-6, "resolution_kind": "float32"},
    "n_filled_frames": {},
}


def fan(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    on = ((t + rng.uniform(0, 150)) % 150) < 90
    phase = rng.uniform(0, 2 * np.pi, 8)[((t + 60) // 150).astype(int)]
    return 0.03 * on * np.sin(2 * np.pi * 12.34 * t + phase)


def one_euro(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    share = 1 / (1 + 100 / (2 * np.pi * 1.2))
    return signal.lfilter([share], [1, share - 1], x)


def repeated(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    some = rng.random(t.size) < rng.uniform(0.01, 0.15)
    return x[:, np.maximum.accumulate(np.where(some, 0, np.arange(t.size)))]


def exchanged(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[3] += 60
    first = round(rng.uniform(100, 400) * 100)
    there = slice(first, first + round(rng.uniform(5, 100) * 100))
    x[:3, there], x[3:, there] = x[3:, there].copy(), x[:3, there].copy()
    return x


def trucks(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    """Bursts at random times."""
    times = np.cumsum(rng.exponential(60, 40))
    return sum(
        0.1 * np.exp(-(((t - at) / 3) ** 2)) * np.sin(2 * np.pi * 3.1 * t + rng.uniform(0, 6))
        for at in times[times < t[-1]]
    )


def oscillator(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    """Driven by white noise."""
    f_0, damping = rng.uniform(3, 20), rng.uniform(0.01, 0.06)
    w_0 = 200 * np.tan(np.pi * f_0 / 100)  # so that the bilinear transform leaves f_0
    b, a = signal.bilinear([w_0**2], [1, 2 * damping * w_0, w_0**2], 100)
    shaken = signal.lfilter(b, a, rng.standard_normal(t.size))
    return 0.02 * shaken / shaken.std()


def spline_fills(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Forty gaps of 15 to 60 frames of one marker, in steps of a micrometre."""
    for start in rng.integers(100, t.size - 200, 40):
        stop = start + rng.integers(15, 60)
        known = np.r_[start - 12 : start, stop : stop + 12]
        for axis in x[:3]:
            axis[start:stop] = CubicSpline(known, axis[known])(np.arange(start, stop))
    return np.round(x, 3)


KINDS: dict[str, w.Kind] = {
    "nothing": kind(lambda r, t, x: x),
    "accelerating": in_x1(
        lambda r, t: 0.594 * np.expm1(t / 100) / np.expm1(6), "accelerating", "moves drift"
    ),
    "two levels": in_x1(w.two_levels(200), "two_levels", "event"),
    "shift with recovery": in_x1(w.recovering(120, 400), "shift", "event moves"),
    "step of 0.05 mm": in_x1(w.step(0.05, 120, 450), "step", "event moves"),
    "lift for 20 s": in_x1(w.after(120, 450, lambda r, s: 0.06 * (s < 20)), "shift", "event"),
    "cycle of 420 s": in_x1(w.sine(0.1, 1 / 420), "wander"),
    "cycle of 150 s": in_x1(w.sine(0.05, 1 / 150), "cycle", "line"),
    "creep": in_x1(w.creep, "creep"),
    "warm-up and cycle": in_x1(
        w.summed(w.decay(0.2, 150), w.sine(0.05, 1 / 170)), "warm_up cycle wander", "drift line"
    ),
    "gain": kind(
        lambda r, t, x: x * (1 + 0.25 * np.sin(2 * np.pi * (t / 240 + r.uniform()))),
        "level_changes",
        "heavy_tails event",
    ),
    "fan on and off": in_x1(fan, "line", "event level_changes"),
    "doors": in_x1(
        lambda r, t: w.ringing((t - r.uniform(0, 30)) % 30, 0.15, 0.5, 4),
        "recurring",
        "event line heavy_tails",
    ),
    "resampled": kind(
        lambda r, t, x: np.array([np.interp(t / 1.2, t, row) for row in x]),
        "resampled",
        "heavy_tails",
    ),
    "repeated": kind(repeated, "repeated", "heavy_tails"),
    "one-euro": kind(one_euro, "smoothed"),
    "median of five": kind(
        lambda r, t, x: ndimage.median_filter(x, (1, 5)), "running_median", "heavy_tails low_pass"
    ),
    "exchanged": kind(exchanged, "exchanged", placed=False),
    "several levels": in_x1(w.dwelling(10, 60, [0.0, 0.03, 0.06], 200), "levels two_levels"),
    "three steps": in_x1(
        lambda r, t: 0.04 * sum(r.uniform(at, at + 100) < t for at in (50, 250, 450)),
        "step",
        "event moves",
    ),
    "fourth power": in_x1(lambda r, t: 0.6 * (t / 600) ** 4, "accelerating", "moves"),
    "trucks": in_x1(trucks, "event", "heavy_tails line"),
    "resonance": kind(w.along([1.0, 0.5, 0.2], oscillator), "resonance"),
    "spline fills": kind(spline_fills, "gap_filled", step_mm=1e-3),
}


def said_of(kinds: dict[str, w.Kind], name: str, *seed: int) -> set[str]:
    """Findings of one recording of a kind."""
    one = kinds[name]
    values = one.drawn(np.random.default_rng([list(kinds).index(name), *seed]))
    if one.placed:
        values[4] += 500
    position = values.astype(np.float32).reshape(2, 3, -1)
    swaps = exchanges(put_right(["A", "B"], position))
    step = one.step_mm or ORIGIN["resolution_mm"]
    filled = filled_frames(position, step)
    position[np.repeat(filled[:, None], 3, axis=1)] = np.nan
    own = {"exchanged": swaps, "resolution_mm": step, "frame_rate_hz": one.rate}
    own["n_filled_frames"] = dict(zip("AB", filled.sum(axis=1).tolist(), strict=True))
    names = [f"{axis}{k}_mm" for k in (1, 2) for axis in "xyz"]
    columns = dict(zip(names, position.reshape(6, -1), strict=True))
    frame = np.arange(values.shape[1], dtype=np.int32)
    raw = Table({"frame": frame} | columns, ORIGIN | own)
    settings = Settings(noise={"estimators": ("likelihood",)})
    clean = cleaned(raw, settings.hampel)[0]
    allan = allan_deviations(clean.in_mm(), clean.origin, settings.allan, in_turn)
    with TemporaryDirectory() as folder:
        results = Results(folder)
        results.raw = raw
        results.noise = noise_coefficients(
            raw, allan.columns, settings, None, in_turn, lambda *_: None
        )[0]
        results.psd = spectra(clean.in_mm(), clean.origin, settings.psd)
        return {found.code for found in diagnose(results, settings).findings}


def rows(runs: int) -> Iterator[Row]:
    """(case, statistic, runs, reach, measured)."""
    return w.rows_of(KINDS, lambda name, run: said_of(KINDS, name, run), runs)
