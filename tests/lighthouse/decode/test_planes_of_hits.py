"""Which plane of a second-generation station a hit is of, where the fields of both overlap."""

import numpy as np
import pytest

from mocap_metrology.lighthouse.decode.turns import _plane

TIME = np.arange(0.0, 2.0, 0.02)


def swept(first: float, second: float, speed: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Angles of the rotor at which both planes meet an object that turns by `speed` rad/s, and
    times, not in their order."""
    rotor = np.concatenate([first + speed * TIME, second + speed * (TIME + 0.01)])
    time = np.concatenate([TIME, TIME + 0.01])
    order = np.random.default_rng(1).permutation(time.size)
    return rotor[order], time[order]


def test_before_half_a_turn_it_is_the_first_plane() -> None:
    rotor, time = swept(2.0, 4.3)
    plane, known = _plane(rotor, time)
    assert known.all()
    assert (plane == (rotor > np.pi)).all()


@pytest.mark.parametrize("speed", [0.0, 0.1, -0.1])
def test_near_half_a_turn_it_is_the_plane_whose_other_hits_are_near(speed: float) -> None:
    """Of an object at the edge of the field of the first plane, some of whose hits lie beyond."""
    rotor, time = swept(np.pi - 0.17, 5.1, speed)
    rotor = rotor + 0.1 * np.sin(37 * time) * (rotor < 4)  # a board: its diodes lie apart
    rotor[np.argmax(np.where(rotor < 4, rotor, 0))] = np.pi + 0.05
    plane, known = _plane(rotor, time)
    assert known.all()
    assert (plane == (rotor > 4)).all()


@pytest.mark.parametrize(("off", "is_known"), [(0.34, True), (0.36, False)])
def test_hits_far_from_those_of_either_plane_are_unknown(off: float, is_known: bool) -> None:
    """An object spans 0.35 rad at most; a plane without other hits may have any at that limit."""
    rotor, time = swept(np.pi - off, 5.1)
    rotor[7] = np.pi
    plane, known = _plane(rotor, time)
    assert known[7] == is_known
    assert plane[7] == (0 if is_known else plane[7])
    alone = _plane(np.array([np.pi]), np.array([0.5]))
    assert alone[1].tolist() == [True]


@pytest.mark.parametrize(("off", "plane"), [(0.156, 0), (0.159, 1)])
def test_the_fields_overlap_by_a_twentieth_of_half_a_turn(off: float, plane: int) -> None:
    """0.157 rad to each side; beyond, hits of the other plane nearby do not matter."""
    rotor, time = np.array([np.pi - 0.17, np.pi - 0.17, np.pi + off]), np.array([0.0, 1.0, 0.5])
    assert _plane(rotor, time)[0].tolist() == [0, 0, plane]
