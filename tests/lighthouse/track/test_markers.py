"""Markers between their frames against a closed path, and which frames are cleaned."""

import numpy as np
import pytest

from mocap_metrology.lighthouse.track.markers import Markers

RATE = 100.0


def markers(n: int = 60, noise: float = 0.0) -> Markers:
    """Two a metre apart on polynomials of third order, which cubic splines follow."""
    t = np.arange(n) / RATE
    path = np.array([[t**3 + x, 2 * t, t**2 - 1] for x in (0, 1)])
    return Markers(
        ("A", "B"), RATE, path + noise * np.random.default_rng(1).normal(size=path.shape)
    )


def test_places_and_velocities_between_frames() -> None:
    t = np.array([0.0, 0.003, 0.257, 0.59])
    place, velocity = markers().at(t)
    assert place[:, 0] == pytest.approx(np.column_stack([t**3, 2 * t, t**2 - 1]))
    assert velocity[:, 0] == pytest.approx(np.column_stack([3 * t**2, 2 + 0 * t, 2 * t]))
    assert markers().duration_s == pytest.approx(0.59)


@pytest.mark.parametrize(
    ("noise", "off_m", "is_cleaned"),
    [
        *((0.0, 0.0049, False), (0.0, 0.0052, True)),  # from 5 mm
        *((5e-4, 0.009, False), (5e-4, 0.05, True)),  # from twelve times the scatter
    ],
)
def test_a_frame_off_the_path_is_cleaned(noise: float, off_m: float, is_cleaned: bool) -> None:
    own = markers(noise=noise)
    own.place_m[1, 2, 31] += off_m
    found = own.cleaned()
    wrong = np.isnan(found.place_m)
    assert wrong[1, :, 31].all() == is_cleaned
    assert wrong.sum() == 3 * is_cleaned
    assert found.place_m[~wrong] == pytest.approx(own.place_m[~wrong], abs=0)


def test_several_frames_of_one_marker_are_cleaned_in_turn() -> None:
    own = markers()
    own.place_m[0, :, 12] += 0.3
    own.place_m[0, :, 20] += 0.2
    own.place_m[0, :, 40] -= 0.02
    wrong = np.isnan(own.cleaned().place_m)
    assert np.flatnonzero(wrong[0].all(axis=0)).tolist() == [12, 20, 40]
    assert not wrong[1].any()
