"""The steps of the file against the noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

FINE, MOST = 0.01, 0.5  # shares of the Allan variance at one frame
LEAST_DITHER = 0.3  # steps of noise below which rounding is no white noise any more


@dataclass(frozen=True)
class Resolution:
    """One series: rounding_h0, white level that rounding adds, mm^2/Hz; noise_mm: Allan deviation
    at one frame, all together; share: of its square that rounding makes."""

    series: str
    step_mm: float
    kind: str
    rounding_mm: float
    rounding_h0: float
    noise_mm: float
    share: float

    @property
    def dithered(self) -> bool:
        """Whether the noise moves values from step to step, so that q^2/12 holds."""
        return self.noise_mm >= LEAST_DITHER * self.step_mm

    @property
    def word(self) -> str:
        """`fine`, `noticeable`, `dominates`, or `unknown`."""
        if math.isnan(self.share):
            return "unknown"
        if self.share > MOST or not self.dithered:
            return "dominates"
        return "fine" if self.share < FINE else "noticeable"


def resolution(
    series: str, step_mm: float, kind: str, avar_1: float, tau0: float, distance: bool = False
) -> Resolution:
    """Rounding to steps q adds white noise of variance q^2/12, one-sided density h_0 = q^2 tau0/6
    [Widrow, 1956], as long as the noise moves values from step to step; a distance has that of both
    its ends, q^2/6. avar_1: Allan variance at one frame, mm^2, that of white noise its variance."""
    variance = step_mm**2 / 12 * (2 if distance else 1)
    share = min(variance / avar_1, 1.0) if avar_1 > 0 else (1.0 if avar_1 == 0 else math.nan)
    noise = math.sqrt(avar_1) if avar_1 >= 0 else math.nan
    return Resolution(series, step_mm, kind, math.sqrt(variance), 2 * tau0 * variance, noise, share)
