"""A line of a spectrum: a sinusoid, or a band that one of wandering frequency fills."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

ROW = 2048  # samples of a sinusoid made at once


@dataclass(frozen=True)
class Line:
    """A_s sin(2 pi f_0 t + phase), t = 0 at the first frame; psd: density of the noise at f_0;
    gain: rise of twice the log likelihood by the line, A_s^2 T / psd.

    width_f (Hz): 0 for a sinusoid, else as `wide_line` defines it; such a line fills `band_hz`, has
    no phase (NaN), and its wave is that of the Fourier coefficients `parts`, from number `first`
    on, of `period` samples. A_error, f_error, width_error: standard errors where they are greater
    than those of `line_errors`, else 0.
    """

    A_s: float
    f_0: float
    phase: float
    psd: float
    gain: float
    width_f: float = 0.0
    A_error: float = 0.0
    f_error: float = 0.0
    width_error: float = 0.0
    band_hz: tuple[float, float] | None = None
    parts: np.ndarray | None = field(default=None, repr=False, compare=False)
    first: int = 0
    period: int = 0

    @property
    def wide(self) -> bool:
        """Whether it is wider than the recording resolves."""
        return self.band_hz is not None

    def wave(self, n: int, tau0: float) -> np.ndarray:
        """(n,) samples; the sine of a sum of a slow and a fast angle, so few sines are taken."""
        if self.parts is not None:
            return self._band(n)
        step = 2 * np.pi * self.f_0 * tau0
        fast = step * np.arange(ROW)
        slow = step * ROW * np.arange(-(-n // ROW))[:, None] + self.phase
        rows = (self.A_s * np.sin(slow)) * np.cos(fast)
        rows += (self.A_s * np.cos(slow)) * np.sin(fast)
        return rows.ravel()[:n]

    def _band(self, n: int) -> np.ndarray:
        from scipy.fft import irfft

        spectrum = np.zeros(self.period // 2 + 1, complex)
        spectrum[self.first : self.first + self.parts.size] = self.parts
        wave = irfft(spectrum, self.period, overwrite_x=True)
        return wave if n == self.period else np.resize(wave, n)

    def errors(self, duration_s: float, psd: float | None = None) -> tuple[float, float]:
        """Standard errors of A_s and f_0 in noise of density `psd` (default: its own)."""
        own = line_errors(self.A_s, self.psd if psd is None else psd, duration_s)
        return max(own[0], self.A_error), max(own[1], self.f_error)


def line_errors(A_s: float, psd: float, duration_s: float) -> tuple[float, float]:
    """Least standard errors (Cramer-Rao) of A_s and f_0 of a sinusoid of unknown phase in noise of
    one-sided density `psd`: sqrt(S/T) and sqrt(3 S / (pi^2 A^2 T^3)) [Rife & Boorstyn 1974]."""
    if not A_s > 0:
        return math.sqrt(psd / duration_s), math.inf
    return (
        math.sqrt(psd / duration_s),
        math.sqrt(3 * psd / (math.pi**2 * A_s**2 * duration_s**3)),
    )
