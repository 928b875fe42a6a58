"""What changed between recordings: captions, sentences and the text of `<group>_compare`."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mocap_metrology.noise.changes.compare import DAYS_A_MONTH
from mocap_metrology.noise.changes.rows import COARSE, Columns, dated_curves, ratio_curves
from mocap_metrology.present.plot import curves
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.tables import Row, document
from mocap_metrology.present.text import captions

SENTENCES = captions.texts("COMPARE_SENTENCES")
MOST = 6  # comparisons on a page; more are in the table
MOST_MARKERS = 2  # with a column each
NONE: Mapping[str, Sequence[Row]] = {}
OUTCOMES = (  # of a comparison, in the order of the front page
    *("worse", "worse and better", "better", "without a significant change"),
    *("not comparable", "limited by the resolution", "the same data"),
)
OTHER_CAUSES = ("rates", "low_pass", "moves")  # conditions that alone make a ratio
ENDS = (
    *(("least", "ratio", min), ("most", "ratio", max)),
    *(("least", "lower", min), ("most", "upper", max)),
)
UNKNOWN = 100.0  # an interval that reaches so far says no more than that nothing is known
CLEAR = ("worse", "better")  # words of a trend that is drawn
TIMES_S = (1.0, 100.0)  # averaging times of a trend beside a single frame; all are in the table
ROW_MM, REST_MM = 44.0, 28.0
MARGIN = "#efd98f"
CONFIDENCE = 0.683  # of the intervals of a trend


def sentences(rows: Sequence[Row], conditions: Mapping[str, Sequence[Row]] = NONE) -> list[str]:
    """A sentence a comparison: what became better, worse, by how much at most, or nothing; and what
    is to be known beside it: `conditions` (of `noise.changes.rows`) by recording."""
    return [
        f"{new} compared with {old}: {_changes(of_pair, conditions.get(new, ()))}."
        for (new, old), of_pair in _by_pair(rows).items()
    ]


def outcomes(rows: Sequence[Row], conditions: Mapping[str, Sequence[Row]] = NONE) -> dict[str, str]:
    """One word of `OUTCOMES` for each recording that is compared."""
    return {
        new: _outcome({row["word"] for row in of_pair}, conditions.get(new, ()))
        for (new, _), of_pair in _by_pair(rows).items()
    }


def _outcome(words: Collection[str], conditions: Sequence[Row]) -> str:
    codes = {row["code"] for row in conditions}
    if "same_data" in codes:
        return "the same data"
    if not codes.isdisjoint(OTHER_CAUSES):
        return "not comparable"
    changed = [word for word in ("worse", "better") if word in words]
    if changed:
        return " and ".join(changed)
    return "without a significant change" if "same" in words else "limited by the resolution"


def _by_pair(rows: Sequence[Row]) -> dict[tuple[str, str], list[Row]]:
    pairs: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        pairs.setdefault((row["recording"], row["reference"]), []).append(row)
    return pairs


def _changes(rows: Sequence[Row], conditions: Sequence[Row]) -> str:
    if any(row["code"] == "same_data" for row in conditions):
        return SENTENCES["same_data"]
    parts = []
    for word in ("worse", "better"):
        if changed := [row for row in rows if row["word"] == word]:
            most = max(changed, key=lambda row: abs(math.log(row["ratio"])))
            parts.append(
                SENTENCES["change"].format(**(_written(most) | {"where": _where(changed)}))
            )
    if not parts and (same := [row for row in rows if row["word"] == "same"]):
        parts.append(f"{SENTENCES['none']}: {_limits(same)}")
    if limited := {row["series"]: row["step_mm"] for row in rows if row["word"] == COARSE}:
        step, names = max(limited.values()), ", ".join(limited)
        parts.append(SENTENCES["resolution"].format(names=names, step=step))
    for row in conditions:
        names = ", ".join(row.get("series", ()))
        parts.append(SENTENCES[str(row["code"])].format(**row, names=names))
    return "; ".join(parts)


def _limits(rows: Sequence[Row]) -> str:
    """What may have changed all the same: least and greatest ratio of a single frame with the ends
    of their intervals, and the ratio that is farthest from 1."""
    frame = min(float(row["tau_s"]) for row in rows)
    at = [row for row in rows if row["tau_s"] == frame]
    ends = {f"{end}_{of}": of_all(row[of] for row in at) for end, of, of_all in ENDS}
    farthest = max(rows, key=lambda row: abs(math.log(row["ratio"])))
    known = farthest["lower"] > 1 / UNKNOWN and farthest["upper"] < UNKNOWN
    text = f"{SENTENCES['limits']}{SENTENCES['farthest' if known else 'undecided']}"
    more = {"frame_s": _time(frame), "n_ratios": len(rows)}
    return text.format(**(_written(farthest) | ends | more))


def _written(row: Row) -> Row:
    """A row with its averaging time as it is written."""
    return {**row, "tau_s": _time(row["tau_s"])}


def _time(tau_s: float) -> str:
    return f"{tau_s:.0f}" if tau_s >= 10 else f"{tau_s:.2g}"


def _where(changed: Sequence[Row]) -> str:
    """`in x1, L over 0.1 to 1 s and in z1 at 10 s`: successive times of the same series as one."""
    spans: list[tuple[str, list[float]]] = []
    for tau in sorted({row["tau_s"] for row in changed}):
        names = ", ".join(row["series"] for row in changed if row["tau_s"] == tau)
        if not spans or spans[-1][0] != names:
            spans.append((names, []))
        spans[-1][1].append(tau)
    return " and ".join(
        f"in {names} "
        + (f"over {_time(t[0])} to {_time(t[-1])} s" if t[1:] else f"at {_time(t[0])} s")
        for names, t in spans
    )


def compare_markdown(
    rows: Sequence[Row],
    title: str,
    caption: str,
    conditions: Mapping[str, Sequence[Row]] = NONE,
) -> str:
    """Title, a sentence a comparison, and a line a series with its ratios side by side."""
    taus = sorted({float(row["tau_s"]) for row in rows})
    lines: dict[tuple[str, ...], dict[float, str]] = {}
    for row in rows:
        key = tuple(row[k] for k in ("recording", "reference", "series", "overall"))
        mark = {"better": " −", "worse": " +"}.get(row["word"], "")
        text = f"{row['ratio']:.3g} ({row['lower']:.3g} to {row['upper']:.3g}){mark}"
        lines.setdefault(key, {})[float(row["tau_s"])] = text
    head = ["recording", "reference", "series", "word", *(f"{tau:.3g} s" for tau in taus)]
    body = [[*key, *(cells.get(tau, "") for tau in taus)] for key, cells in lines.items()]
    told = "\n".join(f"* {sentence}" for sentence in sentences(rows, conditions))
    return document(title, f"{caption} `+` worse, `−` better.", told, [head, *body])


@dataclass(frozen=True)
class Comparison:
    """A recording beside its reference: names, columns of `allan_masked.parquet`."""

    recording: str
    reference: str
    new: Columns
    old: Columns


@plot.styled()
def compare_figure(
    comparisons: Sequence[Comparison], margin: float, confidence: float, texts: plot.Texts
) -> plot.Picture:
    """Ratios over averaging time, a row a comparison (the last `MOST` of them), a column a marker
    or the distances, with the margin within which a change counts as none."""
    shown, caption = comparisons[-MOST:], f"{captions.COMPARE} {texts.caption}"
    if len(shown) < len(comparisons):
        caption += f" The last {MOST} of {len(comparisons)} comparisons; all are in the table."
    ratios = [ratio_curves(one.new, one.old, confidence) for one in shown]
    every = pd.concat(ratios)
    # About the ratios themselves, 1 and its margin; wide intervals at long tau may leave
    logs = 1.25 * np.log(curves.positive(every["value"]))
    low, high = (pick([0.0, *logs[np.isfinite(logs)]]) for pick in (min, max))
    reach = 0.3 * max(-low, high, 3 * np.log1p(margin))
    limits = float(np.exp(min(low, -reach))), float(np.exp(max(high, reach)))
    looks = curves.looks_of(every["series"])
    body, grid, panels = _grid(texts, len(shown), every["series"])
    for row, one, of_it in zip(grid, shown, ratios, strict=True):
        plot.panel_title(row[0], f"{plot.short(one.recording)} / {plot.short(one.reference)}")
        row[0].set_ylabel("Ratio of\nAllan deviations")
        for axes, names in zip(row, panels.values(), strict=True):
            plot.log_axis(axes, "y", limits)
            axes.axhline(1, color=plot.INK, lw=0.6, zorder=1)
            axes.axhspan(1 / (1 + margin), 1 + margin, color=MARGIN, lw=0, zorder=0)
            for name, curve in curves.groups_of(of_it[of_it["series"].isin(names)], "series"):
                ends = (curve[end].clip(limits[0] / 2, limits[1] * 2) for end in ("lower", "upper"))
                axes.fill_between(curve["tau_s"], *ends, color=looks[name].colour, **plot.BAND)
                how = looks[name].line(marker="", lw=1.1, label=_label(name))
                axes.plot(curve["tau_s"], curve["value"], **how)
    plot.log_axis(grid[0, 0], "x", curves.log_limits([every["tau_s"]]))
    grid[0, 0].xaxis.get_major_locator().set_params(numticks=4)  # panels are narrow
    last = grid[-1, -1]
    last.fill([], [], color=plot.GREY, label=f"{100 * confidence:.3g} % interval", **plot.BAND)
    last.fill([], [], color=MARGIN, lw=0, label=f"no change: within {100 * margin:.3g} %")
    for axes in grid[-1]:
        axes.set_xlabel(curves.ADEV_AXES[0])
    return plot.finished(body, grid.flat, caption)


def _grid(
    texts: plot.Texts, n_rows: int, series: Iterable[str]
) -> tuple[plot.SubFigure, np.ndarray, dict[str, list[str]]]:
    """The body of a figure, its axes (`n_rows` rows of panels, named inside), series by panel."""
    panels = curves.facets(series, MOST_MARKERS) or {"": []}
    body = plot.new_figure(texts, REST_MM + n_rows * ROW_MM)
    grid = body.subplots(n_rows, len(panels), sharex=True, sharey="row", squeeze=False)
    how: plot.Keywords = {"va": "top", "size": plot.SMALL_PT, "color": plot.GREY}
    how["bbox"] = {"facecolor": "white", "alpha": 0.7, "lw": 0, "pad": 1}
    for row in grid:
        for axes, name in zip(row, panels, strict=True):
            axes.text(0.02, 0.96, name, transform=axes.transAxes, **how)
    return body, grid, panels


def _label(name: str) -> str:
    return name[0] if plot.coordinate_of(name) else plot.short(name)


@plot.styled()
def trend_figure(
    names: Sequence[str],
    dates: Sequence[str],
    allan: Mapping[str, Columns],
    rows: Sequence[Row],
    texts: plot.Texts,
) -> plot.Picture:
    """Allan deviations over dates, a row an averaging time: a frame, and those nearest to 1 and
    100 s that all recordings have. names in order of `dates` (ISO); rows: of `trend_rows`."""
    from matplotlib.dates import date2num

    series = list(dict.fromkeys(row["series"] for row in rows))
    reached = sorted({float(row["tau_s"]) for row in rows})
    near = [int(np.abs(np.log(np.divide(reached, time))).argmin()) for time in TIMES_S]
    taus = np.array([reached[k] for k in sorted({0, *near})])
    points = dated_curves(names, dates, allan, series, taus, CONFIDENCE)
    points["day"] = date2num(points["date"].tolist())
    looks = curves.looks_of(series)
    trends = {(r["tau_s"], r["series"]): r["percent_per_month"] for r in rows if r["word"] in CLEAR}
    body, grid, panels = _grid(texts, len(taus), series)
    grid[0, 0].margins(x=0.06)
    plot.date_axis(grid[0, 0], 5)
    beside = 0.012 * max(np.ptp(points["day"]), 1e-9)  # series side by side
    for tau, row in zip(taus, grid, strict=True):
        at_tau = points[points["tau_s"] == tau]
        limits = curves.log_limits([at_tau[["adev", "lower", "upper"]]], 0.3)
        plot.log_axis(row[0], "y", limits)
        for axes, panel in zip(row, panels.values(), strict=True):
            for order, name in enumerate(panel):
                one = at_tau[at_tau["series"] == name]
                x = one["day"] + (order - (len(panel) - 1) / 2) * beside
                ends = [one["adev"] - one["lower"], one["upper"] - one["adev"]]
                how = looks[name].line(ls="", elinewidth=0.8, label=_label(name))
                axes.errorbar(x, one["adev"], yerr=ends, **how)
                if (tau, name) in trends:
                    slope = np.log1p(trends[tau, name] / 100) / DAYS_A_MONTH
                    level = np.mean(np.log(one["adev"]) - slope * one["day"])
                    line = looks[name].line(marker="", lw=1.0)
                    axes.plot(x, np.exp(level + slope * one["day"]), **line)
        single = f"One frame ({1000 * tau:.3g} ms)"
        plot.panel_title(row[0], single if tau == taus[0] else f"Averaged over {tau:.3g} s")
        row[0].set_ylabel("Allan deviation (µm)")
    for axes in grid[-1]:
        axes.set_xlabel("Date")
    last = grid[-1, -1]
    last.plot([], [], color=plot.GREY, ls="", marker="|", markersize=9, label="68 % interval")
    if any(tau in taus for tau, _ in trends):
        last.plot([], [], color=plot.GREY, label="trend, where clear")
    caption = f"{captions.TREND} Series are drawn side by side. {texts.caption}"
    return plot.finished(body, grid.flat, caption)
