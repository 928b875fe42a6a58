"""Normal equations, covariances and noise of the joint estimate, against dense algebra, numerical
derivatives, closed forms and Monte Carlo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.batch import solve
from mocap_metrology.lighthouse.batch import view as views
from mocap_metrology.lighthouse.batch.problem import (
    GROUPS,
    Layout,
    Priors,
    SideInformation,
    State,
    by_sweep,
    layout,
    start,
)
from mocap_metrology.lighthouse.batch.recording import Recording, more_damping
from mocap_metrology.lighthouse.batch.solve import estimated_noise
from mocap_metrology.lighthouse.batch.trajectory import Trajectory, through
from mocap_metrology.lighthouse.batch.view import Noise
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import Factory, Hits
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import LIBSURVIVE, rotor_parameters

EXACT = Priors(0, 0, 0, 0, 0)
EVERYTHING = Priors(tilt_mrad=4.0, curve_mrad=4.0, gib_mrad=6.0)
FACTORY = Factory(
    np.array([0.03, -0.02]),
    np.array([-0.004, 0.003]),
    np.array([0.002, -0.005]),
    np.array([1.9, -0.8]),
    np.array([0.009, -0.011]),
)


MOVES = {
    **{"pose": {"R", "t_m"}, "depth": {"rotors"}, "offset": {"offsets"}, "intrinsic": {"rotors"}},
    **{"scale": {"board"}, "place": {"board"}, "gravity": {"gravity"}, "cover": {"cover"}},
}
MOVED = set().union(*MOVES.values())


@pytest.mark.parametrize("known_poses", [False, True])
def test_every_unknown_moves_what_it_is_of(known_poses: bool) -> None:
    board, covers = flat_board(), SideInformation(normals=np.tile([1.0, 0.0, 0.0], (32, 1)))
    of = layout(2, len(board), EVERYTHING, known_poses, gravity=True, more=covers)
    rotors = np.array([rotor_parameters(FACTORY)] * 2)
    before = start([np.eye(3)] * 2, np.zeros((2, 3)), rotors, board, of.size)
    before = before.moved(np.zeros(of.size), of)  # amplitudes are positive from then on
    for k, group in enumerate(of.group):
        step = 1e-4 * (np.arange(of.size) == k)
        after = before.moved(step, of)
        moved = {x for x in MOVED if np.ptp(getattr(after, x) - getattr(before, x)) > 1e-9}
        own = MOVES[GROUPS[group]]
        assert len(moved & own) == 1 and moved <= own


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
    trajectory = through(node_s, node_R, node_t, 0.0, 0.41)
    trajectory = trajectory.moved(0.02 * rng.normal(size=trajectory.control.size))
    return views.view(by_sweep(some_hits()), trajectory), trajectory, state, of


def test_basis_is_that_of_scipy() -> None:
    """Position and rotation vector against scipy's B-spline and rotations."""
    _, trajectory, _, _ = begun(EVERYTHING)
    n = len(trajectory.control)
    knots = trajectory.begin_s + trajectory.knot_s * np.arange(-3, n + 1)
    time = np.linspace(0.01, 0.39, 50)
    expected = BSpline(knots, trajectory.control, 3)(time)
    R, p = trajectory.poses(time)
    np.testing.assert_allclose(p, expected[:, :3], atol=1e-12)
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


def test_covariance_of_what_is_considered_but_not_estimated() -> None:
    """20,000 draws of a linear problem: noise, and unknowns larger than the estimate assumes; each
    entry of the covariance within 5 standard errors."""
    rng = np.random.default_rng(7)
    J = rng.normal(size=(30, 5))
    S = J.T @ J
    working, believed = (
        np.array([np.inf, np.inf, 1e-3, 0.5, 2.0]),
        np.array([np.inf, np.inf, 1.0, 1.0, 2.0]),
    )
    expected = solve.covariance_of(S, working, believed)
    known, n = 1 / working**2, 20_000
    true = np.where(np.isfinite(believed), believed, 0) * rng.normal(size=(n, 5))
    measured = true @ J.T + rng.normal(size=(n, 30))
    off = np.linalg.solve(S + np.diag(known), J.T @ measured.T).T - true
    error = np.sqrt((np.outer(np.diag(expected), np.diag(expected)) + expected**2) / n)
    assert (np.abs(off.T @ off / n - expected) < 5 * error).all()


