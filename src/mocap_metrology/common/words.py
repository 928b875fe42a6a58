"""Numbers within sentences."""

from __future__ import annotations


def three(value: float, sign: str = "") -> str:
    """Three digits without a power of ten above 0.0001: `0.246`, `2020`; sign: `+` or nothing.

    `%.3g` alone makes 2.02e+03 of 2020.
    """
    rounded = float(f"{value:.3g}")
    return f"{rounded:{sign}.0f}" if abs(rounded) >= 1000 else f"{rounded:{sign}g}"
