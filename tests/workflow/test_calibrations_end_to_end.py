"""Calibrations, from sheet to tables: a twin, recordings of three formats, and all bad input."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from laboratory import (
    BAD_ROWS,
    HEADER,
    REFUSED,
    ROOM,
    SHIFT_MM,
    TWINS,
    bad_rows,
    made,
    sheet_rows,
    write_angles,
    write_bad,
    write_board,
    write_laboratory,
    write_rec,
)
from running import finished, write_sheet
from sample_files import samples_folder

from mocap_metrology.calibration.decode import Entry, checked
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.lighthouse.rotation import error, to_angles
from mocap_metrology.lighthouse.simulate.recording import write_dump
from mocap_metrology.settings import Lighthouse


@pytest.fixture(scope="module")
def run(tmp_path_factory, root, snakemake):
    """Results, output and arguments of one run in a folder of its own."""
    folder = tmp_path_factory.mktemp("calibrations")
    (folder / "profiles").symlink_to(root / "profiles")
    (folder / "twins.yaml").write_text(TWINS)
    lab, short, perfect = made("mounted"), made("short"), made("perfect")
    write_board(folder / "board.csv", lab.truth.board)
    write_dump(folder / "lab.dump", lab.pulses)
    write_dump(folder / "short.dump", short.pulses)
    write_rec(folder / "made.rec", lab)
    write_angles(folder / "angles.csv", perfect)
    write_laboratory(folder, lab)
    write_bad(folder, made("brief"))
    presented = (
        *("tables/lab_calibrations.csv", "tables/jansen_table1.csv"),
        *("calibrations/measured/calibration.png", "figures/jansen_fig03.svg"),
    )
    old = folder / "results/calibrations/odd/pose.json"
    old.parent.mkdir(parents=True)
    old.write_text("of an earlier input")
    arguments = (
        *("--cores", "2", "-s", str(root / "Snakefile"), "calibrations"),
        *(f"results/{file}" for file in presented),
        *("--config", f"calibrations={write_sheet(folder, HEADER, *sheet_rows(folder))}"),
        *(
            "recordings=",
            "twins=twins.yaml",
            "lighthouse={estimators: [paper-lm], joint: setup}",
        ),
    )
    return folder / "results", snakemake(folder, *arguments), arguments


def pose(results: Path, name: str) -> dict:
    return json.loads((results / f"calibrations/{name}/pose.json").read_text())


def chosen(results: Path, name: str) -> dict:
    told = pose(results, name)
    return told["poses"][told["chosen"]]


def off(entry: dict) -> tuple[float, float]:
    """Distance in mm and angle in deg from the reference."""
    mm, deg = (np.linalg.norm(entry[key]) for key in ("errors_mm", "errors_deg"))
    return float(mm), float(deg)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def said(output: str, start: str) -> list[str]:
    return [line for line in output.splitlines() if line.startswith(start)]


@pytest.mark.parametrize("name", REFUSED)
def test_bad_input_is_refused_by_the_check(run, monkeypatch, name: str) -> None:
    monkeypatch.chdir(run[0].parent)
    row = bad_rows()[name]
    files = {"dump": row["path"], "board": row["board"]}
    with pytest.raises(Refusal, match=re.escape(REFUSED[name][1])) as refusal:
        checked(Entry(name, **row), files, Lighthouse())
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("name", BAD_ROWS)
def test_bad_input_is_one_clear_line_and_no_pose(run, name: str) -> None:
    results, out, _ = run
    assert out.returncode == 1
    lines = said(out.stdout, f"calibration {name} refused:")
    assert len(lines) == 1, out.stdout
    assert REFUSED[name][1] in lines[0], lines[0]
    left = [path.name for path in (results / f"calibrations/{name}").iterdir()]
    tables = {"pulses.parquet", "inertial.parquet", "sweeps.parquet", "stations.json", "board.csv"}
    assert set(left) == {"check.json", *tables}


def test_nobody_else_is_refused_and_nothing_is_half_written(run) -> None:
    results, out, _ = run
    assert len(said(out.stdout, "calibration ")) == len(BAD_ROWS) + 1, out.stdout  # stranger
    assert "Traceback" not in out.stdout
    assert "Error in rule" not in out.stdout.replace("Error in rule gate", "")
    assert not list(results.rglob(".part-*"))
    assert not list(results.rglob("twin.dump"))  # raw twins are temporary


@pytest.mark.parametrize("name", ["twin", "measured"])
def test_against_markers_on_both_housings(run, name: str) -> None:
    """4 s with factory values; the markers' own noise is 0.3 mm over 100 frames."""
    results, _, _ = run
    told = pose(results, name)
    best = chosen(results, name)
    assert (best["estimator"], best["stage"], best["optics"]) == ("paper-lm", "final", "factory")
    mm, deg = off(best)
    assert mm < 6
    assert deg < 0.1
    assert told["verdict"]["word"] in ("good", "usable"), told["verdict"]
    assert {told["stations"][role]["id"] for role in ROLES} == {3001, 3002}
    assert ("truth_errors_mm" in best) == (name == "twin")  # no lab has it
    ideal = [e for e in told["poses"] if (e["estimator"], e["optics"]) == ("paper-lm", "ideal")]
    assert all(off(e)[0] > 5 * mm for e in ideal)


