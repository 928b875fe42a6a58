"""Seconds in which one station of the second generation sees another board than the others, as
reflections in a floor show it."""

from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.fits import FINE_RAD, TOGETHER_S, _gated
from mocap_metrology.lighthouse.records import COVARIANCE_UNITS, Hits
from tests.lighthouse.batch.planes_scene import made

LAST_S = 2.0


def test_the_sound_part_decides() -> None:
    """The other board is of a recording of another motion before the same stations: the error is
    that of the sound recording, no piece differs and no diode is blamed."""
    one, other = made(2, 1, 8.0), made(2, 1, 8.0, take=1).scene.hits
    hits = one.scene.hits
    first = hits.take((hits.time_s >= LAST_S) | (hits.station == 0))
    parts = first, other.take((other.time_s < LAST_S) & (other.station == 1))
    names = Hits.__dataclass_fields__
    both = Hits(*(np.concatenate([getattr(own, name) for own in parts]) for name in names))
    both = both.take(np.argsort(both.time_s, kind="stable"))
    found, note = joint(replace(one.scene, hits=both))
    R, t_m = one.poses[1]
    off = np.r_[found.state.t_m[1] - t_m, rotation.error(found.state.R[1], R)] * COVARIANCE_UNITS
    assert np.linalg.norm(off[:3]) < 0.3 and np.linalg.norm(off[3:]) < 0.006
    assert found.misfit == 1 and not note


@pytest.mark.parametrize(("shift_rad", "lost"), [(2e-3, False), (4.5e-3, True)])
def test_hits_are_left_out_while_a_station_is_milliradians_off(shift_rad, lost) -> None:
    """Those of the other of two as well: nothing shows which of them is right."""
    scene = made(2, 1, 3.0).scene
    found, hits = joint(scene)[0], scene.hits
    then = ((hits.time_s - hits.time_s.min()) / TOGETHER_S).astype(int) == 10
    angle = hits.angle_rad + shift_rad * (then & (hits.station == 1))
    good = _gated(scene, replace(hits, angle_rad=angle), found, FINE_RAD)
    sound = _gated(scene, hits, found, FINE_RAD)
    of_then = np.count_nonzero(np.isin(sound.time_s, hits.time_s[then]))
    assert of_then > 100 and len(sound) - len(good) == (of_then if lost else 0)
