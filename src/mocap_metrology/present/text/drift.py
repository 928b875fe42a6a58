"""Slow movement, warm-up and drift of a recording in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mocap_metrology.noise.diagnosis.findings import approach, deterministic_parts
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.present.text.numbers import duration_words, mm, with_unit
from mocap_metrology.present.text.sentence import Sentence, severity


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
    numbers = {
        "range_mm": {k: d.range for k, d in known.items()},
        "drift_mm_per_h": {k: d.per_hour for k, d in known.items()},
    }
    return [Sentence("drift", "info", (name,), words, numbers)]


def under_the_noise(noise: Sequence[NoiseRow], recording: Recording) -> list[Sentence]:
    """Warm-up and straight line that the noise model has."""
    parts = deterministic_parts(noise)
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
