"""Slow movement, warm-up and drift of a recording in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mocap_metrology.noise.diagnosis.findings import approach, deterministic_parts
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.present.text.numbers import duration_words, mm, moment, with_unit
from mocap_metrology.present.text.sentence import Sentence, severity

LASTING_S = 10.0  # of a shift; a shorter one is movement
AT_ONCE_S = 5.0  # from an event to the step or shift that it is an end of
LONGER = 4  # times the length: of cycles four, of a warm-up its end


def slow_movement(found: Diagnosis, recording: Recording) -> list[Sentence]:
    """Range and slope of the means of short blocks, of the series that wanders most."""
    known = {k: d for k, d in found.drifts.items() if d.per_hour == d.per_hour}
    if not known:
        return []
    name, worst = max(known.items(), key=lambda item: item[1].range)
    words = (
        f"Slow movement: means over {worst.block_s:.2g} s wander by up to {mm(worst.range)} "
        f"({name}) in {duration_words(recording.duration_s)}; the slope of a straight line "
        f"through them is {_slope(worst.per_hour, recording.duration_s)}."
    )
    one = found.wanders.get(name)
    if one and one.net_error_mm == one.net_error_mm:
        words += (
            f" From its first tenth to its last it moved by {mm(one.net_mm)} "
            f"+- {mm(1.96 * one.net_error_mm)}."
        )
    numbers = {
        "range_mm": {k: d.range for k, d in known.items()},
        "drift_mm_per_h": {k: d.per_hour for k, d in known.items()},
    }
    return [Sentence("drift", "info", (name,), words, numbers)]


def under_the_noise(
    noise: Sequence[NoiseRow], recording: Recording, wanders: Mapping[str, Wander]
) -> list[Sentence]:
    """Warm-up and straight line that the noise model has and no other kind of wander explains."""
    parts = deterministic_parts(noise, wanders)
    told = []
    for kind, words in (
        ("warm_up", warm_up_words(parts, recording.duration_s)),
        ("drift", drift_words(parts, recording.duration_s)),
    ):
        if words:
            names = [k for k, p in parts.items() if (p.A_w if kind == "warm_up" else p.drift)]
            numbers = {k: {"drift_mm_per_h": parts[k].drift, "A_w_mm": parts[k].A_w,
                           "T_w_s": parts[k].T_w} for k in names}  # fmt: skip
            words = f"{words[0].upper()}{words[1:]}."
            level = severity(kind == "warm_up")
            told.append(Sentence(kind, level, tuple(names), words, numbers))
    return told


def wander_sentences(
    found: Diagnosis, noise: Sequence[NoiseRow], recording: Recording
) -> list[Sentence]:
    """One of each kind of slow wander, of the coordinate that has most of it, and of what is
    undecided; not of steps that are an event, nor of what `under_the_noise` says."""
    told = []
    parts = deterministic_parts(noise, found.wanders)
    said = {"drift"} | ({"warm_up"} if any(part.A_w for part in parts.values()) else set())
    of: dict[str, dict[str, Wander]] = {}
    for name, one in found.wanders.items():
        for kind in ("undecided",) if one.undecided else one.kinds:
            of.setdefault(kind, {})[name] = one
    for kind, those in of.items():
        if kind in said:
            continue
        size = {k: v.range_mm if kind == "undecided" else abs(v.size_mm) for k, v in those.items()}
        name = max(size, key=lambda k: (k in recording.coordinates, size[k]))
        if kind in ("step", "shift") and any(
            at_once(e.time_s, e.stop_s, those[name]) == 0 for e in found.events
        ):
            continue
        words = _words_of(kind, those[name], name, recording.duration_s)
        told.append(Sentence("wander", "warning", tuple(those), words, {f"{kind}_mm": size}))
    return told


def at_once(begin_s: float, end_s: float, one: Wander) -> int | None:
    """Which end of a step or shift an event is: 0 the begin, 1 where it goes back; else None."""
    near = AT_ONCE_S
    if not {"step", "shift"} & set(one.kinds):
        return None
    ends = one.at_s if "shift" in one.kinds else one.at_s[:1]
    return next((k for k, t in enumerate(ends) if begin_s - near <= t <= end_s + near), None)


def at_once_words(begin_s: float, end_s: float, wanders: Mapping[str, Wander]) -> str:
    """What an event is that is an end of a step or shift; empty for others."""
    ends = {name: at_once(begin_s, end_s, one) for name, one in wanders.items()}
    here = [name for name, end in ends.items() if end is not None]
    if not here:
        return ""
    name = max(here, key=lambda k: (not k.startswith("L"), abs(wanders[k].size_mm)))
    one = wanders[name]
    size = f"by {mm(abs(one.size_mm))} ({name})"
    if "step" in one.kinds:
        return f"shifted {size} and stayed there"
    if one.at_s[1] - one.at_s[0] < LASTING_S:
        return ""
    lasting = duration_words(one.at_s[1] - one.at_s[0])
    return (
        f"shifted back {size}" if ends[name] else f"shifted {size} and came back within {lasting}"
    )


def _words_of(kind: str, one: Wander, name: str, duration_s: float) -> str:
    size, net = mm(abs(one.size_mm)), mm(abs(one.net_mm))
    lasting = duration_words(duration_s)
    if kind == "warm_up":
        return f"{name} approaches a position: it moved by {net} in {lasting}, ever more slowly."
    if kind == "accelerating":
        return (
            f"{name} moved by {net} in {lasting}, ever faster: check that the marker and the "
            "cameras are mounted firmly."
        )
    if kind == "creep":
        return f"{name} creeps: it moved by {net} in {lasting}, ever more slowly."
    if kind == "cycle":
        period = duration_words(one.at_s[-1])
        return f"{name} goes to and fro with a period of {period}, amplitude {size}."
    if kind == "step":
        return f"At {moment(one.at_s[0])} {name} shifted by {size} and stayed there."
    if kind == "shift":
        begin, end = one.at_s
        back = duration_words(end - begin)
        return f"At {moment(begin)} {name} shifted by {size}, and came back within {back}."
    if kind == "two_levels":
        return (
            f"{name} switches between two positions {size} apart, every "
            f"{duration_words(one.at_s[-1])} on average: a camera may gain and lose the marker."
        )
    return (
        f"Slow wander of {mm(one.range_mm)} in {lasting} ({name}); its kind cannot be decided from "
        f"this recording, one of {duration_words(LONGER * duration_s)} may show it."
    )


def warm_up_words(parts: Mapping[str, Deterministic], duration_s: float) -> str:
    """`still warming up: 0.21 mm in the first 18 minutes (x1), time constant 6 minutes: start
    recording later`; of the series that moves most; empty where none does."""
    sizes = {name: approach(p, duration_s) for name, p in parts.items() if p.A_w}
    if not sizes:
        return ""
    name = max(sizes, key=lambda k: abs(sizes[k][0]))
    size, within = sizes[name]
    return (
        f"still warming up: {mm(abs(size))} in the first {duration_words(within)} ({name}), "
        f"time constant {duration_words(parts[name].T_w)}: start recording later"
    )


def drift_words(parts: Mapping[str, Deterministic], duration_s: float) -> str:
    """`a steady drift of 1.2 mm/h (x1), 0.2 mm in all`; of the series with the fastest; empty where
    none drifts."""
    speeds = {name: p.drift for name, p in parts.items() if p.drift}
    if not speeds:
        return ""
    name = max(speeds, key=lambda k: abs(speeds[k]))
    gone = abs(speeds[name]) * duration_s / 3600
    return f"a steady drift of {with_unit(speeds[name], 'mm/h')} ({name}), {mm(gone)} in total"


def _slope(per_hour: float, duration_s: float) -> str:
    """In mm/h for a recording of a minute or more; for a shorter one in mm over its length."""
    if duration_s >= 60:
        return with_unit(per_hour, "mm/h", sign=True)
    return f"{mm(per_hour * duration_s / 3600)} over the whole recording"
