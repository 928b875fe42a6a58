"""Numbers that decide claims of S: its tables, recordings of the workflow, further realisations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, TypeVar

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, S_ESTIMATOR
from mocap_metrology.noise.model.components import Component, NoiseModel
from mocap_metrology.noise.twins import published
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, SERIES
from mocap_metrology.papers.claims.decide import Missing
from mocap_metrology.papers.shock import ShockEffect

TYPES = {
    "T40": (2, 3, 4, 5, 6, 8, 10),
    "Bonita": (2, 3, 4, 5, 6, 8, 10),
    "Vantage": (2, 3, 4, 5, 6, 8, 9),  # S excludes the tenth
}
COORDINATES = SERIES[:6]
FRAME_S = 1 / FRAME_RATE_HZ
Key = tuple[str, int]
WHOLE = {kind: (kind, ns[-1]) for kind, ns in TYPES.items()}  # subset with most cameras
SUBSETS = [(kind, n) for kind, ns in TYPES.items() for n in ns]  # all that S compares
LEAST_VARIANCE = 1e-9  # mm^2, of a correlated component that counts
Record = Mapping[str, Any]  # a row of a table
Moments = Mapping[Key, Mapping[str, np.ndarray]]
T = TypeVar("T")


def cases(series: Sequence[str] = COORDINATES) -> Iterator[tuple[Key, str]]:
    """Subsets by series."""
    return ((key, name) for key in SUBSETS for name in series)


@cache
def _published(key: Key) -> dict[str, NoiseModel]:
    return published.published_row(*key)


@dataclass(frozen=True)
class Published:
    """S's tables; Allan deviations are those of the models in Tables A1-A3, in continuous time as
    S fits them."""

    def adev(self, key: Key, series: str, tau_s: Sequence[float] | np.ndarray) -> np.ndarray:
        """Allan deviation (k,) in mm at averaging times (k,)."""
        return np.asarray(np.sqrt(avar(model_of(self, key, series), tau_s)))

    def longest_s(self, key: Key) -> float:
        """Longest averaging time whose Allan variance is known, in s."""
        return np.inf

    def coefficients(self, key: Key, series: str) -> dict[str, float]:
        return _published(key)[series].coefficients()

    estimates = coefficients

    def printed(self, key: Key, series: str) -> dict[str, float]:
        """Coefficients of a series as its row of the appendix prints them."""
        return published.printed_row(*key)[series]

    def ended(self, key: Key, series: str) -> set[str]:
        """S does not report where its search ended."""
        return set()

    def gaussian(self, key: Key) -> Mapping[str, float]:
        """Table 4 has one row for each type, that of most cameras."""
        if key not in WHOLE.values() and key[0] != "All":
            raise Missing("Table 4 covers the largest sets only")
        return published.published_gaussian(key[0])

    def lines(self, key: Key, series: str) -> list[tuple[float, float]]:
        """(f_0, A_s) of periodic disturbances below the Nyquist frequency."""
        return _line(self.coefficients(key, series))


@dataclass(frozen=True)
class Regenerated:
    """Recordings of group skurowski2019: by (camera type, cameras) their columns of allan.parquet,
    rows of noise.csv and of gaussian.csv. shock: effect of the shock of the recording that has one;
    repaired: rows of noise.csv after the repair, by recording. Coefficients are those of
    `annealing-ant-colony`, lines those of `likelihood`."""

    allan: Mapping[Key, Mapping[str, np.ndarray]]
    noise: Mapping[Key, Sequence[Record]]
    gaussians: Mapping[Key, Sequence[Record]]
    shock: ShockEffect | None = None
    repaired: Mapping[str, Sequence[Record]] = field(default_factory=dict)

    def adev(self, key: Key, series: str, tau_s: Sequence[float] | np.ndarray) -> np.ndarray:
        """Interpolated in logarithms; refused with `Missing` outside the range of tau."""
        tau, adev = self.curve(key, series)
        wanted = np.asarray(tau_s, float)
        if not tau.size or wanted.max() > tau[-1] * 1.02 or wanted.min() < tau[0] * 0.98:
            raise Missing(f"no Allan deviation of {key[0]} {key[1]} at all averaging times")
        return np.asarray(np.exp(np.interp(np.log(wanted), np.log(tau), np.log(adev))))

    def longest_s(self, key: Key) -> float:
        """Longest averaging time of L."""
        return float(np.max(self.curve(key, "L")[0], initial=0.0)) * 1.02

    def curve(self, key: Key, series: str) -> tuple[np.ndarray, np.ndarray]:
        """tau in s and Allan deviation in mm."""
        columns = of_recording(self.allan, key)
        pick = (columns["series"] == series) & (columns["estimator"] == "oadev")
        pick &= columns["adev_mm"] > 0
        return columns["tau_s"][pick], columns["adev_mm"][pick]

    def coefficients(self, key: Key, series: str) -> dict[str, float]:
        return self.fitted(key, series, S_ESTIMATOR)

    def printed(self, key: Key, series: str) -> dict[str, float]:
        """Without those that ended at a limit of the search, which are no estimates (`ended`)."""
        ended = self.ended(key, series)
        return {k: v for k, v in self.coefficients(key, series).items() if k not in ended}

    estimates = printed

    def ended(self, key: Key, series: str) -> set[str]:
        """Coefficients whose search ended at a limit."""
        rows = self._rows(key, series, S_ESTIMATOR)
        return {row["parameter"] for row in rows if row.get("status") == "at_bound"}

    def fitted(self, key: Key, series: str, estimator: str) -> dict[str, float]:
        """All coefficients of an estimator's model, including those at a limit."""
        return {
            row["parameter"]: float(row["value"])
            for row in self._rows(key, series, estimator)
            if row["value"] is not None and np.isfinite(float(row["value"]))
        }

    def _rows(self, key: Key, series: str, estimator: str) -> list[Record]:
        rows = of_recording(self.noise, key)
        return [r for r in rows if (r["series"], r["estimator"]) == (series, estimator)]

    def gaussian(self, key: Key) -> Mapping[str, float]:
        """Along x, as S; `pair_sigma_L_mm` and so on along the line between the markers."""
        rows = {row["axis"]: row for row in of_recording(self.gaussians, key)}
        return dict(rows["x"]) | {f"pair_{k}": v for k, v in rows["pair"].items()}

    def lines(self, key: Key, series: str) -> list[tuple[float, float]]:
        """(f_0, A_s) that the likelihood estimator detected."""
        return _line(self.fitted(key, series, DEFAULT_ESTIMATOR))


