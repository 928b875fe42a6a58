"""What is wrong with a recording: one page that proves it (events, noise before and after, lines,
filters, resolution), and events.csv, periodic.csv, filters.csv and diagnosis.json."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import reduce
from pathlib import Path

import numpy as np
import pandas as pd

from mocap_metrology.common.files import write_csv, write_json
from mocap_metrology.common.types import Row
from mocap_metrology.noise.diagnosis import evidence
from mocap_metrology.noise.diagnosis.events import LEAST_S, Event
from mocap_metrology.noise.diagnosis.evidence import View
from mocap_metrology.noise.diagnosis.export import Resolution
from mocap_metrology.noise.diagnosis.filtering import NO_FILTER, Filtered, filter_row
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.diagnosis.periodic import SpectralLine
from mocap_metrology.noise.diagnosis.records import Diagnosis, Recording
from mocap_metrology.noise.diagnosis.sides import Sides
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.curves import log_bins, log_limits
from mocap_metrology.present.plot.figure import GREY, INK, Keywords, length_unit, panel_title
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.diagnosis import line_words, outcome
from mocap_metrology.present.text.numbers import mm, moment, number, significant
from mocap_metrology.present.text.sentence import Sentence, render

DYNAMIC_MM, CLOSE_MM, SPECTRA_MM = 36.0, 44.0, 58.0
LEAST_S_SHOWN, MOST_S_SHOWN = 3.0, 60.0
BINS_PER_DECADE = 40
DECADES = 9  # of a spectrum that a filter is followed down
NAMED = 4  # lines that are labelled
LIKELY = 0.5  # chance from which noise explains a window
# None of the coordinates' own, and as far apart in lightness
FILTER_LOOKS: tuple[Keywords, ...] = (
    {"color": INK, "ls": "-"},
    {"color": "#23733d", "ls": (0, (3, 1.1))},
    {"color": "#8a6500", "ls": (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))},
    {"color": "#6b2480", "ls": (0, (1.2, 1.2))},
)
ROUNDING: Keywords = {"color": INK, "lw": 0.8, "ls": ":", "label": "rounding of the file"}
SHOWN = {"burst": "while it lasts", "level": "within 5 s", "window": "this window"}
# A ratio by what it shows: colour, sign of its middle, and words
COMPARED = {
    "changed": ("#b03a20", "s", "noise changed"),
    "alike": ("#10307a", "o", "noise alike"),
    "undecided": (GREY, "D", "undecided whether noise changed"),
}


@figure.styled()
def diagnosis_figure(
    recording: Recording, diagnosis: Diagnosis, texts: figure.Texts
) -> figure.Picture:
    """The figure of `captions.DIAGNOSIS`; of a short recording, what there is of it."""
    event = evidence.largest_event(diagnosis)
    view = evidence.view_of(diagnosis, event)
    seen = view.series if view else next(iter(recording.coordinates))
    series = evidence.series_of_surest_line(diagnosis) or seen
    after = event is not None and event.most_changed is not None
    sides = event.sides if event and after else evidence.halves(diagnosis, recording.duration_s)
    sides = tuple(side for side in sides if math.isfinite(side.ratio))
    rows = {"aa": DYNAMIC_MM} if view else {}
    close = ("b" if view else "") + ("c" if sides else "")
    rows |= {close * (3 - len(close)): CLOSE_MM} if close else {}
    rows |= {"de": SPECTRA_MM}
    body = figure.new_figure(texts, 25.0 + sum(height + 12.0 for height in rows.values()))
    panels = body.subplot_mosaic("\n".join(rows), height_ratios=list(rows.values()))
    if view is not None:
        _draw_dynamic(panels["a"], recording, diagnosis, view)
        _draw_close(panels["b"], recording, diagnosis, event, view)
    if sides:
        _draw_sides(panels["c"], sides, "after / before" if after else "2nd half / 1st")
    looks = _filter_looks(diagnosis.filtered, series)
    steps = (r for r in diagnosis.resolutions if r.series == series and r.share > evidence.SEEN)
    rounding = next(steps, None)
    _draw_spectrum(panels["d"], recording, diagnosis, series, looks, rounding)
    _draw_deviations(panels["e"], recording.frame_rate_hz, series, looks, rounding)
    figure.letters(panels.values())
    for name in set(panels) - {"a"}:  # half as wide: the title a line above the remark
        panels[name].set_title(f"{panels[name].get_title(loc='left')}\n")
    figure.legend_below(body, panels.values())
    none = "" if view else render("event.undetectable")
    return figure.Picture(body, f"{captions.DIAGNOSIS} {texts.caption} {none}")


def _draw_dynamic(
    axes: figure.Axes, recording: Recording, diagnosis: Diagnosis, view: View
) -> None:
    """Ratio of the dynamic Allan deviation to that of the noise, over time and averaging time, of
    the series that is shown close up; its most unusual window is framed."""
    import matplotlib
    from matplotlib.colors import LogNorm

    axis = figure.time_axis(recording.n_frames, recording.frame_rate_hz)
    per_s = axis.per_frame * recording.frame_rate_hz
    n, windows = len(diagnosis.events), f"{number(diagnosis.n_windows)} windows of all series"
    remark = f"{n or 'no'} event{'s' if n > 1 else ''} in {windows}"
    if not n and recording.duration_s < LEAST_S:
        remark = "too short to decide on events"
    panel_title(axes, f"Dynamic Allan deviation of {view.series}", remark)
    colours = matplotlib.colormaps["RdBu_r"].with_extremes(bad=figure.FAINT)
    norm = LogNorm(0.25, 4.0)  # of variances: half to twice the deviation
    dynamics = diagnosis.dynamics[view.series]
    for row, d in enumerate(dynamics):
        left = (d.window_s - d.hop_s) / 2 * per_s
        extent = (left, left + d.ratio.size * d.hop_s * per_s, row - 0.5, row + 0.5)
        ratio = np.maximum(d.ratio[None], 1e-3)
        shown = axes.imshow(ratio, colours, norm, aspect="auto", extent=extent)
        if view.kind == "window" and d.tau_s == view.tau_s:
            span = view.first_s * per_s, (view.last_s - view.first_s) * per_s
            axes.broken_barh([span], (row - 0.5, 1.0), fc="none", ec=INK, lw=1.2, zorder=3)
    if n:
        mark: Keywords = {"marker": "v", "color": INK, "ls": "", "clip_on": False}
        at = [event.time_s * per_s for event in diagnosis.events]
        axes.plot(at, [len(dynamics) - 0.5] * n, label="event", ms=4.5 if n < 20 else 2.0, **mark)
    axes.set(xlim=axis.limits, xlabel=axis.label, ylim=(-0.5, len(dynamics) - 0.5), ylabel="τ (s)")
    axes.set_yticks(range(0, len(dynamics), 2), [f"{d.tau_s:.2g}" for d in dynamics[::2]])
    axes.grid(visible=False)
    bar = axes.figure.colorbar(shown, ax=axes, pad=0.01, aspect=12, label="ADEV / median")
    bar.set_ticks([0.25, 1.0, 4.0], labels=["½", "1", "2"])
    bar.minorticks_off()


def _draw_close(
    axes: figure.Axes, recording: Recording, diagnosis: Diagnosis, event: Event | None, view: View
) -> None:
    """The coordinates of the marker that was moved most, or of that of the window, about their
    median before it."""
    rate, duration = recording.frame_rate_hz, view.last_s - view.first_s
    span = min(max(1.6 * duration, LEAST_S_SHOWN), MOST_S_SHOWN)
    begin = round(max(view.first_s - 0.25 * min(span, 2 * LEAST_S_SHOWN), 0.0) * rate)
    end = min(begin + round(span * rate) + 1, recording.n_frames)
    values = pd.DataFrame({k: diagnosis.quiet[k][begin:end] for k in view.names}, dtype=float)
    first = max(round(view.first_s * rate) - begin, 0)
    values = (values - values.iloc[: max(first, 8)].median()).dropna(axis=1, how="all")
    values.index = values.index / rate
    unit, per_mm = length_unit([(values.max() - values.min()).max()])
    for name in values:
        place = figure.coordinate_of(str(name))
        look = figure.LOOKS[place[0]] if place else figure.OTHER_LOOKS[0]
        how: Keywords = {"color": look.colour, "ls": look.dashes, "lw": 0.7, "label": name}
        axes.plot(values.index, values[name] * per_mm, **how)
    start = begin / rate
    ends = view.first_s - start, min(view.last_s, end / rate) - start
    axes.axvspan(*ends, label=SHOWN[view.kind], facecolor=figure.FAINT, alpha=0.45, lw=0)
    axes.set(xlim=(0.0, (end - begin) / rate), ylabel=f"{', '.join(view.names)} ({unit})")
    axes.set_xlabel(f"Time (s) from {moment(start)}" if begin else "Time (s)")
    inside = values.iloc[first : first + round(duration * rate)]
    spans = (inside.max() - inside.min()).dropna()
    title, remark = "Most unusual window", ""
    if view.kind == "level":
        title = "Where the noise changes"
    elif event:
        title = "The event" if len(diagnosis.events) == 1 else "The largest event"
        size = f"{significant(event.size_mm * per_mm)} {unit}"
        unknown = event.outcome == "unknown"
        word = "too close to an end to compare" if unknown else outcome(event)
        remark = f"{size} in {view.series}, {word}"
    elif recording.duration_s >= LEAST_S:
        likely = view.chance >= LIKELY
        remark = "explained by noise" if likely else f"chance ≤ {100 * view.chance:.2g} %"
    elif len(spans):
        remark = f"{spans.idxmax()} spans {significant(spans.max() * per_mm)} {unit}"
    panel_title(axes, title, remark)


def _draw_sides(axes: figure.Axes, sides: Sequence[Sides], compared: str) -> None:
    """Ratio of the standard deviations of fast noise of every series, with 99 % intervals over all
    series together, coloured by what they show."""
    table = pd.DataFrame([{**vars(side), "word": side.word} for side in sides])
    words = table["word"].value_counts()
    worst = next(word for word in ("changed", "undecided", "alike") if word in words)
    some = worst != "alike" and words[worst] < len(table)
    of = f"{words[worst]} of {len(table)} " if some else ""
    panel_title(axes, f"Noise: {compared}", f"{of}{worst}")
    ends = table["lower"].min(), table["upper"].max()
    reach = 1.15 * max(abs(math.log(end)) for end in ends)
    reach = min(max(reach, math.log(1.02)), math.log(20))
    figure.log_axis(axes, "y", (math.exp(-reach), math.exp(reach)))
    axes.axhline(1.0, color=INK, lw=0.8)
    for word, (colour, marker, label) in COMPARED.items():
        rows = table[table["word"] == word]
        if len(rows):
            error = rows["ratio"] - rows["lower"], rows["upper"] - rows["ratio"]
            how: Keywords = {"fmt": marker, "ms": 4, "mew": 0, "color": colour, "elinewidth": 1.4}
            axes.errorbar(rows.index, rows["ratio"], error, label=label, **how)
    axes.set(xlim=(-0.6, len(table) - 0.4), xlabel="Series", ylabel="Ratio of SD, 99 %")
    names = table["series"][:: -(-len(table) // 10)]
    axes.set_xticks(names.index, names)
    axes.grid(visible=False, axis="x")


Looks = Sequence[tuple[Filtered, Keywords]]


def _filter_looks(filtered: Sequence[Filtered], series: str) -> Looks:
    """How every filter of a series is drawn: none, two low-passes, the notch of its main line."""
    every = [one for one in filtered if one.series == series]
    notches = [one for one in every if one.filter.name.startswith("notch")]
    passes = [one for one in every if one not in notches]
    looks = [*zip(passes, FILTER_LOOKS[:3], strict=False)]
    looks += zip(notches, FILTER_LOOKS[3:], strict=False)
    names = {one.filter.name: one.filter.name for one, _ in looks} | {"none": "as recorded"}
    return [(one, {**look, "lw": 1.2, "label": names[one.filter.name]}) for one, look in looks]


def _draw_spectrum(
    axes: figure.Axes,
    recording: Recording,
    diagnosis: Diagnosis,
    series: str,
    looks: Looks,
    rounding: Resolution | None,
) -> None:
    """Welch's spectrum, its lines by number, and what is left of it behind each filter."""
    psd, rate = diagnosis.spectra.get(series), recording.frame_rate_hz
    if psd is None or not np.any(psd["psd_mm2_hz"] > 0):
        panel_title(axes, f"Spectrum of {series}")
        axes.set(xticks=[], yticks=[])
        figure.write_message(axes, "no spectrum")
        return
    bins = log_bins(psd["f_hz"], psd["psd_mm2_hz"], BINS_PER_DECADE)
    lines = [one.line for one in diagnosis.lines if one.series == series]
    remark = f"{len(lines) or 'no'} spectral line{'s' if len(lines) > 1 else ''}"
    for peak in (one for one in diagnosis.resonances if one.series == series):
        remark = f"broad resonance at {peak.f_hz:.3g} Hz"
    panel_title(axes, f"Spectrum of {series}", remark)
    axes.set(xlabel="Frequency (Hz)", ylabel="PSD (mm²/Hz)")
    levels = [bins.high, bins.median[bins.median > 0] / 300]
    levels += [np.array([rounding.rounding_h0])] if rounding else []
    lower, upper = log_limits(levels, 2.0, DECADES)
    x_limits = log_limits([bins.centre])[0], rate / 2 * 1.1
    figure.log_axes(axes, (x_limits, (lower, upper * (4.0 if lines else 1.0))))
    axes.fill_between(bins.centre, bins.median, bins.high, color=INK, alpha=0.2, lw=0)
    axes.plot(bins.centre, bins.high, color=GREY, lw=0.6)
    for one, look in looks:
        axes.plot(bins.centre, bins.median * one.filter.gain(bins.centre, rate) ** 2, **look)
    if rounding:
        axes.axhline(rounding.rounding_h0, **ROUNDING)
    for k, line in enumerate(sorted(lines[:NAMED], key=lambda line: line.f_0), start=1):
        top = bins.high[np.argmin(np.abs(np.log(bins.centre / line.f_0)))]
        how: Keywords = {"marker": f"${k}$", "ms": 5.5, "color": INK, "mew": 0.3, "ls": ""}
        label = f"{line.f_0:.4g} Hz: {mm(line.A_s, 2)}"
        axes.plot([line.f_0], [top * (1.8 if k % 2 else 4.5)], label=label, clip_on=False, **how)