def test_size_of_a_group_by_restricted_likelihood() -> None:
    """Forty unknowns of standard deviation f where 1 is given: f is found within 30 %, and is
    among those not ruled out; of none the least factor is taken."""
    rng = np.random.default_rng(8)
    J = rng.normal(size=(400, 42)) * 5
    S, working = J.T @ J, np.r_[[np.inf] * 2, np.ones(40)]
    own = np.arange(42) >= 2
    for true in (0.0, 0.2, 0.5, 0.9):
        y = np.r_[3.0, -2.0, true * rng.normal(size=40)]
        values = np.zeros(42)
        h = -J.T @ (J @ y + rng.normal(size=400))  # at values 0
        best, most = solve.supported(S, h, values, working, own)
        moved = rng.normal(size=42)  # the same seen from elsewhere
        assert solve.supported(S, h + S @ moved, moved, working, own) == pytest.approx((best, most))
        if true:
            assert true / 1.35 < best < true * 1.35 and best <= most < 2 * true + 0.1
        else:
            assert most <= 0.06


def test_other_data_are_as_good_as_before_where_the_first_have_a_misfit() -> None:
    """Of 30 data 20 err twice as much as assumed: 20,000 draws, within 5 standard errors."""
    rng, n = np.random.default_rng(17), 20_000
    J, sd = rng.normal(size=(30, 4)), np.where(np.arange(30) < 20, 2.0, 1.0)
    S, prior = J.T @ J, np.array([np.inf, np.inf, 1.0, 0.5])
    pull = S + (4 - 1) * (S - J[20:].T @ J[20:])
    expected = solve.covariance_of(S, prior, prior, pull)
    true = np.where(np.isfinite(prior), prior, 0) * rng.normal(size=(n, 4))
    measured = true @ J.T + sd * rng.normal(size=(n, 30))
    off = np.linalg.solve(S + np.diag(1 / prior**2), J.T @ measured.T).T - true
    error = np.sqrt((np.outer(np.diag(expected), np.diag(expected)) + expected**2) / n)
    assert (np.abs(off.T @ off / n - expected) < 5 * error).all()


def test_the_prior_of_the_trajectory_pulls_at_what_scales_with_it_and_hits_do_not() -> None:
    """Angles are the same of a scene of any scale, so hits pull at none."""
    seen, trajectory, state, of = begun(Priors(board_scale=1e-2))
    rng, noise = np.random.default_rng(6), Noise(3e-5, 0.0)
    off = 1e-4 * rng.normal(size=len(seen.sweeps.hits))
    sums = solve.linearised(seen, trajectory, state, off, np.ones(off.size), of)
    part = solve.reduced(sums, trajectory, noise)
    larger = np.zeros(of.size)
    pose = int(of.columns[1, 0, 0])
    larger[pose : pose + 3], larger[of.scale] = state.t_m[1], 1.0
    whole = larger @ part.h
    assert abs(whole) > 10
    assert abs(larger @ (part.h + solve.by_bends(part, trajectory, noise))) < 0.1 * abs(whole)


def test_a_piece_is_the_same_along_its_own_stretch_of_the_trajectory() -> None:
    """Control points that no hit touches go straight on, which costs nothing."""
    seen, trajectory, state, of = begun(Priors())
    begin = seen.begin
    seen = views.sweeps_of(seen, (begin > 1) & (begin < 5))
    rng, noise, found = np.random.default_rng(7), Noise(3e-5, 5e-5), []
    off = 1e-4 * rng.normal(size=len(seen.sweeps.hits))
    for own, path in ((seen, trajectory), views.stretch(seen, trajectory)):
        sums = solve.linearised(own, path, state, off, np.ones(off.size), of)
        part = solve.reduced(sums, path, noise)
        found.append((part.S, part.h + solve.by_bends(part, path, noise)))
    assert len(path.control) < len(trajectory.control)
    unit = 1 / np.sqrt(np.diag(found[0][0]).clip(1e-30))
    np.testing.assert_allclose(*(np.outer(unit, unit) * S for S, _ in found), atol=1e-5)
    np.testing.assert_allclose(*(unit * h for _, h in found), atol=1e-4)


def test_a_step_is_damped_where_it_fails() -> None:
    """The control points of sweeps whose cost rose most; all, where none did or by wish."""
    seen, trajectory, _, _ = begun(Priors())
    off = np.zeros(len(seen.sweeps.hits))
    one = Recording(seen.sweeps, trajectory, seen, Noise(3e-5, 5e-5), off)
    begin, n = seen.begin, len(trajectory.control)
    worse = replace(one, residual=np.where((begin == 4)[seen.sweeps.sweep], 3e-4, 3e-6))
    damping, least = [np.full(n, 0.5)], [np.full(n, 1e-2)]
    for after, everywhere in ((worse, False), (worse, True), (one, False)):
        (own,) = more_damping(damping, least, [one], [after], everywhere)
        where = np.flatnonzero(own == 5.0)
        assert (own[np.setdiff1d(np.arange(n), where)] == 0.5).all()
        assert where.tolist() == list(
            range(4, 9) if after is worse and not everywhere else range(n)
        )


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
