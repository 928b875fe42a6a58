"""Studies of J's claims: medians, paired ratios and rank correlations of the errors of simulated
recordings, and what they say about each claim.

A correlation is noticeable from `NOTICEABLE` on: what 40 recordings, as J has, show with p < 0.05.
J's recordings differ in everything at once, those of a study in one circumstance, so a study shows
weaker influences than J could have seen.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.fit.board_pose import MIRRORED_RAD
from mocap_metrology.papers.claims.decide import DOES_NOT, HOLDS, UNKNOWN
from mocap_metrology.papers.studies.errors import UNWEIGHTED, WEIGHTED
from mocap_metrology.papers.studies.ranks import (
    NONE,
    Interval,
    median_interval,
    rank_correlation,
)
from mocap_metrology.papers.studies.study import ESTIMATED, REAL
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    import pandas as pd

NOTICEABLE = 0.31  # |r| with p = 0.05 in 40 pairs: t / sqrt(38 + t^2), t = 2.024
MARGINAL = 1.25  # ratio of errors, as in claims.tsv
FAR_OFF_DEG = math.degrees(MIRRORED_RAD)
FULL = "full-interpolation"
METHOD = ["estimator", "stage", "variant"]
NO_INFLUENCE, FALLS, OPEN, BETTER = "no influence", "falls", "open", "better"


@dataclass(frozen=True)
class Shown:
    """A study as a table and a figure. data: of `papers.studies`; kind: what J claims of the
    correlation, or (BETTER) of the ratio to the reference; reference: variants whose errors in the
    same recordings those of other variants are divided by; only: estimators and stages."""

    number: int
    name: str
    data: str
    title: str
    parameter: str
    unit: str
    claim: str
    kind: str
    reference: tuple[str, ...] = ()
    only: tuple[tuple[str, str], ...] = ()
    without: str = ""  # a variant that another study shows


SHOWN = (
    Shown(
        *(1, "reconstruction", "reconstruction", "three ways of reconstruction"),
        *("speed of the board", "m/s"),
        "VII, VIII: the speed has no noticeable influence",
        NO_INFLUENCE,
        (FULL,),
    ),
    Shown(
        *(2, "pattern", "pattern", "motion pattern", "motion pattern", ""),
        "VII: the motion pattern has no noticeable influence",
        NO_INFLUENCE,
    ),
    Shown(
        *(3, "distance", "distance", "distance of the board"),
        *("board to both stations", "m"),
        "VII: the setup has no noticeable influence",
        NO_INFLUENCE,
        without=UNWEIGHTED,
    ),
    Shown(
        *(4, "baseline", "baseline", "baseline", "distance of the stations", "m"),
        "VII: the setup has no noticeable influence",
        NO_INFLUENCE,
    ),
    Shown(
        *(5, "diodes", "diodes", "number of diodes", "number of diodes", ""),
        "III: more diodes lower the ambiguity and make up for poor readings",
        FALLS,
    ),
    Shown(
        *(6, "weights", "distance", "Kabsch with and without weights"),
        *("board to both stations", "m"),
        "VI-E: weights by the remaining error emphasise the accurate poses",
        BETTER,
        (UNWEIGHTED,),
        (("paper", "kabsch"), ("paper-lm", "kabsch")),
    ),
    Shown(
        *(7, "lasers", "lasers", "a common centre of the lasers against their real places"),
        *("laser to the middle of its station", "mm"),
        "V-A: open how far a common centre of both lasers affects the accuracy",
        OPEN,
        (REAL, ESTIMATED),
    ),
)


def rows_of(shown: Shown, found: pd.DataFrame) -> list[Row]:
    """A row for each method and value; found: recordings as `papers.studies` writes them, NaN
    for errors of recordings without a pose."""
    found = _selected(shown, found)
    rows: list[Row] = []
    for distance_m, of_distance in _by_distance(shown, found):
        for method, own in of_distance.groupby(METHOD, sort=False):
            name = dict(zip(METHOD, map(str, method), strict=True))
            whole = _paired(of_distance, own, shown, name)
            common = _overall(shown, own, whole, name)
            for value, point in own.groupby("value", sort=False):
                ratio = median_interval(whole[own["value"] == value][_known(whole, own, value)])
                rows.append(
                    {
                        "study": shown.name,
                        "parameter": shown.parameter,
                        "unit": shown.unit,
                        "board_m": distance_m,
                        **name,
                        "value": value,
                        **_point(point),
                        **_cells("ratio", ratio),
                        **(common or _of_kind(shown, own, value)),
                    }
                )
    return rows


def _selected(shown: Shown, found: pd.DataFrame) -> pd.DataFrame:
    """The methods of a study; an error of NaN as infinite."""
    found = found.astype({"variant": object})  # nothing but gaps is read as numbers
    found = found.fillna({"variant": "", "error_mm": math.inf, "error_deg": math.inf})
    found = found[found["variant"] != shown.without] if shown.without else found
    if shown.only:
        kept = [tuple(pair) in shown.only for pair in found[METHOD[:2]].to_numpy()]
        return found[kept]
    return found.replace({"variant": {WEIGHTED: ""}})


def _by_distance(shown: Shown, found: pd.DataFrame) -> Iterator[tuple[float, pd.DataFrame]]:
    """Parts of a study that is made at several distances of the board, or the whole (NaN)."""
    if shown.name != "lasers":
        yield math.nan, found
        return
    for distance_m, own in found.groupby("distance_m", sort=False):
        yield float(str(distance_m)), own


def _paired(found: pd.DataFrame, own: pd.DataFrame, shown: Shown, name: Row) -> Floats:
    """Error in mm over that of the reference in the same recording, NaN without one or where
    neither has a pose."""
    same = (found["estimator"] == name["estimator"]) & (found["stage"] == name["stage"])
    reference = found[same & found["variant"].isin(shown.reference)]
    if reference.empty or name["variant"] in shown.reference:
        return np.full(len(own), math.nan)
    keys = ["value", "recording"]
    joined = own.merge(reference[[*keys, "error_mm"]], on=keys, how="left", suffixes=("", "_of"))
    with np.errstate(invalid="ignore"):
        ratio: Floats = (joined["error_mm"] / joined["error_mm_of"]).to_numpy(dtype=float)
    return ratio


def _known(whole: Floats, own: pd.DataFrame, value: object) -> np.ndarray:
    known: np.ndarray = ~np.isnan(whole[own["value"] == value])
    return known


def _point(point: pd.DataFrame) -> Row:
    """Medians of one method at one value, and what became of the recordings."""
    mm, deg = (point[name].to_numpy(dtype=float) for name in ("error_mm", "error_deg"))
    mirrored = point["mirrored"].to_numpy(dtype=float)
    known = mirrored[np.isfinite(mirrored)]
    return {
        "n": len(mm),
        "failed": int(np.isinf(mm).sum()),
        "beyond_8_deg": int((np.isfinite(deg) & (deg > FAR_OFF_DEG)).sum()),
        "mirrored_percent": 100 * float(np.median(known)) if known.size else math.nan,
        **_cells("mm", median_interval(mm), "median"),
        **_cells("deg", median_interval(deg), "median"),
    }


def _cells(name: str, found: Interval, first: str = "") -> Row:
    """Three columns of an interval; what is infinite is empty."""
    names = f"{first}_{name}".strip("_"), f"lower_{name}", f"upper_{name}"
    return {
        key: value if math.isfinite(value) else math.nan
        for key, value in zip(names, found, strict=True)
    }


def _overall(shown: Shown, own: pd.DataFrame, ratio: Floats, name: Row) -> Row | None:
    """Correlations and finding of a method, from all its recordings; None for kinds, which have one
    for each value. Values at which no recording has a pose are left out."""
    if isinstance(own["value"].iloc[0], str):
        return None
    some = own.groupby("value")["error_mm"].transform("min") < math.inf
    mm, deg = (_correlation(own[some], column) for column in ("error_mm", "error_deg"))
    overall = median_interval(ratio[~np.isnan(ratio)])
    claim, finding = _finding(shown, mm, overall, name)
    return _correlations(mm, deg) | _cells("overall_ratio", overall) | _judged(claim, finding)


def _of_kind(shown: Shown, own: pd.DataFrame, value: object) -> Row:
    """The same of one kind against all others: correlation with 1 for this kind, 0 for others."""
    is_this = np.array(own["value"] == value, dtype=np.float64)
    mm, deg = (
        rank_correlation(is_this, own[column].to_numpy(dtype=float))
        for column in ("error_mm", "error_deg")
    )
    return (
        _correlations(mm, deg)
        | _cells("overall_ratio", NONE)
        | _judged(shown.claim, influence_word(mm))
    )


def _correlation(own: pd.DataFrame, column: str) -> Interval:
    if own.empty:
        return NONE
    return rank_correlation(own["value"].to_numpy(dtype=float), own[column].to_numpy(dtype=float))


def _correlations(mm: Interval, deg: Interval) -> Row:
    return _cells("correlation_mm", mm) | _cells("correlation_deg", deg)


def _judged(claim: str, finding: str) -> Row:
    return {"claim": claim, "finding": finding}


def _finding(shown: Shown, r: Interval, ratio: Interval, name: Row) -> tuple[str, str]:
    """The claim that a method's numbers decide, and the word for it."""
    if shown.kind == BETTER:
        return shown.claim, "" if math.isnan(ratio.value) else side_word(ratio, 1.0, below=True)
    if shown.name == "reconstruction" and not math.isnan(ratio.value):
        more, marginal = side_word(ratio, 1.0), marginal_word(ratio)
        claim = "IV: full interpolation is more accurate; the difference is marginal"
        return claim, f"{more}; {marginal}"
    if shown.kind == FALLS:
        return shown.claim, side_word(r, 0.0, below=True)
    return shown.claim, open_word(r) if shown.kind == OPEN else influence_word(r)