def _draw_deviations(
    axes: figure.Axes, rate_hz: float, series: str, looks: Looks, rounding: Resolution | None
) -> None:
    """Allan deviations behind every filter: curves by the model, points as measured, joined where
    there is no model."""
    curves = [left.curve for one, _ in looks for left in (one.predicted, one.measured) if left]
    drawn = [one for one, _ in looks if one.predicted or one.measured]
    filtered = any(one.filter.sos is not None for one in drawn)
    remark = "as it is and filtered" if filtered else "too short to filter"
    panel_title(axes, f"Allan deviation of {series}", remark if drawn else "")
    if not any(np.any(np.asarray(adev) > 0) for _, adev in curves):
        axes.set(xticks=[], yticks=[])
        figure.write_message(axes, "no Allan deviation")
        return
    limits = log_limits([tau for tau, _ in curves]), log_limits([adev for _, adev in curves])
    figure.log_axes(axes, limits)
    axes.set(xlabel="Averaging time τ (s)", ylabel="ADEV (mm)")
    for one, look in looks:
        points: Keywords = {"marker": "o", "ms": 2.6, "mew": 0}
        if one.predicted:
            axes.plot(*one.predicted.curve, **look)
            points |= {"ls": "", "label": "_measured"}
        if one.measured:
            axes.plot(*one.measured.curve, **{**look, **points})
    if any(one.predicted for one in drawn):
        axes.plot([], [], color=GREY, label="curve: by the noise model")
        axes.plot([], [], color=GREY, ls="", marker="o", ms=3, label="points: measured")
    if rounding:
        tau = np.array(limits[0])
        axes.plot(tau, rounding.rounding_mm / np.sqrt(np.maximum(tau * rate_hz, 1.0)), **ROUNDING)


