"""Normal equations, covariances and noise of the joint estimate, against dense algebra, numerical
derivatives, closed forms and Monte Carlo."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.batch import solve
from mocap_metrology.lighthouse.batch import view as views
from mocap_metrology.lighthouse.batch.problem import Layout, Priors, State, by_sweep, layout, start
from mocap_metrology.lighthouse.batch.solve import estimated_noise
from mocap_metrology.lighthouse.batch.trajectory import Trajectory, trajectory_through
from mocap_metrology.lighthouse.batch.view import Noise
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import Factory, Hits
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import LIBSURVIVE, rotor_parameters

EXACT = Priors(0, 0, 0, 0, 0)
EVERYTHING = Priors(tilt_mrad=4.0, curve_mrad=4.0, gib_mrad=6.0)
FACTORY = Factory(
    np.array([0.03, -0.02]), np.array([-0.004, 0.003]), np.array([0.002, -0.005]),
    np.array([1.9, -0.8]), np.array([0.009, -0.011]),
)  # fmt: skip


def some_hits(n: int = 400) -> Hits:
    """Hits in any order within 0.4 s; angles are not those of any board."""
    rng = np.random.default_rng(3)
    cycle = np.sort(rng.integers(0, 48, n)).astype(np.int32)
    # one hit of a diode in a sweep
    diode = np.concatenate([rng.permutation(8)[:c] for c in np.bincount(cycle) if c])
    cycle = np.concatenate([np.full(min(c, 8), k) for k, c in enumerate(np.bincount(cycle))])
    n = min(cycle.size, diode.size)
    cycle, diode = cycle[:n], diode[:n]
    time = cycle / 120 + rng.uniform(0.002, 0.006, n)
    angle = rng.normal(0, 0.3, n)
    station, axis = (cycle // 2 % 2).astype(np.int8), (cycle % 2).astype(np.int8)
    return Hits(station, axis, cycle, diode.astype(np.int16), time, angle, np.full(n, 4e-6))


def begun(priors: Priors) -> tuple[views.View, Trajectory, State, Layout]:
    rng = np.random.default_rng(4)
    board = flat_board(4, 2)
    of = layout(2, len(board), priors)
    poses = [np.eye(3), from_angles(0.2, -0.1, -0.6)], [np.zeros(3), np.array([0.4, 2.0, 0.2])]
    rotors = np.array([rotor_parameters(FACTORY, None, LIBSURVIVE), rotor_parameters(FACTORY)])
    state = start(*poses, rotors, board, of.size)
    node_s = np.linspace(0, 0.4, 6)
    node_R = np.array([from_angles(0.3 * k / 5, 0.1, 3.2 - 0.2 * k / 5) for k in range(6)])
    node_t = np.column_stack([3 + node_s, np.sin(5 * node_s), 0.1 * node_s])
    trajectory = trajectory_through(node_s, node_R, node_t, 0.0, 0.41)
    trajectory = trajectory.moved(0.02 * rng.normal(size=trajectory.control.size))
    return views.view(by_sweep(some_hits()), trajectory), trajectory, state, of


def test_nodes_on_a_straight_line_make_that_line() -> None:
    """As uniform B-splines do, but within a knot of the ends, beyond which it is held."""
    node_s, velocity = np.linspace(0, 0.41, 6), np.array([1.0, -0.5, 0.2])
    path = trajectory_through(
        node_s, np.tile(np.eye(3), (6, 1, 1)), node_s[:, None] * velocity, 0.0, 0.41
    )
    time = np.linspace(path.knot_s, 0.41 - 2 * path.knot_s, 30)
    np.testing.assert_allclose(path.poses(time)[1], time[:, None] * velocity, atol=1e-12)


def test_basis_is_that_of_scipy() -> None:
    """Position and rotation vector against scipy's B-spline and rotations."""
    _, trajectory, _, _ = begun(EVERYTHING)
    n = len(trajectory.control)
    knots = trajectory.begin_s + trajectory.knot_s * np.arange(-3, n + 1)
    time = np.linspace(0.01, 0.39, 50)
    expected = BSpline(knots, trajectory.control, 3)(time)
    R, p = trajectory.poses(time)
    np.testing.assert_allclose(p, expected[:, :3], atol=1e-12)
    np.testing.assert_allclose(trajectory.halved().poses(time)[1], p, atol=1e-12)
    turned = trajectory.reference(time) @ Rotation.from_rotvec(expected[:, 3:]).as_matrix()
    np.testing.assert_allclose(R, turned, atol=1e-12)


def numerical_jacobian(
    seen: views.View, trajectory: Trajectory, state: State, of: Layout
) -> np.ndarray:
    """Derivatives (hits, control points + globals) by central differences."""
    columns, eps = [], 1e-6
    for k in range(trajectory.control.size):
        unit = np.zeros(trajectory.control.size)
        unit[k] = eps
        high = views.residuals(seen, trajectory.moved(unit), state)
        columns.append((high - views.residuals(seen, trajectory.moved(-unit), state)) / (2 * eps))
    for k in range(of.size):
        unit = np.zeros(of.size)
        unit[k] = eps
        high = views.residuals(seen, trajectory, state.moved(unit, of))
        low = views.residuals(seen, trajectory, state.moved(-unit, of))
        columns.append((high - low) / (2 * eps))
    return np.array(columns).T


