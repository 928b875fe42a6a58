"""Turns, hits and planes of one second-generation station, of times made by hand."""

import numpy as np
import pytest

from mocap_metrology.lighthouse.decode.turns import Light, _plane, find_turns

PERIOD_S = 949_000 / 48e6  # channel index 3
Row = tuple[int, float]  # diode, rotor in rad


def light(
    hits: list[list[Row]], n: int = 20, ppm: float = 0.0, late: dict[int, float] | None = None
):
    """A station that turns n times; the hits of the first turns."""
    period = PERIOD_S * (1 + 1e-6 * ppm)
    begin = 0.01 + period * np.arange(n)
    for turn, off in (late or {}).items():
        begin[turn] += off
    rows = [
        (d, 0.01 + period * (k + a / (2 * np.pi))) for k, own in enumerate(hits) for d, a in own
    ]
    diode, time = np.array(rows).T if rows else np.empty((2, 0))
    return Light(
        begin_channel=np.full(n, 3, np.int8),
        begin_s=begin,
        begin_bit=np.arange(n, dtype=np.int8) % 2,
        hit_channel=np.full(time.size, 3, np.int8),
        hit_diode=diode.astype(np.int16),
        hit_s=time,
        n_diodes=6,
        duration_s=n * period,
        resolution_s=1 / 48e6,
    )


@pytest.mark.parametrize(
    ("n", "ppm", "is_used"),
    [(12, 0, True), (11, 0, False), (20, 99, True), (20, 101, False), (20, -99, True)],
)
def test_a_station_has_twelve_begins_of_its_period(n: int, ppm: float, is_used: bool) -> None:
    turns, notes = find_turns(light([], n, ppm))
    assert len(turns) == is_used
    if is_used:
        assert turns[0].channel == 3
        assert turns[0].clock.cycle_s == pytest.approx(PERIOD_S * (1 + 1e-6 * ppm), rel=1e-12)
        assert turns[0].bit.tolist() == [k % 2 for k in range(n)]
    else:
        assert notes


TIME = np.arange(0.0, 2.0, 0.02)


def swept(first: float, second: float, speed: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Angles of the rotor at which both planes meet an object that turns by `speed` rad/s, and
    times, not in their order."""
    rotor = np.concatenate([first + speed * TIME, second + speed * (TIME + 0.01)])
    time = np.concatenate([TIME, TIME + 0.01])
    order = np.random.default_rng(1).permutation(time.size)
    return rotor[order], time[order]


@pytest.mark.parametrize("speed", [0.0, 0.1, -0.1])
def test_near_half_a_turn_it_is_the_plane_whose_other_hits_are_near(speed: float) -> None:
    """Of an object at the edge of the field of the first plane, some of whose hits lie beyond."""
    rotor, time = swept(np.pi - 0.17, 5.1, speed)
    rotor = rotor + 0.1 * np.sin(37 * time) * (rotor < 4)  # a board: its diodes lie apart
    rotor[np.argmax(np.where(rotor < 4, rotor, 0))] = np.pi + 0.05
    plane, known = _plane(rotor, time)
    assert known.all()
    assert (plane == (rotor > 4)).all()


@pytest.mark.parametrize(("off", "plane"), [(0.156, 0), (0.159, 1)])
def test_the_fields_overlap_by_a_twentieth_of_half_a_turn(off: float, plane: int) -> None:
    """0.157 rad to each side; beyond, hits of the other plane nearby do not matter."""
    rotor, time = np.array([np.pi - 0.17, np.pi - 0.17, np.pi + off]), np.array([0.0, 1.0, 0.5])
    assert _plane(rotor, time)[0].tolist() == [0, 0, plane]