# ---- Files

# Columns with the attributes that they hold; those without one are computed. Sides of an event are
# those of the series that changed most for its interval, of 99 % over all series together.
EVENTS = {
    "event": "", "time_s": "time_s", "duration_s": "duration_s", "kind": "kind", "series": "",
    "markers": "", "size_mm": "size_mm", "size_series": "largest", "shift_mm": "shift_mm",
    "significance": "ratio", "tau_s": "tau_s", "false_alarm_p": "p",
    "side_series": "most_changed.series", "sd_before_mm": "most_changed.sd_before",
    "sd_after_mm": "most_changed.sd_after", "fast_sd_before_mm": "most_changed.fast_before",
    "fast_sd_after_mm": "most_changed.fast_after", "ratio": "most_changed.ratio",
    "ratio_lower": "most_changed.lower", "ratio_upper": "most_changed.upper", "word": "",
}  # fmt: skip
PERIODIC = {
    "series": "series", "f_hz": "line.f_0", "f_std_error_hz": "f_error", "width_f_hz": "",
    "amplitude_mm": "line.A_s", "lower_95_mm": "lower", "upper_95_mm": "upper",
    "in_periodogram": "", "periodogram_gain": "line.gain", "in_psd": "in_psd",
    "psd_snr": "snr_psd", "in_adev": "in_adev", "share_of_avar": "share", "tau_s": "tau_s",
    "harmonic": "", "fundamental_hz": "", "alias_below_hz": "", "alias_above_hz": "", "word": "",
}  # fmt: skip


