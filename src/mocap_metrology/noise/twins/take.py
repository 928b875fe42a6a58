"""A simulated take: every camera has its own noise, and recordings are subsets of the cameras.

The position of a marker from a subset is start + motion + A^-1 sum_i J_i^T e_i (`triangulation`),
with the centroid errors e_i of the cameras in it. They and the motion depend on the seed and the
camera alone, so recordings of two subsets with one seed hold the same frames: what they have in
common is what real subsets of a take have in common.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Row
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.simulate import AXES, SimulatedRecording, stream
from mocap_metrology.noise.twins.triangulation import (
    Facility,
    gain_matrices,
    joint_covariance,
    random_facility,
)
from mocap_metrology.noise.twins.twin import Point


@dataclass(frozen=True)
class Failing:
    """The centroid noise of this camera is so many times that of the others."""

    camera: int
    times: float


@dataclass(frozen=True)
class Take:
    """Cameras 1 to `cameras` of one type round the hall, placed at random by `layout_seed`.

    centroid_px: standard deviation of a centroid in each direction, white; from camera to camera
    it differs by a log-normal factor whose logarithm has the standard deviation `spread`. The
    failing camera has `times` the nominal one. `h_m2`: random walk of every coordinate of the
    markers, one-sided PSD h f^-2 in mm^2 Hz; drift: their velocity, by label.
    """

    camera_type: str
    cameras: int
    layout_seed: int
    centroid_px: float
    spread: float = 0.0
    failing: Failing | None = None
    h_m2: float = 0.0
    drift_mm_per_h: Mapping[str, Point] = field(default_factory=dict)


@dataclass(frozen=True)
class TakeTwin:
    """A recording of a take by the cameras `camera_ids`."""

    name: str
    take: Take
    camera_ids: tuple[int, ...]
    seed: int
    duration_s: float = 32400.0
    frame_rate_hz: float = 120.0
    labels: tuple[str, str] = ("Wand1", "Wand2")


def facility(take: Take) -> tuple[Facility, np.ndarray]:
    """The cameras, and the standard deviation of the centroids of each in pixels."""
    found = random_facility(np.random.default_rng(take.layout_seed), take.cameras, take.camera_type)
    rng = stream("take", take.layout_seed, "spread")
    noise = take.centroid_px * np.exp(take.spread * rng.standard_normal(take.cameras))
    if take.failing:
        noise[take.failing.camera - 1] = take.failing.times * take.centroid_px
    return found, noise


def centroid_errors(take: Take, seed: int, camera: int, n_frames: int) -> np.ndarray:
    """(2 markers, 2 directions, n) errors in pixels that one camera, numbered from 1, makes."""
    noise = facility(take)[1][camera - 1]
    found: np.ndarray = noise * stream("take", seed, f"camera {camera}").standard_normal(
        (2, 2, n_frames)
    )
    return found


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


def simulate_take(twin: TakeTwin, seed: int | None = None) -> SimulatedRecording:
    """Simulate `twin` with `seed` (default: its own). Same twin and seed: same bytes."""
    seed = twin.seed if seed is None else seed
    n = round(twin.duration_s * twin.frame_rate_hz)
    if n < 16:
        raise Refusal(
            f"twin {twin.name}: duration {twin.duration_s:g} s, expected 16 frames at least"
        )
    hall, noise = facility(twin.take)
    subset = sorted(camera - 1 for camera in twin.camera_ids)
    gains = [gain_matrices(hall, marker, [subset])[0] for marker in (0, 1)]
    position = motion(twin.take, twin.labels, seed, twin.frame_rate_hz, n)
    for index in subset:
        errors = centroid_errors(twin.take, seed, index + 1, n)
        for marker, gain in enumerate(gains):
            position[marker] += gain[:, :, index] @ errors[marker]
    position += hall.markers_mm[:, :, None]
    truth = _truth(twin, seed, n, hall, noise)
    return SimulatedRecording(twin.frame_rate_hz, position, truth)


def _truth(twin: TakeTwin, seed: int, n: int, hall: Facility, noise_px: np.ndarray) -> Row:
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
    return {
        "twin": twin.name,
        "source": f"simulated take of {take.cameras} {take.camera_type} cameras round a hall, "
        f"triangulated from {len(subset)}",
        "seed": seed,
        "form": "sampled",
        "frame_rate_hz": twin.frame_rate_hz,
        "n_frames": n,
        "labels": list(twin.labels),
        "start_mm": hall.markers_mm.tolist(),
        "coefficients": coefficients,
        "camera_ids": list(twin.camera_ids),
        "camera_noise_px": noise,
        "failing": {"camera": failing.camera, "times": failing.times} if failing else None,
        "drift_mm_per_h": {label: list(v) for label, v in take.drift_mm_per_h.items()},
        "notes": ["white noise of each camera; motion of the markers is the same in all subsets"],
    }
