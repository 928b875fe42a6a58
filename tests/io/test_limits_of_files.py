"""Rules of reading at their limits."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parent / "text"))
from text_files import LABELS, TAKE, make, nexus, refusal, trc

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.read import orientation_of, read_recording


def take_at(tmp_path: Path, times, frames=None) -> Path:
    """A marker at rest in a TRC file of 100 Hz; `times` in s, frame numbers from 1 unless given."""
    n = len(times)
    lines = trc(("A",), 100, np.full((n, 1, 3), 511.5)).splitlines()
    for k, time in enumerate(times):
        cells = lines[k + 6].split("\t")
        number = str(k + 1 if frames is None else frames[k])
        lines[k + 6] = "\t".join([number, f"{time:.6f}", *cells[2:]])
    return make(tmp_path, "a.trc", "\n".join([*lines, ""]))


@pytest.mark.parametrize("stated", [49, 50, 54, 55, 56])
def test_the_stated_number_of_frames_is_that_of_the_rows_or_of_their_span(tmp_path, stated) -> None:
    """Of 50 rows in which five frames are missing."""
    frames = np.delete(np.arange(1, 56), slice(20, 25))
    path = take_at(tmp_path, (frames - 1) / 100, frames)
    path.write_text(path.read_text().replace("\t50\t", f"\t{stated}\t", 1))
    if stated in (50, 55):
        assert read_recording([path], ["A"]).n_gap_frames == 5
    elif stated < 50:
        assert refusal(path, ["A"]) == "a.trc: has 50 frames, NumFrames states 49"
    else:
        assert f"cut off: 50 of the {stated} frames that NumFrames" in refusal(path, ["A"])


@pytest.mark.parametrize("sign", [1, -1])
def test_a_time_less_than_half_a_frame_off_its_number_is_that_frame(tmp_path, sign) -> None:
    """But for its rounding, here of 1e-6 s, which is 1e-4 frames."""
    for late, is_read in ((0.0, True), (0.4999, True), (0.5002, False), (0.9, False)):
        times = np.arange(50) / 100
        times[20:] += sign * late / 100
        times[40:] -= sign * late / 100
        path = take_at(tmp_path, times)
        if is_read:
            assert read_recording([path], ["A"]).position_mm.shape == (1, 3, 50)
        else:
            said = f"a.trc: line 27: time goes from 0.19 to {times[20]:.10g} s, expected 1 / (100 "
            assert refusal(path, ["A"]).startswith(said)


@pytest.mark.parametrize(("percent", "is_read"), [(0.0998, True), (0.1002, False), (5, False)])
def test_rates_of_header_and_times_may_differ_by_a_tenth_of_a_per_cent(tmp_path, percent, is_read):
    for sign in (-1, 1):
        rate = 100 * (1 + sign * percent / 100)
        path = take_at(tmp_path, np.arange(2000) / rate)
        if is_read:
            assert read_recording([path], ["A"]).frame_rate_hz == 100
        else:
            said = f"by its time column {rate:.6g} Hz; they may differ by 0.1 %"
            assert refusal(path, ["A"]).endswith(said)


@pytest.mark.parametrize(("last", "is_read"), [(219, True), (220, True), (221, False)])
def test_ten_times_the_frames_there_are_may_be_missing(tmp_path, last, is_read) -> None:
    path = make(tmp_path, "n.csv", nexus(LABELS, 100, TAKE).replace("\n20,0,", f"\n{last},0,"))
    if is_read:
        assert read_recording([path], LABELS).n_gap_frames == last - 20
    else:
        assert refusal(path) == (
            "n.csv: frame numbers or times skip 201 frames, more than 10 times the 20 there are"
        )
    parts = [make(tmp_path, f"{k}.csv", nexus(LABELS, 100, TAKE, first=first))
             for k, first in ((1, 1), (2, last + 201))]  # fmt: skip
    if is_read:
        assert read_recording(parts, LABELS).n_gap_frames == last + 180
    else:
        assert refusal(parts).startswith("1.csv: the segments' frame numbers skip 401 frames, more")


def test_a_recording_has_two_frames(tmp_path) -> None:
    two = make(tmp_path, "2.csv", nexus(LABELS, 100, TAKE[:2]))
    assert read_recording([two], LABELS).position_mm.shape == (2, 3, 2)
    one = make(tmp_path, "1.csv", nexus(LABELS, 100, TAKE[:1]))
    assert refusal(one) == "1.csv: has 1 frame, expected at least 2 frames"


def poses(tmp_path: Path, rotation: np.ndarray) -> Path:
    row = np.column_stack([rotation, [1.0, 2.0, 3.0]]).ravel()
    return make(tmp_path, "p.txt", "# Freq: 100\n" + (" ".join(map(repr, row.tolist())) + "\n") * 5)


def test_a_rotation_may_be_off_by_a_thousandth(tmp_path) -> None:
    """Rows of a matrix by 1 in a thousand of R R^T, a quaternion by as much of its length."""
    turn = Rotation.from_euler("XYZ", [10, 20, 30], degrees=True)
    for size, is_read in ((1.0009, True), (0.9991, True), (1.0011, False), (0.9989, False)):
        matrix = poses(tmp_path, turn.as_matrix() * np.sqrt(size))
        values = " ".join(map(repr, (turn.as_quat() * size).tolist()))
        head = "# timestamp tx ty tz qx qy qz qw\n"
        rows = "".join(f"{k / 100} 1 2 3 {values}\n" for k in range(5))
        for path, kind in (
            (matrix, "matrix"),
            (make(tmp_path, "q.tum", head + rows), "quaternion"),
        ):
            if is_read:
                found = Rotation.from_quat(orientation_of([path], "tracker").T)
                assert (found * turn.inv()).magnitude().max() < 1e-3
            else:
                with pytest.raises(Refusal, match=f"a {kind} of no rotation, first in seen frame"):
                    orientation_of([path], "tracker")
    with pytest.raises(Refusal, match="a matrix of no rotation"):
        orientation_of([poses(tmp_path, np.diag([1.0, 1.0, -1.0]))], "tracker")


@pytest.mark.parametrize(("period_s", "is_read"), [(0.99, True), (1.0, False), (1.01, False)])
def test_times_of_one_hertz_or_less_name_their_unit(tmp_path, period_s, is_read) -> None:
    rows = "".join(f"{k * period_s:.4f},1.5,2.5,3.5\n" for k in range(9))
    path = make(tmp_path, "a.csv", "time,A_x,A_y,A_z\n" + rows)
    if is_read:
        assert read_recording([path], ["A"], unit="m").frame_rate_hz > 1
    else:
        assert f"frame rate of {1 / period_s:g} Hz: name their unit" in refusal(
            path, ["A"], unit="m"
        )
    path = make(tmp_path, "a.csv", "time_s,A_x,A_y,A_z\n" + rows)
    assert read_recording([path], ["A"], unit="m").frame_rate_hz == pytest.approx(
        1 / period_s, 1e-5
    )


def test_words_alone_and_a_line_without_an_end_are_no_table(tmp_path) -> None:
    for text, said in (
        ("# c\n" * 9, "no row of three or more numbers in its first lines; line 9 is '# c'"),
        ("#" * 2**20, "line 1 is longer than 1048576 bytes"),
    ):
        assert refusal(make(tmp_path, "a.csv", text), ["A"]).startswith(f"a.csv: {said}")
