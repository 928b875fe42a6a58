"""Noise of an orientation: of a rigid cluster of three or more markers, or of poses themselves.

S section 5 proposes the Allan variance of orientation. A rotation close to the mean one is a
vector, w = log(R R_mean^T), in the axes of the room; its three components are series like any
other, in rad, and each has its Allan variance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.large import Sliced
from mocap_metrology.common.linear import nearest_rotation
from mocap_metrology.common.types import Row
from mocap_metrology.noise.filters import FLAT

AXES = ("rx", "ry", "rz")
CHUNK = 100_000  # frames at once: 3 x 3 decompositions of so many stay small
SHAPE_FRAMES = 5_000  # determine the shape as well as all would: sigma / 70
TURNS_RAD = 0.0175  # 1 degree: what turns further is moved, and not measured for its noise
TURNS = "the body turns: this is its motion, not noise"


@dataclass(frozen=True)
class Orientation:
    """`vectors_rad` (3, n), rotation vectors from the mean orientation in axes of the room, NaN
    where fewer than three markers are seen; `residual_mm` (n,), rms distance of the markers from
    the rigid shape; `spread_mm`, rms distance of the markers from their centre."""

    vectors_rad: np.ndarray
    residual_mm: np.ndarray
    spread_mm: float

    @cached_property
    def range_rad(self) -> float:
        """How far it turned: 95 % of the angles from the mean orientation."""
        n = self.vectors_rad.shape[1]
        angle = np.empty(n)
        for part in _chunks(n):
            angle[part] = np.linalg.norm(self.vectors_rad[:, part], axis=0)
        known = angle[np.isfinite(angle)]
        return float(np.quantile(known, 0.95)) if known.size else float("nan")


def of_cluster(points_mm: Sequence[Sequence[Sliced]]) -> Orientation:
    """Orientation of a rigid cluster in every frame.

    points_mm: (k, 3, n), k >= 3 markers, NaN where hidden: arrays (n,) of floats of any kind, or
    columns of a table on the disk (`common.large.in_parts`).
    R of a frame minimises the sum of |p_i - c - R s_i|^2 over the markers seen (Kabsch 1976), s_i
    the cluster's own shape: the mean of all frames, each turned onto it. With noise of variance
    s^2 on every coordinate the covariance of w is s^2 (sum |s_i|^2 I - s_i s_i^T)^-1, R s_i about
    the centre.

    Refuses fewer than three markers, clusters on a line, and recordings in which three are never
    seen together.
    """
    k, n = len(points_mm), len(points_mm[0][0])
    if k < 3:
        raise Refusal(f"orientation: {k} markers; expected three or more of a rigid body")
    seen = np.ones(n, bool)
    for part in _chunks(n):
        for x in (x for marker in points_mm for x in marker):
            seen[part] &= np.isfinite(x[part])
    if not seen.any():
        raise Refusal("orientation: no frame in which all markers of the cluster are visible")
    shape = _shape(points_mm, np.flatnonzero(seen))
    spread = np.linalg.svd(shape, compute_uv=False) / np.sqrt(k)
    if spread[1] < FLAT * spread[0]:
        raise Refusal(
            "orientation: the markers of the cluster lie on a line; expected three that do not"
        )
    residual = np.full(n, np.nan)

    def turns() -> Iterator[np.ndarray]:
        for part in _chunks(n):
            turned, residual[part] = _turned(_chosen_frames(points_mm, part), shape)
            yield turned

    return Orientation(_vectors(turns(), n), residual, float(np.sqrt((shape**2).sum() / k)))


def unknown(n: int) -> Orientation:
    """What is known of n frames where `of_cluster` or `of_poses` refuses: nothing."""
    return Orientation(np.full((3, n), np.nan), np.full(n, np.nan), float("nan"))


def of_poses(xyzw: np.ndarray) -> Orientation:
    """The orientation by quaternions (4, n) that turn the axes of the body into those of the room;
    NaN stays NaN, residuals and spread are unknown."""
    known = np.isfinite(xyzw).all(axis=0) & (np.abs(xyzw).max(axis=0) > 0)
    if not known.any():
        raise Refusal("orientation: no pose with an orientation")
    from scipy.spatial.transform import Rotation

    n = xyzw.shape[1]

    def turns() -> Iterator[np.ndarray]:
        for part in _chunks(n):
            turned = np.full((known[part].size, 3, 3), np.nan)
            turned[known[part]] = Rotation.from_quat(xyzw[:, part][:, known[part]].T).as_matrix()
            yield turned

    return Orientation(_vectors(turns(), n), np.full(n, np.nan), float("nan"))


def _chunks(n: int) -> list[slice]:
    return [slice(start, start + CHUNK) for start in range(0, n, CHUNK)]


def _chosen_frames(points: Sequence[Sequence[Sliced]], frames: slice | np.ndarray) -> np.ndarray:
    """(k, 3, ...) of some frames, float64."""
    return np.array([[x[frames] for x in marker] for marker in points], dtype=np.float64)


def _shape(points: Sequence[Sequence[Sliced]], whole: np.ndarray) -> np.ndarray:
    """(k, 3) mean shape about its centre, by turning up to SHAPE_FRAMES frames onto each other."""
    chosen = whole[np.linspace(0, whole.size - 1, min(whole.size, SHAPE_FRAMES)).astype(int)]
    some = _chosen_frames(points, chosen)
    some -= some.mean(axis=0)
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
    r = nearest_rotation(np.einsum("kf,kaf,kbf->fab", weight, p, s))
    left = np.einsum("kf,kaf->kaf", weight, p - np.einsum("fab,kbf->kaf", r, s))
    residual = np.sqrt((left**2).sum(axis=(0, 1)) / n_seen)
    r[~enough], residual[~enough] = np.nan, np.nan
    return r, residual


def _vectors(turns: Iterable[np.ndarray], n: int) -> np.ndarray:
    """log(R R_mean^T) as (3, n), R_mean the rotation nearest to the sum of all matrices.

    turns: (m, 3, 3) of one of `_chunks` after the other: of 90 hours at 120 Hz all of them together
    would be 2.8 GB.
    """
    from scipy.spatial.transform import Rotation

    vectors, total = np.full((3, n), np.nan), np.zeros((3, 3))
    for part, turned in zip(_chunks(n), turns, strict=True):
        known = np.isfinite(turned).all(axis=(1, 2))
        # one after the other, so that the sum does not depend on the parts
        total = np.concatenate([total[None], turned[known]]).sum(axis=0)
        vectors[:, part][:, known] = Rotation.from_matrix(turned[known]).as_rotvec().T
    back = Rotation.from_matrix(nearest_rotation(total)).inv()  # of full turns it is no rotation
    for part in _chunks(n):
        known = np.isfinite(vectors[0, part])
        rotations = Rotation.from_rotvec(vectors[:, part][:, known].T)
        vectors[:, part][:, known] = (rotations * back).as_rotvec().T
    return vectors


def in_radians(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of an Allan table with the units of angles in their names."""
    return {name.replace("_mm", "_rad"): values for name, values in columns.items()}


