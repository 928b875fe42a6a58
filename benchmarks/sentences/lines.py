"""Periodic disturbances: wandering mains, filtered data, the end of the spectrum, stable lines.

Series of ten minutes at 120 Hz unless stated, white noise of 50 um. Wandering lines: 15 um at 50
Hz, whose frequency deviates by 20 mHz (standard deviation of an Ornstein-Uhlenbeck process of 60 s;
amplitude of a sinusoid of 100 s; largest deviation of a random walk). Folded: at 100 Hz, so at
Nyquist. `findings`: lines in a recording; intervals are those of `noise.csv`. Widths are medians
over the Cramer-Rao bound of a sinusoid in the same noise (which excludes the phases on which the
power of a folded line depends). Where named, the estimator is `likelihood` (lines, gaps, slow lines
and noise in turn); otherwise it is the search for lines alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.signal import butter, lfilter

from benchmarks.sentences import Row, percent
from benchmarks.sentences._kinds import Filter, butterworth, savitzky_golay, woltring
from mocap_metrology.noise.fit.estimates import Z_95
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.lines import Line, find_lines

RATE, SECONDS, SIGMA, A_S = 120, 600, 0.05, 0.015
BY = 0.02
Part = tuple[str, str, str, str]  # a row without the number of runs


def rows(n: int) -> Iterator[Row]:
    """n recordings a case."""
    for part in (_wandering, _by_likelihood, _filtered, _ends, _stable, _detected, _plain):
        for case, statistic, reach, measured in part(n):
            yield case, statistic, n, reach, measured


def wandering(rng: np.random.Generator, kind: str, rate: int = RATE) -> tuple[np.ndarray, float]:
    """(n,) line of 15 um whose frequency wanders about 50 Hz, and its mean frequency."""
    n = rate * SECONDS
    if kind == "up and down":
        offset = BY * np.sin(2 * np.pi * np.arange(n) / rate / 100 + rng.uniform(0, 2 * np.pi))
    elif kind == "random walk":
        offset = np.cumsum(rng.normal(size=n))
        offset -= offset.mean()
        offset *= BY / np.abs(offset).max()
    else:
        a = math.exp(-1 / (rate * 60))
        drawn = rng.normal(size=n) * math.sqrt(1 - a**2)
        offset = BY * lfilter([1], [1, -a], drawn, zi=[a * rng.normal()])[0]
    phase = (50 * np.arange(n) + np.cumsum(offset)) / rate
    return A_S * np.sin(2 * np.pi * phase), 50 + float(offset.mean())


def stable(rng: np.random.Generator, A_s: float, f_0: float, rate: int = RATE) -> np.ndarray:
    """(n,) line of any phase."""
    t = np.arange(rate * SECONDS) / rate
    return A_s * np.sin(2 * np.pi * f_0 * t + rng.uniform(0, 2 * np.pi))


def found_in(rng: np.random.Generator, wave: np.ndarray, rate: int = RATE) -> list[Line]:
    """Lines of a wave under white noise, the strongest first."""
    return find_lines(wave + rng.normal(0, SIGMA, wave.size), rate)


def near(lines: list[Line], f_0: float) -> bool:
    return any(abs(line.f_0 - f_0) < 2 / SECONDS for line in lines)


def _wandering(n: int) -> Iterator[Part]:
    for rate in (120, 100):
        for kind in ("noise", "up and down", "random walk"):
            found = []
            for seed in range(n):
                rng = np.random.default_rng(seed)
                wave, f_0 = wandering(rng, kind, rate)
                found.append(_judged(found_in(rng, wave, rate), A_S, min(f_0, rate - f_0)))
            case = f"mains wander, {kind}" + (", folded" if rate == 100 else "")
            yield from _told(case, found)


def _judged(lines: list[Line], A_s: float, f_0: float) -> tuple[float, ...]:
    """Of the strongest line: whether both intervals hold, A_s's error over the bound, width_f; and
    the number of lines."""
    if not lines:
        return 0.0, 0.0, math.nan, math.nan, 0
    line = lines[0]
    errors = line.errors(SECONDS)
    size = abs(math.log(line.A_s / A_s)) < Z_95 * errors[0] / line.A_s
    frequency = abs(line.f_0 - f_0) < Z_95 * errors[1]
    bound = math.sqrt(line.psd / SECONDS)
    return size, frequency, errors[0] / bound, line.width_f, len(lines)


def _told(name: str, found: list[tuple[float, ...]]) -> Iterator[Part]:
    size, frequency, error, width, number = np.array(found, float).T
    yield name, "findings a recording", "1", f"{number.mean():.2f}"
    yield name, "A_s: 95 % holds", ">= 90 %", percent(size)
    yield name, "f_0: 95 % holds", ">= 90 %", percent(frequency)
    reach = "" if "folded" in name else "<= 1.5"
    yield name, "A_s: standard error over bound", reach, f"{np.nanmedian(error):.2f}"
    yield name, "width_f, mHz", "", f"{1e3 * np.nanmedian(width):.1f}"


def _by_likelihood(n: int) -> Iterator[Part]:
    for gaps in (0.0, 0.02):
        name = "mains wander, noise, `likelihood`" + (f", {gaps:.0%} gaps" if gaps else "")
        number, size, white = [], [], []
        for seed in range(n):
            rng = np.random.default_rng(seed)
            series = wandering(rng, "noise")[0] + rng.normal(0, SIGMA, RATE * SECONDS)
            series[rng.random(series.size) < gaps] = np.nan
            run = likelihood(series, RATE)
            rows = {c.parameter: c for c in run.estimate.coefficients}
            number.append(len(run.lines))
            size.append(rows["A_s"].lower_95 < A_S < rows["A_s"].upper_95)
            white.append(rows["h_0"].lower_95 < 2 * SIGMA**2 / RATE < rows["h_0"].upper_95)
        yield name, "findings a recording", "1", f"{np.mean(number):.2f}"
        yield name, "A_s: 95 % holds", ">= 90 %", percent(size)
        yield name, "h_0: 95 % holds", ">= 90 %", percent(white)


FILTERS: dict[str, Filter] = {
    "five-point mean": lambda x, _: np.convolve(x, np.ones(5) / 5, "valid"),
    "twelve-point mean": lambda x, _: np.convolve(x, np.ones(12) / 12, "valid"),
    **{f"Butterworth {cutoff} Hz": butterworth(cutoff) for cutoff in (6, 10, 20)},
    "Butterworth 20 Hz, second order, one way": lambda x, rate: lfilter(*butter(2, 20, fs=rate), x),
    "spline 6 Hz": woltring(6),
    "Savitzky-Golay 11, 3": savitzky_golay(11, 3),
}


def _filtered(n: int) -> Iterator[Part]:
    """White noise with a random walk, and a line of 3 Hz that all of the filters let pass."""
    wave = 0.003 * np.sin(2 * np.pi * 3 * np.arange(RATE * SECONDS) / RATE)
    for name, applied in FILTERS.items():
        invented, seen = 0, 0
        for seed in range(n):
            rng = np.random.default_rng(seed)
            noise = rng.normal(0, SIGMA, wave.size) + np.cumsum(rng.normal(0, 2e-4, wave.size))
            invented += bool(find_lines(applied(noise, RATE), RATE))
            seen += near(find_lines(applied(noise + wave, RATE), RATE), 3)
        yield name, "recordings with an invented line", "<= 1 %", f"{invented} of {n}"
        yield name, "line of 3 um at 3 Hz found", "", f"{seen} of {n}"


def _ends(n: int) -> Iterator[Part]:
    """A stable line of 15 um within two coefficients of Nyquist, in odd and even numbers."""
    rng = np.random.default_rng(1)
    crashed, found = 0, 0
    for _ in range(n):
        size = int(rng.integers(5000, 20_000))
        place = size / 2 - rng.uniform(0, 2)
        wave = A_S * np.sin(2 * np.pi * place / size * np.arange(size) + rng.uniform(0, 6.3))
        try:
            lines = found_in(rng, wave, 100)
        except IndexError:
            crashed += 1
            continue
        found += any(line.f_0 > 50 - 300 / size for line in lines)
    case = "stable line, 0-2 coefficients from Nyquist"
    yield case, "crashes", "0", f"{crashed} of {n}"
    yield case, "found", "", f"{found} of {n}"


def _stable(n: int) -> Iterator[Part]:
    for f_0, rate in ((20.0, 120), (49.992, 100)):
        drawn = (
            (rng, stable(rng, 0.005, f_0, rate)) for rng in map(np.random.default_rng, range(n))
        )
        found = [_judged(found_in(rng, wave, rate), 0.005, f_0) for rng, wave in drawn]
        yield from list(_told(f"stable line of 5 um, {f_0:g} Hz at {rate} Hz", found))[:4]


def _detected(n: int) -> Iterator[Part]:
    """A stable line of so many standard errors of its amplitude."""
    error = SIGMA * math.sqrt(2 / RATE / SECONDS)
    for times in (5, 6, 7):
        drawn = (
            (rng, stable(rng, times * error, 20)) for rng in map(np.random.default_rng, range(n))
        )
        found = sum(near(found_in(rng, wave), 20) for rng, wave in drawn)
        yield f"stable line of {times} standard errors", "found", "as before", f"{found} of {n}"


def _plain(n: int) -> Iterator[Part]:
    """White noise with and without a random walk, and blue noise."""
    for name, shaped in {"white": np.array, "random walk": np.cumsum, "blue": np.diff}.items():
        drawn = (np.random.default_rng(seed).normal(0, SIGMA, RATE * SECONDS) for seed in range(n))
        invented = sum(bool(find_lines(shaped(x), RATE)) for x in drawn)
        yield f"plain {name} noise", "series with an invented line", "<= 1 %", f"{invented} of {n}"
