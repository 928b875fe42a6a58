"""Columns of the stored results of noise analysis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:  # what stores a curve need not depend on all that makes one
    from mocap_metrology.noise.allan.confidence import AllanCurve
    from mocap_metrology.noise.fit.spectral.periodogram import Periodogram

ALLAN = (
    *("series", "estimator", "m", "tau_s", "avar_mm2", "adev_mm", "n_terms", "alpha", "edf"),
    *("adev_lower_mm", "adev_upper_mm"),
)
PERIODOGRAM = ("series", "f_hz", "f_lower_hz", "f_upper_hz", "psd_mm2_hz", "dof", "stretch_s")


def allan_columns(series: str, curve: AllanCurve, estimator: str = "oadev") -> dict[str, Any]:
    """Columns of allan.parquet of one series and estimator."""
    k = curve.m.size
    values = (
        *(np.full(k, series, dtype=object), np.full(k, estimator, dtype=object)),
        *(curve.m, curve.tau_s, curve.variance, curve.deviation, curve.n_terms, curve.alpha),
        *(curve.edf, curve.lower, curve.upper),
    )
    return dict(zip(ALLAN, values, strict=True))


def periodogram_columns(series: str, found: Periodogram | None) -> dict[str, Any]:
    """Columns of periodogram.parquet of one series: what the likelihood was fitted to, lines
    subtracted; stretch_s is the duration of the stretch without long gaps a bin comes from."""
    if found is None:
        return {name: np.array([]) for name in PERIODOGRAM}
    bins = found.bins
    values = (
        *(np.full(bins.n.size, series, dtype=object), bins.centre_hz, bins.f_lower_hz),
        *(bins.f_upper_hz, found.psd, found.weight, bins.duration_s),
    )
    return dict(zip(PERIODOGRAM, values, strict=True))


def joined(parts: Sequence[Mapping[str, Any]], names: Sequence[str]) -> dict[str, Any]:
    """The parts one below the other; columns `names` even without a part."""
    return {
        name: np.concatenate([p[name] for p in parts]) if parts else np.array([]) for name in names
    }
