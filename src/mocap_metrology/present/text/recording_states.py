"""Sentences on what the export did to the noise, and on noise that is not stationary Gaussian."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.noise.diagnosis.export import MANY_FILLED, LowPass
from mocap_metrology.noise.diagnosis.levels import Trend
from mocap_metrology.noise.diagnosis.outliers import Tails
from mocap_metrology.noise.diagnosis.recording import Recording
from mocap_metrology.noise.diagnosis.repeats import Repeats
from mocap_metrology.noise.diagnosis.software import Processed
from mocap_metrology.noise.series import AXES
from mocap_metrology.present.text.numbers import mm, moment, percent
from mocap_metrology.present.text.sentence import Sentence, severity


def low_pass_words(found: Sequence[LowPass]) -> list[Sentence]:
    if not found:
        return []
    cutoffs = {one.series: one.cutoff_hz for one in found}
    known = [f for f in cutoffs.values() if math.isfinite(f)]
    about = f" at about {float(np.median(known)):.2g} Hz" if known else ""
    words = (
        f"{', '.join(cutoffs)} appear{'s' if len(cutoffs) == 1 else ''} to be low-pass "
        f"filtered{about}; the noise of a frame before the filter cannot be estimated."
    )
    numbers = {"cutoff_hz": cutoffs, "top_to_pass_band": {one.series: one.ratio for one in found}}
    return [Sentence("low_pass", "warning", tuple(cutoffs), words, numbers)]


def level_words(found: Sequence[Trend]) -> list[Sentence]:
    """One over all series that fall, that rise, and that come back."""
    told = []
    for word in ("falls", "rises", "changes"):
        own = [t for t in found if t.direction == word]
        if not own:
            continue
        names = tuple(t.series for t in own)
        worst = max(own, key=lambda t: t.extent)
        if word == "changes":
            least, most = (percent(v, 2, sign=True) for v in (worst.least, worst.greatest))
            how = f"slowly, by {least} to {most} from its level at "
            how += f"the start ({worst.series})"
        else:
            ends = (percent(v, sign=True) for v in (worst.lower, worst.upper))
            how = f"by {percent(abs(worst.change))} over the recording ({worst.series}; 95 %: "
            how += f"{' to '.join(ends)})"
        words = f"Noise of {', '.join(names)} {word} {how}."
        numbers = {"change": {t.series: t.change for t in own}}
        told.append(Sentence("level", severity(worst.matters), names, words, numbers))
    return told


def tail_words(found: Sequence[Tails]) -> list[Sentence]:
    if not found:
        return []
    worst = max(found, key=lambda t: t.excess)
    names = tuple(t.series for t in found)
    words = (
        f"Noise of {', '.join(names)} has heavy tails: the differences of frames have an excess "
        f"kurtosis of up to {worst.excess:.2g} ({worst.series}; Gaussian noise: 0)."
    )
    return [
        Sentence("tails", "info", names, words, {"excess": {t.series: t.excess for t in found}})
    ]


def filled_words(recording: Recording) -> list[Sentence]:
    told = []
    for k, label in enumerate(recording.labels, start=1):
        share = recording.n_filled.get(label, 0) / recording.n_frames
        if share:
            words = (
                f"{percent(share)} of the frames of {label} are gap-filled: they show less noise "
                "than is possible. They are excluded as missing."
            )
            names = tuple(f"{axis}{k}" for axis in AXES)
            told.append(
                Sentence("filled", severity(share > MANY_FILLED), names, words, {"share": share})
            )
    return told


def solved_words(solved: Mapping[str, float]) -> list[Sentence]:
    """One of all distances within rigid bodies."""
    if not solved:
        return []
    words = (
        f"Solved by the software: {', '.join(solved)} is not measured, as its markers keep the "
        "distance that a rigid body has. Export the markers as they were reconstructed."
    )
    return [Sentence("solved", "warning", tuple(solved), words, {"ratio": dict(solved)})]


def exchanged_words(recording: Recording) -> list[Sentence]:
    """One a pair of markers."""
    told = []
    for one in recording.exchanged:
        ends = [moment(one[k] / recording.frame_rate_hz) for k in ("first", "last")]
        words = (
            f"The labels of {' and '.join(one['labels'])} are exchanged in {one['n_frames']} "
            f"frames between {ends[0]} and {ends[1]}: each is where the other was. They are put "
            "right here."
        )
        numbers = [recording.labels.index(label) + 1 for label in one["labels"]]
        names = tuple(f"{axis}{k}" for k in numbers for axis in AXES)
        told.append(Sentence("exchanged", "warning", names, words, dict(one)))
    return told


def processed_words(found: Sequence[Processed], rate_hz: float) -> list[Sentence]:
    """One a kind."""
    told = []
    for code in dict.fromkeys(one.code for one in found):
        own = {one.series: one.value for one in found if one.code == code}
        words = {
            "smoothed": "have no white noise: the software smoothed them, as far as can be told. "
            "The noise of a measured frame cannot be estimated",
            "resampled": "were interpolated to another frame rate: the variance of their frames "
            f"varies with {next(iter(own.values())):.4g} Hz, so they were measured at "
            f"{rate_hz - next(iter(own.values())):.4g} or {next(iter(own.values())):.4g} Hz",
            "running_median": "are running medians: their values repeat, each coordinate's for "
            "itself",
        }[code]
        words = f"{', '.join(own)} {words}. Export unprocessed frames."
        told.append(Sentence(code, "warning", tuple(own), words, {"value": own}))
    return told


def repeated_words(found: Sequence[Repeats], recording: Recording) -> list[Sentence]:
    """One a marker that repeats its position."""
    said = []
    for one in found:
        k = list(recording.labels).index(one.label) + 1
        longest = one.longest / recording.frame_rate_hz
        words = (
            f"{one.label} repeats its position exactly in {percent(one.share)} of the frames, for "
            f"up to {longest:.2g} s, and then jumps by {mm(one.change_mm)}: it was filtered or "
            "gap-filled before the export."
        )
        names = tuple(f"{axis}{k}" for axis in AXES)
        numbers = {"share": one.share, "longest_s": longest, "change_mm": one.change_mm}
        said.append(Sentence("repeated", "warning", names, words, numbers))
    return said
