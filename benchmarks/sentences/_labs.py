"""What happens to still markers in laboratories: makers of the kinds of `labs`.

Of a generator, times (n,) in s and white noise (3 markers, n) in mm: all coordinates; or of the
first two: what is added to one coordinate, or what the noise is multiplied by.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import ndimage, signal

from benchmarks.sentences._kinds import coloured, gauss_markov
from benchmarks.sentences.unforeseen import Make, Noise, dwelling


def ou(rng: Noise, t: np.ndarray, T_c: float) -> np.ndarray:
    return gauss_markov(T_c, 1.0)(rng, t.size, 1 / (t[1] - t[0]))


def louder(gain: Callable[[Noise, np.ndarray], np.ndarray]) -> Make:
    return lambda rng, t, x: x * gain(rng, t)


def hunting(rng: Noise, t: np.ndarray) -> np.ndarray:
    """An exposure that is put right in steps, each of two to six seconds."""
    return dwelling(2, 6, [0.8, 1.0, 1.25])(rng, t)


def merging(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Two images become one, now and then."""
    for at in np.cumsum(rng.uniform(20, 90, 20)):
        now = (t > at) & (t < at + rng.uniform(0.3, 2))
        x[0, now] += 3
        x[3, now] -= 3
    return x


def jittery_clock(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.03 * np.sin(2 * np.pi * 9.3 * (t + 3e-3 * rng.standard_normal(t.size)))


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


def camera_lost(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    later = t > rng.uniform(80, 220)
    x = np.where(later, 1.3 * x, x)
    x[0] += 0.04 * later
    x[2] -= 0.03 * later
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


def building(rng: Noise, t: np.ndarray) -> np.ndarray:
    """A hammer drill, for a while now and then."""
    on = dwelling(3, 60, [0.0, 1.0])(rng, t)
    return 0.05 * on * signal.lfilter([1], [1, -0.6, 0.8], rng.standard_normal(t.size)) / 2


def fan_blades(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Two frames are lost each time that a blade passes."""
    x[:3, np.arange(t.size) % 13 < 2] = np.nan
    return x


def sawtooth_gain(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.7 + 0.6 * ((t / 20 + rng.uniform()) % 1)


def swings(rng: Noise, t: np.ndarray) -> np.ndarray:
    return swinging(rng, t) + 0.6 * swinging(rng, t)


def creep_and_step(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.05 * np.log1p(t / 8) + 0.08 * (t > rng.uniform(100, 250))


def settling(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.12 * np.exp(-t / 90) * np.sin(2 * np.pi * t / 47 + rng.uniform(0, 6))


def frame_walks(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The frame of the cameras, so all markers alike."""
    return x + np.tile(np.cumsum(4e-4 * rng.standard_normal((3, t.size)), axis=1), (2, 1))


def spins_up(rng: Noise, t: np.ndarray) -> np.ndarray:
    f = np.minimum(4 + 12 * t / 60, 16.0)
    return 0.03 * np.sin(2 * np.pi * np.cumsum(f) * (t[1] - t[0]))


def late_line(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.04 * (t > 200) * np.sin(2 * np.pi * 11.3 * t)


def saw_line(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.03 * signal.sawtooth(2 * np.pi * 3.07 * t)


def heart(rng: Noise, t: np.ndarray) -> np.ndarray:
    out = np.zeros(t.size)
    for at in np.cumsum(rng.normal(0.9, 0.04, 400)):
        out += 0.05 * np.exp(-(((t - at) / 0.05) ** 2)) if at < t[-1] else 0
    return out


def drafts(rng: Noise, t: np.ndarray) -> np.ndarray:
    out = np.zeros(t.size)
    for at in np.cumsum(rng.normal(60, 10, 8)):
        since = np.maximum(t - at, 0)
        out += 0.08 * since / 5 * np.exp(1 - since / 5)
    return out


def flickering_level(rng: Noise, t: np.ndarray) -> np.ndarray:
    return np.exp(0.3 * coloured(-1.0, 1.0)(rng, t.size, 50.0) / 3)


def shadows(rng: Noise, t: np.ndarray) -> np.ndarray:
    gain = np.ones(t.size)
    for at in np.cumsum(rng.exponential(15, 40)):
        gain[(t > at) & (t < at + 1)] = 2
    return gain


def salt(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    off = rng.random(x.shape) < 0.01
    return x + off * rng.normal(0, 1, x.shape)


def one_sided(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return x + (rng.random(x.shape) < 0.02) * rng.exponential(0.1, x.shape)


def stairs(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.01 * np.floor(t / 10)


def unsteady(rng: Noise, t: np.ndarray) -> np.ndarray:
    jump = np.repeat(rng.uniform(0, 6, 12), t.size // 12 + 1)[: t.size]
    return 0.05 * np.sin(2 * np.pi * t / 20 + jump)


def wheel(rng: Noise, t: np.ndarray) -> np.ndarray:
    """A cart that rolls by: the floor bends and comes back."""
    return sum(0.1 * np.exp(-(((t - at) / 6) ** 2)) for at in np.cumsum(rng.uniform(40, 120, 6)))


def projector(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.03 * (1 + 0.8 * np.sin(2 * np.pi * 0.2 * t)) * np.sin(2 * np.pi * 17.4 * t)


def heater(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Five seconds of heat every 70 s, which fades in 20 s."""
    on = ((t + 30) % 70 < 5).astype(float)
    s = (t[1] - t[0]) / 20
    return 0.3 * signal.lfilter([s], [1, s - 1], on)


def hanging_steps(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Another marker's y: three shifts that recover."""
    for at in (60, 140, 230):
        since = t - at - rng.uniform(0, 20)
        x[4] += np.where(since > 0, 0.1 * np.exp(-np.maximum(since, 0) / 8), 0)
    return x


def antiphase(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    w = 0.04 * np.sin(2 * np.pi * 5.5 * t)
    x[1] += w
    x[4] -= w
    return x


def common(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return x + np.tile(0.015 * np.array([ou(rng, t, 8.0) for _ in range(3)]), (2, 1))


def overshoot(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.3 * (np.exp(-t / 90) - np.exp(-t / 25))


def louder_late(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 1 + 0.8 * np.expm1(t / t[-1] * 2) / np.expm1(2)


def two_doors(rng: Noise, t: np.ndarray) -> np.ndarray:
    a = t % 19
    b = (t + 5) % 31
    return 0.12 * np.exp(-a / 0.4) * np.sin(2 * np.pi * 5 * a) + 0.1 * np.exp(-b / 0.5) * np.sin(
        2 * np.pi * 3.3 * b
    )


def tilt(rng: Noise, t: np.ndarray) -> np.ndarray:
    """A tripod sinks: linear, and stops."""
    return 0.15 * np.clip((t - 60) / 120, 0, 1)


def wild_clock(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.05 * np.sin(2 * np.pi * 3.1 * (t + 2e-3 * rng.standard_t(2.2, t.size)))


def slides(rng: Noise, t: np.ndarray) -> np.ndarray:
    """At 3 um/s, and at rest, in turn."""
    ends = np.cumsum(rng.uniform(25, 50, 20))
    return np.cumsum(np.where(np.searchsorted(ends, t, "right") % 2, 0.0, 0.003)) * (t[1] - t[0])


def kicked(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """All markers shift; half of it fades."""
    since = t - rng.uniform(90, 210)
    left = np.where(since > 0, 0.1 + 0.1 * np.exp(-np.maximum(since, 0) / 20), 0)
    return x + np.tile([[1.0], [0.5], [-0.3]], (2, 1)) * left


def loud_minute(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    since = t - rng.uniform(60, 180)
    x[1] *= np.where((since > 0) & (since < 60), 2, 1)
    return x


def gusts(rng: Noise, t: np.ndarray) -> np.ndarray:
    """A tent's wall: bursts of low-frequency shaking."""
    env = np.maximum(ou(rng, t, 12.0), 0)
    return (
        0.05
        * env
        * signal.lfilter([0.1], [1, -1.9 * np.cos(0.2), 0.9025], rng.standard_normal(t.size))
    )


def three_causes(rng: Noise, t: np.ndarray) -> np.ndarray:
    later = t > rng.uniform(120, 250)
    return 0.2 * np.exp(-t / 80) + 0.1 * later + 0.03 * np.sin(2 * np.pi * 6.3 * t)


def fading(t: np.ndarray, at: np.ndarray, constant: float) -> np.ndarray:
    """Sum of pulses of size 1."""
    since = t - at[:, None]
    return np.where(since > 0, np.exp(-np.maximum(since, 0) / constant), 0.0).sum(axis=0)


def clicks(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.12 * fading(t, np.cumsum(rng.exponential(25, 30)), 3.0)


def doors_of_a_day(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.15 * np.sin(2 * np.pi * t / 86400) - 0.08 * fading(t, rng.uniform(0, 86400, 12), 900.0)


def threes(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """One frame of a hundred, three at a time."""
    for start in rng.integers(5, t.size - 5, t.size // 300):
        x[:3, start : start + 3] += rng.normal(0, 0.4, (3, 1))
    return x
