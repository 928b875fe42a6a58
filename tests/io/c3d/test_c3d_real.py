"""Recordings by other people's systems, against ezc3d and against what is known about them."""

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.read import read_points
from mocap_metrology.io.c3d.second_opinion import ask_ezc3d
from mocap_metrology.io.c3d.structure import inspect
from mocap_metrology.io.read import read_recording
from mocap_metrology.io.recording import Recording
from mocap_metrology.io.units import METRE

READ = (
    "btk_others/ADemo1_rewrite_c3d_pc_float.c3d", "btk_others/ADemo1_rewrite_c3d_pc_integer.c3d",
    "btk_others/FunctionalStatic.c3d", "btk_pig/PiG_Calibration3_FF.c3d",
    "c3dorg_sample01/Eb015pi.c3d", "c3dorg_sample01/Eb015pr.c3d", "c3dorg_sample01/Eb015vi.c3d",
    "c3dorg_sample01/Eb015vr.c3d", "c3dorg_sample04/sub_labels.c3d", "c3dorg_sample08/TESTAPI.c3d",
    "c3dorg_sample08/TESTBPI.c3d", "c3dorg_sample08/TESTCPI.c3d", "c3dorg_sample08/TESTDPI.c3d",
    "c3dorg_sample15/FP1.C3D", "c3dorg_sample24/MotionMonitorC3D.c3d",
    "ezc3d_testfiles/Qualisys.c3d", "kineticstoolkit/duplicate_labels.c3d",
    "kineticstoolkit/kinematics_racing_probing_acromion_R.c3d",
    "kineticstoolkit/kinematics_racing_static.c3d",
)  # fmt: skip


@pytest.fixture(scope="session")
def c3d(samples) -> Path:
    return samples / "c3d"


def all_markers(path: Path) -> list[str]:
    """Every marker of a file, numbered where labels occur twice."""
    labels = inspect(path).labels
    counts = [labels[: i + 1].count(label) for i, label in enumerate(labels)]
    return [
        f"{label}#{k}" if labels.count(label) > 1 else label
        for label, k in zip(labels, counts, strict=True)
    ]


@cache
def read_all(path: Path) -> Recording:
    """All markers that are seen in at least one frame."""
    structure = inspect(path)
    every = range(structure.n_points)
    out = np.empty((structure.n_points, 3, structure.n_frames))
    counts, _ = read_points(structure, every, out)
    seen = [sum(n.values()) < structure.n_frames for n in counts]
    markers = [m for m, is_seen in zip(all_markers(path), seen, strict=True) if is_seen]
    return read_recording([path], markers, second_opinion=False)


@pytest.mark.parametrize("name", READ)
def test_same_as_ezc3d(c3d, name):
    import ezc3d

    path = c3d / name
    theirs = ezc3d.c3d(str(path))
    ours = read_all(path)
    structure = inspect(path)
    points = theirs["data"]["points"]
    assert points.shape[1:] == (structure.n_points, structure.n_frames)
    assert theirs["header"]["points"]["frame_rate"] == pytest.approx(ours.frame_rate_hz, rel=1e-6)
    labels = theirs["parameters"]["POINT"]["LABELS"]["value"][: structure.n_points]
    given = [label or f"point_{i}" for i, label in enumerate(labels, start=1)]
    assert tuple(given) == structure.labels[: len(given)]
    names = all_markers(path)
    chosen = [names.index(label) for label in ours.labels]
    expected = points[:3, chosen].transpose(1, 0, 2) * structure.unit.mm
    expected = np.where((expected == 0).all(axis=1, keepdims=True), np.nan, expected)
    np.testing.assert_allclose(ours.position_mm, expected, rtol=3e-7, atol=0)
    negative = (theirs["data"]["meta_points"]["residuals"][0, chosen] < 0).sum(axis=1)
    assert [n["negative_residual"] for n in ours.n_invalid] == negative.tolist()


@pytest.mark.parametrize("name", (READ[1], READ[2], READ[4], READ[7], READ[8], *READ[-5:-1]))
def test_second_opinion_agrees(c3d, name):
    """The unit is given, as the last points of one file are powers, which are small numbers."""
    recording = read_recording([c3d / name], all_markers(c3d / name)[-3:-1], unit="mm")
    assert recording.segments[0].second_opinion == "agrees"


