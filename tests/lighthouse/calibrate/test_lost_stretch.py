"""Seconds in which one station of the second generation sees another board than the others, as
reflections in a floor show it."""

from dataclasses import replace

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.batch import joint
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
