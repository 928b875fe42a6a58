"""`make check FILE=x.c3d`: one file without a sheet, from choice of markers to the verdict."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import check_file
import numpy as np
import pytest
from mocap_workflow import one_file
from running import environment

from mocap_metrology.io.c3d.write import write_c3d

ROOT = Path(__file__).resolve().parents[2]
RATE, SECONDS, SIGMA = 50.0, 70, 0.02


def check(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, str(ROOT / "workflow/check_file.py"), *arguments]
    how = {"env": environment(), "capture_output": True, "text": True, "timeout": 900}
    return subprocess.run(command, cwd=folder, check=False, **how)


@pytest.fixture
def take(tmp_path: Path) -> Path:
    """Three markers, the first of which walks away."""
    n = round(RATE * SECONDS)
    position = np.random.default_rng(5).normal(0, SIGMA, (n, 3, 3))
    position += [[100, 200, 300], [400, 250, 900], [10, 20, 30]]
    position[:, 0, 0] += np.linspace(0, 80, n)
    path = tmp_path / "static take (2).c3d"
    write_c3d(path, ["Walker", "Head", "Toe"], RATE, [position], n)
    return path


def test_verdict_on_one_file(take: Path) -> None:
    """White noise of a known size, by the two markers that stand still; a marker by name."""
    found = check(take.parent, take.name, "--results", "kept")
    assert found.returncode == 0, found.stdout + found.stderr
    lines = found.stdout.splitlines()
    assert lines[0].startswith("Markers: Head, Toe (the first two that stand still)")
    assert lines[1] == "  Walker, Head, Toe"
    assert "static-take-2: good" in lines
    own = take.parent / "kept/recordings/static-take-2"
    assert f"  {own / 'verdict.png'}" in lines
    verdict = json.loads((own / "verdict.json").read_text())
    assert verdict["decided_by"]["value"] == pytest.approx(SIGMA, rel=0.05)
    assert verdict["series"]["x1"]["shares"] == {"white": pytest.approx(1.0)}
    assert (own / "adev.png").is_file()
    assert (own / "diagnosis.json").is_file()


def test_what_cannot_be_checked_is_said_in_one_line(take: Path) -> None:
    text = take.parent / "words.c3d"
    text.write_text("not a recording at all\n" * 100)
    cases = {
        ("none.c3d",): "none.c3d: no such file; expected a recording, as take.c3d",
        (take.name, "--markers", "Head;Nose"): (
            "static take (2).c3d: no marker Nose; expected some of: Walker, Head, Toe"
        ),
        (text.name,): "words.c3d: is not a C3D file: it looks like text",
    }
    for arguments, message in cases.items():
        found = check(take.parent, *arguments)
        assert (found.returncode, found.stdout) == (1, "")
        assert found.stderr.rstrip("\n") == message
    assert not (take.parent / "results").exists()


def test_choice_of_markers() -> None:
    moved = {"A": 30.0, "B": 0.1, "C": None, "D": 0.5, "E": 0.01, "*7": 0.0}
    still, why = one_file.choose(list(moved), moved.get, 2.0)
    assert (still, why) == (["B", "D"], "the first two that stand still")  # not E, the quietest
    one, why = one_file.choose(["A", "B"], moved.get, 2.0)
    assert one == ["B", "A"]
    assert why == "those that move least (B by 0.1 mm, A by 30 mm): no two stand still"
    assert one_file.choose(["C", "B"], moved.get, 2.0) == (["B"], "all that stand still")
    assert one_file.choose(["C", "*7"], moved.get, 2.0)[0] == []


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("a/take.c3d", "take"),
        ("Wand 240 (final).c3d", "Wand-240-final"),
        ("-x.c3d", "x"),
        ("_1.trc", "recording-_1"),
    ],
)
def test_names_that_sheets_take(file: str, name: str) -> None:
    assert one_file.name_of(file) == name


def test_names_are_told_apart() -> None:
    """Without a letter of ASCII, too long, or so repeated that Snakemake would refuse them."""
    files = [
        "\u65e5\u672c.c3d",
        "\u4e2d\u6587.c3d",
        "\u00dc.c3d",
        *(f"{'x' * n}.c3d" for n in (200, 201)),
    ]
    names = [one_file.name_of(file) for file in files]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"(recording|xxxxxxxxxxxx)-[0-9a-f]{6}", name) for name in names)
    assert [one_file.folder_of(f) for f in ("a/take.C3D", "take.trc")] == ["take.c3d", "take.trc"]


def test_labels_that_stand_twice_are_numbered() -> None:
    assert one_file.numbered(["A", "B ", "A"]) == ["A#1", "B", "A#2"]
    seen = []
    one_file.choose(["A", "B", "A"], lambda label: seen.append(label), 2.0)
    assert seen == ["A#1", "B", "A#2"]


def test_make_takes_names_as_they_are(take: Path) -> None:
    """Neither make nor the shell reads a $, a ` or a quote in them."""
    name = 'a `touch PWNED` $HOME "q.c3d'
    command = ["make", "-C", str(ROOT), "check", f"FILE={take.parent / name}", "-o", "warm"]
    how = {"capture_output": True, "text": True, "check": False, "timeout": 900}
    found = subprocess.run(command, env=environment(), **how)
    assert found.returncode != 0
    assert f"{take.parent / name}: no such file" in found.stderr
    assert not list(ROOT.glob("PWNED"))


def test_what_is_asked_wrongly_is_said_in_one_line(take: Path) -> None:
    (take.parent / "folder.c3d").mkdir()
    cases = {
        ("folder.c3d",): "folder.c3d: is not a file; expected a recording, as take.c3d",
        (take.name, "--markers", "Head;Toe", "--results", take.name): (
            f"{take}: File exists; expected a folder to write to"
        ),
        (take.name, "--rate", "x"): "rate 'x'; expected frames a second, as 100",
    }
    for arguments, message in cases.items():
        assert check(take.parent, *arguments).stderr.rstrip("\n") == message
    none = check(take.parent, take.name, "--cores", "0")
    assert none.returncode == 2
    assert none.stderr.endswith("--cores: '0'; expected a whole number, 1 or more\n")


def test_a_reason_of_an_earlier_sheet_is_not_given(tmp_path: Path) -> None:
    sheet, said, log = (tmp_path / name for name in ("check.tsv", "check.json", "check.log"))
    for path, text in ((sheet, "a"), (said, '{"ok": false, "why": "old"}'), (log, "new\n")):
        path.write_text(text)
    for second, why in ((1, "refused: old"), (3, "new\n")):
        os.utime(sheet, (second, second))
        os.utime(said, (2, 2))
        assert check_file._why(sheet, said, log).startswith(why)


def test_long_lists_of_labels_are_cut() -> None:
    assert one_file.listed(["A", " ", "B"]) == "A, B"
    assert one_file.listed([f"M{k}" for k in range(70)]).endswith("M59 and 10 more")


def failed(rule: str, log: Path, how: str = "returned non-zero exit status 1") -> str:
    """What Snakemake says of a rule that failed."""
    return (
        f"RuleException:\nCalledProcessError in file \"x.smk\", line 1:\nCommand 'x.py' {how}.\n"
        f"[Sun Nov 22 07:04:34 2026]\nError in rule {rule}:\n    message: None\n    jobid: 5\n"
        f"    log: {log} (check log file(s) for error details)\n"
        "[Sun Nov 22 07:04:37 2026]\nFinished jobid: 8 (Rule: recording_figures)\n"
        "Exiting because a job execution failed. Look above for error messages\n"
        "WorkflowError:\nAt least one job did not complete successfully.\n"
    )


def test_what_crashed_is_said_and_where_its_traceback_is(tmp_path: Path) -> None:
    """A crash with its exception, a refusal as it is, a process that was killed."""
    paths = [tmp_path / name for name in ("noise.log", "psd.log", "allan.log")]
    step = "with step(snakemake) as log:\n    log.info('fits')\n    log.error('a')\n"
    del step
    paths[0].write_text(
        "07:04:30 INFO fits\n07:04:34 ERROR IndexError: index 118 is out of bounds (see "
        f'{paths[0]})\nTraceback (most recent call last):\n  File "noise.py", line 9, in <module>\n'
        '    x()\n  File "/a/lines.py", line 127, in _search\n    y\nIndexError: index 118 is out\n'
    )
    paths[1].write_text("07:04:34 ERROR take.c3d: 10 frames; expected 100\n")
    paths[2].write_text("")
    log = tmp_path / "check.log"
    log.write_text(
        failed("noise", paths[0]) + failed("psd", paths[1])
        + failed("allan", paths[2], "died with <Signals.SIGKILL: 9>")
    )  # fmt: skip
    said = check_file._why(tmp_path / "check.tsv", tmp_path / "check.json", log).splitlines()
    assert said == [
        "step noise crashed: IndexError: index 118 is out of bounds, in lines.py, line 127",
        f"  traceback: {paths[0]}",
        "step psd: take.c3d: 10 frames; expected 100",
        "step allan ended: died with <Signals.SIGKILL: 9>",
        f"  its log: {paths[2]}",
        f"No verdict; all that was said is in {log}",
    ]


def test_a_crash_before_any_step_is_said(take: Path, monkeypatch, capsys) -> None:
    def broken(*_: object) -> None:
        raise IndexError("index 118 is out of bounds")

    monkeypatch.setattr(check_file, "_markers", broken)
    assert check_file.main([str(take), "--results", str(take.parent / "kept")]) == 1
    said = capsys.readouterr().err.splitlines()
    path = take.parent / "kept/crash.log"
    assert said[0] == f"check of {take.name} crashed: IndexError: index 118 is out of bounds"
    assert said[1] == f"  traceback: {path}"
    assert "in broken" in path.read_text()
