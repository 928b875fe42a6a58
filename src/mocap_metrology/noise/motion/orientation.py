"""Noise of an orientation: of a rigid cluster of three or more markers, or of poses themselves.

S section 5 asks for the Allan variance of orientation. A rotation close to the mean one is a
vector, w = log(R R_mean^T), in the axes of the room; its three components are series like any
other, in rad, and each has its Allan variance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal

AXES = ("rx", "ry", "rz")
CHUNK = 100_000  # frames at once: 3 x 3 decompositions of so many stay small
SHAPE_FRAMES = 5_000  # tell the shape as well as all would: sigma / 70
FLAT = 0.02  # least spread across a line of markers, as a share of that along it


@dataclass(frozen=True)
class Orientation:
    """`vectors_rad` (3, n), rotation vectors from the mean orientation in axes of the room, NaN
    where fewer than three markers are seen; `residual_mm` (n,), rms distance of the markers from
    the rigid shape; `spread_mm`, rms distance of the markers from their centre."""

    vectors_rad: np.ndarray
    residual_mm: np.ndarray
    spread_mm: float

    @property
    def range_rad(self) -> float:
        """How far it turned: 95 % of the angles from the mean orientation."""
        angle = np.linalg.norm(self.vectors_rad, axis=0)
        known = angle[np.isfinite(angle)]
        return float(np.quantile(known, 0.95)) if known.size else float("nan")


def of_cluster(points_mm: np.ndarray) -> Orientation:
    """Orientation of a rigid cluster in every frame.

    points_mm: (k, 3, n), k >= 3 markers, NaN where hidden. R of a frame minimises the sum of
    |p_i - c - R s_i|^2 over the markers seen (Kabsch 1976), s_i the cluster's own shape: the mean
    of all frames, each turned onto it. With noise of variance s^2 on every coordinate the
    covariance of w is s^2 (sum |s_i|^2 I - s_i s_i^T)^-1, R s_i about the centre.

    Refuses fewer than three markers, clusters on a line, and recordings in which three are never
    seen together.
    """
    k, _, n = points_mm.shape
    if k < 3:
        raise Refusal(f"orientation: {k} markers; expected three or more of a rigid body")
    whole = np.flatnonzero(np.isfinite(points_mm).all(axis=(0, 1)))
    if not whole.size:
        raise Refusal("orientation: no frame in which all markers of the cluster are visible")
    shape = _shape(points_mm, whole)
    spread = np.linalg.svd(shape, compute_uv=False) / np.sqrt(k)
    if spread[1] < FLAT * spread[0]:
        raise Refusal(
            "orientation: the markers of the cluster lie on a line; expected three that do not"
        )
    rotations, residual = np.full((n, 3, 3), np.nan), np.full(n, np.nan)
    for start in range(0, n, CHUNK):
        part = slice(start, start + CHUNK)
        rotations[part], residual[part] = _turned(points_mm[:, :, part], shape)
    vectors = _vectors(rotations)
    return Orientation(vectors, residual, float(np.sqrt((shape**2).sum() / k)))


def unknown(n: int) -> Orientation:
    """What is known of n frames where `of_cluster` or `of_poses` refuses: nothing."""
    return Orientation(np.full((3, n), np.nan), np.full(n, np.nan), float("nan"))


def of_poses(xyzw: np.ndarray) -> Orientation:
    """Of quaternions (4, n) that turn the body's axes into the room's; NaN stays NaN. Nothing is
    known of residuals and spread."""
    known = np.isfinite(xyzw).all(axis=0) & (np.abs(xyzw).max(axis=0) > 0)
    if not known.any():
        raise Refusal("orientation: no pose with an orientation")
    matrices = np.full((xyzw.shape[1], 3, 3), np.nan)
    matrices[known] = Rotation.from_quat(xyzw[:, known].T).as_matrix()
    return Orientation(_vectors(matrices), np.full(xyzw.shape[1], np.nan), float("nan"))


def _shape(points: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """(k, 3) mean shape about its centre, by turning up to SHAPE_FRAMES frames onto each other."""
    chosen = whole[np.linspace(0, whole.size - 1, min(whole.size, SHAPE_FRAMES)).astype(int)]
    some = points[:, :, chosen]
    some = some - some.mean(axis=0)
    shape: np.ndarray = some[:, :, 0]
    for _ in range(4):  # each round leaves less than a thousandth of the change of the last
        turns, _ = _turned(some, shape)
        shape = np.einsum("fba,kbf->ka", turns, some) / chosen.size
    return shape


def _turned(points: np.ndarray, shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Best rotation (n, 3, 3) of the shape onto each frame, and rms residual (n,)."""
    seen = np.isfinite(points).all(axis=1)
    count = seen.sum(axis=0)
    enough = count >= 3
    weight = np.where(seen & enough, 1.0, 0.0)
    n_seen = np.maximum(count, 1)
    p = np.where(seen[:, None, :], points, 0.0)
    p = p - (np.einsum("kf,kaf->af", weight, p) / n_seen)[None]
    s = shape[:, :, None] - (np.einsum("kf,ka->af", weight, shape) / n_seen)[None]
    h = np.einsum("kf,kaf,kbf->fab", weight, p, s)
    u, _, vt = np.linalg.svd(h)
    flip = np.linalg.det(u) * np.linalg.det(vt)
    u[:, :, 2] *= np.sign(flip)[:, None]
    r = u @ vt
    left = np.einsum("kf,kaf->kaf", weight, p - np.einsum("fab,kbf->kaf", r, s))
    residual = np.sqrt((left**2).sum(axis=(0, 1)) / n_seen)
    r[~enough], residual[~enough] = np.nan, np.nan
    return r, residual


def _vectors(rotations: np.ndarray) -> np.ndarray:
    """log(R R_mean^T) as (3, n), R_mean the rotation nearest to the mean matrix."""
    known = np.isfinite(rotations).all(axis=(1, 2))
    u, _, vt = np.linalg.svd(rotations[known].mean(axis=0))
    u[:, 2] *= np.sign(np.linalg.det(u) * np.linalg.det(vt))
    mean = u @ vt
    vectors = np.full((3, rotations.shape[0]), np.nan)
    vectors[:, known] = Rotation.from_matrix(rotations[known] @ mean.T).as_rotvec().T
    return vectors
