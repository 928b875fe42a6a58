"""Gyroscope, accelerometer and gravity as residuals: derivatives against differences, recordings of
small boards by the generator of this project, still ones of a real recording."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch import inertial, parts
from mocap_metrology.lighthouse.batch.problem import (
    INERTIAL_SD,
    Layout,
    Priors,
    State,
    first_gravity,
    gravity_equations,
    start,
)
from mocap_metrology.lighthouse.batch.problem import layout as layout_of
from mocap_metrology.lighthouse.batch.trajectory import Trajectory, at_rest, trajectory_through
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.scene import Scene, Sensors
from mocap_metrology.lighthouse.calibrate.static import median_angles
from mocap_metrology.lighthouse.decode.chain import Decoded
from mocap_metrology.lighthouse.records import Inertial
from mocap_metrology.lighthouse.simulate.motion import motion_of
from mocap_metrology.lighthouse.simulate.recording import sensed, simulate, up_of
from mocap_metrology.lighthouse.simulate.twin import BoardTwin, InertialTwin, MotionTwin
from tests.lighthouse import pairs
from tests.lighthouse.batch.planes_scene import made, room
from tests.lighthouse.batch.planes_scene import motion as hand

DECK = BoardTwin(columns=2, rows=2, width_m=0.03, height_m=0.015)
HITS_S = np.linspace(0.1, 2.8, 100)
UP = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])


def of_motion(**more: object) -> Inertial:
    """Sensors of a hand's motion, by finite differences in `sensed`."""
    motion = motion_of(MotionTwin(centre_m=(3.0, 0.0, 0.0)), np.zeros((1, 3)), 5)
    twin = InertialTwin(place_m=(0.02, 0.05, -0.01), **more)
    return sensed(motion, UP, twin, 3.0, np.random.default_rng(1))


def test_noise_of_simulated_sensors_has_the_stated_density() -> None:
    """White noise of density N, per root of 1 Hz, has the variance N^2 times the bandwidth,
    half of the 1000 Hz."""
    silent = of_motion(gyro_density=0.0, accel_density=0.0)
    noisy = of_motion(gyro_density=1e-3, accel_density=2e-2)
    for name, density in (("rate_rad_s", 1e-3), ("force_m_s2", 2e-2)):
        noise = getattr(noisy, name) - getattr(silent, name)
        assert noise.std() == pytest.approx(density * np.sqrt(500), rel=0.03)


def moving() -> Trajectory:
    """Through the motion of `of_motion`, with knots 25 ms apart, fitted by nothing."""
    motion = motion_of(MotionTwin(centre_m=(3.0, 0.0, 0.0)), np.zeros((1, 3)), 5)
    time_s = np.arange(0.0, 3.0, 0.1)
    return trajectory_through(time_s, *motion.poses(time_s), 0.1, 2.8, 0.025)


def values(trajectory: Trajectory) -> tuple[State, Layout]:
    of = layout_of(2, 4, pairs.EXACT, inertial=[True])
    state = start(
        [np.eye(3)] * 2, [np.zeros(3)] * 2, np.zeros((2, 2, 10)), np.zeros((4, 3)), of.size
    )
    own = np.zeros(of.size)
    own[of.inertial[0] :] = (
        0.5 * np.random.default_rng(2).standard_normal(inertial.OWN) * INERTIAL_SD
    )
    return state._replace(gravity=-9.8 * UP, values=own), of


@pytest.mark.parametrize("still", [False, True])
def test_derivatives(still: bool) -> None:
    """Of both residuals, by gravity, all unknowns of the sensors, and the control points."""
    trajectory = moving()
    if still:
        trajectory = at_rest(rotation.exp(np.array([0.3, 0.2, 0.1])), np.array([1.0, 2.0, 3.0]))
    seen = inertial.windows(of_motion(), trajectory, HITS_S)
    assert seen is not None
    state, of = values(trajectory)
    column = of.inertial[0]
    found = inertial.residuals(seen, trajectory, state, column)
    near, far = inertial.derivatives(seen, found)

    def difference(at: Callable[[float], tuple[Trajectory, State]], step: float) -> np.ndarray:
        a, b = (inertial.residuals(seen, *at(x), column).e for x in (step, -step))
        return ((a - b) / (2 * step)).reshape(-1, 6)

    def moved(k: int) -> Callable[[float], tuple[Trajectory, State]]:
        def at(x: float) -> tuple[Trajectory, State]:
            step = np.zeros(of.size)
            step[(of.gravity if k < 3 else column - 3) + k] = x
            return trajectory, state.moved(step, of)

        return at

    for k in range(3 + inertial.OWN):
        of_k = difference(moved(k), 1e-5)
        scale = max(np.abs(of_k).max(), 1.0)
        # that by the gyroscope's bias leaves the motion within an interval out
        np.testing.assert_allclose(far[:, :, k], of_k, atol=(0.02 if 3 <= k < 6 else 2e-3) * scale)
    row = len(seen.interval) // 2
    for k in range(6 if still else inertial.NEAR):

        def of_knot(x: float, k: int = k) -> tuple[Trajectory, State]:
            step = np.zeros(trajectory.control.size)
            step[6 * seen.interval[row] + k] = x
            return trajectory.moved(step), state

        of_k = difference(of_knot, 1e-6)[row]
        np.testing.assert_allclose(near[row, :, k], of_k, atol=2e-3 * max(np.abs(of_k).max(), 1.0))


