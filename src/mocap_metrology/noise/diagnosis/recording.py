"""All disturbances of one recording."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.common.hampel import own_step
from mocap_metrology.common.large import LazyArrays, kept_if_small
from mocap_metrology.common.parallel import MapFunction, in_turn
from mocap_metrology.noise.diagnosis.dynamic import Dynamic, dynamic_allan
from mocap_metrology.noise.diagnosis.events import Event, find_events, inside_events
from mocap_metrology.noise.diagnosis.export import bands, hiding_step, low_passes, wander
from mocap_metrology.noise.diagnosis.levels import Trend, trends
from mocap_metrology.noise.diagnosis.one_series import Examiner, decided, without_frames
from mocap_metrology.noise.diagnosis.outliers import (
    drawn_in,
    heavy_tails,
    isolated_frames,
    off_frames,
    without,
)
from mocap_metrology.noise.diagnosis.records import (
    Diagnosis,
    DiagnosisSettings,
    Recording,
    explained,
)
from mocap_metrology.noise.diagnosis.recurring import pulses, recurrence, recurring_bout
from mocap_metrology.noise.diagnosis.sides import Blocks, blocks
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.diagnosis.software import (
    processed,
    repeats,
    running_median,
    solved_pairs,
)
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.gaussian.two_markers import drift
from mocap_metrology.noise.motion.movement import Movement, movement
from mocap_metrology.noise.series import AXES, all_series, every_series, pair_name

MANY_GAPS = 1e-2  # share of the frames from which a reader is warned
MOST_BLANKED = 0.5  # of the frames that lie in events; more, and nothing would be left to look at
Columns = Mapping[str, np.ndarray]


def diagnose(
    recording: Recording,
    noise: Sequence[NoiseRow],
    psd: Columns | None = None,
    settings: DiagnosisSettings | None = None,
    welch_settings: Mapping[str, float] | None = None,
    over: MapFunction = in_turn,
) -> Diagnosis:
    """noise: rows of noise.csv, of which `likelihood` counts; psd: columns of psd.parquet, which is
    made anew without the events where there are any. Units mm, s, Hz.

    Lines, resolution and filters are those of the recording without its events; where there are
    any, the noise model is fitted anew to what the filters are tried on. over: how series are
    worked on.
    """
    settings = settings or DiagnosisSettings()
    rate, step = recording.frame_rate_hz, recording.step_mm
    spikes, coordinates, quiet = _without_spikes(recording, settings, step, over)
    series = all_series(coordinates, recording.pairs)
    drifts = dict(over(lambda one: (one[0], drift(one[1], rate)), series))
    events, dynamics, levels = search_events(
        quiet, recording.pairs, rate, step, settings.false_alarm, settings.side_s, over
    )
    away = inside_events(events, recording.n_frames, 1 / rate)
    if away.mean() > MOST_BLANKED:
        away[:] = False

    welch = welch_settings or {}
    examiner = Examiner(recording, settings, len(quiet), away, noise, psd, welch)
    every = list(over(examiner.examined, quiet.items()))
    moves = _movements(recording, settings, over)
    at_rest = [
        pair
        for pair in recording.pairs
        if not any(moves[f"{axis}{k}"].moves for k in pair for axis in AXES)
    ]
    blanked = LazyArrays(quiet, lambda name: without_frames(quiet[name], away))
    spectra = {one.name: one.spectrum for one in every if one.spectrum is not None}
    lines = [line for one in every for line in one.lines]
    wanders = decided({one.name: one.wander for one in every if one.wander}, noise)
    wanders |= _of_distances(wanders, recording.pairs)
    recurring, bouts = _recurring(events, quiet, levels, rate, settings.false_alarm, over)
    still = _still(recording, blanked, levels, settings)
    of_still = over(lambda name: bands(still[name], rate), still)
    still_spectra = dict(zip(still, of_still, strict=True))
    processing = processed(still, still_spectra, rate, step, over)
    repeated = []
    for k, label in enumerate(recording.labels, start=1):
        axes = {f"{a}{k}": recording.coordinates[f"{a}{k}"] for a in AXES}
        processing += running_median(axes, step)
        repeated.append(repeats(label, list(axes.values()), step))
    low = low_passes(still_spectra, rate, step)
    trends_of = _trends(levels, events)
    n_windows = sum(d.n_tests for of_series in dynamics.values() for d in of_series)
    diagnosis = Diagnosis(
        events, lines, [left for one in every for left in one.filtered],
        [one.step for one in every], spikes, _missing(recording), drifts, moves, dynamics, levels,
        n_windows, quiet, spectra, low, trends_of,
        heavy_tails(blanked, step, over), [one for one in repeated if one], wanders,
        solved_pairs(quiet, at_rest), processing, recurring,
        [one.resonance for one in every if one.resonance], bouts,
    )  # fmt: skip
    return explained(diagnosis, recording.duration_s, settings.still_range_mm)


def _of_distances(
    wanders: Mapping[str, Wander], pairs: Sequence[tuple[int, int]]
) -> dict[str, Wander]:
    """Undecided, where a distance has a kind that none of its coordinates has, and one of these has
    any or is undecided: it shows a part of the same movement, or a sum of several."""
    distances = {}
    for pair in pairs:
        name = pair_name(pair, pairs)
        of_ends = [one for k in pair for axis in AXES if (one := wanders.get(f"{axis}{k}"))]
        known = {kind for one in of_ends for kind in one.kinds}
        one = wanders.get(name)
        if one and not known.issuperset(one.kinds) and (known or any(x.undecided for x in of_ends)):
            distances[name] = replace(one, kinds=(), possible=one.kinds, jumps=())
    return distances


def search_events(
    quiet: Mapping[str, np.ndarray],
    pairs: Sequence[tuple[int, int]],
    rate_hz: float,
    step: float,
    false_alarm: float,
    side_s: float,
    over: MapFunction = in_turn,
) -> tuple[list[Event], dict[str, list[Dynamic]], dict[str, Blocks]]:
    """Events of coordinates and distances, spikes bridged, and what they were found in."""
    coordinates = LazyArrays((k for k in quiet if not k.startswith("L")), quiet.__getitem__)
    drawn = drawn_in(coordinates, step, over)

    def level(one: tuple[str, np.ndarray]) -> tuple[str, Blocks]:
        blocks_of = blocks(one[1], rate_hz)
        hidden = hiding_step(one[1], step, one[0].startswith("L")) > 0  # levels are of the steps
        return one[0], replace(
            blocks_of, variance=blocks_of.variance + np.nan
        ) if hidden else blocks_of

    def dynamic(one: tuple[str, np.ndarray]) -> tuple[str, list[Dynamic]]:
        least = max(step, own_step(one[1]))
        return one[0], dynamic_allan(one[1], rate_hz, least, breaks_s=breaks_s)

    breaks_s: list[float] = []
    levels = dict(over(level, quiet.items()))
    while True:  # again beside changes of level, as windows of the louder side are no bursts
        dynamics = dict(over(dynamic, all_series(drawn, pairs)))
        events = find_events(dynamics, levels, quiet, rate_hz, false_alarm, side_s)
        found_s = sorted(e.level_s for e in events if not math.isnan(e.level_s))
        if breaks_s or not found_s:
            return events, dynamics, levels
        breaks_s = found_s


def _recurring(
    events: Sequence[Event],
    quiet: Mapping[str, np.ndarray],
    levels: Mapping[str, Blocks],
    rate_hz: float,
    false_alarm: float,
    over: MapFunction,
) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Period of events, in the series that moved most, or of bursts that are none as they are so
    many; begin and end of those that recur for a while."""
    period = recurrence(events)
    if math.isfinite(period):
        return {max(events, key=lambda e: np.nan_to_num(e.size_mm)).largest: period}, {}
    chance = false_alarm / max(len(quiet), 1) / 2

    def of(one: tuple[str, np.ndarray]) -> tuple[str, float, float, float]:
        name, values = one[0], one[1].astype(np.float64)
        whole = pulses(values, rate_hz, chance)
        part = recurring_bout(values, rate_hz, chance, levels[name])
        return (name, whole, 0.0, math.inf) if math.isfinite(whole) else (name, *part)

    recurring = [one for one in over(of, quiet.items()) if math.isfinite(one[1])]
    periods = {name: period for name, period, _, _ in recurring}
    return periods, {name: (begin, end) for name, _, begin, end in recurring if math.isfinite(end)}