@dataclass(frozen=True)
class Realisation:
    """Moments of one more realisation of the same systems: rows as of gaussian.csv, along x."""

    moments: Mapping[Key, Mapping[str, float]]

    def gaussian(self, key: Key) -> Mapping[str, float]:
        return of_recording(self.moments, key)


Study = Published | Regenerated


def of_recording(by_key: Mapping[Key, T], key: Key) -> T:
    """What belongs to a recording; `Missing` without it."""
    if key not in by_key:
        raise Missing(f"no recording {key[0]} with {key[1]} cameras")
    return by_key[key]


def _line(values: Mapping[str, float]) -> list[tuple[float, float]]:
    return [(values["f_0"], values["A_s"])] if {"f_0", "A_s"} <= values.keys() else []


def model_of(study: Study, key: Key, series: str) -> NoiseModel:
    """The coefficients as a model in continuous time, as S fits them."""
    return NoiseModel.from_coefficients(study.coefficients(key, series), "continuous")


def avar(model: NoiseModel | Component, tau_s: float | Sequence[float] | np.ndarray) -> np.ndarray:
    """Allan variance in mm^2, in continuous time at the frame rate of S."""
    return model.avar(np.asarray(tau_s, float) * FRAME_RATE_HZ, FRAME_RATE_HZ, "continuous")


def share_of_avar(
    model: NoiseModel, tau_s: float, alphas: Sequence[int], least_s: float = np.inf
) -> float:
    """Share of the Allan variance at tau that power laws of these alphas, and correlated components
    with T_c of `least_s` or more, contribute."""
    part = sum(
        avar(c, tau_s)
        for c in model.components
        if getattr(c, "alpha", None) in alphas or getattr(c, "T_c", 0.0) >= least_s
    )
    return float(part / avar(model, tau_s))


def active_terms(study: Study, key: Key, series: str) -> list[tuple[float, float]]:
    """(q_c, T_c) of the correlated components of `LEAST_VARIANCE` or more, excluding those at a
    limit of the search."""
    values = study.estimates(key, series)
    terms = [(values.get(f"q_c{k}", 0.0), values.get(f"T_c{k}", 0.0)) for k in (1, 2, 3, 4)]
    return [(q, t) for q, t in terms if q**2 * t / 2 >= LEAST_VARIANCE]
