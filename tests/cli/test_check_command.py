"""`mocap-metrology check`: one file without a sheet, from the choice of markers to the verdict."""

import errno
import gzip
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.cli import main, recording, results
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_csv
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.header import READ
from mocap_metrology.io.text.table import HOW
from mocap_metrology.recording import analyse, figures
from mocap_metrology.recording.clean import Entry, clean
from mocap_metrology.settings import Settings

ROOT = Path(__file__).resolve().parents[2]
RATE, SECONDS, SIGMA = 50.0, 70, 0.02
UNWANTED = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH")
ENVIRONMENT = {key: value for key, value in os.environ.items() if key not in UNWANTED}


def write_take(path: Path, seconds: float = SECONDS, walk_mm: float = 80) -> Path:
    """White noise of three markers; the first walks away."""
    n = round(RATE * seconds)
    position = np.random.default_rng(5).normal(0, SIGMA, (n, 3, 3))
    position += [[100, 200, 300], [400, 250, 900], [10, 20, 30]]
    position[:, 0, 0] += np.linspace(0, walk_mm, n)
    write_c3d(path, ["Walker", "Head", "Toe"], RATE, [position], n)
    return path


@pytest.fixture
def take(tmp_path: Path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return write_take(tmp_path / "static take (2).c3d")


@pytest.fixture
def undrawn(monkeypatch) -> None:
    """Figures take most of the time of a check."""
    for name in analyse.PICTURES:
        monkeypatch.setattr(figures, f"draw_{name.replace('adev', 'allan')}", lambda *_: None)


def test_verdict_on_one_file(take: Path, capsys) -> None:
    """White noise of a known size, by the two markers at rest; progress meanwhile, and
    nothing but results in the folder."""
    assert main.main(["check", take.name]) == 0
    printed = capsys.readouterr()
    progress, lines = printed.err.splitlines(), printed.out.splitlines()
    assert progress[0] == f"{take.name}: reading"
    assert progress[1].startswith("Markers: Head, Toe (the first two at rest)")
    assert progress[2] == "Head, Toe: 3500 frames at 50 Hz, 70 s"
    assert list(dict.fromkeys(x[:3] for x in progress[3:])) == [f"{k}/7" for k in range(1, 8)]
    folder = Path("results/check/static-take-2.c3d")
    assert lines[0] == "static-take-2: good" and f"  {folder / 'verdict.png'}" in lines
    verdict = json.loads((folder / "verdict.json").read_text())
    assert verdict["decided_by"]["value"] == pytest.approx(SIGMA, rel=0.05)
    assert verdict["series"]["x1"]["shares"] == {"white": pytest.approx(1.0)}
    written = {path.name for path in folder.iterdir()}
    assert {"check.json", "clean.parquet", "noise.csv", "adev.png", "diagnosis.json"} <= written
    assert not [name for name in written if name.startswith(".")]
    rows = read_csv(folder / "allan.csv", ("m", "tau_s", "adev_mm"))  # sigma / sqrt(m)
    first = next(row for row in rows if row["series"] == "x1" and row["m"] == 1)
    assert first["tau_s"] == 1 / RATE and first["adev_mm"] == pytest.approx(SIGMA, rel=0.05)


def test_what_cannot_be_checked_is_said_in_one_line(take: Path, capsys) -> None:
    """And leaves the results of an earlier check alone."""
    Path("folder.c3d").mkdir()
    Path("dump.bin").write_bytes(b"\0" * 64)
    Path("loop.c3d").symlink_to("loop.c3d")
    no_text = Path(os.fsdecode(b"a\xff.c3d"))
    no_text.write_bytes(take.read_bytes())
    Path("file").touch()
    rows = "\n".join(f"{k / 100},1000.5,2000.5,3000.25" for k in range(20)) + "\n"
    Path("nameless.csv").write_text(rows)
    Path("take.csv.gz").write_bytes(gzip.compress(rows.encode()))
    Path("cut.c3d").write_bytes(take.read_bytes()[:-20_000])
    position = np.random.default_rng(3).normal(0, 1e-5, (500, 1, 3)) + 0.1
    write_c3d(Path("metres.c3d"), ["A"], 50.0, [position], 500)
    for objects in ([], ["T20"], ["T20", "T21"]):
        lines = [f"0.1 {name} CONFIG {{}}\n" for name in objects]
        Path(f"objects{len(objects)}.rec").write_text("".join(lines))
    unit = " (--unit m or mm, in make UNIT=m or mm)"
    name = take.name
    cases = {
        ("nameless.csv",): f"nameless.csv: line 1 has numbers without names: {HOW}, here"
        f' --columns "t x y z", in make NAMES="t x y z"; {READ}',
        (
            "take.csv.gz",
        ): f"take.csv.gz: is not a C3D file: it looks like a gzip archive (unpack it); {READ}",
        ("nameless.csv", "--columns", "t A_x A_y A_z"): "nameless.csv: no column names the unit of"
        f" its coordinates: state it, m or mm{unit}",
        (str(no_text),): "a\\udcff.c3d: its name is not UTF-8; rename it",
        ("none.c3d",): "none.c3d: no such file; expected a recording, as take.c3d",
        ("loop.c3d",): "loop.c3d: no such file; expected a recording, as take.c3d",
        ("~nobody at all/a.c3d",): "~nobody at all/a.c3d: no such file; expected a recording, as"
        " take.c3d",
        (9999 * "a",): None,
        ("folder.c3d", "metres.c3d"): None,  # an empty folder does not stop the others
        ("dump.bin",): "dump.bin: a dump needs --board board.csv, the places of its photodiodes",
        (
            "objects1.rec",
        ): "objects1.rec: no light; expected raw pulses (C lines, or W and Y lines):"
        " record with a libsurvive that writes them",
        (
            "objects0.rec",
        ): "objects0.rec: no line `seconds object CONFIG ...`; expected a recording of libsurvive",
        ("objects2.rec",): "objects2.rec: name one of its objects with --board, in make BOARD=:"
        " T20, T21",
        ("cut.c3d",): None,
        ("metres.c3d", "--markers", "A"): None,
        (name, "--markers", "Haed"): f"{name}: no marker 'Haed'; did you mean Head?",
        (name, "--markers", "Head;Toe", "--output", "file"): "file: Not a directory; expected a"
        " folder to write to",
    }
    ends = {9999 * "a": "no such file; expected a recording, as take.c3d"}
    ends |= {"cut.c3d": "use what is there, add --accept-truncated, in make TRUNCATED=accept"}
    for arguments, message in cases.items():
        assert main.main(["check", *arguments]) == 1
        said = capsys.readouterr().err
        assert "Traceback" not in said
        last = said.splitlines()[-1]
        assert last == message if message else last.endswith(ends.get(arguments[0], unit)), last
    assert not Path("results").exists()


@pytest.mark.usefixtures("undrawn")
def test_files_of_one_name_are_distinguished_and_hidden_ones_left_alone(take: Path, capsys) -> None:
    """Of two folders, as macOS fills them; in the lines of verdicts and in the table."""
    for day in ("monday", "tuesday"):
        Path(day).mkdir()
        Path(day, "take.c3d").write_bytes(take.read_bytes())
        Path(day, "._take.c3d").write_bytes(b"Mac OS X")
    assert main.main(["check", "monday", "tuesday"]) == 0
    *verdicts, nothing, one, other = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in verdicts] == [
        "monday-take.c3d",
        "tuesday-take.c3d",
    ]
    assert not nothing and [row.split()[0] for row in (one, other)] == [
        "monday/take.c3d",
        "tuesday/take.c3d",
    ]


