"""`mocap-metrology check --bar`: from a file of a moved bar to words, numbers and a figure."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.accuracy.bar import BarEntry
from mocap_metrology.accuracy.twin import BarErrors, BarMotion, BarTwin, simulate_bar
from mocap_metrology.cli import main
from mocap_metrology.common.files import read_csv
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.present.plot.figure import caption_of
from mocap_metrology.recording.bar import FILES, read_bar
from mocap_metrology.recording.clean import Entry
from mocap_metrology.settings import Settings

RATE = 50.0


def write_pass(path: Path, seed: int, bias: float = 0.0, still: bool = False) -> Path:
    """A bar of 500 mm beside a marker that hangs loose; or at rest."""
    way = BarMotion(speed_mm_s=1e-3 if still else 400.0)
    bar = BarErrors(500.0, pass_mm=0.05, rest=0.1, frame=0.03, bias=bias, path=way)
    ends = simulate_bar(BarTwin("t", bar, seed, 30.0, RATE)).position_mm
    loose = ends[:1] + 100 * np.sin(np.arange(ends.shape[2]) / 9)
    position = np.moveaxis(np.concatenate([loose, ends]), 2, 0).astype(np.float32)
    write_c3d(path, ["Loose", "Wand-A", "Wand-B"], RATE, [position], position.shape[0])
    return path


@pytest.fixture
def passes(tmp_path: Path, monkeypatch) -> list[str]:
    monkeypatch.chdir(tmp_path)
    return [write_pass(tmp_path / f"pass {k}.c3d", k).name for k in range(3)]


def test_a_certified_bar_is_judged(passes: list[str], capsys) -> None:
    named = ["--bar", "Wand-A-Wand-B", "--length", "500", "--length-u", "0.02"]
    assert main.main(["check", passes[0], *named]) == 0
    printed = capsys.readouterr()
    assert printed.err.splitlines()[1] == "Wand-A and Wand-B: 1500 frames at 50 Hz, 30 s"
    lines = printed.out.splitlines()
    assert lines[0] == "pass-0: good" and "are wrong by at most 0.2" in lines[1]
    folder = Path("results/check/pass-0.c3d")
    assert {path.name for path in folder.iterdir()} == set(FILES)
    found = json.loads((folder / "bar.json").read_text())
    assert found["certificate"] == {"length_mm": 500.0, "u_mm": 0.02}
    assert found["size_mm"] == pytest.approx(0.04 + 2 * 0.11, rel=0.3)
    (row,) = read_csv(folder / "bar.csv", ("p95", "rms"))
    assert (row["class"], row["passes"], row["rms_lower"]) == ("bar x, way x", "1", "")
    assert found["size_mm"] == pytest.approx(row["p95"] + 0.04)
    title, caption = caption_of(folder / "bar.png")
    assert title == "pass-0: length of the bar" and "5 % of the frames" in caption


def test_another_marker_taken_for_an_end_is_told(tmp_path: Path) -> None:
    """For half a second, 100 mm aside along the bar: too long to be a spike, too short for p95."""
    bar = BarErrors(500.0, rest=0.1, frame=0.03)
    ends = simulate_bar(BarTwin("t", bar, 1, 30.0, RATE)).position_mm
    ends[1, 0, 300:325] += 100
    position = np.moveaxis(ends, 2, 0).astype(np.float32)
    write_c3d(tmp_path / "a.c3d", ["A", "B"], RATE, [position], position.shape[0])
    named = {"recording": "a", "source": "measured", "twin": None}
    entry = Entry([str(tmp_path / "a.c3d")], [])
    (said,) = read_bar(entry, BarEntry("A-B", 500.0), Settings(), named).warnings
    assert re.search(r"in 25 frames, the first at 6 s, by up to (99\.\d|100|10[0-1]) mm", said)


def test_files_are_passes_of_their_own_and_have_intervals(passes: list[str], capsys) -> None:
    """Of one name, in three folders; one that is given twice is checked once."""
    for k, name in enumerate(passes):
        Path(f"day{k}").mkdir()
        Path(name).rename(f"day{k}/wand.c3d")
    arguments = ["day0", "day1/wand.c3d", "day2/wand.c3d", "day1/../day0/wand.c3d"]
    assert main.main(["check", *arguments, "--bar", "auto", "--length", "500.5"]) == 0
    text = capsys.readouterr().out
    assert "3 passes of Wand-A-Wand-B: " in text
    assert "lengths are too short on average" in text and "Record 3 passes" not in text
    found = [json.loads(path.read_text()) for path in Path("results/check").glob("*/bar.json")]
    assert len({str(one["classes"]) for one in found}) == 3


def test_what_is_no_bar_has_no_verdict(passes, capsys) -> None:
    assert main.main(["check", passes[0], "--bar", "Wand-A"]) == 1
    words = 'bar is "Wand-A"; expected auto, or two markers of the file'
    assert words in capsys.readouterr().err
    assert not Path("results").exists()


def test_options_that_need_each_other(capsys) -> None:
    for arguments, words in (
        (["--length", "5"], "--length needs --bar"),
        (["--bar", "auto", "--length-u", "1"], "--length-u needs --length"),
        (["--bar", "auto", "--markers", "A"], "--markers is not for a moving bar"),
        (["--rate", "100", "--board", "b.csv"], "--rate is not for a dump"),
        (["--bar", "auto", "--length", "5cm"], "'5cm'; expected mm, as 500"),
    ):
        with pytest.raises(SystemExit):
            main.main(["check", "a.c3d", *arguments])
        assert words in capsys.readouterr().err
