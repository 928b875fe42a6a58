"""What still markers do, put together from parts: the kinds of `recordings`, `unforeseen`, `labs`.

A wave is made of a generator and times (n,) in s: what is added to one coordinate in mm, or what
the noise is multiplied by. A maker is made of both and of white noise (3 markers, n): all values.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import signal

from benchmarks.sentences import Row
from benchmarks.sentences._kinds import Kind as Process
from benchmarks.sentences._kinds import gauss_markov

Noise = np.random.Generator
Wave = Callable[[Noise, np.ndarray], np.ndarray]
Make = Callable[[Noise, np.ndarray, np.ndarray], np.ndarray]
WHITE = 0.02  # mm a frame
PLACES = np.array([812.0, -430.0, 1105.0, 1312.0, -415.0, 1098.0])  # mm, of two markers


@dataclass(frozen=True)
class Kind:
    """names: findings of which one says what it is; beside: others that are true; step_mm: of the
    file, 0 of float32; good: whether its verdict may be; unit: of the file; placed: whether the
    markers are put apart after it was made."""

    make: Make
    names: frozenset[str]
    beside: frozenset[str]
    rate: float = 100.0
    seconds: float = 600.0
    step_mm: float = 0.0
    markers: int = 2
    good: bool = True
    unit: str = "mm"
    placed: bool = True

    def drawn(self, rng: Noise) -> np.ndarray:
        """(3 markers, n) in units of the file."""
        t = np.arange(round(self.seconds * self.rate)) / self.rate
        return self.make(rng, t, WHITE * rng.standard_normal((3 * self.markers, t.size)))


def kind(make: Make, names: str = "", beside: str = "", **how: float | bool | str) -> Kind:
    return Kind(make, frozenset(names.split()), frozenset(beside.split()), **how)


def in_x1(wave: Wave, names: str = "", beside: str = "", **how: float | bool | str) -> Kind:
    """Of a wave in one coordinate."""
    return kind(added(0, wave), names, beside, **how)


def rows_of(
    kinds: dict[str, Kind], said_of: Callable[[str, int], set[str]], runs: int
) -> Iterator[Row]:
    """For docs/accuracy: how often a kind is named, and how often anything is said that is not so.
    said_of: codes of the findings of one recording."""
    for name, one in kinds.items():
        said = [said_of(name, run) for run in range(runs)]
        wrong = [sorted(codes - one.names - one.beside) for codes in said]
        named = np.mean([bool(codes & one.names) or not one.names for codes in said])
        yield name, "named", runs, ">= 0.7", f"{named:.2f}"
        which = Counter(code for codes in wrong for code in codes)
        listed = ", ".join(f"{code} {count}" for code, count in which.items())
        share = np.mean([bool(codes) for codes in wrong])
        yield name, "false", runs, "<= 0.03", f"{share:.2f} {listed}".strip()


def placed(x: np.ndarray) -> np.ndarray:
    """With the markers where they are."""
    return x + np.resize(PLACES, len(x))[:, None] + 40.0 * (np.arange(len(x)) // 6)[:, None]


def added(coordinate: int, *waves: Wave) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        for wave in waves:
            x[coordinate] += wave(rng, t)
        return x

    return made


def along(direction: Sequence[float], wave: Wave) -> Make:
    """One wave in all coordinates, by so much of it in each (of both markers alike, where 3)."""
    return lambda rng, t, x: x + np.outer(np.resize(direction, len(x)), wave(rng, t))


def common(of_both: Callable[[Noise, np.ndarray], np.ndarray]) -> Make:
    """(3, n) that both markers have in common."""
    return lambda rng, t, x: x + np.tile(of_both(rng, t), (2, 1))


def louder(gain: Wave) -> Make:
    return lambda rng, t, x: x * gain(rng, t)


def of_noise(process: Process, white: float = 0.0) -> Make:
    """All coordinates of this noise, and as much of the white one."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        rate = 1 / (t[1] - t[0])
        return white * x + np.array([process(rng, t.size, rate) for _ in x])

    return made


def lost(when: Callable[[Noise, np.ndarray], np.ndarray], markers: int = 1) -> Make:
    """Without the frames of the first markers where `when` is true."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        x[: 3 * markers, when(rng, t).astype(bool)] = np.nan
        return x

    return made


def then(*makes: Make) -> Make:
    """One after another."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        for make in makes:
            x = make(rng, t, x)
        return x

    return made