@pytest.mark.filterwarnings("error")
@pytest.mark.usefixtures("undrawn")
def test_positions_that_were_computed_are_called_so(tmp_path: Path, capsys) -> None:
    """Steps, a spike and a curve without any noise, in nine decimals."""
    t = np.arange(3000) / 3000
    columns = [t, t**2, 50 * np.floor(7 * t), 1.0 * (t == t[1000]), 400 + 0.1 * t**2, 0 * t, t < 0]
    path = tmp_path / "computed.csv"
    head = "time,A_x,A_y,A_z,B_x,B_y,B_z"
    np.savetxt(path, np.transpose(columns) * [30, *[1] * 6], "%.9f", ",", header=head, comments="")
    options = ["--unit", "mm", "--markers", "A", "B", "--output", str(tmp_path)]
    assert main.main(["check", str(path), *options, "--threads", "1"]) == 0
    words = (tmp_path / "diagnosis.json").read_text()
    assert "these positions are computed, not measured" in words


@pytest.mark.usefixtures("undrawn")
def test_a_file_that_is_cut_off_or_in_another_unit_is_used_where_that_is_stated(
    take: Path, capsys
) -> None:
    """Markers are chosen then, too; noise in m is that of the same take in mm."""
    Path("cut.c3d").write_bytes(take.read_bytes()[:-20_000])
    assert main.main(["check", "cut.c3d", "--accept-truncated"]) == 0
    printed = capsys.readouterr()
    assert "Markers: Head, Toe" in printed.err and printed.out.startswith("cut: good\n")
    position = np.random.default_rng(3).normal(0.2, 1e-5, (500, 1, 3))
    write_c3d(Path("m.c3d"), ["A"], 50.0, [position], 500)
    assert main.main(["check", "m.c3d", "--unit", "m", "--rate", "50.02", "--output", "out"]) == 0
    verdict = json.loads(Path("out/verdict.json").read_text())
    assert verdict["series"]["x1"]["sigma_frame_mm"] == pytest.approx(0.01, rel=0.2)
    assert "500 frames at 50.02 Hz" in capsys.readouterr().err


