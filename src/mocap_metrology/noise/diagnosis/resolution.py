"""The steps of the file against the noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

FINE, MOST = 0.01, 0.2  # shares of the Allan variance at one frame
DOMINATES: Final = "dominates"


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
    def word(self) -> Literal["fine", "noticeable", "dominates", "unknown"]:
        """What it does to the noise; `unknown` without any."""
        if math.isnan(self.share):
            return "unknown"
        if self.share > MOST:
            return DOMINATES
        return "fine" if self.share < FINE else "noticeable"

    def share_of(self, step_mm: float) -> float:
        """What steps of another size would add to the noise, of its square."""
        return step_mm**2 / 12 / self.noise_mm**2 if self.noise_mm > 0 else math.inf


def resolution(
    series: str, step_mm: float, kind: str, avar_1: float, tau0: float, distance: bool = False
) -> Resolution:
    """Rounding to steps q adds white noise of variance q^2/12, one-sided density h_0 = q^2 tau0/6
    [Widrow, 1956], as long as the noise moves values from step to step; a distance has that of both
    its ends, q^2/6. avar_1: Allan variance at one frame, mm^2, that of white noise its variance.

    Of Gaussian noise sigma = s q, what is stored has, beside sigma^2 + q^2/12, a variance of
    (q^2/pi^2 + 4 sigma^2) exp(-2 pi^2 s^2) cos(2 pi x/q), x being where in a step the marker is;
    and slow noise passes 1 + 2 exp(-2 pi^2 s^2) cos(2 pi x/q) times. From s = 0.58 on, a share of a
    fifth, either moves an Allan deviation by 0.3 % at most; at s = 0.4 by 6 and 8 %, and below that
    the place within a step decides. A share above a fifth therefore `dominates`: the largest that
    sigma < 0.42 q can seem, just between two steps, is q^2/4, a share of a third.
    """
    variance = step_mm**2 / 12 * (2 if distance else 1)
    share = rounding_share(step_mm, avar_1, distance)
    noise = math.sqrt(avar_1) if avar_1 >= 0 else math.nan
    return Resolution(series, step_mm, kind, math.sqrt(variance), 2 * tau0 * variance, noise, share)


def rounding_share(step_mm: float, avar_1: float, distance: bool = False) -> float:
    """Share of the Allan variance at one frame that rounding to steps makes; 1 of a constant."""
    if not avar_1 >= 0:
        return math.nan
    if not step_mm:
        return 0.0
    variance = step_mm**2 / 12 * (2 if distance else 1)
    return min(variance / avar_1, 1.0) if avar_1 > 0 else 1.0