def test_a_station_that_moved_since_an_earlier_pose_is_told(run) -> None:
    results, _, _ = run
    against = pose(results, "measured")["check_against"]
    assert against["moved"] is True
    assert against["difference_mm"] == pytest.approx([-SHIFT_MM, 0, 0], abs=5)
    assert against["sentence"].startswith("A station has moved: ")


def exported(results: Path, name: str) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """R and t of the stations in the file for a Crazyflie."""
    found = yaml.safe_load((results / f"calibrations/{name}/crazyflie.yaml").read_text())
    return {k: (np.array(g["rotation"]), np.array(g["origin"])) for k, g in found["geos"].items()}


def test_exports_in_the_frame_of_measured_points(run) -> None:
    """True places of both stations and of a diode in flight."""
    results, _, _ = run
    told = pose(results, "measured")["world"]
    assert told["name"] == "points" and told["residual_rms_mm"] < 10
    placed = exported(results, "measured")
    assert np.linalg.norm(placed[0][1] - ROOM[1]) < 0.01
    assert np.degrees(np.linalg.norm(error(placed[0][0], ROOM[0]))) < 0.6
    for k, role in enumerate(ROLES):
        assert told["stations"][role]["translation_mm"] == pytest.approx(1e3 * placed[k][1])
    (R0, t0), (R1, t1) = placed[0], placed[1]
    best = chosen(results, "measured")
    assert 1e3 * R0.T @ (t1 - t0) == pytest.approx(best["translation_mm"], abs=1e-6)
    assert np.degrees(to_angles(R0.T @ R1)) == pytest.approx(list(best["rotation_deg"].values()))


def test_exports_are_level_where_the_stations_state_gravity(run) -> None:
    """Which 4 s hold, and 2.5 s do not. Of a calibration that failed there is no pose."""
    results, _, _ = run
    (R0, t0), (R1, _) = exported(results, "recorded").values()
    assert t0.tolist() == [0, 0, 0] and R0[1, 0] == 0  # x of the master is ahead, or up
    for R, station in zip((R0, R1), made("mounted").truth.stations, strict=True):
        assert np.degrees(np.arccos(R[2] @ station.gravity)) < 1
    told = pose(results, "short")["world"]
    assert told["name"] == "board-start"
    assert told["why"] == "no station states the direction of gravity"
    assert exported(results, "stranger") == {}
    assert pose(results, "stranger")["world"] == {"name": None, "stations": {}}
    folder = results / "calibrations/stranger"
    for file in ("crazyflie.yaml", "libsurvive.json", "ros2_static_transforms.launch.xml"):
        assert "the calibration failed: reference: its master is" in (folder / file).read_text()
        assert "(twin)" in (results / "calibrations/twin" / file).read_text()


def test_the_other_formats(run) -> None:
    """The same pulses in a libsurvive recording, and angles of ideal stations from a file."""
    results, out, _ = run
    recorded = chosen(results, "recorded")
    assert recorded["optics"] == "factory"
    assert off(recorded)[0] < 6
    assert off(recorded)[1] < 0.1
    angles = pose(results, "angles")
    best = chosen(results, "angles")
    assert (best["optics"], angles["stations"]["master"]["id"]) == ("ideal", None)
    assert off(best)[0] < 6
    assert off(best)[1] < 0.1
    assert "a file of angles contains no flashes" in angles["verdict"]["reason"]
    assert "Station ids not compared" in angles["diagnostics"]["notes"][-1]
    assert len(said(out.stdout, "warning: calibration angles: ")) == 2
    empty = pq.read_metadata(results / "calibrations/angles/pulses.parquet")
    assert empty.num_rows == 0


def test_a_dump_without_a_whole_frame_is_ideal_or_takes_a_file(run) -> None:
    """2.5 s hold 300 bits of about 350."""
    results, out, _ = run
    told = pose(results, "short")
    assert {entry["optics"] for entry in told["poses"]} == {"ideal"}
    assert told["verdict"]["word"] == "doubtful"
    assert "Ideal optics, without the stations' factory values" in told["verdict"]["reason"]
    assert "no calibration frame" in told["verdict"]["reason"]
    assert len(said(out.stdout, "warning: calibration short: master: no factory values")) == 1

    told, best = pose(results, "filed"), chosen(results, "filed")
    assert best["optics"] == "factory"
    assert off(best)[0] < 6
    assert told["verdict"]["word"] == "usable"
    assert "come from a calibration file" in told["verdict"]["reason"]
    filed = [f"{role}: factory values from stations.json" for role in ROLES]
    assert set(filed) <= set(told["diagnostics"]["notes"])
    assert not said(out.stdout, "warning: calibration filed: ")
    stations = json.loads((results / "calibrations/filed/stations.json").read_text())
    assert [station["id"] for station in stations] == [3001, 3002]
    assert all("taken from stations.json" in station["why"] for station in stations)


