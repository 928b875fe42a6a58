"""Recordings as laboratories make them, through files and all steps: what is said that is not so.

Two markers, 5 min at 50 Hz or as the kind has it, white noise of 0.02 mm a frame, in a C3D file. `named`,
`false`: as in `unforeseen`; a verdict `good` of a recording that is not is false too, and so is a
failure.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage, signal

from benchmarks.sentences._kinds import coloured, gauss_markov, walk
from benchmarks.sentences.unforeseen import SLOW, WHITE, Make, Noise, dwelling, in_x1, of_noise
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.recording.analyse import origin
from mocap_metrology.recording.clean import Entry, clean
from mocap_metrology.recording.noise import noise
from mocap_metrology.recording.verdict import diagnose, verdict
from mocap_metrology.settings import Settings

SETTINGS = Settings(noise={"estimators": ("likelihood",)}, second_opinion=False)
PLACES = np.array([812.0, -430.0, 1105.0, 1312.0, -415.0, 1098.0])  # mm, of two markers
LOUD = "event heavy_tails level_changes"  # that the noise changes in time, in any form


@dataclass(frozen=True)
class Kind:
    """names, beside: as in `unforeseen`; good: whether its verdict may be; unit: of the file."""

    make: Make
    names: frozenset[str]
    beside: frozenset[str]
    rate: float = 50.0
    seconds: float = 300.0
    markers: int = 2
    good: bool = True
    unit: str = "mm"
    places: bool = True

    def drawn(self, rng: Noise) -> np.ndarray:
        """(3 markers, n) in units of the file."""
        t = np.arange(round(self.seconds * self.rate)) / self.rate
        x = WHITE * rng.standard_normal((3 * self.markers, t.size))
        return self.make(rng, t, x)


def kind(make: Make, names: str = "", beside: str = "", **how: float | bool | str) -> Kind:
    return Kind(make, frozenset(names.split()), frozenset(beside.split()), **how)


def placed(x: np.ndarray) -> np.ndarray:
    """With the markers where they are."""
    return x + np.resize(PLACES, len(x))[:, None] + 40.0 * (np.arange(len(x)) // 6)[:, None]


def ou(rng: Noise, t: np.ndarray, T_c: float) -> np.ndarray:
    return gauss_markov(T_c, 1.0)(rng, t.size, 1 / (t[1] - t[0]))


def louder(gain: Callable[[Noise, np.ndarray], np.ndarray]) -> Make:
    return lambda rng, t, x: x * gain(rng, t)


def hunting(rng: Noise, t: np.ndarray) -> np.ndarray:
    """An exposure that is put right in steps, each of two to six seconds."""
    return dwelling(2, 6, [0.8, 1.0, 1.25])(rng, t)


def lost_regularly(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[:3, (t + rng.uniform(0, 7)) % 7 < 1.5] = np.nan
    return x


def stalls(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for at in np.cumsum(rng.uniform(20, 90, 20)):
        x[:, (t > at) & (t < at + 3)] = np.nan
    return x


def merging(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Two images become one, now and then."""
    for at in np.cumsum(rng.uniform(20, 90, 20)):
        now = (t > at) & (t < at + rng.uniform(0.3, 2))
        x[0, now] += 3
        x[3, now] -= 3
    return x


