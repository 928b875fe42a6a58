"""What was recorded beside a recording: responses, holes, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.text.covariate import read_covariate
from mocap_metrology.noise.changes.covariate import Covariate, coherence_row

RATE = 100.0
SERIES = np.random.default_rng(1).normal(0, 0.01, 12_000)
ROOM = Covariate("room", np.arange(121.0), np.random.default_rng(2).normal(20, 1, 121))


@pytest.mark.parametrize("offset_s", [0.0, 7.3, -4.6])
def test_a_row_is_the_coherence_of_means_over_blocks(offset_s: float) -> None:
    """Of the common time; means of the covariate are those of straight lines through its samples,
    here sums over a fine grid."""
    room = Covariate("room", ROOM.time_s + offset_s, ROOM.values)
    row = coherence_row(SERIES, RATE, room, 0.01)
    first, last = max(offset_s, 0.0), min(offset_s + 120, 120.0)
    assert (row["from_s"], row["to_s"]) == (pytest.approx(first), pytest.approx(last))
    start, count = round(first * RATE), int(round((last - first) * RATE) // 100)
    means = SERIES[start : start + 100 * count].reshape(count, 100).mean(axis=1)
    fine = first + (np.arange(1000 * count) + 0.5) / 1000
    beside = np.interp(fine, room.time_s, room.values).reshape(count, 1000).mean(axis=1)
    length = 2 * count // 9 // 2 * 2
    f, squared = signal.coherence(beside, means, 1.0, nperseg=length, detrend="linear")
    at = int(np.argmin(np.abs(f - 1 / row["period_s"])))
    assert row["period_s"] == pytest.approx(1 / f[at])
    assert row["coherence"] == pytest.approx(squared[at], rel=1e-3)
    assert row["word"] == "unrelated" and np.isnan([row["gain_mm_per_unit"], row["lag_s"]]).all()


@pytest.mark.parametrize("sensor", ["slow", "noisy", "of any unit", "with a hole"])
def test_what_goes_with_temperature_is_found(sensor: str) -> None:
    """9 h, 0.004 mm per degree, 200 s behind, in a random walk: gain to 10 %, lag to 60 s. Noise of
    the sensor, of four times the swing, averages out (of single samples, one a block, the gain
    would be half); a tenth of the covariate may be missing."""
    rng, rate, n = np.random.default_rng(6), 2.0, 9 * 3600 * 2
    time = np.arange(n) / rate

    def swing(t: np.ndarray) -> np.ndarray:
        return np.sin(2 * np.pi * t / 3300) + 0.3 * np.sin(2 * np.pi * t / 1370)

    series = 0.004 * swing(time - 200) + 0.01 * rng.standard_normal(n)
    series += 2e-5 * np.cumsum(rng.standard_normal(n))
    at = time[::2] if sensor == "noisy" else time[::120]
    if sensor == "with a hole":
        at = at[(at < 9000) | (at > 10_000)]
    unit = 1e300 if sensor == "of any unit" else 1.0
    noise = 4 * rng.standard_normal(at.size) if sensor == "noisy" else 0.0
    row = coherence_row(series, rate, Covariate("t", at, unit * (swing(at) + noise)), 0.01)
    assert row["word"] == "goes with it" and ("note" in row) is (sensor == "with a hole")
    assert row["gain_mm_per_unit"] * unit == pytest.approx(0.004, rel=0.1)
    assert row["lag_s"] == pytest.approx(200, abs=60)


def test_one_step_in_each_is_no_coherence() -> None:
    """White noise with a step, and a door that was opened once: of 120 pairs in an hour, an eighth
    have both in one window (14 were coherent by their power)."""
    rng, time, found = np.random.default_rng(1), np.arange(0, 3600, 10.0), 0
    for _ in range(120):
        series = 0.02 * rng.standard_normal(36_000)
        series[rng.integers(series.size) :] += 0.1
        door = (time > rng.uniform(0, 3600)) + 0.02 * rng.standard_normal(time.size)
        found += (
            coherence_row(series, 10.0, Covariate("t", time, door), 0.01)["word"] != "unrelated"
        )
    assert found <= 4


def with_hole(first: float, last: float) -> Covariate:
    there = (ROOM.time_s <= first) | (ROOM.time_s >= last)
    return Covariate(ROOM.name, ROOM.time_s[there], ROOM.values[there])


@pytest.mark.parametrize(
    ("first", "last", "gap", "share", "refused"),
    [
        (40, 43, (0, 0), None, ""),  # three steps
        (40, 44, (0, 0), "3.3", ""),
        (40, 52, (0, 0), "10", ""),
        (40, 70, (0, 0), "25", ""),
        (40, 71, (0, 0), "", "a quarter of the common time is a gap of room"),
        (40, 52, (40, 52), "10", ""),
        (40, 53, (40, 53), "", "a tenth of the common time is a gap of the markers and of room"),
        (44, 57, (40, 56), "11", ""),
        (0, 0, (40, 70), None, ""),
        (0, 0, (40, 71), "", "a quarter of the common time is a gap of the markers"),
    ],
)
def test_holes_are_reported_or_refused(first, last, gap, share, refused: str) -> None:
    gappy = SERIES.copy()
    gappy[round(gap[0] * RATE) : round(gap[1] * RATE)] = np.nan
    if refused:
        with pytest.raises(Refusal, match=refused):
            coherence_row(gappy, RATE, with_hole(first, last), 0.01)
        return
    row = coherence_row(gappy, RATE, with_hole(first, last), 0.01)
    assert coherence_row(SERIES[:3600], RATE, ROOM, 0.01)["to_s"] == 36  # steps are enough
    note = f"room has no samples in {share} % of the common time (gaps of more than 3 steps): "
    assert row.get("note") == (note + "interpolated linearly" if share else None)


CONSTANT = np.where(np.arange(12_000) % 97 == 0, np.nan, 100.1)
TIME = np.arange(0.0, 121.0)


@pytest.mark.parametrize(
    ("series", "covariate", "why"),
    [
        (SERIES, Covariate("t", 1000 + TIME, TIME), "the recording of 0 to 120 s; expected times"),
        (SERIES, Covariate("t", -500 + TIME, TIME), "t is of -500 to -380 s, the recording of 0"),
        (SERIES, Covariate("t", 120 + TIME, TIME), "the recording of 0 to 120 s; expected times"),
        (SERIES, Covariate("t", TIME, 0 * TIME + 20.1), "t stays at 20.1: nothing"),
        (CONSTANT, ROOM, r"the series never changes \(100.1 mm\)"),
        (SERIES[:200], Covariate("t", 10 * TIME, TIME), "0 steps of 10 s in the 2 s that t"),
        (SERIES[:3500], ROOM, "35 steps of 1 s in the 35 s that room shares with the recording; "
         "expected 36 or more"),
        (SERIES[:30], Covariate("t", TIME / 1000, TIME), "30 steps of 0.01 s in the 0.12 s"),
    ],
    ids=range(8),
)  # fmt: skip
def test_what_cannot_be_compared_is_refused(series, covariate: Covariate, why: str) -> None:
    if "30 steps" in why:
        covariate = Covariate("t", np.arange(0, 1, 0.001), np.arange(1000) % 7)
        why = "30 steps of 0.01 s in the 0.3 s"
    with pytest.raises(Refusal, match=why):
        coherence_row(series, RATE, covariate, 0.01)


def written(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "room.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
def test_encodings_blank_lines_quotes_and_empty_cells(tmp_path: Path, encoding: str) -> None:
    lines = ['"time_s","temp_°C",', "", "0,20.5,,", " 60 , 21 ", ",", "1.2e2,-.5"]
    ends = "\r\n" if encoding == "latin-1" else "\n"
    found = Covariate(*read_covariate(written(tmp_path, ends.join(lines) + ends, encoding)))
    assert found.name == "temp_°C"
    assert found.time_s.tolist() == [0, 60, 120] and found.values.tolist() == [20.5, 21, -0.5]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("time_s,t\n0,0,20\n1,10,21\n", ": line 2 has 3 cells, expected 2"),
        ("time_s,t\n0,20\n10\n", ": line 3 has 1 cells, expected 2"),
        ("time_s,t\n0,20\n\n\n10,x\n", ": line 5: expected two numbers"),
        ("time_s,t\n0,20\n10,\n", ": line 3: expected two numbers"),
        ("time_s,t\n0,20\n10,1e999\n", ": line 3: expected two numbers"),
        ("time_s,t\n0,20\n10,2_1\n", ": line 3: expected two numbers"),
        ("time_s,t\n0,1\n\n9,1\n8,2\n", ": line 5: time_s must increase, 8 follows 9"),
        ("time_s,t\n0,1\n0,2\n", ": line 3: time_s must increase"),
        ("time_s,t\n0,20\n", ": 1 lines of numbers; expected two or more"),
        ("time_s|t\n0|20\n", ": columns time_s|t; expected time_s and one other, with a comma"),
        ("time_s,t,u\n0,1,2\n", ": columns time_s, t, u; expected time_s and one other"),
        ("t,c\n0,1\n", ": columns t, c; expected time_s and one other"),
        ("\0\1\2", ": is not a CSV file of time_s and one other column: it looks like a binary"),
        ("", ": is empty, expected a CSV file of time_s and one other column"),
        ("\n,\n", ": columns ; expected time_s and one other"),
        ("time_s,\n0,1\n1,2\n", ": columns time_s, ; expected time_s and one other"),
    ],
)
def test_files_that_are_refused(tmp_path: Path, text: str, why: str) -> None:
    with pytest.raises(Refusal) as caught:
        read_covariate(written(tmp_path, text))
    assert str(caught.value).startswith(f"room.csv{why}")
