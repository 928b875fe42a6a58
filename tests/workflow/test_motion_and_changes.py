"""Real takes of bodies that move or tell their orientation, and recordings held against each
other, through the workflow itself."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from running import write_sheet
from scipy.spatial.transform import Rotation

HEADER = [
    *("recording", "path", "markers", "group", "cluster", "compare_with", "date", "covariate"),
]
ROD = "c3dorg_sample15/FP1.C3D"  # markers along a stick, swung by hand
CHAIR = "kineticstoolkit/kinematics_racing_static.c3d"
CHAIR_MARKERS = "WheelchairFront;WheelchairRearR;WheelchairRearL"
ROBOT = "motive/timeanddoctor__parse_optitrack_csv/test.csv"  # a rigid body of Motive
POSES = "20201001_Exp1_measurementPoint10.txt"
TWINS = """twins:
  before: {coefficients: {all: {h_0: 1.0e-4}}, seed: 1, duration_s: 60}
  after: {coefficients: {all: {h_0: 0.5e-4}}, seed: 3, duration_s: 60}
"""


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture(scope="module")
def results(samples, root, snakemake, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("motion")
    (folder / "twins.yaml").write_text(TWINS, encoding="utf-8")
    time = np.arange(0, 61)
    lines = [f"{t},{20 + np.sin(t / 5):.4f}" for t in time]
    (folder / "room.csv").write_text("time_s,celsius\n" + "\n".join(lines) + "\n", "utf-8")
    data = samples
    sheet = write_sheet(
        folder,
        HEADER,
        {"recording": "rod", "path": str(data / "c3d" / ROD), "markers": "PT00;PT02", "group": "g"},
        {"recording": "chair", "path": str(data / "c3d" / CHAIR), "group": "g"}
        | {"markers": CHAIR_MARKERS, "cluster": CHAIR_MARKERS},
        {"recording": "tracker", "path": str(data / "static_vive_pose" / POSES), "group": "g"}
        | {"markers": "tracker"},
        {"recording": "robot", "path": str(data / "exports" / ROBOT), "group": "g"}
        | {"markers": "ernesto_body"},
        {"recording": "old", "path": "simulate:before", "group": "lab", "date": "2026-10-20"},
        {"recording": "new", "path": "simulate:after", "group": "lab", "date": "2026-11-20"}
        | {"covariate": "room.csv"},
    )
    out = folder / "results"
    wanted = [
        *("recordings/rod/place.csv", "recordings/chair/orientation.csv"),
        *("recordings/tracker/orientation.parquet", "tables/lab_compare.csv"),
        "recordings/robot/orientation.parquet",
        *("tables/lab_coherence.csv", "recordings/rod/allan.parquet"),
    ]
    done = snakemake(
        root,
        *("--cores", "2", *(str(out / name) for name in wanted), "--config"),
        *(f"recordings={folder / sheet}", "calibrations=", f"results={out}"),
        *(f"twins={folder / 'twins.yaml'}", "noise={estimators: [likelihood]}"),
    )
    assert done.returncode == 0, done.stdout
    return out


def test_length_of_a_stick_that_is_swung(results: Path) -> None:
    """It moves by decimetres; its length scatters by half a millimetre, and ADEV(L) says so."""
    cells = rows_of(results / "recordings/rod/place.csv")
    assert len(cells) >= 2
    assert all(0.01 < float(cell["sigma_mm"]) < 1 for cell in cells)
    allan = pq.read_table(results / "recordings/rod/allan.parquet").to_pandas()
    longest = allan.groupby("series")["adev_mm"].max()
    assert longest["x1"] > 30 and longest["L"] < 0.6


def test_orientation_of_a_rigid_frame_at_rest(results: Path) -> None:
    rows = rows_of(results / "recordings/chair/orientation.csv")
    assert [row["axis"] for row in rows] == ["rx", "ry", "rz"]
    assert all(float(row["adev_1_rad"]) < 2e-4 and row["note"] == "" for row in rows)
    assert 0.01 < float(rows[0]["residual_rms_mm"]) < 0.1


def test_orientation_of_a_tracker_is_that_of_its_file(results: Path, samples: Path) -> None:
    """The components' standard deviations, by numpy and scipy from the file itself."""
    table = pq.read_table(results / "recordings/tracker/orientation.parquet").to_pandas()
    raw = np.loadtxt(samples / "static_vive_pose" / POSES).reshape(-1, 3, 4)[:, :, :3]
    turns = Rotation.from_matrix(raw)
    theirs = (turns * turns.mean().inv()).as_rotvec().std(axis=0)
    ours = table[["rx_rad", "ry_rad", "rz_rad"]].std(ddof=0)
    np.testing.assert_allclose(ours, theirs, rtol=0.1)  # a Hampel filter lies between


def test_orientation_of_a_rigid_body_is_that_of_its_file(results: Path, samples: Path) -> None:
    """Rotation vectors about the mean, by scipy from the quaternions in columns 3 to 6."""
    table = pq.read_table(results / "recordings/robot/orientation.parquet").to_pandas()
    lines = (samples / "exports" / ROBOT).read_text("utf-8").splitlines()[7:]
    cells = [line.split(",")[2:6] for line in lines]
    seen = np.array([all(row) for row in cells])
    turns = Rotation.from_quat(np.array([row for row in cells if all(row)], float))
    theirs = (turns * turns.mean().inv()).as_rotvec()
    ours = table[["rx_rad", "ry_rad", "rz_rad"]].to_numpy()[seen]
    assert np.nanmedian(np.abs(ours - theirs)) < 1e-9  # a Hampel filter lies between


def test_half_the_noise_is_better(results: Path) -> None:
    rows = rows_of(results / "tables/lab_compare.csv")
    assert {(row["recording"], row["reference"]) for row in rows} == {("new", "old")}
    frame = [row for row in rows if float(row["tau_s"]) < 0.01 and row["series"] != "L"]
    assert len(frame) == 6 and {row["word"] for row in frame} == {"better"}
    for row in frame:
        assert float(row["lower"]) < 0.5**0.5 * 1.02 and float(row["upper"]) > 0.5**0.5 * 0.98
    assert {row["word"] for row in rows_of(results / "tables/lab_coherence.csv")} == {"unrelated"}
