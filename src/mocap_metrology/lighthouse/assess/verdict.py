"""How far a calibration can be trusted: named checks, and one word for all of them.

A low residual alone proves nothing: with ideal optics a fit that is 70 mm and 2° off has a
residual of 0.06-0.3 mrad. So the checks ask for what fits cannot show, too: factory values,
mirrored board poses, the way the board went, gravity, and whether stages and optics agree.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.variants import Weighed, steps
from mocap_metrology.lighthouse.records import ROLES, PoseEstimate, Station
from mocap_metrology.lighthouse.timing import CYCLE_S

WORDS = ("good", "usable", "doubtful", "failed")
JITTER_URAD = 61.0  # of one angle: 53 common to a sweep, 30 of each diode
EXPECTED_URAD = 75.0  # with 38 by the two edges of a pulse at 2 MHz
# Residual over the expected one: (usable from, doubtful from). A board on its way adds what the
# interpolation of its path misses.
RESIDUAL = {"static": (2.0, 6.0), "kabsch": (10.0, 40.0), "final": (5.0, 30.0)}
RESIDUAL_FAILED = 100.0  # over the expected one: no pose fits
WEIGHTED_FAILED = 20.0  # over the noise, errors of board poses taken out; sound ones reach 2
USUAL_GAIN = 4.0  # of a board of 20 cm; errors of a smaller one's poses raise what is expected
FARTHEST_M = 20.0  # no station is seen from farther
BOARD = (1.2, 3.0)  # over the noise of an angle
MIRRORED = (0.01, 0.05)
MIRRORED_FAILED = 0.5
COMMON = (200, 50)  # usable below, doubtful below
SPAN_M = (0.3, 0.1)
STAGES_APART = ((20.0, 0.5), (60.0, 2.0))  # mm, deg
CHI2_6 = 22.46  # of six degrees of freedom, exceeded with probability 0.001
WEIGHTED = 1.3  # over the noise, errors of board poses taken out: sound ones reach 1.2 by tremor
# Reported standard deviations are too small by 3 to 5, as blocks of time share their time zeros.
# Of that a difference of two parts keeps less: sound ones reach 35, a station moved by 5 mm 150.
HALVES_M2 = (2**2 * CHI2_6, 5**2 * CHI2_6)
OPTICS_APART = (500.0, 10.0)  # what factory values can change at most
GRAVITY_SD_DEG = 1.5  # of either component of the difference: sound real pairs differ by 1-2.5
# Doubtful where one sound pair in 200 is, failed where none in 1e9 is (Rayleigh's distribution).
GRAVITY_DEG = tuple(GRAVITY_SD_DEG * math.sqrt(-2 * math.log(p)) for p in (5e-3, 1e-9))
SIGMA = ((5.0, 0.1), (20.0, 0.5))  # mm, deg: largest axis
REFERENCE = ((30.0, 2.0), (100.0, 5.0))
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


class Verdict(NamedTuple):
    """One of `WORDS`, one or two sentences, and the checks behind them."""

    word: str
    reason: str
    checks: tuple[Check, ...] = ()


def expected_noise_urad(resolution_s: float | None) -> float:
    """Noise of one angle by jitter and by the clock's steps at both edges of a pulse, urad."""
    if resolution_s is None:
        return EXPECTED_URAD
    step = 1e6 * math.pi * resolution_s / CYCLE_S
    return math.hypot(JITTER_URAD, step / math.sqrt(24))


