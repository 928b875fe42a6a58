"""One run over everything that a laboratory may have: recordings and calibrations that can be used,
of every format, and all that is refused."""

import csv
import html
import json
import re
import subprocess
import sys
from pathlib import Path

import laboratory as lab
import numpy as np
import pyarrow.parquet as pq
import pytest
from browser import ACTIVE_LINKS, LINKS, READY, SHOW, SHOWN, TITLE, browser
from laboratory import ACTIVE
from outcomes import chosen, contents, damage, exported, off, origin, pose, rows, said
from running import command, environment, finished

from mocap_metrology.calibration.sweeps import Entry, checked
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.lighthouse.rotation import error, to_angles
from mocap_metrology.settings import Lighthouse

ROOT = Path(__file__).resolve().parents[2]


# What is refused


def test_every_bad_input_is_one_line_and_the_rest_is_computed(run) -> None:
    assert run.output.returncode == 1
    text = run.output.stdout
    for kind, refused, tables in (
        ("recording", lab.REFUSED_RECORDINGS, lab.TABLES_OF_RECORDING),
        ("calibration", lab.BAD_ROWS, lab.TABLES_OF_CALIBRATION),
    ):
        for name in refused:
            reason = lab.REFUSED[name][1] if name in lab.REFUSED else lab.REFUSED_RECORDINGS[name]
            lines = said(text, f"{kind} {name} refused:")
            assert len(lines) == 1 and reason in lines[0], (name, text)
            left = {path.name for path in (run.results / f"{kind}s" / name).iterdir()}
            assert left == {"check.json", *tables}, name
    assert len(said(text, "calibration ")) == len(lab.BAD_ROWS) + 1  # stranger
    assert "Traceback" not in text
    assert "Error in rule" not in text.replace("Error in rule gate", "")
    assert not [
        p for p in run.results.rglob("*") if p.name.startswith((".part-", "twin.c", "twin.d"))
    ]


def test_rerun_repeats_the_verdict_alone(run, snakemake) -> None:
    again = snakemake(run.folder, *run.arguments)
    assert again.returncode == 1
    assert finished(again.stdout) == {}
    for start in ("recording ", "calibration ", "warning: "):
        assert {*said(again.stdout, start)} <= {*said(run.output.stdout, start)}
    assert len(said(again.stdout, "recording ")) >= len(lab.REFUSED_RECORDINGS)


@pytest.mark.parametrize("name", lab.REFUSED)
def test_bad_dumps_are_refused_by_the_check(run, monkeypatch, name: str) -> None:
    monkeypatch.chdir(run.folder)
    row = lab.bad_rows()[name]
    given = {"dump": row["path"], "board": row["board"]}
    with pytest.raises(Refusal, match=re.escape(lab.REFUSED[name][1])) as refusal:
        checked(Entry(name, **row), given, Lighthouse())
    assert "\n" not in str(refusal.value)


# Recordings


def test_orientation_of_a_body(run) -> None:
    """Markers at (0, 0), (a, 0), (0, a) with noise s, in rad: of s^2 (sum |p|^2 I - p p^T)^-1 the
    roots of the diagonal are sqrt(2) s / a about x and y, and sqrt(3) / 2 s / a about z."""
    found = rows(run.results / "recordings/active/orientation.csv")
    one_frame = [float(row["adev_1_rad"]) for row in found]
    expected = lab.ACTIVE_MM / 100 * np.sqrt([2, 2, 0.75])
    np.testing.assert_allclose(one_frame, expected, rtol=0.1)  # 4 standard errors


def test_the_comparison_and_the_covariate_of_a_recording(run) -> None:
    """Frames of the other scatter five times as much; nothing is heard of the temperature."""
    compared = rows(run.results / "tables/check_compare.csv")
    assert {(row["recording"], row["reference"]) for row in compared} == {("take", "active")}
    frame = [row for row in compared if row["series"] == "x1" and float(row["tau_s"]) < 0.03]
    assert [row["word"] for row in frame] == ["better"]
    assert float(frame[0]["lower"]) < 0.2 < float(frame[0]["upper"])
    assert {r["word"] for r in rows(run.results / "tables/check_coherence.csv")} == {"unrelated"}


def test_tables_of_groups_and_of_the_paper(run) -> None:
    """Of T40-10 alone: each number states what it is."""
    tables = run.results / "tables"
    for group, names, source in (
        ("check", {"take", "active"}, "measured"),
        ("skurowski2019", {"T40-10"}, "twin"),
    ):
        table = rows(tables / f"{group}_gaussian.csv")
        assert {(row["recording"], row["source"]) for row in table} == {(n, source) for n in names}
    table = rows(tables / "skurowski_table4.csv")
    computed = {r["quantity"]: r for r in table if r["camera_type"] == "T40"}
    assert {r["source"] for r in computed.values()} == {"twin"}
    assert float(computed["mu_L_mm"]["regenerated"]) == pytest.approx(160.58, abs=0.05)
    missing = [r for r in table if r["camera_type"] == "Vantage"]
    assert {(r["regenerated"], r["source"]) for r in missing} == {("", "cited")}
    assert "simulated" in (tables / "skurowski_table4.md").read_text()
    own = run.results / "recordings/T40-10"
    assert origin(own / "trajectories.parquet")["form"] == "continuous"
    assert {r["model"] for r in rows(own / "noise.csv")} == {"continuous"}
    assert (own / "truth.json").exists()


