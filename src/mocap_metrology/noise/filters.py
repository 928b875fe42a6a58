"""Noise of one frame for state estimators: ROS covariances, parameters of PX4's EKF2.

The variance is that of one frame about the mean of the horizon, `frame_mm` of verdict.json: a
filter that takes the white part alone for all of the noise believes in the slow rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.common.documents import yaml_text

UNKNOWN_RAD2 = 1e6  # of an orientation that was not measured: no filter takes notice of it
# Floors of EKF2_EVP_NOISE and EKF2_EVA_NOISE [PX4-Autopilot, module.yaml of ekf2]
FLOORS = {"EKF2_EVP_NOISE": (0.01, "m"), "EKF2_EVA_NOISE": (0.05, "rad")}
FLAT = 0.02  # least spread across a line of markers, as a share of that along it
FLOAT = 9  # MAV_PARAM_TYPE_REAL32
OF_STILL = "Noise of one frame about the mean of horizon_s; no scale, distortion or latency."
OF_BAR = (
    "Noise of one frame of a moving bar, without what belongs to its place and pass; half of the "
    "variance of its length for each end and axis."
)
# By marker, and of all markers as one body, None where that is unknown
Covariances = tuple[dict[str, np.ndarray], np.ndarray | None]


def frame_sigma(verdict: Mapping[str, Any]) -> np.ndarray:
    """Standard uncertainty of one frame in m, (markers, 3); NaN where it is unknown."""
    series, n = verdict["series"], len(verdict["labels"])
    sizes = [series.get(f"{a}{k}", {}).get("frame_mm") for k in range(1, n + 1) for a in "xyz"]
    return 1e-3 * np.array(sizes, dtype=np.float64).reshape(n, 3)


def covariances(verdict: Mapping[str, Any], places_mm: np.ndarray) -> Covariances:
    """Pose covariances (6, 6) in m^2 and rad^2: of each marker, and of all as one body.

    verdict: contents of verdict.json; places_mm: (markers, 3), means of the recording.
    """
    sigma = frame_sigma(verdict)
    known = np.isfinite(sigma).all(axis=1) & np.isfinite(places_mm).all(axis=1)
    of_markers = {
        label: np.diag(np.r_[sigma[k] ** 2, [UNKNOWN_RAD2] * 3])
        for k, label in enumerate(verdict["labels"])
        if known[k]
    }
    return of_markers, body_covariance(1e-3 * places_mm[known], sigma[known])


def body_covariance(places: np.ndarray, sigma: np.ndarray) -> np.ndarray | None:
    """Covariance (6, 6) of translation of the markers' centre, and of rotation about it.

    The pose that least squares fit to k >= 3 markers at p_i, whose errors are independent with
    variances S_i = diag(sigma_i^2): with J_i = (I, -[p_i - c]x) and A = sum J_i' J_i it is
    A^-1 (sum J_i' S_i J_i) A^-1 [law of propagation, JCGM 100 5.1]. Equal sigma give s^2/k for the
    translation and s^2 (sum |q_i|^2 I - q_i q_i')^-1 for the rotation.

    places, sigma: (k, 3), of one unit, which the translation has; rotation vectors in rad, in the
    axes of the places. None with fewer than three markers, or on a line, as the rotation about it
    is then unknown.
    """
    if len(places) < 3:
        return None
    centred = places - places.mean(axis=0)
    spread = np.linalg.svd(centred, compute_uv=False)
    if not spread[1] > FLAT * spread[0]:
        return None
    scale = spread[0]  # so that both kinds of unknowns are of one size
    x, y, z = centred.T / scale
    none = np.zeros_like(x)
    cross = np.moveaxis(np.array([[none, z, -y], [-z, none, x], [y, -x, none]]), 2, 0)
    jacobian = np.concatenate([np.broadcast_to(np.eye(3), cross.shape), cross], axis=2)
    inverse = np.linalg.inv(np.einsum("kab,kac->bc", jacobian, jacobian))
    noise = np.einsum("kab,ka,kac->bc", jacobian, sigma**2, jacobian)
    units = np.repeat([1.0, 1.0 / scale], 3)
    return np.asarray(inverse @ noise @ inverse * np.outer(units, units))


def ros_yaml(verdict: Mapping[str, Any], both: Covariances, what: str = OF_STILL) -> str:
    """noise_ros.yaml: `covariance` of geometry_msgs/PoseWithCovariance, row by row; what: the
    numbers are of, in words."""

    def numbers(covariance: np.ndarray) -> list[float]:
        return [float(f"{x:.6g}") for x in covariance.ravel()]

    markers, body = both
    content = {
        "recording": verdict["recording"],
        "horizon_s": round(verdict["horizon_s"], 3),
        "markers": {label: {"covariance": numbers(matrix)} for label, matrix in markers.items()},
        "body": None if body is None else {"markers": list(markers), "covariance": numbers(body)},
    }
    remarks = [
        what,
        "covariance: geometry_msgs/PoseWithCovariance, row by row: x, y, z (m^2), then rotations",
        f"about the fixed axes x, y, z (rad^2; {UNKNOWN_RAD2:g}: not measured).",
        "body: all markers as one rigid body, about their centre; null without three of them",
        "that are not on a line.",
    ]
    return _remarks(remarks) + yaml_text(content)


def px4_params(verdict: Mapping[str, Any], both: Covariances) -> str:
    """px4.params: lower bounds of the noise of external vision, as QGroundControl loads them."""
    markers, body = both
    poses = list(markers.values()) if body is None else [body]
    variances = np.array([np.diag(one) for one in poses]).reshape(-1, 6)
    worst = variances[:, :3].max(initial=-1), variances[:, 3:].max(initial=-1)
    lines, remarks = [], [f"Noise of one frame of {verdict['recording']}, for EKF2."]
    for (name, (floor, unit)), variance in zip(FLOORS.items(), worst, strict=True):
        sigma = math.sqrt(variance) if 0 <= variance < UNKNOWN_RAD2 else math.nan
        measured = f"{sigma:.2g} {unit}" if math.isfinite(sigma) else "not measured"
        binds = "" if sigma > floor else f"; PX4 takes no less than {floor:g} {unit}, which binds"
        remarks.append(f"{name}: {measured}{binds}.")
        lines.append(f"1\t1\t{name}\t{max(floor, np.nan_to_num(sigma)):.6g}\t{FLOAT}\n")
    return _remarks(remarks) + "".join(lines)


def _remarks(lines: Sequence[str]) -> str:
    return "".join(f"# {' '.join(line.split())}\n" for line in lines)