def verdict(
    chosen: PoseEstimate | None,
    poses: Sequence[PoseEstimate],
    stations: Sequence[Station],
    *,
    n_common: int | None = None,
    span_m: float | None = None,
    duration_s: float | None = None,
    expected_urad: float = EXPECTED_URAD,
    board_rms_urad: float | None = None,
    errors: tuple[np.ndarray, np.ndarray] | None = None,
    variants: Sequence[Weighed] = (),
    why_none: str = "",
) -> Verdict:
    """Verdict on the pose `chosen` out of `poses`.

    stations: master first; n_common: moments with a board pose of both stations; span_m: largest
    distance between two places of the board's path, or about it; duration_s: of the recording;
    expected_urad: noise of one angle; board_rms_urad: angles about single board poses; errors: mm
    and deg against a reference, see `reference`; variants: of the rotor model, as the recording
    weighed them; why_none: the reason where nothing was chosen.
    """
    if chosen is None or not (np.isfinite(chosen.R).all() and np.isfinite(chosen.t_m).all()):
        return Verdict("failed", why_none or "No pose of the slave was found.")
    checks = (
        _distance(chosen),
        _residual(chosen, expected_urad),
        _factory(chosen, stations),
        _rotor_model(chosen, variants),
        _mirrored(chosen),
        _stage(chosen),
        _common(chosen, n_common),
        _board(board_rms_urad, expected_urad),
        _span(chosen, span_m),
        *_agreements(chosen, poses),
        _gravity(chosen, stations),
        _weighted(chosen, expected_urad),
        _halves(chosen),
        _sigma(chosen),
        _duration(duration_s),
        _against_reference(errors),
    )
    word = max((c.level for c in checks), key=WORDS.index)
    return Verdict(word, _reason(word, checks), checks)


def _reason(word: str, checks: Sequence[Check]) -> str:
    """The sentences of the checks that made the word, then what else was found, in short."""
    models = [c.sentence for c in checks if c.name == "rotor model" and c.ok is False]
    if word == "good":
        passed = sum(c.ok is True for c in checks)
        said = [c.sentence for c in checks if c.ok and c.name in ("residual", "uncertainty")]
        return " ".join([f"All {passed} checks passed.", *said, *models])
    bad = [c for c in checks if c.level == word]
    rest = [*bad[2:], *(c for c in checks if c.level not in (word, "good"))]
    more = (c.sentence.split(", as by ")[0].rstrip(".") + "." for c in rest)
    return " ".join([*(c.sentence for c in bad[:2]), *more, *models])


def _graded(value: float, limits: Sequence[float]) -> tuple[str, float]:
    """Word of a value that had better be small, and the limit of the next worse word."""
    usable, doubtful = limits
    if not value >= usable:
        return "good", usable
    return ("usable" if value < doubtful else "doubtful"), doubtful


def _graded_low(value: float, limits: Sequence[float]) -> tuple[str, float]:
    """Word of a value that had better be large, and the limit of the next worse word."""
    usable, doubtful = limits
    if value >= usable:
        return "good", usable
    return ("usable" if value >= doubtful else "doubtful"), doubtful


def _worst(mm: float, deg: float, limits: Sequence[tuple[float, float]]) -> tuple[str, str]:
    """Word of a distance and an angle with limits for both, and the limits as text."""
    first, second = limits
    word = max(
        (_graded(v, (first[k], second[k]))[0] for k, v in enumerate((mm, deg))), key=WORDS.index
    )
    shown = first if word == "good" else second
    return word, f"{shown[0]:g} mm, {shown[1]:g}°"


def _unknown(name: str, unit: str, sentence: str, level: str = "good") -> Check:
    return Check(name, None, unit, None, None, level, sentence)


def _distance(chosen: PoseEstimate) -> Check:
    """Farther than stations can be: a search that ran away."""
    value = float(np.linalg.norm(chosen.t_m))
    ok = value <= FARTHEST_M
    sentence = f"The stations are {value:.3g} m apart" + (
        "." if ok else f", farther than any board sees both (at most {FARTHEST_M:g} m)."
    )
    return Check("distance", value, "m", FARTHEST_M, ok, "good" if ok else "failed", sentence)


