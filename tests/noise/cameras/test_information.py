"""What subsets tell, against facilities whose cameras are known; and bounds in closed form."""

import numpy as np
import pytest

from mocap_metrology.noise.cameras.information import Addition, Chain, camera_noise
from mocap_metrology.noise.twins.take import joint_covariance, random_facility


def step(smaller: int, larger: int) -> Addition:
    """One camera more; recordings are named by their number."""
    return Addition(str(smaller), str(larger), (0,))


def pairs(joint: np.ndarray, steps: list[Addition]) -> np.ndarray:
    """(1, steps, 6, 6) out of the covariance of all subsets."""
    ends = [(3 * int(s.smaller), 3 * int(s.larger)) for s in steps]
    picks = [np.r_[a : a + 3, b : b + 3] for a, b in ends]
    return np.array([[joint[np.ix_(pick, pick)] for pick in picks]])


def facility_and_noise(seed: int) -> tuple:
    rng = np.random.default_rng(seed)
    return random_facility(rng, 8), np.exp(rng.normal(0, 0.3, 8))


EVERY = list(range(8))
NESTED = [EVERY[:n] for n in range(2, 9)], [step(k, k + 1) for k in range(6)], ("0",)
LEFT_OUT = [EVERY] + [[j for j in EVERY if j != i] for i in EVERY], [
    step(k + 1, 0) for k in EVERY
], ()  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("subsets", "steps", "firsts"), [NESTED, LEFT_OUT], ids=range(2))
def test_noise_of_every_camera_is_exact(seed: int, subsets, steps, firsts) -> None:
    """Of nested subsets, and of each camera left out once, relative to the median; at longer tau,
    too, where the marker moves."""
    facility, noise = facility_and_noise(seed)
    chain = Chain(tuple(steps), {str(k): len(s) for k, s in enumerate(subsets)}, firsts)
    still = pairs(joint_covariance(facility, 1, noise, subsets), steps)
    motion = 20 * np.trace(still[0, 0, :3, :3]) * np.tile(np.eye(3), (2, 2))
    found, first = camera_noise(np.concatenate([still, still / 100 + motion]), chain)
    known = noise / np.sqrt(np.median(noise**2))
    own = known[2:] if firsts else known
    assert found[0] == pytest.approx(own, rel=1e-4)
    assert found[1] / found[1, 0] == pytest.approx(own / own[0], rel=1e-3)
    assert first == pytest.approx([max(known[:2])] if firsts else [], rel=1e-4)


def test_noise_of_the_one_camera_added_is_relative_to_those_before() -> None:
    """A coordinate each of three cameras and a fourth along (1, 1, 1), s times as noisy: weighted
    means of p_a and of the fourth, as their covariances state."""
    s, n = 1.7, np.ones(3) / np.sqrt(3)
    gain = np.linalg.inv(np.eye(3) + np.outer(n, n)) @ np.outer(n, n)
    cross = np.eye(3) - gain
    after = cross @ cross.T + s**2 * gain @ gain.T
    joint = np.block([[np.eye(3), cross.T], [cross, after]])[None, None]
    found, first = camera_noise(joint, Chain((step(0, 1),), {"0": 3, "1": 4}))
    assert found[0] == pytest.approx([s], rel=1e-6) and first.size == 0
