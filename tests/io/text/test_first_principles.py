"""Exports of NDI First Principles, written after real ones of an Optotrak (see its module)."""

import numpy as np
import pytest
from text_files import make, read, refusal

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
        ("Units: mm", "Units: inch", "Units is 'inch'"),
        ("Beam2 z", "Beam2 y", "line 5: columns 6 and 7 are both 'Beam2 y'"),
        ("\tBeam2 z", "", "line 5: 'Beam2' has the columns x, y, but not z"),
        ("Frame\t", "Row\t", "is not an NDI First Principles export: it has no line Frame"),
    ],
)
def test_refused(tmp_path, old, new, said):
    text = BEAM.replace(old, new, 1)
    assert said in refusal(make(tmp_path, "a.tsv", text), ["Beam1"])
