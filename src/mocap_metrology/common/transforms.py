"""Fourier and cosine transforms of long series, without what they leave behind in memory.

scipy.fft keeps the tables of the last 16 lengths of each transform, of 16 bytes a sample: a cosine
and a Fourier transform of 90 hours at 120 Hz leave 1.2 GB. Transforms of 16 short lengths put them
out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

LONG = 1 << 22  # samples; nine hours at 120 Hz are fewer, and their tables are used again
KEPT = 16  # lengths


def rfft(series: np.ndarray, *given: Any, **how: Any) -> np.ndarray:
    """scipy.fft.rfft of a series (n,)."""
    from scipy.fft import rfft as transform

    return _transformed(transform, series, *given, **how)


def irfft(spectrum: np.ndarray, *given: Any, **how: Any) -> np.ndarray:
    """scipy.fft.irfft of a spectrum (n/2 + 1,)."""
    from scipy.fft import irfft as transform

    return _transformed(transform, spectrum, *given, **how)


def dct(series: np.ndarray, *given: Any, **how: Any) -> np.ndarray:
    """scipy.fft.dct of a series (n,)."""
    from scipy.fft import dct as transform

    return _transformed(transform, series, *given, **how)


def _transformed(
    transform: Callable[..., np.ndarray], values: np.ndarray, *given: Any, **how: Any
) -> np.ndarray:
    found = transform(values, *given, **how)
    if found.size > LONG:
        for size in range(KEPT):
            transform(np.zeros(size + 2))
    return found
