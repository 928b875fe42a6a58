"""All disturbances of one recording."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.large import Made, kept_if_small
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.diagnosis.dynamic import Dynamic, dynamic_allan
from mocap_metrology.noise.diagnosis.events import (
    Event,
    bout,
    find_events,
    inside_events,
    pulses,
    recurrence,
)
from mocap_metrology.noise.diagnosis.export import (
    Resolution,
    low_passes,
    resolution,
    wander,
)
from mocap_metrology.noise.diagnosis.filtering import Filtered, filters, middle, tried
from mocap_metrology.noise.diagnosis.levels import Blocks, Trend, blocks, trends
from mocap_metrology.noise.diagnosis.outliers import (
    drawn_in,
    heavy_tails,
    isolated,
    off_frames,
    without,
)
from mocap_metrology.noise.diagnosis.periodic import Found, described, series_lines
from mocap_metrology.noise.diagnosis.records import (
    Diagnosis,
    DiagnosisSettings,
    Recording,
    explained,
)
from mocap_metrology.noise.diagnosis.repeats import Repeats, repeats, solved_pairs
from mocap_metrology.noise.diagnosis.resonance import MOST_GAPS, Resonance, resonance
from mocap_metrology.noise.diagnosis.signatures import Wander, signature
from mocap_metrology.noise.diagnosis.software import processed, running_median
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow, model_of
from mocap_metrology.noise.fit.spectral.gaps import filled
from mocap_metrology.noise.fit.spectral.likelihood import (
    LONGEST_GAP,
    LikelihoodSettings,
    likelihood,
)
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.gaussian.two_markers import Drift, drift
from mocap_metrology.noise.model.components import Form, NoiseModel, Sinusoid
from mocap_metrology.noise.motion.movement import Movement, movement
from mocap_metrology.noise.series import AXES, all_series, every_series

NOTCHES = 3  # of a series: its strongest lines
MANY_GAPS = 1e-2  # share of the frames from which a reader is warned
SLOW_HZ = 0.25  # lines below may be of what a change at once leaves
MOST_BLANKED = 0.5  # of the frames that lie in events; more, and nothing would be left to look at
Columns = Mapping[str, np.ndarray]


def diagnose(
    recording: Recording,
    noise: Sequence[NoiseRow],
    psd: Columns | None = None,
    settings: DiagnosisSettings | None = None,
    welch_settings: Mapping[str, float] | None = None,
    over: Over = in_turn,
) -> Diagnosis:
    """noise: rows of noise.csv, of which `likelihood` counts; psd: columns of psd.parquet, which is
    made anew without the events where there are any. Units mm, s, Hz.

    Lines, resolution and filters are those of the recording without its events; where there are
    any, the noise model is fitted anew to what the filters are tried on. over: how series are
    worked on.
    """
    settings = settings or DiagnosisSettings()
    rate, step = recording.frame_rate_hz, recording.step_mm
    spikes, coordinates, quiet = _quiet(recording, settings, step, over)

    def drifted(one: tuple[str, np.ndarray]) -> tuple[str, Drift]:
        return one[0], drift(one[1], rate)

    drifts = dict(over(drifted, all_series(coordinates, recording.pairs)))
    events, dynamics, levels = searched(
        quiet, recording.pairs, rate, step, settings.false_alarm, settings.side_s, over
    )
    away = inside_events(events, recording.n_frames, 1 / rate)
    if away.mean() > MOST_BLANKED:
        away[:] = False

    def examined(one: tuple[str, np.ndarray]) -> _Examined:
        name, series = one
        kind_of = signature(blank := _blanked(series, away), rate)
        model, spectrum = _model(noise, name), _rows(psd, name)
        jumps = kind_of.jumps if kind_of else ()
        if kind_of and jumps:
            blank = kind_of.without_jumps(blank, rate)
        if jumps or away.any():
            wide = _widened(np.isnan(blank) & ~np.isnan(series))
            form = model.form if model else "sampled"
            model = _refitted(_blanked(middle(blank), middle(wide)), rate, form) or model
            spectrum = _welch(blank, rate, welch_settings or {})
        density = partial(model.psd, frame_rate_hz=rate) if model else None
        own_lines, own_filtered = _lines_and_filters(
            name, blank, rate, density, spectrum, settings, len(quiet)
        )
        if jumps:
            own_lines = [one for one in own_lines if one.line.f_0 > SLOW_HZ]
        avar_1 = float(allan_variance(blank, np.array([1])).variance[0])
        kind = recording.resolution_kind
        step_of = resolution(name, step, kind, avar_1, rate, name.startswith("L"))
        at_hz = [line.line.f_0 for line in own_lines]
        whole = spectrum
        if density and 0 < np.isnan(blank).mean() <= MOST_GAPS:
            whole = _welch(_gapless(blank, density, rate), rate, welch_settings or {})
        broad = resonance(name, blank, rate, whole, at_hz) if whole else None
        return _Examined(name, spectrum, own_lines, own_filtered, step_of, kind_of, broad)

    every = list(over(examined, quiet.items()))
    moves = _movements(recording, settings, over)
    at_rest = [
        pair
        for pair in recording.pairs
        if not any(moves[f"{axis}{k}"].moves for k in pair for axis in AXES)
    ]
    blanked = Made(quiet, lambda name: _blanked(quiet[name], away))
    spectra = {one.name: one.spectrum for one in every if one.spectrum is not None}
    lines = [line for one in every for line in one.lines]
    wanders = {one.name: _walk_decided(one.wander, noise, one.name) for one in every if one.wander}
    recurring, bouts = _recurring(events, quiet, levels, rate, settings.false_alarm, over)
    still = _still(recording, blanked, levels, settings)
    processing = processed(still, rate, step, over)
    for k in range(1, len(recording.labels) + 1):
        processing += running_median(
            {f"{a}{k}": recording.coordinates[f"{a}{k}"] for a in AXES}, step
        )
    low = low_passes(still, rate, recording.resolution_mm, over)
    trends_of = _trends(levels, events)
    n_windows = sum(d.n_tests for own in dynamics.values() for d in own)
    found = Diagnosis(
        events, lines, [left for one in every for left in one.filtered],
        [one.step for one in every], spikes, _missing(recording), drifts, moves, dynamics, levels,
        n_windows, quiet, spectra, low, trends_of,
        heavy_tails(blanked, step, over), _repeats(recording), wanders,
        solved_pairs(quiet, at_rest), processing, recurring,
        [one.resonance for one in every if one.resonance], bouts,
    )  # fmt: skip
    return explained(found)


@dataclass(frozen=True)
class _Examined:
    """What was found in one series without its events."""

    name: str
    spectrum: dict[str, np.ndarray] | None
    lines: list[Found]
    filtered: list[Filtered]
    step: Resolution
    wander: Wander | None
    resonance: Resonance | None


def searched(
    quiet: Mapping[str, np.ndarray],
    pairs: Sequence[tuple[int, int]],
    rate_hz: float,
    step: float,
    false_alarm: float,
    side_s: float,
    over: Over = in_turn,
) -> tuple[list[Event], dict[str, list[Dynamic]], dict[str, Blocks]]:
    """Events of coordinates and distances, spikes bridged, and what they were found in."""
    coordinates = Made((k for k in quiet if not k.startswith("L")), quiet.__getitem__)
    drawn = drawn_in(coordinates, step, over)

    def dynamic(one: tuple[str, np.ndarray]) -> tuple[str, list[Dynamic]]:
        return one[0], dynamic_allan(one[1], rate_hz, step)

    def level(one: tuple[str, np.ndarray]) -> tuple[str, Blocks]:
        return one[0], blocks(one[1], rate_hz)

    dynamics = dict(over(dynamic, all_series(drawn, pairs)))
    levels = dict(over(level, quiet.items()))
    return find_events(dynamics, levels, quiet, rate_hz, false_alarm, side_s), dynamics, levels


def _recurring(
    events: Sequence[Event],
    quiet: Mapping[str, np.ndarray],
    levels: Mapping[str, Blocks],
    rate_hz: float,
    false_alarm: float,
    over: Over,
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
        part = bout(values, rate_hz, chance, levels[name])
        return (name, whole, 0.0, math.inf) if math.isfinite(whole) else (name, *part)

    found = [one for one in over(of, quiet.items()) if math.isfinite(one[1])]
    periods = {name: period for name, period, _, _ in found}
    return periods, {name: (begin, end) for name, _, begin, end in found if math.isfinite(end)}


def _trends(levels: Mapping[str, Blocks], events: Sequence[Event]) -> list[Trend]:
    """Beside what became another at once."""
    one = next(iter(levels.values()), None)
    if one is None:
        return []
    out_of = inside_events(events, one.mean.size, one.length_s)
    steps = [e.time_s for e in events if e.kind == "level" or e.level_changed]
    return trends(levels, out_of, steps)


def _lines_and_filters(
    name: str,
    series: np.ndarray,
    rate_hz: float,
    density: Callable[[np.ndarray], np.ndarray] | None,
    spectrum: Columns | None,
    settings: DiagnosisSettings,
    n_series: int,
) -> tuple[list[Found], list[Filtered]]:
    found, duration = series_lines(series, rate_hz, settings.max_lines, density, n_series)
    notches = [line.f_0 for line in found[:NOTCHES]]
    among = filters(rate_hz, settings.cutoffs_hz, notches, settings.notch_width_hz)
    sinusoids = [Sinusoid(line.A_s, line.f_0) for line in found]
    return (
        described(name, found, duration, rate_hz, series, spectrum),
        tried(name, series, rate_hz, among, density, sinusoids),
    )


def _quiet(
    recording: Recording, settings: DiagnosisSettings, step: float, over: Over
) -> tuple[dict[str, np.ndarray], Mapping[str, np.ndarray], Mapping[str, np.ndarray]]:
    """Isolated frames of every coordinate; the coordinates without them; and these with the
    distances, float32."""
    raw = recording.coordinates
    found = over(lambda values: off_frames(values, settings.spike_sigma, step), raw.values())
    off = dict(zip(raw, found, strict=True))
    spikes = isolated(off, {k: int(k[1:]) for k in raw})
    coordinates = Made(raw, lambda name: without(raw[name], spikes[name]))
    small = kept_if_small(coordinates, recording.n_frames)
    every = every_series(small, recording.pairs)

    def stored(name: str) -> np.ndarray:
        return small[name] if name in small else every[name].astype(np.float32)

    return spikes, small, kept_if_small(Made(every, stored), recording.n_frames)


def _blanked(series: np.ndarray, away: np.ndarray) -> np.ndarray:
    """A copy as float64, NaN where `away`."""
    blank = series.astype(np.float64)
    blank[away] = np.nan
    return blank


def _missing(recording: Recording) -> dict[str, float]:
    """Share of frames without a sample by marker; those that were gap-filled are not counted."""
    filled = {k: n / recording.n_frames for k, n in recording.n_filled.items()}
    return {
        label: max(np.isnan(recording.coordinates[f"x{k}"]).mean() - filled.get(label, 0.0), 0.0)
        for k, label in enumerate(recording.labels, start=1)
    }


def _movements(
    recording: Recording, settings: DiagnosisSettings, over: Over
) -> dict[str, Movement]:
    """Of every coordinate as recorded, and of every distance."""
    given = (
        *(recording.frame_rate_hz, settings.still_range_mm, settings.horizon_s),
        recording.step_mm,
    )

    def of(one: tuple[str, np.ndarray]) -> tuple[str, Movement]:
        name, values = one
        return name, recording.movements.get(name) or movement(values, *given)

    return dict(over(of, all_series(recording.coordinates, recording.pairs)))


def _still(
    recording: Recording,
    series: Mapping[str, np.ndarray],
    levels: Mapping[str, Blocks],
    settings: DiagnosisSettings,
) -> Mapping[str, np.ndarray]:
    """Of markers that do not move all the time, as movement may have any spectrum."""
    busy = {k for k, v in levels.items() if wander(v.mean) > settings.still_range_mm}
    numbers = {k[1:] for k in busy if k in recording.coordinates}
    still = [
        k for k in series if k not in busy and not (k in recording.coordinates and k[1:] in numbers)
    ]
    return Made(still, series.__getitem__)


def _repeats(recording: Recording) -> list[Repeats]:
    """Of every marker, as recorded."""
    found = [
        repeats(label, [recording.coordinates[f"{axis}{k}"] for axis in AXES], recording.step_mm)
        for k, label in enumerate(recording.labels, start=1)
    ]
    return [one for one in found if one is not None]


def _likelihood_rows(noise: Sequence[NoiseRow], series: str) -> list[NoiseRow]:
    return [r for r in noise if r["series"] == series and r["estimator"] == DEFAULT_ESTIMATOR]


def _model(noise: Sequence[NoiseRow], series: str) -> NoiseModel | None:
    """The likelihood's model of a series, or None without one."""
    own = _likelihood_rows(noise, series)
    model = model_of(own) if any(r["status"] != "refused" for r in own) else None
    return model if model and model.broadband else None