def test_an_interrupt_ends_in_one_line(tmp_path: Path) -> None:
    path = write_take(tmp_path / "long.c3d", 3600, 0)
    command = [sys.executable, "-m", "mocap_metrology", "check", path.name, "--markers", "Head"]
    with subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        # In the background of a shell without job control it would be ignored
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        cwd=tmp_path,
        env=ENVIRONMENT,
        text=True,
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
    code = "import sys, mocap_metrology.cli.main as m; m.parser();"
    code += "print({'numpy', 'pandas', 'scipy'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_what_crashed_is_said_and_where_its_traceback_is(take: Path, monkeypatch, capsys) -> None:
    def broken(*_: object) -> None:
        raise IndexError("index 118 is out of bounds")

    monkeypatch.setattr("mocap_metrology.recording.clean.examine", broken)
    assert main.main(["check", take.name, "--markers", "Head", "--output", "out"]) == 1
    assert capsys.readouterr().err.splitlines()[-3:] == [
        f"check of {take.name} crashed: IndexError: index 118 is out of bounds",
        "  traceback: out/crash.log",
        "No results were written",
    ]
    assert "in broken" in Path("out/crash.log").read_text()

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("mocap_metrology.recording.clean.examine", full)
    assert main.main(["check", take.name, "--markers", "Head", "--output", "full"]) == 1
    said = "full: No space left on device; no results were written"
    assert capsys.readouterr().err.splitlines()[-1] == said and not Path("full").exists()


def test_results_are_replaced_whole_or_not_at_all(tmp_path: Path) -> None:
    before = dict.fromkeys(("a.csv", "b.csv", "mine.txt"), "old")
    for name, text in before.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(KeyboardInterrupt), results.replaced(tmp_path, ("a.csv", "b.csv")) as part:
        (part / "a.csv").write_text("new")
        raise KeyboardInterrupt
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == before
    with results.replaced(tmp_path, ("a.csv", "b.csv")) as part:
        (part / "a.csv").write_text("new")
    after = {p.name: p.read_text() for p in tmp_path.iterdir()}
    assert after == {"a.csv": "new", "mine.txt": "old"}
    (killed := tmp_path / ".part-0123456789ab").mkdir()
    with results.replaced(tmp_path, ()) as other, results.replaced(tmp_path, ()):
        assert other.exists() and not killed.exists()


@pytest.mark.parametrize(
    ("labels", "markers", "why"),
    [  # not E, the quietest: the first two at rest
        ("ABCDE", ["B", "D"], "the first two at rest"),
        ("AB", ["B", "A"], "those that move least, B by 0.1 mm, A by 30 mm: no two are at rest"),
        ("CB", ["B"], "all at rest"),
        ("F", ["F"], "all at rest"),
        ("C", [], "those that move least, : no two are at rest"),
    ],
)
def test_choice_of_markers(labels: str, markers: list[str], why: str) -> None:
    moved = {"A": 30.0, "B": 0.1, "C": None, "D": 0.5, "E": 0.01, "F": 2.0}
    assert recording.choose(list(labels), moved.get, 2.0) == (markers, why)


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
    entry = Entry([str(samples / "c3d" / file)], (), None, accept_truncated=True)
    assert ", ".join(recording.chosen(entry, 2.0)[0]) == chosen


