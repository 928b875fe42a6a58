"""Writing: what comes back, here and in ezc3d, and that a file is whole or absent."""

import numpy as np
import pytest

from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.read import read_recording


def frames(n: int, n_points: int = 2, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(800, 1, (n, n_points, 3)).astype(np.float32)


@pytest.mark.parametrize("n", [2, 65_534, 65_535, 65_536, 70_000])
def test_round_trip(tmp_path, n):
    """ezc3d counts the frames rightly too, because nothing follows the last one."""
    import ezc3d

    written = frames(n)
    written[n // 2, 1] = np.nan
    path = tmp_path / "twin.c3d"
    chunks = (written[i : i + 10_007] for i in range(0, n, 10_007))
    write_c3d(path, ["A", "B"], 119.88, chunks, n, description="twin" * 70)
    recording = read_recording([path], ["A", "B"])
    expected = written.transpose(1, 2, 0)
    assert np.array_equal(recording.position_mm, expected, equal_nan=True)
    assert recording.n_invalid[1]["negative_residual"] == 1
    assert recording.frame_rate_hz == 119.88 and recording.units == "mm"
    segment = recording.segments[0]
    assert segment.frame_count_source == "POINT:LONG_FRAMES" and segment.first_frame == 1
    assert segment.second_opinion.startswith("agrees" if n <= 65_534 else "not asked")
    theirs = ezc3d.c3d(str(path))
    assert np.array_equal(theirs["data"]["points"][:3].transpose(1, 0, 2), expected, equal_nan=True)
    assert theirs["parameters"]["TRIAL"]["DESCRIPTION"]["value"] == ["twin" * 63 + "twi"]  # 255
    assert theirs["parameters"]["POINT"]["LABELS"]["value"] == ["A", "B"]


@pytest.mark.parametrize(
    ("chunks", "message"),
    [
        ([frames(99)], "99 frames written, 100 announced"),
        ([frames(60), frames(60)], "more than the 100 frames announced"),
        ([frames(100, 3)], "frames of shape"),
    ],
)
def test_whole_or_absent(tmp_path, chunks, message):
    with pytest.raises(ValueError, match=message):
        write_c3d(tmp_path / "a.c3d", ["A", "B"], 120, chunks, 100)
    assert list(tmp_path.iterdir()) == []
    write_c3d(tmp_path / "a.c3d", ["A", "B"], 120, [frames(100)], 100)
    before = (tmp_path / "a.c3d").read_bytes()
    with pytest.raises(ValueError, match=message):
        write_c3d(tmp_path / "a.c3d", ["A", "B"], 120, chunks, 100)
    assert [p.name for p in tmp_path.iterdir()] == ["a.c3d"]
    assert (tmp_path / "a.c3d").read_bytes() == before


@pytest.mark.parametrize(
    "change",
    [{"labels": []}, {"labels": ["A", "A"]}, {"labels": ["A", ""]}, {"labels": ["A", "x" * 128]},
     {"labels": ["A", "Fuß"]}, {"frame_rate_hz": 0}, {"frame_rate_hz": float("nan")},
     {"n_frames": 0}, {"first_frame": 0}],
)  # fmt: skip
def test_refuses_to_start(tmp_path, change):
    keys = {"labels": ["A", "B"], "frame_rate_hz": 120, "n_frames": 10} | change
    with pytest.raises(ValueError):
        write_c3d(tmp_path / "a.c3d", chunks=[frames(10)], **keys)
    assert list(tmp_path.iterdir()) == []
