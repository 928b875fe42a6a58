"""One sinusoid fitted to the Fourier coefficients next to it, up to Nyquist and its fold."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mocap_metrology.noise.fit.spectral.line_of import Line

NEAR = 8  # coefficients on each side that the least squares uses: 99 % of a line's power
END_FRAMES = 16  # averaged at each end for the ramp
FOLD, STEP = 2.0, 1e-3  # coefficients from Nyquist that a line overlaps with its fold; a derivative
APART = 6.0  # gain by not being Nyquist: chi-squared of two, 95 %
DETERMINED = 0.5  # relative error of A_s beyond which it is not


def without_ramp(series: np.ndarray) -> np.ndarray:
    """Less the straight line through the means of both ends: a loop has no jump to leak."""
    width = min(END_FRAMES, series.size // 2)
    jump = series[-width:].mean() - series[:width].mean()
    slope = jump / max(series.size - width, 1)
    out = np.arange(series.size, dtype=np.float64)
    out *= -slope
    out += series
    out -= out.mean()
    return out


def kernel(f_0: float, k: np.ndarray, n: int, tau0: float) -> np.ndarray:
    """(2, k): Fourier coefficients k >= 1 of cos and sin (2 pi f_0 t) over n frames, less the ramp
    `without_ramp` takes from them, in closed form."""
    forward, backward = (_dirichlet(sign * f_0 * tau0 - k / n, n) for sign in (1, -1))
    waves = np.stack([(forward + backward) / 2, (forward - backward) / 2j])
    width = min(END_FRAMES, n // 2)
    angle = 2 * np.pi * f_0 * tau0 * np.stack([np.arange(width), np.arange(n - width, n)])
    ends = np.stack([np.cos(angle), np.sin(angle)]).mean(axis=2)
    slope = (ends[:, 1] - ends[:, 0]) / max(n - width, 1)
    ramp = n / np.expm1(-2j * np.pi * k / n)
    return waves - slope[:, None] * ramp


def _dirichlet(delta: np.ndarray, n: int) -> np.ndarray:
    """sum of exp(2 pi i delta t), t = 0 ... n - 1."""
    delta = delta - np.rint(delta)
    sine = np.sin(np.pi * delta)
    safe = np.where(np.abs(sine) < 1e-15, 1.0, sine)
    size = np.where(np.abs(sine) < 1e-15, n, np.sin(np.pi * n * delta) / safe)
    return np.exp(1j * np.pi * (n - 1) * delta) * size


def refined(spectrum: np.ndarray, start: float, n: int, tau0: float, psd: float) -> Line:
    """Least squares of the coefficients within NEAR of `start` (in units of 1/T)."""
    from scipy.optimize import minimize_scalar

    k = np.arange(max(1, round(start) - NEAR), min(spectrum.size - 1, round(start) + NEAR) + 1)
    root = np.where(2 * k == n, math.sqrt(0.5), 1.0)  # Nyquist's coefficient is real

    def stacked(parts: np.ndarray) -> np.ndarray:
        return np.concatenate([root * parts.real, root * parts.imag], axis=-1)

    y = stacked(spectrum[k])

    def solved(place: float) -> tuple[np.ndarray, float]:
        matrix = stacked(kernel(place / (n * tau0), k, n, tau0)).T
        x, *_ = np.linalg.lstsq(matrix, y, rcond=None)
        return x, float(np.sum((y - matrix @ x) ** 2))

    best = minimize_scalar(
        lambda place: solved(place)[1],
        bounds=(max(start - 1, 0.5), min(start + 1, n / 2)),
        method="bounded",
        options={"xatol": 1e-6},
    )
    x, rest = solved(best.x)
    gain = float((np.sum(y**2) - rest) * 2 * tau0 / n / psd * 2)
    line = Line(math.hypot(*x), float(best.x) / (n * tau0), math.atan2(*x), psd, gain)
    if best.x < n / 2 - FOLD:
        return line
    slope = stacked(_slope(best.x, x, k, n, tau0))
    matrix = np.vstack([stacked(kernel(line.f_0, k, n, tau0)), slope]).T
    whole = _folded(line, x, matrix, n, tau0)
    half = _alternating(line, stacked(kernel(0.5 / tau0, k, n, tau0))[0], y, n, tau0)
    return whole if whole and line.gain - half.gain > APART else half


def _slope(place: float, x: np.ndarray, k: np.ndarray, n: int, tau0: float) -> np.ndarray:
    """Change of a line's coefficients with its place in units of 1/T."""
    low, high = (kernel((place + step) / (n * tau0), k, n, tau0) for step in (-STEP, STEP))
    return x @ (high - low) / (2 * STEP)


def _folded(line: Line, x: np.ndarray, matrix: np.ndarray, n: int, tau0: float) -> Line | None:
    """A line so near to Nyquist that it overlaps with its own fold, with errors by the inverse
    information; None where they leave its size open."""
    noise = math.sqrt(line.psd * n / (4 * tau0))  # of a part of a coefficient
    information = matrix.T @ matrix / noise**2
    scale = 1 / np.sqrt(np.maximum(np.diag(information), np.finfo(float).tiny))
    covariance = np.linalg.pinv(information * np.outer(scale, scale), 1e-12) * np.outer(
        scale, scale
    )
    along = np.array([*(x / max(line.A_s, np.finfo(float).tiny)), 0.0])
    A_error = math.sqrt(max(along @ covariance @ along, 0.0))
    f_error = min(math.sqrt(max(covariance[2, 2], 0.0)), 1.0) / (n * tau0)
    sure = np.linalg.eigvalsh(information * np.outer(scale, scale))[0] > 1e-10
    if sure and A_error < DETERMINED * line.A_s:
        return replace(line, A_error=A_error, f_error=f_error)
    return None


def _alternating(line: Line, wave: np.ndarray, y: np.ndarray, n: int, tau0: float) -> Line:
    """The line as a difference of odd and even frames; wave: coefficients of cos(pi t / tau0)."""
    energy = float(wave @ wave)
    size = float(wave @ y) / energy
    gain = size**2 * energy * 4 * tau0 / n / line.psd
    nyquist, step = 0.5 / tau0, 1 / (n * tau0)
    return Line(
        abs(size), nyquist, math.copysign(math.pi / 2, size), line.psd, gain,
        f_error=min(max(nyquist - line.f_0, step / 4), step),
    )  # fmt: skip
