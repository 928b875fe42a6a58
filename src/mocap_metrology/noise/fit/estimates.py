"""Input and output of every estimator of noise coefficients."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict, cast

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_csv
from mocap_metrology.common.types import Row
from mocap_metrology.noise.model.components import (
    ALPHAS,
    FORMS,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    check_form,
)
from mocap_metrology.noise.model.deterministic import UNITS as DETERMINISTIC_UNITS
from mocap_metrology.noise.model.deterministic import Deterministic

DEFAULT_ESTIMATOR = "likelihood"
S_ESTIMATOR = "annealing-ant-colony"  # that of S, with a descent from each trial
PLAIN_ESTIMATOR = "annealing-ant-colony-plain"  # what S used
# Two-sided normal quantiles of the intervals named 68 % and 95 %
Z_68, Z_95 = 0.9944578832097532, 1.959963984540054
SLOW = 3  # kind of a component that is no noise
ONE_SIDED_95 = 1.6448536269514722  # of upper limits
# The classes of correlation time of S 4.6, in s. S names 10^-2..10^0, 10^0..10^1 and 10^2..10^3 s;
# the first takes what is shorter and the last what is longer, as in S's own tables (2000 s).
CLASSES = (("short", 0.0, 1.0), ("medium", 1.0, 10.0), ("long", 100.0, math.inf))


@dataclass(frozen=True)
class Components:
    """Which components are fitted: powers of the power laws, Gauss-Markov terms, a sinusoid."""

    alphas: tuple[int, ...] = ALPHAS
    gauss_markov: int = 3
    sinusoid: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "alphas", tuple(sorted(self.alphas)))
        once = len(set(self.alphas)) == len(self.alphas)
        if not (set(self.alphas) <= set(ALPHAS) and once and self.gauss_markov >= 0):
            raise Refusal(f"{self}, expected alphas out of {ALPHAS}, each once; gauss_markov >= 0")

    @classmethod
    def of(cls, model: NoiseModel) -> Components:
        """Those a model has."""
        alphas = tuple(c.alpha for c in model.components if isinstance(c, PowerLaw))
        correlated = sum(isinstance(c, GaussMarkov) for c in model.components)
        return cls(alphas, correlated, bool(model.lines))

    @property
    def names(self) -> list[str]:
        """`h_-2` ..., `q_c1`, `T_c1`, ..., `A_s`, `f_0`, as in `NoiseModel.coefficients`."""
        correlated = [f"{p}{k + 1}" for k in range(self.gauss_markov) for p in ("q_c", "T_c")]
        line = ["A_s", "f_0"] if self.sinusoid else []
        return [f"h_{alpha}" for alpha in self.alphas] + correlated + line


@dataclass(frozen=True)
class Coefficient:
    """One line of noise.csv. Units as in `NoiseModel.UNITS`; NaN where there is no such number.

    std_error: by the estimator; crlb: least standard error any unbiased estimator can have with so
    many samples (`crlb`) if the fitted model is true. status: `ok`; `at_bound` (the value is an end
    of the range searched); `not_converged`; `misfit` (the model does not describe the data,
    so neither values nor errors are valid); `not_detected` (value NaN, upper_95 the limit).
    """

    parameter: str
    value: float
    std_error: float = math.nan
    crlb: float = math.nan
    lower_68: float = math.nan
    upper_68: float = math.nan
    lower_95: float = math.nan
    upper_95: float = math.nan
    detected: bool = True
    status: str = "ok"
    note: str = ""

    @classmethod
    def limit(cls, name: str, upper: float = math.nan, note: str = "") -> Coefficient:
        """The coefficient of a component that was not detected, with its 95 % limit, if there is
        one."""
        return cls(name, math.nan, upper_95=upper, detected=False, status="not_detected", note=note)


class NoiseRow(TypedDict, total=False):
    """A row of noise.csv: a `Coefficient` (see there) of one series by one estimator."""

    series: str
    estimator: str
    model: Form  # empty in rows without a number
    parameter: str
    value: float
    unit: str
    std_error: float
    crlb: float
    lower_68: float
    upper_68: float
    lower_95: float
    upper_95: float
    detected: bool
    status: str
    note: str


NUMBERS = ("value", "std_error", "crlb", "lower_68", "upper_68", "lower_95", "upper_95")


def read_noise(path: str | Path) -> list[NoiseRow]:
    """Rows of a noise.csv; NaN where a number is missing."""
    rows = read_csv(path, NUMBERS)
    return [cast(NoiseRow, row | {"detected": row["detected"] == "True"}) for row in rows]


@dataclass(frozen=True)
class Estimate:
    """Coefficients of one series by one estimator.

    form: of the Allan variances, or the frames whose spectra, were fitted. cost: what was
    minimised, at the end. note: what a reader should know, one line, or empty.
    """

    estimator: str
    form: Form
    coefficients: tuple[Coefficient, ...]
    cost: float
    note: str = ""

    @property
    def values(self) -> dict[str, float]:
        """Detected coefficients by name, the deterministic part's too."""
        return {c.parameter: c.value for c in self.coefficients if c.detected}

    @property
    def model(self) -> NoiseModel:
        """The noise of the detected coefficients, in the form that was fitted."""
        return _noise_of(self.values, self.form)


