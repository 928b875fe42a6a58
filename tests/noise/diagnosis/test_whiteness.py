"""Noise that is loud is as white as before; what moves is less white."""

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.sides import likeness


@pytest.mark.parametrize(("size", "loud", "times"), [(120, 30, 5), (200, 40, 4)])
def test_noise_that_is_louder_in_a_part_has_not_moved(size: int, loud: int, times: float) -> None:
    """Of 1,500 windows by themselves; of one series among many more rarely. The loud frames alone
    decide, which are fewer than the window has."""
    rng, found = np.random.default_rng(1), np.zeros((1500, 2), bool)
    for row in found:
        x = rng.standard_normal(5 * size + 2000)
        x[1000 : 1000 + loud] *= times
        row[:] = [likeness(x, 1000, 1000 + size, 1000, n)[2] for n in (1, 20)]
    assert found.mean(axis=0) == pytest.approx([0.004, 0.001], abs=0.0035)


def test_what_moves_is_less_white() -> None:
    """Away and back, a step, a short ringing, each of five standard deviations or more."""
    rng, k = np.random.default_rng(2), np.arange(3000)
    since = np.maximum(k - 1480, 0)
    for way in (
        5 * np.exp(-(((k - 1500) / 20) ** 2)),
        5.0 * (k > 1500),
        9 * (k > 1480) * np.exp(-since / 20) * np.sin(0.4 * since),
    ):
        x = rng.standard_normal(k.size) + way
        assert likeness(x, 1450, 1570, 1000, 20)[2]
