"""The twin of second-generation light: its angles against the model at the true poses, its noise,
and the file of it, which is decoded to the same."""

from pathlib import Path

import numpy as np

from mocap_metrology.lighthouse.decode.chain import Decoded, decode, decode_light
from mocap_metrology.lighthouse.decode.gates import Cleaning
from mocap_metrology.lighthouse.planes import parameters
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotor import angles
from mocap_metrology.lighthouse.simulate.turns import (
    MadeTurns,
    TurnsTwin,
    simulate_turns,
    stations_around,
    write_rec,
)
from mocap_metrology.lighthouse.simulate.twin import MotionTwin


def twin(n: int = 3, **changes: object) -> TurnsTwin:
    R, t, middle, up = stations_around(n, np.random.default_rng(1))
    motion = MotionTwin(centre_m=tuple(middle), speed_m_s=1.0, extent_m=0.8, wobble_deg=20)
    some = {"seed": 3, "R": R, "t": t, "channels": (0, 7, 11)[:n], "motion": motion, "up": up}
    return TurnsTwin(**{**some, "duration_s": 4.0, "clock_ppm": 0.0, **changes})


def decoded(made: MadeTurns) -> Decoded:
    return decode_light(made.light, made.twin.board, None, Cleaning(), "twin")


def residuals(made: MadeTurns, hits: Hits, begin_s: float = 0.0) -> np.ndarray:
    """Angles less those of the model at the true places of diodes without cover, by rotation and
    translation written out; rad."""
    out, (turn, shift) = np.empty(len(hits)), made.twin.mount
    R, p = made.motion.poses(hits.time_s + begin_s)
    place = np.einsum("nij,nj->ni", R, (made.places @ turn.T + shift)[hits.diode]) + p
    for s, factory in enumerate(made.factories):
        own = hits.station == s
        angle = angles((place[own] - made.twin.t[s]) @ made.twin.R[s], parameters(factory, True))
        out[own] = hits.angle_rad[own] - angle[np.arange(own.sum()), hits.axis[own]]
    return out


def test_angles_are_those_of_the_model_with_the_stated_noise() -> None:
    """15 urad common, 15 of each hit, 3 of half ticks; the begins add little."""
    made = simulate_turns(twin(collisions=False))
    off = residuals(made, (found := decoded(made)).hits)
    assert found.notes == [] and not made.wrong.any() and sum(found.report["sweep"]) == 0
    assert 20e-6 < off.std() < 25e-6 and np.abs(off).max() < 150e-6
    exact = twin(
        collisions=False, common_urad=0.0, independent_urad=0.0, begin_ns=0.0, wander_ns=0.0
    )
    off = residuals(made := simulate_turns(exact), decoded(made).hits)
    assert off.std() < 5e-6  # ticks


def test_collisions_and_reflections() -> None:
    """Two stations: 4 to 6 % of the light is lost or given to the other one."""
    quiet = simulate_turns(twin(2, collisions=False))
    loud = simulate_turns(twin(2))
    lost = 1 - (~loud.wrong).sum() / quiet.wrong.size
    assert 0.02 < lost < 0.08 and 0.002 < loud.wrong.mean() < 0.01
    bright = simulate_turns(twin(2, collisions=False, reflections=0.03))
    assert 0.02 < bright.wrong.mean() < 0.04


def test_only_a_diode_that_is_seen_as_often_as_others_casts_doubt_on_the_board() -> None:
    """Diodes that face away have reflections alone; then one is 2 cm off."""
    made = simulate_turns(twin(2, reflections=0.05, duration_s=10.0))
    found = decoded(made)
    assert np.greater(found.report["sweep"], found.report["kept"]).any() and not found.notes
    board = made.twin.board.copy()
    board[5, 1] += 0.02
    wrong = decode_light(made.light, board, None, Cleaning(), "twin")
    assert wrong.notes == ["most rejected hits are on diode 5: is the board file right?"]


def test_the_file_is_decoded_to_the_same(tmp_path: Path) -> None:
    """Through text and a wrapping counter; a frame of the calibration is in 20 s."""
    made = simulate_turns(twin(2, duration_s=20.0, incidence_deg=40.0))
    write_rec(tmp_path / "a.rec.gz", made, begin=2**32 - 10**8)
    found, direct = decode(tmp_path / "a.rec.gz", "libsurvive-rec", "LHR-TWIN"), decoded(made)
    assert len(found.hits) == len(direct.hits)
    assert np.allclose(found.normals, made.twin.normals)
    apart = found.hits.time_s - direct.hits.time_s
    assert np.ptp(apart) < 1e-8
    assert np.abs(np.sort(found.hits.angle_rad) - np.sort(direct.hits.angle_rad)).max() < 1e-6
    for station, factory, id_ in zip(found.stations, made.factories, made.ids, strict=True):
        assert station.id == id_ and np.array_equal(station.factory.tilt, factory.tilt)
        assert station.gravity @ [0, 0, 1] > 0.8 and station.frames_found > 0