def dense(band: np.ndarray) -> np.ndarray:
    n = band.shape[1]
    full = np.zeros((n, n))
    for k in range(len(band)):
        full[np.arange(k, n), np.arange(n - k)] = band[k, : n - k]
    return full + np.tril(full, -1).T


@pytest.mark.parametrize("priors", [EVERYTHING, Priors(), EXACT])
def test_sums_are_those_of_numerical_derivatives(priors: Priors) -> None:
    seen, trajectory, state, of = begun(priors)
    rng = np.random.default_rng(5)
    e = views.residuals(seen, trajectory, state)
    w = rng.uniform(0.1, 1, e.size)
    sums = solve.linearised(seen, trajectory, state, e, w, of)
    J = numerical_jacobian(seen, trajectory, state, of)
    H, g = J.T @ (w[:, None] * J), J.T @ (w * e)
    scale = np.sqrt(np.outer(np.diag(H), np.diag(H))) + 1e-12
    own = sums.hits
    found = np.block([[dense(own.band), own.cross], [own.cross.T, own.inner]])
    assert np.abs((found - H) / scale).max() < 1e-6
    np.testing.assert_allclose(np.r_[own.g, own.g_inner], g, atol=1e-6 * np.abs(g).max())
    assert sums.square == pytest.approx(float(w @ e**2))


def test_offsets_of_sweeps_are_integrated_out() -> None:
    """S and h against the whole matrix with V = sigma^2 diag(1/w) + sigma_c^2 11' of each sweep."""
    seen, trajectory, state, of = begun(Priors())
    rng = np.random.default_rng(6)
    e = 1e-4 * rng.normal(size=len(seen.sweeps.hits))
    w, noise = rng.uniform(0.2, 1, e.size), Noise(40e-6, 70e-6)
    sums = solve.linearised(seen, trajectory, state, e, w, of)
    part = solve.reduced(sums, trajectory, noise)
    same = seen.sweeps.sweep[:, None] == seen.sweeps.sweep
    V = np.diag(noise.hit**2 / w) + noise.sweep**2 * same
    J, K = numerical_jacobian(seen, trajectory, state, of), trajectory.control.size
    H, g = J.T @ np.linalg.solve(V, J), J.T @ np.linalg.solve(V, e)
    bend, bend_g = solve._bend(trajectory, noise.hit)
    A = H[:K, :K] + dense(bend) / noise.hit**2
    C, g_A = H[:K, K:], g[:K] + bend_g / noise.hit**2
    S = H[K:, K:] - C.T @ np.linalg.solve(A, C)
    h = g[K:] - C.T @ np.linalg.solve(A, g_A)
    scale = np.sqrt(np.outer(np.diag(S), np.diag(S)))
    assert np.abs((part.S - S) / scale).max() < 1e-4
    np.testing.assert_allclose(part.h / np.sqrt(np.diag(S)), h / np.sqrt(np.diag(S)), atol=1e-3)
    step = rng.normal(size=of.size) * 1e-4
    expected = -np.linalg.solve(A, g_A + C @ step)
    assert np.abs(part.trajectory_step(step) - expected).max() < 1e-3 * np.abs(expected).max()


@pytest.mark.parametrize(("common", "share"), [(60e-6, 0.0), (60e-6, 0.04), (0.0, 0.0)])
def test_noise_by_restricted_likelihood(common: float, share: float) -> None:
    """Of hits and of sweeps about the angles of a trajectory that is estimated with them, also
    where a share of the sweeps is wrong, by up to 50 mrad."""
    seen, trajectory, state, of = begun(EXACT)
    n, hits, found = seen.sweeps.first.size - 1, seen.sweeps.hits, []
    for seed in range(12):
        rng = np.random.default_rng([18, seed])
        shift = common * rng.normal(size=n)
        wrong = rng.choice(n, round(share * n), replace=False)
        shift[wrong] += rng.choice([-1, 1], wrong.size) * rng.uniform(1e-3, 5e-2, wrong.size)
        off = 30e-6 * rng.normal(size=len(hits)) + shift[seen.sweeps.sweep]
        own = views.weights(seen, off, Noise(30e-6, 60e-6))
        sums = solve.linearised(seen, trajectory, state, off, own.hit, of, held=own.held)
        found.append(estimated_noise(sums, trajectory, Noise(30e-6, 30e-6)))
    assert np.mean([one.hit for one in found]) == pytest.approx(30e-6, rel=0.1)
    sweep = np.mean([one.sweep for one in found])
    assert sweep == pytest.approx(common, rel=0.15) if common else sweep < 12e-6


def test_negative_information_is_no_solution() -> None:
    """As hits of a wrong clock left it."""
    with pytest.raises(np.linalg.LinAlgError):
        solve.solved(np.diag([1.0, -1.0]), np.ones(2))