def test_unit_once_per_point(c3d, tmp_path):
    """The sample is cut off: 29 of 1149 frames, which ezc3d returns without a word."""
    path = c3d / "ezc3d_testfiles/Optotrak.c3d"
    with pytest.raises(Refusal, match=r"^Optotrak\.c3d: cut off: .*1149 by POINT.*file: 29$"):
        inspect(path)
    taken = read_recording([path], ["Marker_1"], accept_truncated=True)
    assert taken.position_mm.shape == (1, 3, 29)
    assert [f.n_frames for f in taken.segments] == [29] and len(taken.notes) == 1
    raw = bytearray(path.read_bytes())
    raw[8:10] = (29).to_bytes(2, "little")
    at = raw.index(b"FRAMES") + 6 + 4
    assert int.from_bytes(raw[at : at + 2], "little") == 1149
    raw[at : at + 2] = (29).to_bytes(2, "little")
    (tmp_path / "a.c3d").write_bytes(bytes(raw))
    recording = read_recording([tmp_path / "a.c3d"], ["Marker_1"])
    assert recording.units == "mm" and recording.position_mm.shape == (1, 3, 29)
    assert recording.segments[0].second_opinion == "agrees"


@pytest.fixture(scope="module")
def read(c3d):
    path = c3d / "btk_pig/PiG_Calibration3_FF.c3d"
    return inspect(path), read_recording([path], ["LASI", "RASI"]).position_mm


class TestSecondOpinion:
    """A reading that differs from ezc3d's is refused; no answer from it is a remark."""

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"frame_rate_hz": 120.0}, "100 Hz instead of 120 Hz"),
            ({"unit": METRE}, "unit 'mm' instead of 'm'"),
            ({"n_frames": 94}, "95 frames instead of 94"),
            ({"given_labels": ("LASI", "ROSI")}, "label 'RASI' instead of 'ROSI'"),
            ({"n_points": 65}, "66 points instead of 65"),
            ({"frame_rate_hz": 100.11}, "100 Hz instead of 100.11 Hz"),
        ],
    )
    def test_structure_differs(self, read, change, message):
        structure, position = read
        changed = replace(structure, **change)
        with pytest.raises(Refusal, match=f"^PiG.*: ezc3d reads it differently: {message}"):
            ask_ezc3d(changed, [0, 1], position[:, :, : changed.n_frames])

    def test_position_differs(self, read):
        structure, position = read
        moved = position.copy()
        moved[1, 2, 40] += 0.001
        with pytest.raises(Refusal, match="point 2, frame 41: "):
            ask_ezc3d(structure, [0, 1], moved)
        moved[1, :, 40] = np.nan
        with pytest.raises(Refusal, match="point 2 is valid in frame 41"):
            ask_ezc3d(structure, [0, 1], moved)

    def test_limits(self, read, c3d, tmp_path):
        structure, position = read
        near = replace(structure, frame_rate_hz=100.09)
        for size in (1 - 4e-7, 1 + 4e-7):
            assert ask_ezc3d(near, [0, 1], position.astype(float) * size) == ("agrees", "")
        with pytest.raises(Refusal, match="point 1, frame 1: "):
            ask_ezc3d(structure, [0, 1], position.astype(float) * (1 + 6e-7))
        opinion, note = ask_ezc3d(structure, [0, 1], position, time_limit_s=0.01)
        assert opinion == "none" and "took longer than 0.01 s" in note
        opinion, note = ask_ezc3d(structure, [0, 1], position, memory_limit=1 << 20)
        assert opinion == "none" and "no second opinion: " in note
        gone = shutil.copy(c3d / "btk_pig/PiG_Calibration3_FF.c3d", tmp_path / "gone.c3d")
        missing = replace(inspect(gone), path=tmp_path / "missing.c3d")
        opinion, note = ask_ezc3d(missing, [0, 1], position)
        assert opinion == "none" and "ezc3d does not read it" in note

    def test_not_asked(self, c3d):
        path = c3d / "c3dorg_sample01/Eb015sr.c3d"
        segment = read_recording([path], ["RFT1"]).segments[0]
        assert segment.second_opinion == "not asked (ezc3d does not read MIPS files)"
        segment = read_recording([path], ["RFT1"], second_opinion=False).segments[0]
        assert segment.second_opinion == "not asked (switched off)"
