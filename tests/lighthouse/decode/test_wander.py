"""Wander of a rotor: against dense algebra and by Monte Carlo."""

import numpy as np
import pytest
from scipy import linalg

from mocap_metrology.lighthouse.decode.wander import TurnClock, Wander, wander

SWING = 2 * 0.88 * np.cos(2 * np.pi / 13), 0.88**2  # of real stations


def begins(n: int, seed: int, noise_s: float = 4e-8) -> tuple[np.ndarray, np.ndarray]:
    """A swing of some 250 ns, and begins with noise."""
    rng = np.random.default_rng(seed)
    z = np.zeros(n + 100)
    for t in range(2, z.size):
        z[t] = SWING[0] * z[t - 1] - SWING[1] * z[t - 2] + 7e-8 * rng.standard_normal()
    return z[100:], z[100:] + noise_s * rng.standard_normal(n)


def covariance(n: int, stiffness: float) -> np.ndarray:
    """Of the process over the variance of a begin: by its autocovariance, from the Lyapunov
    equation of its two last values."""
    step = np.array([[SWING[0], -SWING[1]], [1.0, 0.0]])
    state, lags = linalg.solve_discrete_lyapunov(step, np.diag([1.0, 0.0])), []
    for _ in range(n):
        lags.append(state[0, 0])
        state = step @ state
    return linalg.toeplitz(lags) / stiffness


def test_curve_and_likelihood_are_those_of_dense_algebra() -> None:
    n, one = 40, Wander(2.0, 3.0, *SWING)
    turn = np.delete(np.arange(n), [7, 8, 30]) + 100
    y, known = np.random.default_rng(1).standard_normal(turn.size), turn - 100
    process = covariance(n, 3.0)
    of_y = np.eye(turn.size) + process[np.ix_(known, known)]
    z, cost = one.curve(turn, y)
    best = np.linalg.solve(of_y, y)
    np.testing.assert_allclose(z, process[:, known] @ best, rtol=1e-7, atol=1e-10)
    likelihood = (turn.size - 2) * np.log(y @ best) + np.linalg.slogdet(of_y)[1]
    assert cost == pytest.approx(likelihood, rel=1e-9)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_errors_of_line_and_wander_are_those_of_dense_algebra(share: float) -> None:
    """Generalised least squares of a line under the process: at turns of which begins are known,
    and at others. A share of the begins are known as well as all, with as much more variance."""
    n, known, turn = 60, np.arange(10, 40), np.r_[np.arange(5, 58, 2), 20, 20]
    own, process = Wander(2.0, 3.0, *SWING), 4.0 * covariance(60, 3.0)
    X = np.column_stack([np.ones(n), np.arange(n)])
    of_y = process[np.ix_(known, known)] + 4.0 / share * np.eye(known.size)
    gain = np.linalg.solve(of_y, process[known]).T
    line = X - gain @ X[known]
    slope = np.linalg.inv(X[known].T @ np.linalg.solve(of_y, X[known]))
    error = process - gain @ process[known] + line @ slope @ line.T
    pull = np.random.default_rng(2).standard_normal((turn.size, 3))
    clock = TurnClock(0.0, 0.02, 1.0, **vars(own), told=(110, 139), share=share)
    expected = pull.T @ error[np.ix_(turn, turn)] @ pull
    np.testing.assert_allclose(clock.error_of(pull, turn + 100), expected, rtol=1e-7)
    still = TurnClock(0.0, 0.02, 2.0, told=(110, 139), share=share)
    alone = 4.0 / share * X @ np.linalg.inv(X[known].T @ X[known]) @ X.T
    expected = pull.T @ alone[np.ix_(turn, turn)] @ pull
    np.testing.assert_allclose(still.error_of(pull, turn + 100), expected, rtol=1e-7)


def test_errors_of_the_curve_are_as_stated() -> None:
    """Of 60 stations; a mean of its error over 100 turns has the stated standard deviation, within
    25 %, and the noise of a begin is found."""
    off, stated, noise, raw = [], [], [], []
    for seed in range(60):
        true, told = begins(400, seed)
        turn = np.arange(400)
        late, its = wander(turn, told, 1e-9)
        z = late(turn)
        off.append(np.mean((z - true)[150:250]))
        clock = TurnClock(0.0, 0.02, 0.0, **vars(its), told=(0, 399))
        stated.append(clock.error_of(np.full((100, 1), 0.01), turn[150:250])[0, 0])
        noise.append(its.begin_s)
        raw.append(np.std(z - true))
    assert np.std(off) == pytest.approx(np.sqrt(np.mean(stated)), rel=0.25)
    assert np.mean(noise) == pytest.approx(4e-8, rel=0.1)
    assert np.mean(raw) < 0.8 * 4e-8  # the begins themselves are 40 ns off


def test_what_the_clock_cannot_show_is_no_wander() -> None:
    turn = np.arange(300)
    late, its = wander(turn, 2e-9 * np.sin(turn), 20e-9)
    assert not late.at_turns.any() and its == Wander()
