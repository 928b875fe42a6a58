"""Two parts of a recording held against each other: did a station move meanwhile?

A station that is bumped by millimetres leaves a pose between both, with a residual like that of
sound recordings; but what came before and what came after then have poses of their own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.weighted_station import Evidence, by_gauss_newton
from mocap_metrology.lighthouse.records import Halves

SPLITS = (1 / 3, 1 / 2, 2 / 3)  # of the duration; a bump is near one of them


def halves(R: np.ndarray, t: np.ndarray, given: Evidence, rotors: np.ndarray) -> Halves | None:
    """Poses of the slave from the measurements before and after each of `SPLITS`, both from near
    the pose R, t (m) of all: the two that are farthest apart by m2; None where no part tells its
    uncertainty. rotors: of the slave."""
    time = given.path.time_s
    found = []
    for split in SPLITS:
        early = time < time.min() + split * np.ptp(time)
        parts = [by_gauss_newton(R, t, _part(given, own), rotors) for own in (early, ~early)]
        if all(covariance is not None for *_, covariance in parts):
            found.append(_apart(*parts))
    return max(found, key=lambda one: one.m2, default=None)


def _part(given: Evidence, own: np.ndarray) -> Evidence:
    return replace(
        given,
        path=given.path.take(own),
        angles=given.angles[own],
        information=given.information[own],
    )


def _apart(
    a: tuple[np.ndarray, np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> Halves:
    d = np.r_[a[1] - b[1], rotation.error(a[0], b[0])]
    m2 = float(d @ np.linalg.pinv(a[2] + b[2], rcond=1e-12) @ d)
    return Halves(1e3 * float(np.linalg.norm(d[:3])), float(np.degrees(np.linalg.norm(d[3:]))), m2)