def _trends(levels: Mapping[str, Blocks], events: Sequence[Event]) -> list[Trend]:
    """Beside what became another at once."""
    one = next(iter(levels.values()))
    out_of = inside_events(events, one.mean.size, one.length_s)
    steps = [
        e.time_s if math.isnan(e.level_s) else e.level_s
        for e in events
        if e.kind == "level" or e.level_changed
    ]
    return trends(levels, out_of, steps)


def _without_spikes(
    recording: Recording, settings: DiagnosisSettings, step: float, over: MapFunction
) -> tuple[dict[str, np.ndarray], Mapping[str, np.ndarray], Mapping[str, np.ndarray]]:
    """Isolated frames of every coordinate; the coordinates without them; and these with the
    distances, float32."""
    raw = recording.coordinates
    frames = over(lambda values: off_frames(values, settings.spike_sigma, step), raw.values())
    off = dict(zip(raw, frames, strict=True))
    spikes = isolated_frames(off, {k: int(k[1:]) for k in raw})
    coordinates = LazyArrays(raw, lambda name: without(raw[name], spikes[name]))
    small = kept_if_small(coordinates, recording.n_frames)
    every = every_series(small, recording.pairs)

    def stored(name: str) -> np.ndarray:
        return small[name] if name in small else every[name].astype(np.float32)

    return spikes, small, kept_if_small(LazyArrays(every, stored), recording.n_frames)


def _missing(recording: Recording) -> dict[str, float]:
    """Share of frames without a sample by marker; those that were gap-filled are not counted."""
    filled = {k: n / recording.n_frames for k, n in recording.n_filled.items()}
    return {
        label: max(np.isnan(recording.coordinates[f"x{k}"]).mean() - filled.get(label, 0.0), 0.0)
        for k, label in enumerate(recording.labels, start=1)
    }


def _movements(
    recording: Recording, settings: DiagnosisSettings, over: MapFunction
) -> dict[str, Movement]:
    """Movement of every coordinate as recorded, and of every distance."""
    rate, step = recording.frame_rate_hz, recording.step_mm
    limits = rate, settings.still_range_mm, settings.horizon_s, step

    def of(one: tuple[str, np.ndarray]) -> tuple[str, Movement]:
        name, values = one
        return name, recording.movements.get(name) or movement(values, *limits)

    return dict(over(of, all_series(recording.coordinates, recording.pairs)))


def _still(
    recording: Recording,
    series: Mapping[str, np.ndarray],
    levels: Mapping[str, Blocks],
    settings: DiagnosisSettings,
) -> Mapping[str, np.ndarray]:
    """The series of markers that do not move all the time, as movement may have any spectrum."""
    busy = {k for k, v in levels.items() if wander(v.mean) > settings.still_range_mm}
    numbers = {k[1:] for k in busy if k in recording.coordinates}
    still = [
        k for k in series if k not in busy and not (k in recording.coordinates and k[1:] in numbers)
    ]
    return LazyArrays(still, series.__getitem__)