# The command `check`, which runs the same steps


def test_the_command_writes_what_the_workflow_does(run, tmp_path: Path) -> None:
    arguments = ("take.c3d", "--markers", "A", "B", "--output", str(tmp_path / "one"))
    command = [sys.executable, "-m", "mocap_metrology", "check", *arguments]
    drawn = environment(run.drawn)
    subprocess.run(command, cwd=run.folder, env=drawn, check=True, capture_output=True, timeout=900)
    names = {path.name for path in (tmp_path / "one").iterdir()} - {"allan.csv"}
    assert len(names) >= 21
    for name in names:
        own = run.results / "recordings/take" / name
        assert contents(tmp_path / "one" / name) == contents(own), name


# Calibrations


@pytest.mark.parametrize("name", ["twin", "measured"])
def test_against_markers_on_both_housings(run, name: str) -> None:
    """4 s with factory values; the markers' own noise is 0.3 mm over 100 frames."""
    told, best = pose(run.results, name), chosen(run.results, name)
    assert (best["estimator"], best["stage"], best["optics"]) == ("paper-lm", "final", "factory")
    mm, deg = off(best)
    assert mm < 6 and deg < 0.1
    assert told["verdict"]["word"] in ("good", "usable"), told["verdict"]
    assert {told["stations"][role]["id"] for role in ROLES} == {3001, 3002}
    assert ("truth_errors_mm" in best) == (name == "twin")  # no lab has it
    ideal = [e for e in told["poses"] if (e["estimator"], e["optics"]) == ("paper-lm", "ideal")]
    assert all(off(e)[0] > 5 * mm for e in ideal)


def test_a_station_that_moved_since_an_earlier_pose_is_told(run) -> None:
    against = pose(run.results, "measured")["check_against"]
    assert against["moved"] is True
    assert against["difference_mm"] == pytest.approx([-lab.SHIFT_MM, 0, 0], abs=5)
    assert against["sentence"].startswith("A station has moved: ")


def test_exports_in_the_frame_of_measured_points(run) -> None:
    """True places of both stations and of a diode in flight."""
    told = pose(run.results, "measured")["world"]
    assert told["name"] == "points" and told["residual_rms_mm"] < 10
    placed = exported(run.results, "measured")
    assert np.linalg.norm(placed[0][1] - lab.ROOM[1]) < 0.01
    assert np.degrees(np.linalg.norm(error(placed[0][0], lab.ROOM[0]))) < 0.6
    for k, role in enumerate(ROLES):
        assert told["stations"][role]["translation_mm"] == pytest.approx(1e3 * placed[k][1])
    (R0, t0), (R1, t1) = placed[0], placed[1]
    best = chosen(run.results, "measured")
    assert 1e3 * R0.T @ (t1 - t0) == pytest.approx(best["translation_mm"], abs=1e-6)
    assert np.degrees(to_angles(R0.T @ R1)) == pytest.approx(list(best["rotation_deg"].values()))


def test_a_dump_without_a_whole_frame_takes_a_file(run) -> None:
    """2.5 s hold 300 bits of about 350."""
    told, best = pose(run.results, "filed"), chosen(run.results, "filed")
    assert best["optics"] == "factory" and off(best)[0] < 6
    assert told["verdict"]["word"] == "usable"
    filed = [f"{role}: factory values from stations.json" for role in ROLES]
    assert set(filed) <= set(told["diagnostics"]["notes"])
    stations = json.loads((run.results / "calibrations/filed/stations.json").read_text())
    assert [station["id"] for station in stations] == [3001, 3002]
    assert all("taken from stations.json" in station["why"] for station in stations)


def test_the_board_is_tracked_with_its_own_or_an_earlier_calibration(run) -> None:
    """The path of 2.5 s, with stations calibrated in 4 s, against the truth."""
    tracks = {n: run.results / f"calibrations/{n}/track.parquet" for n in ("filed", "measured")}
    told, table = origin(tracks["filed"]), pq.read_table(tracks["filed"])
    assert (told["tracked_with"], told["still"], "reason" in told) == ("measured", False, False)
    track = {name: table[name].to_numpy() for name in table.column_names}
    _, place = lab.made("short").truth.motion.poses(track["time_s"])
    apart = np.stack([track[f"{axis}_mm"] for axis in "xyz"], axis=1) - 1e3 * place
    sd = np.stack([track[f"sd_{axis}_mm"] for axis in "xyz"], axis=1)
    assert len(apart) == 150 and np.linalg.norm(apart, axis=1).max() < 12
    assert np.mean((apart / sd) ** 2) < 4
    assert origin(tracks["measured"])["tracked_with"] is None
    assert pq.read_metadata(tracks["measured"]).num_rows == 240


