"""`mocap-metrology check`: one file without a sheet, from the choice of markers to the verdict."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.cli import main, markers, results
from mocap_metrology.common.files import read_csv
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.header import READ
from mocap_metrology.io.text.table import HOW

ROOT = Path(__file__).resolve().parents[2]
RATE, SECONDS, SIGMA = 50.0, 70, 0.02


def environment() -> dict[str, str]:
    unwanted = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH")
    return {key: value for key, value in os.environ.items() if key not in unwanted}


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "mocap_metrology", "check", *arguments]


def check(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    how = {"env": environment(), "capture_output": True, "text": True, "timeout": 900}
    return subprocess.run(command(*arguments), cwd=folder, check=False, **how)


def write_take(path: Path, seconds: float = SECONDS, walk_mm: float = 80) -> Path:
    """White noise of three markers; the first walks away."""
    n = round(RATE * seconds)
    position = np.random.default_rng(5).normal(0, SIGMA, (n, 3, 3))
    position += [[100, 200, 300], [400, 250, 900], [10, 20, 30]]
    position[:, 0, 0] += np.linspace(0, walk_mm, n)
    write_c3d(path, ["Walker", "Head", "Toe"], RATE, [position], n)
    return path


@pytest.fixture
def take(tmp_path: Path) -> Path:
    return write_take(tmp_path / "static take (2).c3d")


def test_verdict_on_one_file(take: Path) -> None:
    """White noise of a known size, by the two markers at rest; progress meanwhile, and
    nothing but results in the folder."""
    found = check(take.parent, take.name)
    assert found.returncode == 0, found.stderr
    said, lines = found.stderr.splitlines(), found.stdout.splitlines()
    assert said[0] == f"{take.name}: reading"
    assert said[1].startswith("Markers: Head, Toe (the first two at rest)")
    assert said[2] == "Head, Toe: 3500 frames at 50 Hz, 70 s"
    steps = list(dict.fromkeys(line[:3] for line in said[3:]))
    assert steps == [f"{k}/7" for k in range(1, 8)]
    assert lines[0] == "static-take-2: good"
    own = Path("results/check/static-take-2.c3d")
    assert f"  {own / 'verdict.png'}" in lines
    verdict = json.loads((take.parent / own / "verdict.json").read_text())
    assert verdict["decided_by"]["value"] == pytest.approx(SIGMA, rel=0.05)
    assert verdict["series"]["x1"]["shares"] == {"white": pytest.approx(1.0)}
    written = {path.name for path in (take.parent / own).iterdir()}
    assert {"check.json", "clean.parquet", "noise.csv", "adev.png", "diagnosis.json"} <= written
    assert not [name for name in written if name.startswith(".")]


def test_markers_that_move_are_said_to_move_and_nothing_of_noise(tmp_path: Path) -> None:
    path = write_take(tmp_path / "gait.c3d", 20, 900)
    found = check(tmp_path, path.name, "--markers", "Walker", "--output", "kept")
    lines = found.stdout.splitlines()
    assert lines[0] == "gait: bad"
    assert lines[1].startswith("Walker moves: x1 by 8")
    assert "uncertainties" not in found.stdout
    assert "Findings" not in found.stdout


def test_what_cannot_be_checked_is_said_in_one_line(take: Path) -> None:
    """And leaves the results of an earlier check alone."""
    text = take.parent / "words.c3d"
    text.write_text("not a recording at all\n" * 100)
    (take.parent / "folder.c3d").mkdir()
    (take.parent / "dump.bin").write_bytes(b"\0" * 64)
    (take.parent / "file").touch()
    name = take.name
    rows = "\n".join(f"{k / 100},1000.5,2000.5,3000.25" for k in range(20)) + "\n"
    (take.parent / "nameless.csv").write_text(rows)
    cases = {
        ("nameless.csv",): (
            f"nameless.csv: line 1 has numbers without names: {HOW}; {READ}, here --columns"
            ' "t x y z", in make NAMES="t x y z"'
        ),
        ("nameless.csv", "--columns", "t A_x A_y A_z"): (
            "nameless.csv: no column names the unit of its coordinates: state it, m or mm"
            " (--unit m or mm, in make UNIT=m or mm)"
        ),
        ("none.c3d",): "none.c3d: no such file; expected a recording, as take.c3d",
        ("folder.c3d",): "folder.c3d: is not a file; expected a recording, as take.c3d",
        ("dump.bin",): "dump.bin: a dump needs --board board.csv, the places of its photodiodes",
        (text.name,): "words.c3d: is not a C3D file: it looks like text; " + READ,
        (name, "--markers", "Haed"): f"{name}: no marker 'Haed'; did you mean Head?",
        (name, "--markers", "Head,Toe"): (
            f'{name}: no marker \'Head,Toe\'; separate the labels with ";": "Head;Toe"'
        ),
        (name, "--markers", "head"): (
            f"{name}: no marker 'head'; the letter case differs: did you mean Head?"
        ),
        (name, "--markers", "Head;Toe", "--output", "file"): (
            "file: Not a directory; expected a folder to write to"
        ),
    }
    for arguments, message in cases.items():
        found = check(take.parent, *arguments)
        assert (found.returncode, found.stdout) == (1, "")
        assert found.stderr.splitlines()[-1] == message
        assert "Traceback" not in found.stderr
    assert not (take.parent / "results").exists()


def test_a_file_that_is_cut_off_is_used_where_that_is_accepted(take: Path) -> None:
    """Markers are chosen then, too."""
    cut = take.parent / "cut.c3d"
    cut.write_bytes(take.read_bytes()[:-20_000])
    refused = check(take.parent, cut.name)
    assert refused.returncode == 1
    assert refused.stderr.splitlines()[-1].endswith(
        "; to use what is there, add --accept-truncated, in make TRUNCATED=accept"
    )
    found = check(take.parent, cut.name, "--accept-truncated")
    assert found.returncode == 0, found.stderr
    assert "Markers: Head, Toe" in found.stderr
    assert found.stdout.startswith("cut: good\n")


def test_the_unit_that_is_given_counts(tmp_path: Path) -> None:
    """Coordinates in m under mm are refused; as m they are those of the same take in mm."""
    n = 500
    position = np.random.default_rng(3).normal(0, 1e-5, (n, 2, 3))
    position += [[0.1, 0.2, 0.3], [0.4, 0.1, 1]]
    write_c3d(tmp_path / "m.c3d", ["A", "B"], 50.0, [position], n)
    refused = check(tmp_path, "m.c3d", "--markers", "A", "B")
    assert refused.returncode == 1
    assert refused.stderr.rstrip().endswith("(--unit m or mm, in make UNIT=m or mm)")
    found = check(tmp_path, "m.c3d", "--markers", "A", "B", "--unit", "m", "--output", "kept")
    assert found.returncode == 0, found.stderr
    verdict = json.loads((tmp_path / "kept/verdict.json").read_text())
    assert verdict["series"]["x1"]["sigma_frame_mm"] == pytest.approx(0.01, rel=0.2)


def test_an_interrupt_ends_in_one_line(tmp_path: Path) -> None:
    path = write_take(tmp_path / "long.c3d", 3600, 0)
    how = {"cwd": tmp_path, "env": environment(), "text": True}
    with subprocess.Popen(
        command(path.name, "--markers", "Head"),
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        # In the background of a shell without job control it would be ignored
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        **how,
    ) as process:
        for line in process.stderr:
            if line.startswith("2/7"):
                break
        process.send_signal(signal.SIGINT)
        said, _ = process.stderr.read(), process.stdout.read()
        assert process.wait(60) == main.INTERRUPTED
    rest = [line for line in said.splitlines() if line and not line[0].isdigit()]
    assert rest == ["Interrupted; no results were written"]
    assert not (tmp_path / "results").exists()


def test_the_first_line_waits_for_no_heavy_import() -> None:
    code = (
        "import sys, mocap_metrology.cli.main; print({'numpy', 'pandas', 'scipy'} & {*sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_what_crashed_is_said_and_where_its_traceback_is(take: Path, monkeypatch, capsys) -> None:
    def broken(*_: object) -> None:
        raise IndexError("index 118 is out of bounds")

    monkeypatch.setattr("mocap_metrology.recording.clean.examine", broken)
    kept = take.parent / "kept"
    assert main.main(["check", str(take), "--markers", "Head", "--output", str(kept)]) == 1
    said = capsys.readouterr().err.splitlines()
    assert said[-3:] == [
        f"check of {take.name} crashed: IndexError: index 118 is out of bounds",
        f"  traceback: {kept / 'crash.log'}",
        "No results were written",
    ]
    assert "in broken" in (kept / "crash.log").read_text()


def test_results_are_replaced_whole_or_not_at_all(tmp_path: Path) -> None:
    folder = tmp_path / "kept"
    folder.mkdir()
    for name in ("a.csv", "b.csv", "mine.txt"):
        (folder / name).write_text("old")
    with pytest.raises(KeyboardInterrupt), results.replaced(folder, ("a.csv", "b.csv")) as part:
        (part / "a.csv").write_text("new")
        raise KeyboardInterrupt
    assert {p.name: p.read_text() for p in folder.iterdir()} == dict.fromkeys(
        ("a.csv", "b.csv", "mine.txt"), "old"
    )
    with results.replaced(folder, ("a.csv", "b.csv")) as part:
        (part / "a.csv").write_text("new")
    assert {p.name: p.read_text() for p in folder.iterdir()} == {"a.csv": "new", "mine.txt": "old"}


def test_choice_of_markers() -> None:
    moved = {"A": 30.0, "B": 0.1, "C": None, "D": 0.5, "E": 0.01}
    still, why = markers.choose(list(moved), moved.get, 2.0)
    assert (still, why) == (["B", "D"], "the first two at rest")  # not E, the quietest
    one, why = markers.choose(["A", "B"], moved.get, 2.0)
    assert one == ["B", "A"]
    assert why == "those that move least, B by 0.1 mm, A by 30 mm: no two are at rest"
    assert markers.choose(["C", "B"], moved.get, 2.0) == (["B"], "all at rest")
    assert markers.choose(["C"], moved.get, 2.0)[0] == []


@pytest.mark.parametrize(
    ("file", "chosen"),
    [  # powers in W, axes of a model, markers that were never seen come before these in the file
        ("c3dorg_sample04/sub_labels.c3d", "Matt:RCLA, Matt:LCLA"),
        ("btk_pig/PiG_Calibration3_FF.c3d", "LANK, LHEE"),
        ("btk_others/FunctionalStatic.c3d", "LANK, LHEE"),
        ("ezc3d_testfiles/Optotrak.c3d", "Marker_37, Marker_38"),
    ],
)
def test_markers_that_are_chosen_of_real_files(file: str, chosen: str, samples: Path) -> None:
    from mocap_metrology.recording.check import Entry

    asked = Entry([str(samples / "c3d" / file)], (), None, accept_truncated=True)
    assert ", ".join(markers.chosen(asked, 2.0)[0]) == chosen


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("a/take.c3d", "take"),
        ("Wand 240 (final).c3d", "Wand-240-final"),
        ("-x.c3d", "x"),
        ("_1.trc", "_1"),
    ],
)
def test_names_of_recordings(file: str, name: str) -> None:
    assert results.name_of(Path(file)) == name


def test_names_are_told_apart() -> None:
    """Without a letter of ASCII, or too long."""
    files = ["\u65e5\u672c.c3d", "\u4e2d\u6587.c3d", *(f"{'x' * n}.c3d" for n in (200, 201))]
    names = {results.name_of(Path(file)) for file in files}
    assert len(names) == len(files)
    assert all(len(name) <= results.LONGEST for name in names)


def test_make_takes_names_as_they_are(take: Path) -> None:
    """Neither make nor the shell reads a $, a ` or a quote in them."""
    name = 'a `touch PWNED` $HOME "q.c3d'
    make = ["make", "-C", str(ROOT), "check", f"FILE={take.parent / name}", "-o", "env"]
    how = {"capture_output": True, "text": True, "check": False, "timeout": 900}
    found = subprocess.run(make, env=environment(), **how)
    assert found.returncode != 0
    assert f"{take.parent / name}: no such file" in found.stderr
    assert not list(ROOT.glob("PWNED"))


@pytest.mark.parametrize(
    ("arguments", "call"),
    [
        ("FILE=a MARKERS=A;B RATE=100 UNIT=m TRUNCATED=accept RESULTS=out",
         '--rate "100" --unit "m" --accept-truncated ${CHECK_MARKERS:+--markers="$CHECK_MARKERS"}'
         ' ${CHECK_NAMES:+--columns="$CHECK_NAMES"}'),
        ("FILE=a BOARD=b.csv",
         '--output="$CHECK_RESULTS" ${CHECK_BOARD:+--board="$CHECK_BOARD"} -- "$CHECK_FILE"'),
        ("FILE=a BOARD=HMD INERTIAL=use", '--inertial'),
        ("FILE=a BOARD=b.csv WORLD=master POINTS=p.csv",
         '--world "master" ${CHECK_POINTS:+--world-points="$CHECK_POINTS"} ${CHECK_LENGTH:'),
        ("FILE=a BOARD=b.csv LENGTH=points", '${CHECK_LENGTH:+--known-length="$CHECK_LENGTH"}'),
    ],
)  # fmt: skip
def test_make_hands_on_what_is_asked(arguments: str, call: str) -> None:
    make = ["make", "-n", "-C", str(ROOT), "check", *arguments.split(), "-o", "env"]
    done = subprocess.run(make, capture_output=True, text=True, check=True)
    assert call in " ".join(done.stdout.replace("\\\n", " ").split())


@pytest.mark.parametrize("asked", [[], ["ARGS=--config recordings=my.tsv"]])
def test_a_folder_of_results_is_that_of_run_and_report(asked: list[str]) -> None:
    make = ["make", "-n", "-C", str(ROOT), "report", "RESULTS=out", *asked, "-o", "warm"]
    said = subprocess.run(make, capture_output=True, text=True, check=True).stdout
    assert said.count("--config results=out") == 2
    assert "out/report.html" in said
    assert said.count("recordings=my.tsv") == (2 if asked else 0)


def test_processors_are_counted_where_there_is_no_affinity(monkeypatch) -> None:
    from mocap_metrology.cli import recording

    assert recording.processors() == len(os.sched_getaffinity(0))
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 7)
    assert recording.processors() == 7


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        (["*0", "*1"], "Markers: *0, *1 (the first two at rest; no marker of the file has a label"),
        (["Unlabeled 7", "A;B"], "Markers: Unlabeled 7 (all at rest; no marker of the file has a"),
        (["LKneeAngles", "RHipPower"], "all its points were computed by a model, not measured"),
        (["A", "LKneeAngles"], "Markers: A (all at rest);"),
    ],
)
def test_points_that_are_no_markers_are_named_for_what_they_are(
    tmp_path: Path, capsys, labels: list[str], words: str
) -> None:
    n = round(RATE * 20)
    position = np.random.default_rng(5).normal(300, SIGMA, (n, 2, 3))
    write_c3d(tmp_path / "take.c3d", labels, RATE, [position], n)
    arguments = ["check", str(tmp_path / "take.c3d"), "--output", str(tmp_path / "results")]
    status = main.main(arguments)
    assert words in capsys.readouterr().err
    assert status == ("computed" in words)


def test_a_file_of_rigid_bodies_alone_is_judged(tmp_path: Path, capsys) -> None:
    """Rotation matrix and position in metres, as a tracker writes them (`Freq:`)."""
    rng = np.random.default_rng(3)
    places = rng.normal([0.3, 0.4, 1.5], 2e-5, (2000, 3))
    rows = [f"1 0 0 {x:.6f} 0 1 0 {y:.6f} 0 0 1 {z:.6f}" for x, y, z in places]
    (tmp_path / "drone.txt").write_text("\n".join(["# Freq: 100", *rows, ""]))
    arguments = ["check", str(tmp_path / "drone.txt"), "--output", str(tmp_path / "results")]
    assert main.main(arguments) == 0
    assert "tracker (all at rest; they are rigid bodies, whose" in capsys.readouterr().err
    verdict = json.loads((tmp_path / "results/verdict.json").read_text())
    assert verdict["series"]["x1"]["sigma_frame_mm"] == pytest.approx(0.02, rel=0.1)


def test_several_files_and_folders_have_a_table_in_the_end(tmp_path: Path, capsys) -> None:
    """One that is refused does not stop the others; the status tells of it."""
    folder = tmp_path / "takes"
    folder.mkdir()
    write_take(folder / "b.c3d")
    (folder / "a.trc").write_text("no recording")
    (folder / "notes.txt.bak").write_text("left alone")
    single = write_take(tmp_path / "c.c3d")
    out = tmp_path / "out"
    assert main.main(["check", str(folder), str(single), "--output", str(out)]) == 1
    table = [line.split()[:2] for line in capsys.readouterr().out.splitlines()[-3:]]
    assert table == [["a.trc", "no"], ["b.c3d", "good"], ["c.c3d", "good"]]
    assert {path.name for path in out.iterdir()} == {"b.c3d", "c.c3d"}
    assert main.main(["check", str(single), str(single), "--output", str(out)]) == 0


def test_allan_deviations_as_csv(take: Path, capsys) -> None:
    """Those of allan_masked.parquet, which adev.png shows: of white noise sigma / sqrt(m)."""
    assert main.main(["check", str(take), "--output", str(take.parent / "out")]) == 0
    rows = read_csv(take.parent / "out/allan.csv", ("m", "tau_s", "adev_mm"))
    first = next(row for row in rows if row["series"] == "x1" and row["m"] == 1)
    assert first["tau_s"] == 1 / RATE and first["adev_mm"] == pytest.approx(SIGMA, rel=0.05)


@pytest.mark.parametrize(
    "options",
    [
        *(
            ["--world", "master"],
            ["--inertial"],
            ["--factory", "f.json"],
            ["--format", "angles-csv"],
        ),
        *(["--reference", "r.json"], ["--world-points", "p.csv"], ["--known-length", "points"]),
        *(["--board", "b.csv", *of] for of in (["--markers", "A"], ["--rate", "100"])),
        *(["--board", "b.csv", *of] for of in (["--unit", "m"], ["--accept-truncated"])),
    ],
)
def test_options_that_do_not_apply_are_refused(options: list[str], capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main.main(["check", "take.c3d", *options])
    assert ended.value.code == 2
    assert "board" in capsys.readouterr().err.splitlines()[-1]


def test_version(capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main.main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"mocap-metrology {metadata.version('mocap-metrology')}\n"
