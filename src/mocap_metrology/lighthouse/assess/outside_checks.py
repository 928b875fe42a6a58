"""Checks that ask for what no fit shows: factory values, the rotor model, other stages and optics,
gravity, and what a lab measured.

A low residual alone proves nothing: with ideal optics a fit that is 70 mm and 2° off has a
residual of 0.06-0.3 mrad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.fit_checks import CHI2_6, Check, unknown, worst
from mocap_metrology.lighthouse.calibrate.variants import Weighed, steps
from mocap_metrology.lighthouse.records import ROLES, PoseEstimate, Station

STAGES_APART = ((20.0, 0.5), (60.0, 2.0))  # mm, deg
OPTICS_APART = (500.0, 10.0)  # what factory values can change at most
GRAVITY_SD_DEG = 1.5  # of either component of the difference: sound real pairs differ by 1-2.5
# Doubtful where one sound pair in 200 is, failed where none in 1e9 is (Rayleigh's distribution).
GRAVITY_DEG = tuple(GRAVITY_SD_DEG * math.sqrt(-2 * math.log(p)) for p in (5e-3, 1e-9))
REFERENCE = ((30.0, 2.0), (100.0, 5.0))


def factory(chosen: PoseEstimate, stations: Sequence[Station]) -> Check:
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


def rotor_model(chosen: PoseEstimate, variants: Sequence[Weighed]) -> Check:
    """Drivers differ in what factory values mean; their difference is in the covariance."""
    name = "rotor model"
    if chosen.optics != "factory" or not variants:
        return unknown(name, "mm", "The recording was not asked for the model of the rotors.")
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


def apart(a: PoseEstimate, b: PoseEstimate) -> tuple[float, float]:
    """Distance in mm and angle in deg between two poses."""
    angle = np.linalg.norm(rotation.error(a.R, b.R))
    return 1e3 * float(np.linalg.norm(a.t_m - b.t_m)), float(np.degrees(angle))


def agreements(chosen: PoseEstimate, poses: Sequence[PoseEstimate]) -> Iterator[Check]:
    """The other stage, and the other optics, of the same estimator."""
    other = {"kabsch": "final", "final": "kabsch"}.get(chosen.stage)
    own = [p for p in poses if p.estimator == chosen.estimator]
    for p in own:
        if (p.stage, p.optics) == (other, chosen.optics):
            mm, deg = apart(chosen, p)
            word, limit = worst(mm, deg, STAGES_APART)
            sentence = f"Kabsch and final stage are {mm:.3g} mm and {deg:.2g}° apart."
            if word != "good" and _within_noise(chosen, p):
                word = "good"
                sentence += " Kabsch is no surer than that on such a path."
            yield Check("stages agree", mm, "mm", limit, word == "good", word, sentence)
        if p.stage == chosen.stage and p.optics != chosen.optics:
            mm, deg = apart(chosen, p)
            word, limit = worst(mm, deg, (OPTICS_APART, OPTICS_APART))
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


def gravity(chosen: PoseEstimate, stations: Sequence[Station]) -> Check:
    """Up as the stations feel it, held against the pose."""
    value = gravity_angle_deg(chosen.R, stations)
    if not math.isfinite(value):
        return unknown("gravity", "deg", "No gravity from both stations to compare with.")
    word = "good" if value < GRAVITY_DEG[0] else "doubtful" if value < GRAVITY_DEG[1] else "failed"
    limit = GRAVITY_DEG[0] if word == "good" else GRAVITY_DEG[1]
    cause = "" if chosen.optics == "factory" else " Neglected factory values alone can be 4°."
    sentence = (
        f"Up as both stations feel it agrees within {value:.1f}°."
        if word == "good"
        else f"Up as both stations feel it differs by {value:.1f}° in this pose.{cause}"
    )
    return Check("gravity", value, "deg", limit, word == "good", word, sentence)


def against_reference(errors: tuple[np.ndarray, np.ndarray] | None) -> Check:
    """The pose held against that of a lab."""
    if errors is None:
        return unknown("reference", "mm", "There is no reference.")
    mm, deg = (float(np.linalg.norm(e)) for e in errors)
    word, limit = worst(mm, deg, REFERENCE)
    sentence = f"The pose is {mm:.3g} mm and {deg:.2g}° from the reference."
    return Check("reference", mm, "mm", limit, word == "good", word, sentence)