def test_a_reference_of_other_stations_is_refused_when_calibrating(run) -> None:
    """Only then both are known. The recording itself is all right, so the run goes on, with a
    warning; pose.json states why there is no pose in it, and the last step names it again."""
    (warned,) = said(run.output.stdout, "warning: pose stranger: ")
    (last,) = said(run.output.stdout, "calibration stranger failed: ")
    told = pose(run.results, "stranger")
    assert "reference: its master is station 7, that of the recording is 3001" in warned
    assert (told["chosen"], told["poses"], told["verdict"]["word"]) == (None, [], "failed")
    assert warned.endswith(told["verdict"]["reason"]) and last.endswith(told["verdict"]["reason"])


def test_recordings_of_a_setup_are_joined(run) -> None:
    """Both see the same stations: nearer to the truth than the interval of either alone."""
    told = json.loads((run.results / "setups/lab/pair/pose.json").read_text())
    assert sorted(told["recordings"]) == ["filed", "measured"]
    best = told["poses"][told["chosen"]]
    assert (best["estimator"], best["optics"]) == ("batch", "factory")
    check = next(c for c in told["checks"] if c["name"] == "recordings agree")
    assert check["ok"] and set(told["predicted"]) == set(told["recordings"])
    true = json.loads((run.folder / "truth.json").read_text())
    assert np.linalg.norm(np.array(best["translation_mm"]) - 1e3 * np.array(true["t_m"])) < 3
    assert not list((run.results / "setups").glob("lab/[!p]*"))


def test_tables_and_figures_of_calibrations(run) -> None:
    tables = run.results / "tables"
    names = {"measured", "filed", "stranger"}
    found = {row["calibration"] for row in rows(tables / "lab_calibrations.csv")}
    assert found == names | {"pair (joint)"}
    tracks = {row["calibration"]: row for row in rows(tables / "lab_track.csv")}
    assert set(tracks) == names
    assert tracks["filed"]["stations"] == "measured" and float(tracks["filed"]["total_mm"]) > 0
    for number in (1, 2, 3):
        assert rows(tables / f"jansen_table{number}.csv")
        assert (tables / f"jansen_table{number}.md").stat().st_size > 0
    assert rows(tables / "lab_angles.csv") == []  # no board was at rest
    for figure in ("calibration", "track"):
        assert (run.results / f"calibrations/measured/{figure}.png").stat().st_size > 10_000


# The report

PLAIN = command()[3:]


def write_report(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, ROOT / "workflow/write_report.py", "results/report.html", *arguments],
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,  # as that of Snakemake
    )


@pytest.fixture(scope="module")
def made(run) -> tuple[Path, str]:
    """Folder of the run over everything with its report, and what was said of it."""
    written = write_report(run.folder, *PLAIN, *run.arguments)
    assert written.returncode == 0, written.stdout
    return run.folder, written.stdout


def test_opens_without_error_or_network(made, executable, tmp_path) -> None:
    folder, said = made
    assert re.fullmatch(r"results/report\.html: \d+\.\d MB\n", said)
    page = folder / "results/report.html"
    with browser(executable, tmp_path) as seen:
        seen.open(page.as_uri(), READY)
        front = seen.until("document.querySelector('#app').innerText")
        shown = seen.until("Object.keys(results)")
        for path in map(json.dumps, shown):
            seen.evaluate(SHOW % (path, path))
            seen.until(SHOWN % path)
        seen.open(page.as_uri(), f"{READY} && {LINKS}.length")
        links = dict(seen.evaluate(LINKS))
        menu = seen.until("document.querySelector('nav').innerText").split("\n")
        titles = []
        for width, height in ((1400, 900), (400, 800)):
            seen.size(width, height)
            titles.append(seen.evaluate(TITLE))
    assert seen.errors == []
    assert {url.partition(":")[0] for url in seen.requests} == {"data", "file"}
    assert {url for url in seen.requests if url.startswith("file")} == {page.as_uri()}
    for left, top, _ in titles:  # beside the menu, and not above or left of what can be reached
        assert 0 <= left < 30 and 0 <= top < 60
    assert titles[0][2] > 1000 and titles[1][2] > 300
    for words in ("How good is", "check: recordings", "lab: calibrations", "cut", "refused"):
        assert words in front
    assert links["take"] == "details/recordings/take.html"
    assert links["measured"] == "details/calibrations/measured.html"
    assert links["Monitor hall"] == "details/monitors/hall.html"
    assert all((page.parent / path).is_file() for path in links.values())
    assert {Path(path).suffix for path in shown} == {".html", ".svg", ".png"}  # of the monitor
    papers = "2 Skurowski & Pawlyta 2019", "3 Jansen et al. 2019"
    results = "4 Groups", "5 Recordings", "6 Calibrations"
    categories = ("1 Summary", *papers, *results, "7 Provenance")
    listed = [line.strip() for line in menu if line.strip() in categories]
    assert listed == [name for name in categories if name in listed]
    assert listed[0] == "1 Summary"
    assert listed[-1] == "7 Provenance"


