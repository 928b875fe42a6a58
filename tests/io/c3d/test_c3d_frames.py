"""The true number of frames: every row of the table of what ezc3d does with long recordings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from make_c3d import build, still

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.structure import inspect
from mocap_metrology.io.read import read_recording

LONG = still(100_001)
ROTATION = {"ROTATION": {"USED": 0, "DATA_START": 9, "RATE": 120.0}}


def count(path: Path) -> tuple[int, str]:
    structure = inspect(path)
    return structure.n_frames, structure.frame_count_source


@pytest.mark.parametrize("n", [3000, 65534, 65535, 65536])
@pytest.mark.parametrize("pad", [True, False])
def test_declared_up_to_the_limit(tmp_path, n, pad):
    path = build(tmp_path / "a.c3d", LONG[:n], frames=min(n, 65535), pad=pad)
    # 65536 says 65535: the 65536th frame is there, so the count is at its limit, not true.
    assert count(path) == (n, "POINT:FRAMES" if n < 65536 else "file size")


def test_the_limit_of_a_count_from_the_file_size_is_reported(tmp_path):
    assert inspect(build(tmp_path / "a.c3d", LONG, frames=65535)).notes == (
        "the declared frame count is at its 16-bit limit: frames are counted by the file size, so "
        "a cut-off end would not be detected",
    )


def test_trial_that_does_not_fit_is_set_aside(tmp_path):
    path = build(tmp_path / "a.c3d", LONG[:3000], trial=(1, 9000))
    structure = inspect(path)
    assert (structure.n_frames, structure.frame_count_source) == (3000, "POINT:FRAMES")
    assert structure.notes == ("3000 frames; the file also declares 9000 by TRIAL",)
    assert structure.trial is None and structure.first_frame == 1


@pytest.mark.parametrize("extra", [{}, ROTATION, ROTATION | {"MANUFACTURER": {"COMPANY": "Vicon"}}])
@pytest.mark.parametrize(
    ("keys", "source"),
    [
        ({"trial": (1, 100_001)}, "TRIAL"),
        ({"long_frames": 100_001}, "POINT:LONG_FRAMES"),
        ({}, "file size"),
    ],
)
def test_saturated(tmp_path, extra, keys, source):
    path = build(tmp_path / "a.c3d", LONG, frames=65535, groups=extra, **keys)
    assert count(path) == (100_001, source)
    position = read_recording([path], ["M1", "M2"], second_opinion=False).position_mm
    assert np.array_equal(position, LONG[..., :3].transpose(1, 2, 0))
    assert len(inspect(path).notes) == (source == "file size")


@pytest.mark.parametrize(
    ("keys", "source"),
    [
        ({"trial": (1, 100_001)}, "TRIAL"),
        ({"long_frames": 100_001}, "POINT:LONG_FRAMES"),
        ({}, "file size"),
    ],
)
def test_wrapped(tmp_path, keys, source):
    path = build(tmp_path / "a.c3d", LONG, frames=34465, header=(1, 34465), **keys)
    assert count(path) == (100_001, source)


def test_wrapped_in_one_place_only_is_refused(tmp_path):
    path = build(tmp_path / "a.c3d", LONG, frames=34465, header=(1, 34466))
    with pytest.raises(Refusal, match=r"^a\.c3d: frame count and file size disagree: 34465 by POI"):
        inspect(path)


def test_signed_limit(tmp_path):
    path = build(tmp_path / "a.c3d", LONG, frames=32767, header=(1, 32767))
    assert count(path) == (100_001, "file size")


def test_float_frames(tmp_path):
    path = build(tmp_path / "a.c3d", LONG, frames=100_001.0)
    assert count(path) == (100_001, "POINT:FRAMES")


def test_vicon_without_trial(tmp_path):
    path = build(tmp_path / "a.c3d", LONG[:50], groups={"MANUFACTURER": {"COMPANY": "Vicon"}})
    assert count(path) == (50, "POINT:FRAMES")


@pytest.mark.parametrize("n", [81_001, 65_536])
def test_written_by_ezc3d(tmp_path, n):
    """ezc3d's writer: ROTATION group, no TRIAL, no LONG_FRAMES; it reads 65535 frames back."""
    import ezc3d

    c = ezc3d.c3d()
    c["parameters"]["POINT"]["RATE"]["value"] = [120.0]
    c["parameters"]["POINT"]["LABELS"]["value"] = ["A", "B"]
    points = LONG[:n].transpose(2, 1, 0).astype(float)
    c["data"]["points"] = points
    c.write(str(tmp_path / "a.c3d"))
    assert count(tmp_path / "a.c3d") == (n, "file size")
    recording = read_recording([tmp_path / "a.c3d"], ["A", "B"])
    assert np.array_equal(recording.position_mm, points[:3].transpose(1, 0, 2).astype("f4"))
    assert any("mm is assumed" in note for note in recording.notes)
    assert ezc3d.c3d(str(tmp_path / "a.c3d"))["data"]["points"].shape[2] == 65535


def test_rotations_after_the_points(tmp_path):
    groups = {"ROTATION": {"USED": 1, "DATA_START": 0}}
    path = build(tmp_path / "a.c3d", LONG[:640], groups=groups)  # 40 blocks of data
    first = inspect(path).data_offset // 512 + 1
    groups["ROTATION"]["DATA_START"] = first + 40
    build(path, LONG[:640], groups=groups, tail=bytes(range(256)) * 200)
    assert count(path) == (640, "POINT:FRAMES")


