"""Where speeds of a track and of markers are most alike."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.track.markers import Markers, Tracked
from mocap_metrology.lighthouse.track.mocap import offsets

STEP, LATE_S = 0.02, 1.36
LEVER = np.array([0.0, 0.12, 0.0])


def made(moves: float, turns: float, seconds: float = 14.0) -> tuple[Tracked, Markers]:
    """A board that moves and turns to and fro, and three markers beside it, of a system whose clock
    is so much ahead."""
    rng = np.random.default_rng(4)
    phase, rate = rng.uniform(0, 6, (6, 5)), rng.uniform(1, 7, (6, 5))

    def pose(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        own = np.sin(rate[:, :, None] * t + phase[:, :, None]).sum(axis=1)
        return Rotation.from_rotvec(turns * own[3:].T).as_matrix(), moves * own[:3].T

    time = np.arange(0.0, seconds, STEP)
    R, t = pose(time)
    t = t + 1e-5 * rng.standard_normal(t.shape)
    frames = np.arange(0.0, seconds + 3, 0.01)
    R_f, t_f = pose(frames - LATE_S)
    around = 0.01 * (np.eye(3) - 1 / 3) + LEVER
    place = np.array([t_f + R_f @ lever for lever in around]).transpose(0, 2, 1)
    return Tracked(time, R, t, np.full(time.size, 1e-4)), Markers(("A", "B", "C"), 100.0, place)


@pytest.mark.parametrize(("moves", "turns"), [(0.1, 0.1), (0.1, 0.0), (0.0, 0.3)])
def test_the_best_offset_is_that_of_the_clocks(moves: float, turns: float) -> None:
    """Also where the board turns on the spot: then places beside it move as the markers do."""
    track, seen = made(moves, turns)
    found = offsets(track, seen, np.ones(track.time_s.size, bool))
    assert found[0].offset_s == pytest.approx(LATE_S, abs=STEP)
    if turns > 0.2:
        assert abs(found[0].lever_m[0]) == pytest.approx(LEVER)  # speeds do not tell its sign
    apart = [abs(one.offset_s - found[0].offset_s) for one in found[1:]]
    assert min(apart, default=1.0) >= 0.25
