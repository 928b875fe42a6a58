"""Stage `final` of `paper-lm`: the slave's pose from its own angles of the master's path."""

from __future__ import annotations

import numpy as np

from mocap_metrology.lighthouse.calibrate import station_pose
from mocap_metrology.lighthouse.calibrate.agreement import Agreed, agree, minima
from mocap_metrology.lighthouse.calibrate.board_pose import Path
from mocap_metrology.lighthouse.calibrate.optics import Optics
from mocap_metrology.lighthouse.calibrate.reconstruction import Measurements
from mocap_metrology.lighthouse.calibrate.superpose import at_times
from mocap_metrology.lighthouse.calibrate.weighted_station import (
    Evidence,
    by_gauss_newton,
    residuals,
)
from mocap_metrology.lighthouse.records import MASTER, SLAVE

# Of the plain residual by weighting it: lasers 15 mm off make 2, a last step that runs away 10.
RISE = 3.0

Pose = tuple[np.ndarray, np.ndarray]


def agreed_paths(
    optics: Optics, board: np.ndarray, order: int, near: np.ndarray | None = None
) -> Agreed:
    """Board poses in the frames of both stations, the mirror decided by both."""
    both = (
        minima(own, board, rotors)
        for own, rotors in zip(optics.measurements, optics.rotors, strict=True)
    )
    return agree(*both, board, optics.rotors, order, near)


def seen_on_path(paths: tuple[Path, Path], optics: Optics, order: int) -> tuple[Path, Measurements]:
    """The slave's measurements that have the master's path on both sides, and the path then."""
    own = optics.measurements[SLAVE]
    then, kept = at_times(paths[MASTER], own.time_s, order)
    return then, Measurements(own.time_s[kept], own.angles_rad[kept])


def last_step(
    starts: list[Pose],
    given: station_pose.Scene,
    weighed: Evidence,
    rotors: np.ndarray,
    weights: str = "path",
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """From the start of the least cost: R, t (m), covariance (6, 6) in m and rad.

    The weighted K_2 is taken down from there. If that makes the plain residual rise by more than
    weights can, it has run away: then the least plain K_2 stays. weights `none` stops at that, too.
    """
    plain = min(starts, key=lambda pose: station_pose.residual_rms(*pose, given, rotors))
    R, t, _ = station_pose.by_levenberg_marquardt(*plain, given, rotors)
    if weights == "path":
        starts = [*starts, (R, t)]
        found = [residuals(*start, weighed, rotors) for start in starts]
        limit = min(one.limit() for one in found)
        best = min(range(len(starts)), key=lambda k: found[k].total(limit))
        R2, t2, spread = by_gauss_newton(*starts[best], weighed, rotors)
        before = station_pose.residual_rms(R, t, given, rotors)
        if station_pose.residual_rms(R2, t2, given, rotors) <= RISE * before:
            return R2, t2, spread
    return R, t, station_pose.covariance(R, t, given, rotors)
