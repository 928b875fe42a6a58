"""Calibrations, from sheet to tables: a twin, recordings of three formats, and all bad input."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from mocap_workflow.calibration_twins import calibration_twin
from rule_graph import shipped, write_shipped
from running import finished, planned, write_sheet
from sample_files import samples_folder

from mocap_metrology.common.files import sha256, write_json
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.assess.pose_file import pose_json
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.lighthouse.decode.factory_file import stations_to_json
from mocap_metrology.lighthouse.records import ROLES, PoseEstimate, Pulses
from mocap_metrology.lighthouse.rotation import error, from_angles, to_angles
from mocap_metrology.lighthouse.simulate.mocap import simulate_mounts, write_mounts
from mocap_metrology.lighthouse.simulate.recording import Made, simulate, truth_json, write_dump
from mocap_metrology.lighthouse.timing import TICKS_PER_S

HEADER = [
    *("calibration", "setup", "group", "path", "format", "board", "factory", "sha256"),
    *("reference", "reference_labels_master", "reference_labels_slave", "mount", "check_against"),
    "tracked_with",
    "world_points",
]
WHOLE_S, SHORT_S = 4.0, 2.5  # with and without a whole calibration frame in the flashes
BRIEF_S = 1.0
ROOM = from_angles(0.3, -0.2, 2.0), np.array([5.0, -1.0, 2.2])  # the master in it
SHIFT_MM = 30.0  # of the slave since an earlier calibration
LONGEST_SWEEP_S = 40e-6
LABELS = {"reference_labels_master": "M1;M2;M3;M4;M5", "reference_labels_slave": "S1;S2;S3;S4;S5"}
TWINS = f"""
factories:
  one: {{phase: [0.026, 0.054], tilt: [-0.003, -0.003], curve: [0.002, -0.0004],
         gibphase: [2.4, -1.1], gibmag: [0.001, -0.009]}}
  two: {{phase: [0.05, 0.024], tilt: [-0.009, 0.001], curve: [-0.004, -0.0015],
         gibphase: [1.9, -0.8], gibmag: [0.011, -0.011]}}
setups:
  room: &room
    reference: mocap
    duration_s: {WHOLE_S}
    common_urad: 20
    independent_urad: 20
    tilt_deg: [6.5, 14]
    master: {{id: 3001, mode: b, factory: one}}
    slave: {{id: 3002, mode: c, factory: two,
             position_m: [1.432, 1.976, -0.236], rotation_deg: [17.25, 2.84, -48]}}
    motion: {{pattern: circle, centre_m: [3.57, -1.04, -0.09], speed_m_s: 0.5, extent_m: 0.4,
              wobble_deg: 9, sway_m: 0.04}}
  perfect:
    <<: *room
    reference: truth
    master: {{id: 3001, mode: b}}
    slave: {{id: 3002, mode: c,
             position_m: [1.432, 1.976, -0.236], rotation_deg: [17.25, 2.84, -48]}}
  alone:
    duration_s: {BRIEF_S}
    master: {{id: 3001, mode: A}}
    motion: {{centre_m: [3.5, 0, 0]}}
twins:
  mounted: {{setup: room, seed: 1}}
  short: {{setup: room, seed: 2, duration_s: {SHORT_S}}}
  brief: {{setup: room, seed: 5, duration_s: {BRIEF_S}}}
  perfect: {{setup: perfect, seed: 3, duration_s: {SHORT_S}}}
  alone: {{setup: alone, seed: 4}}
