"""Second-generation stations against truth that they do not know: a bar, and poses of flights.

    python -m benchmarks.second_generation_truth bars 20
    python -m benchmarks.second_generation_truth flights 20

`bars`: two objects of 22 diodes back to back, 267.86 mm apart, 1.7 and 2.9 m from two stations that
look at them from nearly opposite sides; sizes, covers and places of diodes and time zeros of the
stations are drawn from what `batch` takes them for beforehand, 3 % of the hits are reflections. Two
recordings of 10 s, the bar across the lines of sight and along them, place the stations; errors of
the distance are of other recordings, stated is its median standard deviation. All frames of a run
share the error of the scale of the stations, so the share within one sigma of n runs scatters by
0.47 / sqrt(n).

`flights`: a deck of four diodes, 30 x 15 mm, 0.6 % (SD) larger than its file, flies for 20 s at 0.3
to 1.5 m/s; with the distance of the stations known to 5 mm, and without. Errors of the pose of the
other station, from the file of the recording to pose.json.
"""

from __future__ import annotations

import gzip
import json
import logging
import re
import tempfile
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks import arguments
from benchmarks.poses import error, lengths, mahalanobis
from benchmarks.second_generation import drawn, zeroed
from mocap_metrology.calibration.pose import pose
from mocap_metrology.calibration.sweeps import Entry, sweeps
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse.assess.pose_file import (
    chosen_pose,
    matrix_and_metres,
    pairs,
    read_pose_json,
)
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.scene import Scene, Sensors
from mocap_metrology.lighthouse.calibrate.setup import by_setup
from mocap_metrology.lighthouse.decode.factory_file import stations_to_json
from mocap_metrology.lighthouse.records import COVARIANCE_UNITS, Station
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.motion import facing_to
from mocap_metrology.lighthouse.simulate.turns import (
    MadeTurns,
    TurnsTwin,
    simulate_turns,
    stations_around,
    write_rec,
)
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from mocap_metrology.lighthouse.track.bar import Object, heads
from mocap_metrology.lighthouse.track.receiver import Calibrated
from mocap_metrology.settings import Lighthouse
from tests.lighthouse.batch.planes_scene import tracker
from tests.lighthouse.track.test_track_bar import seen

LENGTH_M = 0.26786
PRIORS = Priors(phase_mrad=0.0)
HEAD = np.eye(3), np.zeros(3)
OUTWARD = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # the board's z axis along the bar
ACROSS, ALONG, ASLANT = (0.0, 0.0, 0.0), (0.0, 0.0, 90.0), (0.0, 0.0, 45.0)
HELD_OUT = {  # turn of the bar, how it moves
    "across, 0.5 m/s": (ACROSS, {"speed_m_s": 0.5}),
    "along, 0.5 m/s": (ALONG, {"speed_m_s": 0.5}),
    "aslant": (ASLANT, {}),
    "across, at rest": (ACROSS, {"pattern": "still"}),
    "along, at rest": (ALONG, {"pattern": "still"}),
    "aslant, at rest": (ASLANT, {"pattern": "still"}),
}
DECK_M = np.array([[x, y, 0.0] for x in (-0.015, 0.015) for y in (-0.0075, 0.0075)])


