"""Rules of reading at their limits."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent / "text"))
from text_files import make, refusal

from mocap_metrology.io.c3d import second_opinion
from mocap_metrology.io.read import labels_of, read_recording

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
