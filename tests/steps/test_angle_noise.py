"""Noise of the angles of a board at rest: Allan deviations in closed form, from simulated hits."""

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.calibration.angle_noise import MOVED, UNKNOWN, still_angles, write_angle_noise
from mocap_metrology.common.files import read_table
from mocap_metrology.lighthouse.assess.rows import ANGLE_HEAD, angle_rows
from mocap_metrology.lighthouse.decode.chain import Decoded, decode
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, MotionTwin, StationTwin
from mocap_metrology.settings import Allan

COMMON, INDEPENDENT, SECONDS = 53e-6, 30e-6, 30.0
NAMED = {"calibration": "desk", "setup": "room", "source": "twin"}
ROTORS = ("master_azimuth", "master_elevation", "slave_azimuth", "slave_elevation")


@pytest.fixture(scope="module")
def hits() -> Hits:
    """Half a minute of a board at rest: 53 urad in common to a sweep, 30 urad of each hit, one hit
    in five missing."""
    slave = StationTwin(id=2, mode="c", position_m=(0.5, 2.5, 0.3), rotation_deg=(5, 4, -40))
    return simulate(
        LighthouseTwin(
            seed=3,
            duration_s=SECONDS,
            master=StationTwin(id=1, mode="b"),
            slave=slave,
            motion=MotionTwin(pattern="still", centre_m=(3.0, 0.8, 0.2)),
            common_urad=1e6 * COMMON,
            independent_urad=1e6 * INDEPENDENT,
            dropout=0.2,
        )
    ).hits


def written(
    path: Path, hits: Hits, still: bool | None = True, resolution_s: float | None = 1 / 48e6
):
    write_angle_noise(str(path), hits, still, resolution_s, Allan(), {"recording": "desk"})
    return read_table(path)


def test_white_noise_of_both_parts(hits: Hits, tmp_path: Path) -> None:
    """900 sweeps: ADEV = sigma / sqrt(m), each within 4 standard errors, and 68 % intervals that
    hold it at one sweep in most rotors; the common part alone, not with 1/n of the other."""
    allan, origin = written(tmp_path / "allan.parquet", hits)
    assert list(allan)[:6] == ["series", "estimator", "m", "tau_s", "avar_rad2", "adev_rad"]
    assert {"adev_lower_rad", "adev_upper_rad", "n_terms", "edf"} <= set(allan)
    assert [rotor["rotor"] for rotor in origin["rotors"]] == list(ROTORS)
    for rotor in ROTORS:
        for part, sigma in (("common", COMMON), ("independent", INDEPENDENT)):
            own = (allan["series"] == f"{rotor}_{part}") & (allan["m"] <= 10)
            ratio = allan["adev_rad"][own] * np.sqrt(allan["m"][own]) / sigma
            error = 1 / np.sqrt(2 * allan["edf"][own])
            assert (np.abs(ratio - 1) < 4 * error).all(), (rotor, part)
            assert allan["tau_s"][own][0] == pytest.approx(1 / 30)
        own = (allan["series"] == f"{rotor}_3") & (allan["m"] == 1)
        assert allan["adev_rad"][own] == pytest.approx(np.hypot(COMMON, INDEPENDENT), rel=0.12)
    rows = angle_rows(NAMED, allan, origin)
    assert [tuple(row) for row in rows] == [ANGLE_HEAD] * 4
    for rotor, row in zip(ROTORS, rows, strict=True):
        best = np.argmin(np.where(allan["series"] == f"{rotor}_common", allan["adev_rad"], np.inf))
        least = row["common_adev_min_urad"], row["common_tau_min_s"]
        assert least == pytest.approx((1e6 * allan["adev_rad"][best], allan["tau_s"][best]))
        assert row["independent_exponent"] == 0
        assert row["sd_urad"] == pytest.approx(1e6 * np.hypot(COMMON, INDEPENDENT), rel=0.1)
        assert row["independent_adev_1_urad"] == pytest.approx(30, rel=0.03)
        assert row["independent_h_0_urad2_hz"] == pytest.approx(2 * 30**2 / 30, rel=0.06)
        ends = row["common_adev_1_lower_urad"], row["common_adev_1_upper_urad"]
        assert ends[0] < row["common_adev_1_urad"] < ends[1]


def test_a_spread_below_the_step_of_the_clock_is_reported(hits: Hits, tmp_path: Path) -> None:
    """61 urad are below the 188 urad of 2 MHz, and not below the 8 urad of 48 MHz."""
    hits = hits.take(hits.diode < 3)
    _, fine = written(tmp_path / "fine.parquet", hits)
    _, coarse = written(tmp_path / "coarse.parquet", hits, resolution_s=0.5e-6)
    _, unknown = written(tmp_path / "unknown.parquet", hits, resolution_s=None)
    for rotors, below in ((fine, False), (coarse, True), (unknown, None)):
        assert {rotor["below_step"] for rotor in rotors["rotors"]} == {below}
        assert {rotor["independent_below_step"] for rotor in rotors["rotors"]} == {below}
    assert coarse["rotors"][0]["step_rad"] == pytest.approx(188.5e-6, rel=1e-3)
    assert fine["rotors"][0]["sd_rad"] == pytest.approx(np.hypot(COMMON, INDEPENDENT), rel=0.1)


