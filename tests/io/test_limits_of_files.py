"""Rules of reading at their limits."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import asdict
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent / "text"))
from text_files import make, refusal

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d import second_opinion
from mocap_metrology.io.c3d.read import read_c3d
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.read import labels_of, read_recording
from mocap_metrology.io.text import read

RATE = 100.0


def trc(late_frames: float) -> str:
    """One marker at rest; frame numbers beside the times, of which one is late."""
    n = 50
    times = np.arange(n) / RATE
    times[20] += late_frames / RATE
    head = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
        "OrigNumFrames",
        f"{RATE:g}\t{RATE:g}\t{n}\t1\tmm\t{RATE:g}\t1\t{n}",
        "Frame#\tTime\tA\t\t",
        "\t\tX1\tY1\tZ1",
        "",
    ]
    rows = [f"{k + 1}	{t:.6f}	511.5	602.25	703.125" for k, t in enumerate(times)]
    return "\n".join([*head, *rows, ""])


@pytest.mark.parametrize("late_frames", [0.0, 0.3, 0.45])
def test_a_time_less_than_half_a_frame_off_its_number_is_that_frame(
    tmp_path: Path, late_frames: float
) -> None:
    path = make(tmp_path, "a.trc", trc(late_frames))
    take = read_recording([path], labels_of(path))
    assert take.position_mm.shape == (1, 3, 50)


def test_a_time_more_than_half_a_frame_off_its_number_is_refused(tmp_path: Path) -> None:
    assert "time goes from 0.19" in refusal(make(tmp_path, "a.trc", trc(0.6)), ["A"])


def test_the_answer_of_ezc3d_is_the_last_line_it_prints(monkeypatch) -> None:
    """What libraries print before it is theirs."""
    answer = {"opinion": "differs", "reason": "frames"}
    said = "\n".join(["one", "two", "three", json.dumps(answer)]) + "\n"
    done = subprocess.CompletedProcess([], 0, said, "")
    monkeypatch.setattr(second_opinion.subprocess, "run", lambda *_, **__: done)
    request = second_opinion.Request("a", [0], ["A"], 1, 1, 16, 100.0, "mm", 1.0, "b", 1, 1.0)
    assert second_opinion._run(request) == second_opinion.Answer(**answer)


def test_a_cut_off_file_is_used_only_where_that_is_asked(tmp_path: Path) -> None:
    path = tmp_path / "a.c3d"
    write_c3d(path, ["A"], RATE, [np.random.default_rng(1).normal(500, 0.1, (200, 1, 3))], 200)
    path.write_bytes(path.read_bytes()[:-1000])
    with pytest.raises(Refusal, match="cut off"):
        read_c3d([path], ["A"], second_opinion=False)
    taken = read_c3d([path], ["A"], second_opinion=False, accept_truncated=True)
    assert 0 < taken.position_mm.shape[2] < 200


def test_numbers_of_frames_are_whole_as_far_as_a_double_counts() -> None:
    layout, last = SimpleNamespace(name="a.csv", time_column=None), 2.0**53
    assert read._by_number(layout, np.array([last - 2, last - 1, last]), [])[1] == last - 2


def test_a_decimal_comma_among_decimal_points_is_named_with_its_place(tmp_path: Path) -> None:
    text = trc(0.0).replace("48\t0.470000\t511.5", "48\t0.470000\t511,5")
    assert "column 3: '511,5' is not a number" in refusal(make(tmp_path, "a.trc", text), ["A"])


def test_a_long_answer_of_ezc3d_is_cut(monkeypatch, capsys) -> None:
    def fails(request) -> None:
        raise ValueError("x" * 1000)

    request = second_opinion.Request("a", [0], ["A"], 1, 1, 16, 100.0, "mm", 1.0, "b", 1, 1.0)
    monkeypatch.setattr(sys, "stdin", StringIO(json.dumps(asdict(request))))
    monkeypatch.setattr(second_opinion, "_limit", lambda *_: None)
    monkeypatch.setattr(second_opinion, "_differences", fails)
    second_opinion.main()
    answer = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert answer["reason"] == f"ezc3d does not read it (ValueError: {'x' * 188})"