def test_the_board_is_tracked_with_its_own_or_an_earlier_calibration(run) -> None:
    """The path of 2.5 s, with stations calibrated in 4 s, against the truth."""
    results, _, _ = run
    table = pq.read_table(results / "calibrations/filed/track.parquet")
    told = json.loads(table.schema.metadata[b"mocap_metrology"])
    assert (told["tracked_with"], told["still"], "reason" in told) == ("measured", False, False)
    track = {name: table[name].to_numpy() for name in table.column_names}
    _, place = made("short").truth.motion.poses(track["time_s"])
    off = np.stack([track[f"{axis}_mm"] for axis in "xyz"], axis=1) - 1e3 * place
    sd = np.stack([track[f"sd_{axis}_mm"] for axis in "xyz"], axis=1)
    assert len(off) == 150 and np.linalg.norm(off, axis=1).max() < 12
    assert np.mean((off / sd) ** 2) < 4
    own = pq.read_table(results / "calibrations/measured/track.parquet")
    assert json.loads(own.schema.metadata[b"mocap_metrology"])["tracked_with"] is None
    assert own.num_rows == 240
    refused = pq.read_table(results / "calibrations/short/track.parquet")
    why = json.loads(refused.schema.metadata[b"mocap_metrology"])["reason"]
    assert refused.num_rows == 0
    assert why == "calibration odd, to track with, is refused itself"


def test_a_reference_of_other_stations_is_refused_when_calibrating(run) -> None:
    """Only then both are known. The recording itself is all right, so the run goes on, with a
    warning; pose.json says why there is no pose in it, and the last step names it again."""
    results, out, _ = run
    lines = said(out.stdout, "warning: pose stranger: ")
    last = said(out.stdout, "calibration stranger failed: ")
    assert (len(lines), len(last)) == (1, 1), out.stdout
    told = pose(results, "stranger")
    assert "reference: its master is station 7, that of the recording is 3001" in lines[0]
    assert (told["chosen"], told["poses"]) == (None, [])
    assert told["verdict"]["word"] == "failed"
    assert lines[0].endswith(told["verdict"]["reason"])
    assert last[0].endswith(told["verdict"]["reason"])


def test_headset_of_other_people(run, samples) -> None:
    results, _, _ = run
    told, best = pose(results, "headset"), chosen(results, "headset")
    assert (best["stage"], best["optics"]) == ("static", "factory")
    assert np.linalg.norm(best["translation_mm"]) == pytest.approx(3921, abs=9)  # by variant
    assert told["verdict"]["word"] == "usable"
    assert told["stations"]["slave"] == {"id": 178605925, "mode": "A"}


def test_recordings_of_a_setup_are_joined(run) -> None:
    """Both see the same stations: nearer to the truth than the interval of either alone, and the
    factory values of one, whose flashes carry them, serve both."""
    results, _, _ = run
    told = json.loads((results / "setups/lab/pair/pose.json").read_text())
    assert sorted(told["recordings"]) == ["recorded", "short"]
    assert told["stations"]["slave"]["id"] == 3002
    best = told["poses"][told["chosen"]]
    assert (best["estimator"], best["optics"]) == ("batch", "factory")
    check = next(c for c in told["checks"] if c["name"] == "recordings agree")
    assert check["ok"] and set(told["predicted"]) == set(told["recordings"])
    true = json.loads((results.parent / "truth.json").read_text())
    off = np.array(best["translation_mm"]) - 1e3 * np.array(true["t_m"])
    assert np.linalg.norm(off) < 3
    assert not list((results / "setups").glob("lab/[!p]*"))


def test_tables_and_figures(run) -> None:
    results, _, _ = run
    table = rows(results / "tables/lab_calibrations.csv")
    names = {"measured", "recorded", "angles", "short", "filed", "stranger"}
    assert {row["calibration"] for row in table} - {"headset"} == names | {"pair (joint)"}
    tracks = {row["calibration"]: row for row in rows(results / "tables/lab_track.csv")}
    assert set(tracks) - {"headset"} == names
    assert tracks["filed"]["stations"] == "measured" and float(tracks["filed"]["total_mm"]) > 0
    for number in (1, 2, 3):
        own = rows(results / f"tables/jansen_table{number}.csv")
        assert own
        assert (results / f"tables/jansen_table{number}.md").stat().st_size > 0
    rotors = rows(results / "tables/lab_angles.csv")
    assert {row["calibration"] for row in rotors} == ({"headset"} if samples_folder() else set())
    for figure in ("calibration", "track"):
        assert (results / f"calibrations/measured/{figure}.png").stat().st_size > 10_000
    assert (results / "figures/jansen_fig03.svg").stat().st_size > 1_000


def test_rerun_repeats_the_verdict_alone(run, snakemake) -> None:
    results, first, arguments = run
    again = snakemake(results.parent, *arguments)
    assert again.returncode == 1
    assert finished(again.stdout) == {}
    for start in ("calibration ", "warning: calibration "):
        assert said(again.stdout, start) == said(first.stdout, start)
