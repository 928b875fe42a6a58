"""Real exports of motion-capture software, as `../samples/data/exports/README.md` judges them.

Positions and orientations against a parser of a few lines, written apart from the readers.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from text_files import make, motive, read, still, trc

from mocap_metrology.common.errors import Refusal, Unseen
from mocap_metrology.io.read import bodies_of, labels_of, orientation_of, read_recording

FOLDER = "exports"
BALL = "motive/MarcoRosson__Optitrack_basketball/Ball_6.csv"
TAKE = "motive/cmuphyscomp__hmv-s16/sample_optitrack_take.csv"
ROBOT = "motive/timeanddoctor__parse_optitrack_csv/test.csv"
LEG, LEG_6D = (f"qtm/martinling__imusim/stand_{kind}.tsv" for kind in ("3D", "6D"))
OPENSIM = "trc/opensim-org__opensim-core"
CORTEX = "trc/demotu__BMC/walk.trc"
SOLVED = "is a body: its position and orientation are solved from its markers, not measured"

# File: labels, frames, rate, and the first of the numbers (column, line of the file from 0, mm per
# unit) of its first label.
READ = {
    BALL: (6, 8554, 360.0, 9, 7, 1000.0),
    TAKE: (12, 250, 120.0, 22, 7, 1000.0),
    ROBOT: (4, 499, 120.0, 26, 7, 1000.0),
    LEG: (14, 513, 256.0, 0, 10, 1.0),
    LEG_6D: (3, 513, 256.0, 0, 11, 1.0),
    "nexus/pyomeca__pyomeca/markers.csv": (51, 580, 100.0, 2, 5, 1.0),
    f"{OPENSIM}/exampleFormat.trc": (3, 5, 100.0, 2, 5, 1000.0),
    f"{OPENSIM}/dataWithEformat.trc": (14, 5, 119.88012, 2, 5, 1000.0),
    f"{OPENSIM}/dataWithNaNsOfDifferentCases.trc": (14, 5, 250.0, 2, 5, 1.0),
    f"{OPENSIM}/gait10dof18musc_walk_CRLF_line_ending.trc": (41, 10, 60.0, 2, 6, 1.0),
    f"{OPENSIM}/subject01_synthetic_marker_data.trc": (31, 73, 60.0, 2, 6, 1000.0),
    CORTEX: (28, 184, 150.0, 2, 6, 1.0),
}


def found(samples, name):
    path = samples / FOLDER / name
    if not path.exists():
        pytest.skip(f"{path} is not there")
    return path


def numbers(path, line, columns):
    """Cells of the rows from a line on, NaN where a cell is no number; (n, columns)."""
    mark = "," if path.suffix == ".csv" else "\t"
    rows = path.read_text("latin-1").splitlines()[line:]
    cells = [[*row.split(mark), *[""] * 900] for row in rows if row.strip(f"{mark} ")]

    def value(text):
        return float(text) if text.strip(' "').strip() else np.nan

    return np.array([[value(row[c]) for c in columns] for row in cells])


@pytest.mark.parametrize("name", READ)
def test_read(samples, name):
    """All labels, frames, the rate, and every number of the first label."""
    path = found(samples, name)
    n_labels, frames, rate, column, line, mm = READ[name]
    labels = labels_of(path)
    assert len(labels) == n_labels
    recording = read_recording([path], labels[:1])
    assert recording.position_mm.shape == (1, 3, frames)
    assert recording.frame_rate_hz == pytest.approx(rate, rel=1e-6)
    ours = mm * numbers(path, line, range(column, column + 3))
    np.testing.assert_allclose(recording.position_mm[0].T, ours, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize(
    "name, body, column, line", [(BALL, "Ball_6", 2, 7), (ROBOT, "ernesto_body", 2, 7)]
)
def test_rigid_bodies_of_motive(samples, name, body, column, line):
    """Beside measured markers a body is read where it is asked for."""
    path = found(samples, name)
    assert bodies_of(path) == (body,) and body not in labels_of(path)
    recording = read_recording([path], [body])
    cells = numbers(path, 7, range(2, 9))
    np.testing.assert_allclose(recording.position_mm[0].T, 1000 * cells[:, 4:], rtol=1e-12)
    assert any(note.endswith(f"{body}: {SOLVED}") for note in recording.notes)
    ours = orientation_of([path], body)
    seen = np.isfinite(cells).all(axis=1)
    assert np.array_equal(np.isfinite(ours).all(axis=0), seen)
    same = np.abs((ours[:, seen].T * cells[seen, :4]).sum(axis=1))
    assert np.abs(same - 1).max() < 3e-6  # six decimals; q and -q are one rotation
    with pytest.raises(Refusal, match="is a marker, which has no orientation"):
        orientation_of([path], labels_of(path)[0])


def test_bodies_of_qualisys_turn_as_their_markers_do(samples):
    """The same leg, its markers in one file, its bodies in the other: a body's matrix carries its
    three markers from frame to frame; transposed it carries them farther off than not at all."""
    bodies, markers = found(samples, LEG_6D), found(samples, LEG)
    assert labels_of(bodies) == ("Upper Leg IMU", "Foot IMU", "Lower Leg IMU")
    for body in labels_of(bodies):
        recording = read_recording([bodies], [body])
        assert recording.notes == (f"{bodies.name}: {body}: {SOLVED}",)
        turns = Rotation.from_quat(orientation_of([bodies], body).T).as_matrix()
        own = read_recording([markers], [f"{body} - {k}" for k in (1, 2, 3)]).position_mm
        shape = own - recording.position_mm
        by_body = np.einsum("fba,kbf->kaf", turns, shape)  # in axes of the body
        transposed = np.einsum("fab,kbf->kaf", turns, shape)
        left, without, wrong = (v.std(axis=2).max() for v in (by_body, shape, transposed))
        assert left < 0.5 * without < without < wrong


def test_bodies_alone(tmp_path):
    """Motive with bodies and bones only; angles in degrees, in the order that the header names."""
    rng, n = np.random.default_rng(2), 30
    angles = np.cumsum(rng.normal(0, 2, (n, 3)), axis=0)
    places = 1 + rng.normal(0, 1e-4, (n, 3))
    whole = motive(["A", "B"], 100, np.zeros((n, 2, 3)), "Meters").split("\r\n")
    whole[2] = ",Type" + ",Bone" * 6
    whole[3] = ",Name" + ",Fred:Hip" * 6
    whole[5] = ",," + ",".join(["Rotation"] * 3 + ["Position"] * 3)
    whole[7 : 7 + n] = [
        ",".join([str(i), f"{i / 100:.6f}", *(f"{v:.6f}" for v in (*angles[i], *places[i]))])
        for i in range(n)
    ]
    path = make(tmp_path, "a.csv", "\r\n".join(whole).replace("Quaternion", "ZYX"))
    assert labels_of(path) == bodies_of(path) == ("Fred:Hip",)
    assert bodies_of(path, ["Hip"]) == ("Hip",)
    recording = read(path, ["Hip"])
    np.testing.assert_allclose(recording.position_mm[0].T, 1000 * places, atol=1e-3)
    theirs = Rotation.from_euler("ZYX", angles[:, ::-1], degrees=True)
    ours = Rotation.from_quat(orientation_of([path], "Hip").T)
    assert (ours * theirs.inv()).magnitude().max() < 1e-7


def test_zeros_of_matlab_are_gaps(tmp_path):
    """Where line 4 says Times; with a marker seen in no frame at all."""
    take = still()
    take[4:7, 0] = 0
    for ends, mark in (("\n", "\t"), ("\r\n", ",")):
        text = trc(["A", "B"], 100, take).replace("Frame#\tTime\t", "Frame#\tTimes\t")
        text = text.replace("\n", ends).replace("\t", mark)
        recording = read(make(tmp_path, "a.trc", text))
        assert np.flatnonzero(np.isnan(recording.position_mm[0, 0])).tolist() == [4, 5, 6]
        assert recording.n_invalid[0]["zero"] == 3
        assert "in 3 frames, treated as gaps: its writer (Times in line 4)" in recording.notes[0]
    take[:, 1] = 0
    with pytest.raises(Unseen, match=r"'B'.*40 zero"):
        read(make(tmp_path, "a.trc", trc(["A", "B"], 100, take).replace("\tTime\t", "\tTimes\t")))


@pytest.mark.parametrize("name", ["a.csv", "a.txt"])
@pytest.mark.parametrize(
    "before", ["", "EVENTS\r\n\r\nANALOG\r\n1000.000000,Hz\r\nSample #,F1\r\n1,2\r\n\r\n"]
)
def test_old_vicon_is_named(tmp_path, name, before):
    old = "TRAJECTORIES\r\n120.000000,Hz\r\n,Fred:C7,,\r\nField #,X,Y,Z\r\n1,10.5,20.5,30.5\r\n"
    with pytest.raises(Refusal, match=r"is an old Vicon ASCII export .* export C3D, or CSV from"):
        labels_of(make(tmp_path, name, before + old))
