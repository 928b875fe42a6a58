"""The diagnosis in sentences, each with its numbers; their wording is in recording.toml."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.noise.diagnosis import findings, levels
from mocap_metrology.noise.diagnosis.events import LEAST_S, Event, inside_events
from mocap_metrology.noise.diagnosis.fills import MANY_FILLED
from mocap_metrology.noise.diagnosis.filtering import Filtered
from mocap_metrology.noise.diagnosis.outliers import MANY_OUTLIERS
from mocap_metrology.noise.diagnosis.periodic import SpectralLine, comb, disturbances, mains_of
from mocap_metrology.noise.diagnosis.recording import MANY_GAPS
from mocap_metrology.noise.diagnosis.records import Diagnosis, DiagnosisSettings, Recording
from mocap_metrology.noise.diagnosis.sides import BLOCK_S
from mocap_metrology.noise.diagnosis.signatures import NEAR_S, Wander
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow
from mocap_metrology.noise.motion.movement import all_keep_moving, most_moving
from mocap_metrology.noise.series import AXES
from mocap_metrology.present.text.sentence import Sentence, movement_words, render, sentence

NAMED = 10  # events, or lines
RECURRING_SHOWN = 2  # examples of events that recur
LEVELS_S = 2 * levels.LEAST_POINTS * levels.JOINED_BLOCKS * BLOCK_S
COARSE_STEP_MM = 0.01  # of text files as some programs export them, Vicon's among them (S 3.4)
ENDS = 10  # parts, of which the first and the last are compared
LONGER = 4  # times the length: of cycles four, of a warm-up its end


def sentences(
    recording: Recording,
    diagnosis: Diagnosis,
    noise: Sequence[NoiseRow],
    settings: DiagnosisSettings,
) -> list[Sentence]:
    """All sentences on a recording: movement first, then warnings, then the others.

    If every marker keeps moving, noise is not reported, because movement masks it.
    """
    by_marker = {
        label: {axis: diagnosis.movements[f"{axis}{k}"] for axis in AXES}
        for k, label in enumerate(recording.labels, start=1)
    }
    sizes = {name: one.size_mm for name, one in diagnosis.movements.items() if one.moves}
    within_s = min(recording.duration_s, settings.horizon_s)
    moving = [
        sentence("moving.markers", True, sizes, {"size_mm": sizes}, line=line)
        for line in movement_words(most_moving(by_marker), within_s)
    ]
    parts: list[Iterable[Sentence]] = [_samples(diagnosis, recording)]
    if not all_keep_moving(by_marker):
        parts = [
            _events(diagnosis, recording, settings),
            _periodic(diagnosis, recording),
            _resonances(diagnosis, recording),
            _misfit(noise, diagnosis),
            _wanders(diagnosis, noise, recording),
            _shape_of_noise(diagnosis, recording.frame_rate_hz),
            *parts,
            _outliers(diagnosis, recording, settings.spike_sigma),
            _resolution(diagnosis),
            _filters(diagnosis.filtered),
            _slow_movement(diagnosis, recording),
        ]
    told = [one for part in parts for one in part]
    return [*moving, *sorted(told, key=lambda one: one.severity != "warning")]


def _events(
    diagnosis: Diagnosis, recording: Recording, settings: DiagnosisSettings
) -> Iterator[Sentence]:
    seconds, shown = recording.duration_s, NAMED
    if diagnosis.recurring:
        shown = RECURRING_SHOWN
        period = {"period_s": dict(diagnosis.recurring)}
        within = next(iter(diagnosis.bouts.values()), None)
        yield sentence("recurring.bursts", True, diagnosis.recurring, period, within=within)
    elif len(diagnosis.events) > NAMED:
        matter = sum(event.matters for event in diagnosis.events) >= NAMED
        numbers = {"n_events": len(diagnosis.events)}
        yield sentence("event.many", matter, (), numbers, seconds=seconds, named=NAMED)
    if not diagnosis.events:
        case = "none" if seconds >= LEAST_S else "short"
        case = case if diagnosis.n_windows else "undetectable"
        none = {"n_events": 0 if case == "none" else None, "n_windows": diagnosis.n_windows}
        limits = {"least_s": LEAST_S, "levels_s": LEVELS_S, "false_alarm": settings.false_alarm}
        yield sentence(f"event.{case}", False, (), none, seconds=seconds, **limits)
    order = sorted(diagnosis.events, key=lambda e: (not e.matters, -np.nan_to_num(e.size_mm)))
    for event in order[:shown]:
        yield _event(event, recording, diagnosis.wanders)


def _event(event: Event, recording: Recording, wanders: Mapping[str, Wander]) -> Sentence:
    shift, near = "", findings.shift_near(event.time_s, event.stop_s, wanders)
    if near and not abs(event.shift_mm) > 2 * abs(near[1]):  # else another coordinate moved more
        event = replace(event, series=tuple(dict.fromkeys([*event.series, near[0]])))
        within_s = event.duration_s if event.duration_s > NEAR_S else 0.0  # not at once
        values = {"name": near[0], "size_mm": near[1], "back": near[2], "one": wanders[near[0]]}
        shift = render("event.shift", within_s=within_s, **values)
    markers = event.markers(recording.labels)
    numbers = {
        "time_s": event.time_s, "duration_s": event.duration_s, "size_mm": event.size_mm,
        "shift_mm": event.shift_mm, "false_alarm_p": event.p, "word": outcome(event),
        "markers": markers, "sides": [vars(side) for side in event.sides],
    }  # fmt: skip
    more = {"shift": shift, "side": event.most_changed, "event": event}
    return sentence("event.one", event.matters, event.series, numbers, **more)


def outcome(event: Event) -> str:
    """`level changed`, `happened once`, `one of 3`, or `unknown`."""
    words = {"once": "happened once", "repeated": f"one of {event.of}"}
    return words.get(event.outcome, event.outcome)


def _periodic(diagnosis: Diagnosis, recording: Recording) -> Iterator[Sentence]:
    """One a frequency, with all series that show it, and one for all multiples of one."""
    lines = diagnosis.lines
    groups = sorted(disturbances(lines, recording.duration_s), key=lambda one: not one.matters)
    f_hz, teeth = comb(groups, recording.duration_s)
    if teeth:
        of_comb = [line for one in teeth for line in one.lines]
        rms = {
            name: math.sqrt(sum(x.line.A_s**2 for x in of_comb if x.series == name) / 2)
            for name in dict.fromkeys(x.series for x in of_comb)
        }
        highest = max(x.line.f_0 for x in of_comb)
        numbers = {"f_hz": f_hz, "n_lines": len(teeth), "highest_hz": highest, "rms_mm": rms}
        mains = mains_of(f_hz, recording.frame_rate_hz, 1 / recording.duration_s)
        matter = any(one.matters for one in teeth)
        yield sentence("periodic.comb", matter, rms, numbers, mains=mains)
        groups = [one for one in groups if one not in teeth]
    if not lines:
        slow = any("cycle" in one.kinds for one in diagnosis.wanders.values())
        slow = slow or bool(diagnosis.recurring)
        yield sentence("periodic.none", False, (), {"n_lines": 0}, slow=slow)
    if len(groups) > NAMED:
        matter = all(one.matters for one in groups[:NAMED])
        yield sentence("periodic.many", matter, (), {"n_lines": len(groups)}, named=NAMED)
    for one in groups[:NAMED]:
        first = one.first
        numbers = {
            "f_hz": first.line.f_0,
            "f_std_error_hz": first.f_error,
            "width_f_hz": first.line.width_f,
            "amplitude_mm": {x.series: x.line.A_s for x in one.lines},
            "share_of_avar": {x.series: x.share for x in one.lines},
            "psd_snr": {x.series: x.snr_psd for x in one.lines},
            "alias_hz": recording.frame_rate_hz - first.line.f_0,
        }
        names, seen = [x.series for x in one.lines], line_words(first)
        yield sentence("periodic.one", one.matters, names, numbers, first=first, seen=seen)


def _resonances(diagnosis: Diagnosis, recording: Recording) -> Iterator[Sentence]:
    """One a frequency, with all series that show it, the largest first."""
    left = sorted(diagnosis.resonances, key=lambda one: -one.rms_mm)
    while left:
        first = left[0]
        same = [one for one in left if abs(one.f_hz / first.f_hz - 1) < 0.05]
        left = [one for one in left if one not in same]
        rms = {one.series: one.rms_mm for one in same}
        shaken = {int(name[1:]) for name in rms if name in recording.coordinates}
        numbers = {"f_hz": first.f_hz, "damping": first.damping, "rms_mm": rms}
        common = len(recording.labels) > 1 and len(shaken) == len(recording.labels)
        yield sentence("resonance.broad", True, rms, numbers, common=common)


def line_words(line: SpectralLine) -> str:
    """Words on where a line shows and what causes it."""
    return render("periodic.seen", x=line)


def _misfit(noise: Sequence[NoiseRow], diagnosis: Diagnosis) -> Iterator[Sentence]:
    for status in ("misfit", "refused"):
        rows = [r for r in noise if (r["estimator"], r["status"]) == (DEFAULT_ESTIMATOR, status)]
        if rows:
            names = dict.fromkeys(r["series"] for r in rows)
            note = rows[0]["note"]
            yield sentence(f"misfit.{status}", True, names, events=diagnosis.events, note=note)


def _wanders(
    diagnosis: Diagnosis, noise: Sequence[NoiseRow], recording: Recording
) -> Iterator[Sentence]:
    """Warm-up and straight line of the noise model, and each other kind of slow wander; of the
    coordinate that has most of it."""
    seconds = recording.duration_s
    parts = findings.deterministic_parts(noise, diagnosis.wanders)
    numbers = {
        name: {"drift_mm_per_h": part.drift, "A_w_mm": part.A_w, "T_w_s": part.T_w}
        for name, part in parts.items()
    }
    warm = {name: findings.approach(part, seconds) for name, part in parts.items() if part.A_w}
    if warm:
        name = max(warm, key=lambda k: abs(warm[k][0]))
        values = {"name": name, "moved": warm[name], "part": parts[name]}
        yield sentence("warm_up.model", True, warm, {k: numbers[k] for k in warm}, **values)
    drift = {name: part.drift for name, part in parts.items() if part.drift}
    if drift:
        name = max(drift, key=lambda k: abs(drift[k]))
        values = {"name": name, "per_hour": drift[name], "seconds": seconds}
        yield sentence("drift.model", False, drift, {k: numbers[k] for k in drift}, **values)
    for kind, name, sizes in findings.other_wanders(recording, diagnosis, parts):
        one = diagnosis.wanders[name]
        times_s = findings.times_of(one, diagnosis)
        begin_s = one.at_s[0] if kind == "shift" else times_s[0] if times_s else 0.0
        when = render("wander.when", begin_s=begin_s, lost_s=one.lost_s, near_s=NEAR_S)
        values = {"name": name, "one": one, "seconds": seconds, "longer": LONGER}
        values |= {"times_s": times_s, "when": when}
        yield sentence(f"wander.{kind}", kind != "drift", sizes, {f"{kind}_mm": sizes}, **values)


def _slow_movement(diagnosis: Diagnosis, recording: Recording) -> Iterator[Sentence]:
    """Range and slope of the means of short blocks, of the series that wanders most."""
    known = {k: d for k, d in diagnosis.drifts.items() if math.isfinite(d.per_hour)}
    if known:
        name = max(known, key=lambda k: known[k].range)
        numbers = {
            "range_mm": {k: d.range for k, d in known.items()},
            "drift_mm_per_h": {k: d.per_hour for k, d in known.items()},
        }
        seconds = recording.duration_s
        ends = inside_events(diagnosis.events, ENDS, seconds / ENDS)[[0, -1]]
        one = None if ends.any() else diagnosis.wanders.get(name)
        values = {"drift": known[name], "one": one}
        yield sentence("drift.slow", False, [name], numbers, seconds=seconds, **values)


def _shape_of_noise(diagnosis: Diagnosis, rate_hz: float) -> Iterator[Sentence]:
    """Noise that the export filtered or made, whose level changes, or that is not Gaussian."""
    if diagnosis.low_pass:
        cutoffs = {one.series: one.cutoff_hz for one in diagnosis.low_pass}
        ratios = {one.series: one.ratio for one in diagnosis.low_pass}
        known = [f for f in cutoffs.values() if math.isfinite(f)]
        numbers = {"cutoff_hz": cutoffs, "top_to_pass_band": ratios}
        yield sentence("low_pass.filtered", True, cutoffs, numbers, cutoffs_hz=known)
    for code in dict.fromkeys(one.code for one in diagnosis.processed):
        of = {one.series: one.value for one in diagnosis.processed if one.code == code}
        f_hz = next(iter(of.values()))
        yield sentence(f"{code}.frames", True, of, {"value": of}, f_hz=f_hz, rate_hz=rate_hz)
    for direction in ("falls", "rises", "changes"):
        trends = [t for t in diagnosis.trends if t.direction == direction]
        if trends:
            worst = max(trends, key=lambda t: t.extent)
            change = {t.series: t.change for t in trends}
            yield sentence("level.noise", worst.matters, change, {"change": change}, worst=worst)
    if diagnosis.tails:
        excess = {one.series: one.excess for one in diagnosis.tails}
        name = max(excess, key=lambda k: excess[k])
        yield sentence("tails.heavy", False, excess, {"excess": excess}, name=name)


def _samples(diagnosis: Diagnosis, recording: Recording) -> Iterator[Sentence]:
    """Frames that were filled, repeated, solved, exchanged, or are missing."""
    rate = recording.frame_rate_hz
    coordinates = {
        label: [f"{axis}{k}" for axis in AXES] for k, label in enumerate(recording.labels, start=1)
    }
    for label, names in coordinates.items():
        share = recording.n_filled.get(label, 0) / recording.n_frames
        if share:
            case = "filled.smooth" if diagnosis.smooth else "filled.marker"
            yield sentence(case, share > MANY_FILLED, names, {"share": share}, label=label)
    for one in diagnosis.repeats:
        longest_s = one.longest / rate
        numbers = {"share": one.share, "longest_s": longest_s, "change_mm": one.change_mm}
        names = coordinates[one.label]
        yield sentence("repeated.marker", True, names, numbers, label=one.label)
    if diagnosis.solved:
        yield sentence(
            "solved.distances", True, diagnosis.solved, {"ratio": dict(diagnosis.solved)}
        )
    for pair in recording.exchanged:
        names = [name for label in pair["labels"] for name in coordinates[label]]
        yield sentence("exchanged.pair", True, names, dict(pair), rate_hz=rate)
    label = max(diagnosis.missing, key=lambda k: diagnosis.missing[k])
    many = diagnosis.missing[label] > MANY_GAPS
    yield sentence("gaps.marker", many, (), {"share": diagnosis.missing}, label=label)


def _outliers(diagnosis: Diagnosis, recording: Recording, n_sigma: float) -> Iterator[Sentence]:
    n = {k: int(v.size) for k, v in diagnosis.spikes.items()}
    name, hours = max(n, key=lambda k: n[k]), recording.duration_s / 3600
    share = n[name] / max(recording.n_frames, 1)
    numbers = {"n": n, "per_hour": sum(n.values()) / hours, "share": share}
    names = [k for k, count in n.items() if count]
    values = {"name": name, "hours": hours, "n_sigma": n_sigma}
    yield sentence("outliers.count", share > MANY_OUTLIERS, names, numbers, **values)


def _resolution(diagnosis: Diagnosis) -> Iterator[Sentence]:
    known = {
        r.series: r
        for r in diagnosis.resolutions
        if r.series not in diagnosis.solved and math.isfinite(r.share)
    }
    if known:
        worst = max(known.values(), key=lambda r: r.share)
        numbers = {
            "step_mm": worst.step_mm,
            "word": worst.word,
            "share": {name: r.share for name, r in known.items()},
            "rounding_h0_mm2_hz": {name: r.rounding_h0 for name, r in known.items()},
            "vicon_share": worst.share_of(COARSE_STEP_MM),
        }
        alone = worst.step_mm > 2 * min(r.step_mm for r in known.values())
        values = {"worst": worst, "coarse_mm": COARSE_STEP_MM, "alone": alone}
        yield sentence("resolution.steps", worst.word != "fine", known, numbers, **values)


def _filters(filtered: Sequence[Filtered]) -> Iterator[Sentence]:
    """One a low-pass over all series, one a notch."""
    before = {f.series: f.measured for f in filtered if f.filter.sos is None and f.measured}
    for name in dict.fromkeys(f.filter.name for f in filtered if f.filter.sos is not None):
        by_series = {f.series: f for f in filtered if f.filter.name == name}
        after = {k: f.measured for k, f in by_series.items() if f.measured and k in before}
        after = {k: left for k, left in after.items() if before[k].sigma > 0}
        if not after:
            continue
        predicted = {k: by_series[k].predicted for k in after}
        numbers = {
            "filter": name,
            "share_left": {k: left.variance_share(before[k]) for k, left in after.items()},
            "adev_1s_ratio": {k: left.adev_1s_ratio(before[k]) for k, left in after.items()},
            "sigma_mm": {k: left.sigma for k, left in after.items()},
            "least_adev_mm": {k: left.least for k, left in after.items()},
            "predicted_sigma_mm": {k: left.sigma for k, left in predicted.items() if left},
        }
        yield sentence("filter.left", False, after, numbers)
