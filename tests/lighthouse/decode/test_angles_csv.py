"""Angles decoded elsewhere."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.angles_csv import read_angles
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.decode.turns import PERIOD_S, PLANE_RAD

HEADER = "station,axis,cycle,diode,time_s,angle_rad"


def write(path: Path, *rows: str) -> Path:
    path.write_text("".join(row + "\n" for row in rows))
    return path


CASES = {
    "no column": (["station,axis,cycle,diode,time_s", "0,0,0,0,0"], "no column angle_rad"),
    "no rows": ([HEADER], "no rows"),
    "empty": ([], "no column station"),
    "a column twice": ([f"{HEADER}, station", "0,0,0,0,0,0,1"], "column station is repeated"),
    "a cell too many": ([HEADER, "5,0,0,0,0,0,0"], "line 2 has 7 cells, expected 6"),
    "a station too many": ([HEADER, "0,0,0,0,0,0", "2,0,0,0,0,0"], "row 2: station is '2'"),
    "a word": ([HEADER, "0,0,0,0,0,left"], "angle_rad is 'left'"),
    "an empty cell": ([HEADER, "0,0,0,0,,0.1"], "time_s is ''"),
    "not finite": ([HEADER, "0,0,0,0,inf,0.1"], "time_s is 'inf'"),
    "third axis": ([HEADER, "0,2,0,0,0,0"], "axis is 2; expected 0 or 1"),
    "half a cycle": ([HEADER, "0,0,0.5,0,0,0"], "cycle is 0.5"),
    "negative diode": ([HEADER, "0,0,0,-1,0,0"], "diode is -1"),
    "a sweep of a second": ([HEADER, "0,0,7,0,0.1,0", "0,0,7,1,1.1,0"], "cycle 7 are 1 s apart"),
    "cycles backwards": ([HEADER, "1,1,8,0,0.1,0", "1,1,4,0,0.2,0"],
                         "cycle 8 is not after cycle 4"),
    "milliseconds": ([HEADER, *(f"0,0,{4 * k},0,{33.3 * k},0.1" for k in range(30))],
                     "azimuth sweeps of the master are 33.3 s apart"),
    "one number for all": ([HEADER, *(f"0,0,3,{k},{0.033 * k},0.1" for k in range(30))],
                           "hits of cycle 3 are 0.957 s apart"),
    "twice": ([HEADER, "0,0,1,0,0.1,0", "0,0,1,0,0.101,0"], "row 1: its station, axis, cycle and"),
    "a diode of 16 bits": ([HEADER, "0,0,0,32768,0,0"], "diode is 32768; expected a whole number"),
    "more than a right angle": ([HEADER, "0,0,0,0,0,1.5709"], "reaches 1.5709; expected radians"),
    "each eighth turn": ([HEADER, *(f"0,0,{k},0,{0.075 * k},0.1" for k in range(11))],
                         "are 0.075 s apart; expected about 0.017 or 0.033 s"),
    "each half of a turn": ([HEADER, *(f"0,0,{k},0,{k / 120},0.1" for k in range(11))],
                            "are 0.00833 s apart; expected about 0.017 or 0.033 s"),
    "degrees": ([HEADER, "0,0,0,0,0,0.5", "0,0,0,1,0,-22.5"], "reaches 22.5; expected radians"),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_bad_input_gets_one_line(tmp_path: Path, case: str) -> None:
    rows, message = CASES[case]
    with pytest.raises(Refusal, match=message) as refused:
        read_angles(write(tmp_path / "bad.csv", *rows))
    assert "bad.csv" in str(refused.value) and "\n" not in str(refused.value)


@given(
    step=st.sampled_from((2, 4)), first=st.integers(-1000, 1000), begin=st.floats(0, 1e4),
    missing=st.sets(st.integers(0, 39), max_size=10), comma=st.booleans(),
)  # fmt: skip
def test_angles_are_those_of_the_file(step, first, begin, missing, comma) -> None:
    """Cycles numbered by half turns or by turns from any number, times rounded to ms, some sweeps
    missing, and as a spreadsheet saves it where the decimal mark is a comma."""
    rng = np.random.default_rng(first + 1000)
    rows = [
        (
            1,
            first + step * k,
            d,
            round(begin + k / 30 + 1e-4 * d, 3),
            round(rng.uniform(-1.5, 1.5), 6),
        )
        for k in range(40)
        for d in range(4)
        if k not in missing
    ]
    lines = [HEADER, *(f"slave,{','.join(map(repr, row))}" for row in rows)]
    text = "\n".join(lines)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.csv"
        path.write_text(text.replace(",", ";").replace(".", ",") if comma else text)
        hits, _ = read_angles(path)
    columns = hits.axis, hits.cycle, hits.diode, hits.time_s, hits.angle_rad
    assert sorted(zip(*(x.tolist() for x in columns), strict=True)) == sorted(rows)
    assert (hits.station == 1).all() and (np.diff(hits.time_s) >= 0).all()


# Second generation


def of_turns(tmp_path: Path, change: tuple[str, str] = ("", ""), kind: str = "angles-csv") -> Path:
    """Angles, or counts, of six diodes before the stations of channels 3 and 12, and the board."""
    lines = ["generation,station,axis,cycle,diode,time_s,angle_rad"]
    counts = ["time_s,channel,diode,count_1,count_0"]
    for channel in (12, 3):
        period = PERIOD_S[channel]
        for turn in range(40):
            for diode in range(6):
                angles = [0.02 * diode + 0.1, 0.03 * diode - 0.2]
                part = [
                    (angle + ahead) / (2 * np.pi)
                    for angle, ahead in zip(angles, PLANE_RAD, strict=True)
                ]
                when = [period * (turn + one) for one in part]
                head = f"2,{channel}", f"{turn},{diode}"
                lines += [f"{head[0]},{p},{head[1]},{when[p]},{angles[p]}" for p in (0, 1)]
                first, second = (round(6e6 * period * one) for one in part)
                counts.append(f"{when[0]},{channel},{diode},{first},{second}")
    text = "\n".join(lines if kind == "angles-csv" else counts).replace(*change) + "\n"
    (path := tmp_path / "angles.csv").write_text(text)
    places = "".join(f"0,{k % 3 / 20},{k // 3 / 20},0.8,0,-0.6\n" for k in range(6))
    (tmp_path / "board.csv").write_text("x_m,y_m,z_m,nx,ny,nz\n" + places)
    return path


@pytest.mark.parametrize("kind", ["angles-csv", "lfsr-counts"])
def test_angles_and_counts_of_the_second_generation(tmp_path: Path, kind: str) -> None:
    """Stations by rising channel; counts to half a count of 52 urad."""
    found = decode(of_turns(tmp_path, kind=kind), kind, tmp_path / "board.csv")
    assert found.generation == 2 and [one.channel for one in found.stations] == [3, 12]
    hits = found.hits
    expected = np.where(hits.axis == 0, 0.02 * hits.diode + 0.1, 0.03 * hits.diode - 0.2)
    assert np.abs(hits.angle_rad - expected).max() < (1e-9 if kind == "angles-csv" else 3e-5)
    assert len(hits) == 2 * 2 * 40 * 6 and hits.cycle.max() == 39
    np.testing.assert_allclose(found.normals, [[0.8, 0, -0.6]] * 6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("2,12,0,0,0,", "1,12,0,0,0,"), "generation is '2'; expected 1 in all"),
        (("2,12,", "2,16,"), "station is '16'; expected a channel"),
        (("2,12,0,1,", "2,12,0,0,"), "occur again"),
    ],
)
def test_bad_angles_of_the_second_generation(
    tmp_path: Path, change: tuple[str, str], message: str
) -> None:
    with pytest.raises(Refusal, match=message):
        decode(of_turns(tmp_path, change), "angles-csv", tmp_path / "board.csv")


def test_counts_by_a_coarse_clock_and_of_two_recordings(tmp_path: Path) -> None:
    """Times of whole milliseconds lose no turn; a second recording is none of the first."""
    path = of_turns(tmp_path, kind="lfsr-counts")
    head, *rows = path.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    coarse = [",".join([f"{float(t):.3f}", *rest]) for t, *rest in cells]
    path.write_text("\n".join([head, *coarse, ""]))
    assert len(decode(path, "lfsr-counts", tmp_path / "board.csv").hits) == 2 * 2 * 40 * 6
    other = [f"{float(t) + 0.005},{c},{d},{int(a) + 99},{int(b) + 99}" for t, c, d, a, b in cells]
    path.write_text("\n".join([head, *rows, *other, ""]))
    with pytest.raises(Refusal, match="480 of 960 rows have the turn and diode of another row"):
        decode(path, "lfsr-counts", tmp_path / "board.csv")
