"""What check.json and the origin of trajectories.parquet say of the unit, in a sheet's words."""

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.calibration.pose import reference_of
from mocap_metrology.calibration.sweeps import Entry as CalibrationEntry
from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.recording.clean import Entry, examine, read, refused, trajectories
from mocap_metrology.settings import Settings

SETTINGS = Settings()
NAMED = {"recording": "A", "source": "measured", "twin": None}


@pytest.fixture
def take(tmp_path: Path) -> Path:
    """Two markers 0.5 m apart, written in metres where the header says mm."""
    rng = np.random.default_rng(2)
    positions = rng.normal([[0.3, 0.4, 0.5], [0.8, 0.4, 0.5]], 5e-5, (500, 2, 3))
    write_c3d(tmp_path / "take.c3d", ["A", "B"], 100, [positions], 500)
    return tmp_path / "take.c3d"


def test_metres_are_refused_until_the_sheet_states_them(take: Path) -> None:
    with pytest.raises(Refusal) as caught:
        read(Entry([str(take)], ["A", "B"]), False)
    check = refused(caught.value, "write accept", "column unit of the sheet")
    assert not check["ok"]
    assert check["why"].endswith(
        "so they may be in metres: state the unit, m or mm (column unit of the sheet)"
    )
    entry = Entry([str(take)], ["A", "B"], unit="m")
    recording = read(entry, False)
    check, _ = examine(entry, recording, SETTINGS)
    assert (check["unit"], check["unit_source"], check["warnings"]) == ("m", "given", [])
    made = trajectories(recording, NAMED)
    assert (made.origin["file_units"], made.origin["unit_source"]) == ("m", "given")
    assert made.columns["x2_mm"].mean() == pytest.approx(800, abs=0.1)


def test_an_assumed_unit_is_warned_of(tmp_path: Path) -> None:
    positions = np.random.default_rng(3).normal(300, 0.05, (500, 1, 3))
    write_c3d(tmp_path / "take.c3d", ["A"], 100, [positions], 500, units="")
    entry = Entry([str(tmp_path / "take.c3d")], ["A"])
    recording = read(entry, False)
    check, _ = examine(entry, recording, SETTINGS)
    assert check["warnings"] == [
        "the file names no unit, so its coordinates are assumed to be in mm"
    ]
    assert trajectories(recording, NAMED).origin["unit_source"] == "assumed"


def test_a_reference_in_metres_names_its_own_column(tmp_path: Path) -> None:
    """Three markers on each of two housings, 2 m apart along x."""
    mount = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])
    lines = [f"{label},{x},{y},{z}" for label, (x, y, z) in zip("ABC", mount, strict=True)]
    lines += [f"{label},{x},{y},{z}" for label, (x, y, z) in zip("DEF", mount, strict=True)]
    (tmp_path / "mount.csv").write_text("\n".join(["label,x_m,y_m,z_m", *lines, ""]))
    still = np.concatenate([mount + np.array([x, 0.2, 0.1]) for x in (0.3, 2.3)])
    path = tmp_path / "housings.c3d"
    write_c3d(path, list("ABCDEF"), 100, [np.tile(still, (50, 1, 1))], 50)
    labels = {"reference_labels_master": ["A", "B", "C"], "reference_labels_slave": list("DEF")}
    given = str(path), str(tmp_path / "mount.csv")
    with pytest.raises(Refusal, match=r"m or mm \(column reference_unit of the sheet\)$"):
        reference_of(CalibrationEntry(**labels), *given)
    found = reference_of(CalibrationEntry(**labels, reference_unit="m"), *given)
    assert found is not None and np.allclose(found.t_m, [2, 0, 0], atol=1e-6)
