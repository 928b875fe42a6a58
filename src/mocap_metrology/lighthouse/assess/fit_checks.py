"""Checks of a recording and of the fit to it, each with the best word a verdict can then have."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from mocap_metrology.lighthouse.records import PoseEstimate
from mocap_metrology.lighthouse.timing import CYCLE_S

WORDS = ("good", "usable", "doubtful", "failed")
JITTER_URAD = 61.0  # of one angle: 53 common to a sweep, 30 of each diode
EXPECTED_URAD = 75.0  # with 38 by the two edges of a pulse at 2 MHz
# Residual over the expected one: (usable from, doubtful from). A board on its way adds what the
# interpolation of its path misses.
RESIDUAL = {"static": (2.0, 6.0), "kabsch": (10.0, 40.0), "final": (5.0, 30.0)}
RESIDUAL_FAILED = 100.0  # over the expected one: no pose fits
# Over the noise, errors of board poses taken out. Sound ones reach 1.2, lasers 15 mm off 1.3; of a
# mirrored deep board a pose 5 m and 76° off can leave as little as 13 (of 50, the next 13.6).
WEIGHTED_FAILED = 10.0
USUAL_GAIN = 4.0  # of a board of 20 cm; errors of a smaller one's poses raise what is expected
FARTHEST_M = 20.0  # no station is seen from farther
BOARD = (1.2, 3.0)  # over the noise of an angle
MIRRORED = (0.01, 0.05)
MIRRORED_FAILED = 0.5
COMMON = (200, 50)  # usable below, doubtful below
SPAN_M = (0.3, 0.1)
CHI2_6 = 22.46  # of six degrees of freedom, exceeded with probability 0.001
WEIGHTED = 1.3  # over the noise, errors of board poses taken out: sound ones reach 1.2 by tremor
# Reported standard deviations are too small by 3 to 5, as blocks of time share their time zeros.
# Of that a difference of two parts keeps less: sound ones reach 35, a station moved by 5 mm 150.
HALVES_M2 = (2**2 * CHI2_6, 5**2 * CHI2_6)
SIGMA = ((5.0, 0.1), (20.0, 0.5))  # mm, deg: largest axis
USUAL_S, USUAL_LONGEST_S, SHORT_S = 8.0, 8.4, 4.0  # 8.389 s is the memory of J's board


@dataclass(frozen=True)
class Check:
    """One check. ok None: not applicable or not known; level: the best word a verdict can have
    with it; limit: of `value`, for the next worse word; sentence: for a reader."""

    name: str
    value: float | int | str | None
    unit: str
    limit: float | int | str | None
    ok: bool | None
    level: str
    sentence: str

    def as_row(self) -> dict[str, Any]:
        """For a table or JSON."""
        return asdict(self)


def graded(value: float, limits: Sequence[float]) -> tuple[str, float]:
    """Word of a value that had better be small, and the limit of the next worse word."""
    usable, doubtful = limits
    if not value >= usable:
        return "good", usable
    return ("usable" if value < doubtful else "doubtful"), doubtful


def graded_low(value: float, limits: Sequence[float]) -> tuple[str, float]:
    """Word of a value that had better be large, and the limit of the next worse word."""
    usable, doubtful = limits
    if value >= usable:
        return "good", usable
    return ("usable" if value >= doubtful else "doubtful"), doubtful


def worst(mm: float, deg: float, limits: Sequence[tuple[float, float]]) -> tuple[str, str]:
    """Word of a distance and an angle with limits for both, and the limits as text."""
    first, second = limits
    word = max(
        (graded(v, (first[k], second[k]))[0] for k, v in enumerate((mm, deg))), key=WORDS.index
    )
    shown = first if word == "good" else second
    return word, f"{shown[0]:g} mm, {shown[1]:g}°"


def unknown(name: str, unit: str, sentence: str, level: str = "good") -> Check:
    """A check that does not apply, or of something not known."""
    return Check(name, None, unit, None, None, level, sentence)


def expected_noise_urad(resolution_s: float | None) -> float:
    """Noise of one angle by jitter and by the clock's steps at both edges of a pulse, urad."""
    if resolution_s is None:
        return EXPECTED_URAD
    step = 1e6 * math.pi * resolution_s / CYCLE_S
    return math.hypot(JITTER_URAD, step / math.sqrt(24))


