"""What the diagnosis is asked for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DiagnosisSettings:
    """false_alarm: probability that a sound recording gets any event; side_s: what is compared
    before and after an event (S 3.5: five minutes); spike_sigma: frames farther off than this are
    outliers and no events; cutoffs_hz: low-pass filters; notch_width_hz: between its half-power
    points, one pass; max_lines: a series; still_range_mm, horizon_s: of
    `movement`.
    """

    false_alarm: float = 0.01
    side_s: float = 300.0
    spike_sigma: float = 6.0
    cutoffs_hz: tuple[float, ...] = (6.0, 10.0)
    notch_width_hz: float = 1.0
    max_lines: int = 10
    still_range_mm: float = 2.0
    horizon_s: float = 3600.0