def test_no_label_cell_or_file_name_asks_a_host_or_runs_in_a_page(
    made, executable, tmp_path
) -> None:
    """Nor is it a formula in a table, or a signal to a terminal."""
    folder, _ = made
    pages = sorted((folder / "results").rglob("*.html"))
    assert {"summary.html", "active.html", "check_subsets.html"} <= {page.name for page in pages}
    with browser(executable, tmp_path) as seen:
        for page in pages:
            seen.requests.clear()
            seen.open(page.as_uri(), "document.body")
            assert not [url for url in seen.requests if not url.startswith(("file:", "data:"))]
            assert not seen.evaluate(ACTIVE_LINKS), page
            assert seen.errors == [] and seen.dialogs == [], page
    text = (folder / "results/details/recordings/active.html").read_text(encoding="utf-8")
    assert html.escape(ACTIVE[0]) in text
    for path in (folder / "results").rglob("*.csv"):
        cells = [cell for row in csv.reader(path.open(encoding="utf-8")) for cell in row]
        assert not [cell for cell in cells if cell.startswith("=")], path


def test_pages_and_provenance(made) -> None:
    folder, _ = made
    results = folder / "results"
    found = json.loads((results / "provenance.json").read_text())
    tables = {path.name for path in (results / "tables").glob("*.csv")}
    assert set(found["tables"]) == tables
    assert {path.stem for path in (results / "pages").glob("*.html")} == {
        Path(name).stem for name in tables
    }
    watched = (results / "details/monitors/hall.html").read_text(encoding="utf-8")
    assert "Learning: 1 take on 1 day" in watched
    assert '<img src="../../monitors/hall/chart.png"' in watched
    inputs = {row["name"]: row for row in found["inputs"]}
    twin, calibration = inputs["T40-10"], inputs["twin"]
    assert (twin["name"], twin["source"], twin["seed"]) == ("T40-10", "twin", 110)
    assert calibration["source"] == "twin"
    rules = {row["rule"]: row["jobs"] for row in found["run_times"]}
    assert (rules["noise"], rules["calibration_twins"]) == (3, 1)
    for name in ("provenance.json", "provenance.html", "summary.html", "report_front.html"):
        text = (results / name).read_text()
        assert str(folder) not in text, name
        assert str(ROOT) not in text, name


def test_a_damaged_table_and_a_damaged_check_are_made_again(run, snakemake) -> None:
    """Named and removed, then made by a plain run; the check at once, as it is in the plan."""
    own, place = run.results / "recordings/take", "results/recordings/take"
    expected = {path.name: path.read_bytes() for path in own.iterdir() if path.is_file()}
    wanted = [f"{place}/{name}" for name in ("allan.parquet", "psd.parquet", "check.json")]
    damage(own / "trajectories.parquet")
    for name in ("allan.parquet", "psd.parquet"):
        (own / name).unlink()
    failed = snakemake(run.folder, *run.arguments, "--", *wanted)
    assert failed.returncode == 1
    table = f"{place}/trajectories.parquet"
    lines = [line for line in failed.stdout.splitlines() if f" take: {table} is damaged: " in line]
    assert any(line.endswith("make it anew") for line in lines), failed.stdout
    assert not (run.folder / table).exists()
    (own / "check.json").write_bytes(expected["check.json"][:-20])
    again = snakemake(run.folder, *run.arguments, "--", *wanted)
    assert again.returncode == 0, again.stdout
    assert "check.json is damaged: its content is not what was written" in again.stdout
    assert {path.name: path.read_bytes() for path in own.iterdir() if path.is_file()} == expected


def test_a_deleted_table_beside_its_check_is_made_again(run, snakemake) -> None:
    """Snakemake itself asks for the check alone, and ends as if all were there."""
    table = run.results / "calibrations/measured/sweeps.parquet"
    expected = table.read_bytes()
    table.unlink()
    done = snakemake(run.folder, *run.arguments, "--", "calibrations")  # fails: one is refused
    assert "measured/sweeps.parquet is missing; it is made anew" in done.stdout
    assert table.exists() and table.read_bytes() == expected, done.stdout