def test_a_real_headset(headset: dict[str, Decoded], tmp_path: Path) -> None:
    """`lh1_test_cal`: what the diodes share is 15 to 21 urad at one sweep and not white, the
    independent part is 3.7 to 5.8 urad, white, and below the step of the clock."""
    rows = angle_rows(NAMED, *written(tmp_path / "allan.parquet", headset["HMD"].hits))
    assert len(rows) == 4
    for row in rows:
        assert 14 < row["common_adev_1_urad"] < 23 and row["common_exponent"] < 0
        assert 3.5 < row["independent_adev_1_urad"] < 6 and row["independent_exponent"] == 0
        assert (row["below_step"], row["independent_below_step"]) == (False, True)


def test_a_board_that_moved_has_no_rows_but_a_reason(hits: Hits, tmp_path: Path) -> None:
    allan, origin = written(tmp_path / "moved.parquet", hits, still=False)
    assert allan["adev_rad"].size == 0 and origin["reason"] == MOVED
    _, refused = written(tmp_path / "refused.parquet", hits, still=None)
    assert refused["reason"] == UNKNOWN
    assert angle_rows(NAMED, allan, origin) == []


def test_one_diode_has_no_parts(hits: Hits, tmp_path: Path) -> None:
    alone = hits.take(hits.diode == 3)
    allan, origin = written(tmp_path / "one.parquet", alone)
    assert set(allan["series"]) == {f"{rotor}_3" for rotor in ROTORS}
    row = angle_rows(NAMED, allan, origin)[0]
    assert (row["common_adev_1_urad"], row["independent_below_step"]) == (None, None)
    few = alone.take(np.arange(len(alone)) % 8 == 0)
    assert list(still_angles(few)) == []
    assert "half of the sweeps" in written(tmp_path / "few.parquet", few)[1]["reason"]


def test_planes_of_the_second_generation(tmp_path: Path) -> None:
    """White noise of 20 urad in common and 10 urad of each hit, one sweep a turn of 1/52 s."""
    rng, n, d = np.random.default_rng(4), 1500, 5
    turn, diode, axis = (k.ravel() for k in np.meshgrid(*map(np.arange, (n, d, 2)), indexing="ij"))
    noise = 2e-5 * rng.standard_normal((n, 2))[turn, axis] + 1e-5 * rng.standard_normal(turn.size)
    station = np.zeros(turn.size, np.int8)
    time_s = (turn + (1 + axis) / 3) / 52
    hits = Hits(station, axis.astype(np.int8), turn, diode, time_s, 0.1 * diode + noise, noise)
    told = {"stations": ["3", "7"], "generation": 2}
    path = str(tmp_path / "allan.parquet")
    write_angle_noise(path, hits, True, 1 / 96e6, Allan(), told)
    allan, origin = read_table(path)
    assert [rotor["rotor"] for rotor in origin["rotors"]] == ["3_plane0", "3_plane1"]
    for rotor in origin["rotors"]:
        assert rotor["rate_hz"] == pytest.approx(52)
        assert rotor["step_rad"] == pytest.approx(2 * np.pi * 52 / 96e6)
        for part, sigma in (("common", 2e-5), ("independent", 1e-5)):
            own = (allan["series"] == f"{rotor['rotor']}_{part}") & (allan["m"] <= 10)
            ratio = allan["adev_rad"][own] * np.sqrt(allan["m"][own]) / sigma
            assert (np.abs(ratio - 1) < 4 / np.sqrt(2 * allan["edf"][own])).all()


def test_a_real_controller_before_stations_of_the_second_generation(
    samples: Path, tmp_path: Path
) -> None:
    """`lh2_test_cal`: turns of channels 6 and 10 last 941,000 and 919,000 ticks of 48 MHz."""
    found = decode(samples / "lighthouse2/lh2_test_cal.rec.gz", "libsurvive-rec", "T20", None)
    told = {"stations": [one.role for one in found.stations], "generation": 2}
    path = str(tmp_path / "allan.parquet")
    write_angle_noise(path, found.hits, True, found.pulses and 1 / 96e6, Allan(), told)
    _, origin = read_table(path)
    for rotor, ticks in zip(origin["rotors"], (941_000, 941_000, 919_000, 919_000), strict=True):
        assert 1 / rotor["rate_hz"] == pytest.approx(ticks / 48e6, rel=1e-4)
        assert 9e-6 < rotor["sd_rad"] < 18e-6
