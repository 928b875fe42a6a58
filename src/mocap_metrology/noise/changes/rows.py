"""Recordings beside each other: rows of <group>_compare, <group>_trend and <group>_places, curves
of their figures, and what beside the system makes their noise differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np
import pandas as pd

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.confidence import interval
from mocap_metrology.noise.changes.compare import (
    Curve,
    adev_ratio,
    adev_trend,
    ratios_to_mean,
    words_of,
)
from mocap_metrology.noise.diagnosis.export import MOST, rounding_share
from mocap_metrology.noise.series import AXES, STRETCHES, pair_name

Columns = Mapping[str, np.ndarray]  # of allan_masked.parquet
Row = dict[str, Any]  # of a table: numbers, words, gaps
TAUS_S = (0.1, 1.0, 10.0, 100.0, 1000.0)  # at which changes are worded, besides a single frame
NO_TREND = "none found"
COARSE = "resolution"  # the word where the file's steps decide
N_TAUS = 60  # of a curve of ratios
SAME_RATE = 0.01  # frame rates that differ by less are one
# Of half the interval of the logarithm of a ratio: at one averaging time of one coordinate the
# ratio of independent recordings is nearer to 1 with a probability of 8 %
SAME_DATA, LEAST_RATIOS = 0.05, 6
NOTABLE = ("low_pass", "moves")  # findings that are of the export or of the object


@dataclass(frozen=True)
class Side:
    """A recording: its name, columns and metadata of allan_masked.parquet (`labels`, `pairs`,
    `frame_rate_hz`), and findings of diagnosis.json."""

    name: str
    columns: Columns
    origin: Mapping[str, Any]
    findings: Sequence[Mapping[str, Any]] = ()

    def named_as(self, other: Side) -> Side:
        """The same recording with its series named as in another: those of markers of one label
        have one number. Markers that only this one has are left out. Where no label is common to
        both, markers are those of the same number."""
        labels = {label: k for k, label in enumerate(other.origin["labels"], start=1)}
        numbers = {
            k: labels[label]
            for k, label in enumerate(self.origin["labels"], start=1)
            if label in labels
        }
        if not numbers:
            return self
        names = {f"{axis}{k}": f"{axis}{n}" for k, n in numbers.items() for axis in AXES}
        pairs, of_other = ([(a, b) for a, b in one.origin["pairs"]] for one in (self, other))
        distances = {frozenset(pair): pair_name(pair, of_other) for pair in of_other}
        for pair in pairs:
            name = distances.get(frozenset(numbers.get(k, 0) for k in pair))
            names |= {pair_name(pair, pairs): name} if name else {}
        series = self.columns["series"]
        keep = np.isin(series, list(names))
        columns = {name: values[keep] for name, values in self.columns.items()}
        columns["series"] = np.array([names[str(name)] for name in series[keep]], dtype=object)
        return Side(self.name, columns, self.origin, self.findings)


def conditions(new: Side, old: Side, rows: Sequence[Row]) -> list[Row]:
    """What is to be known beside the ratios of two recordings, `rows` of `compare_rows`: rows with
    a `code` and its values.

    `same_data`: all ratios are so near 1 that the recordings are one; `rates`: of frames, `white`
    the ratio that they alone make of equal white noise of a frame; `by_number`: no label is common
    to both; `left_out`: series of `new` without a counterpart; `gone`: labels that only `old` has;
    codes of NOTABLE findings that only the recording `recording` has, with their largest or, of a
    cutoff, lowest `value`.
    """
    codes: list[Row] = []
    if _same_data(rows):
        return [{"code": "same_data"}]
    rates = [float(one.origin["frame_rate_hz"]) for one in (new, old)]
    if abs(math.log(rates[0] / rates[1])) > SAME_RATE:
        white = math.sqrt(rates[1] / rates[0])
        codes.append({"code": "rates", "new_hz": rates[0], "old_hz": rates[1], "white": white})
    gone = [label for label in old.origin["labels"] if label not in new.origin["labels"]]
    if len(gone) == len(old.origin["labels"]):
        codes.append({"code": "by_number"})
    elif gone:
        codes.append({"code": "gone", "recording": old.name, "series": gone})
    compared = {row["series"] for row in rows}
    every = dict.fromkeys(str(name) for name in new.columns["series"])
    if missing := [name for name in every if name not in compared]:
        codes.append({"code": "left_out", "series": missing})
    for code in NOTABLE:
        values = [[f["value"] for f in one.findings if f["code"] == code] for one in (new, old)]
        for one, of_it, of_other in zip((new, old), values, values[::-1], strict=True):
            if of_it and not of_other:
                value = (min if code == "low_pass" else max)(of_it)
                codes.append({"code": code, "recording": one.name, "value": value})
    return codes


def _same_data(rows: Sequence[Row]) -> bool:
    """Whether two recordings agree far better than independent ones do, at all averaging times."""
    of = [row for row in rows if not row["series"].startswith("L")]
    return len(of) >= LEAST_RATIOS and all(
        abs(math.log(row["ratio"])) < SAME_DATA * math.log(row["upper"] / row["lower"]) / 2
        for row in of
    )


def curve_of(columns: Columns, series: str) -> Curve:
    """Overlapping Allan deviation of a series, where it is usable."""
    pick = (columns["series"] == series) & (columns["estimator"] == "oadev")
    tau_s, adev, edf = (np.asarray(columns[k][pick], float) for k in ("tau_s", "adev_mm", "edf"))
    there = STRETCHES[0] in columns
    stretches = np.array([columns[k][pick] for k in STRETCHES]) if there else None
    return Curve(tau_s, adev, edf, stretches).usable()


def series_in_all(allan: Sequence[Columns]) -> list[str]:
    """Series that all recordings have, in the order of the first."""
    first, *others = ([str(s) for s in dict.fromkeys(c["series"].tolist())] for c in allan)
    return [name for name in first if all(name in names for names in others)]


def coarse_in_either(
    new: Columns, old: Columns, steps_mm: tuple[float | None, float | None], margin: float
) -> dict[str, float]:
    """`coarse_steps` of either recording. Where their steps differ, also series of which the noise
    of rounding alone makes a change by more than the margin."""
    most = MOST if steps_mm[0] == steps_mm[1] else min(MOST, 1 - (1 + margin) ** -2)
    return coarse_steps(old, steps_mm[1], most) | coarse_steps(new, steps_mm[0], most)


def coarse_steps(columns: Columns, step_mm: float | None, most: float = MOST) -> dict[str, float]:
    """The step of the file by series of which rounding makes more than the share `most` of the
    Allan variance at one frame; beyond `MOST` it hides the noise.

    Where in a step a marker is then decides on its Allan deviations (`noise.diagnosis.export`).
    """
    if step_mm is None or not step_mm > 0 or math.isinf(step_mm):
        return {}
    frame = (columns["estimator"] == "oadev") & (np.asarray(columns["m"]) == 1)
    levels = dict(zip(columns["series"][frame], columns["adev_mm"][frame], strict=True))
    return {
        name: float(step_mm)
        for name in series_in_all([columns])
        if rounding_share(step_mm, float(levels.get(name, math.nan)) ** 2, name[0] == "L") > most
    }


def taus_of(allan: Sequence[Columns]) -> np.ndarray:
    """A single frame (of the slowest recording) and decades of a second."""
    frame = max(float(np.min(columns["tau_s"])) for columns in allan)
    return np.array([frame, *(tau for tau in TAUS_S if tau > 1.5 * frame)])


def compare_rows(
    recording: str,
    reference: str,
    new: Columns,
    old: Columns,
    margin: float,
    alpha: float,
    confidence: float,
    coarse: Mapping[str, float] | None = None,
) -> list[Row]:
    """One row a series both have and averaging time both reach; `overall` is the word of the
    series' largest change, `same` where there is none.

    alpha: probability, at most, that any series of two equal recordings has a word other than
    `same`: each series has its share of it (Bonferroni). coarse: series of which the export's
    resolution decides, in either recording (`coarse_steps`).
    """
    rows: list[Row] = []
    series, coarse = series_in_all([new, old]), coarse or {}
    for name in series:
        curves = curve_of(new, name), curve_of(old, name)
        ratio = adev_ratio(*curves, taus_of([new, old]), confidence)
        words = words_of(ratio, margin, alpha / len(series))
        changes = zip(ratio.value, words, strict=True)
        changed = [(abs(math.log(v)), w) for v, w in changes if w in ("better", "worse")]
        overall = COARSE if name in coarse else max(changed, default=(0.0, "same"))[1]
        for k in (k for k, word in enumerate(words) if word):
            row: Row = {"recording": recording, "reference": reference, "series": name}
            row |= {"tau_s": ratio.tau_s[k], "ratio": ratio.value[k], "lower": ratio.lower[k]}
            row |= {"upper": ratio.upper[k], "p": ratio.p[k]}
            row |= {"word": COARSE if name in coarse else words[k], "overall": overall}
            rows.append(row | {"step_mm": coarse.get(name)})
    if not rows:
        raise Refusal(f"{recording} and {reference}: no series or averaging time in common")
    return rows


def ratio_curves(new: Columns, old: Columns, confidence: float) -> pd.DataFrame:
    """`series`, `tau_s`, `value`, `lower`, `upper` of the ratio of each series that both have, over
    the averaging times that both reach."""
    keys = ("tau_s", "value", "lower", "upper")
    parts = [pd.DataFrame(columns=["series", *keys]).astype(dict.fromkeys(keys, float))]
    for name in series_in_all([new, old]):
        curves = curve_of(new, name), curve_of(old, name)
        low, high = (
            pick((c.tau_s[end] for c in curves if c.tau_s.size), default=0.0)
            for pick, end in ((max, 0), (min, -1))
        )
        if all(c.tau_s.size for c in curves) and high > low:
            ratio = adev_ratio(*curves, np.geomspace(low, high, N_TAUS), confidence)
            parts.append(pd.DataFrame({k: getattr(ratio, k) for k in keys}).assign(series=name))
    return pd.concat(parts[1:] or parts)


def days_of(dates: Sequence[str]) -> list[float]:
    """Days since the first date; dates with a time zone and without one do not mix."""
    moments = [datetime.fromisoformat(date) for date in dates]
    try:
        first = min(moments)
    except TypeError as error:
        raise Refusal(
            "dates: some have a time zone and some have none; expected one way"
        ) from error
    return [(moment - first).total_seconds() / 86400 for moment in moments]


def trend_rows(
    names: Sequence[str],
    dates: Sequence[str],
    allan: Mapping[str, Columns],
    alpha: float,
    confidence: float,
    coarse: Mapping[str, float] | None,
) -> list[Row]:
    """One row a series and averaging time that three or more recordings of different days have.
    alpha is that of one series, over its averaging times; coarse as in `compare_rows`, of any."""
    days, rows, every = days_of(dates), [], [allan[name] for name in names]
    taus = taus_of(every)
    for series in series_in_all(every):
        curves = [curve_of(columns, series).at(taus) for columns in every]
        adev, edf = (np.array([getattr(c, k) for c in curves]) for k in ("adev", "edf"))
        known = np.isfinite(adev).all(axis=0)
        for k in np.flatnonzero(known):
            trend = adev_trend(days, adev[:, k].tolist(), edf[:, k].tolist(), confidence)
            clear = trend.p < alpha / known.sum()
            word = ("worse" if trend.per_month > 1 else "better") if clear else NO_TREND
            row: Row = {"series": series, "tau_s": taus[k], "n_recordings": trend.n}
            row |= {"from": min(dates), "to": max(dates)}
            row["percent_per_month"] = 100 * (trend.per_month - 1)
            row |= {end: 100 * (getattr(trend, end) - 1) for end in ("lower", "upper")}
            row |= {"p": trend.p, "scatter": trend.scatter}
            rows.append(row | {"word": COARSE if coarse and series in coarse else word})
    return rows


def dated_curves(
    names: Sequence[str],
    dates: Sequence[str],
    allan: Mapping[str, Columns],
    series: Sequence[str],
    taus_s: np.ndarray,
    confidence: float,
) -> pd.DataFrame:
    """`series`, `tau_s`, `date`, `adev` (µm) with its interval `lower`, `upper` of each series of
    each recording that reaches an averaging time."""
    parts = []
    for one in series:
        for name, date in zip(names, dates, strict=True):
            curve = curve_of(allan[name], one).at(taus_s)
            values = {"tau_s": taus_s, "adev": 1000 * curve.adev, "edf": curve.edf}
            moment = datetime.fromisoformat(date)
            parts.append(pd.DataFrame(values).assign(series=one, date=[moment] * len(taus_s)))
    points = pd.concat(parts).dropna(subset="adev")
    low, high = interval(points["adev"].to_numpy() ** 2, points["edf"].to_numpy(), confidence)
    return points.assign(lower=low, upper=high)


def places_rows(
    recordings: Sequence[Mapping[str, Any]],
    allan: Mapping[str, Columns],
    means: Mapping[str, Mapping[str, float]],
) -> list[Row]:
    """One row a recording and series: where it was, its noise, and by what `factor` it exceeds the
    geometric mean of all places (`ratios_to_mean`), at one frame and at 1 s."""
    rows: list[Row] = []
    names = [row["recording"] for row in recordings]
    for series in series_in_all([allan[name] for name in names]):
        curves = [curve_of(allan[name], series) for name in names]
        taus = np.array([max([c.tau_s[0] for c in curves if c.tau_s.size], default=0.0), 1.0])
        levels = np.array([curve.at(taus).adev for curve in curves])
        if not np.isfinite(levels[:, 0]).any():
            continue
        quietest = names[np.nanargmin(levels[:, 0])]
        ratios = ratios_to_mean(curves, taus)
        for recording, level, ratio in zip(recordings, levels, ratios, strict=True):
            name = recording["recording"]
            row = {"recording": name, "place": recording["place"], **means[name], "series": series}
            for k, label in enumerate(("1_frame", "1_s")):
                row |= {f"adev_{label}_mm": level[k], f"factor_{label}": ratio.value[k]}
                row |= {f"factor_{label}_{e}": getattr(ratio, e)[k] for e in ("lower", "upper")}
            rows.append(row | {"quietest": name == quietest})
    if not rows:
        raise Refusal(f"{', '.join(names)}: expected a series that all places have")
    return rows
