"""Gyroscope and accelerometer of a board from the files of one step to those of the next."""

import json
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.calibration.pose import write_poses
from mocap_metrology.calibration.setup import Member, write_setup
from mocap_metrology.calibration.sweeps import (
    Entry,
    decoded,
    with_sensors,
    write_decoded,
    write_twin,
)
from mocap_metrology.common.files import read_table, write_json
from mocap_metrology.lighthouse.records import inertial_of
from mocap_metrology.lighthouse.simulate.twin import (
    BoardTwin,
    InertialTwin,
    LighthouseTwin,
    MotionTwin,
    StationTwin,
)
from mocap_metrology.settings import Lighthouse

SETTINGS = Lighthouse(  # the scale of the board is known: sensors do not show it
    estimators=("batch", "paper-lm"), optics=("ideal",), world="master", board_scale_sd=0.0
)
FILES = {
    **{name: f"{name}.parquet" for name in ("pulses", "inertial", "sweeps", "poses", "track")},
    **{name: f"{name}.json" for name in ("truth", "stations", "pose", "libsurvive")},
    **{"board": "board.csv", "twin_board": "given.csv", "mount": "mount.csv", "dump": "dump"},
    **{"reference": "mocap.c3d", "crazyflie": "crazyflie.yaml", "ros2": "ros2.xml"},
}


def deck(seed: int, sensors: InertialTwin | None, seconds: float = 4.0) -> LighthouseTwin:
    return LighthouseTwin(
        seed=seed,
        master=StationTwin(id=1, mode="b"),
        slave=StationTwin(id=2, mode="c", position_m=(0.5, 2.5, 0.3), rotation_deg=(5, 4, -40)),
        motion=MotionTwin(centre_m=(3.0, 0.8, 0.2)),
        board=BoardTwin(columns=2, rows=2, width_m=0.03, height_m=0.015),
        inertial=sensors,
        duration_s=seconds,
        independent_urad=50.0,
    )


def calibrated(folder: Path, twin: LighthouseTwin, settings: Lighthouse) -> dict[str, str]:
    """Files of a calibration of the twin."""
    folder.mkdir(exist_ok=True)
    files = {name: str(folder / file) for name, file in FILES.items()}
    asked = Entry("deck", twin="deck")
    write_twin(twin, 0, files)
    found = decoded(asked, files | {"board": files["twin_board"]}, settings)
    write_decoded(asked, with_sensors(found, twin, 0), settings, files)
    given = {name: files[name] for name in ("sweeps", "inertial", "stations", "board", "truth")}
    write_poses(asked, settings, given, files)
    return files


def chosen(file: str) -> dict[str, object]:
    document = json.loads(Path(file).read_text(encoding="utf-8"))
    return document["poses"][document["chosen"]]


@pytest.mark.filterwarnings("error")
def test_sensors_are_used_where_the_settings_say_so(tmp_path: Path) -> None:
    """`inertial` halves the variance of a small board's calibration, `gravity` changes it, and
    what was found of the sensors is in the pose; without them, or without the setting, nothing."""
    of_board = InertialTwin(place_m=(0.0, 0.02, 0.01))
    files = calibrated(
        tmp_path / "with", deck(1, of_board), SETTINGS.model_copy(update={"inertial": True})
    )
    series = inertial_of(read_table(files["inertial"])[0])
    assert series is not None and len(series) == 4000
    assert series.place_m.tolist() == [0.0, 0.02, 0.01]
    used = chosen(files["pose"])
    found = used["details"]["inertial"]
    assert found["delay_ms"] == pytest.approx(3, abs=3)
    assert 5e-4 < found["gyro_noise_rad_s"] < 5e-3 < found["accel_noise_m_s2"] < 5e-2
    assert np.linalg.norm(found["gravity_m_s2"]) == pytest.approx(9.81, abs=0.1)

    given = {name: files[name] for name in ("sweeps", "inertial", "stations", "board", "truth")}
    write_poses(Entry("deck", twin="deck"), SETTINGS, given, files)
    without = chosen(files["pose"])
    assert without["details"]["inertial"] is None
    variance = [np.trace(np.array(one["covariance"])[:3, :3]) for one in (used, without)]
    assert variance[0] < 0.6 * variance[1]
    stations = json.loads(Path(files["stations"]).read_text(encoding="utf-8"))
    for station in stations:  # as a longer recording transmits it
        station["gravity"] = [0.0, 0.0, 1.0]
    write_json(files["stations"], stations)
    write_poses(
        Entry("deck", twin="deck"), SETTINGS.model_copy(update={"gravity": True}), given, files
    )
    assert chosen(files["pose"])["translation_mm"] != without["translation_mm"]


def test_sensors_of_all_recordings_of_a_setup(tmp_path: Path) -> None:
    """Each recording has sensors of its own; one without any is used all the same."""
    how = SETTINGS.model_copy(update={"inertial": True})
    members = []
    for k, sensors in enumerate((InertialTwin(), None)):
        files = calibrated(tmp_path / str(k), deck(k, sensors, 2.0), how)
        names = ("sweeps", "stations", "board", "pose", "inertial")
        members.append(Member(str(k), *(files[name] for name in names)))
    assert inertial_of(read_table(members[1].inertial)[0]) is None
    joined = write_setup("deck", members, how, str(tmp_path / "joined.json"))
    light = write_setup("deck", members, SETTINGS, str(tmp_path / "light.json"))
    sd = []
    for document in (joined, light):
        pose = document["poses"][document["chosen"]]
        sd.append(np.sqrt(np.trace(np.array(pose["covariance"])[:3, :3])))
    assert sd[0] < 0.9 * sd[1]
