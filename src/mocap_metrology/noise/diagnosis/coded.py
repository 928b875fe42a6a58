"""The diagnosis in codes: everything found in a recording as `Finding`s, in one list."""

from __future__ import annotations

import math

from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording, Rows
from mocap_metrology.noise.estimates import Z_95
from mocap_metrology.noise.findings import CODES, Finding
from mocap_metrology.noise.series import AXES


def coded(recording: Recording, found: Diagnosis, noise: Rows) -> list[Finding]:
    """All findings in the order of `CODES`, by series within a code.

    noise: rows of noise.csv. Every part is a function of these that returns `Finding`s.
    """
    parts = [_low_pass(found), _gap_filled(recording), _lines(found), _events(found)]
    order = list(CODES)
    return sorted((one for part in parts for one in part), key=lambda one: order.index(one.code))


def _low_pass(found: Diagnosis) -> list[Finding]:
    return [Finding("low_pass", one.series, one.cutoff_hz) for one in found.low_pass]


def _gap_filled(recording: Recording) -> list[Finding]:
    """Of all coordinates of a marker, as they are filled together."""
    return [
        Finding("gap_filled", f"{axis}{k}", recording.n_filled[label] / recording.n_frames)
        for k, label in enumerate(recording.labels, start=1)
        if recording.n_filled.get(label)
        for axis in AXES
    ]


def _lines(found: Diagnosis) -> list[Finding]:
    """Frequency of every line of every series."""
    return [
        Finding(
            "line", one.series, one.line.f_0,
            one.line.f_0 - Z_95 * one.f_error, one.line.f_0 + Z_95 * one.f_error,
        )
        for one in found.lines
    ]  # fmt: skip


def _events(found: Diagnosis) -> list[Finding]:
    """One an event, in the series that moved most."""
    return [Finding("event", one.largest, one.time_s, math.nan, math.nan) for one in found.events]