def _residual(chosen: PoseEstimate, noise: float) -> Check:
    """Residual of the fit; of a small board what the errors of its poses make of it is expected."""
    value, expected, small = chosen.residual_rms_urad, noise, ""
    if not math.isfinite(value):
        return _unknown("residual", "urad", "The residual of the fit is unknown.", "usable")
    if chosen.noise_gain > USUAL_GAIN:
        expected = noise * chosen.noise_gain / USUAL_GAIN
        small = f", which poses of so small a board make {noise * chosen.noise_gain:.0f}"
    word, limit = _graded(value / expected, RESIDUAL[chosen.stage])
    lost = chosen.weighted_rms_urad > WEIGHTED_FAILED * noise
    if lost or not value < RESIDUAL_FAILED * expected:
        word, limit = "failed", RESIDUAL_FAILED
    sentence = (
        f"Angles are {value:.0f} µrad rms from the fit (noise of an angle: {noise:.0f}{small}; good"
        f" below {limit * expected:.0f})."
    )
    if word != "good":
        sentence = (
            f"Angles are {value:.0f} µrad rms from the fit, {value / noise:.0f} times the noise"
            f" of an angle{small}, as by wrong optics (factory values, lasers off the housing's"
            " origin), a wrong board file, reflections or board poses in the wrong minimum."
        )
    return Check("residual", value, "urad", limit * expected, word == "good", word, sentence)


def _weighted(chosen: PoseEstimate, noise: float) -> Check:
    """What errors of the board's path do not explain."""
    name, value, limit = "angles beyond the path", chosen.weighted_rms_urad, WEIGHTED * noise
    if not math.isfinite(value):
        return _unknown(name, "urad", "Errors of the board's path were not told apart.")
    ok = value < limit
    sentence = f"Errors of the board's path leave {value:.0f} µrad of the residual unexplained"
    sentence += (
        "."
        if ok
        else f" (noise of an angle: {noise:.0f}), as by a station that was touched, a wrong board"
        " file or wrong optics."
    )
    return Check(name, value, "urad", limit, ok, "good" if ok else "usable", sentence)


def _halves(chosen: PoseEstimate) -> Check:
    """A station that was moved meanwhile: before and after have different poses."""
    name, parts = "halves agree", chosen.halves
    if parts is None or not math.isfinite(parts.m2):
        return _unknown(name, "", "Parts of the recording were not held against each other.")
    word, limit = _graded(parts.m2, HALVES_M2)
    sentence = f"Parts of the recording differ by {parts.mm:.2g} mm and {parts.deg:.2g}°" + (
        ", as chance allows."
        if word == "good"
        else f", {math.sqrt(parts.m2 / 6):.0f} times what noise explains: was a station touched"
        " meanwhile?"
    )
    return Check(name, parts.m2, "", limit, word == "good", word, sentence)


def _factory(chosen: PoseEstimate, stations: Sequence[Station]) -> Check:
    """Errors by neglected factory values do not show in any fit (facts of eight real stations)."""
    name, limit = "factory values", "of both stations, from the recording"
    if chosen.optics != "factory":
        reasons = [
            f"{role}: {station.why or 'none found'}"
            for role, station in zip(ROLES, stations, strict=True)
            if station.factory is None
        ]
        known = f" ({'; '.join(reasons)})" if reasons else " (not used)"
        sentence = (
            f"Ideal optics, without the stations' factory values{known}: the pose is 2 to"
            " 20 cm and 1 to 6° off for real stations, and no residual shows it."
        )
        return Check(name, "ideal", "", limit, False, "doubtful", sentence)
    filed = [r for r, s in zip(ROLES, stations, strict=True) if s.frames_found == 0]
    if filed:
        sentence = (
            f"Factory values of the {' and '.join(filed)} come from a calibration file, not from"
            " the recording: they are right only if the file is of this very station."
        )
        return Check(name, "file", "", limit, False, "usable", sentence)
    return Check(name, "recording", "", limit, True, "good", "Factory values from the recording.")


