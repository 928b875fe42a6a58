"""A simulated take: cameras round a hall, each with its own noise; recordings are subsets of them.

Camera i sees a marker at p as a pinhole does, q = c + f (X/Z, Y/Z) in pixels, with (X, Y, Z) =
R_i (p - o_i). Centroid noise e_i has standard deviation s_i pixels in both directions. The position
that minimises the sum of squared residuals of a set of cameras has, to first order, the error

    A^-1 sum_i J_i^T e_i,   A = sum_i J_i^T J_i,   J_i = dq_i / dp  (2 x 3)

so positions p_a, p_b from two sets of the same frames have the covariance
A_a^-1 (sum over cameras in both of s_i^2 J_i^T J_i) A_b^-1. Hall and optics as in S section 3.1 and
Table 2. Lengths in mm.

The position of a marker from a subset is start + motion + that error. Centroid errors and motion
depend on the seed and the camera alone, so recordings of two subsets with one seed hold the same
frames: what they have in common is what real subsets of a take have in common.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator
from pydantic.dataclasses import dataclass as entry

from mocap_metrology.common.entries import ENTRY, MADE, NonNegative, Number, Positive, Whole, one_of
from mocap_metrology.common.faults import Unfit
from mocap_metrology.common.types import Floats, Row
from mocap_metrology.noise.model.components import Form, NoiseModel
from mocap_metrology.noise.twins.simulate import (
    AXES,
    SimulatedRecording,
    frames_of,
    stream,
    truth_of,
)
from mocap_metrology.noise.twins.twin import Labels, Place, check_markers

HALL_MM = (9000.0, 5000.0, 3000.0)  # S section 3.1
WAND_MM = 160.0  # distance of the two markers, S Table 4
MOST_CAMERAS = 1000
# Focal length in pixels: half the sensor's width over the tangent of half the angle of view (S
# Table 2; sensors 4, 1 and 5 MP wide by the makers' data)
FOCAL_PX = {
    "T40": 2336 / 2 / np.tan(np.radians(49.15 / 2)),
    "Bonita": 1024 / 2 / np.tan(np.radians(70.29 / 2)),
    "Vantage": 2432 / 2 / np.tan(np.radians(63.5 / 2)),
}


@dataclass(frozen=True)
class Facility:
    """`n` cameras and markers. origins_mm: (n, 3); rotations: (n, 3, 3), rows are the camera's
    right, down and forward; focal_px: (n,); markers_mm: (k, 3)."""

    origins_mm: np.ndarray
    rotations: np.ndarray
    focal_px: np.ndarray
    markers_mm: np.ndarray

    @property
    def n(self) -> int:
        return len(self.origins_mm)


def random_facility(rng: np.random.Generator, n: int, camera_type: str = "Vantage") -> Facility:
    """`n` cameras on a scaffold round the hall, 2 to 3 m high, aimed within 5 degrees of the wand.

    They hang in four places with about a metre between neighbours, which makes the noise of a
    subset depend on who is in it as much as S's coefficients do. The wand lies near the middle, up
    to 1.2 m above the floor, turned at random.
    """
    place = rng.uniform(0, 1, 4)[rng.integers(4, size=n)] + rng.normal(0, 0.03, n)
    origins = _on_scaffold(place, rng.uniform(2000, HALL_MM[2], n))
    middle = np.array([*rng.normal(0, 300, 2), rng.uniform(0, 1200)])
    turn = rng.uniform(0, 2 * np.pi)
    half = WAND_MM / 2 * np.array([np.cos(turn), np.sin(turn), 0.0])
    forward = middle - origins
    forward /= np.linalg.norm(forward, axis=1)[:, None]
    forward += np.tan(np.radians(5)) * rng.uniform(-1, 1, (n, 3))
    rotations = np.array([_camera_rotation(direction) for direction in forward])
    focal = np.full(n, FOCAL_PX[camera_type])
    return Facility(origins, rotations, focal, np.array([middle - half, middle + half]))


def _on_scaffold(place: np.ndarray, height: np.ndarray) -> np.ndarray:
    """(n, 3) points on the hall's outline, `place` going round once from 0 to 1."""
    length, width = HALL_MM[:2]
    along = (place % 1.0) * 2 * (length + width)
    corners = np.array([0, length, length + width, 2 * length + width, 2 * (length + width)])
    x = np.interp(along, corners, [0, length, length, 0, 0]) - length / 2
    y = np.interp(along, corners, [0, 0, width, width, 0]) - width / 2
    return np.stack([x, y, height], axis=1)


