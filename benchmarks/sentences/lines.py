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
from collections.abc import Callable, Iterator

import numpy as np
from scipy.signal import butter, lfilter, savgol_filter, sosfiltfilt

from mocap_metrology.noise.fit.estimates import Z_95
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.lines import find_lines

RATE, SECONDS, SIGMA, A_S = 120, 600, 0.05, 0.015
BY = 0.02
Row = tuple[str, str, int, str, str, str]
Series = Callable[[np.random.Generator], np.ndarray]

# Of this module's generators at commit 8b8d0af, 100 recordings a case; a crash counts as no line
BEFORE: dict[tuple[str, str], str] = {
    ("mains wander, noise", "findings a recording"): "19.74",
    ("mains wander, noise", "A_s: 95 % holds"): "0 %",
    ("mains wander, noise", "f_0: 95 % holds"): "1 %",
    ("mains wander, up and down", "findings a recording"): "6.83",
    ("mains wander, up and down", "A_s: 95 % holds"): "0 %",
    ("mains wander, up and down", "f_0: 95 % holds"): "0 %",
    ("mains wander, random walk", "findings a recording"): "14.14",
    ("mains wander, random walk", "A_s: 95 % holds"): "0 %",
    ("mains wander, random walk", "f_0: 95 % holds"): "2 %",
    ("mains wander, noise, folded", "findings a recording"): "13.43",
    ("mains wander, noise, folded", "A_s: 95 % holds"): "0 %",
    ("mains wander, noise, folded", "f_0: 95 % holds"): "0 %",
    ("mains wander, up and down, folded", "findings a recording"): "3.14",
    ("mains wander, up and down, folded", "A_s: 95 % holds"): "4 %",
    ("mains wander, up and down, folded", "f_0: 95 % holds"): "0 %",
    ("mains wander, random walk, folded", "findings a recording"): "7.53",
    ("mains wander, random walk, folded", "A_s: 95 % holds"): "0 %",
    ("mains wander, random walk, folded", "f_0: 95 % holds"): "0 %",
    ("five-point mean", "recordings with an invented line"): "66 of 100",
    ("five-point mean", "line of 3 um at 3 Hz found"): "100 of 100",
    ("twelve-point mean", "recordings with an invented line"): "99 of 100",
    ("twelve-point mean", "line of 3 um at 3 Hz found"): "100 of 100",
    ("Butterworth 6 Hz", "recordings with an invented line"): "0 of 100",
    ("Butterworth 6 Hz", "line of 3 um at 3 Hz found"): "100 of 100",
    ("Butterworth 10 Hz", "recordings with an invented line"): "0 of 100",
    ("Butterworth 10 Hz", "line of 3 um at 3 Hz found"): "100 of 100",
    ("Butterworth 20 Hz", "recordings with an invented line"): "1 of 100",
    ("Butterworth 20 Hz", "line of 3 um at 3 Hz found"): "100 of 100",
    ("Butterworth 20 Hz, second order, one way", "recordings with an invented line"): "79 of 100",
    ("Butterworth 20 Hz, second order, one way", "line of 3 um at 3 Hz found"): "100 of 100",
    ("spline 6 Hz", "recordings with an invented line"): "0 of 100",
    ("spline 6 Hz", "line of 3 um at 3 Hz found"): "100 of 100",
    ("Savitzky-Golay 11, 3", "recordings with an invented line"): "100 of 100",
    ("Savitzky-Golay 11, 3", "line of 3 um at 3 Hz found"): "100 of 100",
    ("stable line, 0-2 coefficients from Nyquist", "crashes"): "26 of 100",
    ("stable line, 0-2 coefficients from Nyquist", "found"): "71 of 100",
    ("stable line of 5 um, 20 Hz at 120 Hz", "findings a recording"): "1.01",
    ("stable line of 5 um, 20 Hz at 120 Hz", "A_s: 95 % holds"): "93 %",
    ("stable line of 5 um, 20 Hz at 120 Hz", "f_0: 95 % holds"): "92 %",
    ("stable line of 5 um, 49.992 Hz at 100 Hz", "findings a recording"): "1.00",
    ("stable line of 5 um, 49.992 Hz at 100 Hz", "A_s: 95 % holds"): "97 %",
    ("stable line of 5 um, 49.992 Hz at 100 Hz", "f_0: 95 % holds"): "91 %",
    ("stable line of 5 standard errors", "found"): "18 of 100",
    ("stable line of 6 standard errors", "found"): "58 of 100",
    ("stable line of 7 standard errors", "found"): "89 of 100",
    ("plain white noise", "series with an invented line"): "1 of 100",
    ("plain random walk noise", "series with an invented line"): "1 of 100",
    ("plain blue noise", "series with an invented line"): "1 of 100",
}