def orientation_rows(
    recording: str,
    source: str,
    allan: Mapping[str, np.ndarray],
    orientation: Orientation,
    refused: str,
) -> list[Row]:
    """One row an axis: noise of one frame, smallest Allan deviation, and how rigid the body is.

    `note` states that the body turned, which the Allan variance assumes it did not, or why there is
    no orientation (`refused`).
    """
    best = {"adev_min_rad": "adev_rad", "adev_min_lower_rad": "adev_lower_rad"}
    best |= {"adev_min_upper_rad": "adev_upper_rad", "tau_min_s": "tau_s"}
    spread, turned = orientation.spread_mm, orientation.range_rad
    of_all = {
        "residual_rms_mm": rms(orientation.residual_mm),
        "spread_mm": None if math.isnan(spread) else spread,
        "turned_rad": None if math.isnan(turned) else turned,
        "note": TURNS if turned > TURNS_RAD else refused,
    }
    rows = []
    for axis in AXES:
        at = np.flatnonzero(allan["series"] == axis)
        adev = allan["adev_rad"][at]
        row: Row = {"recording": recording, "source": source, "axis": axis}
        row["adev_1_rad"] = adev[0] if at.size else None
        row |= {k: allan[of][at[adev.argmin()]] if at.size else None for k, of in best.items()}
        rows.append(row | of_all)
    return rows


def rms(values: np.ndarray) -> float | None:
    """None where there is no value, as of poses that come without markers."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None
