"""What was recorded beside a recording: times and values that cannot be used."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.text.covariate import read_covariate
from mocap_metrology.noise.changes.covariate import Covariate, together

RATE = 100.0
SERIES = np.random.default_rng(1).normal(0, 0.01, 12_000)
ROOM = Covariate("room", np.arange(121.0), np.random.default_rng(2).normal(20, 1, 121))


@pytest.mark.parametrize("start", [1000.0, -500.0, 120.0])
def test_times_outside_the_recording_are_refused(start: float) -> None:
    covariate = Covariate("temperature_degC", start + np.arange(100.0), np.arange(100.0))
    with pytest.raises(
        Refusal, match=r"the recording of 0 to 120 s; expected times from its first"
    ):
        together(SERIES, RATE, covariate, 0.01)


def test_what_never_changes_is_refused() -> None:
    for level in (20.5, 20.1, 1e-3):  # not all of them sums of powers of two
        covariate = Covariate("temperature_degC", np.arange(121.0), np.full(121, level))
        with pytest.raises(Refusal, match=rf"temperature_degC stays at {level}: nothing"):
            together(SERIES, RATE, covariate, 0.01)


@pytest.mark.parametrize("level", [0.0, 3.0, 100.1])
def test_a_series_that_never_changes_is_refused(level: float) -> None:
    series = np.full(12_000, level)
    series[3000:3070] = series[5000:5100:3] = np.nan
    with pytest.raises(Refusal, match=rf"the series never changes \({level:g} mm\)"):
        together(series, RATE, ROOM, 0.01)


@pytest.mark.parametrize(
    ("duration_s", "step_s", "found"),
    [
        (2, 10, "0 steps of 10 s in the 2 s that"),
        (60, 60, "1 steps of 60 s in the 60 s that"),
        (35, 1, "35 steps of 1 s in the 35 s that"),
        (0.3, 0.001, "30 steps of 0.01 s in the 0.3 s that"),
    ],
)
def test_too_few_steps_are_refused_with_their_number(
    duration_s: float, step_s: float, found: str
) -> None:
    time = np.arange(0, 121 + step_s, step_s)
    covariate = Covariate("t", time, np.sin(time))
    with pytest.raises(Refusal) as caught:
        together(SERIES[: round(duration_s * RATE)], RATE, covariate, 0.01)
    assert str(caught.value) == (
        f"covariate: {found} t shares with the recording; expected 36 or more"
    )


def test_thirty_six_steps_are_enough() -> None:
    assert not coherent(together(SERIES[:3600], RATE, ROOM, 0.01))


def coherent(row: dict[str, Any]) -> bool:
    return row["coherence"] > row["threshold"]


def with_hole(first: float, last: float) -> Covariate:
    kept = (ROOM.time_s <= first) | (ROOM.time_s >= last)
    return Covariate(ROOM.name, ROOM.time_s[kept], ROOM.values[kept])


def test_a_hole_is_told() -> None:
    assert "note" not in together(SERIES, RATE, ROOM, 0.01)
    assert "note" not in together(SERIES, RATE, with_hole(40, 43), 0.01)
    row = together(SERIES, RATE, with_hole(40, 52), 0.01)
    assert row["note"] == (
        "room has no samples in 10 % of the common time (gaps of more than 3 steps): "
        "interpolated linearly"
    )
    with pytest.raises(Refusal, match="more than a quarter of the common time is a gap of room"):
        together(SERIES, RATE, with_hole(40, 71), 0.01)


def test_a_hole_where_the_markers_have_a_gap_too_may_be_a_tenth() -> None:
    gappy = SERIES.copy()
    gappy[4000:5600] = np.nan
    together(gappy, RATE, ROOM, 0.01)
    together(gappy, RATE, with_hole(60, 76), 0.01)
    together(gappy, RATE, with_hole(44, 56), 0.01)
    with pytest.raises(Refusal, match=r"a tenth .* markers and of room"):
        together(gappy, RATE, with_hole(40, 56), 0.01)


def test_a_response_is_found_across_a_hole() -> None:
    """0.02 mm per unit, with a tenth of the covariate missing: gain to 15 %."""
    time = np.arange(0, 601.0)
    kept = (time < 200) | (time > 260)
    covariate = Covariate("t", time[kept], np.sin(2 * np.pi * time[kept] / 75))
    at = np.arange(60_000) / RATE
    noise = np.random.default_rng(3).normal(0, 0.01, at.size)
    row = together(0.02 * np.sin(2 * np.pi * at / 75) + noise, RATE, covariate, 0.01)
    assert coherent(row) and row["note"]
    assert row["gain_mm_per_unit"] == pytest.approx(0.02, rel=0.15)


def test_a_hole_raises_no_false_alarms() -> None:
    """400 unrelated pairs at alpha = 0.05, a quarter of the covariate missing: 2 to 8 %."""
    rng = np.random.default_rng(11)
    time = np.arange(0, 361.0)
    kept = (time < 100) | (time > 188)
    false = 0
    for _ in range(400):
        walk = np.cumsum(rng.standard_normal(time.size))
        series = np.cumsum(rng.standard_normal(360))
        covariate = Covariate("t", time[kept], walk[kept])
        false += coherent(together(series, 1.0, covariate, 0.05))
    assert 0.02 < false / 400 < 0.08


@pytest.mark.parametrize("factor", [1e300, 1e-250])
def test_any_unit_will_do(factor: float) -> None:
    time = np.arange(0, 121.0)
    swing = np.sin(2 * np.pi * time / 20)
    series = 0.05 * np.sin(2 * np.pi * np.arange(12_000) / RATE / 20) + SERIES
    plain = together(series, RATE, Covariate("t", time, swing), 0.01)
    other = together(series, RATE, Covariate("t", time, factor * swing), 0.01)
    assert coherent(plain) and coherent(other)
    assert other["coherence"] == pytest.approx(plain["coherence"])
    assert other["gain_mm_per_unit"] == pytest.approx(plain["gain_mm_per_unit"] / factor)


def written(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "room.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_encodings_blank_lines_quotes_and_empty_cells(
    tmp_path: Path, encoding: str, ends: str
) -> None:
    lines = ['"time_s","temp_°C",', "", "0,20.5,,", " 60 , 21 ", ",", "1.2e2,-.5"]
    found = Covariate(*read_covariate(written(tmp_path, ends.join(lines) + ends, encoding)))
    assert found.name == "temp_°C"
    assert found.time_s.tolist() == [0, 60, 120]
    assert found.values.tolist() == [20.5, 21, -0.5]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("time_s,t\n0,0,20\n1,10,21\n", ": line 2 has 3 cells, expected 2"),
        ("time_s,t\n0,20,5\n10,21,6\n", ": line 2 has 3 cells, expected 2"),
        ("time_s,t\n0,20\n10\n", ": line 3 has 1 cells, expected 2"),
        ("time_s,t\n0,20\n\n\n10,x\n", ": line 5: expected two numbers"),
        ("time_s,t\n0,20\n10,\n", ": line 3: expected two numbers"),
        ("time_s,t\n0,20\n10,1e999\n", ": line 3: expected two numbers"),
        ("time_s,t\n0,20\n10,2_1\n", ": line 3: expected two numbers"),
        ("time_s,t\n0,1\n\n9,1\n8,2\n", ": line 5: time_s must increase, 8 follows 9"),
        ("time_s,t\n0,20\n", ": 1 lines of numbers; expected two or more"),
        ("time_s|t\n0|20\n", ": columns time_s|t; expected time_s and one other, with a comma"),
        ("time_s,t,u\n0,1,2\n", ": columns time_s, t, u; expected time_s and one other"),
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


def test_utf_16_and_no_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(
        Refusal, match=r"room\.csv: is UTF-16 text, expected UTF-8: save it as UTF-8"
    ):
        read_covariate(written(tmp_path, "time_s,t\n0,1\n1,2\n", "utf-16"))
    with pytest.raises(Refusal, match=r"other\.csv: no such file"):
        read_covariate(tmp_path / "other.csv")