def test_the_robust_cost_is_what_its_weights_minimise() -> None:
    """The integral of twice the weight times the residual, in standard deviations."""
    z, noise = np.linspace(0, 12, 4001), np.array([0.02, 0.3])
    e = z[:, None, None] * noise[:, None] * np.array([1.0, -1.0, 1.0])
    weight, costs = inertial._robust(e, noise)
    wanted = cumulative_simpson(2 * weight * z[:, None, None], x=z, axis=0, initial=0)
    np.testing.assert_allclose(costs, wanted, atol=1e-4)
    assert np.all(weight[z < 2] == 1) and np.all(weight[-1] < 0.3)


def test_exact_sensors_leave_nothing_of_the_true_motion() -> None:
    """With a trajectory through the true poses, the integrals over an interval are those that the
    sensors measure: 1 mrad/s and 10 mm/s^2, what is left is the spline's."""
    none = dict.fromkeys(
        ("gyro_density", "accel_density", "gyro_bias_rad_s", "accel_bias_m_s2"), 0.0
    )
    none |= dict.fromkeys(
        ("accel_scale_error", "place_error_mm", "turn_error_deg", "delay_ms"), 0.0
    )
    series, motion = (
        of_motion(**none),
        motion_of(MotionTwin(centre_m=(3.0, 0.0, 0.0)), np.zeros((1, 3)), 5),
    )
    seen = inertial.windows(series, moving(), HITS_S)
    assert seen is not None
    R, p = motion.poses(seen.time_s.ravel())
    R, p = R.reshape(-1, 3, 3, 3), p.reshape(-1, 3, 3)
    turn, force = inertial.sensed(seen, np.zeros(3), 0.0)
    np.testing.assert_allclose(turn, np.swapaxes(R[:, 0], 1, 2) @ R[:, 2], atol=1e-7)
    q = p + R @ series.place_m
    a = (q[:, 0] - 2 * q[:, 1] + q[:, 2]) / 0.0125**2 + 9.81 * UP
    np.testing.assert_allclose(force, np.einsum("nji,nj->ni", R[:, 1], a), atol=1e-4)


def test_gravity_by_the_stations_ways_up() -> None:
    """The equations are those of the least squares: differences of half their sum."""
    of = layout_of(2, 4, pairs.EXACT, gravity=True)
    R = [np.eye(3), rotation.exp(np.array([0.2, -0.4, 1.0]))]
    state = start(R, [np.zeros(3)] * 2, np.zeros((2, 2, 10)), np.zeros((4, 3)), of.size)
    ups = np.array([UP, R[1].T @ rotation.exp(np.array([0.03, 0.01, 0.0])) @ UP])
    state = state._replace(gravity=first_gravity(state, ups) + np.array([0.02, 0.01, 0.05]))
    S, h, _ = gravity_equations(state, of, ups)

    def gradient(at: State) -> np.ndarray:
        return gravity_equations(at, of, ups)[1]

    for k in [3, 4, 5, *range(of.gravity, of.gravity + 3)]:
        step = np.zeros(of.size)
        step[k] = 1e-6
        a, b = state.moved(step, of), state.moved(-step, of)
        cost = [gravity_equations(one, of, ups)[2] for one in (a, b)]
        assert (cost[0] - cost[1]) / 4e-6 == pytest.approx(h[k], rel=1e-4, abs=1e-4)
        np.testing.assert_allclose((gradient(a) - gradient(b)) / 2e-6, S[k], atol=0.05 * S.max())
    one = gravity_equations(state, of, np.array([UP, [np.nan] * 3]))[0]
    assert not one[3:6].any() and one[of.gravity, of.gravity] > 0


TURNED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
WRONG: dict[str, Callable[[Inertial], Inertial]] = {
    "axes of another frame": lambda own: replace(
        own, rate_rad_s=own.rate_rad_s @ TURNED, force_m_s2=own.force_m_s2 @ TURNED
    ),
    "forces in g": lambda own: replace(own, force_m_s2=own.force_m_s2 / 9.81),
    "late by 60 ms": lambda own: replace(own, time_s=own.time_s + 0.06),
}