def jittery_clock(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.03 * np.sin(2 * np.pi * 9.3 * (t + 3e-3 * rng.standard_normal(t.size)))


def rounded(step: float, slope: float = 0.0) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        x[0] += slope * t / t[-1]
        return step * np.round((placed(x) + rng.uniform(0, step, (len(x), 1))) / step)

    return made


def half_floats(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return (x + [[61.0], [-43.0], [88.0], [112.0], [-40.0], [90.0]]).astype(np.float16).astype(float)


def other_unit(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """m from some frame on."""
    x = placed(x)
    x[:, t > rng.uniform(80, 220)] /= 1000
    return x


def filled_linearly(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Gaps of 10 to 40 frames of one marker, with straight lines."""
    for start in rng.integers(50, t.size - 100, 40):
        stop = start + rng.integers(10, 40)
        for axis in x[:3]:
            axis[start:stop] = np.linspace(axis[start - 1], axis[stop], stop - start + 2)[1:-1]
    return x


def filtered(order: int, corner: float, both: bool = True, kind: str = "low") -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        sos = signal.butter(order, corner, kind, fs=1 / (t[1] - t[0]), output="sos")
        return signal.sosfiltfilt(sos, x) if both else signal.sosfilt(sos, x)

    return made


def notch(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return signal.filtfilt(*signal.iirnotch(12.5, 5, fs=50), x)


def exponential(share: float) -> Make:
    return lambda rng, t, x: signal.lfilter([share], [1, share - 1], x)


def dead_band(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A coordinate is told anew where it is 0.03 mm from the one told last."""
    for axis in x:
        told = axis[0]
        for k, value in enumerate(axis):
            told = axis[k] = value if abs(value - told) > 0.03 else told
    return x


def nearest(old_hz: float) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return x[:, np.floor(t * old_hz + 0.3).astype(int) % t.size]

    return made


def doubled(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Every second frame is the mean of its neighbours."""
    x[:, 1:-1:2] = (x[:, :-2:2] + x[:, 2::2])[:, : x[:, 1:-1:2].shape[1]] / 2
    return x


def swinging(rng: Noise, t: np.ndarray) -> np.ndarray:
    since = np.maximum(t - rng.uniform(40, 150), 0)
    return 0.5 * (since > 0) * np.exp(-since / 25) * np.sin(2 * np.pi * 0.8 * since)


def leaning(rng: Noise, t: np.ndarray) -> np.ndarray:
    since = t - rng.uniform(50, 150)
    return 0.12 * np.clip(np.minimum(since / 3, (rng.uniform(30, 70) - since) / 3), 0, 1)


def leanings(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Somebody comes and goes, and leans as he likes."""
    ends = np.cumsum(rng.uniform(10, 60, 40))
    size = rng.uniform(0, 0.1, 41)[np.searchsorted(ends, t)]
    return ndimage.uniform_filter1d(size, 150)


def shaded(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.03 * np.tanh(1.2 * ou(rng, t, 15.0))


def clouds(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Stretches in the sun, each warming and cooling with 12 s."""
    ends = np.cumsum(rng.uniform(10, 70, 40))
    on = (np.searchsorted(ends, t) % 2).astype(float)
    share = (t[1] - t[0]) / 12
    return 0.08 * signal.lfilter([share], [1, share - 1], on)


def drifting_pump(rng: Noise, t: np.ndarray) -> np.ndarray:
    f = rng.uniform(0.3, 1.5) + 0.06 * ou(rng, t, 30.0)
    return 0.03 * np.sin(2 * np.pi * np.cumsum(f) * (t[1] - t[0]))


def two_pumps(rng: Noise, t: np.ndarray) -> np.ndarray:
    f = rng.uniform(0.7, 2)
    return 0.02 * (np.sin(2 * np.pi * f * t) + np.sin(2 * np.pi * (f + 0.027) * t))


def passers_by(rng: Noise, t: np.ndarray) -> np.ndarray:
    total = np.zeros(t.size)
    for at in np.cumsum(rng.uniform(25, 90, 20)):
        total += 0.08 * np.exp(-(((t - at) / 3) ** 2)) * np.sin(2 * np.pi * 1.9 * t + at)
    return total


def recalibrated(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x = placed(x)
    later = t > rng.uniform(80, 220)
    return np.where(later, x * (1 + 2e-4) + 0.05, x)


def camera_lost(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    later = t > rng.uniform(80, 220)
    x = np.where(later, 1.3 * x, x)
    x[0] += 0.04 * later
    x[2] -= 0.03 * later
    return x


def dropped(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Frames of a vibrating marker that were lost without a gap."""
    kept = np.cumsum(1 + (rng.random(t.size) < 0.004) * rng.integers(1, 12, t.size))
    x[0] += 0.03 * np.sin(2 * np.pi * 7.3 * kept * (t[1] - t[0]))
    return x


def copied(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    n = round(30 / (t[1] - t[0]))
    x[:, 6 * n : 7 * n] = x[:, 2 * n : 3 * n]
    return x


def thermostat(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Short heating, long cooling, of unequal length."""
    value, heats, out = 0.5, True, np.empty(t.size)
    rise, fall, dt = rng.uniform(10, 16), rng.uniform(30, 50), t[1] - t[0]
    for k in range(t.size):
        value += dt * ((1.3 - value) / rise if heats else -(value + 0.3) / fall)
        heats = (value < 1) if heats else value < 0
        out[k] = value
    return 0.08 * out


def two_constants(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.2 * np.exp(-t / 12) + 0.2 * np.exp(-t / 150)


def slips(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Creep by slips, ever more rare."""
    at = np.expm1(np.sort(rng.uniform(0, np.log(t[-1] + 2), 14)))
    return 0.02 * np.searchsorted(at, t)


def held_warm(rng: Noise, t: np.ndarray) -> np.ndarray:
    up, down = rng.uniform(30, 90), rng.uniform(180, 250)
    return 0.15 * np.clip(np.minimum((t - up) / 50, (down - t) / 50 + 1), 0, 1)


def subpixel(rng: Noise, t: np.ndarray) -> np.ndarray:
    x = 1.0 * t / t[-1]
    return x + 0.03 * np.sin(2 * np.pi * x / 0.21)


def switched_on(rng: Noise, t: np.ndarray) -> np.ndarray:
    since = np.maximum(t - rng.uniform(80, 160), 0)
    return 0.15 * -np.expm1(-since / 40)


def peeling(rng: Noise, t: np.ndarray) -> np.ndarray:
    at = rng.uniform(200, 260)
    return np.where(t < at, 0.4 * np.exp((t - at) / 20), 40.0)


def ghosts(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for start in rng.integers(10, t.size - 20, 8):
        x[:3, start : start + rng.integers(2, 11)] += [[60.0], [20.0], [-9.0]]
    return x


def reflections(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for start in rng.integers(10, t.size - 20, 30):
        there = slice(start, start + rng.integers(1, 6))
        x[:3, there] += rng.normal(0, 0.4, (3, 1))
    return x


def lift(rng: Noise, t: np.ndarray) -> np.ndarray:
    """An elevator's weight on two floors, ten seconds between them."""
    return ndimage.uniform_filter1d(dwelling(25, 60, [0.0, 0.06])(rng, t), 500)


def sag(rng: Noise, t: np.ndarray) -> np.ndarray:
    since = np.maximum(t - rng.uniform(80, 220), 0)
    return 0.3 * (since > 0) * (1 - np.exp(-since / 1.5) * np.cos(2 * np.pi * 1.7 * since))


def person(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Holds the markers, breathes and sways."""
    breath = np.sin(2 * np.pi * np.cumsum(0.25 + 0.02 * ou(rng, t, 10.0)) * (t[1] - t[0]))
    sway = np.array([ou(rng, t, 4.0) for _ in range(3)])
    return x + np.tile(0.8 * breath + 2.0 * sway, (2, 1))


def bouncing(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A walk between walls."""
    rate = 1 / (t[1] - t[0])
    for axis in x:
        path = np.cumsum(0.02 / np.sqrt(rate) * rng.standard_normal(t.size))
        axis += np.abs((path + 0.05) % 0.2 - 0.1)
    return x


def mixed(*terms: tuple[float, float]) -> Make:
    """Gauss-Markov noise of time constants and sizes."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return x + np.array([sum(s * ou(rng, t, c) for c, s in terms) for _ in x])

    return made


def lamps(rng: Noise, t: np.ndarray) -> np.ndarray:
    """100 Hz of a grid that wanders, folded."""
    f = 100 + 0.04 * ou(rng, t, 60.0)
    return 0.02 * np.sin(2 * np.pi * (np.cumsum(f) / 60 + rng.uniform()))


def alternate(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Two groups of cameras in turn."""
    return x + 0.006 * (-1.0) ** np.arange(t.size)


def building(rng: Noise, t: np.ndarray) -> np.ndarray:
    """A hammer drill, for a while now and then."""
    on = dwelling(3, 60, [0.0, 1.0])(rng, t)
    return 0.05 * on * signal.lfilter([1], [1, -0.6, 0.8], rng.standard_normal(t.size)) / 2


KINDS: dict[str, Kind] = {
    "exposure that hunts": kind(louder(hunting), "", LOUD),
    "volatile noise": kind(
        louder(lambda r, t: np.exp(0.4 * ou(r, t, 2.0))), "heavy_tails", "level_changes"
    ),
    "noise that swings": kind(
        louder(lambda r, t: 1 + 0.5 * np.sin(2 * np.pi * (t / 10 + r.uniform()))),
        "heavy_tails", "level_changes",
    ),
    "building site": kind(in_x1(building), "", f"{LOUD} resonance"),
    "lost every 7 s": kind(lost_regularly, good=False),
    "frames of both stall": kind(stalls),
    "images merge": kind(merging, "event", "heavy_tails moves"),
    "ghosts": kind(ghosts, "", "event heavy_tails moves"),
    "reflections": kind(reflections, "", "event heavy_tails"),
    "vibration, jittery clock": kind(in_x1(jittery_clock), "line"),
    "vibration, frames dropped": kind(dropped, "", "line"),
    "steps of 0.1 mm": kind(rounded(0.1), "resolution_limited", places=False),
    "steps of 0.1 mm and drift": kind(
        rounded(0.1, 0.4), "resolution_limited", "drift wander", places=False
    ),
    "steps of 1 mm": kind(rounded(1.0), "", "resolution_limited", places=False, good=False),
    "half floats": kind(half_floats, "", "resolution_limited", places=False),
    "unit changes": kind(other_unit, "step moves", "event resolution_limited", places=False, good=False),
    "in m": kind(lambda r, t, x: placed(x) / 1000, unit="m", places=False),
    "straight fills": kind(filled_linearly, "gap_filled", "heavy_tails"),
    "Butterworth 1.5 Hz": kind(filtered(2, 1.5), "low_pass"),
    "Butterworth 22 Hz of 25": kind(filtered(4, 22.0), "", "low_pass smoothed"),
    "one pass at 8 Hz": kind(filtered(2, 8.0, both=False), "low_pass"),
    "Bessel-like, first order at 10 Hz": kind(filtered(1, 10.0, both=False), "", "low_pass smoothed"),
    "high pass": kind(filtered(1, 0.05, both=False, kind="high")),
    "notch": kind(notch),
    "exponential, light": kind(exponential(0.8), "", "low_pass smoothed"),
    "exponential, heavy": kind(exponential(0.1), "smoothed low_pass", "low_pass"),
    "dead band": kind(dead_band, "", "repeated running_median heavy_tails"),
    "nearest of 45 Hz": kind(nearest(45.0), "repeated resampled", "heavy_tails"),
    "every second interpolated": kind(doubled, "resampled low_pass", "heavy_tails low_pass"),
    "a part is copied": kind(copied),
    "cable that swings": kind(in_x1(swinging), "event line", f"{LOUD} moves"),
    "leaning on the table": kind(in_x1(leaning), "shift wander event", "event moves"),
    "leaning, again and again": kind(in_x1(leanings), "wander levels", "event moves"),
    "shade": kind(in_x1(shaded), "", "wander"),
    "clouds": kind(in_x1(clouds), "wander", "event"),
    "pump that drifts": kind(in_x1(drifting_pump), "", "line"),
    "two pumps": kind(in_x1(two_pumps), "line", LOUD),
    "passers-by": kind(in_x1(passers_by), "event", f"{LOUD} line"),
    "calibrated anew": kind(recalibrated, "step", "event moves", places=False, good=False),
    "camera lost": kind(camera_lost, "step event level_changes", "event level_changes moves step"),
    "thermostat": kind(in_x1(thermostat), "cycle wander", "line"),
    "two time constants": kind(in_x1(two_constants), f"{SLOW} warm_up", "moves"),
    "slips, ever rarer": kind(in_x1(slips), "wander step", "event moves"),
    "warm for a while": kind(in_x1(held_warm), "wander", "moves"),
    "drift over pixels": kind(in_x1(subpixel), "drift wander", "cycle line moves", good=False),
    "heating switched on": kind(in_x1(switched_on), "wander", "moves"),
    "peels and falls": kind(
        in_x1(peeling), "step moves event", "event moves accelerating wander", good=False
    ),
    "lift": kind(in_x1(lift), "wander two_levels levels", "event"),
    "sag that rings": kind(in_x1(sag), "step event", "event moves heavy_tails"),
    "person": kind(person, "", "moves event wander line", good=False),
    "walk between walls": kind(bouncing, "", "wander"),
    "correlated over 100 s": kind(mixed((100.0, 0.04)), "", "wander random_walk"),
    "correlated over 1 and 30 s": kind(mixed((1.0, 0.02), (30.0, 0.03)), "", "wander"),
    "flicker": kind(of_noise(coloured(-1.0, WHITE / 2), 1.0), "", "wander"),
    "walk": kind(of_noise(walk(5e-4), 1.0), "", "wander random_walk"),
    "lamps": kind(in_x1(lamps), "line", rate=60.0),
    "cameras in turn": kind(alternate, "", "line"),
    "3 s": kind(lambda r, t, x: x, seconds=3.0, good=False),
    "30 s at 1000 Hz": kind(lambda r, t, x: x, seconds=30.0, rate=1000.0),
    "one marker": kind(lambda r, t, x: x, markers=1, good=False),
    "twelve markers": kind(lambda r, t, x: x, markers=12, seconds=120.0),
}


def told(one: Kind, values: np.ndarray, folder: Path) -> tuple[Counter[str], str]:
    """Findings and the word of the verdict of (3 markers, n) values in mm."""
    labels = [f"M{k + 1}" for k in range(one.markers)]
    frames = (placed(values) if one.places else values).reshape(one.markers, 3, -1)
    path = folder / "take.c3d"
    write_c3d(path, labels, one.rate, [frames.transpose(2, 0, 1)], frames.shape[2], one.unit)
    results = clean(Entry([str(path)], labels), origin("take"), SETTINGS, folder)
    noise(results, SETTINGS)
    found = diagnose(results, SETTINGS)
    word = verdict(results, {"recording": "take", "group": "check"}, SETTINGS)["word"]
    return Counter(one.code for one in found.findings), str(word)


def false(name: str, seed: int, markers: int | None = None) -> tuple[bool, list[str]]:
    """Whether it was named; what is said that is not so. markers: that are kept, at most."""
    rng = np.random.default_rng([list(KINDS).index(name), seed, 11])
    one = KINDS[name]
    values = one.drawn(rng)
    with tempfile.TemporaryDirectory() as folder:
        try:
            found, word = told(one, values, Path(folder))
        except Exception as failure:
            return False, [f"{type(failure).__name__}: {failure}"]
    said = set(found)
    wrong = sorted(said - one.names - one.beside)
    if word == "good" and not one.good:
        wrong.append("good")
    return bool(said & one.names) or not one.names, wrong


def rows(runs: int) -> Iterator[tuple[str, str, int, str, str, str]]:
    """For docs/accuracy."""
    for name, one in KINDS.items():
        told_of = [false(name, run) for run in range(runs)]
        wrong = Counter(code for _, codes in told_of for code in codes)
        named = sum(named for named, _ in told_of) / runs
        yield name, "named", runs, ">= 0.7" if one.names else "", "", f"{named:.2f}"
        listed = ", ".join(f"{code} {count}" for code, count in wrong.items())
        share = sum(bool(codes) for _, codes in told_of) / runs
        yield name, "false", runs, "<= 0.03", "", f"{share:.2f} {listed}".strip()
