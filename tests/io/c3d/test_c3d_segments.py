"""Several files of one take: order, gaps, and what cannot belong together."""

from __future__ import annotations

import numpy as np
import pytest
from make_c3d import build, still

from mocap_metrology.common.errors import Refusal, UnknownUnit
from mocap_metrology.io.read import read_recording

# A take of 240,000 frames, split, with a gap of 500 before the last part; one point.
RANGES = ((1, 60_000), (60_001, 120_000), (120_001, 180_000), (180_501, 240_000))
TAKE = still(240_000, 1)
WHOLE = TAKE[:, 0, :3].T.copy()
WITH_GAP = WHOLE.copy()
WITH_GAP[:, 180_000:180_500] = np.nan


def split(folder, ranges=RANGES, header=lambda first, last: (1, last - first + 1), **keys):
    paths = []
    for i, (first, last) in enumerate(ranges, start=1):
        part = TAKE[first - 1 : last]
        paths.append(folder / f"part{i}.c3d")
        build(
            paths[-1],
            part,
            header=header(first, last),
            **{
                key: value(first, last) if callable(value) else value for key, value in keys.items()
            },
        )
    return paths


def read(paths, **keys):
    return read_recording(paths, ["M1"], second_opinion=False, **keys)


def wrapped(first, last):
    return first % 65536, last % 65536


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 0, 3, 1)])
@pytest.mark.parametrize("base", [65536, 65535])
def test_by_trial(tmp_path, order, base):
    paths = split(tmp_path, trial=lambda *ends: ends, header=wrapped, trial_base=base)
    recording = read([paths[i] for i in order])
    assert np.array_equal(recording.position_mm[0], WITH_GAP, equal_nan=True)
    assert recording.n_gap_frames == 500
    assert recording.n_invalid == ({"negative_residual": 0, "zero": 0, "not_finite": 0},)
    assert [s.path for s in recording.segments] == [p.name for p in paths]
    assert [s.gap_before for s in recording.segments] == [0, 0, 0, 500]
    assert [s.n_frames for s in recording.segments] == [60_000, 60_000, 60_000, 59_500]
    assert bool(recording.notes) == (order[0] == 2)
    if recording.notes:
        assert recording.notes[0].startswith("segments were given out of order; joined as part1")
    if base == 65536:
        assert [s.first_frame for s in recording.segments] == [first for first, _ in RANGES]


def test_by_the_header(tmp_path):
    paths = split(tmp_path, header=wrapped)
    recording = read(paths)
    assert np.array_equal(recording.position_mm[0], WITH_GAP, equal_nan=True)
    with pytest.raises(Refusal, match=r"^part3\.c3d: segments overlap or are out of order: frames"):
        read([paths[i] for i in (0, 2, 1, 3)])


def test_header_at_its_limit(tmp_path):
    paths = split(tmp_path, header=lambda *ends: tuple(min(e, 65535) for e in ends))
    with pytest.raises(Refusal, match=r"^part3\.c3d: its first frame is at the 16-bit limit"):
        read(paths)
    assert read(paths[:2]).n_gap_frames == 0


def test_every_segment_from_one(tmp_path):
    recording = read(split(tmp_path))
    expected = np.concatenate([WHOLE[:, a - 1 : b] for a, b in RANGES], axis=1)
    assert np.array_equal(recording.position_mm[0], expected)
    assert recording.n_gap_frames == 0 and "without gaps" in recording.notes[0]


def test_trial_in_some_only(tmp_path):
    paths = split(tmp_path, header=wrapped, trial=lambda *ends: ends)
    build(paths[1], TAKE[60_000:120_000], header=wrapped(*RANGES[1]))
    assert np.array_equal(read(paths).position_mm[0], WITH_GAP, equal_nan=True)


