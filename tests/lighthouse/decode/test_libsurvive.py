"""Recordings of libsurvive: a real one against its own processed lines, and small made ones."""

import gzip
import json
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode import libsurvive
from mocap_metrology.lighthouse.decode.libsurvive import read_libsurvive, tracked_objects
from mocap_metrology.lighthouse.decode.libsurvive_lines import normals_of
from mocap_metrology.lighthouse.decode.libsurvive_solution import read_solution, solution_pose
from mocap_metrology.lighthouse.rotation import log
from mocap_metrology.lighthouse.timing import TICKS_PER_S

FOLDER = "lighthouse/libsurvive_extras"
BOARD = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]


def config(points: list[list[float]] = BOARD, channels: list[int] | None = None) -> str:
    lights = {"modelPoints": points, "channelMap": channels or list(range(len(points)))}
    return json.dumps({"lighthouse_config": lights})


def recording(path: Path, *lines: str, end: str = "\n", packed: bool = False) -> Path:
    data = "".join(line + end for line in lines).encode()
    path.write_bytes(gzip.compress(data) if packed else data)
    return path


def first_lines(samples: Path) -> bytes:
    """Of a real recording, packed."""
    with gzip.open(samples / FOLDER / "lh1_test_cal.rec.gz") as lines:
        return gzip.compress(b"".join(islice(lines, 5000)))


def test_real_diodes_are_those_of_the_processed_lines(samples: Path, headset: dict) -> None:
    """A lines repeat the pulse's start and name the diode as libsurvive mapped it."""
    path = samples / FOLDER / "lh1_test_cal.rec.gz"
    raw, mapped = [], {}
    with gzip.open(path, "rt") as lines:
        for cells in (line.split() for line in lines):
            if cells[1:3] == ["T20", "C"]:
                raw.append(int(cells[4]))
            elif cells[1:3] == ["T20", "A"]:
                mapped[int(cells[5])] = int(cells[3])
    read = headset["T20"].pulses
    ticks = np.round(read.start_s * TICKS_PER_S).astype(np.int64)
    diode_at = dict(zip(((ticks + min(raw)) % 2**32).tolist(), read.diode.tolist(), strict=True))
    assert len(mapped) > 10_000
    starts = {s: d for s, d in mapped.items() if s in diode_at}
    assert len(starts) > 0.99 * len(mapped)
    wrong = sum(diode_at[s] != d for s, d in starts.items())
    assert wrong <= 0.01 * len(starts)  # two diodes hit in one tick


def test_real_solution_is_turned_into_this_projects_axes(samples: Path) -> None:
    """Against the hand-made inversion in the data's notes: (0.811, 0.128, -3.926) m, 170.7 deg for
    libsurvive's station 1 in its station 0."""
    stations = read_solution(samples / FOLDER / "lh1_test_cal.rec.gz.json")
    assert [s.id for s in stations] == [178605925, 4152238579]
    assert [s.mode for s in stations] == ["A", "b"]
    R, t = solution_pose(stations)
    assert np.linalg.norm(t) == pytest.approx(4.011, abs=5e-4)
    assert np.degrees(np.linalg.norm(log(R))) == pytest.approx(170.7, abs=0.05)
    assert np.linalg.det(R) == pytest.approx(1.0)
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-5)
    back = -R.T @ t  # the master in the slave's frame: x = -Z, y = -X, z = Y
    assert back == pytest.approx([3.926, -0.811, 0.128], abs=6e-4)


