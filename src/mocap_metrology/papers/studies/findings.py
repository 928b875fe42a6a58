"""Studies of J's claims: medians, paired ratios and rank correlations of the errors of simulated
recordings, and what they say about each claim.

A correlation is noticeable from `NOTICEABLE` on: what 40 recordings, as J has, show with p < 0.05.
J's recordings differ in everything at once, those of a study in one circumstance, so a study shows
weaker influences than J could have seen. An error may be infinite: a calibration that found no pose
is worse than any other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.fit.board_pose import MIRRORED_RAD
from mocap_metrology.papers.studies.study import ESTIMATED, REAL, UNWEIGHTED, WEIGHTED

if TYPE_CHECKING:
    import pandas as pd

NOTICEABLE = 0.31  # |r| with p = 0.05 in 40 pairs: t / sqrt(38 + t^2), t = 2.024
MARGINAL = 1.25  # ratio of errors, as in claims.tsv
FAR_OFF_DEG = math.degrees(MIRRORED_RAD)
METHOD = ["estimator", "stage", "variant"]
HOLDS, DOES_NOT, UNKNOWN = "holds", "does not", "undecided"
NO_INFLUENCE, FALLS, OPEN, BETTER = "no influence", "falls", "open", "better"
SETUP = "VII: the setup has no noticeable influence"
MARGINAL_CLAIM = "IV: full interpolation is more accurate; the difference is marginal"
Row = dict[str, Any]


CONFIDENCE = 0.95
FEWEST_PAIRS = 4  # the variance of Fisher's z has n - 3 in its denominator


class Interval(NamedTuple):
    """An estimate and its limits; limits are NaN where the sample is too small to have any."""

    value: float
    lower: float
    upper: float


NONE = Interval(math.nan, math.nan, math.nan)


def median_interval(values: Floats) -> Interval:
    """Median of n values, and the order statistics x_(k), x_(n+1-k) that contain the median of the
    population with a probability of at least `CONFIDENCE`, whatever its distribution: k is the
    largest with P(B < k) <= (1 - CONFIDENCE) / 2, B binomial (n, 1/2) [David & Nagaraja 2003,
    section 7.1].

    Fewer than six values have no such interval of 95 %.
    """
    from scipy.stats import quantile_test

    if not len(values):
        return NONE
    ends = quantile_test(values, p=0.5).confidence_interval(CONFIDENCE)
    return Interval(float(np.median(values)), float(ends.low), float(ends.high))


def rank_correlation(x: Floats, y: Floats) -> Interval:
    """Spearman's rank correlation r of x (n,) and y (n,), ties with their mean rank.

    Interval: tanh(atanh r -+ z sqrt((1 + r^2 / 2) / (n - 3))) [Bonett & Wright 2000], with z the
    normal quantile. Where x has few values, as in a designed study, it covers 93 to 99.8 %
    (simulated: more than 95 % above |r| of 0.6). NaN where x or y is constant; no limits for
    |r| = 1 or fewer than four pairs.
    """
    from scipy.stats import norm, rankdata

    a, b = (rankdata(values) - (len(values) + 1) / 2 for values in (x, y))
    size = math.sqrt(float(a @ a) * float(b @ b))
    if not size:
        return NONE
    r = float(np.clip(a @ b / size, -1.0, 1.0))
    if len(a) < FEWEST_PAIRS or abs(r) > 1 - 1e-12:
        return Interval(r, math.nan, math.nan)
    half = norm.ppf((1 + CONFIDENCE) / 2) * math.sqrt((1 + r**2 / 2) / (len(a) - 3))
    return Interval(r, math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half))


@dataclass(frozen=True)
class StudyDisplay:
    """A study as a table and a figure. data: of `papers.studies`; kind: what J claims of the
    correlation, or (BETTER) of the ratio to the reference; reference: variants whose errors in the
    same recordings those of other variants are divided by; only: estimators and stages; without: a
    variant that another study shows."""

    number: int
    name: str
    data: str
    title: str
    parameter: str
    unit: str
    claim: str
    kind: str = NO_INFLUENCE
    reference: tuple[str, ...] = ()
    only: tuple[tuple[str, str], ...] = ()
    without: str = ""


SHOWN = (
    StudyDisplay(
        *(1, "reconstruction", "reconstruction", "three ways of reconstruction"),
        *("speed of the board", "m/s", "VII, VIII: the speed has no noticeable influence"),
        reference=("full-interpolation",),
    ),
    StudyDisplay(
        *(2, "pattern", "pattern", "motion pattern", "motion pattern", ""),
        "VII: the motion pattern has no noticeable influence",
    ),
    StudyDisplay(
        *(3, "distance", "distance", "distance of the board", "board to both stations", "m"),
        SETUP,
        without=UNWEIGHTED,
    ),
    StudyDisplay(4, "baseline", "baseline", "baseline", "distance of the stations", "m", SETUP),
    StudyDisplay(
        *(5, "diodes", "diodes", "number of diodes", "number of diodes", ""),
        *("III: more diodes lower the ambiguity and make up for poor readings", FALLS),
    ),
    StudyDisplay(
        *(6, "weights", "distance", "Kabsch with and without weights"),
        *("board to both stations", "m"),
        *("VI-E: weights by the remaining error emphasise the accurate poses", BETTER),
        reference=(UNWEIGHTED,),
        only=(("paper", "kabsch"), ("paper-lm", "kabsch")),
    ),
    StudyDisplay(
        *(7, "lasers", "lasers", "a common centre of the lasers against their real places"),
        *("laser to the middle of its station", "mm"),
        *("V-A: open how far a common centre of both lasers affects the accuracy", OPEN),
        reference=(REAL, ESTIMATED),
    ),
)


def rows_of(shown: StudyDisplay, recordings: pd.DataFrame) -> list[Row]:
    """A row for each method and value of a study; recordings: as `papers.studies` writes them, NaN
    for errors of recordings without a pose."""
    table = _selected(shown, recordings)
    boards = table.groupby("distance_m", sort=False) if shown.name == "lasers" else [("nan", table)]
    rows: list[Row] = []
    for board_m, part in boards:
        for method, by_method in part.groupby(METHOD, sort=False):
            name = dict(zip(METHOD, map(str, method), strict=True))
            ratio = _ratio(shown, part, by_method, name)
            of_method = (
                None
                if isinstance(by_method["value"].iloc[0], str)
                else _overall(shown, by_method, ratio)
            )
            for value, point in by_method.groupby("value", sort=False):
                row: Row = {"study": shown.name, "parameter": shown.parameter, "unit": shown.unit}
                row |= {"board_m": float(str(board_m)), **name, "value": value} | _point(point)
                row |= _cells("ratio", median_interval(ratio[point.index].dropna().to_numpy()))
                if of_method is None:  # one kind against all others
                    r = _correlations(
                        by_method, (by_method["value"] == value).to_numpy(dtype=float)
                    )
                    row |= _judged(*r, NONE, shown.claim, influence_word(r[0]))
                rows.append(row | (of_method or {}))
    return rows


def _selected(shown: StudyDisplay, table: pd.DataFrame) -> pd.DataFrame:
    """The methods of a study; an error of NaN as infinite."""
    table = table.astype({"variant": object})  # nothing but gaps is read as numbers
    table = table.fillna({"variant": "", "error_mm": math.inf, "error_deg": math.inf})
    table = table[table["variant"] != shown.without] if shown.without else table
    if shown.only:
        return table[[tuple(pair) in shown.only for pair in table[METHOD[:2]].to_numpy()]]
    return table.replace({"variant": {WEIGHTED: ""}})


def _ratio(
    shown: StudyDisplay, part: pd.DataFrame, of_method: pd.DataFrame, name: Row
) -> pd.Series:
    """Error in mm over that of the reference in the same recording, NaN without one or where
    neither has a pose."""
    same = (part["estimator"] == name["estimator"]) & (part["stage"] == name["stage"])
    reference = part[same & part["variant"].isin(shown.reference)]
    if reference.empty or name["variant"] in shown.reference:
        return of_method["error_mm"] * math.nan
    keys = ["value", "recording"]
    beside = of_method[keys].merge(reference[[*keys, "error_mm"]], on=keys, how="left")["error_mm"]
    return of_method["error_mm"] / beside.to_numpy()


def _point(point: pd.DataFrame) -> Row:
    """Medians of one method at one value, and what became of the recordings."""
    mm, deg = (point[name].to_numpy(dtype=float) for name in ("error_mm", "error_deg"))
    return {
        "n": len(mm),
        "failed": int(np.isinf(mm).sum()),
        "beyond_8_deg": int((np.isfinite(deg) & (deg > FAR_OFF_DEG)).sum()),
        "mirrored_percent": 100 * float(point["mirrored"].astype(float).median()),
        **_cells("mm", median_interval(mm), "median_mm"),
        **_cells("deg", median_interval(deg), "median_deg"),
    }


def _cells(name: str, interval: Interval, first: str = "") -> Row:
    """Three columns of an interval; what is infinite is empty."""
    cells = zip((first or name, f"lower_{name}", f"upper_{name}"), interval, strict=True)
    return {key: value if math.isfinite(value) else math.nan for key, value in cells}


def _overall(shown: StudyDisplay, of_method: pd.DataFrame, ratio: pd.Series) -> Row:
    """Correlations and finding of a method from all its recordings, without values at which none
    has a pose."""
    some = of_method[of_method.groupby("value")["error_mm"].transform("min") < math.inf]
    x = some["value"].to_numpy(dtype=float)
    mm, deg = _correlations(some, x) if len(some) else (NONE, NONE)
    overall = median_interval(ratio.dropna().to_numpy())
    claim, finding = shown.claim, influence_word(mm)
    if shown.kind == BETTER:
        finding = "" if math.isnan(overall.value) else side_word(overall, 1.0, below=True)
    elif shown.name == "reconstruction" and not math.isnan(overall.value):
        marginal = within_word(overall, 1 / MARGINAL, MARGINAL)
        claim, finding = MARGINAL_CLAIM, f"{side_word(overall, 1.0)}; {marginal}"
    elif shown.kind == FALLS:
        finding = side_word(mm, 0.0, below=True)
    elif shown.kind == OPEN:
        finding = "no noticeable influence" if finding == HOLDS else UNKNOWN
        if mm.lower > 0 or mm.upper < 0:
            finding = f"error {'rises' if mm.lower > 0 else 'falls'}"
    return _judged(mm, deg, overall, claim, finding)


def _correlations(of_method: pd.DataFrame, x: np.ndarray) -> tuple[Interval, Interval]:
    """Rank correlations of the errors in mm and in degrees with x."""
    mm, deg = (of_method[name].to_numpy(dtype=float) for name in ("error_mm", "error_deg"))
    return rank_correlation(x, mm), rank_correlation(x, deg)


def _judged(mm: Interval, deg: Interval, ratio: Interval, claim: str, finding: str) -> Row:
    cells = _cells("correlation_mm", mm) | _cells("correlation_deg", deg)
    return cells | _cells("overall_ratio", ratio) | {"claim": claim, "finding": finding}


def side_word(interval: Interval, limit: float, below: bool = False) -> str:
    """Whether a number is above (or below) a limit."""
    above, under = interval.lower > limit, interval.upper < limit
    if not (above or under):
        return UNKNOWN
    return HOLDS if under == below else DOES_NOT


def within_word(interval: Interval, low: float, high: float) -> str:
    """Whether a number is within limits."""
    if interval.lower > low and interval.upper < high:
        return HOLDS
    return DOES_NOT if interval.lower > high or interval.upper < low else UNKNOWN


def influence_word(r: Interval) -> str:
    """Whether a circumstance has no noticeable influence, by its rank correlation."""
    return within_word(r, -NOTICEABLE, NOTICEABLE)


def first_of_methods(rows: list[Row]) -> list[Row]:
    """One row of each method (and kind), for what they have in common."""
    first: dict[tuple[str, ...], Row] = {}
    for row in rows:
        kind = row["value"] if isinstance(row["value"], str) else ""
        first.setdefault((*(str(row[key]) for key in ("board_m", *METHOD)), kind), row)
    return list(first.values())