def _camera_rotation(direction: np.ndarray) -> np.ndarray:
    """Rotation of an upright camera that looks along `direction`."""
    forward = direction / np.linalg.norm(direction)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(forward, right), forward])


def jacobians(facility: Facility, marker: int) -> np.ndarray:
    """(n, 2, 3) pixels per mm: J_i at a marker."""
    rotations = facility.rotations
    offset = facility.markers_mm[marker] - facility.origins_mm
    seen = np.einsum("nij,nj->ni", rotations, offset)
    depth = seen[:, 2, None, None]
    ratio = seen[:, :2, None] / depth
    return facility.focal_px[:, None, None] * (rotations[:, :2] - ratio * rotations[:, 2:]) / depth


def joint_covariance(
    facility: Facility, marker: int, noise_px: np.ndarray, subsets: Sequence[Sequence[int]]
) -> np.ndarray:
    """(3 s, 3 s) covariance in mm^2 of one marker's positions from `s` subsets of the same frames.

    noise_px: (n,) centroid noise of each camera; subsets: indices of cameras.
    """
    gains = gain_matrices(facility, marker, subsets)
    return np.einsum("sidk,k,tjdk->sitj", gains, noise_px**2, gains).reshape(
        3 * len(subsets), 3 * len(subsets)
    )


def gain_matrices(facility: Facility, marker: int, subsets: Sequence[Sequence[int]]) -> np.ndarray:
    """(s, 3, 2, n): what a pixel of centroid error in each camera moves the position by, A^-1
    J_i^T; zero for cameras that are not in the subset."""
    jacobian = jacobians(facility, marker)
    gains = np.zeros((len(subsets), 3, 2, facility.n))
    for gain, subset in zip(gains, subsets, strict=True):
        rows = jacobian[list(subset)]
        inverse = np.linalg.inv(np.einsum("nki,nkj->ij", rows, rows))
        gain[:, :, list(subset)] = np.einsum("ij,nkj->ikn", inverse, rows)
    return gains


@entry(frozen=True, config=ENTRY)
class Failing:
    """One camera is noisier than the others."""

    camera: Annotated[int, Whole(1)]
    """Id of the camera."""
    times: Positive
    """Factor of its noise."""


@entry(frozen=True, config=ENTRY)
class Take:
    """Two markers, seen by cameras on a scaffold round a hall of 9 x 5 x 3 m as in the paper."""

    camera_type: Annotated[str, one_of(FOCAL_PX)]
    """T40, Bonita or Vantage: the optics of the cameras."""
    cameras: Annotated[int, Whole(2, MOST_CAMERAS)]
    """Number of cameras; their ids are 1, 2, ..."""
    layout_seed: Annotated[int, Whole()]
    """Seed of the positions of the cameras: another value is another hall."""
    centroid_px: Positive
    """Noise of a centroid in pixels (white, SD in each direction)."""
    spread: Annotated[float, Number(0, 1)] = 0.0
    """Variation of the noise from camera to camera (SD of its logarithm)."""
    failing: Failing | None = None
    """One that is so many times as noisy."""
    h_m2: NonNegative = Field(default=0.0, alias="h_-2")
    """Random walk of every coordinate of the markers themselves, mm^2 Hz; the same in all
    subsets."""
    drift_mm_per_h: dict[str, Place] = Field(default_factory=dict)
    """Drift of the markers, by label."""

    @field_validator("failing")
    @classmethod
    def _is_there(cls, failing: Failing | None, info: ValidationInfo) -> Failing | None:
        cameras = info.data.get("cameras")
        if failing and cameras and failing.camera > cameras:
            raise Unfit(f"one from 1 to {cameras}", failing.camera, ".camera")
        return failing


@entry(frozen=True, config=ENTRY)
class TakeTwin:
    """A twin triangulated from some of the cameras of a take by least squares. Twins of one `take`
    and one `seed` are recordings of the same frames, as subsets of a real take are."""

    form: ClassVar[Form] = "sampled"

    name: Annotated[str, MADE]
    take: Take
    """The take."""
    camera_ids: tuple[int, ...]
    """The cameras of this recording, as in its row of the sheet."""
    seed: Annotated[int, Whole()]
    """The same seed gives the same recording."""
    duration_s: Positive = 32400.0
    """Length; by default, and at most, that of config.yaml."""
    frame_rate_hz: Positive = 120.0
    """Frames per second."""
    labels: Labels = ("Wand1", "Wand2")
    """Names of the two markers in the file."""

    @field_validator("camera_ids", mode="before")
    @classmethod
    def _of_take(cls, value: object, info: ValidationInfo) -> object:
        if "take" not in info.data:
            return ()
        n = info.data["take"].cameras
        ids = tuple(value) if isinstance(value, list | tuple) else ()
        right = all(type(one) is int and 1 <= one <= n for one in ids)
        if not right or len(ids) < 2 or len(set(ids)) < len(ids):
            raise Unfit(f"two or more different whole numbers from 1 to {n}", value)
        return ids

    @model_validator(mode="after")
    def _of_its_markers(self) -> TakeTwin:
        check_markers(self.take.drift_mm_per_h, self.labels, "take.drift_mm_per_h")
        return self


