"""Steps of coordinates: found where chance does not explain them."""

import math

import numpy as np
import pytest

from mocap_metrology.io.resolution import rounding_step_mm


@pytest.mark.parametrize(("near", "far"), [(4, 1), (2, 4), (5, 0), (4, 0), (3, 2), (0, 6), (0, 7)])
def test_a_step_counts_where_chance_is_below_a_billionth(near: int, far: int) -> None:
    """Values beyond the first of a coordinate about 1 m away, where float32 has steps of 2^-14 mm,
    and of one about 3 m away, 2^-12 mm: each is a multiple of 0.01 mm, to within one float32 step
    either way, by chance with probability 2 * 2^-14 / 0.01 and 2 * 2^-12 / 0.01."""
    position = np.full((1, 3, 9), 1000.0)
    position[0, 2] = 3000.0
    position[0, 0, : near + 1] += 0.01 * np.arange(near + 1) + 0.01
    position[0, 0, near + 1 :] = position[0, 0, 0]
    position[0, 2, : far + 1] += 0.01 * np.arange(far + 1) + 0.01
    position[0, 2, far + 1 :] = position[0, 2, 0]
    chance = near * math.log10(2**-13 / 0.01) + far * math.log10(2**-11 / 0.01)
    assert rounding_step_mm(position, 1.0) == (0.01 if chance < -9 else None)


@pytest.mark.parametrize(
    ("stored", "expected"),
    [
        (lambda x: x.astype(np.float16), 2**-4),  # of half floats between 64 and 128
        (lambda x: np.round(x / 0.0123) * 0.0123, 0.0123),
        (lambda x: np.round(x / 0.0254) * 0.0254, 0.0254),  # thousandths of an inch
        (lambda x: np.round(64 * x) / 64, 1 / 64),
        (lambda x: np.round(x, 2), 0.01),
        (lambda x: x, None),
        (lambda x: x[..., :30], None),
    ],
)
def test_steps_of_any_size(stored, expected: float | None) -> None:
    """Noise of 0.02 mm, written in steps that are no round decimal."""
    noise = np.random.default_rng(4).normal(0, 0.02, (1, 3, 4000))
    place = np.array([[61.0], [-43.0], [88.0]])
    position = stored(noise + place).astype(np.float32)
    assert rounding_step_mm(position, 1.0) == (expected and pytest.approx(expected, rel=1e-3))