def rows(n: int) -> Iterator[Row]:
    """(case, statistic, runs, reach, at 8b8d0af, measured); n recordings a case."""
    parts = (_wandering, _by_likelihood, _filtered, _ends, _stable, _detected, _plain)
    for part in parts:
        for case, statistic, reach, measured in part(n):
            yield case, statistic, n, reach, BEFORE.get((case, statistic), ""), measured


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


def _wandering(n: int) -> Iterator[tuple[str, str, str, str]]:
    for rate in (120, 100):
        for kind in ("noise", "up and down", "random walk"):
            name = f"mains wander, {kind}" + (", folded" if rate == 100 else "")
            found = []
            for seed in range(n):
                rng = np.random.default_rng(seed)
                wave, f_0 = wandering(rng, kind, rate)
                lines = find_lines(wave + rng.normal(0, SIGMA, wave.size), rate)
                found.append((*_holds(lines, A_S, min(f_0, rate - f_0)), len(lines)))
            yield from _told(name, found)


def _told(name: str, found: list[tuple[float, ...]]) -> Iterator[tuple[str, str, str, str]]:
    size, frequency, error, width, number = np.array(found, float).T
    yield name, "findings a recording", "1", f"{number.mean():.2f}"
    yield name, "A_s: 95 % holds", ">= 90 %", _percent(size)
    yield name, "f_0: 95 % holds", ">= 90 %", _percent(frequency)
    reach = "" if "folded" in name else "<= 1.5"
    yield name, "A_s: standard error over bound", reach, f"{np.nanmedian(error):.2f}"
    yield name, "width_f, mHz", "", f"{1e3 * np.nanmedian(width):.1f}"


def _holds(lines: list, A_s: float, f_0: float) -> tuple[float, float, float, float]:
    """Of the strongest line: whether both intervals hold, A_s's error over the bound, width_f."""
    if not lines:
        return 0.0, 0.0, math.nan, math.nan
    line = lines[0]
    errors = line.errors(SECONDS)
    size = abs(math.log(line.A_s / A_s)) < Z_95 * errors[0] / line.A_s
    frequency = abs(line.f_0 - f_0) < Z_95 * errors[1]
    return size, frequency, errors[0] / math.sqrt(line.psd / SECONDS), line.width_f


def _by_likelihood(n: int) -> Iterator[tuple[str, str, str, str]]:
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
        yield name, "A_s: 95 % holds", ">= 90 %", _percent(size)
        yield name, "h_0: 95 % holds", ">= 90 %", _percent(white)


def _both_ways(cutoff: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda x: sosfiltfilt(butter(2, cutoff, fs=RATE, output="sos"), x)


def spline(cutoff: float) -> Callable[[np.ndarray], np.ndarray]:
    """Woltring's quintic smoothing spline, far from the ends: gain 1/(1 + (f/f_c)^6)."""

    def smoothed(x: np.ndarray) -> np.ndarray:
        looped = np.concatenate([x, x[::-1]])
        f = np.fft.rfftfreq(looped.size, 1 / RATE)
        gain = 1 / (1 + (f / cutoff) ** 6)
        return np.fft.irfft(np.fft.rfft(looped) * gain, looped.size)[: x.size]

    return smoothed


FILTERS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "five-point mean": lambda x: np.convolve(x, np.ones(5) / 5, "valid"),
    "twelve-point mean": lambda x: np.convolve(x, np.ones(12) / 12, "valid"),
    "Butterworth 6 Hz": _both_ways(6),
    "Butterworth 10 Hz": _both_ways(10),
    "Butterworth 20 Hz": _both_ways(20),
    "Butterworth 20 Hz, second order, one way": lambda x: lfilter(*butter(2, 20, fs=RATE), x),
    "spline 6 Hz": spline(6),
    "Savitzky-Golay 11, 3": lambda x: savgol_filter(x, 11, 3),
}


