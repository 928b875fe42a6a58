"""What supports a calibration: both paths compared, diodes seen, scatter of tracked poses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse.assess.fit_checks import BOARD, EXPECTED_URAD
from mocap_metrology.lighthouse.calibrate.superpose import at_times
from mocap_metrology.lighthouse.fit.board_pose import MIRRORED_RAD
from mocap_metrology.lighthouse.records import Path
from mocap_metrology.lighthouse.rotation import log, mean

UNSEEN, SELDOM = 0.01, 0.5  # share of sweeps seen; SELDOM of the median diode's
TIMES_SIGMA = 3.0  # an error beyond so many standard deviations is more than scatter
FLAT = 0.05  # thickness of a board whose diodes all face the same way, over its width
AXES = {"mm": ("x_mm", "y_mm", "z_mm"), "deg": ("rx_deg", "ry_deg", "rz_deg")}
KINDS = {"noise": "sd_noise_", "calibration": "sd_calibration_", "total": "sd_"}
Columns = Mapping[str, np.ndarray]
N_BOARDS = 7


@dataclass(frozen=True)
class Agreement:
    """Both paths of the board in the master's frame, at times of the master's poses.

    time_s (n,), master_m, slave_m (n, 3), apart_mm (n,), turned_deg (n,): angle between the board's
    rotations; alone_s: times between them of poses that only master, only slave has.
    """

    time_s: np.ndarray
    master_m: np.ndarray
    slave_m: np.ndarray
    apart_mm: np.ndarray
    turned_deg: np.ndarray
    alone_s: tuple[np.ndarray, np.ndarray]

    @property
    def mirrored(self) -> np.ndarray:
        """Moments at which one of both poses is in the other minimum."""
        return np.asarray(self.turned_deg > np.degrees(MIRRORED_RAD))


def agreement(paths: tuple[Path, Path], pose: tuple[np.ndarray, np.ndarray]) -> Agreement:
    """p_m against R p_s + t and R_m against R R_s, p_s and R_s interpolated (J VI-C)."""
    (master, slave), (R, t) = paths, pose
    then, common = at_times(slave, master.time_s)
    _, both = at_times(master, slave.time_s)
    own, moved = master.take(common), then.t_m @ R.T + t
    trace = np.einsum("nij,ik,nkj->n", own.R, R, then.R)
    first, last = (own.time_s[0], own.time_s[-1]) if len(own) else (np.inf, -np.inf)
    alone = master.time_s[~common], slave.time_s[~both]
    return Agreement(
        own.time_s,
        own.t_m,
        moved,
        1e3 * np.linalg.norm(own.t_m - moved, axis=1),
        np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))),
        tuple(t_s[(t_s > first) & (t_s < last)] for t_s in alone),
    )


def residuals_urad(path: Path) -> np.ndarray:
    """Root mean square of C - M of each board pose, sqrt(epsilon / n_angles), in urad."""
    return np.asarray(1e6 * np.sqrt(path.epsilon / np.maximum(path.n_angles, 1)))


def seen_shares(sweeps: Columns, n_diodes: int, n: int) -> np.ndarray:
    """Share of the sweeps of each of n stations that each diode saw, (n, diodes), of those that any
    diode saw."""
    shares = []
    for station in range(n):
        own = np.asarray(sweeps["station"]) == station
        cycle, diode = np.asarray(sweeps["cycle"])[own], np.asarray(sweeps["diode"])[own]
        pairs = np.unique(np.column_stack([cycle, diode]).astype(np.int64), axis=0)
        counts = np.bincount(pairs[:, 1], minlength=n_diodes)[:n_diodes]
        shares.append(counts / max(np.unique(cycle).size, 1))
    return np.array(shares)


def faint_diodes(shares: np.ndarray, board: np.ndarray, station: int) -> dict[str, np.ndarray]:
    """Numbers of the diodes that are dead, that this station has not seen, and that it has seen
    less than half as often as the median one.

    shares (2, n): of the sweeps of either station that each diode saw. Those on a flat board all
    face the same way, so one that no station sees where others are seen is dead. On a board with
    depth it may face away, or something may be in the way: it is `not seen`.
    """
    seen = shares >= UNSEEN
    thickness, _, width = np.linalg.svd(board - board.mean(axis=0), compute_uv=False)[::-1]
    dead = ~seen.any(axis=0) & (thickness < FLAT * width and seen.any())
    own = seen[station]
    usual = np.median(shares[station][own]) if own.any() else 0.0
    return {
        "dead": np.flatnonzero(dead),
        "not seen": np.flatnonzero(~own & ~dead),
        "seldom": np.flatnonzero(own & (shares[station] < SELDOM * usual)),
    }


def lengths(track: Columns, kind: str, unit: str) -> np.ndarray:
    """Length (n,) of the vector of standard deviations of tracked poses; kind: one of `KINDS`;
    unit: mm or deg."""
    names = [f"{KINDS[kind]}{axis}" for axis in AXES[unit]]
    squares = [np.asarray(track[name], dtype=np.float64) ** 2 for name in names]
    return np.asarray(np.sqrt(np.sum(squares, axis=0)))


def settled(track: Columns) -> np.ndarray:
    """Poses (n,) of no more than twice the usual noise: not at an end, nor where hits are few."""
    noise = lengths(track, "noise", "mm")
    known = np.isfinite(noise)
    return known & (noise <= 2 * np.median(noise[known])) if known.any() else known


def deviations_mm(track: Columns) -> np.ndarray:
    """(n, 3) of the position from the mean of `settled` poses."""
    place = np.column_stack([track[f"{axis}_mm"] for axis in "xyz"])
    good = settled(track)
    return np.asarray(place - place[good].mean(axis=0)) if good.any() else place


def jitter(track: Columns) -> tuple[float, float]:
    """Standard deviation of the `settled` poses about their mean: lengths in mm and deg."""
    from scipy.spatial.transform import Rotation

    good = settled(track)
    if good.sum() < 2:
        return math.nan, math.nan
    q = np.column_stack([track[name][good] for name in ("qx", "qy", "qz", "qw")])
    R = Rotation.from_quat(q).as_matrix()
    both = deviations_mm(track)[good], np.degrees(log(R @ mean(R).T))
    mm, deg = (float(np.sqrt(own.var(axis=0, ddof=1).sum())) for own in both)
    return mm, deg


def expected_urad(pose: Record) -> float:
    """Noise of one angle that the checks went by, in µrad."""
    limit, good = limit_of(pose, "board poses")
    return EXPECTED_URAD if limit is None else limit / BOARD[0 if good else 1]


def limit_of(pose: Record, name: str) -> tuple[float | None, bool]:
    """Limit of a check and whether it is that of the word good; None where it has none."""
    check: Record = next((c for c in pose.get("checks", ()) if c["name"] == name), {})
    limit = check.get("limit")
    return (limit if isinstance(limit, int | float) else None), bool(check.get("ok"))


def deviations(entry: Record) -> np.ndarray:
    """Standard deviations (6,) in mm and deg, NaN where they are not known."""
    if entry.get("covariance") is None:
        return np.full(6, np.nan)
    variance = np.diag(np.array(entry["covariance"], dtype=np.float64))
    return np.asarray(np.sqrt(np.clip(variance, 0, None)))


def beyond_sigma(entry: Record) -> bool:
    """Whether the error of an estimate against its reference is more than three standard deviations
    in a coordinate or about an axis."""
    if entry.get("errors_mm") is None:
        return False
    off = np.abs([*entry["errors_mm"], *entry["errors_deg"]])
    return bool((off > TIMES_SIGMA * deviations(entry)).any())


def usual_points(points: np.ndarray) -> np.ndarray:
    """All but the farthest hundredth in each coordinate."""
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    inside = points[((points >= low) & (points <= high)).all(axis=1)]
    return inside if len(inside) else points


def on_the_path(points: np.ndarray) -> np.ndarray:
    """Which points are on the path: within the middle nine tenths in each coordinate and a little
    round them."""
    low, high = np.percentile(points, [5, 95], axis=0)
    room = 0.2 * (high - low).max()
    return np.asarray(((points >= low - room) & (points <= high + room)).all(axis=1))


def boards_along(path: Path, board: np.ndarray) -> list[np.ndarray]:
    """Corners (4, 3) of the board at some moments, equally far apart along its path."""
    path = path.take(on_the_path(path.t_m))
    step = np.linalg.norm(np.diff(path.t_m, axis=0), axis=1)
    far = np.concatenate([[0.0], np.cumsum(np.minimum(step, 5 * np.median(step)))])
    at = np.searchsorted(far, np.linspace(0, far.max(), N_BOARDS))
    corners = outline(board)
    which = np.unique(np.clip(at, 0, len(path) - 1))
    return [path.t_m[k] + corners @ path.R[k].T for k in which]


def outline(board: np.ndarray) -> np.ndarray:
    """Corners (4, 3) of the rectangle round a board in its principal plane, in its own frame."""
    centre = board.mean(axis=0)
    axes = np.linalg.svd(board - centre, full_matrices=False)[2][:2]
    within = (board - centre) @ axes.T
    (a, c), (b, d) = within.min(axis=0), within.max(axis=0)
    return np.asarray(centre + np.array([[a, c], [b, c], [b, d], [a, d]]) @ axes)