def test_names_of_recordings_are_short_and_distinguished() -> None:
    """Those without a letter of ASCII, or too long, by a hash."""
    names = {
        "a/take.c3d": "take",
        "Wand 240 (final).c3d": "Wand-240-final",
        "-x.c3d": "x",
        "_x.c3d": "x",
    }
    assert {file: results.name_of(Path(file)) for file in names} == names
    files = ["\u65e5\u672c.c3d", "\u4e2d\u6587.c3d", *(f"{'x' * n}.c3d" for n in (200, 201))]
    short = {results.name_of(Path(file)) for file in files}
    assert len(short) == len(files) and all(len(name) <= 60 for name in short)


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


def test_make_takes_names_as_they_are_and_one_folder_of_results(tmp_path: Path) -> None:
    """Neither make nor the shell reads a $, a ` or a quote in them."""
    path = f'{tmp_path}/a `touch PWNED` $HOME "q.c3d'
    make = ["make", "-C", str(ROOT), "check", f"FILE={path}", "-o", "env"]
    done = subprocess.run(make, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and f"{path}: no such file" in done.stderr
    assert not list(ROOT.glob("PWNED"))
    make = ["make", "-n", "-C", str(ROOT), "report", "RESULTS=out", "-o", "warm"]
    make.append("ARGS=--config recordings=my.tsv")
    said = subprocess.run(make, capture_output=True, text=True, check=True).stdout
    assert said.count("--config results=out") == said.count("recordings=my.tsv") == 2
    assert "out/report.html" in said


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        (["*0", "*1"], "*0, *1: the first two at rest; no marker of the file has a label"),
        (["Unlabeled 7", "A;B"], "Unlabeled 7: all at rest; no marker of the file has a"),
        (["LKneeAngles", "RHipPower"], "all its points were computed by a model, not measured"),
        (["A", "LKneeAngles"], "A: all at rest"),
    ],
)
def test_points_that_are_no_markers_are_named_for_what_they_are(
    tmp_path: Path, labels: list[str], words: str
) -> None:
    n = round(RATE * 20)
    position = np.random.default_rng(5).normal([[300.0], [350.0]], SIGMA, (n, 2, 3))
    write_c3d(tmp_path / "take.c3d", labels, RATE, [position], n)
    entry = Entry([str(tmp_path / "take.c3d")], (), None)
    if "computed" in words:
        with pytest.raises(Refusal, match=words):
            recording.chosen(entry, 2.0)
        return
    markers, why = recording.chosen(entry, 2.0)
    assert f"{', '.join(markers)}: {why}".startswith(words)


@pytest.mark.parametrize("walks_mm", [0, 500])
def test_one_marker_under_two_labels_is_taken_once(tmp_path: Path, walks_mm: float) -> None:
    """As of a body that is exported with its markers: neither a distance nor a second opinion."""
    n = round(RATE * 20)
    position = np.random.default_rng(5).normal([[300.0], [300.0], [350.0]], SIGMA, (n, 3, 3))
    position[:, :, 0] += np.linspace(0, walks_mm, n)[:, None]
    write_c3d(tmp_path / "take.c3d", ["Body:M1", "M1", "M2"], RATE, [position], n)
    entry = Entry([str(tmp_path / "take.c3d")], ["Body:M1", "M1"], None)
    assert set(recording.chosen(entry, 2.0)[0]) == {"Body:M1", "M2"}
    with pytest.raises(Refusal, match=r"^take.c3d: Body:M1 and M1 are within 2 mm .* one marker"):
        clean(entry, analyse.origin("take"), Settings(), tmp_path / "out")


@pytest.mark.parametrize(
    "options",
    [*(f"--{of} x" for of in ("factory", "reference", "world-points", "known-length"))]
    + ["--inertial", "--world master", "--format angles-csv"]
    + [f"--board b.csv --{of}" for of in ("markers A", "rate 100", "unit m", "accept-truncated")]
    + ["--board b.csv --columns x", "--rate 0", "--rate x", "--threads 0", "--threads 1.5"],
)
def test_options_that_do_not_apply_or_have_no_sense_are_refused(options: str, capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main.main(["check", "take.c3d", *options.split()])
    assert ended.value.code == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert "board" in last or "expected" in last


def test_a_marker_that_is_one_number_throughout_is_not_chosen(tmp_path: Path) -> None:
    position = np.random.default_rng(5).normal([[300], [310], [320]], SIGMA, (2000, 3, 3))
    position[:, 0] = -9999
    write_c3d(tmp_path / "take.c3d", ["A", "B", "C"], RATE, [position], 2000)
    assert recording.chosen(Entry([str(tmp_path / "take.c3d")], (), None), 2.0)[0] == ["B", "C"]