@pytest.mark.parametrize("case", WRONG)
def test_sensors_that_contradict_the_light_are_not_used(case: str) -> None:
    """The estimate is that of the light alone, and its note says why."""
    twin = pairs.twin(1, board=DECK)
    made = simulate(twin)
    series = sensed(
        made.truth.motion, up_of(twin), InertialTwin(), twin.duration_s, np.random.default_rng(4)
    )
    scene = pairs.scene(made)
    alone, _ = joint(scene)
    found, note = joint(replace(scene, sensors=Sensors(WRONG[case](series))))
    assert note.startswith("gyroscope and accelerometer not used: ")
    np.testing.assert_array_equal(found.state.t_m, alone.state.t_m)


def test_an_accelerometer_turned_from_the_gyroscope_is_not_used() -> None:
    """By 20 deg, on a dome that turns: bias, gravity and noise can share that among them."""
    given, axis = made(2, 3, 3.0, place_mm=0.2, priors=Priors(phase_mrad=0.0)), np.ones(3) / 3**0.5
    R_0, t_0 = room(2, 3)[0]

    class OfFirst:
        @staticmethod
        def poses(time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            R, p = hand(time_s, 3)
            return R_0.T @ R, (p - t_0) @ R_0

    how = R_0.T @ [0.0, 0, 1], InertialTwin(), 3.0, np.random.default_rng(4)
    series = sensed(OfFirst, *how)  # type: ignore[arg-type]
    turned = series.force_m_s2 @ rotation.exp(np.radians(20) * axis)
    notes = [
        joint(replace(given.scene, sensors=Sensors(one)))[1]
        for one in (series, replace(series, force_m_s2=turned))
    ]
    assert notes[0] == ""
    assert "their orientation to each other would be 20 standard deviations off" in notes[1]


def test_light_with_gaps_suffices_where_it_does_alone() -> None:
    """Seen for 0.4 s of each second; with sensors the path has twice the knots, which so few hits
    do not determine."""
    twin = pairs.twin(2, board=DECK, duration_s=2.0)
    made = simulate(twin)
    series = sensed(
        made.truth.motion, up_of(twin), InertialTwin(), twin.duration_s, np.random.default_rng(4)
    )
    scene = pairs.scene(made, made.hits.take(made.hits.time_s % 1.0 < 0.4))
    found, _ = joint(replace(scene, sensors=Sensors(series)))
    off = pairs.error(found.state.R[1], found.state.t_m[1], made.truth.R, made.truth.t_optical_m)
    assert (np.abs(off) < 3 * np.sqrt(np.diag(found.pose_covariance()))).all()


def test_a_piece_of_a_recording_has_the_sensors_of_its_own_time() -> None:
    """With those of all times it would count them twelve times, beside a path without hits."""
    twin = pairs.twin(1, board=DECK, duration_s=2.0)
    made = simulate(twin)
    series = sensed(
        made.truth.motion, up_of(twin), InertialTwin(), twin.duration_s, np.random.default_rng(4)
    )
    found, _ = joint(replace(pairs.scene(made), sensors=Sensors(series)))
    (one,) = found.recordings
    e = one.sensors.residual.e.copy()
    e[len(e) // 2 :] += 1.0
    touched = replace(one.sensors, residual=replace(one.sensors.residual, e=e))
    both = [parts.pieces_of(found, each) for each in (one, replace(one, sensors=touched))]
    same = [np.array_equal(a.h, b.h) for a, b in zip(*both, strict=True)]
    assert same[:5] == [True] * 5 and same[7:] == [False] * 5


def test_a_real_headset_at_rest(headset: dict[str, Decoded]) -> None:
    """The way up by its accelerometer, through its description and the calibration, is that
    which both stations transmit, to 3 deg (single stations are wrong by 1 to 2.5); and the
    stations' ways up as residuals do not make the covariance larger."""
    given = headset["HMD"]
    assert given.pulses is not None
    series = given.pulses.inertial
    assert series is not None and 200 < len(series) / given.duration_s < 1100
    assert np.linalg.norm(series.force_m_s2.mean(axis=0)) == pytest.approx(9.81, abs=0.2)
    ups = np.array([station.gravity for station in given.stations])
    middle = [median_angles(given.hits, k, len(given.board)) for k in (0, 1)]
    factories = [station.factory for station in given.stations]
    scene = Scene(given.hits, given.board, "factory", factories, None, "crazyflie", Priors())
    still = middle[0], middle[1]
    alone, _ = joint(scene, still)
    both, _ = joint(replace(scene, sensors=Sensors(series, ups)), still)
    R = both.recordings[0].trajectory.node_R[0]
    turn = both.recordings[0].trajectory.control[0, 3:]
    up = R @ Rotation.from_rotvec(turn).as_matrix() @ series.force_m_s2.mean(axis=0)
    up /= np.linalg.norm(up)
    for own, seen in zip(both.state.R, ups, strict=True):
        assert np.degrees(np.arccos(up @ own @ seen)) < 3
    traces = [np.trace(replace(one, misfit=1.0).pose_covariance()) for one in (both, alone)]
    assert traces[0] < 1.01 * traces[1]
