"""The diagnosis in words: plain sentences, each with its numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from mocap_metrology.noise.diagnosis.events import LEAST_S, Event
from mocap_metrology.noise.diagnosis.export import Resolution
from mocap_metrology.noise.diagnosis.filtering import Filtered, Left
from mocap_metrology.noise.diagnosis.levels import BLOCK_S, JOINED_BLOCKS, LEAST_POINTS
from mocap_metrology.noise.diagnosis.outliers import MANY_OUTLIERS
from mocap_metrology.noise.diagnosis.periodic import Disturbance, Found, disturbances
from mocap_metrology.noise.diagnosis.recording import (
    MANY_GAPS,
    Diagnosis,
    DiagnosisSettings,
    Recording,
)
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow
from mocap_metrology.noise.motion.movement import Movement, most_moving
from mocap_metrology.noise.series import AXES
from mocap_metrology.present.text.drift import (
    at_once_words,
    slow_movement,
    under_the_noise,
    wander_sentences,
)
from mocap_metrology.present.text.movement import movement_words
from mocap_metrology.present.text.numbers import (
    at_most,
    duration_words,
    mm,
    moment,
    number,
    percent,
    span,
)
from mocap_metrology.present.text.recording_states import (
    exchanged_words,
    filled_words,
    level_words,
    low_pass_words,
    processed_words,
    repeated_words,
    solved_words,
    tail_words,
)
from mocap_metrology.present.text.sentence import Sentence, severity

NAMED_EVENTS = NAMED_LINES = 10
RECURRING_SHOWN = 2  # examples of events that recur
LEVELS_S = 2 * LEAST_POINTS * JOINED_BLOCKS * BLOCK_S
COMPARED = {
    "changed": "noise changed",
    "alike": "noise is the same before and after",
    "undecided": "undecided whether the noise changed",
}
COARSE_STEP_MM = 0.01  # of text files as some programs export them, Vicon's among them (S 3.4)


def sentences(
    recording: Recording,
    found: Diagnosis,
    noise: Sequence[NoiseRow],
    settings: DiagnosisSettings,
) -> list[Sentence]:
    """All sentences on a recording: movement first, then warnings, then the others.

    If every marker keeps moving, noise is not reported, because movement masks it.
    """
    moving = _moving(found.movements, recording, settings)
    of_the_data = [
        *filled_words(recording),
        *repeated_words(found.repeats, recording),
        *solved_words(found.solved),
        *exchanged_words(recording),
        *_gaps(found.missing),
    ]
    if _all_move_on(found.movements, recording):
        return [*moving, *sorted(of_the_data, key=lambda s: s.severity != "warning")]
    parts: list[Iterable[Sentence]] = [
        _recurring(found),
        _events(found, recording, settings),
        _periodic(found.lines, recording),
        _misfit(noise, found),
        under_the_noise(noise, recording, found.wanders),
        wander_sentences(found, noise, recording),
        low_pass_words(found.low_pass),
        processed_words(found.processed, recording.frame_rate_hz),
        level_words(found.trends),
        tail_words(found.tails),
        of_the_data,
        _outliers(found, recording, settings.spike_sigma),
        _resolution([r for r in found.resolutions if r.series not in found.solved]),
        _filters(found.filtered),
        slow_movement(found, recording),
    ]
    said = [sentence for part in parts for sentence in part]
    return [*moving, *sorted(said, key=lambda s: s.severity != "warning")]


def _events(found: Diagnosis, recording: Recording, settings: DiagnosisSettings) -> list[Sentence]:
    if not found.n_windows and not found.events:
        words = (
            "Events cannot be detected: the recording is too short, or its steps are too coarse."
        )
        return [Sentence("event", "info", (), words, {"n_events": None, "n_windows": 0})]
    if not found.events:
        return [_no_event(found, recording, settings)]
    order = sorted(found.events, key=lambda e: (not e.matters, -np.nan_to_num(e.size_mm)))
    told = [_event(e, recording, found.wanders) for e in order[:NAMED_EVENTS]]
    if found.recurring:
        return told[:RECURRING_SHOWN]
    if len(order) > NAMED_EVENTS:
        words = (
            f"{len(order)} events in {duration_words(recording.duration_s)}; the {NAMED_EVENTS} "
            "most important are listed. The recording was disturbed."
        )
        listed = severity(all(event.matters for event in order[:NAMED_EVENTS]))
        told.insert(0, Sentence("event", listed, (), words, {"n_events": len(order)}))
    return told


def _recurring(found: Diagnosis) -> list[Sentence]:
    if not found.recurring:
        return []
    names = tuple(found.recurring)
    period = found.recurring[names[0]]
    words = (
        f"Bursts recur every {number(period, 1 if period >= 10 else 2)} s in {', '.join(names)}."
    )
    return [Sentence("recurring", "warning", names, words, {"period_s": dict(found.recurring)})]


def _no_event(found: Diagnosis, recording: Recording, settings: DiagnosisSettings) -> Sentence:
    windows = f"{found.n_windows:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    lasting = duration_words(recording.duration_s)
    if recording.duration_s < LEAST_S:
        words = (
            f"Too short to decide on events: {lasting} with {windows} windows of the dynamic "
            f"Allan variance; both sides of an event together need at least {LEAST_S:g} s."
        )
        numbers = {"n_events": None, "n_windows": found.n_windows}
        return Sentence("event", "info", (), words, numbers)
    words = (
        f"No event in {lasting}: none of {windows} windows of the dynamic Allan variance departs "
        f"from the noise by more than it would by chance in {100 * settings.false_alarm:g} % of "
        "undisturbed recordings."
    )
    if recording.duration_s < LEVELS_S:
        words += (
            " Lasting changes of the noise can only be detected in recordings of at least "
            f"{LEVELS_S:g} s."
        )
    return Sentence("event", "info", (), words, {"n_events": 0, "n_windows": found.n_windows})


def _event(event: Event, recording: Recording, wanders: Mapping[str, Wander]) -> Sentence:
    side, markers = event.most_changed, event.markers(recording.labels)
    numbers = {
        "time_s": event.time_s, "duration_s": event.duration_s, "size_mm": event.size_mm,
        "shift_mm": event.shift_mm, "false_alarm_p": event.p, "word": outcome(event),
        "markers": markers,
        "sides": [vars(s) for s in event.sides],
    }  # fmt: skip
    if event.kind == "level":
        words = f"At {moment(event.time_s)} the noise level of {event.series[0]} changed"
    else:
        who = ", ".join(markers) or ", ".join(event.series)
        words = f"At {moment(event.time_s)} {who} "
        words += at_once_words(event.time_s, event.stop_s, wanders) or (
            f"moved by up to {mm(event.size_mm)} ({event.largest}) for {event.duration_s:.2g} s"
        )
    if side is None:
        words += "; too few samples remain on one side to compare the noise before and after"
    else:
        words += (
            f"; {COMPARED[event.noise_after]}: sd of {side.series} {mm(side.fast_before)} before, "
            f"{mm(side.fast_after)} after, ratio {side.ratio:.3f} "
            f"({side.lower:.3f} to {side.upper:.3f})"
        )
    return Sentence("event", severity(event.matters), event.series, words + ".", numbers)


def outcome(event: Event) -> str:
    """`level changed`, `happened once`, `one of 3`, or `unknown`."""
    words = {"once": "happened once", "repeated": f"one of {event.of}"}
    return words.get(event.outcome, event.outcome)


def _periodic(lines: Sequence[Found], recording: Recording) -> list[Sentence]:
    """One a frequency, with all series that show it."""
    found = disturbances(lines, recording.duration_s)
    if not found:
        words = "No periodic disturbance was detected in any series."
        return [Sentence("periodic", "info", (), words, {"n_lines": 0})]
    found = sorted(found, key=lambda one: not one.matters)
    told = [_disturbance(one, recording) for one in found[:NAMED_LINES]]
    if len(found) > NAMED_LINES:
        words = f"{len(found)} periodic disturbances; the {NAMED_LINES} most important are listed."
        listed = severity(all(one.matters for one in found[:NAMED_LINES]))
        told.insert(0, Sentence("periodic", listed, (), words, {"n_lines": len(found)}))
    return told


def _disturbance(one: Disturbance, recording: Recording) -> Sentence:
    first = one.first
    sizes = ", ".join(f"{x.series} {mm(x.line.A_s)}" for x in one.lines)
    words = f"Periodic disturbance at {first.line.f_0:.5g} Hz, amplitude: {sizes}; "
    words += line_words(first)
    if first.share == first.share:
        words += f"; it contributes {percent(first.share)} of the Allan variance of "
        words += f"{first.series} at {first.tau_s:.2g} s"
    numbers = {
        "f_hz": first.line.f_0,
        "f_std_error_hz": first.f_error,
        "width_f_hz": first.line.width_f,
        "amplitude_mm": {x.series: x.line.A_s for x in one.lines},
        "share_of_avar": {x.series: x.share for x in one.lines},
        "psd_snr": {x.series: x.snr_psd for x in one.lines},
        "alias_hz": recording.frame_rate_hz - first.line.f_0,
    }
    names = tuple(x.series for x in one.lines)
    return Sentence("periodic", severity(one.matters), names, words + ".", numbers)


def line_words(one: Found) -> str:
    """Where a line shows, and what it is of."""
    where = ["in the periodogram"]
    where += ["in the PSD"] if one.in_psd else []
    where += ["in the ADEV"] if one.in_adev else []
    said = "seen " + " and ".join([", ".join(where[:-1]), where[-1]] if where[1:] else where)
    if one.harmonic:
        said += f"; harmonic {one.harmonic[0]} of {one.harmonic[1]:.6g} Hz"
    if one.amplitude:
        said += f"; its amplitude changes between {mm(one.amplitude[0])} and {mm(one.amplitude[1])}"
    elif one.line.wide:
        said += (
            f"; its frequency or its amplitude varies: it fills a band of {one.line.width_f:.2g} Hz"
        )
    if one.mains:
        said += f"; could be {one.mains.f_hz:g} Hz of {one.mains.mains_hz:g} Hz mains"
        folded = one.mains.folded_at_hz
        said += f", folded at {folded:g} Hz" if folded else ""
    return said


def _resolution(found: Sequence[Resolution]) -> list[Sentence]:
    known = [r for r in found if r.share == r.share]
    if not known:
        return []
    worst = max(known, key=lambda r: r.share)
    coarse = worst.share_of(COARSE_STEP_MM)
    meaning = {
        "fine": "which is negligible",
        "noticeable": "which is visible in the white level",
        "dominates": "so the resolution of the export limits the result: export with finer steps",
        "unknown": "",
    }[worst.word]
    words = (
        f"Resolution: the steps of the file are {mm(worst.step_mm)} ({worst.kind}). They "
        f"contribute {at_most(worst.share)} of the Allan variance at one frame ({worst.series}), "
        f"{meaning}; {_coarse_words(coarse)}."
    )
    numbers = {
        "step_mm": worst.step_mm, "word": worst.word, "share": {r.series: r.share for r in known},
        "rounding_h0_mm2_hz": {r.series: r.rounding_h0 for r in known}, "vicon_share": coarse,
    }  # fmt: skip
    names = tuple(r.series for r in known)
    return [Sentence("resolution", severity(worst.word != "fine"), names, words, numbers)]


def _coarse_words(share: float) -> str:
    """What an export in coarse steps would do, by the variance of their rounding over that of a
    frame as it is."""
    steps = f"an export in steps of {COARSE_STEP_MM:g} mm would"
    if not math.isfinite(share):
        return f"{steps} hide all of it"
    if share > 1:
        return f"{steps} add {number(share, 0 if share >= 10 else 1)} times that variance"
    return f"{steps} contribute {percent(share)}"


def _filters(filtered: Sequence[Filtered]) -> list[Sentence]:
    """One a low-pass over all series, one a notch."""
    before = {f.series: f.measured for f in filtered if f.filter.sos is None and f.measured}
    told = []
    for name in dict.fromkeys(f.filter.name for f in filtered if f.filter.sos is not None):
        own = [f for f in filtered if f.filter.name == name]
        after = {f.series: f.measured for f in own if f.measured}
        after = {k: f for k, f in after.items() if k in before and before[k].sigma > 0}
        if not after:
            continue
        share = {k: (f.sigma / before[k].sigma) ** 2 for k, f in after.items()}
        slow = {k: _slow(f, before[k]) for k, f in after.items()}
        words = f"{name} leaves {span(share.values(), percent)} of the variance of a frame"
        slow_known = [v for v in slow.values() if v == v]
        if slow_known:
            words += f" and {span(slow_known, percent)} of the Allan deviation at 1 s"
        numbers = {
            "filter": name, "share_left": share, "adev_1s_ratio": slow,
            "sigma_mm": {k: f.sigma for k, f in after.items()},
            "least_adev_mm": {k: f.least for k, f in after.items()},
            "predicted_sigma_mm": {
                f.series: f.predicted.sigma for f in own if f.predicted and f.series in after
            },
        }  # fmt: skip
        told.append(Sentence("filter", "info", tuple(after), words + ".", numbers))
    return told


def _slow(after: Left, before: Left) -> float:
    return after.adev[2] / before.adev[2] if before.adev[2] > 0 else math.nan


def _outliers(found: Diagnosis, recording: Recording, n_sigma: float) -> list[Sentence]:
    count = {k: int(v.size) for k, v in found.spikes.items()}
    total, name = sum(count.values()), max(count, key=lambda k: count[k])
    share = count[name] / max(recording.n_frames, 1)
    hours = recording.duration_s / 3600
    frames = "frame deviates" if total == 1 else "frames deviate"
    words = f"{total or 'No'} isolated {frames} by more than {n_sigma:g} standard deviations"
    if total:
        often = f"{total / hours:.3g} an hour" if hours > 0.1 else f"{percent(share)} of {name}"
        words += f", {often}, most in {name} ({count[name]})"
    words += "."
    numbers = {"n": count, "per_hour": total / hours, "share": share}
    names = tuple(k for k, n in count.items() if n)
    return [Sentence("outliers", severity(share > MANY_OUTLIERS), names, words, numbers)]


def _gaps(missing: dict[str, float]) -> list[Sentence]:
    name = max(missing, key=lambda k: missing[k])
    if not missing[name]:
        return [Sentence("gaps", "info", (), "No frame is missing.", {"share": missing})]
    words = f"Marker {name} is missing in {percent(missing[name])} of the frames."
    return [Sentence("gaps", severity(missing[name] > MANY_GAPS), (), words, {"share": missing})]


def _moving(
    movements: Mapping[str, Movement], recording: Recording, settings: DiagnosisSettings
) -> list[Sentence]:
    by_marker = {
        label: {axis: movements[f"{axis}{k}"] for axis in AXES}
        for k, label in enumerate(recording.labels, start=1)
    }
    within = min(recording.duration_s, settings.horizon_s)
    named = tuple(name for name, one in movements.items() if one.moves)
    sizes = {name: movements[name].size_mm for name in named}
    return [
        Sentence("moving", "warning", named, f"{line[0].upper()}{line[1:]}.", {"size_mm": sizes})
        for line in movement_words(most_moving(by_marker), within)
    ]


def _all_move_on(movements: Mapping[str, Movement], recording: Recording) -> bool:
    """Whether every marker moves, other than by one jump with rest before and after it."""
    return all(
        any(one.moves and math.isnan(one.time_s) for one in own)
        for k in range(1, len(recording.labels) + 1)
        for own in [[movements[f"{axis}{k}"] for axis in AXES]]
    )


def _misfit(noise: Sequence[NoiseRow], found: Diagnosis) -> list[Sentence]:
    own = [r for r in noise if r["estimator"] == DEFAULT_ESTIMATOR]
    told = []
    bad = tuple(dict.fromkeys(r["series"] for r in own if r["status"] == "misfit"))
    if bad:
        words = f"No noise model describes the spectrum of {', '.join(bad)}"
        if found.events:
            words += ", which contains the events; for the filters it was fitted again without them"
        else:
            words += "; the noise left by filters is therefore measured, not predicted"
        words += "."
        told.append(Sentence("misfit", "warning", bad, words))
    refused = tuple(dict.fromkeys(r["series"] for r in own if r["status"] == "refused"))
    if refused:
        why = next(r["note"] for r in own if r["status"] == "refused")
        words = f"No noise model of {', '.join(refused)}: {why}."
        told.append(Sentence("misfit", "warning", refused, words))
    return told
