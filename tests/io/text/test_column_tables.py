"""Columns with names: markers and poses of programs that have no format of their own; several
bodies in one text of poses."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation
from text_files import LABELS, make, read, refusal, still

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.read import (
    bodies_of,
    labels_of,
    orientation_of,
    points_by_kind,
    read_recording,
)

TAKE = still()
EXPECTED = TAKE.transpose(1, 2, 0)
N = len(TAKE)
TIME = np.round(np.arange(N) / 100, 6)


def table(names, values, mark=",", digits=6) -> str:
    rows = [mark.join("" if np.isnan(v) else f"{v:.{digits}f}" for v in row) for row in values]
    return "\n".join([*([names] if names else []), *rows, ""])


def markers(pattern: str, take=TAKE, time="time", **keys) -> str:
    mark = keys.get("mark", ",")
    names = [pattern.format(label, axis) for label in LABELS for axis in "xyz"]
    return table(mark.join([time, *names]), np.c_[TIME, take.reshape(N, -1)], **keys)


class TestMarkers:
    @pytest.mark.parametrize(
        "pattern",
        ["{0}_{1}", "{0}.{1}", "{0} {1}", "{0}:{1}", "{0}-{1}", "{0}/{1}", "{1}_{0}", "{0}_{1}_mm",
         "{0}_{1} [mm]", "{0}_{1}/mm", "{0}.{1} / mm", '"{0}_{1}"'],
    )  # fmt: skip
    def test_names_and_the_rate_by_the_times(self, tmp_path, pattern):
        text = markers(pattern)
        path = make(tmp_path, "a.csv", text + ",,,,,,\n")  # as a spreadsheet ends it
        recording = read(path, unit="mm")
        assert labels_of(path) == points_by_kind(path)["marker"] == LABELS and bodies_of(path) == ()
        assert np.allclose(recording.position_mm, EXPECTED, atol=1e-9, rtol=0)
        assert recording.frame_rate_hz == 100 and recording.encoding == "table of markers"

    @pytest.mark.parametrize(
        ("unit", "mm"), [("in", 25.4), ("\u00b5m", 1e-3), ("CM", 10), ("m", 1000)]
    )
    def test_units_in_names(self, tmp_path, unit, mm):
        text = markers("{0}_{1}_" + unit, TAKE / mm)
        recording = read(make(tmp_path, "a.csv", text))
        assert np.allclose(recording.position_mm, EXPECTED, atol=6e-7 * mm, rtol=0)

    @pytest.mark.parametrize("index", [None, "time", "Frame", "whole numbers"])
    def test_as_pandas_writes_axes_under_labels(self, tmp_path, index):
        columns = pd.MultiIndex.from_product([LABELS, list("xyz")])
        frame = pd.DataFrame(TAKE.reshape(N, -1), columns=columns)
        frame.index = np.arange(N) if index in ("Frame", "whole numbers") else TIME
        frame.index.name = None if index == "whole numbers" else index
        frame.to_csv(path := tmp_path / "a.csv")
        recording = read(path, unit="mm", frame_rate_hz=100)
        assert np.allclose(recording.position_mm, EXPECTED, atol=1e-9, rtol=0)

    @pytest.mark.parametrize(
        "head",
        ["Frame,A,,,B,,\n,X,Y,Z,X,Y,Z", ",A,A,A,B,B,B\nFrame,X,Y,Z,X,Y,Z\n,mm,mm,mm,mm,mm,mm",
         "sep=,\nFrame,A_x,A_y,A_z,B_x,B_y,B_z", "# exported today\nFrame,A x,A y,A z,B x,B y,B z",
         "Frame,A.X,A.Y,A.Z,B.X,B.Y,B.Z\n,(mm),(mm),(mm),(mm),(mm),(mm)"],
    )  # fmt: skip
    def test_rows_of_a_header(self, tmp_path, head):
        values = np.c_[np.arange(N), TAKE.reshape(N, -1)]
        text = table(head, values).replace(".000000,", ",", N)
        recording = read(make(tmp_path, "a.csv", text), unit="mm", frame_rate_hz=50)
        assert np.allclose(recording.position_mm, EXPECTED, atol=1e-9, rtol=0)
        assert (recording.frame_rate_hz, recording.units) == (50, "mm")

    def test_as_kineticstoolkit_writes(self, samples, tmp_path):
        """A real recording: homogeneous coordinates in m, the index is the time without a name."""
        ezc3d = pytest.importorskip("ezc3d")
        source = samples / "c3d/kineticstoolkit/kinematics_racing_static.c3d"
        file = ezc3d.c3d(str(source))
        points = file["data"]["points"].transpose(2, 1, 0)
        points = points[:, np.isfinite(points).all(axis=(0, 2))][:, :4]
        rate = float(file["parameters"]["POINT"]["RATE"]["value"][0])
        names = [f"M{k}[{i}]" for k in range(4) for i in range(4)]
        index = np.arange(len(points)) / rate
        pd.DataFrame(points.reshape(len(points), 16), index, names).to_csv(tmp_path / "a.csv")
        recording = read(tmp_path / "a.csv", ["M0", "M3"], unit="m")
        expected = points[:, [0, 3], :3].transpose(1, 2, 0) * 1000
        assert labels_of(tmp_path / "a.csv") == ("M0", "M1", "M2", "M3")
        assert np.allclose(recording.position_mm, expected, rtol=1e-12)
        assert recording.frame_rate_hz == pytest.approx(rate, rel=1e-5)

    @pytest.mark.parametrize(
        ("unit", "factor"), [("milliseconds", 1e3), ("microseconds", 1e6), ("us", 1e6), ("ns", 1e9)]
    )
    def test_units_of_time(self, tmp_path, unit, factor):
        values = np.c_[TIME * factor + 1.4e9 * factor, TAKE.reshape(N, -1)]
        names = ",".join([f"timestamp [{unit}]", *(f"{a}_{b}" for a in LABELS for b in "xyz")])
        recording = read(make(tmp_path, "a.csv", table(names, values)), unit="mm")
        assert recording.frame_rate_hz == pytest.approx(100, rel=1e-5)
        assert recording.n_gap_frames == 0

    @pytest.mark.parametrize(
        ("old", "new", "said"),
        [
            ("B_z", "A_z", "line 1: columns 4 and 7 are both 'A_z'"),
            ("B_z", "time", "line 1: columns 1 and 7 are both 'time'"),
            ("B_z", "A_z_cm", "line 1: columns 4 and 7 are the same coordinate, 'A_z' and"),
            ("time", "by hand\ntime", "line 1 is not understood before a table"),
            ("A_x,A_y,A_z,B_x,B_y,B_z", "gyr_x,gyr_y,gyr_z,x_dot,y_dot,z_dot",
             "line 1: no columns x, y, z of a marker"),
            ("A_x,A_y,A_z,B_x,B_y,B_z", "A_x [ell],A_y [ell],A_z [ell],b,c,d",
             "line 1: no columns x, y, z of a marker in time, A_x [ell], A_y [ell], A_z [ell], b,"
             " c, d; units are mm, cm, m, um, in, ft, or their names"),
            ("B_z", "B_q", "line 1: 'B' has the columns x, y, but not z"),
            (",B_z", "", "line 1: 6 names of columns, but 7 cells in line 2"),
            ("time,A_x,A_y,A_z,B_x,B_y,B_z\n", "", "line 1 has numbers without names"),
            ("A_x,A_y,A_z,B_x,B_y,B_z", "a,b,c,d,e,f", "line 1: no columns x, y, z of a marker"),
            ("\n0.010000,", "\n0.000000,", "line 3: time 0.000000 follows 0.000000"),
            ("\n0.390000,", "\n0.380000,", "line 41: time 0.380000 follows 0.380000"),
            ("time", "frame", "line 3: expected a whole frame number, 0.01"),
            ("\n0.050000,", "\nfive,", "line 7, column 1: 'five' is not a number, expected a time"),
        ],
    )  # fmt: skip
    def test_refused(self, tmp_path, old, new, said):
        text = markers("{0}_{1}").replace(old, new, 1)
        rate = {"frame_rate_hz": 100.0} if new == "frame" else {}
        assert f"a.csv: {said}" in refusal(make(tmp_path, "a.csv", text), unit="mm", **rate)

    @pytest.mark.parametrize("names", ["frame,marker", "time,id"])
    def test_a_row_for_each_marker_is_refused(self, tmp_path, names):
        labels = ("hip", "knee", "toe") if "marker" in names else (1, 2, 3)
        rows = [f"{k},{label},1.5,2,{k % 7}" for k in range(40) for label in labels]
        for order in (rows, sorted(rows, key=lambda row: row.split(",")[1])):
            path = make(tmp_path, "a.csv", "\n".join([f"{names},x,y,z", *order, ""]))
            assert f"a row for each '{names.split(',')[1]}' of a frame" in refusal(path, unit="mm")

    def test_a_time_in_two_columns_is_no_row_for_each_marker(self, tmp_path):
        rows = [f"{k // 10},{k % 10 * 100000},1.5,2,{k % 7}" for k in range(40)]
        path = make(tmp_path, "a.csv", "\n".join(["sec,usec,x,y,z", *rows, ""]))
        assert "line 3: time 0 follows 0" in refusal(path, unit="mm")

    @pytest.mark.parametrize(
        "change",
        [
            lambda lines: [",".join(f'"{c}"' for c in line.split(",")) for line in lines],
            lambda lines: [f",{line}" for line in lines],
            lambda lines: [f'"{k or ""}",{line}' for k, line in enumerate(lines)],
            lambda lines: [line.replace(",", ", NA,", 1) for line in lines],
        ],
        ids=["all quoted", "blank column", "row names of R", "NA"],
    )
    def test_as_other_programs_write(self, tmp_path, change):
        text = "\n".join([*change(markers("{0}_{1}").splitlines()), ""])
        recording = read(make(tmp_path, "a.csv", text), unit="mm")
        assert np.allclose(recording.position_mm, EXPECTED, atol=1e-9, rtol=0)
        assert recording.frame_rate_hz == 100 and recording.n_gap_frames == 0

    def test_a_row_may_end_before_its_time(self, tmp_path):
        rows = [f"{k}.0,2.0,{k}.5,{k / 100}" for k in range(20)]
        for cells in (3, 2):
            rows[7] = ",".join(["7.0", "2.0", "7.5"][:cells])
            text = "\n".join(["A_x,A_y,A_z,time", *rows, ""])
            said = "line 9, column 4: '' is not a number, expected a time"
            assert said in refusal(make(tmp_path, "a.csv", text), ["A"], unit="mm")

    def test_constant_times_and_cut_off(self, tmp_path):
        text = markers("{0}_{1}")
        zeros = "\n".join(  # as a spreadsheet has it
            line if k == 0 else "0," + line.partition(",")[2]
            for k, line in enumerate(text.split("\n"))
        )
        assert "line 3: time 0 follows 0" in refusal(make(tmp_path, "z.csv", zeros[:-2]), unit="mm")
        cut = make(tmp_path, "c.csv", text[:-30])
        in_time = make(tmp_path, "t.csv", text[: text.rindex("0.390000") + 3])
        assert "t.csv: cut off: line 41 ends after 1 of 7 cells" in refusal(in_time, unit="mm")
        assert "c.csv: cut off: line 41 ends after" in refusal(cut, unit="mm")
        assert read(cut, unit="mm", accept_truncated=True).position_mm.shape[2] == N - 1


TURNS = Rotation.random(N, np.random.default_rng(5))
QUATERNION = TURNS.as_quat()
POSITION = TAKE[:, 0] / 1000


def pose_text(names):
    """Each column by its name; x y z first, then the quaternion."""
    known = dict(zip("xyz", POSITION.T, strict=True))
    known |= dict(zip(("qx", "qy", "qz", "qw"), QUATERNION.T, strict=True)) | {"t": TIME}
    return [known[name] for name in names]


ORDERS = [
    ("# timestamp tx ty tz qx qy qz qw", "t x y z qx qy qz qw", " ", ".txt"),
    ("# timestamp tx ty tz qx qy qz qw", "t x y z qx qy qz qw", " ", ".tum"),
    ("x y z w i j k", "x y z qw qx qy qz", " ", ".txt"),
    ("x,y,z,i,j,k,w", "x y z qx qy qz qw", ",", ".csv"),
    ("time,px,py,pz,qw,qx,qy,qz", "t x y z qw qx qy qz", ",", ".csv"),
    ("time,Q0,Qx,Qy,Qz,Tx,Ty,Tz", "t qw qx qy qz x y z", ",", ".csv"),
    ("#timestamp [s],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],"
     "q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []",
     "t x y z qw qx qy qz", ",", ".csv"),
    ("%time,field.pose.position.x,field.pose.position.y,field.pose.position.z,"
     "field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
     "field.pose.orientation.w", "t x y z qx qy qz qw", ",", ".csv"),
    ("t\tpos_x\tpos_y\tpos_z\tquat_w\tquat_x\tquat_y\tquat_z", "t x y z qw qx qy qz", "\t", ".tsv"),
]  # fmt: skip


class TestPoses:
    @pytest.mark.parametrize(("header", "order", "mark", "suffix"), ORDERS)
    def test_the_order_is_that_of_the_header(self, tmp_path, header, order, mark, suffix):
        values = np.transpose(pose_text(order.split()))
        path = make(tmp_path, f"a{suffix}", table(header, values, mark, 9))
        (label,) = labels_of(path)
        assert bodies_of(path) == (label,)
        rate = None if "t" in order.split() else 100.0
        recording = read(path, [label], unit="m", frame_rate_hz=rate)
        assert np.allclose(recording.position_mm[0].T, 1000 * POSITION, atol=1e-5)
        assert recording.frame_rate_hz == 100
        ours = Rotation.from_quat(orientation_of([path], label, rate).T)
        assert (ours * TURNS.inv()).magnitude().max() < 1e-7

    @pytest.mark.parametrize("suffix", [".txt", ".csv", ".tum"])
    def test_an_order_that_is_stated(self, tmp_path, suffix):
        order = "t x y z qw qx qy qz"
        values = np.transpose(pose_text(order.split()))
        wrong = "# t x y z qx qy qz qw" if suffix == ".tum" else ""
        path = make(tmp_path, f"a{suffix}", table(wrong, values, " ", 9))
        assert bodies_of(path, columns=order) == labels_of(path, columns=order) == ("tracker",)
        assert read(path, ["tracker"], unit="m", columns=order).frame_rate_hz == 100
        ours = Rotation.from_quat(orientation_of([path], "tracker", columns=order).T)
        assert (ours * TURNS.inv()).magnitude().max() < 1e-7
        assert f"a{suffix}: columns as given: 7 names of columns, but 8 cells" in refusal(
            path, ["tracker"], unit="m", columns=order[2:]
        )

    @pytest.mark.parametrize("of_turn", ["{}_q{}", "{}.q.{}", "{} orientation {}"])
    def test_several_bodies(self, tmp_path, of_turn):
        names = ["time", *(f"{body}_{axis}" for body in "ab" for axis in "xyz")]
        names += [of_turn.format(body, axis) for body in "ba" for axis in "wxyz"]
        order = "t x y z x y z qx qy qz qw qw qx qy qz"
        values = np.transpose(pose_text(order.split()))
        path = make(tmp_path, "a.csv", table(",".join(names), values, digits=9))
        assert bodies_of(path) == ("a", "b")
        ours = Rotation.from_quat(orientation_of([path], "a").T)
        assert (ours * TURNS.inv()).magnitude().max() < 1e-7

    @pytest.mark.parametrize(
        ("header", "said"),
        [
            ("", "line 1 has numbers without names: name its columns"),
            ("x,y,z,q1,q2,q3,q4", "line 1 has numbers without names"),
            ("x,y,z,qx,qy,qz,q", "'q' has the columns x, y, z, but not w"),
            ("x,y,qx,qy,qz,qw,z2", "there are x, y, but not z"),
        ],
    )
    def test_no_order_is_guessed(self, tmp_path, header, said):
        values = np.transpose(pose_text(["x", "y", "z", "qx", "qy", "qz", "qw"]))
        path = make(tmp_path, "a.csv", table(header, values, digits=9))
        if header.startswith("x,y,z,q1"):  # positions alone: the quaternion has no order
            assert bodies_of(path) == ()
        else:
            assert said in refusal(path, ["tracker"], unit="m", frame_rate_hz=100.0)

    def test_a_real_recording_of_a_still_tracker(self, samples):
        path = samples / "metrology/vive_accuracy/20200918_Exp1/measurementPoint1.txt"
        values = np.loadtxt(path)
        recording = read(path, ["tracker"])
        assert np.array_equal(recording.position_mm[0], 1000 * values[:, :3].T)
        assert recording.frame_rate_hz == 250
        turned = Rotation.from_quat(orientation_of([path], "tracker").T)
        upward = turned.inv().apply([0.0, 1.0, 0.0])  # by the matrices of 2020-10-01: -z of it
        matrix = np.loadtxt(samples / "static_vive_pose/20201001_Exp1_measurementPoint1.txt")
        assert upward @ matrix[:, 4:7].mean(axis=0) == pytest.approx(1, abs=0.02)
        assert math.isclose(np.linalg.norm(upward[0]), 1, rel_tol=1e-9)


FRAMES = 300


@pytest.fixture
def poses() -> tuple[np.ndarray, Rotation]:
    """Positions (2, n, 3) in m, and turns of the second body."""
    rng = np.random.default_rng(1)
    return 1 + rng.random((2, FRAMES, 3)), Rotation.random(FRAMES, rng=rng)


def write(path: Path, comment: str, parts: list[np.ndarray]) -> Path:
    np.savetxt(path, np.hstack(parts), header=comment, fmt="%.9f")
    return path


def matrices(position: np.ndarray, turn: Rotation) -> np.ndarray:
    return np.concatenate([turn.as_matrix(), position[:, :, None]], axis=2).reshape(FRAMES, 12)


@pytest.mark.parametrize("order", ["wxyz", "xyzw"])
def test_two_bodies_by_quaternions(tmp_path: Path, poses, order: str) -> None:
    (a, b), turn = poses
    quaternion = turn.as_quat(scalar_first=order == "wxyz")
    comment = f"bodies: A;B\nquaternion: {order}\nFreq: 250"
    path = write(tmp_path / "bar.txt", comment, [a, quaternion, b, quaternion])
    assert read_recording([path], ["B"]).position_mm[0] == pytest.approx(1000 * b.T, abs=1e-5)
    back = Rotation.from_quat(orientation_of([path], "A").T)
    assert (back * turn.inv()).magnitude().max() < 1e-7


@pytest.mark.parametrize(
    ("comment", "words"),
    [
        ("Freq: 9 bodies: A;B", "12 numbers a line; expected 12 for each of A, B"),
        ("bodies: A;A", "bodies: A;A; expected names, none repeated"),
    ],
)
def test_other_numbers_are_refused(tmp_path: Path, poses, comment: str, words: str) -> None:
    (a, _), turn = poses
    path = write(tmp_path / "bar.txt", comment, [matrices(a, turn)])
    with pytest.raises(Refusal, match=r"bar\.txt") as refused:
        read_recording([path], ["A"])
    assert words in str(refused.value)