def after(low_s: float, high_s: float, shape: Wave) -> Wave:
    """A shape of the seconds since a moment between both; nothing before."""

    def wave(rng: Noise, t: np.ndarray) -> np.ndarray:
        since = t - rng.uniform(low_s, high_s)
        return np.where(since > 0, shape(rng, np.maximum(since, 0)), 0.0)

    return wave


def pulses(times: Callable[[Noise], np.ndarray], shape: Callable[[np.ndarray], np.ndarray]) -> Wave:
    """A shape of the seconds since each of some moments (k,) in s."""

    def wave(rng: Noise, t: np.ndarray) -> np.ndarray:
        since = (t - at for at in times(rng))
        return sum(np.where(s > 0, shape(np.maximum(s, 0)), 0.0) for s in since)

    return wave


def bells(times: Callable[[Noise], np.ndarray], size: float, width_s: float) -> Wave:
    def wave(rng: Noise, t: np.ndarray) -> np.ndarray:
        return sum(size * np.exp(-(((t - at) / width_s) ** 2)) for at in times(rng))

    return wave


def dwelling(low_s: float, high_s: float, levels: list[float], count: int = 0) -> Wave:
    """Positions that are never the same twice in a row; count: of those drawn, 0 for enough."""

    def wave(rng: Noise, t: np.ndarray) -> np.ndarray:
        ends = np.cumsum(rng.uniform(low_s, high_s, count or int(t[-1] / low_s) + 2))
        which = np.cumsum(rng.integers(1, len(levels), ends.size)) % len(levels)
        return np.array(levels)[which][np.searchsorted(ends, t, "right")]

    return wave


def lines(*pairs: tuple[float, float]) -> Wave:
    """Sinusoids of these amplitudes and frequencies, of any phase."""
    return lambda rng, t: sum(
        size * np.sin(2 * np.pi * (f * t + rng.uniform())) for size, f in pairs
    )


def sine(size: float, hz: float) -> Wave:
    """That begins at 0."""
    return lambda rng, t: size * np.sin(2 * np.pi * hz * t)


def decay(size: float, seconds: float) -> Wave:
    return lambda rng, t: size * np.exp(-t / seconds)


def step(size: float, low_s: float, high_s: float) -> Wave:
    """At a moment between both."""
    return after(low_s, high_s, lambda rng, since: size + 0 * since)


def summed(*waves: Wave) -> Wave:
    return lambda rng, t: sum(wave(rng, t) for wave in waves)


def ringing(since: np.ndarray, size: float, decay_s: float, hz: float) -> np.ndarray:
    return size * np.exp(-since / decay_s) * np.sin(2 * np.pi * hz * since)


def ou(rng: Noise, t: np.ndarray, T_c: float) -> np.ndarray:
    """Gauss-Markov noise of standard deviation 1."""
    return gauss_markov(T_c, 1.0)(rng, t.size, 1 / (t[1] - t[0]))


def swept(t: np.ndarray, hz: np.ndarray) -> np.ndarray:
    """Sinusoid of size 1 whose frequency changes."""
    return np.sin(2 * np.pi * np.cumsum(hz) * (t[1] - t[0]))


def lagging(x: np.ndarray, t: np.ndarray, seconds: float) -> np.ndarray:
    """First-order low pass."""
    share = (t[1] - t[0]) / seconds
    return signal.lfilter([share], [1, share - 1], x)


def two_levels(count: int) -> Wave:
    """1 to 3 white standard deviations apart, for 5 to 120 s each."""
    levels = dwelling(5, 120, [WHITE, 0.0], count)
    return lambda rng, t: levels(rng, t) * rng.uniform(1, 3)


def recovering(low_s: float, high_s: float) -> Wave:
    """A shift of 0.1 mm that recovers in 15 to 40 s."""
    return after(low_s, high_s, lambda r, s: 0.1 * np.exp(-s / r.uniform(15, 40)))


def creep(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.05 * np.log1p(t / rng.uniform(5, 30))


def sliding(low_s: float, high_s: float, speeds: list[float]) -> Wave:
    """At these speeds in mm/s, in turn."""
    speed = dwelling(low_s, high_s, speeds, 20)
    return lambda rng, t: np.cumsum(speed(rng, t)) * (t[1] - t[0])
