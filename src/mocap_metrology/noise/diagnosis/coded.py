"""The diagnosis in codes: everything found in a recording as `Finding`s, in one list."""

from __future__ import annotations

import math

from mocap_metrology.noise.diagnosis.findings import CODES, Finding
from mocap_metrology.noise.diagnosis.model_findings import model_findings
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording, Rows
from mocap_metrology.noise.diagnosis.resolution import DOMINATES
from mocap_metrology.noise.fit.estimates import Z_95
from mocap_metrology.noise.gaussian.series import AXES


def coded(recording: Recording, found: Diagnosis, noise: Rows) -> list[Finding]:
    """All findings in the order of `CODES`, by series within a code.

    noise: rows of noise.csv. Every part is a function of these that returns `Finding`s.
    """
    parts = [
        model_findings(noise),
        _moves(found),
        _low_pass(found),
        _gap_filled(recording),
        _coarse(found),
        _heavy_tails(found),
        _level_changes(found),
        _lines(found),
        _events(found),
    ]
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


def _heavy_tails(found: Diagnosis) -> list[Finding]:
    return [
        Finding("heavy_tails", one.series, one.excess, one.lower, one.upper) for one in found.tails
    ]


def _level_changes(found: Diagnosis) -> list[Finding]:
    """Slow ones from the start to the end, and those at once from before to after, whose interval
    holds for all series together."""
    slow = [
        Finding("level_changes", one.series, one.change, one.lower, one.upper)
        for one in found.trends
    ]
    at_once = [
        Finding("level_changes", side.series, side.ratio - 1, side.lower - 1, side.upper - 1)
        for event in found.events
        if event.kind == "level"
        for side in event.sides
        if side.changed
    ]
    return [*slow, *at_once]


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


def _moves(found: Diagnosis) -> list[Finding]:
    """Every coordinate and distance that does what its noise cannot."""
    return [
        Finding("moves", name, one.size_mm, one.lower_95, one.upper_95)
        for name, one in found.movements.items()
        if one.moves
    ]


def _coarse(found: Diagnosis) -> list[Finding]:
    """Every series whose noise the file's steps decide."""
    return [
        Finding("resolution_limited", one.series, one.step_mm)
        for one in found.resolutions
        if one.word == DOMINATES
    ]
