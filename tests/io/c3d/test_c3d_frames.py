"""The true number of frames: every row of the table of what ezc3d does with long recordings."""

from pathlib import Path

import numpy as np
import pytest
from make_c3d import build, still

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.structure import inspect
from mocap_metrology.io.read import read_recording

LONG = still(100_001)
ROTATION = {"ROTATION": {"USED": 0, "DATA_START": 9, "RATE": 120.0}}
VICON = {"MANUFACTURER": {"COMPANY": "Vicon"}}
TRIAL, FRAMES, SIZE = "TRIAL", "POINT:FRAMES", "file size"
JUNK = bytes(range(1, 193))  # no telling where the data end
WRAPPED = {"frames": 34465, "header": (1, 34465)}
ONE_VALUE = {"ACTUAL_START_FIELD": [1.0], "ACTUAL_END_FIELD": [100_001.0]}  # and not two words
AT_LIMIT = (
    "the declared frame count is at its 16-bit limit: frames are counted by the file size, so a"
    " cut-off end would not be detected"
)
HAS_WRAPPED = "the declared frame count has wrapped at 65536: it is corrected by the file size"


def count(path: Path) -> tuple[int, str]:
    structure = inspect(path)
    return structure.n_frames, structure.frame_count_source


COUNTS = [  # frames in the file, what it declares, where its count is from, remark
    (3000, {}, FRAMES, ""),
    (3000, {"pad": False}, FRAMES, ""),
    (65534, {}, FRAMES, ""),
    (65535, {}, FRAMES, ""),
    (65535, {"pad": False}, FRAMES, ""),
    (65536, {"frames": 65535}, SIZE, AT_LIMIT),  # the 65536th frame is there
    (65536, {"frames": 65535, "pad": False}, SIZE, AT_LIMIT),
    (65536, {"frames": 65535, "trial": (1, 65536)}, TRIAL, ""),
    (100_001, {"frames": 65535}, SIZE, AT_LIMIT),
    (100_001, {"frames": 0, "header": (1, 65535)}, SIZE, AT_LIMIT),
    (100_001, {"frames": 65535, "groups": ROTATION}, SIZE, AT_LIMIT),
    (100_001, {"frames": 65535, "groups": ROTATION | VICON}, SIZE, AT_LIMIT),
    (100_001, {"frames": 32767, "header": (1, 32767)}, SIZE, AT_LIMIT),
    (100_001, {"frames": 65535, "trial": (1, 100_001), "groups": ROTATION}, TRIAL, ""),
    (100_001, {"frames": 65535, "long_frames": 100_001}, "POINT:LONG_FRAMES", ""),
    (100_001, WRAPPED, SIZE, HAS_WRAPPED),
    (100_001, WRAPPED | {"trial": (1, 100_001)}, TRIAL, ""),
    (100_001, WRAPPED | {"groups": {"TRIAL": ONE_VALUE}}, TRIAL, ""),
    (100_001, WRAPPED | {"long_frames": 100_001}, "POINT:LONG_FRAMES", ""),
    (100_001, {"frames": 100_001.0}, FRAMES, ""),
    (50, {"groups": VICON}, FRAMES, ""),
    (640, {"tail": bytes(512)}, FRAMES, ""),  # ezc3d adds a block where the data end on one
    (500, {"tail": bytes(5000)}, FRAMES, "5504 bytes of zeros follow the last frame"),
    (100_001, {"frames": 65535, "trial": (1, 100_001), "tail": bytes(5000)}, TRIAL,
     "5088 bytes of zeros follow the last frame"),
    (100_001, {"frames": 65535, "tail": bytes(5000)}, SIZE, AT_LIMIT),
    (3000, {"trial": (1, 9000)}, FRAMES, "3000 frames; the file also declares 9000 by TRIAL"),
    (500, {"frames": 495, "header": (1, 500)}, "header",
     "500 frames; the file also declares 495 by POINT:FRAMES"),
    (500, {"frames": 505, "header": (1, 500)}, "header",
     "500 frames; the file also declares 505 by POINT:FRAMES"),
]  # fmt: skip


@pytest.mark.parametrize(("n", "keys", "source", "note"), COUNTS)
def test_frames_are_as_many_as_were_written(tmp_path, n, keys, source, note):
    path = build(tmp_path / "a.c3d", LONG[:n], **keys)
    structure = inspect(path)
    assert (structure.n_frames, structure.frame_count_source) == (n, source)
    assert structure.notes == ((note,) if note else ())
    assert (structure.trial is not None) == (source == TRIAL)
    position = read_recording([path], ["M1", "M2"], second_opinion=False).position_mm
    assert np.array_equal(position, LONG[:n, :, :3].transpose(1, 2, 0))


REFUSED = [
    (100_001, {"frames": 34465, "header": (1, 34466)},
     "frame count and file size disagree: 34465 by POINT:FRAMES, 34466 by header, but the data"
     " section holds "),
    (640, {"tail": bytes(513), "pad": False},
     "frame count and file size disagree: 640 by POINT:FRAMES, 640 by header, but the data"
     " section holds 641 to 656 frames of 32 bytes"),
    (500, {"tail": bytes(5000), "header": (1, 400)},
     "frame count and file size disagree: 500 by POINT:FRAMES, 400 by header, but the data"),
    (500, {"tail": bytes(5000) + JUNK},
     "frame count and file size disagree: 500 by POINT:FRAMES, 500 by header, but the data"),
    (500, {"frames": 512, "tail": JUNK + JUNK},
     "frame counts disagree and the data do not decide: 512 by POINT:FRAMES, 500 by header, and"
     " the data section holds 496 to 512 frames of 32 bytes"),
    (500, {"frames": 501, "tail": JUNK}, "frame counts disagree and the data do not decide: 501"),
    (500, {"frames": 450, "header": (1, 440), "long_frames": 700},
     "cut off: frames declared: 700 by POINT:LONG_FRAMES, 450 by POINT:FRAMES, 440 by header;"
     " frames in the file: 500"),
    (500, {"frames": 0, "header": (1, 0)}, "no frame count is declared (POINT:FRAMES, header)"),
]  # fmt: skip


@pytest.mark.parametrize(("n", "keys", "said"), REFUSED)
def test_counts_that_leave_a_doubt(tmp_path, n, keys, said):
    with pytest.raises(Refusal) as refused:
        inspect(build(tmp_path / "a.c3d", LONG[:n], **keys))
    assert str(refused.value).startswith(f"a.c3d: {said}")


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

    def test_header_wrong(self, tmp_path):
        structure = inspect(self.patched(tmp_path, 300, 2, 1))
        assert structure.n_frames == 300 and structure.frame_bytes == (8 + 6) * 4
        assert "analog samples per frame differ from the header" in structure.notes[0]

    def test_undecidable(self, tmp_path):
        with pytest.raises(Refusal, match="frames of 60 or 56 bytes both fit the file size"):
            inspect(self.patched(tmp_path, 20, 2, 7))