def correlation_class(T_c: float) -> str:
    """Class of a correlation time (s) after S 4.6: `short`, `medium`, `long`, or `unclassed`."""
    return next((name for name, low, high in CLASSES if low <= T_c < high), "unclassed")


def limit_class(row: Mapping[str, Any]) -> str | None:
    """Class of T_c (S 4.6) that a limit of q_c is for, from its note (`class long: ...`)."""
    note = str(row.get("note") or "")
    if row["status"] != "not_detected" or not note.startswith("class "):
        return None
    return note.split(":")[0].removeprefix("class ")


def rows(series: str, estimate: Estimate) -> list[Row]:
    """The rows of noise.csv of one series; column `class` for Gauss-Markov terms (S 4.6)."""
    values, lines = estimate.values, []
    for c in estimate.coefficients:
        correlated = c.parameter[1:3] == "_c"
        T_c = values.get(f"T_c{c.parameter[3:]}", math.nan) if correlated else math.nan
        origin = {"series": series, "estimator": estimate.estimator, "model": estimate.form}
        size = {"parameter": c.parameter, "value": c.value, "unit": unit_of(c.parameter)}
        line = {**origin, **size, **vars(c)}
        note = line.pop("note")
        line["class"] = correlation_class(T_c) if math.isfinite(T_c) else ""
        lines.append(line | {"note": note})
    return lines


def refused_rows(series: str, estimators: Sequence[str], why: str) -> list[Row]:
    """A row of noise.csv an estimator without a number: status `refused`; the note states why."""
    none = Coefficient("", math.nan, detected=False, status="refused", note=why)
    return [
        {**line, "model": ""}
        for estimator in estimators
        for line in rows(series, Estimate(estimator, "sampled", (none,), math.nan))
    ]


def unit_key(parameter: str) -> str:
    """`q_c1` -> `q_c`: the key of `NoiseModel.UNITS`."""
    return parameter[:3] if parameter[1:3] == "_c" else parameter


def unit_of(parameter: str) -> str:
    """Unit of a parameter of noise.csv."""
    return {**NoiseModel.UNITS, **DETERMINISTIC_UNITS}.get(unit_key(parameter), "")


def _noise_of(values: Mapping[str, float], form: Form) -> NoiseModel:
    noise = {name: value for name, value in values.items() if name not in DETERMINISTIC_UNITS}
    return NoiseModel.from_coefficients(noise, form)


def _detected(noise_rows: Iterable[NoiseRow]) -> dict[str, float]:
    absent = ("not_detected", "refused")
    return {r["parameter"]: float(r["value"]) for r in noise_rows if r["status"] not in absent}


def model_of(noise_rows: Sequence[NoiseRow]) -> NoiseModel:
    """The fitted noise out of rows of noise.csv of one series and estimator (see `rows`), in the
    form that was fitted; what is no noise: `deterministic_of`."""
    forms = (check_form(r["model"]) for r in noise_rows if r.get("model") in FORMS)
    return _noise_of(_detected(noise_rows), next(forms, "sampled"))


def deterministic_of(noise_rows: Iterable[NoiseRow]) -> Deterministic:
    """What was detected, out of rows of noise.csv of one series and estimator."""
    values = {k: v for k, v in _detected(noise_rows).items() if k in DETERMINISTIC_UNITS}
    if not values.get("T_w", 0.0) > 0 or not math.isfinite(values.get("A_w", math.nan)):
        return Deterministic(drift=values.get("drift", 0.0))
    return Deterministic(**values)


def component_of(row: NoiseRow) -> tuple[int, int]:
    """What a coefficient belongs to: a power law, a Gauss-Markov term, the line, or no noise."""
    parameter = row["parameter"]
    if parameter in DETERMINISTIC_UNITS:
        return SLOW, 0
    if parameter.startswith("h_"):
        return 0, int(parameter[2:])
    return (1, int(parameter[3:])) if parameter[1:3] == "_c" else (2, 0)


def is_known(row: NoiseRow) -> bool:
    """Whether a coefficient has a value that a component can be made of."""
    value, parameter = row["value"], row["parameter"]
    if row["status"] == "not_detected" or not math.isfinite(value):
        return False
    return (
        parameter in DETERMINISTIC_UNITS or value > 0 or (value == 0 and parameter[0] not in "Tf")
    )