def write_diagnosis(
    folder: str | Path,
    name: str,
    source: str,
    recording: Recording,
    diagnosis: Diagnosis,
    findings: Sequence[Finding],
    sentences: Sequence[Sentence],
) -> None:
    """Write all four into `folder`; tables without rows have their header. source: `twin` or
    `measured`."""
    none = {one.series: one for one in diagnosis.filtered if one.filter.sos is None}
    of_events = []
    for k, event in enumerate(diagnosis.events, start=1):
        names = {"series": event.series, "markers": event.markers(recording.labels)}
        computed = {key: ";".join(of) for key, of in names.items()}
        of_events.append(_row(EVENTS, event, {"event": k, "word": outcome(event), **computed}))
    of_lines = [_row(PERIODIC, x, _of_line(x, recording.frame_rate_hz)) for x in diagnosis.lines]
    of_filters = [filter_row(none[one.series], one) for one in diagnosis.filtered]
    tables: dict[str, tuple[list[Row], Mapping[str, object]]] = {
        "events": (of_events, EVENTS),
        "periodic": (of_lines, PERIODIC),
        "filters": (of_filters, filter_row(NO_FILTER, NO_FILTER)),
    }
    for stem, (rows, columns) in tables.items():
        named = [{"recording": name, "source": source, **row} for row in rows]
        write_csv(Path(folder) / f"{stem}.csv", named, ("recording", "source", *columns))
    document = {
        "recording": name,
        "source": source,
        "findings": [one.as_dict() for one in findings],
        "sentences": [{**asdict(one), "series": list(one.series)} for one in sentences],
    }
    write_json(Path(folder) / "diagnosis.json", document)


def _row(columns: Mapping[str, str], of: object, computed: Row) -> Row:
    """Attributes of an object, `a.b` those of attribute a, none where it is None."""

    def get(value: object, name: str) -> object:
        return None if value is None else getattr(value, name)

    return {
        name: reduce(get, attributes.split("."), of) if attributes else computed[name]
        for name, attributes in columns.items()
    }


def _of_line(one: SpectralLine, rate_hz: float) -> Row:
    harmonic, fundamental_hz = one.harmonic or (None, None)
    return {
        "width_f_hz": one.line.width_f or None,
        "in_periodogram": True,
        "harmonic": harmonic,
        "fundamental_hz": fundamental_hz,
        "alias_below_hz": rate_hz - one.line.f_0,
        "alias_above_hz": rate_hz + one.line.f_0,
        "word": line_words(one),
    }