def _rotor_model(chosen: PoseEstimate, variants: Sequence[Weighed]) -> Check:
    """Drivers differ in what factory values mean; their difference is in the covariance."""
    name = "rotor model"
    if chosen.optics != "factory" or not variants:
        return _unknown(name, "mm", "The recording was not asked for the model of the rotors.")
    taken = next(w.variant for w in variants if w.standing == "chosen")
    left = [w.variant for w in variants if w.standing == "open"]
    if not left:
        sentence = f"The recording prefers the rotor model of {taken} beyond chance."
        return Check(name, 0.0, "mm", None, True, "good", sentence)
    off = steps(variants)
    mm, deg = (float(np.linalg.norm(part, axis=1).max()) for part in (off[:, :3], off[:, 3:]))
    sentence = (
        f"The recording cannot tell the rotor models of {taken} and {' or '.join(left)} apart;"
        f" their poses differ by up to {mm:.2g} mm and {deg:.2g}°, which the uncertainty contains."
    )
    return Check(name, mm, "mm", None, False, "good", sentence)


def _mirrored(chosen: PoseEstimate) -> Check:
    share, name = chosen.mirrored_share, "mirrored board poses"
    if not math.isfinite(share):
        return _unknown(name, "", "The share of mirrored board poses was not determined.")
    word, limit = _graded(share, MIRRORED)
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


def _stage(chosen: PoseEstimate) -> Check:
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


def _common(chosen: PoseEstimate, n_common: int | None) -> Check:
    name = "common measurements"
    if n_common is None or chosen.stage == "static":
        return _unknown(name, "", "No common measurements are needed of a board at rest.")
    word, limit = _graded_low(n_common, COMMON)
    sentence = f"Both stations saw the board at {n_common} moments" + (
        "." if word == "good" else ", few for a pose: keep the board in the view of both."
    )
    return Check(name, n_common, "", limit, word == "good", word, sentence)


def _board(board_rms_urad: float | None, expected: float) -> Check:
    """K_1 of single board poses: what a wrong board file or reflections raise, and motion or the
    optics of the other station do not."""
    name = "board poses"
    if board_rms_urad is None:
        return _unknown(name, "urad", "There are no board poses.")
    word, limit = _graded(board_rms_urad / expected, BOARD)
    sentence = f"Angles of single board poses are {board_rms_urad:.0f} µrad rms from their fit"
    sentence += "." if word == "good" else ": is the board file right, are there reflections?"
    return Check(name, board_rms_urad, "urad", limit * expected, word == "good", word, sentence)


def _span(chosen: PoseEstimate, span_m: float | None) -> Check:
    if chosen.stage == "final" and chosen.estimator == "paper-lm":
        return _unknown("path", "m", "The last stage does not lean on the length of the path.")
    if span_m is None or chosen.stage == "static":
        return _unknown("path", "m", "There is no path of a board at rest.")
    word, limit = _graded_low(span_m, SPAN_M)
    sentence = f"The board went {span_m:.2g} m" + (
        "." if word == "good" else " only: a short path leaves the slave's rotation uncertain."
    )
    return Check("path", span_m, "m", limit, word == "good", word, sentence)


def apart(a: PoseEstimate, b: PoseEstimate) -> tuple[float, float]:
    """Distance in mm and angle in deg between two poses."""
    angle = np.linalg.norm(rotation.error(a.R, b.R))
    return 1e3 * float(np.linalg.norm(a.t_m - b.t_m)), float(np.degrees(angle))


def _agreements(chosen: PoseEstimate, poses: Sequence[PoseEstimate]) -> Iterator[Check]:
    """The other stage, and the other optics, of the same estimator."""
    other = {"kabsch": "final", "final": "kabsch"}.get(chosen.stage)
    own = [p for p in poses if p.estimator == chosen.estimator]
    for p in own:
        if (p.stage, p.optics) == (other, chosen.optics):
            mm, deg = apart(chosen, p)
            word, limit = _worst(mm, deg, STAGES_APART)
            sentence = f"Kabsch and final stage are {mm:.3g} mm and {deg:.2g}° apart."
            if word != "good" and _within_noise(chosen, p):
                word = "good"
                sentence += " Kabsch is no surer than that on such a path."
            yield Check("stages agree", mm, "mm", limit, word == "good", word, sentence)
        if p.stage == chosen.stage and p.optics != chosen.optics:
            mm, deg = apart(chosen, p)
            word, limit = _worst(mm, deg, (OPTICS_APART, OPTICS_APART))
            sentence = f"Factory values change the pose by {mm:.3g} mm and {deg:.2g}°" + (
                "." if word == "good" else ", more than those of a first-generation station can."
            )
            yield Check("optics agree", mm, "mm", limit, word == "good", word, sentence)


