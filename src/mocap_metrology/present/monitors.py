"""A facility over its takes as table, as document (monitor.json) and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.accuracy.monitor import LEARNT, ORDER, SETTLED
from mocap_metrology.accuracy.monitor_row import Row as SheetRow
from mocap_metrology.accuracy.monitor_take import (
    SEVERAL,
    Judged,
    Series,
    Stretches,
    failed_since,
    shares,
    state,
)
from mocap_metrology.common.types import Row
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.text.numbers import mm, number, percent, with_unit
from mocap_metrology.present.text.sentence import MOST_NAMED, render

STRIP_MM, HEAD_MM = 27.0, 28.0
MOST_STRIPS = 12
OF_ALL = ("jitter", "wander", "place x", "place y", "place z")
BAND = "#1a809d"
# Colour and marker of a word, in the order in which they are drawn
LOOKS = {
    "learning": (plot.GREY, "o"),
    "provisional": ("#5b7fc4", "o"),
    "pass": ("#0d2a6b", "o"),
    "note": ("#b7791f", "s"),
    "alert": ("#c2410c", "^"),
    "failure": ("#991b1b", "X"),
}
NUMBERS = ("value_mm", "mean_mm", "lower_mm", "upper_mm")
Columns = dict[str, np.ndarray]


def document(
    name: str,
    takes: Sequence[SheetRow],
    stretches: Stretches,
    left_out: Mapping[str, str],
    sources: Sequence[str],
    markers: Sequence[str],
) -> Row:
    """Contents of monitor.json: whether the calibration is valid, word and reasons of the last
    take, and the state of each series; left_out: rows that were not used, and why; sources: `twin`
    or `measured` of each take; markers: labels of those of the takes."""
    left = [{"recording": recording, "why": why} for recording, why in left_out.items()]
    told = [render("monitor.left_out", **one) for one in left]
    source = sources[0] if len(set(sources)) == 1 else "mixed" if sources else ""
    common: Row = {"monitor": name, "source": source, "left_out": left}
    if not takes:
        line = render("monitor.empty", name=name, reasons=told)
        return common | {"valid": None, "word": "", "takes": 0, "reasons": told, "line": line}
    start, judged_all = max(stretches.items())
    last = takes[-1]
    at = len(takes) - 1 - start
    judged = [one for one in judged_all if one.at.size and one.at[-1] == at]
    m = max((int(one.chart.n_baseline[-1]) for one in judged), default=0)
    word = _word(judged, m)
    # A series that this take says nothing about keeps what the take before said
    wrong = {one.series.name: take for one in judged_all if (take := failed_since(one)) is not None}
    dates = [takes[start + first].date for first in wrong.values()]
    findings = [finding for one in judged for finding in _findings(one)]
    findings.sort(key=lambda one: one["code"] == "not_capable")  # last
    parted = any(one["case"] in ("parted", "levels", "scattered") for one in findings)
    valid = None if word == "learning" or (parted and not wrong) else not wrong
    learnt = set().union(*(one.at[one.chart.baseline].tolist() for one in judged))
    days = len({takes[start + k].date[:10] for k in learnt})
    how: dict[str, Any] = {"m": len(learnt) if word == "learning" else m, "days": days}
    how |= {"learnt": LEARNT, "settled": SETTLED}
    how |= {"named": any(take.baseline == "yes" for take in takes[start:])}
    how |= {"trend": any(one["code"] == "trend" for one in findings), "parted": parted}
    beyond = [one.series for one in judged if one.chart.beyond[-1]]
    key = "back" if word == "alert" and wrong and not beyond else word or "learning"
    at_fault = [one.series for one in judged_all if one.series.name in wrong] or beyond
    how |= {"alone": _single(at_fault, markers), "others": len(markers) - 1}
    first = render(f"monitor.{key}", since=min(dates, default=""), **how)
    late = [] if word == "learning" else _not_judged(judged_all, judged)
    if m < SETTLED and not how["named"]:
        late += _not_learnt(judged, [take.recording for take in takes[start:]])
    reasons = [first, *_reasons(findings), *late]
    pairs = [one.series.name for one in judged_all if one.series.kind == "length"]
    watched = render("monitor.watched", markers=markers, pairs=pairs)
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
        "markers": list(markers),
        "series": {one.series.name: state(one) for one in judged},
        "findings": findings,
        "line": render("monitor.line", word=word, reasons=[*reasons, watched, *told], **named),
    }


def _word(judged: Sequence[Judged], m: int) -> str:
    """The worst word; a series with fewer takes of the baseline than m, the most, is learnt later
    than the others, and does not make the facility learn again."""
    words = [
        one.words[-1][0]
        for one in judged
        if one.words[-1][0] not in ("learning", "provisional") or one.chart.n_baseline[-1] == m
    ]
    return min(words, key=ORDER.index, default="")


def _not_judged(every: Sequence[Judged], judged: Sequence[Judged]) -> list[str]:
    """Which series of all markers or of a pair this take says nothing about, or not yet."""
    common = [one for one in every if not one.series.marker]
    short = [one.series.name for one in common if one not in judged]
    learning = [one.series.name for one in common if one in judged and one.chart.learning[-1]]
    names = {"learning": learning, "short": short, "learnt": LEARNT}
    return [render("monitor.not_judged", **names)] if learning or short else []


def _not_learnt(judged: Sequence[Judged], names: Sequence[str]) -> list[str]:
    """Which of the first takes are none of the baseline, as they are unlike the others."""
    off = {
        int(one.at[k])
        for one in judged
        for k in np.flatnonzero(one.chart.learning & ~one.chart.baseline)[:LEARNT]
        if one.chart.baseline[k:].any()
    }
    return [render("monitor.not_learnt", names=[names[k] for k in sorted(off)])] if off else []


def _single(at_fault: Sequence[Series], markers: Sequence[str]) -> str:
    """The only marker that series are of, or nothing; what is of all markers or of its pair may be
    due to it."""
    alone = {one.marker for one in at_fault if one.marker}
    if len(alone) != 1 or len(markers) < SEVERAL:
        return ""
    (marker,) = alone
    kinds = {one.kind for one in at_fault if one.marker}
    ends = f"length {marker}-", f"-{marker}"
    others = [
        one
        for one in at_fault
        if not one.marker and (one.kind == "place" or one.kind not in kinds)
        if not (
            one.kind == "length" and (one.name.startswith(ends[0]) or one.name.endswith(ends[1]))
        )
    ]
    return "" if others else marker


def _reasons(findings: Sequence[dict[str, Any]]) -> list[str]:
    """Sentences of findings; of single markers the largest of each case, and which others."""
    said: list[str] = []
    cases: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for one in findings:
        words, marker, case, size = (one.pop(key) for key in ("words", "marker", "case", "size"))
        if not marker:
            said.append(words)
            continue
        kind = one["series"].split()[0] if case == "not_capable" else ""
        cases.setdefault((case, kind), []).append({"words": words, "size": size} | one)
    for (_, kind), several in cases.items():
        several.sort(key=lambda one: -one["size"])
        said.append(several[0]["words"])
        names = [one["series"] for one in several[1:]]
        if names and not kind:
            said.append(render("changed.others", n=len(names), names=names[:MOST_NAMED]))
    return said


def _findings(one: Judged) -> list[dict[str, Any]]:
    """What is to be said of a series at the last take, with its words."""
    chart, series = one.chart, one.series
    if chart.learning[-1]:
        return []
    sizes, m = shares(one), int(chart.n_baseline[-1])
    unit, name = series.unit, series.name[:1].upper() + series.name[1:]
    last = float(series.natural(chart.value)[-1])
    value = mm(last) if series.kind in ("jitter", "wander") else f"{number(last, 3)} mm"
    change = _change(sizes["take"], unit)
    said = render("changed.size", name=name, value=value, change=change, m=m)
    findings: list[dict[str, Any]] = []

    def find(code: str, case: str, value: float, ends: tuple[float, float], **how: Any) -> None:
        words = render(f"changed.{case}", name=name, size=said, series=series, **how)
        of = {"code": code, "series": series.name, "value": value, "unit": unit}
        told: Row = {"words": words, "marker": series.marker, "case": case}
        told |= {"size": abs(value) / sizes["tolerance"]}
        findings.append(of | {"lower_95": ends[0], "upper_95": ends[1]} | told)

    interval, none = (sizes["lower"], sizes["upper"]), (np.nan, np.nan)
    if chart.beyond[-1]:
        find(series.code, "beyond", sizes["take"], interval, room=_change(sizes["room"], unit))
    elif chart.unusual[-1]:
        find(series.code, "unusual", sizes["take"], interval)
    if chart.drifting[-1]:
        n = chart.value.size - int(chart.since[-1])
        moved = _change(sizes["shift"], unit)
        find("trend", "trend", sizes["shift"], none, change=moved, n=n)
    if chart.parted[-1]:
        n, size = int(chart.apart[-1]), sizes["parted"]
        parts = {"change": _change(abs(size) if n else size, unit, not n), "n": n, "m": m}
        find(series.code, "levels" if n else "parted", size, none, **parts)
    elif not chart.capable[-1]:
        of = {k: _change(sizes[k], unit, False) for k in ("least", "tolerance", "scatter")}
        case = "scattered" if chart.scattered[-1] else "not_capable"
        find("not_capable", case, sizes["least"], none, **of)
    return findings


def _change(size: float, unit: str, sign: bool = True) -> str:
    return with_unit(size, unit, 2, sign) if unit else percent(size, 2, sign)


@plot.styled()
def chart(rows: Sequence[Mapping[str, Any]], texts: plot.Texts) -> plot.Picture:
    """Values, baseline and tolerance of each series over the dates; rows: of `words.table`."""
    from matplotlib.dates import date2num

    names, n_left = _drawn(rows)
    if n_left:
        texts = texts._replace(source=f"{texts.source} {render('chart.left', n=n_left)}")
    body = plot.new_figure(texts, HEAD_MM + STRIP_MM * max(len(names), 1))
    if not names:
        plot.write_message(body.subplots(), "no take")
        return plot.Picture(body, render("chart.caption"))
    strips = body.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(strips, names, strict=True):
        of_series = [row for row in rows if row["series"] == name]
        columns = {key: np.array([row[key] for row in of_series]) for key in of_series[0]}
        columns |= {key: columns[key].astype(float) for key in NUMBERS}
        columns["day"] = np.asarray(date2num(columns["date"].astype("datetime64[s]")))
        _strip(axes, name, columns)
    plot.date_axis(strips[-1], 6)
    strips[-1].set_xticks(strips[-1].get_xticks())  # once: they are costly, in all strips the same
    said = {row["word"] for row in rows}
    for word in (word for word in LOOKS if word in said):
        colour, marker = LOOKS[word]
        learnt = all(row["in_baseline"] == "yes" for row in rows if row["word"] == word)
        how: plot.Keywords = {"edgecolor": colour, "marker": marker, "label": word}
        strips[-1].scatter([], [], s=16, facecolor="white" if learnt else colour, **how)
    return plot.finished(body, strips, render("chart.caption"))


def _drawn(rows: Sequence[Mapping[str, Any]]) -> tuple[list[str], int]:
    """Names of the series to draw, in their order, and how many are not drawn: of many those whose
    last take is a note or worse, then those of all markers, then those of a marker that are the
    nearest to what is allowed."""
    last = {row["series"]: row for row in rows}

    def rank(row: Mapping[str, Any]) -> tuple[bool, int, bool, float]:
        name, order = row["series"], ORDER.index(row["word"])
        is_single = not (name in OF_ALL or name.startswith("length "))
        is_sound = order > ORDER.index("note")
        away = abs(row["value_mm"] - row["mean_mm"]) / (row["upper_mm"] - row["lower_mm"])
        nearest = -float(np.nan_to_num(away))
        return is_sound and is_single, order * (not is_sound), is_single, nearest

    chosen = sorted(last, key=lambda name: rank(last[name]))[:MOST_STRIPS]
    return [name for name in last if name in chosen], len(last) - len(chosen)


def _strip(axes: plot.Axes, name: str, takes: Columns) -> None:
    """One series. A place or length is drawn about the first mean of its baseline."""
    starts = [0, *np.flatnonzero(takes["restart"] == "yes").tolist()]
    about = 0.0
    for start, end in zip(starts, [*starts[1:], takes["day"].size], strict=True):
        if name not in ("jitter", "wander"):
            known = [*takes["mean_mm"][start:end], *takes["value_mm"][start:end]]
            about = float(np.round(next((v for v in known if np.isfinite(v)), 0.0), 1))
        for key in NUMBERS:
            takes[key][start:end] -= about
    shown = np.concatenate([takes["value_mm"], takes["lower_mm"][-1:], takes["upper_mm"][-1:]])
    shown = shown[np.isfinite(shown)]
    unit, per_mm = plot.length_unit([np.ptp(shown)] if shown.size else [])
    value, mean, lower, upper = (per_mm * takes[key] for key in NUMBERS)
    day, word = takes["day"], takes["word"]
    for start, end in zip(starts, [*starts[1:], day.size], strict=True):
        at = slice(start, end)
        axes.fill_between(day[at], lower[at], upper[at], color=BAND, alpha=0.15, lw=0)
        axes.plot(day[at], mean[at], color=BAND, lw=0.9)
        for edge in (lower, upper):
            wide = np.where(takes["capable"][at] == "no", edge[at], np.nan)
            axes.plot(day[at], wide, color=BAND, lw=0.8, ls="--")
        if start:
            axes.axvline(day[start], color=plot.INK, lw=0.8)
    size = float(np.clip(300 / np.sqrt(day.size), 3, 16))
    axes.scatter(day[word == ""], value[word == ""], s=2, color=plot.GREY)
    learnt = takes["in_baseline"] == "yes"
    for name_, (colour, marker) in LOOKS.items():
        for face, of in (("white", learnt), (colour, ~learnt)):
            if (chosen := (word == name_) & of).any():
                how: plot.Keywords = {"s": size, "marker": marker, "linewidths": 0.8, "zorder": 3}
                axes.scatter(day[chosen], value[chosen], facecolor=face, edgecolor=colour, **how)
    plot.panel_title(axes, plot.literal(name), f"zero at {about:.1f} mm" if about else "")
    axes.set_ylabel(unit)
    if shown.size and np.ptp(shown) > 0:
        room = 0.08 * np.ptp(shown)
        axes.set_ylim(per_mm * (shown.min() - room), per_mm * (shown.max() + room))
