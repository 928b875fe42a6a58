"""Real C3D files, read by ezc3d, written as text here, must come back the same."""

import numpy as np
import pytest
from text_files import WRITERS, make

from mocap_metrology.io.read import labels_of, read_recording

FILES = (
    "btk_others/FunctionalStatic.c3d",  # with gaps
    "ezc3d_testfiles/Qualisys.c3d",
    "kineticstoolkit/kinematics_racing_static.c3d",
)
DIGITS = 4


def by_ezc3d(path):
    """Labels, rate, positions (n, k, 3) in mm with NaN at gaps, of points that are ever seen."""
    ezc3d = pytest.importorskip("ezc3d")
    file = ezc3d.c3d(str(path))
    point = file["parameters"]["POINT"]
    scale = {"mm": 1.0, "m": 1000.0}[point["UNITS"]["value"][0].strip()]
    positions = file["data"]["points"][:3].transpose(2, 1, 0) * scale
    positions[(positions == 0).all(axis=2)] = np.nan
    seen = np.isfinite(positions).any(axis=(0, 2))
    labels = [label.strip() for label in point["LABELS"]["value"][: positions.shape[1]]]
    labels = [label or f"point {i}" for i, label in enumerate(labels)]
    kept = [label for label, is_seen in zip(labels, seen, strict=True) if is_seen]
    return kept, float(point["RATE"]["value"][0]), positions[:, seen]


@pytest.mark.parametrize(("suffix", "name"), [*zip(WRITERS, 2 * FILES, strict=True)])
def test_text_of_a_real_recording_gives_what_ezc3d_reads(samples, tmp_path, name, suffix):
    labels, rate, positions = by_ezc3d(samples / "c3d" / name)
    text = WRITERS[suffix](labels, rate, positions, digits=DIGITS)
    path = make(tmp_path, f"take{suffix}", text)
    assert labels_of(path) == tuple(labels)
    ours = read_recording([path], labels)
    theirs = positions.transpose(1, 2, 0)
    assert np.array_equal(np.isnan(ours.position_mm), np.isnan(theirs))
    assert np.nanmax(np.abs(ours.position_mm - theirs)) <= 0.5001 * 10.0**-DIGITS
    assert ours.frame_rate_hz == pytest.approx(rate, rel=1e-6)
    assert ours.resolution_mm == pytest.approx(10.0**-DIGITS)
    missing = np.isnan(theirs).all(axis=1).sum(axis=1)
    assert [sum(n.values()) for n in ours.n_invalid] == missing.tolist()
    c3d = read_recording([samples / "c3d" / name], labels[:1], second_opinion=False)
    assert np.nanmax(np.abs(c3d.position_mm[0] - ours.position_mm[0])) < 2e-4
    assert ours.segments[0].n_frames == c3d.segments[0].n_frames
