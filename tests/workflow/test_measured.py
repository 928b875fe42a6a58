"""Recordings by other people, and takes of bodies that move, through the workflow in one run."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest
from mocap_workflow.rows import by_number
from running import write_sheet
from scipy.spatial.transform import Rotation

ROD = "c3dorg_sample15/FP1.C3D"  # markers along a stick, swung by hand
CHAIR_MARKERS = "WheelchairFront;WheelchairRearR;WheelchairRearL"
REAL = {  # recording: file, markers; the last one in Intel int16
    "calibration": ("btk_pig/PiG_Calibration3_FF.c3d", "LTOE;*2"),
    "racing": ("kineticstoolkit/kinematics_racing_static.c3d", CHAIR_MARKERS),
    "optotrak": ("ezc3d_testfiles/Optotrak.c3d", "Marker_50;Marker_49"),
    "sample01": ("c3dorg_sample01/Eb015pi.c3d", "RFT1;RFT2"),
}


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


POSES = "20201001_Exp1_measurementPoint10.txt"
TWINS = """twins:
  before: {coefficients: {all: {h_0: 1.0e-4}}, seed: 1, duration_s: 60}
  after: {coefficients: {all: {h_0: 0.5e-4}}, seed: 3, duration_s: 60}
"""

HEADER = [
    *("recording", "path", "markers", "group", "truncated", "cluster", "compare_with", "date"),
    "covariate",
]
WANTED = (
    *("recordings/rod/place.csv", "recordings/racing/orientation.csv"),
    "recordings/tracker/orientation.parquet",
    *("tables/lab_compare.csv", "tables/lab_coherence.csv", "recordings/rod/allan.parquet"),
    *("tables/real_gaussian.csv", "tables/real_allan.md", "tables/real_noise.md"),
    "tables/real_outliers.csv",
)


@pytest.fixture(scope="module")
def done(samples, root, snakemake, tmp_path_factory) -> SimpleNamespace:
    """Folder of results and output of one run over real recordings, and two twins of two days."""
    folder = tmp_path_factory.mktemp("real")
    (folder / "twins.yaml").write_text(TWINS, encoding="utf-8")
    lines = [f"{t},{20 + np.sin(t / 5):.4f}" for t in range(61)]
    (folder / "room.csv").write_text("time_s,celsius\n" + "\n".join(lines) + "\n", "utf-8")
    rows = [
        {"recording": name, "path": str(samples / "c3d" / file), "markers": markers}
        | {"group": "real", "truncated": "accept" if name == "optotrak" else ""}
        | {"cluster": CHAIR_MARKERS if name == "racing" else ""}
        for name, (file, markers) in REAL.items()
    ]
    others = {
        "rod": {"path": str(samples / "c3d" / ROD), "markers": "PT00;PT02"},
        "tracker": {"path": str(samples / "static_vive_pose" / POSES), "markers": "tracker"},
        "old": {"path": "simulate:before", "group": "lab", "date": "2026-10-20"},
        "new": {"path": "simulate:after", "group": "lab", "date": "2026-11-20"}
        | {"covariate": "room.csv"},
    }
    rows += [{"recording": name, "group": "g"} | cells for name, cells in others.items()]
    results = folder / "results"
    output = snakemake(
        root,
        *("--cores", "2", *(str(results / name) for name in WANTED), "--config"),
        *(f"recordings={folder / write_sheet(folder, HEADER, *rows)}", "calibrations="),
        *(f"results={results}", f"twins={folder / 'twins.yaml'}", "fit_figures=[]"),
        "noise={estimators: [likelihood]}",
        drawn="",
    )
    assert output.returncode == 0, output.stdout
    return SimpleNamespace(results=results, output=output.stdout)


@pytest.fixture
def results(done: SimpleNamespace) -> Path:
    return done.results


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def allan(results: Path, name: str, series: str) -> tuple[np.ndarray, np.ndarray]:
    table = pq.read_table(results / f"recordings/{name}/allan.parquet").to_pydict()
    chosen = [k for k, found in enumerate(table["series"]) if found == series]
    return tuple(np.array([table[c][k] for k in chosen]) for c in ("tau_s", "adev_mm"))


def test_real_recordings_give_allan_deviations_and_tables(results: Path) -> None:
    for name in REAL:
        for series in ("x1", "y1", "z1", "x2", "y2", "z2", "L"):
            tau, adev = allan(results, name, series)
            assert tau.size > 5
            assert np.isfinite(adev).all()
    table = rows_of(results / "tables/real_gaussian.csv")
    assert [row["recording"] for row in table if row["axis"] == "x"] == sorted(REAL, key=by_number)
    assert {row["source"] for row in table} == {"measured"}
    assert (results / "tables/real_allan.md").stat().st_size > 0
    assert not list(results.rglob(".part-*"))
    assert not (results / "tables/skurowski_table4.csv").exists()  # no paper group, no paper table


def test_recordings_too_short_for_noise_coefficients_say_so(done) -> None:
    """Optotrak has 29 frames, the longest 700."""
    results = done.results
    for name in REAL:
        found = rows_of(results / f"recordings/{name}/noise.csv")
        assert {row["series"] for row in found} >= {"x1", "y1", "z1", "x2", "y2", "z2", "L"}
        assert {row["status"] for row in found} == {"refused"}
        assert {row["value"] for row in found} == {""}
        assert all("valid samples, expected at least 1000" in row["note"] for row in found)
        said = [x for x in done.output.splitlines() if f"noise {name}: x1, y1, z1" in x]
        assert len(said) == 1
        assert ": no noise coefficients: " in said[0]
    text = (results / "tables/real_noise.md").read_text()
    assert (
        "x1, y1, z1, x2, y2, z2, L: no coefficients: 29 valid samples, expected at least 1000."
        in text
    )


def test_real_units_rates_and_gaps(results: Path) -> None:
    racing = pq.read_schema(results / "recordings/racing/trajectories.parquet").metadata
    origin = json.loads(racing[b"mocap_metrology"])
    assert origin["file_units"] == "m" and "form" not in origin  # a camera's frames are points
    assert origin["frame_rate_hz"] == pytest.approx(69.9)
    tau, adev = allan(results, "racing", "L")
    assert tau[0] == pytest.approx(1 / 69.9)
    assert 1e-4 < adev[0] < 0.1  # mm: in metres it would be a thousand times less
    gaps = pq.read_table(results / "recordings/calibration/trajectories.parquet")
    assert np.isnan(gaps["x2_mm"].to_numpy()).sum() == 2
    assert np.isnan(gaps["x1_mm"].to_numpy()).sum() == 0


def test_resolution_of_the_file_is_reported(results: Path) -> None:
    table = rows_of(results / "tables/real_outliers.csv")
    found = {row["recording"]: row for row in table if row["series"] == "x1"}
    assert found["sample01"]["resolution_kind"] == "int16"
    assert 0.01 < float(found["sample01"]["resolution_mm"]) < 1  # POINT:SCALE
    assert found["racing"]["resolution_kind"] == "float32"
    assert float(found["racing"]["resolution_mm"]) < 1e-3


def test_moving_markers_are_warned_of_with_the_drift(results: Path) -> None:
    def warnings(name: str) -> list[str]:
        check = json.loads((results / f"recordings/{name}/check.json").read_text("utf-8"))
        return check["warnings"]

    (words,) = warnings("sample01")
    assert words.startswith("marker RFT1 seems to move")
    assert warnings("racing") == [] and not any("move" in w for w in warnings("optotrak"))


def test_length_of_a_stick_that_is_swung(results: Path) -> None:
    """It moves by decimetres; its length scatters by half a millimetre, and ADEV(L) says so."""
    cells = rows_of(results / "recordings/rod/place.csv")
    assert len(cells) >= 2
    assert all(0.01 < float(cell["sigma_mm"]) < 1 for cell in cells)
    allan = pq.read_table(results / "recordings/rod/allan.parquet").to_pandas()
    longest = allan.groupby("series")["adev_mm"].max()
    assert longest["x1"] > 30 and longest["L"] < 0.6


def test_orientation_of_a_rigid_frame_at_rest(results: Path) -> None:
    rows = rows_of(results / "recordings/racing/orientation.csv")
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


def test_half_the_noise_is_better(results: Path) -> None:
    rows = rows_of(results / "tables/lab_compare.csv")
    assert {(row["recording"], row["reference"]) for row in rows} == {("new", "old")}
    frame = [row for row in rows if float(row["tau_s"]) < 0.01 and row["series"] != "L"]
    assert len(frame) == 6 and {row["word"] for row in frame} == {"better"}
    for row in frame:
        assert float(row["lower"]) < 0.5**0.5 * 1.02 and float(row["upper"]) > 0.5**0.5 * 0.98
    assert {row["word"] for row in rows_of(results / "tables/lab_coherence.csv")} == {"unrelated"}
