"""Files of a diagnosis: events.csv, periodic.csv, filters.csv, and diagnosis.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import reduce
from pathlib import Path

from mocap_metrology.common.files import write_csv, write_json, write_text
from mocap_metrology.common.types import Row
from mocap_metrology.noise.diagnosis.filtering import NO_FILTER, filter_row
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.diagnosis.periodic import SpectralLine
from mocap_metrology.noise.diagnosis.records import Diagnosis, Recording
from mocap_metrology.present.text.diagnosis import line_words, outcome
from mocap_metrology.present.text.sentence import Sentence

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
    found: Diagnosis,
    findings: Sequence[Finding],
    sentences: Sequence[Sentence],
) -> None:
    """Write all four into `folder`; tables without rows have their header. source: `twin` or
    `measured`."""
    none = {one.series: one for one in found.filtered if one.filter.sos is None}
    of_events = [
        _row(
            EVENTS,
            event,
            {"event": k, "series": ";".join(event.series)}
            | {"markers": ";".join(event.markers(recording.labels)), "word": outcome(event)},
        )
        for k, event in enumerate(found.events, start=1)
    ]
    of_lines = [_row(PERIODIC, x, _of_line(x, recording.frame_rate_hz)) for x in found.lines]
    of_filters = [filter_row(none[one.series], one) for one in found.filtered]
    tables: dict[str, tuple[list[Row], Mapping[str, object]]] = {
        "events": (of_events, EVENTS),
        "periodic": (of_lines, PERIODIC),
        "filters": (of_filters, filter_row(NO_FILTER, NO_FILTER)),
    }
    for stem, (rows, columns) in tables.items():
        path = Path(folder) / f"{stem}.csv"
        if rows:
            write_csv(path, [{"recording": name, "source": source, **row} for row in rows])
        else:
            write_text(path, ",".join(("recording", "source", *columns)) + "\n")
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
