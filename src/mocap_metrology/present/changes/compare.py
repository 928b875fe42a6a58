"""What changed between recordings: rows, words and text of `<group>_compare`, and of trends."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import datetime

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.changes.compare import Curve, adev_ratio, adev_trend, words_of
from mocap_metrology.noise.diagnosis.export import MOST, rounding_share
from mocap_metrology.present.tables import Row, aligned

Columns = Mapping[str, np.ndarray]
TAUS_S = (0.1, 1.0, 10.0, 100.0, 1000.0)  # at which changes are worded, besides a single frame
CAPTION = (
    "Allan deviation of a recording over that of its reference, with its interval: above 1 is "
    "noisier. Any word other than `same` means that the ratio differs from 1 by more than the "
    "margin, and significantly over all series and averaging times of the two recordings; "
    "`resolution`: the steps of the exported file hide the noise; export with finer steps."
)
NO_TREND = "none found"
COARSE = "resolution"  # the word where the file's steps decide
TREND_CAPTION = (
    "Change of the Allan deviation with the date of recording, in percent a month with its "
    "interval; `scatter` is the scatter of the recordings about the line beyond what their own "
    "noise explains; `resolution`: the steps of the exported file hide the noise."
)
COHERENCE_CAPTION = (
    "What a series has in common with a quantity that was recorded at the same time: the largest "
    "squared coherence above its threshold (otherwise the largest), its period, and the size of "
    "the response at that period. The threshold applies to quantities that wander at random. Two "
    "unrelated quantities exceed it more often if both are periodic with similar periods, or if "
    "both settle."
)


def curve_of(columns: Columns, series: str) -> Curve:
    """Overlapping Allan deviation of a series in `allan_masked.parquet`."""
    pick = (columns["series"] == series) & (columns["estimator"] == "oadev")
    return Curve(*(np.asarray(columns[k][pick], float) for k in ("tau_s", "adev_mm", "edf")))


def series_of(columns: Columns) -> list[str]:
    """Series in order."""
    return list(dict.fromkeys(columns["series"].tolist()))


def coarse_steps(columns: Columns, step_mm: float | None) -> dict[str, float]:
    """The step by series whose noise it hides, by the Allan variance at one frame.

    Where in a step a marker is then decides on its Allan deviations (`noise.diagnosis.export`).
    """
    if not (step_mm and math.isfinite(step_mm)):
        return {}
    found = {}
    for series in series_of(columns):
        pick = (columns["series"] == series) & (columns["estimator"] == "oadev")
        frame = pick & (np.asarray(columns["m"]) == 1)
        avar = float(np.asarray(columns["adev_mm"])[frame][0] ** 2) if frame.any() else math.nan
        if rounding_share(step_mm, avar, series.startswith("L")) > MOST:
            found[series] = float(step_mm)
    return found


def taus_of(new: Columns, old: Columns) -> np.ndarray:
    """A single frame (of the slower of both) and decades of a second."""
    frame = max(float(np.min(c["tau_s"])) for c in (new, old))
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
    """One row a series both have and averaging time both reach; `overall` is the series' word.
    coarse: series of which the export's resolution decides, in either recording (`coarse_steps`).

    alpha: probability, at most, that any series of two equal recordings has a word other than
    `same`: each series has its share of it (Bonferroni).
    """
    rows: list[Row] = []
    taus = taus_of(new, old)
    common = [s for s in series_of(new) if s in series_of(old)]
    for series in common:
        ratio = adev_ratio(curve_of(new, series), curve_of(old, series), taus, confidence)
        words = words_of(ratio, margin, alpha / len(common))
        if coarse and series in coarse:
            words = [word and COARSE for word in words]
        overall = COARSE if COARSE in words else overall_word(ratio.value, words)
        for k, word in enumerate(words):
            if word:
                rows.append(
                    {
                        "recording": recording,
                        "reference": reference,
                        "series": series,
                        "tau_s": ratio.tau_s[k],
                        "ratio": ratio.value[k],
                        "lower": ratio.lower[k],
                        "upper": ratio.upper[k],
                        "p": ratio.p[k],
                        "word": word,
                        "overall": overall,
                        "step_mm": (coarse or {}).get(series),
                    }
                )
    if not rows:
        raise Refusal(f"{recording} and {reference}: no series or averaging time in common")
    return rows


def overall_word(values: np.ndarray, words: Sequence[str]) -> str:
    """The word of the largest change, `same` where there is none."""
    changed = [
        (abs(math.log(value)), word)
        for value, word in zip(values, words, strict=True)
        if word in ("better", "worse")
    ]
    return max(changed)[1] if changed else "same"


def sentences(rows: Sequence[Row]) -> list[str]:
    """A sentence a comparison: what became better, worse, by how much at most, or nothing."""
    found: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        found.setdefault((row["recording"], row["reference"]), []).append(row)
    return [_sentence(*pair, own) for pair, own in found.items()]


def _sentence(recording: str, reference: str, rows: Sequence[Row]) -> str:
    parts = []
    for word in ("worse", "better"):
        changed = [row for row in rows if row["word"] == word]
        if changed:
            most = max(changed, key=lambda row: abs(math.log(row["ratio"])))
            factor = (
                f"{most['ratio']:.2f} ({most['lower']:.2f} to {most['upper']:.2f}) times in "
                f"{most['series']} at {most['tau_s']:.2g} s"
            )
            parts.append(f"{word} {_where(changed)}; largest change: {factor}")
    limited = [row for row in rows if row["word"] == COARSE]
    if limited:
        names = ", ".join(dict.fromkeys(row["series"] for row in limited))
        step = max(row["step_mm"] for row in limited)
        parts.append(
            f"the resolution of the export limits the result in {names}, whose noise its steps "
            f"of {step:.3g} mm hide: export with finer steps"
        )
    found = "; ".join(parts) or "no significant change beyond the margin"
    return f"{recording} compared with {reference}: {found}."


def _where(changed: Sequence[Row]) -> str:
    """`in x1, L over 0.1 to 1 s and in z1 at 10 s`: successive times of the same series as one."""
    spans: list[tuple[list[str], list[float]]] = []
    for tau in sorted({row["tau_s"] for row in changed}):
        names = [row["series"] for row in changed if row["tau_s"] == tau]
        if not spans or spans[-1][0] != names:
            spans.append((names, []))
        spans[-1][1].append(tau)
    return " and ".join(
        f"in {', '.join(names)} "
        + (f"at {of[0]:.2g} s" if len(of) == 1 else f"over {of[0]:.2g} to {of[-1]:.2g} s")
        for names, of in spans
    )


def compare_markdown(rows: Sequence[Row], title: str, caption: str) -> str:
    """Title, a sentence a comparison, and a line a series with its ratios side by side."""
    taus = sorted({float(row["tau_s"]) for row in rows})
    head = ["recording", "reference", "series", "word", *(f"{tau:.3g} s" for tau in taus)]
    lines: dict[tuple[str, ...], dict[float, str]] = {}
    for row in rows:
        key = tuple(row[k] for k in ("recording", "reference", "series", "overall"))
        mark = {"better": " −", "worse": " +"}.get(row["word"], "")
        text = f"{row['ratio']:.3g} ({row['lower']:.3g} to {row['upper']:.3g}){mark}"
        lines.setdefault(key, {})[float(row["tau_s"])] = text
    body = [[*key, *(cells.get(tau, "") for tau in taus)] for key, cells in lines.items()]
    said = "\n".join(f"* {sentence}" for sentence in sentences(rows))
    table = "\n".join(aligned([head, *body]))
    return f"# {title}\n\n{caption} `+` worse, `−` better.\n\n{said}\n\n{table}\n"


def days_of(dates: Sequence[str]) -> list[float]:
    """Days since the first date; dates with a time zone and without one do not mix."""
    moments = [datetime.fromisoformat(date) for date in dates]
    try:
        first = min(moments)
        return [(moment - first).total_seconds() / 86400 for moment in moments]
    except TypeError as error:
        raise Refusal(
            "dates: some have a time zone and some have none; expected one way"
        ) from error


def trend_rows(
    names: Sequence[str],
    dates: Sequence[str],
    allan: Mapping[str, Columns],
    alpha: float,
    confidence: float,
    coarse: Mapping[str, float] | None = None,
) -> list[Row]:
    """One row a series and averaging time that three or more recordings of different days have.
    alpha is that of one series, over its averaging times; coarse as in `compare_rows`, of any."""
    days, rows = days_of(dates), []
    series = [s for s in series_of(allan[names[0]]) if all(s in series_of(allan[n]) for n in names)]
    taus = max((taus_of(allan[n], allan[n]) for n in names), key=lambda t: t[0])
    for one in series:
        curves = [curve_of(allan[name], one).usable().at(taus) for name in names]
        adev, edf = (np.array([getattr(c, k) for c in curves]) for k in ("adev", "edf"))
        known = np.isfinite(adev).all(axis=0)
        for k in np.flatnonzero(known):
            trend = adev_trend(days, adev[:, k].tolist(), edf[:, k].tolist(), confidence)
            clear = trend.p < alpha / known.sum()
            said = ("worse" if trend.per_month > 1 else "better") if clear else NO_TREND
            percent = [100 * (v - 1) for v in (trend.per_month, trend.lower, trend.upper)]
            rows.append(
                {
                    "series": one,
                    "tau_s": taus[k],
                    "n_recordings": trend.n,
                    "from": min(dates),
                    "to": max(dates),
                    "percent_per_month": percent[0],
                    "lower": percent[1],
                    "upper": percent[2],
                    "p": trend.p,
                    "scatter": trend.scatter,
                    "word": COARSE if coarse and one in coarse else said,
                }
            )
    return rows
