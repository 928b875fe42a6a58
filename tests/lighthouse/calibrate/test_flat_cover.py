"""A deck of four diodes under covers, of which its file states no directions."""

import numpy as np
from scipy.stats import chi2

from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.scene import Scene, Sensors, faced, sightings
from mocap_metrology.lighthouse.records import Hits, Measurements, Path
from mocap_metrology.lighthouse.rotation import error, exp
from mocap_metrology.lighthouse.simulate.motion import facing_to
from mocap_metrology.lighthouse.simulate.turns import TurnsTwin, simulate_turns, stations_around
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from tests.lighthouse.track.test_track_bar import seen

DECK_M = np.array([[x, y, 0.0] for x in (-0.015, 0.015) for y in (-0.0075, 0.0075)])
COVER_MM = -0.4, 0.8  # the shift along the normal is 0.2 mm more at 70 than at 40 deg


def squared_error(seed: int, cover_mm: tuple[float, float]) -> float:
    """Of the pose of the other station, over its covariance, by a flight whose deck is as stated
    but for its cover."""
    rng = np.random.default_rng(seed)
    R, t, middle, up = stations_around(2, rng, 2.4, 1.6)
    x = np.cross(up, rng.normal(size=3))
    x /= np.linalg.norm(x)
    level = facing_to(middle, t).T @ np.column_stack([x, np.cross(up, x), up])
    motion = MotionTwin(centre_m=tuple(middle), speed_m_s=0.8, extent_m=1.2, wobble_deg=4.0)
    made = simulate_turns(
        TurnsTwin(
            seed, R, t, (0, 1), motion, DECK_M, np.tile([0.0, 0, 1], (4, 1)), (level, np.zeros(3)),
            duration_s=12.0, up=up, incidence_deg=85.0, place_mm=0.0, cover_mm=cover_mm,
        )
    )  # fmt: skip
    priors = Priors(phase_mrad=0.0, time_zero_us=0.0, board_scale=1e-6, board_position_mm=0.0)
    how = "factory", made.factories, None, "libsurvive", priors
    found, _ = joint(Scene(seen(made).hits, DECK_M, *how, generation=2, names=["0", "1"]))
    off = np.r_[found.state.t_m[1] - t[1], error(found.state.R[1], R[1])]
    return float(off @ np.linalg.solve(found.pose_covariance(1), off))


def test_the_cover_of_a_flat_board_is_an_unknown() -> None:
    """The light tells it, by the normal of the board: errors are as stated, and without a cover.
    Were there none in the estimate, the squared errors would be 36 and 66 instead of 4 and 6."""
    assert squared_error(0, COVER_MM) + squared_error(1, COVER_MM) < chi2.ppf(0.995, 12)
    assert squared_error(0, (0.0, 0.0)) < chi2.ppf(0.995, 6)


def test_directions_away_from_the_light_are_not_used() -> None:
    """A board at (3, 0, 0) whose z axis points to the station within 40 deg: light reaches diodes
    that look along z, and none that look along -z; of ten, three may see reflections."""
    n, rng = 20, np.random.default_rng(1)
    turn = rng.uniform(-0.4, 0.4, (n, 3))
    R = exp(turn) @ np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])
    none, here = np.full(n, np.nan), np.tile([3.0, 0, 0], (n, 1))
    path = Path(np.arange(n), R, here, none, none, none).take(np.arange(3, n))
    own = Measurements(np.arange(n), np.zeros((n, 10, 2)))
    board = np.c_[rng.uniform(-0.03, 0.03, (10, 2)), np.zeros(10)]
    hits = Hits.of(*np.zeros((4, 0)), time_s=np.zeros(0), angle_rad=np.zeros(0))
    for away, used in ((0, True), (3, True), (7, False), (10, False)):
        normals = np.outer(np.where(np.arange(10) < away, -1.0, 1.0), [0, 0, 1])
        how = "ideal", [None], None, "crazyflie", Priors()
        scene, why = faced(
            Scene(hits, board, *how, sensors=Sensors(normals=normals)), [sightings(own, path)]
        )
        assert (scene.sensors.normals is not None) == used
        assert used or f": {10 * away} % of the light" in why
