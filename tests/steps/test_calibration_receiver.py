"""Motion capture of a receiver as a check of a calibration: files to receiver.json."""

import json
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.calibration.receiver import receiver
from mocap_metrology.calibration.sweeps import paths_in
from mocap_metrology.calibration.tables import RECEIVER, TABLES
from mocap_metrology.cli import main
from mocap_metrology.common.files import write_json
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.rotation import exp
from mocap_metrology.lighthouse.simulate.turns import (
    TurnsTwin,
    simulate_turns,
    stations_around,
    write_rec,
)
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from tests.steps.test_calibration_bar import (  # noqa: F401
    SETTINGS,
    calibrate,
    entry_of,
    undrawn,
    write_stations,
)

TURN, SHIFT_MM, OFFSET_S, RATE_HZ = (
    exp(np.array([1.5, 0.2, -0.3])), [900.0, -300.0, 1200.0], 1.7, 150.0,
)  # fmt: skip
LEVERS_M = np.array([[0.0, 0.03, 0.09], [0.04, -0.03, 0.07], [-0.05, -0.02, 0.08]])


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three stations and an object with three markers, seen by motion capture too."""
    folder = tmp_path_factory.mktemp("receiver")
    R, t, middle, up = stations_around(3, np.random.default_rng(7))
    motion = MotionTwin(centre_m=tuple(middle), speed_m_s=0.6, extent_m=0.6, wobble_deg=15)
    twin = TurnsTwin(7, R, t, (1, 4, 9), motion, duration_s=3.5, up=up, cover_mm=(-0.8, 1.6))
    made = simulate_turns(twin)
    write_rec(folder / "a.rec.gz", made)
    write_stations(folder, made)
    time_s = np.arange(int(8 * RATE_HZ)) / RATE_HZ - OFFSET_S
    turns, place = made.motion.poses(time_s)
    frames = 1e3 * (place[:, None] + np.einsum("nij,mj->nmi", turns, LEVERS_M)) @ TURN.T + SHIFT_MM
    frames += 0.2 * np.random.default_rng(1).normal(size=frames.shape)
    frames = frames.astype(np.float32)
    write_c3d(folder / "take.c3d", ["A", "B", "C"], RATE_HZ, [frames], len(frames))
    write_c3d(folder / "other.c3d", ["A", "B", "C"], RATE_HZ, [frames[::-1].copy()], len(frames))
    calibrate(folder, "a", "a", "T20")
    return folder


def judged(
    folder: Path, file: str = "take.c3d", labels: tuple[str, ...] = (), **given: str
) -> dict:
    own = folder / "a"
    paths = paths_in(TABLES, own) | given
    output = str(own / RECEIVER["receiver"])
    return receiver(
        entry_of(folder, "a", "a", "T20"), str(folder / file), labels, paths, SETTINGS, output
    )


def test_path_and_stations_agree_with_motion_capture(lab: Path) -> None:
    found = judged(lab)
    assert json.loads((lab / "a/receiver.json").read_text()) == found
    assert found["motion_capture"]["labels"] == ["A", "B", "C"]
    # The clock of the light begins with its first line
    assert found["clock"]["offset_s"] == pytest.approx(OFFSET_S, abs=0.03)
    assert found["clock"]["offset_sd_s"] < 2e-4
    assert found["place_mm"]["rms"] < 2.0 and found["attitude_deg"]["rms"] < 0.5
    # The cover of the diodes is known to 0.4 mm, which is 0.3 % of the board
    assert abs(found["scale_ppm"]) < 6000
    for label, lever in zip("ABC", LEVERS_M, strict=True):
        np.testing.assert_allclose(found["lever_mm"][label]["value"], 1e3 * lever, atol=2.5)
    assert list(found["stations"]) == ["1", "4", "9"]
    for name in ("4", "9"):
        one = found["stations"][name]
        assert one["agrees"] and one["shift_deg"] < 0.3
        assert one["shift_mm"] < 4 * one["sd_mm"] and one["sd_resection_mm"] < one["sd_mm"]
    assert "Station 4 is" in found["sentence"] and "Station 1" not in found["sentence"]


def test_a_station_that_is_wrong_in_the_calibration_is_found(lab: Path, tmp_path: Path) -> None:
    """One marker is enough: station 9 is moved by 30 mm in the file that the board is tracked
    with, and motion capture has it where it was."""
    document = json.loads((lab / "a/pose.json").read_text())
    moved = document["poses"][document["chosen"]["9"]]
    moved["translation_mm"][0] += 30.0
    write_json(tmp_path / "pose.json", document)
    found = judged(lab, labels=("B",), pose=str(tmp_path / "pose.json"))
    one = found["stations"]["9"]
    assert one["difference_mm"][0] == pytest.approx(30.0, abs=4 * one["sd_mm"])
    assert not one["agrees"] and "more than chance explains" in found["sentence"]
    assert found["stations"]["4"]["agrees"]


@pytest.mark.parametrize(
    ("file", "labels", "why"),
    [("other.c3d", (), "expected one motion, recorded by both"), ("take.c3d", ("D",), "D")],
)
def test_other_recordings_are_refused(lab: Path, file: str, labels: tuple, why: str) -> None:
    assert why in judged(lab, file, labels)["refused"]


@pytest.mark.usefixtures("undrawn")
def test_the_command(lab: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    given = ["--board", "T20", "--factory", str(lab / "stations.json")]
    seen = ["--receiver", str(lab / "take.c3d"), "--receiver-labels", "A;B"]
    out = ["--output", str(tmp_path / "out")]
    assert main.main(["check", str(lab / "a.rec.gz"), *given, *seen, *out]) == 0
    assert "Against motion capture of A, B" in capsys.readouterr().out
    assert json.loads((tmp_path / "out/receiver.json").read_text())["attitude_deg"] is None
