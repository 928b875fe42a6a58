"""Rows of events.csv, periodic.csv and filters.csv."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.filtering import CHOSEN_S, Filtered, Left
from mocap_metrology.noise.diagnosis.periodic import Found

EVENTS = (
    *("event", "time_s", "duration_s", "kind", "series", "markers", "size_mm", "size_series"),
    *("shift_mm", "significance", "tau_s", "false_alarm_p", "side_series", "sd_before_mm"),
    *("sd_after_mm", "fast_sd_before_mm", "fast_sd_after_mm", "ratio", "ratio_lower"),
    *("ratio_upper", "word"),
)
PERIODIC = (
    *("series", "f_hz", "f_std_error_hz", "width_f_hz", "amplitude_mm", "lower_95_mm"),
    *(
        "upper_95_mm",
        "in_periodogram",
        "periodogram_gain",
        "in_psd",
        "psd_snr",
        "in_adev",
        "share_of_avar",
    ),
    *("tau_s", "harmonic", "fundamental_hz", "alias_below_hz", "alias_above_hz", "word"),
)
PLACES = ("adev_1_frame", *(f"adev_{t:g}s" for t in CHOSEN_S), "least_adev", "least_adev_tau_s")
KINDS = ("predicted", "measured")
FILTERS = (
    *("series", "filter", "n_frames"),
    *(f"{kind}_{name}" for kind in KINDS for name in ("sigma_before_mm", "sigma_mm", "share_left")),
    *(
        f"{kind}_{place}{when}{'' if place.endswith('_s') else '_mm'}"
        for kind in KINDS
        for place in PLACES
        for when in ("_before", "")
    ),
)


def event_rows(events: Sequence[Event], labels: Sequence[str]) -> list[dict[str, Any]]:
    """One row an event. The sides are those of the series that changed most for its interval, which
    is of 99 % over all series together."""
    rows = []
    for number, event in enumerate(events, start=1):
        side = event.most_changed
        values = (
            *(number, event.time_s, event.duration_s, event.kind, ";".join(event.series)),
            *(";".join(markers(event, labels)), event.size_mm, event.largest, event.shift_mm),
            *(event.ratio, event.tau_s, event.p, side.series if side else ""),
            *((side.sd_before, side.sd_after) if side else (None, None)),
            *((side.fast_before, side.fast_after) if side else (None, None)),
            *((side.ratio, side.lower, side.upper) if side else (None, None, None)),
            event.word,
        )
        rows.append(dict(zip(EVENTS, values, strict=True)))
    return rows


def markers(event: Event, labels: Sequence[str]) -> list[str]:
    """Labels of the markers whose coordinates the event is seen in."""
    numbers = {int(s[1:]) for s in event.series if s[0] in "xyz"}
    return [label for k, label in enumerate(labels, start=1) if k in numbers]


def periodic_rows(lines: Sequence[Found], rate_hz: float) -> list[dict[str, Any]]:
    """One row a line and series."""
    rows = []
    for one in lines:
        number, fundamental = one.harmonic or (None, None)
        values = (
            *(one.series, one.line.f_0, one.f_error, one.line.width_f or None),
            *(
                one.line.A_s,
                one.lower,
                one.upper,
                True,
                one.line.gain,
                one.in_psd,
                one.snr_psd,
                one.in_adev,
                one.share,
                one.tau_s,
            ),
            *(number, fundamental, rate_hz - one.line.f_0, rate_hz + one.line.f_0, one.word),
        )
        rows.append(dict(zip(PERIODIC, values, strict=True)))
    return rows


def filter_rows(filtered: Sequence[Filtered]) -> list[dict[str, Any]]:
    """One row a series and filter, before being the filter `none`."""
    before = {one.series: one for one in filtered if one.filter.sos is None}
    rows = []
    for one in filtered:
        row: dict[str, Any] = {
            "series": one.series, "filter": one.filter.name, "n_frames": one.n_frames,
        }  # fmt: skip
        for kind in KINDS:
            row |= _columns(kind, getattr(before[one.series], kind), getattr(one, kind))
        rows.append({name: row[name] for name in FILTERS})
    return rows


def _columns(kind: str, before: Left | None, after: Left | None) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for when, left in (("_before", before), ("", after)):
        places = (*left.adev, left.least, left.least_tau_s) if left else [math.nan] * len(PLACES)
        for place, value in zip(PLACES, places, strict=True):
            unit = "" if place.endswith("_s") else "_mm"
            values[f"{kind}_{place}{when}{unit}"] = value
        values[f"{kind}_sigma{when}_mm"] = left.sigma if left else math.nan
    share = math.nan
    if before and after and before.sigma > 0:
        share = (after.sigma / before.sigma) ** 2
    return values | {f"{kind}_share_left": share}
