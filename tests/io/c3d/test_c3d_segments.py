"""Several files of one take: order, gaps, and what cannot belong together."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from make_c3d import build, still

from mocap_metrology.common.errors import Refusal, UnknownUnit
from mocap_metrology.io.read import read_recording

TAKE = still(2000, 1)
WHOLE = TAKE[:, 0, :3].T.copy()


def wrapped(first, last):
    return first % 65536, last % 65536


def split(folder, ranges, header=lambda first, last: (1, last - first + 1), start=1, **keys):
    """Files of frames `first` to `last`, of which frame `start` is the first of the take."""
    paths = []
    for i, (first, last) in enumerate(ranges, start=1):
        paths.append(folder / f"part{i}.c3d")
        own = {key: value(first, last) if callable(value) else value for key, value in keys.items()}
        part = TAKE[first - start : last - start + 1]
        build(paths[-1], part, header=header(first, last), **own)
    return paths


def read(paths, **keys):
    return read_recording(paths, ["M1"], **{"second_opinion": False, **keys})


def ends(first, last):
    return first, last


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_segments_are_joined_by_their_numbers(tmp_path, data):
    """By TRIAL in any order, its high word counting 65536 or 65535 frames; by the header as given,
    whose words wrap; from 1 each: without gaps."""
    draw = data.draw
    start, by = draw(st.sampled_from([1, 65_400, 131_000])), draw(st.sampled_from("THS1"))
    lengths = draw(st.lists(st.integers(2, 90), min_size=2, max_size=4))
    gaps = [0, *(draw(st.integers(0, 30)) for _ in lengths[1:])]
    ranges, at = [], start
    for length, gap in zip(lengths, gaps, strict=True):
        ranges.append((at + gap, at + gap + length - 1))
        at += gap + length
    base = draw(st.sampled_from([65536, 65535])) if by == "T" else 65536
    over = any(first // base != last // base for first, last in ranges)
    assume(base == 65536 or over)  # which base it is shows where a file crosses it
    order = draw(st.permutations(range(len(ranges)))) if by == "T" else range(len(ranges))
    if by == "1":
        paths, gaps = split(tmp_path, ranges, start=start), [0] * len(gaps)
    else:
        trial = {"trial": ends, "trial_base": base} if by != "H" else {}
        paths = split(tmp_path, ranges, wrapped, start, **trial)
    if by == "S":  # TRIAL in some only
        first, last = ranges[1]
        build(paths[1], TAKE[first - start : last - start + 1], header=wrapped(first, last))
    recording = read([paths[i] for i in order])
    pieces = []
    for (first, last), gap in zip(ranges, gaps, strict=True):
        pieces += [np.full((3, gap), np.nan), WHOLE[:, first - start : last - start + 1]]
    np.testing.assert_array_equal(recording.position_mm[0], np.concatenate(pieces, axis=1))
    assert recording.n_gap_frames == sum(gaps)
    assert recording.n_invalid == ({"negative_residual": 0, "zero": 0, "not_finite": 0},)
    assert [s.path for s in recording.segments] == [path.name for path in paths]
    assert [s.gap_before for s in recording.segments] == gaps
    assert [s.n_frames for s in recording.segments] == lengths
    if by == "T" and base == 65536:
        assert [s.first_frame for s in recording.segments] == [first for first, _ in ranges]
    said = "without gaps" if by == "1" else "out of order; joined as part1.c3d, part2.c3d"
    expected = by == "1" or any(b < a for a, b in pairwise(order))
    assert any(said in note for note in recording.notes) == expected


@pytest.mark.parametrize("keys", [{"trial": ends}, {"header": wrapped}])
def test_segments_that_cannot_follow_each_other(tmp_path, keys):
    paths = split(tmp_path, ((1, 1000), (901, 2000)), **keys)
    said = "part2.c3d: segments overlap or are out of order: frames 901 to 2000, but part1.c3d has"
    with pytest.raises(Refusal, match=rf"^{said} frames 1 to 1000$"):
        read(paths)
    paths = split(tmp_path, ((1, 400), (1, 400), (401, 2000)), **keys)
    with pytest.raises(Refusal, match=r"^part2.*: frames 1 to 400, but part1.* frames 1 to 400$"):
        read(paths)
    if "header" in keys:
        paths = split(tmp_path, ((1, 100), (201, 300), (101, 200)), **keys)
        with pytest.raises(Refusal, match=r"^part3.c3d: segments overlap or are out of order"):
            read(paths)


def test_a_header_at_its_limit_states_no_gap(tmp_path):
    paths = split(tmp_path, ((65_000, 65_500), (65_501, 66_000)), wrapped, 65_000)
    assert read(paths).n_gap_frames == 0
    build(paths[1], TAKE[:500], header=(65535, 65535))
    said = r"^part2\.c3d: its first frame is at the 16-bit limit 65535 in the header and TRIAL"
    with pytest.raises(Refusal, match=said):
        read(paths)


class TestNotAlike:
    ENDS = ((1, 1000), (1001, 2000))

    def two(self, tmp_path, **second):
        paths = split(tmp_path, self.ENDS, header=wrapped)
        build(paths[1], TAKE[1000:2000], header=(1001, 2000), **second)
        return paths

    @pytest.mark.parametrize(
        ("second", "said"),
        [
            ({"rate": 100.0}, "its frame rate is 100 Hz, that of part1"),
            ({"labels": ["C7"]}, "its labels are not those of part1.*: 'C7'"),
        ],
    )
    def test_rate_and_labels(self, tmp_path, second, said):
        with pytest.raises(Refusal, match=rf"^part2\.c3d: {said}"):
            read(self.two(tmp_path, **second))

    def test_no_file_and_the_same_file(self, tmp_path):
        paths = self.two(tmp_path)
        with pytest.raises(Refusal, match=r"^part1.c3d: is given twice"):
            read([paths[0], paths[1], tmp_path / "." / "part1.c3d"])
        with pytest.raises(Refusal, match="no C3D file is given"):
            read([])

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
