"""What a diagnosis is given, and what it finds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from mocap_metrology import settings
from mocap_metrology.noise.diagnosis.dynamic import Dynamic
from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.export import LowPass, Resolution
from mocap_metrology.noise.diagnosis.filtering import Filtered
from mocap_metrology.noise.diagnosis.levels import Trend
from mocap_metrology.noise.diagnosis.outliers import Tails
from mocap_metrology.noise.diagnosis.periodic import SpectralLine
from mocap_metrology.noise.diagnosis.resonance import Resonance
from mocap_metrology.noise.diagnosis.sides import WHITE, Blocks
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.diagnosis.software import Processed, Repeats
from mocap_metrology.noise.gaussian.two_markers import Drift
from mocap_metrology.noise.motion.movement import STILL, Movement

MANY_REPEATS = 0.1  # share of the frames, from which they may look like those of a low-pass
MAY_SWITCH = frozenset({"steps", "levels"})  # of cameras, not excluded
WITHIN = 1.6  # times the distance of positions, that a switch between them is at most, with noise
MULTIPLES = 6  # of the frequency at which bursts recur, that are no cycle
SAME = 0.01  # part that frequencies of one line may differ by, in several series


class DiagnosisSettings(settings.Diagnosis):
    """With still_range_mm and horizon_s, which are of `movement`."""

    still_range_mm: float = settings.Still().range_mm
    horizon_s: float = settings.Verdict().horizon_s


@dataclass(frozen=True)
class Recording:
    """What is known of a recording before it is diagnosed. coordinates: x1, y1, ... (n,) mm, NaN in
    gaps; labels of its markers; pairs of their numbers from 1; step of the file and its kind;
    frames of a marker that were gap-filled, and are gaps here; movements: of coordinates, where
    they are known already; exchanged: pairs of labels that were exchanged for a while, and are put
    right here: `labels`, `n_frames`, `first` and `last` frame."""

    coordinates: Mapping[str, np.ndarray]
    labels: Sequence[str]
    pairs: Sequence[tuple[int, int]]
    frame_rate_hz: float
    resolution_mm: float
    resolution_kind: str
    n_filled: Mapping[str, int] = field(default_factory=dict)
    movements: Mapping[str, Movement] = field(default_factory=dict)
    exchanged: Sequence[Mapping[str, Any]] = ()

    @cached_property
    def n_frames(self) -> int:
        return len(next(iter(self.coordinates.values())))

    @property
    def duration_s(self) -> float:
        return self.n_frames / self.frame_rate_hz

    @property
    def step_mm(self) -> float:
        """Resolution of the file in mm; 0 where it is not known."""
        return self.resolution_mm if np.isfinite(self.resolution_mm) else 0.0


@dataclass(frozen=True)
class Diagnosis:
    """What was found in one recording, by series, coordinate or marker. spikes: isolated frames
    that were off, by coordinate; missing: share of the frames in which a marker is missing; drifts,
    movements, dynamics, levels (blocks of a second): by series; n_windows: that events were looked
    for in; quiet: coordinates and distances, spikes bridged; spectra: Welch's, without the events;
    low_pass: filters that ran before the export; trends: slow changes of the level of the noise;
    repeats: markers that repeat their position; wanders: what slow wander is, a series; solved:
    distances within rigid bodies that the software solved; processed: what else software did to the
    frames; recurring: period in s of bursts, a series; resonances: broad ones; bouts: begin and end
    in s of bursts that recur in a part of the recording."""

    events: list[Event]
    lines: list[SpectralLine]
    filtered: list[Filtered]
    resolutions: list[Resolution]
    spikes: dict[str, np.ndarray]
    missing: dict[str, float]
    drifts: dict[str, Drift]
    movements: dict[str, Movement]
    dynamics: dict[str, list[Dynamic]]
    levels: dict[str, Blocks]
    n_windows: int
    quiet: Mapping[str, np.ndarray]
    spectra: dict[str, dict[str, np.ndarray]]
    low_pass: list[LowPass]
    trends: list[Trend]
    tails: list[Tails]
    repeats: list[Repeats]
    wanders: dict[str, Wander]
    solved: dict[str, float]
    processed: list[Processed]
    recurring: dict[str, float]
    resonances: list[Resonance]
    bouts: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def software(self) -> set[str]:
        """Codes of what software did to the frames."""
        return {one.code for one in self.processed}

    @property
    def smooth(self) -> bool:
        """Whether frames of a filter or a median may look filled."""
        return bool(self.low_pass) or "running_median" in self.software


def _in_band(line: SpectralLine, one: Resonance) -> bool:
    """Whether a line is within the width of a resonance."""
    return abs(line.line.f_0 / one.f_hz - 1) <= 2 * one.damping


def explained(diagnosis: Diagnosis, duration_s: float, still_range_mm: float = 2.0) -> Diagnosis:
    """The diagnosis without what something else in it explains: events, movements and changes of
    level that are switches between positions, a line that comes and goes, or, where nothing moved,
    heavy tails; cycles that are multiples of recurring bursts; weak lines in a resonance; isolated
    and repeated frames, broad peaks, bands above the cutoff of a filter (its lobes) and bursts at
    its ends by software."""
    cutoffs = {one.series: one.cutoff_hz for one in diagnosis.low_pass if one.cutoff_hz > 0}
    end_s = 1 / min(cutoffs.values(), default=math.inf)
    switching = {name: one for name, one in diagnosis.wanders.items() if "levels" in one.of}
    swings = [x.line.f_0 for x in diagnosis.lines if x.amplitude or (x.line.wide and x.in_adev)]
    changing = {
        one.series
        for one in diagnosis.lines
        if any(abs(one.line.f_0 / f - 1) < SAME for f in swings)
    }
    tails = {one.series for one in diagnosis.tails}

    def stands(name: str, one: Movement) -> Movement:
        wander = diagnosis.wanders.get(name)
        may_switch = wander and wander.undecided and MAY_SWITCH.intersection(wander.possible)
        switches = wander and name in switching and wander.jump_near(one.time_s, one.time_s)
        return STILL if switches or (may_switch and one.size_mm < still_range_mm) else one

    def is_explained(event: Event) -> bool:
        if event.kind == "level":
            return {side.series for side in event.sides if side.changed} <= changing
        if event.stop_s < end_s or event.time_s > duration_s - end_s:
            return True
        if (not event.moved or event.white > WHITE) and set(event.series) <= tails:
            return True
        switch = switching.get(event.largest)  # perhaps to a position that it hardly stays at
        near = switch is not None and event.size_mm < WITHIN * abs(switch.size_mm)
        return near or any(x.jump_near(event.time_s, event.stop_s) for x in switching.values())

    def left_of(event: Event) -> Event | None:
        if not is_explained(event):
            return event
        level = event if math.isnan(event.level_s) else event.of_level()  # which may remain
        return None if is_explained(level) else level

    def other_than_bursts(name: str, one: Wander) -> bool:
        periods = diagnosis.recurring.get(name, math.nan) / np.arange(1, MULTIPLES + 1)
        near = np.abs(one.at_s[-1] / periods - 1) < 0.02 if "cycle" in one.kinds else [False]
        return not np.any(near)

    def other_than_lines(one: Resonance) -> bool:
        inside = [x for x in diagnosis.lines if _in_band(x, one) and x.line.A_s > one.rms_mm]
        return all(x.wanders and x.series == one.series for x in inside)

    def stands_alone(one: SpectralLine) -> bool:
        below = one.line.f_0 <= cutoffs.get(one.series, math.inf)
        is_lobe = not (below or (one.in_adev and not one.line.wide))
        near = [x for x in resonances if x.series == one.series or one.line.wide]
        return not (is_lobe or any(_in_band(one, x) for x in near))

    if diagnosis.repeats or "repeated" in diagnosis.software:  # which no interpolation makes
        diagnosis = replace(
            diagnosis, processed=[x for x in diagnosis.processed if x.code != "resampled"]
        )
    held = any(one.share > MANY_REPEATS for one in diagnosis.repeats)
    if held:  # which have few fast changes
        diagnosis = replace(diagnosis, low_pass=[])
    codes = diagnosis.software
    if codes - {"smoothed"} or diagnosis.low_pass:  # which smooth
        diagnosis = replace(
            diagnosis, processed=[x for x in diagnosis.processed if x.code != "smoothed"]
        )
    software = bool(codes or diagnosis.low_pass or held)
    none = np.empty(0, int)
    resonances = [one for one in diagnosis.resonances if not software and other_than_lines(one)]
    return replace(
        diagnosis,
        events=list(filter(None, map(left_of, diagnosis.events))),
        lines=list(filter(stands_alone, diagnosis.lines)),
        recurring={k: period for k, period in diagnosis.recurring.items() if k not in switching},
        trends=[one for one in diagnosis.trends if one.series not in changing],
        movements={name: stands(name, one) for name, one in diagnosis.movements.items()},
        wanders={k: one for k, one in diagnosis.wanders.items() if other_than_bursts(k, one)},
        spikes={k: none if "running_median" in codes else v for k, v in diagnosis.spikes.items()},
        repeats=[] if codes & {"running_median", "repeated"} else diagnosis.repeats,
        resonances=resonances,
    )
