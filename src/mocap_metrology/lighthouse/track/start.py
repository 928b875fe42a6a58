"""Board poses with known stations: where the estimate of a trajectory starts.

A diode that both stations see at one moment is at the point nearest to both rays; three such points
give the pose without a mirrored one (Kabsch). Where one station alone sees four diodes, the pose is
that of the smaller K_1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mocap_metrology.lighthouse.batch.trajectory import Trajectory, trajectory_of
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.network import moments
from mocap_metrology.lighthouse.calibrate.scene import Pose
from mocap_metrology.lighthouse.fit.board_pose import by_levenberg_marquardt, well_posed
from mocap_metrology.lighthouse.records import Hits, Measurements, Path
from mocap_metrology.lighthouse.rotor import directions, rotor_parameters

FEWEST_POINTS = 3
PARALLEL = 1e-6  # squared sine of the angle between two rays, below which they fix no point


def trajectory(
    hits: Hits, board: np.ndarray, rotors: np.ndarray, stations: Sequence[Pose]
) -> Trajectory | None:
    """Near that of the board; None where no pose of it is found.

    rotors (stations, 2, 13); stations: their poses in the frame of the first. Points are those of
    a station and of the two before it.
    """
    seen = [
        Measurements(own.time_s, directions(own.angles_rad, rotors[station]))
        for station, own in enumerate(moments(hits, len(board), len(stations)))
    ]
    parts = []
    for j in range(1, len(seen)):
        for i in range(max(j - 2, 0), j):
            (R, t_m), (R_j, t_j) = stations[i], stations[j]
            both = triangulated([seen[i], seen[j]], board, R.T @ R_j, R.T @ (t_j - t_m))
            parts.append(both.seen_from(R, t_m))
    alone = ~np.isin(seen[0].time_s, np.concatenate([part.time_s for part in parts]))
    for own, pose in zip(seen, stations, strict=True):
        rows = alone & (own.seen.sum(axis=1) >= FEWEST_DIODES)
        if len(given := well_posed(own.take(rows), board)):
            by_one = by_levenberg_marquardt(given, board, rotor_parameters())
            parts.append(by_one.seen_from(*pose))
    every = Path.joined(parts)
    if not len(every):
        return None
    begin, end = hits.time_s.min(), hits.time_s.max()
    return trajectory_of(every, begin, end)


def triangulated(
    seen: Sequence[Measurements], board: np.ndarray, R: np.ndarray, t_m: np.ndarray
) -> Path:
    """Poses at the moments at which both stations see three diodes that span a surface.

    seen: ideal angles of both stations at the same moments.
    """
    a, b = (
        np.stack(
            [np.ones(own.angles_rad.shape[:2]), *np.moveaxis(np.tan(own.angles_rad), 2, 0)], -1
        )
        for own in seen
    )
    b = b @ R.T
    aa, ab, bb = (np.einsum("ndi,ndi->nd", *pair) for pair in ((a, a), (a, b), (b, b)))
    with np.errstate(invalid="ignore", divide="ignore"):
        det = np.where(aa * bb - ab**2 > PARALLEL * aa * bb, aa * bb - ab**2, np.nan)
        far_a = (bb * (a @ t_m) - ab * (b @ t_m)) / det
        far_b = (ab * (a @ t_m) - aa * (b @ t_m)) / det
    points = (far_a[..., None] * a + t_m + far_b[..., None] * b) / 2
    known = np.isfinite(points).all(axis=2) & (far_a > 0) & (far_b > 0)
    shared = np.where(known[..., None], seen[0].angles_rad, np.nan)
    enough = known.sum(axis=1) >= FEWEST_POINTS
    wide = well_posed(Measurements(seen[0].time_s[enough], shared[enough]), board).time_s
    rows = np.flatnonzero(np.isin(seen[0].time_s, wide))
    return _path(seen[0].time_s[rows], *_superposed(points[rows], known[rows], board))


def _superposed(
    points: np.ndarray, known: np.ndarray, board: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """R (n, 3, 3), p (n, 3) that bring the board to the known of the points (n, diodes, 3)."""
    w = known / known.sum(axis=1, keepdims=True)
    points = np.where(known[..., None], points, 0.0)
    centre, own = np.einsum("nd,ndi->ni", w, points), w @ board
    H = np.einsum("nd,ndi,ndj->nij", w, points - centre[:, None], board - own[:, None])
    U, _, Vt = np.linalg.svd(H)
    U[:, :, 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
    R = U @ Vt
    return R, centre - np.einsum("nij,nj->ni", R, own)


def _path(time_s: np.ndarray, R: np.ndarray, t_m: np.ndarray) -> Path:
    nothing = np.zeros(time_s.size)
    return Path(time_s, R, t_m, nothing, nothing, nothing)