def distance(chosen: PoseEstimate) -> Check:
    """Farther than stations can be: a search that ran away."""
    value = float(np.linalg.norm(chosen.t_m))
    ok = value <= FARTHEST_M
    sentence = f"The stations are {value:.3g} m apart" + (
        "." if ok else f", farther than any board sees both (at most {FARTHEST_M:g} m)."
    )
    return Check("distance", value, "m", FARTHEST_M, ok, "good" if ok else "failed", sentence)


def residual(chosen: PoseEstimate, noise: float) -> Check:
    """Residual of the fit; of a small board what the errors of its poses make of it is expected."""
    value, expected, small = chosen.residual_rms_urad, noise, ""
    if not math.isfinite(value):
        return unknown("residual", "urad", "The residual of the fit is unknown.", "usable")
    if chosen.noise_gain > USUAL_GAIN:
        expected = noise * chosen.noise_gain / USUAL_GAIN
        made = noise * chosen.noise_gain
        small = f" (errors of the board's poses alone make {made:.0f} µrad of it)"
    word, limit = graded(value / expected, RESIDUAL[chosen.stage])
    lost = chosen.weighted_rms_urad > WEIGHTED_FAILED * noise
    if lost or not value < RESIDUAL_FAILED * expected:
        word, limit = "failed", RESIDUAL_FAILED
    sentence = (
        f"Angles are {value:.0f} µrad rms from the fit; the noise of an angle is"
        f" {noise:.0f}{small}, good is below {limit * expected:.0f}."
    )
    if word != "good":
        sentence = (
            f"Angles are {value:.0f} µrad rms from the fit, {value / noise:.0f} times the noise"
            f" of an angle{small}, as by wrong optics (factory values, lasers off the housing's"
            " origin), a wrong board file, reflections or board poses in the wrong minimum."
        )
    return Check("residual", value, "urad", limit * expected, word == "good", word, sentence)


def weighted(chosen: PoseEstimate, noise: float) -> Check:
    """What errors of the board's path do not explain."""
    name, value, limit = "angles beyond the path", chosen.weighted_rms_urad, WEIGHTED * noise
    if not math.isfinite(value):
        return unknown(name, "urad", "Errors of the board's path were not told apart.")
    ok = value < limit
    sentence = f"Errors of the board's path leave {value:.0f} µrad of the residual unexplained"
    sentence += (
        "."
        if ok
        else f" (noise of an angle: {noise:.0f}), as by a station that was touched, a wrong board"
        " file or wrong optics."
    )
    return Check(name, value, "urad", limit, ok, "good" if ok else "usable", sentence)


def halves(chosen: PoseEstimate) -> Check:
    """A station that was moved meanwhile: before and after have different poses."""
    name, parts = "halves agree", chosen.halves
    if parts is None or not math.isfinite(parts.m2):
        return unknown(name, "", "Parts of the recording were not held against each other.")
    word, limit = graded(parts.m2, HALVES_M2)
    sentence = f"Parts of the recording differ by {parts.mm:.2g} mm and {parts.deg:.2g}°" + (
        ", as chance allows."
        if word == "good"
        else f", {math.sqrt(parts.m2 / 6):.0f} times what noise explains: was a station touched"
        " meanwhile?"
    )
    return Check(name, parts.m2, "", limit, word == "good", word, sentence)