def influence_word(r: Interval) -> str:
    """Whether a circumstance has no noticeable influence, by its rank correlation."""
    if r.lower > -NOTICEABLE and r.upper < NOTICEABLE:
        return HOLDS
    return DOES_NOT if r.lower > NOTICEABLE or r.upper < -NOTICEABLE else UNKNOWN


def open_word(r: Interval) -> str:
    """What a study finds where J leaves it open."""
    if r.lower > 0 or r.upper < 0:
        return f"error {'rises' if r.lower > 0 else 'falls'}"
    return "no noticeable influence" if influence_word(r) == HOLDS else UNKNOWN


def side_word(found: Interval, limit: float, below: bool = False) -> str:
    """Whether a number is above (or below) a limit."""
    above, under = found.lower > limit, found.upper < limit
    if not (above or under):
        return UNKNOWN
    return HOLDS if under == below else DOES_NOT


def marginal_word(ratio: Interval) -> str:
    """Whether errors differ by less than `MARGINAL`, either way."""
    if ratio.lower > 1 / MARGINAL and ratio.upper < MARGINAL:
        return HOLDS
    return DOES_NOT if ratio.lower > MARGINAL or ratio.upper < 1 / MARGINAL else UNKNOWN


def first_of_methods(rows: Sequence[Row]) -> list[Row]:
    """One row of each method, for what they have in common."""
    seen: dict[tuple[object, ...], Row] = {}
    for row in rows:
        kind = row["value"] if isinstance(row["value"], str) else ""
        seen.setdefault((str(row["board_m"]), *(row[key] for key in METHOD), kind), row)
    return list(seen.values())
