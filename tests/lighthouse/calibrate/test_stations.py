"""Any number of stations, from hits to pose.json, tracking and the files of other programs."""

import numpy as np
import pytest
import yaml

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.pose_file import (
    chosen_pose,
    is_network,
    matrix_and_metres,
    pairs,
    read_pose_json,
)
from mocap_metrology.lighthouse.assess.summary import Summary, summary
from mocap_metrology.lighthouse.calibrate.jansen import calibrate
from mocap_metrology.lighthouse.calibrate.scene import Sensors
from mocap_metrology.lighthouse.calibrate.stages import Calibration
from mocap_metrology.lighthouse.decode.factory_file import read_factory
from mocap_metrology.lighthouse.export.formats import Export, crazyflie_yaml, libsurvive_json
from mocap_metrology.lighthouse.records import Station
from mocap_metrology.present.text.calibration import pose_document
from tests.lighthouse.batch.planes_scene import Made, made

CHANNELS = (3, 7, 11, 14)


def told(given: Made) -> list[Station]:
    """What the light says: channels, ids, factory values."""
    known = zip(CHANNELS, given.scene.factories, strict=False)
    return [
        Station(str(k), 100 + k, factory=own, generation=2, channel=k, frames_found=1)
        for k, own in known
    ]


def calibrated(given: Made, sensors: Sensors | None = None) -> tuple[Calibration, Summary]:
    scene, stations = given.scene, told(given)
    factories = [station.factory for station in stations]
    found = calibrate(
        scene.hits, scene.board, factories, sensors=sensors or Sensors(), stations=stations
    )
    return found, summary(found, stations, duration_s=6.0)


@pytest.fixture(scope="module")
def three() -> tuple[Made, Calibration, Summary]:
    given = made(3, 2, 6.0)
    return given, *calibrated(given)


def test_pose_of_every_station_is_written_and_read(three, tmp_path) -> None:
    """Within three standard deviations, with the covariance of all together."""
    given, _, result = three
    write_json(tmp_path / "pose.json", pose_document(result))
    read = read_pose_json(tmp_path / "pose.json")
    assert is_network(read) and read["reference"] == "3"
    assert read["chosen"] == {"7": 0, "11": 1} and read["covariance_joint_stations"] == ["7", "11"]
    assert read["stations"]["11"] == {"id": 111, "mode": "11"}
    standing = {one["variant"]: one["standing"] for one in read["variants"]}
    assert standing == {"libsurvive": "chosen", "crazyflie": "worse"}
    assert read["verdict"]["word"] == "good", read["verdict"]["reason"]
    joint = np.array(read["covariance_joint"])
    off = []
    for k, (name, one) in enumerate(pairs(read).items()):
        entry = chosen_pose(one)
        assert entry is not None and entry["station"] == name and entry["optics"] == "factory"
        (R, t), (R0, t0) = matrix_and_metres(entry), given.poses[k + 1]
        off += [*(1e3 * (t - t0)), *np.degrees(rotation.error(R, R0))]
        own = slice(6 * k, 6 * k + 6)
        np.testing.assert_allclose(joint[own, own], entry["covariance"], rtol=1e-6, atol=1e-9)
        assert entry["halves"]["m2"] < 22.5
    assert np.array(off) @ np.linalg.solve(joint, off) < 12 + 3 * np.sqrt(24)


def test_a_station_without_a_common_view_has_no_pose(tmp_path) -> None:
    """The reason says what would connect it; the others have one."""
    early, late = (0.0, 0.5), (0.55, 1.0)
    given = made(4, 2, 5.0, keep=[early, early, early, late])
    _, result = calibrated(given)
    write_json(tmp_path / "pose.json", pose_document(result))
    read = read_pose_json(tmp_path / "pose.json")
    assert read["chosen"] == {"7": 0, "11": 1, "14": None}
    assert chosen_pose(pairs(read)["14"]) is None
    assert read["verdict"]["word"] == "usable"
    assert "Station 14 shares no view of the board with 3, 7, 11: move" in read["verdict"]["reason"]


def test_without_any_common_view_it_is_refused() -> None:
    given = made(2, 2, 4.0, keep=[(0.0, 0.45), (0.55, 1.0)])
    with pytest.raises(Refusal, match="no two of the stations 3, 7 see four diodes"):
        calibrated(given)


def test_files_of_other_programs(three, tmp_path) -> None:
    given, _, _ = three
    stations = told(given)
    export = Export(stations, [(R, t) for R, t in given.poses], ["Twin."])
    text = crazyflie_yaml(export)
    read = yaml.safe_load(text)
    assert read["systemType"] == 2 and list(read["geos"]) == list(read["calibs"]) == [3, 7, 11]
    assert read["geos"][7]["origin"] == pytest.approx(given.poses[1][1].tolist(), abs=1e-11)
    for name, content in (("a.yaml", text), ("a.json", libsurvive_json(export))):
        (tmp_path / name).write_text(content, encoding="utf-8")
        for own, station in zip(read_factory(tmp_path / name), stations, strict=True):
            assert (own.id, own.channel, own.generation) == (station.id, station.channel, 2)
            for key in ("phase", "tilt", "curve", "gibphase", "gibmag", "ogeephase", "ogeemag"):
                expected = getattr(station.factory, key)
                np.testing.assert_allclose(getattr(own.factory, key), expected, atol=1e-9)
