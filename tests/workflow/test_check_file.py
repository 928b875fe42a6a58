"""`make check FILE=x.c3d`: one file without a sheet, from choice of markers to the verdict."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from lib import one_file
from running import environment

from mocap_metrology.c3d import write_c3d

ROOT = Path(__file__).resolve().parents[2]
RATE, SECONDS, SIGMA = 50.0, 70, 0.02


def check(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, str(ROOT / "workflow/check_file.py"), *arguments]
    how = {"env": environment(), "capture_output": True, "text": True, "timeout": 240}
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
        ("\u00e4\u00f6.c3d", "recording"),
    ],
)
def test_names_that_sheets_take(file: str, name: str) -> None:
    assert one_file.name_of(file) == name


def test_long_lists_of_labels_are_cut() -> None:
    assert one_file.listed(["A", " ", "B"]) == "A, B"
    assert one_file.listed([f"M{k}" for k in range(70)]).endswith("M59 and 10 more")
