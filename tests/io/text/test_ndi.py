"""Files of NDI: N3D as public readers have it, exports of First Principles as real ones are."""

import numpy as np
import pytest
from text_files import make, n3d, read, refusal

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.read import bodies_of, labels_of, read_recording

MISSING = np.frombuffer(bytes([0xEE] * 4), "<f4")[0]  # as one of the readers has it
TAKE = np.random.default_rng(3).normal([300, -500, -2500], 0.05, (50, 4, 3)).astype("<f4")


def write(folder, content: bytes, name="a.n3d"):
    (folder / name).write_bytes(content)
    return folder / name


def test_positions_gaps_rate_and_labels(tmp_path):
    take = TAKE.copy()
    take[4:7, 1] = MISSING
    take[9, 2] = 0
    path = write(tmp_path, n3d(take, 100))
    assert pytest.approx(-3.697314e28) == MISSING
    assert labels_of(path) == ("Marker_1", "Marker_2", "Marker_3", "Marker_4")
    assert bodies_of(path) == ()
    recording = read_recording([path], ["Marker_2", "Marker_3"])
    take[4:7, 1] = take[9, 2] = np.nan
    assert np.array_equal(recording.position_mm, take[:, 1:3].transpose(1, 2, 0), equal_nan=True)
    assert recording.n_invalid[0] == {"missing": 3, "zero": 0, "not_finite": 0}
    assert recording.n_invalid[1]["zero"] == 1
    assert (recording.frame_rate_hz, recording.units, recording.encoding) == (100, "mm", "N3D")
    assert recording.resolution_mm == pytest.approx(2.0**-12)  # of float32 between 2048 and 4096


def test_a_file_that_is_cut_off(tmp_path):
    path = write(tmp_path, n3d(TAKE, 100)[:-60])
    with pytest.raises(Truncated, match=r"a\.n3d: cut off: 48 of the 50 frames"):
        read_recording([path], ["Marker_1"])
    assert read_recording([path], ["Marker_1"], accept_truncated=True).position_mm.shape[2] == 48


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (n3d(TAKE, 100)[:200], "cut off: 200 bytes, the header alone has 256"),
        (n3d(TAKE, 100) + b"more", "4 bytes follow the 50 frames of its header"),
        (n3d(TAKE, 100, mark=1), "is not an N3D file: its first byte is 1"),
        (n3d(TAKE, float("nan")), "50 frames, nan Hz"),
        (n3d(TAKE, 0), "50 frames, 0 Hz"),
        (n3d(TAKE, 1e6), "50 frames, 1e+06 Hz"),
        (n3d(TAKE, 100, frames=-5), "-5 frames"),
        (n3d(TAKE[:, :3], 100, numbers=4), "has 4 numbers a marker, expected 3"),
        (b"", "is empty, expected an N3D file"),
        (b"PK\x03\x04", "is not an N3D file: it looks like a ZIP archive"),
    ],
)
def test_refused(tmp_path, content, said):
    with pytest.raises(Refusal) as caught:
        read_recording([write(tmp_path, content)], ["Marker_1"])
    assert said in str(caught.value) and str(caught.value).startswith("a.n3d: ")


# The first rows of an export that a public reader is tested with (otaithleigh/optotrak)
BEAM = """Number of frames: 3
Frequency: 50
Units: mm

Frame\tBeam1 x\tBeam1 y\tBeam1 z\tBeam2 x\tBeam2 y\tBeam2 z
1\t486.618957520\t-560.735656738\t-2618.344970703\t349.383819580\t-561.470092773\t-2552.003173828\t
2\t486.617706299\t-560.736206055\t-2618.349365234\t349.381195068\t-561.467651367\t-2551.989257813\t
3\t486.620819092\t-560.732177734\t-2618.347412109\t349.382476807\t-561.469909668\t-2551.998535156\t
"""


@pytest.mark.parametrize("missing", ["-3.697314E+028", "-3.697314e28"])
def test_markers_that_were_not_seen(tmp_path, missing):
    text = BEAM
    for cell in ("349.381195068", "-561.467651367", "-2551.989257813"):
        text = text.replace(cell, missing)
    recording = read(make(tmp_path, "a.tsv", text), ["Beam1", "Beam2"])
    assert np.isnan(recording.position_mm[1, :, 1]).all()
    assert np.isfinite(recording.position_mm).sum() == 15
    assert recording.n_invalid[1]["empty"] == 1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("frames: 3", "frames: 9", "cut off: 3 of the 9 frames that Number of frames states"),
        ("frames: 3", "frames: 2", "has 3 frames, Number of frames states 2"),
        ("frames: 3", "frames: x", "Number of frames is 'x', expected a whole number"),
        ("Frequency: 50\n", "", "has no frame rate"),
        ("Units: mm", "Units: ell", "Units is 'ell'"),
        ("Beam2 z", "Beam2 y", "line 5: columns 6 and 7 are both 'Beam2 y'"),
        ("\tBeam2 z", "", "line 5: 'Beam2' has the columns x, y, but not z"),
        ("Frame\t", "Row\t", "is not an NDI First Principles export: it has no line Frame"),
        ("mm\n", "mm\n4\t1\t2\t3\t4\t5\t6\n", "line 4 has numbers above the line Frame"),
        ("mm\n", 'mm\n "4"\t1\t2\t3\t4\t5\t6\n', "line 4 has numbers above the line Frame"),
    ],
)
def test_refused_exports(tmp_path, old, new, said):
    text = BEAM.replace(old, new, 1)
    assert said in refusal(make(tmp_path, "a.tsv", text), ["Beam1"])
