"""A bar as truth of a calibration: recording of two objects to bar.json."""

from __future__ import annotations

import csv
import gzip
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.accuracy.asked import Asked
from mocap_metrology.calibration.bar import FILES, bar
from mocap_metrology.calibration.pose import pose
from mocap_metrology.calibration.sweeps import Entry, paths_in, sweeps
from mocap_metrology.calibration.tables import TABLES
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse.decode.factory_file import stations_to_json
from mocap_metrology.lighthouse.records import Station
from mocap_metrology.lighthouse.simulate.turns import write_rec
from mocap_metrology.settings import Bar, Lighthouse
from tests.lighthouse.track.test_track_bar import HEAD, LENGTH_M, on_a_bar

NAMES, SERIALS = ("T20", "T21"), ("LHR-A1", "LHR-B2")
LENGTH_MM = 1e3 * LENGTH_M
SETTINGS = Lighthouse(estimators=("batch", "paper-lm"))


def write_both(path: Path, made: list, names: tuple[str, str] = NAMES) -> None:
    """Both objects in one file, heads in their descriptions; clocks begin elsewhere."""
    R, t = HEAD
    head = {"plus_x": R[:, 0].tolist(), "plus_z": R[:, 2].tolist(), "position": t.tolist()}
    text = b""
    for k, (one, name, serial) in enumerate(zip(made, names, SERIALS, strict=True)):
        part = path.with_suffix(".part")
        write_rec(part, one, name, serial, begin=k * 700_000_000)
        text += gzip.decompress(part.read_bytes())
    told = f'CONFIG {{"head": {json.dumps(head)}, '.encode()
    path.write_bytes(gzip.compress(text.replace(b"CONFIG {", told), 1))


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A calibrated recording of two objects; in another file their names are swapped."""
    folder = tmp_path_factory.mktemp("bar")
    made = on_a_bar(3, duration_s=8.0, cover_mm=(-0.75, 1.55), place_mm=0.1)
    write_both(folder / "a.rec.gz", made)
    write_both(folder / "swapped.rec.gz", made, NAMES[::-1])
    stations = [
        Station(str(c), id=i, factory=f, generation=2, channel=c)
        for c, i, f in zip(made[0].twin.channels, made[0].ids, made[0].factories, strict=True)
    ]
    write_json(folder / "stations.json", stations_to_json(stations))
    calibrate(folder, "a", "a", "T20")
    return folder


def calibrate(folder: Path, name: str, recording: str, board: str) -> Entry:
    own = folder / name
    own.mkdir(exist_ok=True)
    entry = entry_of(folder, name, recording, board)
    given = {"dump": str(entry.path), "factory": str(folder / "stations.json")}
    sweeps(entry, given, SETTINGS, own)
    pose(entry, {}, SETTINGS, None, own)
    return entry


def entry_of(folder: Path, name: str, recording: str, board: str) -> Entry:
    return Entry(name, str(folder / f"{recording}.rec.gz"), "libsurvive-rec", board)


def judged(folder: Path, entry: Entry, asked: Asked, **more: object) -> dict:
    own = folder / entry.calibration
    given = {"dump": str(entry.path), "factory": str(folder / "stations.json")}
    given |= paths_in(TABLES, own) | more.pop("given", {})
    return bar(entry, asked, given, SETTINGS, Bar(), paths_in(FILES, own), **more)


def test_a_bar_is_as_long_as_it_is(lab: Path) -> None:
    entry = entry_of(lab, "a", "a", "T20")
    half = {"quaternion_xyzw": Rotation.from_euler("z", 180, degrees=True).as_quat().tolist()}
    turn = Rotation.from_matrix(HEAD[0])
    stated = (turn.inv() * Rotation.from_quat(half["quaternion_xyzw"]) * turn).as_quat().tolist()
    asked = Asked("T20-T21", LENGTH_MM, 0.1, json.dumps({"quaternion_xyzw": stated}))
    found = judged(lab, entry, asked)
    print(json.dumps(found["classes"], indent=1)[:1500], found["stated"], found["clock"], found["angles_deg"]["p95"], found["reason"], found["findings"])
    rows = list(csv.DictReader((lab / "a/bar.csv").open()))
    assert {row["quantity"] for row in rows} == {"length_mm", "angle_deg"}


def test_the_other_way(lab):
    pass