def test_overlap(tmp_path):
    paths = split(tmp_path, ((1, 1000), (901, 2000)), trial=lambda *ends: ends)
    with pytest.raises(Refusal, match=r"frames 901 to 2000, but part1.c3d has frames 1 to 1000$"):
        read(paths)
    paths = split(tmp_path, ((1, 1000), (901, 2000)), header=wrapped)
    with pytest.raises(Refusal, match=r"frames 901 to 2000, but part1.c3d has frames 1 to 1000$"):
        read(paths)
    paths = split(tmp_path, ((1, 1000), (1, 1000), (1001, 2000)), trial=lambda *ends: ends)
    with pytest.raises(Refusal, match=r"frames 1 to 1000, but part1.c3d has frames 1 to 1000$"):
        read(paths)


def test_gap_beyond_belief(tmp_path):
    paths = split(tmp_path, ((1, 1000), (30_001, 31_000)), trial=lambda *ends: ends)
    with pytest.raises(Refusal, match="skip 29000 frames, more than 10 times those measured"):
        read(paths)


def test_long_segments(tmp_path):
    """Two of more than 65535 frames each, the second not starting at a multiple of anything."""
    paths = split(
        tmp_path,
        ((1, 70_000), (70_100, 240_000)),
        header=lambda first, last: (min(first, 65535), 65535),
        frames=65535,
        trial=lambda *ends: ends,
    )
    recording = read(paths[::-1])
    expected = WHOLE.copy()
    expected[:, 70_000:70_099] = np.nan
    assert np.array_equal(recording.position_mm[0], expected, equal_nan=True)


class TestNotAlike:
    ENDS = ((1, 1000), (1001, 2000))

    def two(self, tmp_path, **second):
        paths = split(tmp_path, self.ENDS, header=wrapped)
        build(paths[1], TAKE[1000:2000], header=(1001, 2000), **second)
        return paths

    def test_rate(self, tmp_path):
        with pytest.raises(Refusal, match=r"^part2.c3d: its frame rate is 100 Hz, that of part1"):
            read(self.two(tmp_path, rate=100.0))

    def test_labels(self, tmp_path):
        with pytest.raises(
            Refusal, match=r"^part2\.c3d: its labels are not those of part1.*: 'C7'"
        ):
            read(self.two(tmp_path, labels=["C7"]))

    def test_the_same_file(self, tmp_path):
        paths = self.two(tmp_path)
        with pytest.raises(Refusal, match=r"^part1.c3d: is given twice"):
            read([paths[0], paths[1], tmp_path / "." / "part1.c3d"])

    def test_unit(self, tmp_path):
        """One take has one unit: two of them are more likely a field that was lost or damaged."""
        paths = self.two(tmp_path, units="m")
        with pytest.raises(UnknownUnit, match=r"^part2\.c3d: its unit is m, that of part1\.c3d mm"):
            read(paths)
        assert read_recording(paths, ["M1"], second_opinion=False, unit="m").units == "m"
        assert read(self.two(tmp_path, units="millimeters")).units == "mm; millimeters"

    def test_encodings_are_converted(self, tmp_path):
        paths = split(tmp_path, ((1, 1000), (1001, 2000)), header=wrapped)
        steps = np.round(TAKE[1000:2000] / 0.125).astype(int)
        build(paths[1], steps, header=(1001, 2000), scale=0.125, processor="DEC")
        recording = read(paths)
        error = np.abs(recording.position_mm[0] - WHOLE[:, :2000])
        assert error[:, :1000].max() == 0
        assert error[:, 1000:].max() <= 0.0625 + 1e-6
        assert recording.position_mm.dtype == np.float64
        assert (recording.units, recording.encoding) == ("mm", "Intel float; DEC int16")
        assert (recording.resolution_mm, recording.resolution_kind) == (0.125, "int16")

    def test_nothing_given(self):
        with pytest.raises(Refusal, match="no C3D file is given"):
            read([])


def test_second_opinion_on_each(tmp_path):
    paths = split(tmp_path, ((1, 1000), (1001, 2000)), trial=lambda *ends: ends)
    recording = read_recording(paths, ["M1"])
    assert [s.second_opinion for s in recording.segments] == ["agrees", "agrees"]
