"""Gain by gyroscope and accelerometer in calibration and tracking, by Monte Carlo.

    python -m benchmarks.inertial [--setups 10] [--recordings 4]
    python -m benchmarks.inertial --real lh1_test_cal.rec.gz

Recordings as those of joint_calibration.py, calibrated by `batch` from the light alone and with a
gyroscope and an accelerometer on the board: white noise of 0.01 deg/s and 300 ug per root of 1 Hz,
biases of 0.02 rad/s and 0.1 m/s^2, scale wrong by 0.3 %, place by 1 mm, orientation by 0.5 deg, and
3 ms late. Errors of the slave's pose are rms over all recordings, beside the standard deviations
that the estimates state; errors of the board along its trajectory are medians of the rms of
recordings. With --real, the standard deviations of the pose by tracked objects at rest, from the
light alone, with their sensors, and with the way up that the stations transmit.
"""

from __future__ import annotations

import argparse
import tempfile
import time

import numpy as np

from benchmarks import head, line
from benchmarks.joint_calibration import DECK, ZEROS, real
from benchmarks.poses import UNITS, decoded, held, mahalanobis, off_joint
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.scene import Scene, Sensors
from mocap_metrology.lighthouse.calibrate.static import median_angles
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, sensed, up_of
from mocap_metrology.lighthouse.simulate.twin import InertialTwin

SENSORS = InertialTwin(place_m=(0.0, 0.02, 0.01))
BOARDS = {"32 diodes, 240 x 160 mm": {}, "four diodes, 30 x 15 mm": {"board": DECK}}
END_S = 0.2  # of a trajectory, which few hits determine


def both(made: SimulatedSweeps, seed: int) -> list[np.ndarray] | None:
    """A row of numbers from the light alone, and one with the sensors."""
    with tempfile.TemporaryDirectory() as folder:
        given = decoded(made, made.truth.board, folder)
    rng = np.random.default_rng([17, seed])
    series = sensed(made.truth.motion, up_of(made.twin), SENSORS, made.twin.duration_s, rng)
    factories, rows = [station.factory for station in given.stations], []
    for sensors in (Sensors(), Sensors(series)):
        how = "factory", factories, None, "crazyflie", ZEROS
        begun = time.process_time()
        try:
            found, _ = joint(Scene(given.hits, given.board, *how, sensors=sensors))
        except Refusal as refusal:
            print(f"  {seed}: {refusal}", flush=True)
            return None
        rows.append(np.r_[numbers(found, made), time.process_time() - begun])
    return rows


def numbers(found: Joint, made: SimulatedSweeps) -> np.ndarray:
    """Squared errors and variances of position and rotation, m2, errors of the board."""
    error = off_joint(made, found)
    C = found.pose_covariance() * np.outer(UNITS, UNITS)
    time_s = np.arange(END_S, made.twin.duration_s - END_S, 0.01)
    R, p = found.recordings[0].trajectory.poses(time_s)
    R_true, p_true = made.truth.motion.poses(time_s)
    turn = rotation.log(R @ np.swapaxes(R_true, 1, 2))
    squares = [error[:3] @ error[:3], error[3:] @ error[3:]]
    variances = [np.trace(C[:3, :3]), np.trace(C[3:, 3:])]
    of_board = [
        np.sqrt(np.mean(np.sum(x**2, axis=1))) * unit
        for x, unit in ((p - p_true, 1e3), (turn, 180 / np.pi))
    ]
    return np.r_[squares, variances, mahalanobis(error, C), of_board]


def at_rest(path: str, name: str) -> None:
    """A line for each choice of data, of one object of a libsurvive recording."""
    given = decode(path, "libsurvive-rec", name)
    assert given.pulses is not None
    ups = np.array([station.gravity for station in given.stations])
    factories = [station.factory for station in given.stations]
    master, slave = (median_angles(given.hits, k, len(given.board)) for k in (0, 1))
    how = "factory", factories, None, "crazyflie", Priors()
    for data, sensors in (
        ("light", Sensors()),
        ("and sensors", Sensors(given.pulses.inertial)),
        ("and ways up", Sensors(None, ups)),
    ):
        scene = Scene(given.hits, given.board, *how, sensors=sensors)
        sd = np.sqrt(np.diag(joint(scene, (master, slave))[0].pose_covariance())) * UNITS
        cells = " / ".join(f"{x:.1f}" for x in sd[:3]), " / ".join(f"{x:.2f}" for x in sd[3:])
        line(name, data, *cells)


def simulated(setups: int, recordings: int) -> None:
    """A line for each board and choice of data."""
    head(
        *("board", "data", "converged", "rms error of the slave: mm, deg", "stated: mm, deg"),
        *("68 %, 95 % ellipsoids hold, %", "rms error of the board: mm, deg", "CPU s"),
    )
    for board, more in BOARDS.items():
        pairs = [(s, k) for s in range(setups) for k in range(recordings)]
        rows = [both(real(s, k, **more), 100 * s + k) for s, k in pairs]
        used = np.array([row for row in rows if row is not None])
        for data, own in zip(("light", "and sensors"), np.moveaxis(used, 1, 0), strict=True):
            rms = np.sqrt(own[:, :4].mean(axis=0))
            inside = held(own[:, 4])
            mm, deg, cpu = np.median(own[:, 5:], axis=0)
            line(
                *(board, data, f"{len(used)} of {len(rows)}", f"{rms[0]:.2f}, {rms[1]:.3f}"),
                *(f"{rms[2]:.2f}, {rms[3]:.3f}", f"{inside[0]:.0f}, {inside[1]:.0f}"),
                *(f"{mm:.2f}, {deg:.3f}", f"{cpu:.2f}"),
            )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--setups", type=int, default=10)
    parser.add_argument("--recordings", type=int, default=4, help="of each setup")
    parser.add_argument("--real", help="libsurvive recording of the objects HMD and T20 at rest")
    asked = parser.parse_args()
    if asked.real:
        head("object", "data", "stated: x / y / z mm", "about x / y / z deg")
        for name in ("HMD", "T20"):
            at_rest(asked.real, name)
    else:
        simulated(asked.setups, asked.recordings)