@pytest.mark.parametrize(("length", "of_a_head"), [(0.996, True), (1.004, True), (1.006, False)])
def test_axes_of_a_head_have_unit_length_to_half_a_percent(
    tmp_path: Path, length: float, of_a_head: bool
) -> None:
    head = {"plus_x": [0, length, 0], "plus_z": [0, 0, 1], "position": [0.1, 0.2, 0.3]}
    path = recording(tmp_path / "a.rec", f"0 A CONFIG {json.dumps({'head': head})}")
    if of_a_head:
        (found,) = tracked_objects(path)
        np.testing.assert_allclose(found.R, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
        assert found.t_m.tolist() == head["position"]
    else:
        with pytest.raises(Refusal, match=r"^a\.rec, A: its CONFIG is unreadable; .* unit length"):
            tracked_objects(path)


def test_other_objects_and_the_second_generation_are_refused_by_name(
    tmp_path: Path, samples: Path
) -> None:
    (tmp_path / "a.rec.gz").write_bytes(first_lines(samples))
    with pytest.raises(Refusal, match=r"expected one of HMD, T20$"):
        read_libsurvive(tmp_path / "a.rec.gz", "other")
    with pytest.raises(Refusal, match=r"of second-generation \(V2\) stations; expected first"):
        read_solution(samples / FOLDER / "haagh-tracking.rec.gz.json")


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_map_wrap_order_and_line_ends(tmp_path: Path, end: str, packed: bool) -> None:
    path = recording(
        tmp_path / "a.rec",  # packed or not: told by content
        "0.1 INFO LOG a C 1 2 3",
        f"0.2 T20 CONFIG {config(channels=[7, 5, 3, 1])}",
        f"0.2 HMD CONFIG {config()}",
        "0.3 T20 C 5 4294967290 3000",
        "0.3 HMD C 0 17 99",
        "0.3 T20 C 3 100 200",
        "0.3 T20 C 1 40 300",  # later in the file, earlier in time
        "0.4 T20 C 6 500 100",  # on no diode
        "0.4 T20 A 3 4 40 0.000012 0.1 1",
        end=end,
        packed=packed,
    )
    if not packed:
        path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    read, board = read_libsurvive(path, "T20")
    assert read.diode.tolist() == [1, 3, 2]
    assert (read.start_s * TICKS_PER_S).round().tolist() == [0, 46, 106]
    assert (read.length_s * TICKS_PER_S).round().tolist() == [3000, 300, 200]
    assert board.tolist() == BOARD
    assert len(read.notes) == 1 and read.notes[0].startswith("1 pulses ignored")


def test_lines_that_cannot_be_read_are_counted(tmp_path: Path) -> None:
    lines = [f"0.1 A CONFIG {config()}", "0.1 INFO LOG C"]
    lines += [f"0.{k} A C {k % 4} {400_000 * k} 3000" for k in range(1, 9)]
    sound = read_libsurvive(recording(tmp_path / "a.rec", *lines, "", end="\r\n"), "A")[0]
    assert sound.notes == () and sound.start_s.size == 8
    lines[3:6] = ["0.2 A C 1 80x000 3000", "0.\x002 A C 2", "garbage", "0.5 A C 1"]
    lines += ["0.7 AB C 1 10 10", "0.8 AB C 1 20 10"]
    path = recording(tmp_path / "b.rec", *lines)
    path.write_bytes(path.read_bytes() + b"0.9 A C 0 4400010 30")  # a last line cut off
    damaged = read_libsurvive(path, "A")[0]
    assert damaged.start_s.size == 5
    assert damaged.notes == (
        "4 lines cannot be read and are left out: damage, or messages of a program",
        "2 pulses are of objects without a CONFIG line and are left out",
    )


QUARTER = [0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)]  # about z, x y z w


