"""Noise of many kinds, made here and not by the package: what the sentences are tried on.

Every kind is a function (rng, n, rate_hz) -> (n,) mm with about 0.05 mm of noise a frame.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import signal
from scipy.ndimage import gaussian_filter1d

Kind = Callable[[np.random.Generator, int, float], np.ndarray]
Filter = Callable[[np.ndarray, float], np.ndarray]  # of values and frame rate
SIGMA = 0.05


def white(rng: np.random.Generator, n: int, rate_hz: float) -> np.ndarray:
    return SIGMA * rng.standard_normal(n)


def coloured(exponent: float, size: float = SIGMA) -> Kind:
    """Density ~ f^exponent; sd of the differences of frames as of white noise of `size`."""

    def made(rng: np.random.Generator, n: int, rate_hz: float) -> np.ndarray:
        m = 1 << (2 * n - 1).bit_length()
        spectrum = rng.standard_normal(m // 2 + 1) + 1j * rng.standard_normal(m // 2 + 1)
        f = np.arange(1, m // 2 + 1) / m
        spectrum[0] = 0
        spectrum[1:] *= np.sin(np.pi * f) ** (exponent / 2)
        x = np.fft.irfft(spectrum, m)[:n]
        return size * np.sqrt(2) * x / np.std(np.diff(x))

    return made


def walk(step: float) -> Kind:
    return lambda rng, n, rate_hz: np.cumsum(step * rng.standard_normal(n))


def gauss_markov(t_c: float, sigma: float) -> Kind:
    """AR(1) of correlation time t_c in s, of standard deviation sigma in mm."""

    def made(rng: np.random.Generator, n: int, rate_hz: float) -> np.ndarray:
        phi = np.exp(-1 / (t_c * rate_hz))
        e = sigma * np.sqrt(1 - phi**2) * rng.standard_normal(n)
        e[0] = sigma * rng.standard_normal()
        return signal.lfilter([1], [1, -phi], e)

    return made


def line(amplitude: float, f_0: float, wander_hz: float = 0.0) -> Kind:
    def made(rng: np.random.Generator, n: int, rate_hz: float) -> np.ndarray:
        f = f_0 + wander_hz * gauss_markov(20.0, 1.0)(rng, n, rate_hz) if wander_hz else f_0
        phase = 2 * np.pi * np.cumsum(np.full(n, f) / rate_hz) + rng.uniform(0, 2 * np.pi)
        return amplitude * np.sin(phase)

    return made


def total(*kinds: Kind) -> Kind:
    return lambda rng, n, rate_hz: sum(k(rng, n, rate_hz) for k in kinds)


def rounded(kind: Kind, step: float) -> Kind:
    return lambda rng, n, rate_hz: (
        step * np.round((kind(rng, n, rate_hz) + rng.uniform(-1, 1)) / step)
    )


def student(dof: float) -> Kind:
    return lambda rng, n, rate_hz: SIGMA * rng.standard_t(dof, n) * np.sqrt((dof - 2) / dof)


def laplace(rng: np.random.Generator, n: int, rate_hz: float) -> np.ndarray:
    return rng.laplace(0, SIGMA / np.sqrt(2), n)


def contaminated(share: float, times: float) -> Kind:
    return lambda rng, n, rate_hz: (
        SIGMA * rng.standard_normal(n) * np.where(rng.random(n) < share, times, 1)
    )


def telegraph(rate: float, size: float) -> Kind:
    """Jumps between +-size at random, `rate` a second."""

    def made(rng: np.random.Generator, n: int, rate_hz: float) -> np.ndarray:
        flips = rng.random(n) < rate / rate_hz
        return size * (1 - 2 * ((np.cumsum(flips) + rng.integers(2)) % 2))

    return made


def levelled(kind: Kind, factor: Callable[[np.ndarray], np.ndarray]) -> Kind:
    """Noise times factor(t / T)."""
    return lambda rng, n, rate_hz: kind(rng, n, rate_hz) * factor(np.linspace(0, 1, n))


# Unfiltered and Gaussian
PLAIN: dict[str, Kind] = {
    "white": white,
    "strong walk": total(white, walk(0.05)),
    "walk alone": walk(0.02),
    "weak walk": total(white, walk(0.0005)),
    "flicker": total(white, coloured(-1.0, 0.05)),
    "flicker alone": coloured(-1.0),
    **{f"Gauss-Markov {t:g} s": gauss_markov(t, 0.1) for t in (0.005, 0.01, 0.02, 0.05, 0.2)},
    **{
        f"white, Gauss-Markov {t:g} s": total(white, gauss_markov(t, 0.2))
        for t in (0.02, 0.1, 1.0, 30.0, 300.0, 1000.0)
    },
    "two Gauss-Markov": total(white, gauss_markov(0.03, 0.3), gauss_markov(2.0, 0.3)),
    "blue": total(coloured(1.0), walk(0.005)),
    "violet": total(coloured(2.0), gauss_markov(1.0, 0.1)),
    "line 3 Hz": total(white, line(0.1, 3.2)),
    "line 4 Hz, wandering": total(white, line(0.1, 4.1, 0.3)),
    "line 20 Hz": total(white, line(0.2, 20.0)),
    "steps of 0.1 mm": rounded(white, 0.1),
    "steps of 0.05 mm, walk": rounded(total(white, walk(0.01)), 0.05),
    "steps of 0.1 mm, walk alone": rounded(walk(0.02), 0.1),
}


def butterworth(cutoff_hz: float, order: int = 2) -> Filter:
    """Forwards and backwards; so half the amplitude at the cutoff."""

    return lambda x, rate_hz: signal.sosfiltfilt(
        signal.butter(order, cutoff_hz, fs=rate_hz, output="sos"), x
    )


def woltring(cutoff_hz: float) -> Filter:
    """Quintic smoothing spline on even samples: 1 / (1 + (f/f_c)^6) [Craven & Wahba 1979]."""

    def filtered(x: np.ndarray, rate_hz: float) -> np.ndarray:
        mirrored = np.concatenate([x, x[::-1]])
        f = np.fft.rfftfreq(mirrored.size, 1 / rate_hz)
        return np.fft.irfft(np.fft.rfft(mirrored) / (1 + (f / cutoff_hz) ** 6), mirrored.size)[
            : x.size
        ]

    return filtered


def moving_average(size: int) -> Filter:
    return lambda x, rate_hz: np.convolve(x, np.full(size, 1 / size), "same")


def savitzky_golay(size: int, order: int) -> Filter:
    return lambda x, rate_hz: signal.savgol_filter(x, size, order)


def gaussian(sd: float) -> Filter:
    return lambda x, rate_hz: gaussian_filter1d(x, sd)


def half_amplitude(apply: Filter, rate_hz: float) -> float:
    """Cutoff of a linear filter, where it halves the amplitude."""
    x = np.zeros(1 << 14)
    x[x.size // 2] = 1.0
    gain = np.abs(np.fft.rfft(apply(x, rate_hz)))
    return float(np.argmax(gain < 0.5)) * rate_hz / x.size


FILTERS = {
    "Butterworth 6 Hz": butterworth(6.0),
    "Butterworth 6 Hz, 4th order": butterworth(6.0, 4),
    "Butterworth 10 Hz": butterworth(10.0),
    "Butterworth 20 Hz": butterworth(20.0),
    "Woltring 6 Hz": woltring(6.0),
    "Woltring 12 Hz": woltring(12.0),
    "five-point mean": moving_average(5),
    "Savitzky-Golay 11, 2": savitzky_golay(11, 2),
    "Gaussian of 1.2 frames": gaussian(1.2),
    "Gaussian of 3 frames": gaussian(3.0),
}


def fill(x: np.ndarray, starts: np.ndarray, size: int, how: str) -> np.ndarray:
    """(n,) with `size` frames from each start on filled: `linear`, or by a polynomial (`order 3`,
    `order 5`) through eight samples on both sides."""
    out = x.copy()
    for first in starts:
        last = first + size
        at, gap = np.r_[first - 8 : first, last : last + 8], np.arange(first, last)
        if how == "linear":
            out[gap] = np.interp(gap, at, x[at])
        else:
            middle, half = (first + last) / 2, size / 2 + 8
            fitted = np.polynomial.Polynomial.fit((at - middle) / half, x[at], int(how[-1]))
            out[gap] = fitted((gap - middle) / half)
    return out


def bursts(rng: np.random.Generator, n: int, size: int, share: float) -> np.ndarray:
    """Starts of gaps of `size` frames that make up `share` of n and do not touch."""
    count = max(round(share * n / size), 1)
    slots = rng.choice(n // (2 * size + 32) - 2, count, replace=False) + 1
    return np.sort(slots) * (2 * size + 32)