def mirrored(chosen: PoseEstimate) -> Check:
    share, name = chosen.mirrored_share, "mirrored board poses"
    if not math.isfinite(share):
        return unknown(name, "", "The share of mirrored board poses was not determined.")
    word, limit = graded(share, MIRRORED)
    if share > MIRRORED_FAILED:
        word, limit = "failed", MIRRORED_FAILED
    sentence = f"{100 * share:.2g} % of the board poses are mirrored"
    if word == "good":
        sentence += "."
    elif chosen.estimator == "paper-lm":
        sentence += (
            " or wrong in another way, though both stations decided: is the board file right (and"
            " no mirror image)? Use a larger board, or one with depth."
        )
    else:
        sentence += ", as a flat board allows: use `paper-lm`, which lets both stations decide."
    return Check(name, share, "", limit, word == "good", word, sentence)


def motion(chosen: PoseEstimate) -> Check:
    """Whether the board moved."""
    moved = chosen.stage != "static"
    sentence = (
        "The board moved."
        if moved
        else "The board did not move: the pose stands on one place of the board, whose size limits"
        " it. Record again with the board moved through the room."
    )
    return Check(
        "motion", chosen.stage, "", "moving", moved, "good" if moved else "usable", sentence
    )


def common_measurements(chosen: PoseEstimate, n_common: int | None) -> Check:
    """Moments at which both stations saw the board."""
    name = "common measurements"
    if n_common is None or chosen.stage == "static":
        return unknown(name, "", "No common measurements are needed of a board at rest.")
    word, limit = graded_low(n_common, COMMON)
    sentence = f"Both stations saw the board at {n_common} moments" + (
        "." if word == "good" else ", few for a pose: keep the board in the view of both."
    )
    return Check(name, n_common, "", limit, word == "good", word, sentence)


def board_poses(board_rms_urad: float | None, expected: float) -> Check:
    """K_1 of single board poses: what a wrong board file or reflections raise, and motion or the
    optics of the other station do not."""
    name = "board poses"
    if board_rms_urad is None:
        return unknown(name, "urad", "There are no board poses.")
    word, limit = graded(board_rms_urad / expected, BOARD)
    sentence = f"Angles of single board poses are {board_rms_urad:.0f} µrad rms from their fit"
    sentence += "." if word == "good" else ": is the board file right, are there reflections?"
    return Check(name, board_rms_urad, "urad", limit * expected, word == "good", word, sentence)


def path(chosen: PoseEstimate, span_m: float | None) -> Check:
    """Length of the board's path."""
    if chosen.stage == "final" and chosen.estimator == "paper-lm":
        return unknown("path", "m", "The last stage does not lean on the length of the path.")
    if span_m is None or chosen.stage == "static":
        return unknown("path", "m", "There is no path of a board at rest.")
    word, limit = graded_low(span_m, SPAN_M)
    sentence = f"The board went {span_m:.2g} m" + (
        "." if word == "good" else " only: a short path leaves the slave's rotation uncertain."
    )
    return Check("path", span_m, "m", limit, word == "good", word, sentence)


def uncertainty(chosen: PoseEstimate) -> Check:
    """The worst axes of the covariance."""
    name = "uncertainty"
    if chosen.covariance is None:
        return unknown(name, "mm", "There is no covariance of this estimate.")
    sd = np.sqrt(np.diag(chosen.covariance))
    mm, deg = float(sd[:3].max()), float(sd[3:].max())
    word, limit = worst(mm, deg, SIGMA) if np.isfinite(sd).all() else ("doubtful", "finite")
    sentence = (
        f"One standard deviation is {mm:.2g} mm and {deg:.2g}° in the worst axes; an error of"
        " scale in the board file is not in it and scales the distance."
    )
    return Check(name, mm, "mm", limit, word == "good", word, sentence)


def duration(duration_s: float | None) -> Check:
    """Length of the recording."""
    if duration_s is None:
        return unknown("duration", "s", "The duration is unknown.")
    usual = USUAL_S - 0.01 <= duration_s <= USUAL_LONGEST_S
    short = duration_s < SHORT_S
    sentence = f"The recording lasts {duration_s:.3g} s" + (
        "." if usual else f", not the usual {USUAL_S:g} s{': few measurements' if short else ''}."
    )
    level = "usable" if short else "good"
    return Check("duration", duration_s, "s", SHORT_S, not short, level, sentence)