def _filtered(n: int) -> Iterator[tuple[str, str, str, str]]:
    """White noise with a random walk, and a line of 3 Hz that all of the filters let pass."""
    wave = 0.003 * np.sin(2 * np.pi * 3 * np.arange(RATE * SECONDS) / RATE)
    for name, applied in FILTERS.items():
        invented, seen = 0, 0
        for seed in range(n):
            rng = np.random.default_rng(seed)
            noise = rng.normal(0, SIGMA, wave.size) + np.cumsum(rng.normal(0, 2e-4, wave.size))
            invented += bool(find_lines(applied(noise), RATE))
            found = find_lines(applied(noise + wave), RATE)
            seen += any(abs(line.f_0 - 3) < 2 / SECONDS for line in found)
        yield name, "recordings with an invented line", "<= 1 %", f"{invented} of {n}"
        yield name, "line of 3 um at 3 Hz found", "", f"{seen} of {n}"


def _ends(n: int) -> Iterator[tuple[str, str, str, str]]:
    """A stable line of 15 um within two coefficients of Nyquist, in odd and even numbers."""
    rng = np.random.default_rng(1)
    crashed, found = 0, 0
    for _ in range(n):
        size = int(rng.integers(5000, 20_000))
        place = size / 2 - rng.uniform(0, 2)
        wave = A_S * np.sin(2 * np.pi * place / size * np.arange(size) + rng.uniform(0, 6.3))
        try:
            lines = find_lines(wave + rng.normal(0, SIGMA, size), 100)
        except IndexError:
            crashed += 1
            continue
        found += any(line.f_0 > 50 - 300 / size for line in lines)
    yield "stable line, 0-2 coefficients from Nyquist", "crashes", "0", f"{crashed} of {n}"
    yield "stable line, 0-2 coefficients from Nyquist", "found", "", f"{found} of {n}"


def _stable(n: int) -> Iterator[tuple[str, str, str, str]]:
    for f_0, rate in ((20.0, 120), (49.992, 100)):
        found = []
        for seed in range(n):
            rng = np.random.default_rng(seed)
            t = np.arange(rate * SECONDS) / rate
            wave = 0.005 * np.sin(2 * np.pi * f_0 * t + rng.uniform(0, 2 * np.pi))
            lines = find_lines(wave + rng.normal(0, SIGMA, t.size), rate)
            found.append((*_holds(lines, 0.005, f_0), len(lines)))
        yield from list(_told(f"stable line of 5 um, {f_0:g} Hz at {rate} Hz", found))[:4]


def _detected(n: int) -> Iterator[tuple[str, str, str, str]]:
    """A stable line of so many standard errors of its amplitude."""
    error = SIGMA * math.sqrt(2 / RATE / SECONDS)
    t = np.arange(RATE * SECONDS) / RATE
    for times in (5, 6, 7):
        found = 0
        for seed in range(n):
            rng = np.random.default_rng(seed)
            wave = times * error * np.sin(2 * np.pi * 20 * t + rng.uniform(0, 2 * np.pi))
            lines = find_lines(wave + rng.normal(0, SIGMA, t.size), RATE)
            found += any(abs(line.f_0 - 20) < 2 / SECONDS for line in lines)
        yield f"stable line of {times} standard errors", "found", "as before", f"{found} of {n}"


def _plain(n: int) -> Iterator[tuple[str, str, str, str]]:
    """White noise with and without a random walk, and blue noise."""
    kinds: dict[str, Series] = {
        "white": lambda rng: rng.normal(0, SIGMA, RATE * SECONDS),
        "random walk": lambda rng: np.cumsum(rng.normal(0, SIGMA, RATE * SECONDS)),
        "blue": lambda rng: np.diff(rng.normal(0, SIGMA, RATE * SECONDS)),
    }
    for name, drawn in kinds.items():
        invented = sum(
            bool(find_lines(drawn(np.random.default_rng(seed)), RATE)) for seed in range(n)
        )
        yield f"plain {name} noise", "series with an invented line", "<= 1 %", f"{invented} of {n}"


def _percent(hold: np.ndarray | list) -> str:
    return f"{100 * np.mean(hold):.0f} %"
