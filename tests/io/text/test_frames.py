"""Frames that are missing, cut off, or split over files; the step that the text can tell."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from text_files import LABELS, WRITERS, make, motive, nexus, qualisys, read, still, table, trc

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.common.files import sha256
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.read import labels_of, orientation_of, read_recording

TAKE = still(200)
EXPECTED = TAKE.transpose(1, 2, 0)
WITH_HOLES = EXPECTED.copy()
WITH_HOLES[:, :, 50:60] = WITH_HOLES[:, :, 99] = np.nan
KEPT = np.flatnonzero(np.isfinite(WITH_HOLES[0, 0]))


def without(text, first_row, kept=KEPT):
    """The file without the rows of some frames."""
    lines = text.splitlines(keepends=True)
    return "".join(lines[:first_row] + [lines[first_row + i] for i in kept])


def test_frame_numbers_that_count_by_four(tmp_path):
    text = without(
        trc(LABELS, 100, TAKE).replace("100.00\t100.00\t200", "25.00\t100.00\t50"),
        6,
        range(0, 200, 4),
    )
    recording = read(make(tmp_path, "a.trc", text))
    assert np.array_equal(recording.position_mm, EXPECTED[:, :, ::4])
    assert recording.frame_rate_hz == 25 and "increase by 4" in recording.notes[0]
    text = without(nexus(LABELS, 100, TAKE), 5, range(0, 200, 4))
    with pytest.raises(Refusal, match=r"^a\.csv: every frame number is 4 more than the one before"):
        read(make(tmp_path, "a.csv", text))


def test_cut_off(tmp_path):
    lines = trc(LABELS, 100, TAKE).splitlines(keepends=True)
    path = make(tmp_path, "a.trc", "".join(lines[:156]))
    with pytest.raises(Refusal, match=r"^a\.trc: cut off: 150 of the 200 frames that NumFrames"):
        read(path)
    recording = read(path, accept_truncated=True)
    assert np.array_equal(recording.position_mm, EXPECTED[:, :, :150])
    assert recording.notes == (
        "a.trc: cut off: 150 of the 200 frames that NumFrames states; used as it is",
    )
    for name, text in (("b.trc", trc(LABELS, 100, TAKE)), ("b.csv", nexus(LABELS, 100, TAKE))):
        path = make(tmp_path, name, text.rstrip()[:-25])
        with pytest.raises(Refusal, match=r": cut off: line 20[56] ends after \d of 8 cells$"):
            read(path)
        found = read(path, accept_truncated=True)
        assert np.array_equal(found.position_mm, EXPECTED[:, :, :199])
    path = make(tmp_path, "c.csv", nexus(LABELS, 100, TAKE).rstrip())
    assert read(path).notes == ("c.csv: line 205, the last, has no line end: is anything missing?",)


@pytest.mark.parametrize("n", [20, 200])  # more than the first block that is looked at, and less
@pytest.mark.parametrize("suffix", WRITERS)
def test_a_mark_of_the_end_is_no_text(tmp_path, suffix, n):
    """Ctrl-Z, which programs of the time of DOS write."""
    text = WRITERS[suffix](LABELS, 100, TAKE[:n])
    for end in ("\x1a", "\x1a\x1a"):
        path = make(tmp_path, f"a{suffix}", text + end)
        assert np.allclose(read(path).position_mm, EXPECTED[:, :, :n], atol=5e-4)
        with pytest.raises(Truncated, match=r"cut off: line \d+ ends after"):
            read(make(tmp_path, f"a{suffix}", text.rstrip()[:-25] + end))


@pytest.mark.parametrize("end", ["\t\t", "\t" * 5, "\t\t\r\n", "\t" * 5 + "\r\n\t\r\n"])
def test_tabs_alone_behind_the_declared_frames_are_no_frame(tmp_path, end):
    """Before them they are a gap; without frame numbers and times only the count tells."""
    text = qualisys(LABELS, 100, TAKE, leading=0, gap="")
    assert np.allclose(read(make(tmp_path, "a.tsv", text + end)).position_mm, EXPECTED, atol=5e-4)
    take = TAKE.copy()
    take[-1] = np.nan
    found = read(make(tmp_path, "a.tsv", qualisys(LABELS, 100, take, leading=0, gap="") + end))
    assert found.position_mm.shape == EXPECTED.shape and np.isnan(found.position_mm[..., -1]).all()
    lost = text.rstrip().rpartition("\n")[0] + "\n"
    with pytest.raises(Refusal, match="cut off"):
        read(make(tmp_path, "a.tsv", lost + "\t\t"))


def test_the_last_number_of_columns_that_drop_zeros(tmp_path):
    """As short as others above it: said, not refused. In an exponent: refused."""
    lines = nexus(LABELS, 100, TAKE).splitlines()
    lines[50] = lines[50].rpartition(",")[0] + ",600"
    for last in ("600.5", "600"):
        text = "\n".join([*lines[:-1], lines[-1].rpartition(",")[0] + "," + last])
        assert len(read(make(tmp_path, "a.csv", text)).notes) == 1
    rows = [
        f"{i},0," + ",".join(f"{value:.9e}" for value in row.ravel())
        for i, row in enumerate(TAKE, start=1)
    ]
    text = "\n".join(lines[:5] + rows)
    read(make(tmp_path, "a.csv", text))
    for lost in (1, 2, 3, 4, 5):
        with pytest.raises(Truncated, match=r"line 205 .*'6"):
            read(make(tmp_path, "a.csv", text[:-lost]))


def test_segments(tmp_path):
    first = make(tmp_path, "1.trc", trc(LABELS, 100, TAKE[:80]))
    second = make(tmp_path, "2.trc", trc(LABELS, 100, TAKE[100:], first=101))
    expected = EXPECTED.copy()
    expected[:, :, 80:100] = np.nan
    for order in ([first, second], [second, first]):
        recording = read(order)
        assert np.array_equal(recording.position_mm, expected, equal_nan=True)
        assert [s.gap_before for s in recording.segments] == [0, 20]
        assert [s.sha256 for s in recording.segments] == [sha256(first), sha256(second)]
        assert recording.n_gap_frames == 20
    third = make(tmp_path, "3.trc", trc(LABELS, 100, TAKE[100:]))
    recording = read([first, third])
    assert recording.position_mm.shape[2] == 180 and "without gaps" in recording.notes[0]
    for content, why in (
        (trc(LABELS, 100, TAKE[100:], first=70), "70 to 169.* 1 to 80"),
        (trc(LABELS, 90, TAKE[100:], first=101), "90 Hz.* 100 Hz"),
        (trc(("A", "C"), 100, TAKE[100:], first=101), "'B'"),
    ):
        with pytest.raises(Refusal, match=rf"^4\.trc: .*{why}"):
            read([first, make(tmp_path, "4.trc", content)])
    write_c3d(tmp_path / "5.c3d", LABELS, 100, [TAKE], len(TAKE))
    with pytest.raises(Refusal, match=r"one take differ in format: \.trc, \.c3d$"):
        read([first, tmp_path / "5.c3d"])


def test_poses(samples):
    """Against numpy, and the standard deviations that its README states for point 10."""
    path = samples / "static_vive_pose/20201001_Exp1_measurementPoint10.txt"
    matrix = np.loadtxt(path).reshape(-1, 3, 4)
    recording = read_recording([path], labels_of(path))
    assert np.array_equal(recording.position_mm[0], matrix[:, :, 3].T * 1000)
    assert np.round(recording.position_mm[0].std(axis=1), 2).tolist() == [0.21, 0.19, 0.37]
    assert recording.frame_rate_hz == 250 and recording.resolution_kind == "float32"
    orientation = orientation_of([path], "tracker")
    rotation = Rotation.from_quat(orientation.T).as_matrix()
    assert np.abs(rotation - matrix[:, :, :3]).max() < 1e-6
    assert np.abs(np.diff(orientation, axis=1)).max() < 0.01


def test_quaternions_do_not_jump(tmp_path):
    """Once round the z axis: after 360 degrees the quaternion is -1, not back at 1."""
    angles = np.radians(np.arange(0, 361, 5))
    rows = [
        f"{np.cos(a)} {-np.sin(a)} 0.0 1.0 {np.sin(a)} {np.cos(a)} 0.0 2.0 0.0 0.0 1.0 3.0\n"
        for a in angles
    ]
    path = make(tmp_path, "a.txt", "# Freq: 100\n" + "".join(rows))
    found = orientation_of([path], "tracker")
    half = angles / 2
    expected = [0 * half, 0 * half, np.sin(half), np.cos(half)]
    sign = np.sign(found[3, 0])
    assert np.allclose(sign * found, expected, atol=1e-12)


@pytest.mark.parametrize("writer", [trc, motive, nexus, qualisys])
def test_cut_off_within_the_last_number(tmp_path, writer):
    """Of five decimals some or all are lost, and the point: no wrong number is taken."""
    name = "a.csv" if writer in (motive, nexus) else f"a.{'trc' if writer is trc else 'tsv'}"
    whole = writer(LABELS, 100, TAKE, digits=5).rstrip()
    for lost in range(1, 8):
        path = make(tmp_path, name, whole[:-lost])
        said = r"line \d+ ends in '\d+\.?\d*', every earlier number has more"
        with pytest.raises(Truncated, match=said):
            read(path)
        recording = read(path, accept_truncated=True)
        assert np.allclose(recording.position_mm, EXPECTED[:, :, :199], rtol=0, atol=1e-9)
        assert [note for note in recording.notes if "; used as it is" in note]


def test_resolution_of_six_significant_digits_and_of_float32(tmp_path):
    """Nexus drops zeros: 1734.4 of 1734.40; a coordinate that never changes proves nothing."""
    positions = np.round(np.random.default_rng(2).normal(1734, 0.1, (500, 1, 3)), 2)
    positions[:, 0, 2] = 12
    lines = nexus(("A",), 100, positions).splitlines()
    lines[5:] = [
        ",".join([f"{i + 1}", "0", *(f"{v:g}" for v in row[0])]) for i, row in enumerate(positions)
    ]
    recording = read(make(tmp_path, "a.csv", "\n".join(lines) + "\n"), ["A"])
    assert recording.resolution_mm == pytest.approx(0.01)
    single = np.random.default_rng(3).normal(-1.4, 1e-4, (500, 2, 3)).astype(np.float32)
    recording = read(make(tmp_path, "a.trc", trc(LABELS, 100, single, "m", digits=24)))
    assert recording.resolution_kind == "float32"
    assert recording.resolution_mm == pytest.approx(1000 * 2.0**-23)  # spacing from 1 to 2


@pytest.mark.parametrize(("digits", "frames"), [(2, 39), (5, 40)])
def test_times_that_are_too_coarse_to_show_a_missing_frame(tmp_path, digits, frames):
    lines = table(LABELS, 100, still(40), time_digits=digits).splitlines(keepends=True)
    recording = read(make(tmp_path, "a.csv", "".join(lines[:20] + lines[21:])))
    assert recording.position_mm.shape[2] == frames
    said = [note for note in recording.notes if "frame would not be noticed" in note]
    assert len(said) == (digits == 2), recording.notes
