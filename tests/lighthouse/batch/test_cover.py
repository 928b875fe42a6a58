"""Covers of diodes before stations of the first generation, by the formula of a plane window."""

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from benchmarks.lighthouse_recordings import hand
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import Scene, Sensors, joint
from mocap_metrology.lighthouse.calibrate.joint_variants import best_joint
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotation import error
from mocap_metrology.lighthouse.rotor import angles
from mocap_metrology.lighthouse.simulate.recording import Made

A_M, T_M = -0.7e-3, 1.7e-3
N_DIODES = 32


def covered(made: Made, normals: np.ndarray) -> tuple[Hits, np.ndarray]:
    """Hits through covers, and their incidence in rad: by the shift along the normal of a diode
    under a plate of index 1.5, t (1 - cos i / sqrt(1.5^2 - sin^2 i)), from a."""
    exact, truth = made.truth.hits, made.truth
    R, p = truth.motion.poses(exact.time_s)
    places = p + np.einsum("nij,nj->ni", R, truth.board[exact.diode])
    normal = np.einsum("nij,nj->ni", R, normals[exact.diode])
    at = np.array([one.t for one in made.twin.stations])[exact.station]
    cosine = np.einsum("ni,ni->n", at - places, normal) / np.linalg.norm(at - places, axis=1)
    sine2 = 1 - cosine**2
    shift = A_M + T_M * (1 - cosine / np.sqrt(1.5**2 - sine2))
    off = np.zeros(len(exact))
    for station, own in enumerate(made.twin.stations):
        there = exact.station == station
        before = (places[there] - own.t) @ own.R
        after = (places[there] + shift[there, None] * normal[there] - own.t) @ own.R
        change = angles(after, truth.rotors[station]) - angles(before, truth.rotors[station])
        off[there] = np.take_along_axis(change, exact.axis[there, None].astype(int), axis=1)[:, 0]
    return replace(made.hits, angle_rad=made.hits.angle_rad + off), np.arccos(cosine)


def tilted(rng: np.random.Generator, tilt: float) -> np.ndarray:
    """Directions about +x."""
    normals = np.column_stack([np.ones(N_DIODES), tilt * rng.normal(size=(N_DIODES, 2))])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def scene(made: Made, hits: Hits, normals: np.ndarray | None, priors: Priors) -> Scene:
    factories = [station.factory for station in made.truth.stations]
    how = "factory", factories, None, made.twin.variant, priors
    return Scene(hits, made.truth.board, *how, sensors=Sensors(normals=normals))


def squared(found: Joint, made: Made) -> float:
    assert made.truth.R is not None and made.truth.t_optical_m is not None
    off = np.r_[found.state.t_m[1] - made.truth.t_optical_m, error(found.state.R[1], made.truth.R)]
    return float(off @ np.linalg.solve(found.pose_covariance(), off))


def test_the_cover_is_estimated_with_the_pose() -> None:
    """Both numbers within their standard deviations, the pose within its covariance; a scene that
    does not know of covers fits worse."""
    known, total = Priors(board_position_mm=0.05), 0.0
    for seed in range(3):
        made, rng = hand(seed, seconds=3.0), np.random.default_rng(seed)
        normals = tilted(rng, 0.5)
        hits, incidence = covered(made, normals)
        hits = hits.take(incidence < np.radians(74))
        found, _ = joint(scene(made, hits, normals, known))
        first = found.of.cover
        sd = np.sqrt(np.diag(found.covariance))[first : first + 2]
        assert (np.abs(found.state.cover - [A_M, T_M]) < 3 * sd).all() and (sd < 2e-4).all()
        total += squared(found, made)
        without, _ = joint(scene(made, hits, None, known))
        noise, worse = (one.recordings[0].noise.hit for one in (found, without))
        assert noise < 33e-6 and worse > 1.02 * noise
    assert total < chi2.ppf(0.995, 18)


def test_hits_beyond_75_deg_are_left_out_also_where_the_rotor_model_is_chosen() -> None:
    made, rng = hand(4, seconds=3.0), np.random.default_rng(4)
    normals = tilted(rng, 0.9)
    hits, incidence = covered(made, normals)
    off = np.where(incidence > np.radians(78), rng.uniform(2e-3, 1e-2, len(hits)), 0.0)
    assert 0.02 < (off > 0).mean() < 0.3
    given = scene(made, replace(hits, angle_rad=hits.angle_rad + off), normals, Priors())
    ways, (found, note) = best_joint(given)
    kept = np.isin(hits.time_s, found.recordings[0].sweeps.hits.time_s)
    assert kept[incidence < np.radians(73)].mean() > 0.9 and not kept[off > 0].any()
    assert squared(found, made) < chi2.ppf(0.999, 6) and not note
    assert next(way.variant for way in ways if way.standing == "chosen") == "libsurvive"
