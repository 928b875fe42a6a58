"""A take of a monitored facility in a few numbers, the series that many takes make, rows of
monitor.csv, and numbers of each series at the last take."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from mocap_metrology.accuracy.monitor import PRIOR_DF, Chart, WatchLimits, chart, limits, words
from mocap_metrology.accuracy.monitor_row import Row
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.common.types import Row as TableRow
from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.settings import Monitor

COLUMNS = (
    *("recording", "date", "series", "value_mm", "mean_mm", "lower_mm", "upper_mm", "q", "cusum"),
    *("takes_of_baseline", "in_baseline", "capable", "restart", "word"),
)
LEAST_JITTER_MM = 1e-6  # of a stream that repeats itself; its logarithm must be finite
LEAST_DF = 20  # of a wander that is judged
SEVERAL = 3  # markers, of which a single one is lost among all

Kind = Literal["jitter", "wander", "place", "length"]


@dataclass(frozen=True)
class Take:
    """jitter_mm: from frame to frame; wander_mm: Allan deviation at `monitor.wander_s`, both the
    root mean square of all coordinates; wander_df: its degrees of freedom; places_mm: mean
    position of each marker; lengths_mm: mean distance of each pair; jitters_mm, wanders_mm: of each
    marker."""

    jitter_mm: float
    wander_mm: float
    wander_df: float
    places_mm: Mapping[str, Sequence[float]]
    lengths_mm: Mapping[str, float]
    jitters_mm: Mapping[str, float]
    wanders_mm: Mapping[str, float]


def numbers(
    positions: Mapping[str, Floats],
    distances: Mapping[str, Floats],
    frame_rate_hz: float,
    wander_s: float,
) -> Take:
    """Numbers of a take: (3, n) cleaned coordinates of each marker, (n,) distances of each pair, in
    mm, gaps as NaN.

    The jitter is the Allan deviation at one frame, sqrt(<(x_(k+1) - x_k)^2> / 2). Of the wander the
    terms that do not overlap are its degrees of freedom, (n - 2m + 1) / m at m frames.
    """
    series = [axis for marker in positions.values() for axis in marker]
    n, m = series[0].size, max(round(wander_s * frame_rate_hz), 1)
    factors = np.array([1, min(m, max(n // 2, 1))])
    variances = np.array([allan_variance(one, factors).variance for one in series])
    jitters, wanders = (
        {label: _root_mean(variances[3 * i : 3 * i + 3, k]) for i, label in enumerate(positions)}
        for k in range(2)
    )
    return Take(
        _root_mean(variances[:, 0]),
        _root_mean(variances[:, 1]),
        max(n - 2 * m + 1, 0) / m,
        {label: np.nanmean(values, axis=1).tolist() for label, values in positions.items()},
        {
            name: float(np.nanmean(values)) if np.isfinite(values).any() else np.nan
            for name, values in distances.items()
        },
        jitters,
        wanders,
    )


def _root_mean(variances: Floats) -> float:
    known = variances[np.isfinite(variances)]
    return float(np.sqrt(known.mean())) if known.size else np.nan


@dataclass(frozen=True)
class Series:
    """One number of each take: values (n,) in which it is charted, `natural` those to show;
    marker: of which one it is, nothing where it is of all or of a pair."""

    name: str
    kind: Kind
    values: Floats
    judged: np.ndarray
    watched: WatchLimits
    marker: str = ""

    def natural(self, values: Floats) -> Floats:
        """Charted values in mm."""
        if self.kind == "jitter":
            return np.exp(values)
        return np.maximum(values, 0) ** 1.5 if self.kind == "wander" else values

    def change(self, difference: Floats, mean: Floats) -> Floats:
        """The change that a difference of charted values means: in mm, of jitter and wander as a
        share."""
        if self.kind in ("place", "length"):
            return difference
        return self.natural(mean + difference) / self.natural(mean) - 1

    @property
    def unit(self) -> str:
        """Unit of a change."""
        return "mm" if self.kind in ("place", "length") else ""

    @property
    def code(self) -> str:
        """Code of a finding that reports a change."""
        return f"{self.kind}_changed"


def series_of(takes: Sequence[Take], how: Monitor) -> list[Series]:
    """All series of takes of the same markers and pairs: of all markers together, of each pair,
    and, of three markers or more, of each marker."""
    every = np.ones(len(takes), dtype=bool)
    enough = np.array([take.wander_df >= LEAST_DF for take in takes])
    tolerance, scatter = how.tolerance, how.scatter
    of_jitter = WatchLimits(tolerance.jitter, scatter.jitter)
    of_wander = WatchLimits(tolerance.wander, scatter.wander, relative=True)
    of_place = WatchLimits(tolerance.place_mm, scatter.place_mm)
    of_length = WatchLimits(tolerance.length_mm, scatter.length_mm)

    def jitter(values: Floats, marker: str = "") -> Series:
        logs = np.log(np.maximum(values, LEAST_JITTER_MM))
        return Series(f"jitter {marker}".rstrip(), "jitter", logs, every, of_jitter, marker)

    def wander(values: Floats, marker: str = "") -> Series:
        name = f"wander {marker}".rstrip()
        return Series(name, "wander", values ** (2 / 3), enough, of_wander, marker)

    def place(name: str, values: Floats, marker: str = "") -> Series:
        return Series(f"place {name}", "place", values, every, of_place, marker)

    labels = list(takes[0].places_mm)
    alone = labels if len(labels) >= SEVERAL else []
    together, single = _places(takes, how)
    lengths = {n: _values(take.lengths_mm[n] for take in takes) for n in takes[0].lengths_mm}
    series = [
        jitter(_values(take.jitter_mm for take in takes)),
        wander(_values(take.wander_mm for take in takes)),
        *(place(axis, together[:, k]) for k, axis in enumerate("xyz") if together.size),
        *(Series(f"length {n}", "length", v, every, of_length) for n, v in lengths.items()),
        *(jitter(_values(take.jitters_mm[label] for take in takes), label) for label in alone),
        *(wander(_values(take.wanders_mm[label] for take in takes), label) for label in alone),
        *(
            place(f"{label} {axis}", single[:, i, k], label)
            for i, label in enumerate(alone)
            for k, axis in enumerate("xyz")
        ),
    ]
    return [one for one in series if np.isfinite(one.values).any()]


def _values(numbers: Iterable[float | None]) -> Floats:
    """NaN where JSON had no number."""
    return np.array([*numbers], dtype=float)


def _places(takes: Sequence[Take], how: Monitor) -> tuple[Floats, Floats]:
    """Of all markers (takes, 3), and of each (takes, markers, 3): the mean of the first take and of
    the ways of the markers since then, and what each is off that mean way; or nothing, and what a
    rigid fit to the first take leaves of each. Of three ways or more those that differ from the
    median by more than the tolerance are not in the mean: a marker that is moved leaves it."""
    labels = list(takes[0].places_mm)
    places = np.array([[take.places_mm[label] for label in labels] for take in takes], dtype=float)
    if how.frame == "fixed":
        ways = places - places[0]
        near = np.abs(ways - np.median(ways, axis=1, keepdims=True)) <= how.tolerance.place_mm
        near |= ~near.any(axis=1, keepdims=True)
        common = (ways * near).sum(axis=1) / near.sum(axis=1)
        return places[0].mean(axis=0) + common, ways - common[:, None]
    if len(labels) < SEVERAL:
        raise Refusal(
            f"monitor.frame is fitted, and there are {len(labels)} markers; expected three or more"
        )
    from scipy.spatial.transform import Rotation

    centred = places - places.mean(axis=1, keepdims=True)
    left = [Rotation.align_vectors(centred[0], one)[0].apply(one) - centred[0] for one in centred]
    return np.empty(0), np.array(left)


@dataclass(frozen=True)
class Judged:
    """A series of a stretch, from one restart to the next, and its chart.

    at: (k,) which takes are judged; words: of each of them, and since which one of them the series
    is not valid.
    """

    series: Series
    at: np.ndarray
    chart: Chart
    words: Sequence[tuple[str, int | None]]


Stretches = Mapping[int, Sequence[Judged]]


def judge(
    takes: Sequence[Take], days: Sequence[str], marked: Sequence[bool], how: Monitor
) -> list[Judged]:
    """Every series of one stretch of takes, in order of time.

    days: of each; marked: whether the sheet names it as of the baseline.
    """
    every, judged = series_of(takes, how), []
    watched = [np.flatnonzero(one.judged & np.isfinite(one.values)) for one in every]
    kinds = [bool(one.marker) for one in every]
    number = Counter(kind for kind, at in zip(kinds, watched, strict=True) if at.size)
    limit = {  # of single markers half of the false alarms, however many there are
        kind: limits(max(number[kind] * len(number), 1), how.false_alarms, how.dates)
        for kind in set(kinds)
    }
    for one, at in zip(every, watched, strict=True):
        own_days = [days[k] for k in at.tolist()]
        own = limit[bool(one.marker)]
        charted = chart(one.values[at], own_days, np.array(marked)[at], one.watched, own)
        judged.append(Judged(one, at, charted, words(charted)))
    return judged


def stretches(rows: Sequence[Row], takes: Sequence[Take], how: Monitor) -> Stretches:
    """Charts of a facility from its takes, in order of time: of each stretch of them from one
    restart to the next, by the number of its first take."""
    starts = [k for k, row in enumerate(rows) if k == 0 or row.baseline == "restart"]
    judged_from = {}
    for start, end in zip(starts, [*starts[1:], len(rows)], strict=False):
        part = rows[start:end]
        named = any(row.baseline == "yes" for row in part)
        marked = [named and row.baseline != "" for row in part]
        days = [row.date[:10] for row in part]
        judged_from[start] = judge(takes[start:end], days, marked, how)
    return judged_from


def table(takes: Sequence[Row], stretches: Stretches) -> list[TableRow]:
    """Rows of monitor.csv: a series of a take each, in order of the takes."""
    rows: list[TableRow] = []
    for start, judged in stretches.items():
        columns = [_columns(one, start == 0) for one in judged]
        n = len(columns[0]["value_mm"])
        for k, take in enumerate(takes[start : start + n]):
            for column, one in zip(columns, judged, strict=True):
                named = {"recording": take.recording, "date": take.date, "series": one.series.name}
                rows.append(named | {key: column[key][k] for key in COLUMNS[3:]})
    return rows


def _columns(one: Judged, is_first: bool) -> dict[str, list[Any]]:
    """Values of all takes of a stretch; those that are not judged have a value alone."""
    chart, series, n = one.chart, one.series, one.series.values.size

    def every(values: Any, gap: Any) -> list[Any]:
        filled = np.full(n, gap, dtype=object)
        filled[one.at] = values
        return filled.tolist()

    ends = (series.natural(chart.mean + sign * chart.band) for sign in (-1, 1))
    lower, upper = (every(end, np.nan) for end in ends)
    return {
        "value_mm": series.natural(series.values).tolist(),
        "mean_mm": every(series.natural(chart.mean), np.nan),
        "lower_mm": lower,
        "upper_mm": upper,
        "q": every(chart.q, np.nan),
        "cusum": every(chart.cusum, np.nan),
        "takes_of_baseline": every(chart.n_baseline, ""),
        "in_baseline": every(np.where(chart.baseline, "yes", ""), ""),
        "capable": every(np.where(chart.learning, "", np.where(chart.capable, "yes", "no")), ""),
        "restart": ["" if k or is_first else "yes" for k in range(n)],
        "word": every([word for word, _ in one.words], ""),
    }


def failed_since(one: Judged) -> int | None:
    """Number in the stretch of the take since which the series is not valid."""
    since = one.words[-1][1] if one.words else None
    return None if since is None else int(one.at[since])


def shares(one: Judged) -> Mapping[str, float]:
    """Changes against the mean of the baseline, in mm or as shares: of the take, of what is
    allowed on its side, of the mean since the CUSUM rose, within the baseline, of its scatter, of
    the tolerance and of the smallest one that can be watched; lower, upper: 95 % of the take's, by
    the scatter."""
    chart, series = one.chart, one.series
    mean, m = chart.mean[-1], max(int(chart.n_baseline[-1]), 1)
    change = chart.value[-1] - mean
    reach = 1.96 * chart.scatter[-1] * np.sqrt(1 + 1 / m)
    sizes = {
        "take": change,
        "room": np.copysign(chart.band[-1], change),
        "shift": chart.shift[-1],
        "parted": chart.parted[-1],
        "scatter": chart.scatter[-1],
        "tolerance": chart.tolerance[-1],
        "least": chart.watchable[-1],
        "lower": change - reach,
        "upper": change + reach,
    }
    return {name: float(series.change(size, mean)) for name, size in sizes.items()}


def state(one: Judged) -> TableRow:
    """A series at the last take."""
    last, known = {key: values[-1] for key, values in _columns(one, True).items()}, one.chart
    state = {key: last[key] for key in COLUMNS[3:9]} | {"word": one.words[-1][0]}
    if known.learning[-1]:
        return state
    sizes = shares(one)
    more = {"change": sizes["take"], "unit": one.series.unit, "tolerance": sizes["tolerance"]}
    more |= {"scatter": float(known.scatter[-1]), "dof": int(known.n_baseline[-1]) - 1 + PRIOR_DF}
    return state | more | {"capable": bool(known.capable[-1]), "smallest_tolerance": sizes["least"]}
