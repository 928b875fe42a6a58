"""Fourier and cosine transforms of long series, without what they leave behind in memory.

scipy.fft keeps the tables of the last 16 lengths of each transform, of 16 bytes a sample: a cosine
and a Fourier transform of 90 hours at 120 Hz leave 1.2 GB. Transforms of 16 short lengths put them
out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

LONG = 1 << 22  # samples; nine hours at 120 Hz are fewer, and their tables are used again
KEPT = 16  # lengths


def rfft(series: np.ndarray, *args: Any, **options: Any) -> np.ndarray:
    """scipy.fft.rfft of a series (n,)."""
    return _transformed("rfft", series, *args, **options)


def irfft(spectrum: np.ndarray, *args: Any, **options: Any) -> np.ndarray:
    """scipy.fft.irfft of a spectrum (n/2 + 1,)."""
    return _transformed("irfft", spectrum, *args, **options)


def dct(series: np.ndarray, *args: Any, **options: Any) -> np.ndarray:
    """scipy.fft.dct of a series (n,)."""
    return _transformed("dct", series, *args, **options)


def _transformed(name: str, values: np.ndarray, *args: Any, **options: Any) -> np.ndarray:
    import scipy.fft

    transform = getattr(scipy.fft, name)
    result: np.ndarray = transform(values, *args, **options)
    if result.size > LONG:
        for size in range(KEPT):
            transform(np.zeros(size + 2))
    return result
