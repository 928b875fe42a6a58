"""A claim, its decision rule and its result.

Claims of S are decided by its published numbers, or by recordings that went through the workflow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, S_ESTIMATOR
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import (
    FRAME_RATE_HZ,
    SERIES,
    printed_row,
    published_gaussian,
    published_row,
)
from mocap_metrology.present.tables import Record, Row

HOLDS, DOES_NOT, UNKNOWN = "holds", "does not", "undecided"
COLUMNS = (
    *("id", "paper", "section", "claim", "statistic", "criterion"),
    *("published", "published_word", "regenerated", "realisations", "regenerated_word"),
    *("source", "note"),
)


T = TypeVar("T")  # source of the numbers that decide a claim, of S or of J


@dataclass(frozen=True)
class Finding:
    """The statistic in words with its numbers, and whether the claim holds by it; not `there`:
    undecided for lack of numbers, not of precision."""

    value: str
    word: str
    there: bool = True


@dataclass(frozen=True)
class Claim(Generic[T]):
    """A claim of `section`, in the paper's sense; `statistic` and `criterion` say how it is
    decided; `find` does, of published numbers and of regenerated ones alike. `by_chance`: it is
    moments of whole recordings that decide, mostly random walk, so more realisations are asked."""

    id: str
    section: str
    claim: str
    statistic: str
    criterion: str
    find: Callable[[T], Finding]
    note: str = ""
    by_chance: bool = False


def decided(value: str, holds: bool) -> Finding:
    return Finding(value, HOLDS if holds else DOES_NOT)


def by_count(value: str, flags: Sequence[bool], least: float) -> Finding:
    """Whether a share of `least` of such cases is as said: what the 95 % interval (Clopper-Pearson)
    of the share leaves open is undecided. All of fewer than it takes hold too."""
    from scipy.special import betaincinv

    hits, total = int(np.sum(flags)), len(flags)
    if not total:
        return unknown("no cases")
    low = betaincinv(hits, total - hits + 1, 0.025) if hits else 0.0
    high = betaincinv(hits + 1, total - hits, 0.975) if hits < total else 1.0
    if hits == total or low >= least:
        return decided(value, True)
    return decided(value, False) if high < least else Finding(value, UNKNOWN)


def median_error(values: Sequence[float] | np.ndarray) -> float:
    """Two standard errors of the median of values (k,): of a normal distribution as wide as they
    are between 16 and 84 %; infinite of fewer than three."""
    if len(values) < 3:
        return np.inf
    low, high = np.quantile(values, [0.16, 0.84])
    return float(2 * 1.2533 * (high - low) / 2 / np.sqrt(len(values)))


def within(value: float, error: float, low: float, high: float) -> str:
    """Whether a number lies between low and high: undecided where value +- error spans one."""
    if low <= value - error and value + error <= high:
        return HOLDS
    return DOES_NOT if value + error < low or value - error > high else UNKNOWN


def together(words: Sequence[str]) -> str:
    """All hold, one does not, or it is undecided."""
    if DOES_NOT in words:
        return DOES_NOT
    return UNKNOWN if UNKNOWN in words else HOLDS


def unknown(why: str, there: bool = True) -> Finding:
    return Finding(why, UNKNOWN, there)


def row(
    claim: Claim[T],
    paper: str,
    published: Finding,
    regenerated: Finding,
    source: str,
    realisations: str = "",
) -> Row:
    """A line of `claims.csv`."""
    cells = (
        *(claim.id, paper, claim.section, claim.claim, claim.statistic, claim.criterion),
        *(published.value, published.word, regenerated.value, realisations, regenerated.word),
        *(source if regenerated.word != UNKNOWN else "", claim.note),
    )
    return dict(zip(COLUMNS, cells, strict=True))


def orders(values: Sequence[float]) -> tuple[float, float, float]:
    """log10 of the 5 %, 50 % and 95 % points of what is positive."""
    known = np.asarray([v for v in values if v > 0])
    return tuple(np.log10(np.quantile(known, [0.05, 0.5, 0.95])).tolist())


def share(flags: Sequence[bool]) -> str:
    """`12 of 14 (86 %)`."""
    total = len(flags)
    return f"{sum(flags)} of {total} ({100 * sum(flags) / max(total, 1):.0f} %)"


TYPES = {
    "T40": (2, 3, 4, 5, 6, 8, 10),
    "Bonita": (2, 3, 4, 5, 6, 8, 10),
    "Vantage": (2, 3, 4, 5, 6, 8, 9),  # S leaves the tenth out
}
COORDINATES = SERIES[:6]
Key = tuple[str, int]


class Missing(KeyError):
    """A recording, series or averaging time that is not there."""


def whole(camera_type: str) -> Key:
    """The subset with most cameras that S compares."""
    return camera_type, TYPES[camera_type][-1]


def subsets() -> list[Key]:
    """All subsets that S compares."""
    return [(kind, n) for kind, ns in TYPES.items() for n in ns]


@dataclass(frozen=True)
class Published:
    """S's tables; Allan deviations are those of the models in Tables A1-A3, in continuous time as
    S fits them."""

    def adev(self, key: Key, series: str, tau_s: Sequence[float] | np.ndarray) -> np.ndarray:
        model = published_row(*key)[series]
        tau0 = 1 / FRAME_RATE_HZ
        m = np.asarray(tau_s, float) / tau0
        deviation: np.ndarray = np.sqrt(model.avar(m, FRAME_RATE_HZ, "continuous"))
        return deviation

    def coefficients(self, key: Key, series: str) -> dict[str, float]:
        return published_row(*key)[series].coefficients()

    estimates = coefficients

    def printed(self, key: Key, series: str) -> dict[str, float]:
        return printed_row(*key)[series]

    def ended(self, key: Key, series: str) -> set[str]:
        """S does not say where its search ended."""
        return set()

    def gaussian(self, key: Key) -> dict[str, float]:
        """Table 4 has one row a type, of most cameras."""
        if key not in [whole(kind) for kind in TYPES] and key[0] != "All":
            raise Missing(key)
        return published_gaussian(key[0])

    def lines(self, key: Key, series: str) -> list[tuple[float, float]]:
        """(f_0, A_s) of periodic disturbances below Nyquist."""
        found = self.coefficients(key, series)
        return [(found["f_0"], found["A_s"])] if "f_0" in found else []


@dataclass(frozen=True)
class ShockEffect:
    """What a shock did: greatest ratio of the Allan deviations of L with it and without its frames,
    and at which tau (s); by coordinate the noise after it over that before, in so many frames."""

    raised: float
    tau_s: float
    sides: Mapping[str, float]
    frames: int


@dataclass(frozen=True)
class Regenerated:
    """Recordings of group skurowski2019: by (camera type, cameras) their columns of allan.parquet,
    rows of noise.csv and of gaussian.csv. shock: what it did, of the recording that has one;
    repaired: rows of noise.csv after the repair, by recording. Coefficients are those of
    `annealing-ant-colony`, lines those of `likelihood`."""

    allan: Mapping[Key, Mapping[str, np.ndarray]]
    noise: Mapping[Key, Sequence[Record]]
    gaussians: Mapping[Key, Sequence[Record]]
    shock: ShockEffect | None = None
    repaired: Mapping[str, Sequence[Record]] = field(default_factory=dict)

    def adev(self, key: Key, series: str, tau_s: Sequence[float] | np.ndarray) -> np.ndarray:
        """Interpolated in logarithms; refused with `Missing` beyond the longest tau."""
        tau, adev = self.curve(key, series)
        wanted = np.asarray(tau_s, float)
        if not tau.size or wanted.max() > tau[-1] * 1.02 or wanted.min() < tau[0] * 0.98:
            raise Missing(key, series, tau_s)
        between: np.ndarray = np.exp(np.interp(np.log(wanted), np.log(tau), np.log(adev)))
        return between

    def curve(self, key: Key, series: str) -> tuple[np.ndarray, np.ndarray]:
        """tau in s and Allan deviation in mm."""
        if key not in self.allan:
            raise Missing(key)
        columns = self.allan[key]
        pick = (columns["series"] == series) & (columns["estimator"] == "oadev")
        pick &= columns["adev_mm"] > 0
        return columns["tau_s"][pick], columns["adev_mm"][pick]

    def coefficients(self, key: Key, series: str) -> dict[str, float]:
        return self.fitted(key, series, S_ESTIMATOR)

    def printed(self, key: Key, series: str) -> dict[str, float]:
        """Without what ended at a limit of the search, which is no estimate (`ended`)."""
        ended = self.ended(key, series)
        found = self.coefficients(key, series)
        return {name: value for name, value in found.items() if name not in ended}

    estimates = printed

    def ended(self, key: Key, series: str) -> set[str]:
        """Coefficients whose search ended at a limit."""
        return {
            row["parameter"]
            for row in self._rows(key, series, S_ESTIMATOR)
            if row.get("status") == "at_bound"
        }

    def fitted(self, key: Key, series: str, estimator: str) -> dict[str, float]:
        """All coefficients of an estimator's model, those at a limit too."""
        return {
            row["parameter"]: float(row["value"])
            for row in self._rows(key, series, estimator)
            if row["value"] is not None and np.isfinite(float(row["value"]))
        }

    def _rows(self, key: Key, series: str, estimator: str) -> list[Record]:
        if key not in self.noise:
            raise Missing(key)
        wanted = series, estimator
        return [row for row in self.noise[key] if (row["series"], row["estimator"]) == wanted]

    def gaussian(self, key: Key) -> dict[str, float]:
        """Along x, as S; `pair_sigma_L_mm` and so on along the line between the markers."""
        if key not in self.gaussians:
            raise Missing(key)
        rows = {row["axis"]: row for row in self.gaussians[key]}
        return dict(rows["x"]) | {f"pair_{k}": v for k, v in rows["pair"].items()}

    def lines(self, key: Key, series: str) -> list[tuple[float, float]]:
        """(f_0, A_s) that the likelihood estimator found."""
        found = self.fitted(key, series, DEFAULT_ESTIMATOR)
        return [(found["f_0"], found["A_s"])] if "f_0" in found and "A_s" in found else []


@dataclass(frozen=True)
class Drawn:
    """Moments of one more recording of the same systems: rows as of gaussian.csv, along x."""

    moments: Mapping[Key, Mapping[str, float]]

    def gaussian(self, key: Key) -> Mapping[str, float]:
        return self.moments[key]


Study = Published | Regenerated


def model_of(study: Study, key: Key, series: str) -> NoiseModel:
    """Coefficients as a model; a T_c or q_c without its partner is left out."""
    return NoiseModel.from_coefficients(study.coefficients(key, series))


def active_terms(study: Study, key: Key, series: str) -> list[tuple[float, float]]:
    """(q_c, T_c) of the correlated components that are there: of variance 1e-9 mm^2 or more, and
    not at a limit of the search."""
    found = study.estimates(key, series)
    terms = [(found.get(f"q_c{k}", 0.0), found.get(f"T_c{k}", 0.0)) for k in (1, 2, 3, 4)]
    return [(q, t) for q, t in terms if q**2 * t / 2 >= 1e-9]