@pytest.mark.parametrize("described", ["controller", "headset"])
def test_gyroscope_and_accelerometer(tmp_path: Path, described: str) -> None:
    """Axes of the sensors turned by 90 deg about z: their x is the object's y. The counter wraps
    between pulse and sample; a sample whose time is not later than the one before is left out, and
    lines that are damaged, of another object, or out of range are counted or none."""
    own = {"plus_x": [0, 1, 0], "plus_z": [0, 0, 1], "position": [0.01, 0.02, 0.03]}
    more = {"imu": own}
    if described == "headset":
        more = {"trackref_from_imu": [*QUARTER, 0.01, 0.02, 0.03]}
    text = json.dumps(json.loads(config()) | more)
    lines = [f"0.1 A CONFIG {text}", f"0.1 B CONFIG {config()}", "0.2 A C 0 4294919296 3000"]
    lines += ["0.2 B C 0 100 3000", "0.3 A I 3 0 1.0 2.0 3.0 0.1 -0.2 3e-1 0 0 0 7"]
    lines += ["0.3 A I 3 48000 1 0 0 0 0 1 0 0 0 8", "0.4 B I 3 5 1 0 0 0 0 0 0 0 0 8"]
    lines += ["0.4 A I 3 48000 1 0 0 0 0 1 0 0 0 9"]
    read, _ = read_libsurvive(recording(tmp_path / "a.rec", *lines), "A")
    assert read.notes == () and read.inertial is not None
    np.testing.assert_allclose(read.inertial.time_s, [1e-3, 2e-3], atol=1e-12)
    np.testing.assert_allclose(read.inertial.rate_rad_s, [[0.2, 0.1, 0.3], [0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(
        read.inertial.force_m_s2 / 9.80665, [[-2, 1, 3], [0, 1, 0]], atol=1e-12
    )
    assert read.inertial.place_m.tolist() == [0.01, 0.02, 0.03]
    assert read_libsurvive(tmp_path / "a.rec", "B")[0].inertial is None  # not described
    lines += ["0.5 A I 3 96000 1 0 x 0 0 1 0 0 0 9", "0.5 A I 3", "0.5 A I 3 96000 1 0 0 0 0 1e3"]
    read, _ = read_libsurvive(recording(tmp_path / "b.rec", *lines), "A")
    assert read.inertial is not None and len(read.inertial) == 2
    assert read.notes == (
        "3 lines cannot be read and are left out: damage, or messages of a program",
    )


@pytest.mark.parametrize(
    "described",
    [
        {},
        {"imu": {"plus_x": [0, 1, 0], "plus_z": [0, 1, 0], "position": [0, 0, 0]}},
        {"imu": {"plus_x": [0, 2, 0], "plus_z": [0, 0, 1], "position": [0, 0, 0]}},
        {"imu": {"plus_x": [0, 1, 0], "plus_z": [0, 0, 1], "position": [0, 9, 0]}},
        {"imu": {"plus_x": [0, 1], "plus_z": [0, 0, 1], "position": [0, 0, 0]}},
        {"imu": 3},
        {"trackref_from_imu": [0, 0, 0, 2, 0, 0, 0]},
        {"trackref_from_imu": [0, 0, 1, 0, 0, 0]},
        {"trackref_from_imu": [0, 0, 1, 0, 0, 0, 1e400]},
        {"trackref_from_imu": "abc"},
    ],
)
def test_sensors_that_are_not_described_are_not_used(tmp_path: Path, described: object) -> None:
    text = json.dumps(json.loads(config()) | described)
    lines = [f"0.1 A CONFIG {text}", "0.2 A C 0 0 3000", "0.3 A I 3 0 1 2 3 0 0 0 0 0 0 7"]
    assert read_libsurvive(recording(tmp_path / "a.rec", *lines), "A")[0].inertial is None


PULSE = "0.2 A C 0 10 3000"
CASES = {
    "not a recording": (["hello", "world"], "no line reads"),
    "empty": ([], "no line reads"),
    "other object": ([f"0 B CONFIG {config()}", PULSE.replace("A", "B")], "expected one of B$"),
    "angles only": (["0.1 A A 3 4 40 0.000012 0.1 1", "0.1 A L X 3 4 1 2 3 1"], "processed angles"),
    "no light": (["0.1 INFO LOG hello"], "no light"),
    "no geometry": ([PULSE], "no CONFIG line of A"),
    "garbled geometry": (["0 A CONFIG {nonsense", PULSE], "CONFIG is unreadable"),
    "no points": (['0 A CONFIG {"lighthouse_config": {}}', PULSE], "modelPoints"),
    "map too short": ([f"0 A CONFIG {config(channels=[0, 1])}", PULSE], "channelMap"),
    "in mm": ([f"0 A CONFIG {config((1000 * np.array(BOARD)).tolist())}", PULSE], "mm"),
    "too many pulses": ([f"0 A CONFIG {config()}", *[PULSE] * 501], "too long: 501 pulses of A"),
    "too many objects": ([f"0 A{k} C 0 10 3000" for k in range(1001)], "1001 objects"),
    "other channels": ([f"0 A CONFIG {config()}", "0.2 A C 9 10 3000"], "no pulse on a channel"),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_input_gets_one_line(tmp_path: Path, monkeypatch, case: str) -> None:
    lines, message = CASES[case]
    monkeypatch.setattr(libsurvive, "MOST_PULSES", 500)
    with pytest.raises(Refusal, match=message) as refused:
        read_libsurvive(recording(tmp_path / "bad.rec", *lines), "A")
    assert "bad.rec" in str(refused.value) and "\n" not in str(refused.value)


SOLUTIONS = {
    "no stations": ('"v":"0"\n', "no calibrated station"),
    "half a station": ('"lighthouse0":{ "id":"3", "mode":"x" }', "missing or invalid"),
    "second generation": ('"lighthouse-gen":"2"', r"second-generation \(V2\)"),
    "not calibrated": (
        '"lighthouse0":{"id":"3","mode":"0","OOTXSet":"0"}',
        "no calibrated station",
    ),
}


@pytest.mark.parametrize("case", SOLUTIONS)
def test_bad_solutions(tmp_path: Path, case: str) -> None:
    text, message = SOLUTIONS[case]
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(Refusal, match=message):
        read_solution(tmp_path / "a.json")


def test_broken_gzip_and_missing_file(tmp_path: Path, samples: Path) -> None:
    whole = first_lines(samples)
    path = tmp_path / "cut.rec.gz"
    for broken in (whole[: len(whole) // 3], whole[:20_000] + bytes(1000) + whole[21_000:]):
        path.write_bytes(broken)
        with pytest.raises(Refusal, match="gzip stream is damaged"):
            read_libsurvive(path, "HMD")
    path.write_bytes(gzip.decompress(whole)[:9999].decode().encode("utf-16"))
    with pytest.raises(Refusal, match="UTF-16 text; expected UTF-8"):
        read_libsurvive(path, "HMD")
    with pytest.raises(Refusal, match="cannot be read"):
        read_libsurvive(tmp_path / "none.rec", "HMD")


@pytest.mark.parametrize(("length", "n", "used"), [(1.05, 4, True), (1.2, 4, False), (1, 3, False)])
def test_normals_that_are_no_unit_vectors_are_damage(length: float, n: int, used: bool) -> None:
    """Within a tenth they are rounded, and made unit vectors."""
    normals = [[0.6 * length, 0.0, 0.8 * length]] * n
    found = normals_of({"lighthouse_config": {"modelNormals": normals}}, 4)
    assert (found is not None) is used
    if used:
        np.testing.assert_allclose(found, [[0.6, 0.0, 0.8]] * 4)