def facility(take: Take) -> tuple[Facility, np.ndarray]:
    """The cameras, and the standard deviation of the centroids of each in pixels."""
    layout = random_facility(
        np.random.default_rng(take.layout_seed), take.cameras, take.camera_type
    )
    rng = stream("take", take.layout_seed, "spread")
    noise = take.centroid_px * np.exp(take.spread * rng.standard_normal(take.cameras))
    if take.failing:
        noise[take.failing.camera - 1] = take.failing.times * take.centroid_px
    return layout, noise


def centroid_errors(take: Take, seed: int, camera: int, n_frames: int) -> Iterator[Floats]:
    """(2 directions, n) errors in pixels that one camera, numbered from 1, makes of either
    marker."""
    noise = facility(take)[1][camera - 1]
    draw = stream("take", seed, f"camera {camera}")
    for _ in range(2):
        errors = draw.standard_normal((2, n_frames))
        errors *= noise
        yield errors


def motion(take: Take, labels: tuple[str, str], seed: int, rate_hz: float, n: int) -> np.ndarray:
    """(2, 3, n) motion of the markers in mm, 0 in the first frame.

    A random walk of PSD h f^-2 has steps of variance 2 pi^2 h tau_0.
    """
    steps = stream("take", seed, "motion").standard_normal((2, 3, n))
    steps *= np.sqrt(2 * np.pi**2 * take.h_m2 / rate_hz)
    steps[:, :, 0] = 0.0
    path = np.cumsum(steps, axis=2, out=steps)
    hours = np.arange(n) / (3600 * rate_hz)
    for label, velocity in take.drift_mm_per_h.items():
        path[labels.index(label)] += np.outer(velocity, hours)
    return path


def simulate_take(twin: TakeTwin) -> SimulatedRecording:
    """Simulate `twin`. Same twin: same bytes."""
    n = frames_of(twin.name, twin.duration_s, twin.frame_rate_hz)
    hall, noise = facility(twin.take)
    subset = sorted(camera - 1 for camera in twin.camera_ids)
    gains = [gain_matrices(hall, marker, [subset])[0] for marker in (0, 1)]
    position = motion(twin.take, twin.labels, twin.seed, twin.frame_rate_hz, n)
    for index in subset:
        errors = centroid_errors(twin.take, twin.seed, index + 1, n)
        for marker, (gain, error) in enumerate(zip(gains, errors, strict=True)):
            position[marker] += gain[:, :, index] @ error
    position += hall.markers_mm[:, :, None]
    truth = _truth(twin, n, hall, noise)
    return SimulatedRecording(twin.frame_rate_hz, position, truth)


def _truth(twin: TakeTwin, n: int, hall: Facility, noise_px: np.ndarray) -> Row:
    """What the recording was made from; coefficients as of other twins."""
    take, subset = twin.take, [camera - 1 for camera in twin.camera_ids]
    coefficients = {}
    for marker in (0, 1):
        variances = np.diag(joint_covariance(hall, marker, noise_px, [subset]))
        for axis, variance in zip(AXES, variances, strict=True):
            values = {"h_0": 2 * float(variance) / twin.frame_rate_hz, "h_-2": take.h_m2}
            model = NoiseModel.from_coefficients({k: v for k, v in values.items() if v})
            coefficients[f"{axis}{marker + 1}"] = model.coefficients()
    noise = {str(camera): float(noise_px[camera - 1]) for camera in twin.camera_ids}
    failing = take.failing
    return truth_of(
        twin,
        n,
        f"simulated take of {take.cameras} {take.camera_type} cameras round a hall, "
        f"triangulated from {len(subset)}",
        start_mm=hall.markers_mm.tolist(),
        coefficients=coefficients,
        camera_ids=list(twin.camera_ids),
        camera_noise_px=noise,
        failing={"camera": failing.camera, "times": failing.times} if failing else None,
        drift_mm_per_h={label: list(v) for label, v in take.drift_mm_per_h.items()},
        notes=["white noise of each camera; motion of the markers is the same in all subsets"],
    )