def _within_noise(a: PoseEstimate, b: PoseEstimate) -> bool:
    """Whether two poses differ by less than their covariances allow, one time in a thousand."""
    if a.covariance is None or b.covariance is None:
        return False
    off = np.r_[1e3 * (a.t_m - b.t_m), np.degrees(rotation.error(a.R, b.R))]
    return bool(off @ np.linalg.pinv(a.covariance + b.covariance) @ off < CHI2_6)


def gravity_angle_deg(R: np.ndarray, stations: Sequence[Station]) -> float:
    """Angle in deg between R g_slave and g_master; NaN where a station told none."""
    up = [s.gravity for s in stations]
    if any(g is None or not np.linalg.norm(g) > 0 for g in up):
        return math.nan
    master, slave = (np.asarray(g) / np.linalg.norm(g) for g in up)
    turned = R @ slave
    return math.degrees(math.atan2(np.linalg.norm(np.cross(turned, master)), turned @ master))


def _gravity(chosen: PoseEstimate, stations: Sequence[Station]) -> Check:
    value = gravity_angle_deg(chosen.R, stations)
    if not math.isfinite(value):
        return _unknown("gravity", "deg", "No gravity from both stations to compare with.")
    word = "good" if value < GRAVITY_DEG[0] else "doubtful" if value < GRAVITY_DEG[1] else "failed"
    limit = GRAVITY_DEG[0] if word == "good" else GRAVITY_DEG[1]
    cause = "" if chosen.optics == "factory" else " Neglected factory values alone can be 4°."
    sentence = (
        f"Up as both stations feel it agrees within {value:.1f}°."
        if word == "good"
        else f"Up as both stations feel it differs by {value:.1f}° in this pose.{cause}"
    )
    return Check("gravity", value, "deg", limit, word == "good", word, sentence)


def _sigma(chosen: PoseEstimate) -> Check:
    name = "uncertainty"
    if chosen.covariance is None:
        return _unknown(name, "mm", "There is no covariance of this estimate.")
    sd = np.sqrt(np.diag(chosen.covariance))
    mm, deg = float(sd[:3].max()), float(sd[3:].max())
    word, limit = _worst(mm, deg, SIGMA) if np.isfinite(sd).all() else ("doubtful", "finite")
    sentence = (
        f"One standard deviation is {mm:.2g} mm and {deg:.2g}° in the worst axes; an error of"
        " scale in the board file is not in it and scales the distance."
    )
    return Check(name, mm, "mm", limit, word == "good", word, sentence)


def _duration(duration_s: float | None) -> Check:
    if duration_s is None:
        return _unknown("duration", "s", "The duration is unknown.")
    usual = USUAL_S - 0.01 <= duration_s <= USUAL_LONGEST_S
    short = duration_s < SHORT_S
    sentence = f"The recording lasts {duration_s:.3g} s" + (
        "." if usual else f", not the usual {USUAL_S:g} s{': few measurements' if short else ''}."
    )
    level = "usable" if short else "good"
    return Check("duration", duration_s, "s", SHORT_S, not short, level, sentence)


def _against_reference(errors: tuple[np.ndarray, np.ndarray] | None) -> Check:
    if errors is None:
        return _unknown("reference", "mm", "There is no reference.")
    mm, deg = (float(np.linalg.norm(e)) for e in errors)
    word, limit = _worst(mm, deg, REFERENCE)
    sentence = f"The pose is {mm:.3g} mm and {deg:.2g}° from the reference."
    return Check("reference", mm, "mm", limit, word == "good", word, sentence)
