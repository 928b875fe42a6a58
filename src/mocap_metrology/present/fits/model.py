"""A fitted model as a figure shows it: its components with their values, and its curves."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby

import numpy as np
import pandas as pd

from mocap_metrology.noise.fit.estimates import (
    NoiseRow,
    correlation_class,
    deterministic_of,
    limit_class,
    model_of,
)
from mocap_metrology.noise.model.components import (
    Component,
    Form,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)
from mocap_metrology.noise.model.deterministic import PARAMETERS as DETERMINISTIC
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.present.text.coefficients import symbol, unit
from mocap_metrology.present.text.numbers import significant, with_uncertainty

PER_DECADE = 120  # points of a curve: eight a period for the first six periods of a sinusoid
PERIODS = 6  # of a sinusoid drawn one by one; then their envelope
EXACT = 1e-5  # relative error of a frequency below which only its value is written
SPECTRUM = ("f_hz", "f_lower_hz", "f_upper_hz", "psd_mm2_hz", "dof")


@dataclass(frozen=True)
class Under:
    """A deterministic part in a series of `duration_s`: it has an Allan variance and no density."""

    part: Deterministic
    duration_s: float

    def avar(self, m: np.ndarray, frame_rate_hz: float, form: Form = "sampled") -> np.ndarray:
        """(k,) mm^2 at whole m (k,), of frames of either form: it is slow."""
        return self.part.avar(np.asarray(m, float) / frame_rate_hz, self.duration_s)


@dataclass(frozen=True)
class Part:
    """One component: its name, and its name with its value."""

    component: Component | Under
    name: str
    text: str


@dataclass(frozen=True)
class Fit:
    """One estimate: its model, the form of the Allan variances it was fitted in, its parts, what it
    did not detect, with upper limits, and in words the deterministic part and what is wrong. The
    model is of the noise alone, the parts are of all that was detected."""

    estimator: str
    form: Form
    model: NoiseModel
    parts: tuple[Part, ...]
    absent: tuple[str, ...]
    under: str = ""
    trouble: str = ""


def recorded_s(allan: Mapping[str, np.ndarray], frame_rate_hz: float) -> float:
    """Duration, s, of the series of columns `m` and `n_terms` of an overlapping Allan deviation:
    n frames have n - 2m + 1 terms, and fewer only where gaps are long beside m."""
    m, terms = (np.asarray(allan[k], float) for k in ("m", "n_terms"))
    return float(np.max(terms + 2 * m - 1, initial=0.0)) / frame_rate_hz


def fit_of(estimator: str, rows: Iterable[NoiseRow], duration_s: float = 0.0) -> Fit:
    """A fit out of rows of noise.csv of one series and estimator; duration_s: of the series, on
    which the Allan variance of a warm-up depends."""
    rows = [row for row in rows if row["estimator"] == estimator]
    usable, parts = [], []
    for key, group in groupby(sorted(rows, key=_order), key=_order):
        own = list(group)
        finite = [row for row in own if np.isfinite(_number(row["value"]))]
        if key[0] < 3 and (len(finite) < len(own) or not all(map(_drawable, own))):
            continue
        usable += finite
        if key[0] == 3:
            found = deterministic_of(finite)
            component: Component | Under = Under(found, duration_s)
            if found.empty:
                continue
            name = found.name
            own = [row for row in finite if getattr(found, row["parameter"])]
            prefix = "" if found.drift else f"{name}: "
        else:
            component = model_of(own).components[0]
            name = {0: symbol(own[0]["parameter"]), 1: f"GM {key[1]}", 2: "sinusoid"}[key[0]]
            prefix = f"{name}: " if key[0] else ""
        parts.append(Part(component, name, prefix + ", ".join(map(_value, own))))
    absent = tuple(_limit(row) for row in rows if np.isfinite(_upper(row)))
    under = next(
        (p.text.removeprefix("warm-up: ") for p in parts if p.name in ("drift", "warm-up")), ""
    )
    odd = (row["status"] for row in rows)
    trouble = dict.fromkeys(s for s in odd if s in ("at_bound", "not_converged", "misfit"))
    form: Form = rows[0]["model"] if rows else "sampled"
    words = ", ".join(status.replace("_", " ") for status in trouble)
    return Fit(estimator, form, model_of(usable), tuple(parts), absent, "".join(under), words)


def _order(row: NoiseRow) -> tuple[int, int]:
    """What a coefficient belongs to: a power law, a Gauss-Markov term, the line, or no noise."""
    parameter = row["parameter"]
    if parameter.startswith("h_"):
        return 0, int(parameter[2:])
    if parameter[1:3] == "_c":
        return 1, int(parameter[3:])
    return (3, 0) if parameter in DETERMINISTIC else (2, 0)


def _number(value: float | str | None) -> float:
    return math.nan if value in (None, "") else float(value)


def _drawable(row: NoiseRow) -> bool:
    value = _number(row["value"])
    least = value > 0 if row["parameter"][:3] in ("T_c", "f_0") else value >= 0
    return least and row["status"] != "not_detected"


def _upper(row: NoiseRow) -> float:
    return _number(row.get("upper_95")) if row["status"] == "not_detected" else math.nan


def _limit(row: NoiseRow) -> str:
    text = f"{symbol(row['parameter'])} < {significant(_upper(row))} {unit(row['parameter'])}"
    return f"{text} ({limit_class(row)})" if limit_class(row) else text


def _value(row: NoiseRow) -> str:
    """`h₀ 1.29×10⁻⁶ mm²/Hz ±0.6 %`, letters with an index as mathematics."""
    name, value, error = row["parameter"], float(row["value"]), _number(row.get("std_error"))
    if name == "f_0":
        rough = error > EXACT * value and row["status"] != "misfit"
        text = with_uncertainty(value, error, "Hz") if rough else f"{value:.6g} Hz"
        return f"{symbol(name)} {text}"
    shown = re.sub(r"^([A-Za-z]+)_(\w+)$", r"$\1_\2$", symbol(name))
    valid = value and np.isfinite(error) and row["status"] != "misfit"
    spread = f" ±{_percent(error / abs(value))}" if valid else ""
    kind = f" ({correlation_class(value)})" if name.startswith("T_c") else ""
    return f"{shown} {significant(value)} {unit(name)}{spread}{kind}"


def _percent(share: float) -> str:
    """One digit, or two from 10 % on."""
    if share >= 10:
        return ">1000 %"
    percent = float(f"{100 * share:.{int(share >= 0.095)}e}")
    return f"{percent:g} %" if percent >= 1e-3 or percent == 0 else "<0.001 %"


def drawn_m(last: int) -> np.ndarray:
    """Averaging factors to draw a model at, from 1 to `last`."""
    count = int(np.log10(max(last, 2)) * PER_DECADE) + 2
    return np.unique(np.geomspace(1, max(last, 2), count).round().astype(np.int64))


@lru_cache(maxsize=64)
def _unit_avar(alpha: int, form: Form, frame_rate_hz: float, m: bytes) -> np.ndarray:
    """Allan variance of h = 1: an integral a point, and the same for every series."""
    return PowerLaw(alpha, 1.0).avar(np.frombuffer(m, np.int64), frame_rate_hz, form)


def total_avar(
    components: Iterable[Component | Under], m: np.ndarray, frame_rate_hz: float, form: Form
) -> np.ndarray:
    """Allan variance of the sum of components; whole m (k,)."""
    total = np.zeros(len(m))
    for c in components:
        if isinstance(c, PowerLaw):
            key = np.asarray(m, np.int64).tobytes()
            total += c.h * _unit_avar(c.alpha, form, frame_rate_hz, key)
        else:
            total += c.avar(m, frame_rate_hz, form)
    return total


def drawn_avar(c: Component | Under, m: np.ndarray, frame_rate_hz: float, form: Form) -> np.ndarray:
    """Allan variance of a component to draw: of a sinusoid the envelope where its periods are too
    narrow."""
    values = total_avar([c], m, frame_rate_hz, form)
    if not isinstance(c, Sinusoid):
        return values
    x = np.pi * c.f_0 / frame_rate_hz
    gain = np.sin(x) if form == "sampled" else x
    if abs(gain) < 1e-12 * max(1.0, x):
        return values
    envelope = c.A_s**2 / (m * gain) ** 2
    return np.where(m * c.f_0 / frame_rate_hz > PERIODS, envelope, values)


def spectrum_of(columns: Mapping[str, np.ndarray]) -> pd.DataFrame:
    """Rows of periodogram.parquet of one series, bins without a density left out."""
    rows = pd.DataFrame({name: np.asarray(columns[name], float) for name in SPECTRUM})
    return rows[(rows["f_hz"] > 0) & (rows["psd_mm2_hz"] >= 0) & (rows["dof"] > 0)]


def interval(spectrum: pd.DataFrame, confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """Interval of the density, from the chi-squared distribution of dof."""
    from scipy.special import gammaincinv

    half = spectrum["dof"].to_numpy() / 2
    low, high = (gammaincinv(half, q) for q in ((1 + confidence) / 2, (1 - confidence) / 2))
    psd = spectrum["psd_mm2_hz"].to_numpy() * half
    return psd / low, psd / high


def share(spectrum: pd.DataFrame, line: Sinusoid, frame_rate_hz: float, form: Form) -> np.ndarray:
    """What a sinusoid adds to each bin's density: A^2/2 over its width, A as recorded."""
    low, high = spectrum["f_lower_hz"].to_numpy(), spectrum["f_upper_hz"].to_numpy()
    power = line.recorded(frame_rate_hz, form) ** 2 / 2
    return np.where((low <= line.f_0) & (line.f_0 < high), power / (high - low), 0.0)


def residual(
    spectrum: pd.DataFrame, model: NoiseModel, frame_rate_hz: float, lines: bool
) -> np.ndarray:
    """(data / model - 1) in standard deviations sqrt(2 / dof); NaN where the model is zero. lines:
    whether sinusoids are in the spectrum, each in its bin, or were subtracted before."""
    expected = model.psd(spectrum["f_hz"].to_numpy(), frame_rate_hz)
    for line in model.lines if lines else ():
        expected = expected + share(spectrum, line, frame_rate_hz, model.form)
    psd = spectrum["psd_mm2_hz"].to_numpy()
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.where(expected > 0, psd / expected - 1, np.nan)
    return off / np.sqrt(2 / spectrum["dof"].to_numpy())