"""
REFUSED = {  # row: board, what its line says
    "odd": ("board.csv", "bytes are not a whole number of uint32 words"),
    "big-endian": ("board.csv", "a big-endian dump"),
    "sixteen-bit": ("board.csv", "a 16-bit dump"),
    "no-flashes": ("board.csv", "flashes"),
    "one-station": ("board.csv", "flashes of one base station only; expected two"),
    "three-diodes": ("board.csv", "sweeps on 3 diodes; a calibration needs at least 4"),
    "millimetres": ("millimetres.csv", "is the file in mm?"),
    "small-board": ("small.csv", "the board has 24 diodes; expected a board in diode order"),
    "large-board": ("large.csv", "the board has 33 diodes; expected a board in diode order"),
    "second-generation": ("BOARD", "second-generation (V2) base stations"),
    "other-object": ("HMD", "no pulses of an object 'HMD'; expected one of BOARD"),
    "other-checksum": ("board.csv", f"expected {'0' * 64}"),
}


def made(name: str) -> Made:
    """A twin of `TWINS`, drawn with a seed of its own."""
    return simulate(calibration_twin(yaml.safe_load(TWINS), name).made(name), 77)


def write_board(path: Path, places: np.ndarray) -> None:
    lines = ["x_m,y_m,z_m", *(",".join(map(str, place)) for place in places)]
    path.write_text("\n".join(lines) + "\n")


def some(pulses: Pulses, kept: np.ndarray) -> Pulses:
    columns = {name: getattr(pulses, name)[kept] for name in ("start_s", "length_s", "diode")}
    return replace(pulses, **columns)


def write_rec(path: Path, recording: Made) -> None:
    """As libsurvive would write it: 48 MHz ticks in 32 bits, which wrap on the way."""
    pulses, board = recording.pulses, recording.truth.board
    config = {"lighthouse_config": {"modelPoints": board.tolist(), "channelMap": [*range(32)]}}
    lines = [f"0.1 BOARD CONFIG {json.dumps(config)}"]
    start = np.round(pulses.start_s * TICKS_PER_S).astype(np.int64) + (1 << 32) - 48_000_000
    length = np.round(pulses.length_s * TICKS_PER_S).astype(np.int64)
    for diode, at, ticks in zip(pulses.diode, start, length, strict=True):
        lines.append(f"{at / TICKS_PER_S:.6f} BOARD C {diode} {at % (1 << 32)} {ticks}")
    path.write_text("\n".join(lines) + "\n")


def write_angles(path: Path, recording: Made) -> None:
    names = ("station", "axis", "cycle", "diode", "time_s", "angle_rad")
    columns = [getattr(recording.hits, name).tolist() for name in names]
    with path.open("w", newline="") as stream:
        csv.writer(stream).writerows([names, *zip(*columns, strict=True)])


def write_laboratory(folder: Path, recording: Made) -> None:
    """What stands beside a dump: board, markers on both housings, mounts, an earlier pose."""
    seen, truth = simulate_mounts(recording.twin, 77), recording.truth
    frames = np.moveaxis(seen.positions_mm, 2, 0).astype(np.float32)
    write_c3d(folder / "lab.c3d", seen.labels, seen.rate_hz, [frames], len(frames))
    write_mounts(folder / "mount.csv", seen.mounts)
    write_json(folder / "truth.json", truth_json(recording))
    stranger = truth_json(recording) | {"stations": {"master": 7, "slave": 8}}
    write_json(folder / "stranger.json", stranger)
    write_json(folder / "stations.json", stations_to_json(truth.stations))
    before = truth.t_m + np.array([1e-3 * SHIFT_MM, 0, 0])
    pose = PoseEstimate("paper-lm", "final", "factory", truth.R, before)
    earlier = pose_json([pose], truth.stations, 0, Verdict("good"))
    write_json(folder / "earlier.json", earlier)
    (R,), (t,) = truth.motion.poses(np.array([2.0]))
    points = {"master": np.zeros(3), "slave": truth.t_m, "diode 5 at 2.0 s": R @ truth.board[5] + t}
    places = {label: ROOM[0] @ place + ROOM[1] for label, place in points.items()}
    lines = ["label,x_m,y_m,z_m", *(",".join(map(str, [k, *p])) for k, p in places.items())]
    (folder / "room.csv").write_text("\n".join(lines) + "\n")


def write_bad(folder: Path, brief: Made) -> None:
    """The files of `REFUSED`."""
    board, pulses = brief.truth.board, brief.pulses
    write_dump(folder / "brief.dump", pulses)
    write_board(folder / "millimetres.csv", 1e3 * board)
    write_board(folder / "small.csv", board[:24])
    write_board(folder / "large.csv", np.vstack([board, [0.0, 0.3, 0.3]]))
    words = np.fromfile(folder / "brief.dump", "<u4")
    (folder / "odd.dump").write_bytes(words.tobytes()[:-1])
    words.byteswap().tofile(folder / "big-endian.dump")
    words.astype("<u2").tofile(folder / "sixteen-bit.dump")
    write_dump(folder / "no-flashes.dump", some(pulses, pulses.length_s < LONGEST_SWEEP_S))
    write_dump(folder / "three-diodes.dump", some(pulses, pulses.diode < 3))
    write_dump(folder / "one-station.dump", made("alone").pulses)
    (folder / "second-generation.rec").write_text("0.2 BOARD B 3 1234 0 0 1\n0.3 BOARD W 3 1 2 3\n")


def sheet_rows(folder: Path) -> list[dict[str, str]]:
    """The twin, recordings that can be used, and those that cannot."""
    common = {"setup": "room", "group": "lab", "format": "gpio-dump", "board": "board.csv"}
    rec = {"format": "libsurvive-rec", "board": "BOARD"}
    against = {"reference": "lab.c3d", "mount": "mount.csv", "check_against": "earlier.json"}
    against["world_points"] = "room.csv"
    good = {
        "measured": {"path": "lab.dump", "sha256": sha256(folder / "lab.dump")} | against | LABELS,
        "recorded": {"path": "made.rec", "reference": "truth.json"} | rec,
        "angles": {"path": "angles.csv", "format": "angles-csv", "reference": "truth.json"},
        "short": {"path": "short.dump", "tracked_with": "odd"},
        "filed": {"path": "short.dump", "factory": "stations.json", "reference": "truth.json"}
        | {"tracked_with": "measured"},
        "stranger": {"path": "lab.dump", "reference": "stranger.json"},
    }
    if real := samples_folder():
        path = real / "lighthouse/libsurvive_extras/lh1_test_cal.rec.gz"
        good["headset"] = {"path": str(path)} | rec | {"board": "HMD"}
    bad = {name: {"path": f"{name}.dump", "board": board} for name, (board, _) in REFUSED.items()}
    bad["second-generation"] |= {"path": "second-generation.rec"} | rec
    bad["other-object"] |= {"path": "made.rec"} | rec | {"board": "HMD"}
    bad["other-checksum"] |= {"path": "brief.dump", "sha256": "0" * 64}
    for name in ("millimetres", "small-board", "large-board"):
        bad[name]["path"] = "brief.dump"
    twin = common | {"group": "jansen2019", "path": "simulate:mounted", "board": ""}
    good["recorded"] |= {"setup": "pair"}
    good["short"] |= {"setup": "pair"}
    return [{"calibration": "twin"} | twin] + [
        {"calibration": name} | common | {"setup": name} | cells
        for name, cells in (good | bad).items()
    ]


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
            "lighthouse={estimators: [paper, paper-lm], joint: setup}",
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
def test_bad_input_is_one_clear_line_and_no_pose(run, name: str) -> None:
    results, out, _ = run
    assert out.returncode == 1
    lines = said(out.stdout, f"calibration {name} refused:")
    assert len(lines) == 1, out.stdout
    assert REFUSED[name][1] in lines[0], lines[0]
    left = [path.name for path in (results / f"calibrations/{name}").iterdir()]
    assert left == ["check.json"]


def test_nobody_else_is_refused_and_nothing_is_half_written(run) -> None:
    results, out, _ = run
    assert len(said(out.stdout, "calibration ")) == len(REFUSED) + 1, out.stdout  # stranger
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
    assert (told["name"], told["why"]) == ("master", "no station states the direction of gravity")
    assert exported(results, "short")[0][0].tolist() == np.eye(3).tolist()
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
    lines = said(out.stdout, "warning: calibrate stranger: ")
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


def test_default_sheet_of_calibrations_job_counts(root, tmp_path, snakemake) -> None:
    """One job a twin, and one figure a setup: the dumps of one look alike."""
    _, own = write_shipped(tmp_path)
    out = snakemake(root, "-n", "--config", "recordings=", own, f"results={tmp_path}/results")
    table = shipped("calibrations")
    once = ("calibration_tables", "jansen_tables", "jansen_figures", "gate", "default")
    expected = dict.fromkeys(once, 1) | {"calibrate_twin": len(table)}
    expected["calibration_figures"] = len({row["setup"] for row in table})
    found = planned(out.stdout)
    assert {rule: found[rule] for rule in expected} == expected, out.stdout
    assert not {"check_calibration", "decode", "calibrate"} & set(found)