def opposite(rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """As `stations_around`, for the two of the bar."""
    turn, near, far = np.radians(147.6 + rng.uniform(-5, 5)), rng.uniform(1.6, 1.9), 2.9
    t = np.array([[near, 0, 0.8], [far * np.cos(turn), far * np.sin(turn), 0.9]])
    R = np.array([facing_to(p, rng.normal(0, 0.1, (1, 3))) for p in t])
    own = R[0].T
    return own @ R, (t - t[0]) @ own.T, -own @ t[0], own[:, 2]


def bar(seed: int, take: int, turn: tuple[float, float, float], **motion: object) -> list[Scene]:
    """One recording of both objects."""
    R, t, middle, up = opposite(np.random.default_rng(seed))
    centre = tuple(middle + np.random.default_rng([seed, take]).normal(0, 0.1, 3))
    how = {"speed_m_s": 0.3, "extent_m": 0.5, "wobble_deg": 1.0, "turn_deg": turn} | motion
    board, normals = tracker(22, 0.042)
    half, over = np.array([LENGTH_M / 2, 0, 0]), from_angles(0.0, 0.0, np.pi)
    twin = TurnsTwin(
        seed, R, t, (0, 1), MotionTwin(centre_m=centre, **how), board, normals, take=take,
        duration_s=10.0, up=up, place_mm=PRIORS.board_position_mm, reflections=0.03,
    )  # fmt: skip
    mounts = enumerate([(OUTWARD, half), (over @ OUTWARD, -half)])
    return [_scene(replace(twin, mount=m, receiver=k)) for k, m in mounts]


def _scene(twin: TurnsTwin) -> Scene:
    """Of an object that is larger than its file, under a cover, before stations whose time zeros
    err, all by what `batch` takes them for beforehand."""
    rng = np.random.default_rng([twin.seed, twin.receiver, 17])
    larger, cover = drawn(rng, PRIORS)
    a, t = (1e3 * value for value in cover)
    made = simulate_turns(replace(twin, board=(1 + larger) * twin.board, cover_mm=(a, t)))
    found, names = seen(replace(made, twin=twin)), ["0", "1"]
    how = "factory", made.factories, None, "libsurvive", PRIORS
    sensors = Sensors(normals=found.normals, clocks=tuple(found.clocks))
    scene = Scene(found.hits, found.board, *how, sensors=sensors, generation=2, names=names)
    return zeroed(scene, np.random.default_rng([twin.seed, 18]))


def bars(runs: int) -> None:
    """A row for each recording that was held out."""
    rows = defaultdict[str, list[tuple[float, float, float]]](list)  # error, stated mm, inside
    for seed in range(runs):
        scenes = {"A": bar(seed, 1, ACROSS)[0], "B": bar(seed, 2, ALONG)[0]}
        found = by_setup(scenes, None, dict.fromkeys(scenes, "T20")).pose
        covariance = np.array(found.covariance) / np.outer(COVARIANCE_UNITS, COVARIANCE_UNITS)
        known = Calibrated(found.R, found.t_m, covariance, False)
        for take, (name, (turn, motion)) in enumerate(HELD_OUT.items(), start=3):
            both = heads(*(Object(one, known, HEAD) for one in bar(seed, take, turn, **motion)))
            off = np.linalg.norm(both.t_m[1] - both.t_m[0], axis=0) - LENGTH_M
            inside = np.nanmean(np.abs(off) < both.sd_m)[()]
            rows[name].append((1e3 * np.nanmean(off), 1e3 * np.nanmedian(both.sd_m), inside))
        print(seed, *(f"{name} {own[-1][0]:+.2f}" for name, own in rows.items()), flush=True)
    print("recording, mean error, rms of the means, stated (mm), frames within one sigma")
    errors = {}
    for name, own in rows.items():
        errors[name], stated, inside = np.transpose(own)
        mean, rms = errors[name].mean(), np.sqrt(np.mean(errors[name] ** 2))
        print(f"{name}: {mean:+.2f}, {rms:.2f}, {stated.mean():.2f}, {inside.mean():.0%}")
    apart = errors["across, 0.5 m/s"] - errors["along, 0.5 m/s"]
    print(f"across minus along: rms {np.sqrt(np.mean(apart**2)):.2f} mm")


def flight(seed: int) -> tuple[MadeTurns, float]:
    """A flight of a level deck, and how many times as large as its file the deck is."""
    rng = np.random.default_rng(seed)
    R, t, middle, up = stations_around(2, rng, 2.4, 1.6)
    x = np.cross(up, rng.normal(size=3))
    x /= np.linalg.norm(x)
    motion = MotionTwin(
        centre_m=tuple(middle), speed_m_s=float(rng.uniform(0.3, 1.5)), tremor_deg=0.2,
        extent_m=float(rng.uniform(0.8, 1.8)), wobble_deg=float(rng.uniform(2, 6)), tremor_mm=0.2,
    )  # fmt: skip
    level = facing_to(middle, t).T @ np.column_stack([x, np.cross(up, x), up])
    made = simulate_turns(
        TurnsTwin(
            seed, R, t, (0, 1), motion, DECK_M, np.tile([0.0, 0, 1], (4, 1)), (level, np.zeros(3)),
            up=up, common_urad=float(rng.uniform(10, 20)), reflections=0.01, incidence_deg=85.0,
            dropout=0.05,
        )
    )  # fmt: skip
    return made, 1 + float(rng.normal(0, 0.006))


def flights(runs: int) -> None:
    """Errors of each flight with a length and without, and how many are near."""
    logging.disable(logging.WARNING)
    for with_length in (True, False):
        near, squares = [], []
        for seed in range(runs):
            with tempfile.TemporaryDirectory() as folder:
                mm, deg, m2, word = _judged(seed, with_length, Path(folder))
            print(f"{seed}: {mm:.1f} mm, {deg:.3f} deg, m2 {m2:.1f}, {word}", flush=True)
            near.append(mm < 15 and deg < 0.3)
            squares.append(m2)
        title = "length known" if with_length else "no length"
        print(f"{title}: {sum(near)} of {runs} within 15 mm and 0.3 deg; median m2 (expected 5.3)"
              f" {np.median(squares):.1f}, largest {max(squares):.1f}")  # fmt: skip


def _judged(seed: int, with_length: bool, folder: Path) -> tuple[float, float, float, str]:
    made, scale = flight(seed)
    path = folder / "a.rec.gz"
    write_rec(path, replace(made, twin=replace(made.twin, board=DECK_M / scale)))
    text = gzip.decompress(path.read_bytes()).decode()  # a deck's file has no normals
    path.write_bytes(gzip.compress(re.sub(r', "modelNormals": \[\[.*?\]\]', "", text).encode(), 1))
    known = zip(made.twin.channels, made.ids, made.factories, strict=True)
    stations = [Station(str(c), id=i, factory=f, generation=2, channel=c) for c, i, f in known]
    write_json(folder / "stations.json", stations_to_json(stations))
    apart = np.linalg.norm(made.twin.t[1]) + np.random.default_rng([seed, 9]).normal(0, 0.005)
    length = f"stations 0-1 {apart:.4f} 0.005" if with_length else None
    entry = Entry("flight", str(path), "libsurvive-rec", "T20", known_length=length)
    settings = Lighthouse(estimators=("batch", "paper-lm"))
    given = {"dump": entry.path, "factory": str(folder / "stations.json")}
    sweeps(entry, given, settings, folder)
    pose(entry, {}, settings, None, folder)
    (station,) = pairs(read_pose_json(folder / "pose.json")).values()
    entry_of = chosen_pose(station)
    R, t = matrix_and_metres(entry_of)
    off = error(R, t, made.twin.R[1], made.twin.t[1])
    word = json.loads((folder / "pose.json").read_text())["verdict"]["word"]
    return *lengths(off), mahalanobis(off, np.array(entry_of["covariance"])), word


if __name__ == "__main__":
    asked = arguments(__doc__, study="bars", runs=20)
    {"bars": bars, "flights": flights}[asked["study"]](asked["runs"])