def test_a_whole_block_of_padding(tmp_path):
    """ezc3d adds one where the data end on a block."""
    path = build(tmp_path / "a.c3d", LONG[:640], tail=bytes(512))
    assert count(path) == (640, "POINT:FRAMES")
    with pytest.raises(Refusal, match=r"640 by POINT:FRAMES.*holds 641 to 656 frames of 32 bytes"):
        inspect(build(path, LONG[:640], tail=bytes(513), pad=False))


class TestHighWordTimes65535:
    """Writers exist that count TRIAL's high word as 65535 frames."""

    def test_alone(self, tmp_path):
        path = build(
            tmp_path / "a.c3d", LONG, frames=65535, trial=(1, 100_001), trial_base=65535, pad=False
        )
        structure = inspect(path)  # 100,002 frames do not fit: the size decides
        assert (structure.n_frames, structure.frame_count_source) == (100_001, "TRIAL")
        assert structure.trial_base == 65535

    def test_a_cut_file_is_not_taken_for_one(self, tmp_path):
        path = build(tmp_path / "a.c3d", LONG, frames=65535, trial=(1, 100_001), pad=False)
        data = path.read_bytes()
        path.write_bytes(data[:-10])
        with pytest.raises(Refusal, match=r"cut off: .*100001 by TRIAL.*in the file: 100000"):
            inspect(path)

    def test_confirmed_by_frames(self, tmp_path):
        path = build(tmp_path / "a.c3d", LONG[:60_000], trial=(60_001, 120_000), trial_base=65535)
        structure = inspect(path)
        assert structure.n_frames == 60_000 and structure.trial_base == 65535


@pytest.mark.parametrize("keys", [{}, {"trial": (1, 500)}, {"long_frames": 500}])
@pytest.mark.parametrize("cut", [1, 32, 33, 512, 8000, 15_999])
def test_cut_off(tmp_path, keys, cut):
    path = build(tmp_path / "a.c3d", LONG[:500], pad=False, **keys)
    path.write_bytes(path.read_bytes()[:-cut])
    held = (16_000 - cut) // 32
    with pytest.raises(Refusal, match=rf"^a\.c3d: cut off: .*500 by .*in the file: {held}$"):
        inspect(path)


def test_cut_at_the_limit_of_a_longer_count(tmp_path):
    """LONG_FRAMES says 100001; the 65535 frames left do not make POINT:FRAMES = 65535 true."""
    path = build(tmp_path / "a.c3d", LONG, frames=65535, long_frames=100_001, pad=False)
    path.write_bytes(path.read_bytes()[: -(100_001 - 65535) * 32])
    with pytest.raises(Refusal, match="cut off"):
        inspect(path)


def test_counts_that_disagree(tmp_path):
    for wrong in (495, 505):  # both fit; frame 500 is measured and what follows is padding
        structure = inspect(build(tmp_path / "a.c3d", LONG[:500], frames=wrong, header=(1, 500)))
        assert (structure.n_frames, structure.frame_count_source) == (500, "header")
        assert len(structure.notes) == 1 and str(wrong) in structure.notes[0]
    junk = bytes(range(1, 193))  # no telling what follows the data: POINT:FRAMES goes first
    path = build(tmp_path / "a.c3d", LONG[:500], frames=499, tail=junk)
    assert count(path) == (499, "POINT:FRAMES")
    path = build(tmp_path / "a.c3d", LONG[:500], frames=512, tail=junk + junk[:192])
    with pytest.raises(
        Refusal, match=r"frame counts disagree .*: 512 by POINT:FRAMES, 500 by head"
    ):
        inspect(path)  # junk fills the block up to a 512th frame
    path = build(tmp_path / "a.c3d", LONG[:500], frames=501, tail=junk)
    with pytest.raises(Refusal, match=r"frame counts disagree"):
        inspect(path)
    path = build(tmp_path / "a.c3d", LONG[:500], frames=450, header=(1, 440), long_frames=700)
    with pytest.raises(Refusal, match="700 by POINT:LONG_FRAMES, 450 by POINT:FRAMES, 440 by head"):
        inspect(path)
    with pytest.raises(Refusal, match="no frame count is declared"):
        inspect(build(tmp_path / "a.c3d", LONG[:500], frames=0, header=(1, 0)))


class TestAnalog:
    """Analog samples per frame: header and ANALOG group may differ, the size decides."""

    def data(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        return still(n), np.random.default_rng(2).normal(0, 1, (n, 6)).astype("f4")

    def patched(self, tmp_path: Path, n: int, word: int, value: int) -> Path:
        points, analog = self.data(n)
        path = build(tmp_path / "a.c3d", points, analog=analog)
        raw = bytearray(path.read_bytes())
        raw[2 * word : 2 * word + 2] = value.to_bytes(2, "little")
        path.write_bytes(bytes(raw))
        return path

    def test_interleaved(self, tmp_path):
        points, analog = self.data(300)
        path = build(tmp_path / "a.c3d", points, analog=analog)
        recording = read_recording([path], ["M2", "M1"])
        assert np.array_equal(recording.position_mm, points[:, ::-1, :3].transpose(1, 2, 0))
        assert recording.segments[0].second_opinion == "agrees"

    def test_header_wrong(self, tmp_path):
        structure = inspect(self.patched(tmp_path, 300, 2, 1))
        assert structure.n_frames == 300 and structure.frame_bytes == (8 + 6) * 4
        assert "analog samples per frame differ from the header" in structure.notes[0]

    def test_undecidable(self, tmp_path):
        with pytest.raises(Refusal, match="frames of 60 or 56 bytes both fit the file size"):
            inspect(self.patched(tmp_path, 20, 2, 7))
