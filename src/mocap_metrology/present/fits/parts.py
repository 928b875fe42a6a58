"""What a figure of a fit shows: a model in its parts, matched with a published one, its
curves, and how far the data are off."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mocap_metrology.noise.fit.estimates import NoiseRow, deterministic_of, model_of
from mocap_metrology.noise.model.components import (
    Component,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)
from mocap_metrology.noise.model.deterministic import PARAMETERS as DETERMINISTIC
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text.coefficients import symbol, unit
from mocap_metrology.present.text.numbers import significant, with_uncertainty

LIMIT = 10.0  # correlation times that differ by a greater factor are of different components


def by_estimator(rows: Iterable[Record], series: str) -> dict[str, dict[str, Record]]:
    """Rows of one series of noise.csv: estimator -> parameter -> row, in their order."""
    found: dict[str, dict[str, Record]] = {}
    for row in rows:
        if row["series"] == series:
            found.setdefault(row["estimator"], {})[row["parameter"]] = row
    return found


def correlation_times(values: Mapping[str, float]) -> dict[int, float]:
    """Number -> T_c of the Gauss-Markov terms that have one; the rest is passed over."""
    return {
        int(name[3:]): float(value)
        for name, value in values.items()
        if name.startswith("T_c") and value is not None and 0 < float(value) < math.inf
    }


def pair(
    published: Mapping[int, float], fitted: Mapping[int, float], limit: float = LIMIT
) -> dict[int, int]:
    """Published number -> fitted number of the Gauss-Markov terms that belong together.

    Least sum of |ln(T_c / T_c')| over all assignments (Kuhn 1955), in which a term without a
    partner costs as much as a pair that differs by the factor `limit`; so no pair differs by more,
    and a good pair is not split into two poor ones.
    """
    from scipy.optimize import linear_sum_assignment

    if not published or not fitted:
        return {}
    ours, theirs = list(published), list(fitted)
    logs = [np.log([numbers[k] for k in keys]) for numbers, keys in
            ((published, ours), (fitted, theirs))]  # fmt: skip
    distance = np.abs(logs[0][:, None] - logs[1][None, :])
    far = math.log(limit) * (1 + 1e-12)
    chosen = linear_sum_assignment(np.minimum(distance, far))
    return {
        ours[i]: theirs[j]
        for i, j in zip(*(k.tolist() for k in chosen), strict=True)
        if distance[i, j] <= far
    }


def partners(published: Mapping[str, float], fitted: Mapping[str, float]) -> dict[str, str]:
    """Published parameter -> fitted parameter: Gauss-Markov terms by `pair`, others by name."""
    terms = pair(correlation_times(published), correlation_times(fitted))
    found = {name: name for name in published if name[1:3] != "_c" and name in fitted}
    for number, other in terms.items():
        for name in ("q_c", "T_c"):
            if f"{name}{number}" in published and f"{name}{other}" in fitted:
                found[f"{name}{number}"] = f"{name}{other}"
    return found


def limit_class(row: Record) -> str | None:
    """Class of T_c (S 4.6) that a limit of q_c is for, from its note (`class long: ...`)."""
    note = row.get("note") or ""
    if row["status"] != "not_detected" or not str(note).startswith("class "):
        return None
    return str(note).split(":")[0].removeprefix("class ")


PER_DECADE = 120  # points of a curve: eight a period for the first six periods of a sinusoid
PERIODS = 6  # of a sinusoid drawn one by one; then their envelope


@dataclass(frozen=True)
class Under:
    """A deterministic part in a series of `duration_s`: it has an Allan variance and no density."""

    part: Deterministic
    duration_s: float

    def avar(self, m: np.ndarray, frame_rate_hz: float, form: Form = "sampled") -> np.ndarray:
        """(k,) mm^2 at whole m (k,), of frames of either form: it is slow."""
        tau0 = 1 / frame_rate_hz
        return self.part.avar(np.asarray(m, float) * tau0, self.duration_s)


@dataclass(frozen=True)
class Part:
    """One component: its name, and its name with its value."""

    component: Component | Under
    name: str
    text: str


@dataclass(frozen=True)
class Fit:
    """One estimate: its model, the form of the Allan variances it was fitted in, its parts, and
    what it did not detect, with upper limits; under: the deterministic part in words. The model
    is of the noise alone, the parts are all that was found."""

    estimator: str
    form: Form
    model: NoiseModel
    parts: tuple[Part, ...]
    absent: tuple[str, ...]
    under: str = ""


def recorded_s(allan: Mapping[str, np.ndarray], frame_rate_hz: float) -> float:
    """Duration, s, of the series of columns `m` and `n_terms` of an overlapping Allan deviation:
    n frames have n - 2m + 1 terms, and fewer only where gaps are long beside m."""
    tau0 = 1 / frame_rate_hz
    m, terms = (np.asarray(allan[k], float) for k in ("m", "n_terms"))
    return tau0 * float(np.max(terms + 2 * m - 1, initial=0.0))


def fit_of(estimator: str, rows: Sequence[NoiseRow], duration_s: float = 0.0) -> Fit:
    """A fit out of rows of noise.csv of one series and estimator; duration_s: of the series, on
    which the Allan variance of a warm-up depends."""
    rows = [row for row in rows if row["estimator"] == estimator]
    model = model_of(_usable(rows))
    by_name = {r["parameter"]: r for r in _usable(rows)}
    absent = []
    for row in rows:
        upper = row.get("upper_95")
        if row["status"] == "not_detected" and upper is not None and np.isfinite(float(upper)):
            limit = (
                f"{symbol(row['parameter'])} < {significant(float(upper))} {unit(row['parameter'])}"
            )
            kind = limit_class(row)
            absent.append(f"{limit} ({kind})" if kind else limit)
    form: Form = rows[0]["model"] if rows else "sampled"
    finite = {r["parameter"]: r for r in rows if np.isfinite(_number(r["value"]))}
    found = deterministic_of(finite.values())
    names = [n for n in DETERMINISTIC if getattr(found, n)]
    under = ", ".join(f"{n} {significant(getattr(found, n))} {unit(n)}" for n in names)
    parts = _parts(model, by_name)
    if not found.empty:
        values = ", ".join(_value(name, finite[name], found) for name in names)
        prefix = "" if found.drift else f"{found.name}: "
        parts.append(Part(Under(found, duration_s), found.name, prefix + values))
    return Fit(estimator, form, model, tuple(parts), tuple(absent), under)


def _number(value: float | str | None) -> float:
    return math.nan if value in (None, "") else float(value)


def _usable(rows: Sequence[NoiseRow]) -> list[NoiseRow]:
    """Rows of the components all of whose numbers are there and can be drawn."""
    bad = set()
    for row in rows:
        value = _number(row["value"])
        positive = row["parameter"][:3] in ("T_c", "f_0")
        fine = np.isfinite(value) and (value > 0 if positive else value >= 0)
        if row["status"] == "not_detected" or not fine:
            bad.add(_component(row["parameter"]))
    return [row for row in rows if _component(row["parameter"]) not in bad]


def _component(parameter: str) -> str:
    """What a coefficient belongs to: itself, a Gauss-Markov number, or the line."""
    if parameter[1:3] == "_c":
        return parameter[3:]
    return "line" if parameter in ("A_s", "f_0", "width_f") else parameter


def _parts(model: NoiseModel, rows: Mapping[str, NoiseRow]) -> list[Part]:
    """Power laws by alpha, Gauss-Markov terms as they are numbered, the sinusoid."""
    own = sorted(int(name[3:]) for name in rows if name.startswith("T_c"))
    parts, seen = [], 0
    for component in model.components:
        if isinstance(component, PowerLaw):
            names = [f"h_{component.alpha}"]
            short = symbol(names[0])
        elif isinstance(component, GaussMarkov):
            names = [f"q_c{own[seen]}", f"T_c{own[seen]}"]
            short = f"GM {own[seen]}"
            seen += 1
        else:
            names, short = ["A_s", "f_0"], "sinusoid"
            names += ["width_f"] if component.width_f else []
        values = ", ".join(_value(name, rows.get(name), component) for name in names)
        prefix = "" if isinstance(component, PowerLaw) else f"{short}: "
        parts.append(Part(component, short, prefix + values))
    return parts


def _in_figure(parameter: str) -> str:
    """`symbol` as mathematics, where it has an index of letters."""
    text = symbol(parameter)
    return re.sub(r"^([A-Za-z]+)_(\w+)$", r"$\1_\2$", text)


def _value(name: str, row: NoiseRow | None, component: Component | Deterministic) -> str:
    attribute = {"h_": "h"}.get(name[:2], name.rstrip("0123456789") if name != "f_0" else "f_0")
    value = float(getattr(component, attribute))
    error = _number(row.get("std_error")) if row else np.nan
    status = row["status"] if row else ""
    odd = status in ("at_bound", "not_converged", "misfit")
    status = f" ({status.replace('_', ' ')})" if odd else ""
    if name == "f_0" and error > 0:
        return f"{symbol(name)} {with_uncertainty(value, error, 'Hz')}{status}"
    spread = f" ±{_percent(error / abs(value))}" if value and np.isfinite(error) else ""
    return f"{_in_figure(name)} {significant(value)} {unit(name)}{spread}{status}"


def _percent(share: float) -> str:
    """One digit, or two from 10 % on."""
    if share >= 10:
        return ">1000 %"
    percent = float(f"{100 * share:.{int(share >= 0.095)}e}")
    return f"{percent:g} %" if percent >= 1e-3 or percent == 0 else f"{significant(percent)} %"


def drawn_m(last: int) -> np.ndarray:
    """Averaging factors to draw a model at, from 1 to `last`."""
    count = int(np.log10(max(last, 2)) * PER_DECADE) + 2
    return np.unique(np.geomspace(1, max(last, 2), count).round().astype(np.int64))


@lru_cache(maxsize=64)
def _unit_avar(alpha: int, form: Form, frame_rate_hz: float, m: bytes) -> np.ndarray:
    """Allan variance of h = 1: an integral a point, and the same for every series."""
    return PowerLaw(alpha, 1.0).avar(np.frombuffer(m, np.int64), frame_rate_hz, form)


def component_avar(
    c: Component | Under, m: np.ndarray, frame_rate_hz: float, form: Form
) -> np.ndarray:
    """Allan variance of a component; whole m (k,)."""
    if isinstance(c, PowerLaw):
        return c.h * _unit_avar(c.alpha, form, frame_rate_hz, np.asarray(m, np.int64).tobytes())
    return c.avar(m, frame_rate_hz, form)


def model_avar(model: NoiseModel, m: np.ndarray, frame_rate_hz: float, form: Form) -> np.ndarray:
    """`NoiseModel.avar`, with what is the same for every series computed once."""
    parts = (component_avar(c, m, frame_rate_hz, form) for c in model.components)
    return sum(parts, np.zeros(len(m)))


def fit_avar(fit: Fit, m: np.ndarray, frame_rate_hz: float) -> np.ndarray:
    """Allan variance of all that was found: of the noise, and of what lies under it."""
    parts = (part.component for part in fit.parts)
    under = (c.avar(m, frame_rate_hz) for c in parts if isinstance(c, Under))
    return sum(under, model_avar(fit.model, m, frame_rate_hz, fit.form))


def drawn_avar(c: Component | Under, m: np.ndarray, frame_rate_hz: float, form: Form) -> np.ndarray:
    """The same to draw: of a sinusoid the envelope where its periods are too narrow."""
    tau0 = 1 / frame_rate_hz
    values = component_avar(c, m, frame_rate_hz, form)
    if not isinstance(c, Sinusoid):
        return values
    x = np.pi * c.f_0 * tau0
    gain = np.sin(x) if form == "sampled" else x
    if abs(gain) < 1e-12 * max(1.0, x):
        return values
    envelope = c.A_s**2 / (m * gain) ** 2
    return np.where(m * tau0 * c.f_0 > PERIODS, envelope, values)


@dataclass(frozen=True)
class Spectrum:
    """A binned periodogram: f, lower and upper edge in Hz, density in mm^2/Hz, degrees of freedom
    of each bin, (k,) each. lines: whether sinusoids are in it, or were subtracted before."""

    f: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    psd: np.ndarray
    dof: np.ndarray
    lines: bool = True

    @classmethod
    def of(cls, columns: Mapping[str, np.ndarray], lines: bool = True) -> Spectrum:
        """From columns of periodogram.parquet of one series; bins without a density left out."""
        names = ("f_hz", "f_lower_hz", "f_upper_hz", "psd_mm2_hz", "dof")
        f, lower, upper, psd, dof = (np.asarray(columns[n], dtype=np.float64) for n in names)
        keep = (f > 0) & np.isfinite(psd) & (psd >= 0) & (dof > 0)
        return cls(f[keep], lower[keep], upper[keep], psd[keep], dof[keep], lines)

    def interval(self, confidence: float = 0.683) -> tuple[np.ndarray, np.ndarray]:
        """Interval of the density, from the chi-squared distribution of dof."""
        from scipy.special import gammaincinv

        half = self.dof / 2
        low, high = (
            self.psd * half / gammaincinv(half, q)
            for q in ((1 + confidence) / 2, (1 - confidence) / 2)
        )
        return low, high

    def share(self, line: Sinusoid, frame_rate_hz: float, form: Form) -> np.ndarray:
        """What a sinusoid adds to each bin's density: A^2/2 over its width, A as recorded."""
        inside = (self.lower <= line.f_0) & (line.f_0 < self.upper)
        power = line.recorded(frame_rate_hz, form) ** 2 / 2
        return np.where(inside, power / (self.upper - self.lower), 0.0)

    def expected(self, model: NoiseModel, frame_rate_hz: float) -> np.ndarray:
        """Density of the model at the bins, mm^2/Hz, the sinusoid, if there, in its bin."""
        lines = model.lines if self.lines else ()
        shares = (self.share(line, frame_rate_hz, model.form) for line in lines)
        return model.psd(self.f, frame_rate_hz) + sum(shares, 0.0)

    def residual(self, model: NoiseModel, frame_rate_hz: float) -> np.ndarray:
        """(data / model - 1) in standard deviations sqrt(2 / dof); NaN where the model is zero."""
        expected = self.expected(model, frame_rate_hz)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.where(expected > 0, self.psd / expected - 1, np.nan)
        return off / np.sqrt(2 / self.dof)
