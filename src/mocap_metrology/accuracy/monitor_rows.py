"""A facility over its takes: rows of monitor.csv, and numbers of each series at the last take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.accuracy.monitor import PRIOR_DF
from mocap_metrology.accuracy.monitor_row import Row as SheetRow
from mocap_metrology.accuracy.monitor_take import Judged, Stretches
from mocap_metrology.common.types import Row

COLUMNS = (
    *("recording", "date", "series", "value_mm", "mean_mm", "lower_mm", "upper_mm", "q", "cusum"),
    *("takes_of_baseline", "in_baseline", "capable", "restart", "word"),
)


def table(takes: Sequence[SheetRow], stretches: Stretches) -> list[Row]:
    """Rows of monitor.csv: a series of a take each, in order of the takes."""
    rows: list[Row] = []
    for start, found in stretches.items():
        columns = [_columns(one, start == 0) for one in found]
        n = len(columns[0]["value_mm"])
        for k, take in enumerate(takes[start : start + n]):
            for own, one in zip(columns, found, strict=True):
                named = {"recording": take.recording, "date": take.date, "series": one.series.name}
                rows.append(named | {key: own[key][k] for key in COLUMNS[3:]})
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
    known = ~chart.learning
    return {
        "value_mm": series.natural(series.values).tolist(),
        "mean_mm": every(series.natural(chart.mean), np.nan),
        "lower_mm": lower,
        "upper_mm": upper,
        "q": every(chart.q, np.nan),
        "cusum": every(chart.cusum, np.nan),
        "takes_of_baseline": every(chart.n_baseline, ""),
        "in_baseline": every(np.where(chart.baseline, "yes", ""), ""),
        "capable": every(np.where(known, np.where(chart.capable, "yes", "no"), ""), ""),
        "restart": ["" if k or is_first else "yes" for k in range(n)],
        "word": every([word for word, _ in one.words], ""),
    }


def failed_since(one: Judged) -> int | None:
    """Number in the stretch of the take since which the series is not valid."""
    since = one.words[-1][1] if one.words else None
    return None if since is None else int(one.at[since])


def shares(one: Judged) -> Mapping[str, float]:
    """Changes against the mean of the baseline, in mm or as shares: of the take, of what is
    allowed on its side, of the mean since the CUSUM rose, of the tolerance and of the smallest one
    that can be watched; lower, upper: 95 % of the take's, by the scatter."""
    chart, series = one.chart, one.series
    mean, m = chart.mean[-1], max(int(chart.n_baseline[-1]), 1)
    own = chart.value[-1] - mean
    reach = 1.96 * chart.scatter[-1] * np.sqrt(1 + 1 / m)
    sizes = {
        "take": own,
        "room": np.copysign(chart.band[-1], own),
        "shift": chart.shift[-1],
        "tolerance": chart.tolerance[-1],
        "least": chart.watchable[-1],
        "lower": own - reach,
        "upper": own + reach,
    }
    return {name: float(series.change(size, mean)) for name, size in sizes.items()}


def state(one: Judged) -> Row:
    """A series at the last take."""
    own, known = {key: values[-1] for key, values in _columns(one, True).items()}, one.chart
    state = {key: own[key] for key in COLUMNS[3:9]} | {"word": one.words[-1][0]}
    if known.learning[-1]:
        return state
    sizes = shares(one)
    more = {"change": sizes["take"], "unit": one.series.unit, "tolerance": sizes["tolerance"]}
    more |= {"scatter": float(known.scatter[-1]), "dof": int(known.n_baseline[-1]) - 1 + PRIOR_DF}
    return state | more | {"capable": bool(known.capable[-1]), "smallest_tolerance": sizes["least"]}
