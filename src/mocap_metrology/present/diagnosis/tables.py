"""Files of a diagnosis: events.csv, periodic.csv, filters.csv, and diagnosis.json."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from mocap_metrology.common.files import write_csv, write_json, write_text
from mocap_metrology.common.types import Row
from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.filtering import CHOSEN_S, Filtered, Left
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.diagnosis.periodic import Found
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.present.text.diagnosis import line_words, outcome
from mocap_metrology.present.text.sentence import Sentence

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


def write_diagnosis(
    folder: str | Path,
    name: str,
    source: str,
    recording: Recording,
    found: Diagnosis,
    findings: Sequence[Finding],
    sentences: Sequence[Sentence],
) -> None:
    """Write all four into `folder`; tables without rows have their header. source: `twin` or
    `measured`."""
    folder = Path(folder)
    tables = {
        "events": (event_rows(found.events, recording.labels), EVENTS),
        "periodic": (periodic_rows(found.lines, recording.frame_rate_hz), PERIODIC),
        "filters": (filter_rows(found.filtered), FILTERS),
    }
    for stem, (rows, head) in tables.items():
        _write(folder / f"{stem}.csv", name, source, rows, head)
    document = {
        "recording": name,
        "source": source,
        "findings": [one.as_dict() for one in findings],
        "sentences": [{**asdict(one), "series": list(one.series)} for one in sentences],
    }
    write_json(folder / "diagnosis.json", document)


def _write(path: Path, name: str, source: str, rows: Sequence[Row], head: Sequence[str]) -> None:
    if rows:
        write_csv(path, [{"recording": name, "source": source, **row} for row in rows])
    else:
        write_text(path, ",".join(("recording", "source", *head)) + "\n")


def event_rows(events: Sequence[Event], labels: Sequence[str]) -> list[Row]:
    """One row an event. The sides are those of the series that changed most for its interval, which
    is of 99 % over all series together."""
    rows = []
    for number, event in enumerate(events, start=1):
        side = event.most_changed
        values = (
            *(number, event.time_s, event.duration_s, event.kind, ";".join(event.series)),
            *(";".join(event.markers(labels)), event.size_mm, event.largest, event.shift_mm),
            *(event.ratio, event.tau_s, event.p, side.series if side else ""),
            *((side.sd_before, side.sd_after) if side else (None, None)),
            *((side.fast_before, side.fast_after) if side else (None, None)),
            *((side.ratio, side.lower, side.upper) if side else (None, None, None)),
            outcome(event),
        )
        rows.append(dict(zip(EVENTS, values, strict=True)))
    return rows


def periodic_rows(lines: Sequence[Found], rate_hz: float) -> list[Row]:
    """One row a line and series."""
    rows: list[Row] = []
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
            *(number, fundamental, rate_hz - one.line.f_0, rate_hz + one.line.f_0, line_words(one)),
        )
        rows.append(dict(zip(PERIODIC, values, strict=True)))
    return rows


def filter_rows(filtered: Sequence[Filtered]) -> list[Row]:
    """One row a series and filter, before being the filter `none`."""
    before = {one.series: one for one in filtered if one.filter.sos is None}
    rows = []
    for one in filtered:
        row: Row = {
            "series": one.series, "filter": one.filter.name, "n_frames": one.n_frames,
        }  # fmt: skip
        for kind in KINDS:
            row |= _columns(kind, getattr(before[one.series], kind), getattr(one, kind))
        rows.append({name: row[name] for name in FILTERS})
    return rows


def _columns(kind: str, before: Left | None, after: Left | None) -> Row:
    values: Row = {}
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
