"""A facility over its takes as table, as document (monitor.json) and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.accuracy.monitor import LEARNT, ORDER, PRIOR_DF, SETTLED
from mocap_metrology.accuracy.monitor_row import Row as SheetRow
from mocap_metrology.accuracy.monitor_take import Judged, Stretches
from mocap_metrology.common.types import Row
from mocap_metrology.present.text.numbers import mm, number, percent, with_unit
from mocap_metrology.present.text.sentence import render

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


def document(
    name: str,
    takes: Sequence[SheetRow],
    stretches: Stretches,
    left_out: Mapping[str, str],
    sources: Sequence[str],
) -> Row:
    """Contents of monitor.json: whether the calibration is valid, word and reasons of the last
    take, and the state of each series; left_out: rows that were not used, and why; sources: `twin`
    or `measured` of each take."""
    left = [{"recording": recording, "why": why} for recording, why in left_out.items()]
    told = [render("monitor.left_out", **one) for one in left]
    source = sources[0] if len(set(sources)) == 1 else "mixed" if sources else ""
    common: Row = {"monitor": name, "source": source, "left_out": left}
    if not takes:
        line = render("monitor.empty", name=name, reasons=told)
        return common | {"valid": None, "word": "", "takes": 0, "reasons": told, "line": line}
    start, found = max(stretches.items())
    last = takes[-1]
    at = len(takes) - 1 - start
    judged = [one for one in found if one.at.size and one.at[-1] == at]
    word = min((one.words[-1][0] for one in judged), key=ORDER.index, default="")
    # A series that this take says nothing about keeps what the take before said
    wrong = {one.series.name: failed for one in found if (failed := _failed(one)) is not None}
    dates = [takes[start + first].date for first in wrong.values()]
    m = max(int(one.chart.n_baseline[-1]) for one in judged) if judged else 0
    findings = [finding for one in judged for finding in _findings(one)]
    findings.sort(key=lambda one: one["code"] == "not_capable")  # last
    valid = None if word == "learning" else not wrong
    learnt = set().union(*(one.at[one.chart.baseline].tolist() for one in judged))
    days = len({takes[start + k].date[:10] for k in learnt})
    how = {"m": len(learnt) if word == "learning" else m, "days": days}
    how |= {"learnt": LEARNT, "settled": SETTLED}
    how |= {"trend": any(one["code"] == "trend" for one in findings)}
    beyond = any(one.chart.beyond[-1] for one in judged)
    key = "back" if word == "alert" and wrong and not beyond else word or "learning"
    first = render(f"monitor.{key}", since=min(dates, default=""), **how)
    reasons = [first, *(one.pop("words") for one in findings)]
    named = {"name": name, "recording": last.recording, "date": last.date}
    return common | {
        "valid": valid,
        "word": word,
        "since": min(dates, default=None),
        "not_valid": list(wrong),
        "recording": last.recording,
        "date": last.date,
        "takes": len(takes),
        "takes_of_baseline": m,
        "restarted": takes[start].date,
        "reasons": reasons,
        "series": {one.series.name: _state(one) for one in judged},
        "findings": findings,
        "line": render("monitor.line", word=word, reasons=[*reasons, *told], **named),
    }


def _failed(one: Judged) -> int | None:
    """Number in the stretch of the take since which the series is not valid."""
    since = one.words[-1][1] if one.words else None
    return None if since is None else int(one.at[since])


def _shares(one: Judged) -> Mapping[str, float]:
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


def _findings(one: Judged) -> list[Row]:
    """What is to be said of a series at the last take, with its words."""
    chart, series = one.chart, one.series
    if chart.learning[-1]:
        return []
    sizes, m = _shares(one), int(chart.n_baseline[-1])
    unit = series.unit
    size = render(
        "changed.size",
        name=series.name,
        value=_value(one, float(series.natural(chart.value)[-1])),
        change=_change(sizes["take"], unit),
        m=m,
    )
    found: list[Row] = []

    def find(code: str, case: str, value: float, ends: tuple[float, float], **how: Any) -> None:
        words = render(f"changed.{case}", name=series.name, size=size, **how)
        of = {"code": code, "series": series.name, "value": value, "unit": unit}
        found.append(of | {"lower_95": ends[0], "upper_95": ends[1], "words": words})

    interval = sizes["lower"], sizes["upper"]
    if chart.beyond[-1]:
        find(series.code, "beyond", sizes["take"], interval, room=_change(sizes["room"], unit))
    elif chart.unusual[-1]:
        find(series.code, "unusual", sizes["take"], interval)
    if chart.drifting[-1]:
        n = chart.value.size - int(chart.since[-1])
        moved = _change(sizes["shift"], unit)
        find("trend", "trend", sizes["shift"], (np.nan, np.nan), change=moved, n=n)
    if not chart.capable[-1]:
        least, asked = (_change(sizes[name], unit, False) for name in ("least", "tolerance"))
        ends = np.nan, np.nan
        find("not_capable", "not_capable", sizes["least"], ends, least=least, tolerance=asked)
    return found


def _value(one: Judged, value: float) -> str:
    return mm(value) if one.series.kind in ("jitter", "wander") else f"{number(value, 3)} mm"


def _change(size: float, unit: str, sign: bool = True) -> str:
    return with_unit(size, unit, 2, sign) if unit else percent(size, 2, sign)


def _state(one: Judged) -> Row:
    """A series at the last take."""
    own, known = {key: values[-1] for key, values in _columns(one, True).items()}, one.chart
    state = {key: own[key] for key in COLUMNS[3:9]} | {"word": one.words[-1][0]}
    if known.learning[-1]:
        return state
    sizes = _shares(one)
    more = {"change": sizes["take"], "unit": one.series.unit, "tolerance": sizes["tolerance"]}
    more |= {"scatter": float(known.scatter[-1]), "dof": int(known.n_baseline[-1]) - 1 + PRIOR_DF}
    return state | more | {"capable": bool(known.capable[-1]), "smallest_tolerance": sizes["least"]}
