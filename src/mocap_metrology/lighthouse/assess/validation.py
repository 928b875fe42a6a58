"""How far a calibration can be trusted: named checks, and one word for all of them.

A low residual alone proves nothing: with ideal optics a fit that is 70 mm and 2° off has a
residual of 0.06-0.3 mrad. So further checks cover what no fit shows: factory
values, the rotor model, other stages and optics, gravity, and what a lab measured.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess import fit_checks
from mocap_metrology.lighthouse.assess.fit_checks import WORDS, Case, Check, judged, unknown, worst
from mocap_metrology.lighthouse.calibrate.variants import VariantFit, steps
from mocap_metrology.lighthouse.records import PoseEstimate, Station

STAGES_APART = ((20.0, 0.5), (60.0, 2.0))  # mm, deg
OPTICS_APART = (500.0, 10.0)  # what factory values can change at most
GRAVITY_SD_DEG = 1.5  # of either component of the difference: sound real pairs differ by 1-2.5
# Doubtful where one sound pair in 200 is, failed where none in 1e9 is (Rayleigh's distribution).
GRAVITY_DEG = tuple(GRAVITY_SD_DEG * math.sqrt(-2 * math.log(p)) for p in (5e-3, 1e-9))
RIVALS = ("board and optics", "board poses", "gravity")  # fail where halves differ by no touch
REFERENCE = ((30.0, 2.0), (100.0, 5.0))


def factory(
    chosen: PoseEstimate,
    stations: Sequence[Station],
    exchanged: Sequence[str] = (),
    doubted: bool = False,
    unseen: bool = False,
) -> Check:
    """Errors by neglected factory values do not show in any fit (facts of eight real stations);
    exchanged: stations of any pair whose values fit better exchanged; doubted: pieces of the
    recording contradict each other, or all of it the board, as with another station's values;
    unseen: as `fit_checks.optics_hidden`."""
    value, names, why = "file", tuple[str, ...](), dict[str, str]()
    if chosen.optics != "factory":
        value = chosen.optics
        why = {station.role: station.why for station in stations if station.factory is None}
        estimated = value == "estimated"
        case, level = (Case.ESTIMATED, "usable") if estimated else (Case.IDEAL, "doubtful")
    elif any(station.role in exchanged for station in stations):
        case, level, names = Case.FACTORY_EXCHANGED, "doubtful", tuple(exchanged)
    elif filed := tuple(s.role for s in stations if s.frames_found == 0):
        case, level, names = Case.FACTORY_FILE, "usable", filed
        if doubted:
            case, level = Case.FACTORY_DOUBTED, "doubtful"
        elif unseen:
            case = Case.FACTORY_UNSEEN
    else:
        case, level, value = Case.FACTORY, "good", "recording"
    limit, ok = "of both stations, from the recording", case is Case.FACTORY
    return Check("factory values", case, value, "", limit, ok, level, names=names, why=why)


def rotor_model(chosen: PoseEstimate, variants: Sequence[VariantFit]) -> Check:
    """Drivers differ in what factory values mean; their difference is in the covariance."""
    name = "rotor model"
    if chosen.optics != "factory" or not variants:
        return unknown(name, Case.ROTOR_UNASKED, "mm")
    taken = next(w.variant for w in variants if w.standing == "chosen")
    left = [w.variant for w in variants if w.standing == "open"]
    if not left:
        return Check(name, Case.ROTOR_CLEAR, 0.0, "mm", None, True, "good", names=(taken,))
    off = steps(variants)
    mm, deg = (float(np.linalg.norm(part, axis=1).max()) for part in (off[:, :3], off[:, 3:]))
    names = (taken, *left)
    return Check(name, Case.ROTOR_OPEN, mm, "mm", None, False, "good", {"deg": deg}, names)


def pose_distance(a: PoseEstimate, b: PoseEstimate) -> tuple[float, float]:
    """Distance in mm and angle in deg between two poses."""
    angle = np.linalg.norm(rotation.error(a.R, b.R))
    return 1e3 * float(np.linalg.norm(a.t_m - b.t_m)), float(np.degrees(angle))


def agreements(chosen: PoseEstimate, poses: Sequence[PoseEstimate]) -> Iterator[Check]:
    """The other stage, and the other optics, of the same estimator."""
    other = {"kabsch": "final", "final": "kabsch"}.get(chosen.stage)
    same = [p for p in poses if p.estimator == chosen.estimator]
    for p in same:
        if (p.stage, p.optics) == (other, chosen.optics):
            yield _stages(chosen, p)
        if p.stage == chosen.stage and {p.optics, chosen.optics} == {"ideal", "factory"}:
            mm, deg = pose_distance(chosen, p)
            cases, grade = (Case.OPTICS, Case.OPTICS_FAR), worst(mm, deg, 2 * (OPTICS_APART,))
            yield judged("optics agree", cases, mm, "mm", grade, deg=deg)


def _stages(chosen: PoseEstimate, other: PoseEstimate) -> Check:
    """A difference that the covariances allow is no fault."""
    mm, deg = pose_distance(chosen, other)
    word, limit = worst(mm, deg, STAGES_APART)
    case = Case.STAGES
    ok: bool | None = word == "good"
    if not ok:
        allowed = _within_noise(chosen, other)
        if allowed is None:
            case, ok = Case.STAGES_UNKNOWN, None
        elif allowed:
            case, ok, word = Case.STAGES_LOOSE, True, "good"
    return Check("stages agree", case, mm, "mm", limit, ok, word, {"deg": deg})


def _within_noise(a: PoseEstimate, b: PoseEstimate) -> bool | None:
    """Whether two poses differ by less than their covariances allow, one time in a thousand; None
    where a covariance has an entry that is no number."""
    if a.covariance is None or b.covariance is None:
        return False
    total = a.covariance + b.covariance
    if not np.isfinite(total).all():
        return None
    off = np.r_[1e3 * (a.t_m - b.t_m), np.degrees(rotation.error(a.R, b.R))]
    return bool(off @ np.linalg.pinv(total) @ off < fit_checks.CHI2_6)


def gravity_angle_deg(R: np.ndarray, stations: Sequence[Station]) -> float:
    """Angle in deg between R g_slave and g_master; NaN where a station transmitted none."""
    up = [s.gravity for s in stations if s.gravity is not None and np.linalg.norm(s.gravity) > 0]
    if len(up) < len(stations):
        return math.nan
    master, slave = (np.asarray(g) / np.linalg.norm(g) for g in up)
    turned = R @ slave
    return math.degrees(math.atan2(np.linalg.norm(np.cross(turned, master)), turned @ master))


def gravity(chosen: PoseEstimate, stations: Sequence[Station]) -> Check:
    """Up as the stations feel it, held against the pose."""
    value, (first, second) = gravity_angle_deg(chosen.R, stations), GRAVITY_DEG
    grade = ("doubtful" if value < second else "failed"), second
    off = Case.GRAVITY_OFF_IDEAL if chosen.optics == "ideal" else Case.GRAVITY_OFF
    cases = Case.GRAVITY, off, Case.GRAVITY_UNKNOWN
    return judged("gravity", cases, value, "deg", ("good", first) if value < first else grade)


def against_reference(errors: tuple[np.ndarray, np.ndarray] | None) -> Check:
    """The pose held against that of a lab."""
    if errors is None:
        return unknown("reference", Case.REFERENCE_NONE, "mm")
    mm, deg = (float(np.linalg.norm(e)) for e in errors)
    cases = Case.REFERENCE, Case.REFERENCE
    return judged("reference", cases, mm, "mm", worst(mm, deg, REFERENCE), deg=deg)


@dataclass(frozen=True)
class Verdict:
    """One of `WORDS`, and the checks behind it; why_none: where there are none, the reason that
    was given, if any.

    Of any number of stations the checks are those of the `station` with the worst word, `words`
    that of each, and `apart` says why others have no pose.
    """

    word: str
    checks: tuple[Check, ...] = ()
    why_none: str = ""
    station: str = ""
    words: Mapping[str, str] = field(default_factory=dict)
    apart: tuple[str, ...] = ()


def _check(one: Verdict, name: str) -> float:
    """Value of a check of a verdict; 0 where it has none."""
    values = (check.value for check in one.checks if check.name == name)
    return next((v for v in values if isinstance(v, float) and math.isfinite(v)), 0.0)


def worst_of(verdicts: Mapping[str, Verdict], apart: Sequence[str]) -> Verdict:
    """The verdict on several stations, of equal words by the least certain; a calibration that
    lacks some is `usable` at best."""
    words = {name: one.word for name, one in verdicts.items()}
    sd = {name: _check(one, "uncertainty") for name, one in verdicts.items()}
    name = max(words, key=lambda key: (WORDS.index(words[key]), sd[key]))
    word = max(words[name], "usable" if apart else "good", key=WORDS.index)
    return replace(verdicts[name], word=word, station=name, words=words, apart=tuple(apart))


def verdict(
    chosen: PoseEstimate | None,
    poses: Sequence[PoseEstimate],
    stations: Sequence[Station],
    *,
    n_common: int | None = None,
    span_m: float | None = None,
    duration_s: float | None = None,
    expected_urad: float = fit_checks.EXPECTED_URAD,
    board_rms_urad: float | None = None,
    places_urad: float = 0.0,
    errors: tuple[np.ndarray, np.ndarray] | None = None,
    variants: Sequence[VariantFit] = (),
    exchanged: Sequence[str] = (),
    why_none: str = "",
) -> Verdict:
    """Verdict on the pose `chosen` out of `poses`.

    stations: master first; n_common: moments with a board pose of both stations; span_m: largest
    distance between two places of the board's path, or about it; duration_s: of the recording;
    expected_urad: noise of one angle; board_rms_urad: angles about single board poses; places_urad:
    part of it that errors of the board make, as stated; errors: mm and deg against a reference, see
    `reference`; variants: of the rotor model, as the recording weighed them; exchanged: as of
    `factory`; why_none: the reason where nothing was chosen.
    """
    if chosen is None or not (np.isfinite(chosen.R).all() and np.isfinite(chosen.t_m).all()):
        return Verdict("failed", why_none=why_none)
    # Batch of the same optics alone is judged by weights, priors and pieces, of the recording.
    same = [p for p in poses if (p.estimator, p.optics) == ("batch", chosen.optics)]
    weighed = chosen if chosen.estimator == "batch" or not same else same[-1]
    misfit = fit_checks.misfit(weighed)
    priors, halves = fit_checks.priors(weighed), fit_checks.halves(chosen)
    doubted = misfit.case is Case.MISFIT_OPEN
    contradicted = doubted or priors.ok is False or halves.case is Case.HALVES_MISFIT
    unseen = fit_checks.optics_hidden(weighed, stations[0].generation)
    of_poses = board_rms_urad, expected_urad, places_urad, fit_checks.weighs_hits(chosen)
    checks = (
        fit_checks.distance(chosen),
        fit_checks.residual(chosen, expected_urad),
        fit_checks.weight(weighed),
        priors,
        *fit_checks.length(weighed),
        misfit,
        factory(chosen, stations, exchanged, contradicted, unseen),
        rotor_model(chosen, variants),
        fit_checks.mirrored(chosen),
        fit_checks.motion(chosen),
        fit_checks.common_measurements(chosen, n_common),
        fit_checks.board_poses(*of_poses),
        fit_checks.path(chosen, span_m),
        *agreements(chosen, poses),
        gravity(chosen, stations),
        fit_checks.weighted(chosen, expected_urad),
        halves,
        fit_checks.uncertainty(chosen),
        fit_checks.duration(duration_s),
        against_reference(errors),
    )
    if doubted or any(c.ok is False for c in checks if c.name in RIVALS):
        checks = tuple(
            replace(c, case=Case.HALVES_OPEN) if c.case is Case.HALVES_APART else c for c in checks
        )
    word = max((c.level for c in checks), key=WORDS.index)
    return Verdict(word, checks)
