"""Curves of a fitted model beside its data: Allan variances at many averaging times, intervals and
residuals of binned spectra."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd

from mocap_metrology.noise.model.components import (
    Component,
    Form,
    NoiseModel,
    PowerLaw,
    Sinusoid,
    unit_avar,
)
from mocap_metrology.noise.model.deterministic import Deterministic

PER_DECADE = 120  # points of a curve: eight a period for the first six periods of a sinusoid
PERIODS = 6  # of a sinusoid drawn one by one; then their envelope
SPECTRUM = ("f_hz", "f_lower_hz", "f_upper_hz", "psd_mm2_hz", "dof")


def recorded_s(allan: Mapping[str, np.ndarray], frame_rate_hz: float) -> float:
    """Duration, s, of the series of columns `m` and `n_terms` of an overlapping Allan deviation:
    n frames have n - 2m + 1 terms, and fewer only where gaps are long beside m."""
    m, terms = (np.asarray(allan[k], float) for k in ("m", "n_terms"))
    return float(np.max(terms + 2 * m - 1, initial=0.0)) / frame_rate_hz


def drawn_m(last: int) -> np.ndarray:
    """Averaging factors to draw a model at, from 1 to `last`."""
    count = int(np.log10(max(last, 2)) * PER_DECADE) + 2
    return np.unique(np.geomspace(1, max(last, 2), count).round().astype(np.int64))


def total_avar(
    components: Iterable[Component | Deterministic],
    m: np.ndarray,
    frame_rate_hz: float,
    form: Form,
    duration_s: float = 0.0,
) -> np.ndarray:
    """Allan variance, mm^2, of the sum of components at whole m (k,); duration_s: of the series, on
    which that of a warm-up depends."""
    total = np.zeros(len(m))
    for c in components:
        if isinstance(c, PowerLaw):
            key = np.asarray(m, float).tobytes()
            total += c.h * unit_avar(c.alpha, form, frame_rate_hz, key)
        elif isinstance(c, Deterministic):
            total += c.avar(np.asarray(m, float) / frame_rate_hz, duration_s)
        else:
            total += c.avar(m, frame_rate_hz, form)
    return total


def sinusoid_avar(line: Sinusoid, m: np.ndarray, frame_rate_hz: float, form: Form) -> np.ndarray:
    """Allan variance of a sinusoid to draw: its envelope where its periods are too narrow."""
    values = line.avar(m, frame_rate_hz, form)
    x = np.pi * line.f_0 / frame_rate_hz
    gain = np.sin(x) if form == "sampled" else x
    if abs(gain) < 1e-12 * max(1.0, x):
        return values
    narrow = m * line.f_0 / frame_rate_hz > PERIODS
    return np.where(narrow, line.A_s**2 / (m * gain) ** 2, values)


def spectrum_of(columns: Mapping[str, np.ndarray]) -> pd.DataFrame:
    """Rows of periodogram.parquet of one series, bins without a density omitted."""
    rows = pd.DataFrame({name: np.asarray(columns[name], float) for name in SPECTRUM})
    return rows[(rows["f_hz"] > 0) & (rows["psd_mm2_hz"] >= 0) & (rows["dof"] > 0)]


def density_interval(spectrum: pd.DataFrame, confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """Interval of the density, from the chi-squared distribution of dof."""
    from scipy.special import gammaincinv

    half = spectrum["dof"].to_numpy() / 2
    low, high = (gammaincinv(half, q) for q in ((1 + confidence) / 2, (1 - confidence) / 2))
    psd = spectrum["psd_mm2_hz"].to_numpy() * half
    return psd / low, psd / high


def line_density(
    spectrum: pd.DataFrame, line: Sinusoid, frame_rate_hz: float, form: Form
) -> np.ndarray:
    """What a sinusoid adds to each bin's density: A^2/2 over its width, A as recorded."""
    low, high = spectrum["f_lower_hz"].to_numpy(), spectrum["f_upper_hz"].to_numpy()
    power = line.recorded(frame_rate_hz, form) ** 2 / 2
    return np.where((low <= line.f_0) & (line.f_0 < high), power / (high - low), 0.0)


def density_residual(spectrum: pd.DataFrame, model: NoiseModel, frame_rate_hz: float) -> np.ndarray:
    """(data / model - 1) in standard deviations sqrt(2 / dof) of a spectrum that sinusoids were
    subtracted from; NaN where the model is zero."""
    expected = model.psd(spectrum["f_hz"].to_numpy(), frame_rate_hz)
    psd = spectrum["psd_mm2_hz"].to_numpy()
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.where(expected > 0, psd / expected - 1, np.nan)
    return off / np.sqrt(2 / spectrum["dof"].to_numpy())