def _walk_decided(wander: Wander, noise: Sequence[NoiseRow], series: str) -> Wander:
    """No noise that is named where a walk is of another noise by the signature, or its interval
    holds zero, as slow Gauss-Markov noise may stand for it."""
    of_walk = [r for r in _likelihood_rows(noise, series) if r["parameter"] == "h_-2"]
    lowest = [low for r in of_walk if math.isfinite(low := float(r["lower_95"]))]
    if not wander.noise or not lowest or (wander.noise == "random_walk" and min(lowest) > 0):
        return wander
    return replace(wander, noise="", possible=wander.possible or ("noise",))


def _welch(
    series: np.ndarray, rate_hz: float, asked: Mapping[str, float]
) -> dict[str, np.ndarray] | None:
    try:
        found = welch(series, rate_hz, **asked)
    except Refusal:
        return None
    n = np.full(found.f_hz.size, found.n_segments)
    return {"f_hz": found.f_hz, "psd_mm2_hz": found.psd, "n_segments": n}


def _gapless(
    series: np.ndarray, density: Callable[[np.ndarray], np.ndarray], rate_hz: float
) -> np.ndarray:
    """Gaps filled with noise, as straight lines over them have a spectrum of their own."""
    inside = middle(series)
    there = np.flatnonzero(np.isfinite(inside))
    inside = inside[there[0] : there[-1] + 1]
    return filled(inside, density, rate_hz, np.random.default_rng(0))


def _widened(away: np.ndarray) -> np.ndarray:
    """With gaps long enough that the likelihood parts the series there and fills nothing."""
    wide = away.copy()
    edges = np.flatnonzero(np.diff(np.concatenate([[0], away.astype(np.int8), [0]])))
    for first, last in edges.reshape(-1, 2):
        wide[max(first - LONGEST_GAP // 2, 0) : last + LONGEST_GAP // 2 + 1] = True
    return wide


def _refitted(series: np.ndarray, rate_hz: float, form: Form) -> NoiseModel | None:
    try:
        settings = LikelihoodSettings(form=form)
        model = likelihood(series, rate_hz, None, settings).estimate.model
    except Refusal:
        return None
    return model if model.broadband else None


def _rows(columns: Columns | None, series: str) -> dict[str, np.ndarray] | None:
    """Of one series."""
    if columns is None:
        return None
    keep = columns["series"] == series
    return {k: v[keep] for k, v in columns.items() if k != "series"} if keep.any() else None
