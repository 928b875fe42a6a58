"""The workflow itself, from sheet to tables: real recordings by other people, bad input, twins."""

from __future__ import annotations

import csv
import json
import shutil
import zlib
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from mocap_workflow.rows import by_number
from rule_graph import shipped, write_shipped
from running import finished, planned, watching, write_sheet

from mocap_metrology.io.c3d.write import write_c3d

HEADER = ["recording", "path", "markers", "group", "truncated"]
ENCODINGS = ("pi", "vr")  # Intel int16 and DEC float: test_c3d_real.py reads all six

REAL = {  # recording: file, markers
    "calibration": ("btk_pig/PiG_Calibration3_FF.c3d", "LTOE;*2"),
    "racing": ("kineticstoolkit/kinematics_racing_static.c3d", "WheelchairFront;WheelchairRearR"),
    "optotrak": ("ezc3d_testfiles/Optotrak.c3d", "Marker_50;Marker_49"),
} | {f"sample01-{code}": (f"c3dorg_sample01/Eb015{code}.c3d", "RFT1;RFT2") for code in ENCODINGS}


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


# One estimator, and no figure of a fit
QUICK = ("noise={estimators: [likelihood]}", "fit_figures=[]")


@pytest.fixture(scope="module")
def real(samples, tmp_path_factory, root, snakemake):
    """Folder of results and the output of one run over real recordings, a sheet row each."""
    folder = tmp_path_factory.mktemp("real")
    data = samples / "c3d"
    sheet = write_sheet(
        folder,
        HEADER,
        *(
            {"recording": name, "path": str(data / file), "markers": markers, "group": "real"}
            | ({"truncated": "accept"} if name == "optotrak" else {})
            for name, (file, markers) in REAL.items()
        ),
    )
    results = folder / "results"
    figure = results / "recordings/racing/trajectory.png"
    out = snakemake(
        root,
        *("--cores", "2", "tables", figure, "--config"),
        *(f"recordings={folder / sheet}", "calibrations=", f"results={results}", *QUICK),
    )
    return results, out


def allan(results: Path, name: str, series: str) -> tuple[np.ndarray, np.ndarray]:
    table = pq.read_table(results / f"recordings/{name}/allan.parquet").to_pydict()
    chosen = [k for k, found in enumerate(table["series"]) if found == series]
    return tuple(np.array([table[c][k] for k in chosen]) for c in ("tau_s", "adev_mm"))


def test_real_recordings_give_allan_deviations_and_tables(real) -> None:
    results, out = real
    assert out.returncode == 0, out.stdout
    for name in REAL:
        for series in ("x1", "y1", "z1", "x2", "y2", "z2", "L"):
            tau, adev = allan(results, name, series)
            assert tau.size > 5
            assert np.isfinite(adev).all()
    table = rows(results / "tables/real_gaussian.csv")
    assert [row["recording"] for row in table if row["axis"] == "x"] == sorted(REAL, key=by_number)
    assert {row["source"] for row in table} == {"measured"}
    assert (results / "tables/real_allan.md").stat().st_size > 0
    assert (results / "recordings/racing/trajectory.png").stat().st_size > 10_000
    assert not list(results.rglob(".part-*"))
    assert not (results / "tables/skurowski_table4.csv").exists()  # no paper group, no paper table


def test_recordings_too_short_for_noise_coefficients_say_so(real) -> None:
    """Optotrak has 29 frames, the longest 700."""
    results, out = real
    for name in REAL:
        found = rows(results / f"recordings/{name}/noise.csv")
        assert {row["series"] for row in found} == {"x1", "y1", "z1", "x2", "y2", "z2", "L"}
        assert {row["status"] for row in found} == {"refused"}
        assert {row["value"] for row in found} == {""}
        assert all("valid samples, expected at least 1000" in row["note"] for row in found)
        said = [x for x in out.stdout.splitlines() if f"noise {name}: x1, y1, z1" in x]
        assert len(said) == 1
        assert ": no noise coefficients: " in said[0]
    text = (results / "tables/real_noise.md").read_text()
    assert (
        "x1, y1, z1, x2, y2, z2, L: no coefficients: 29 valid samples, expected at least 1000."
        in text
    )


def test_real_units_rates_and_gaps(real) -> None:
    results, _ = real
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


def test_int16_and_float_give_the_same_deviations(real) -> None:
    """The int16 file holds the same numbers rounded."""
    results, _ = real
    for series in ("x1", "z2", "L"):
        (tau, adev), (expected_tau, expected) = (
            allan(results, f"sample01-{code}", series) for code in ENCODINGS
        )
        np.testing.assert_array_equal(tau, expected_tau)
        np.testing.assert_allclose(adev, expected, rtol=0.02)


def test_resolution_of_the_file_is_reported(real) -> None:
    results, _ = real
    table = rows(results / "tables/real_outliers.csv")
    found = {row["recording"]: row for row in table if row["series"] == "x1"}
    assert found["sample01-pi"]["resolution_kind"] == "int16"
    assert 0.01 < float(found["sample01-pi"]["resolution_mm"]) < 1  # POINT:SCALE
    assert found["racing"]["resolution_kind"] == "float32"
    assert float(found["racing"]["resolution_mm"]) < 1e-3


def test_moving_markers_are_warned_of_with_the_drift(real) -> None:
    _, out = real
    for code in ENCODINGS:
        assert f"recording sample01-{code}: marker RFT1 seems to move" in out.stdout
    assert "recording racing: marker" not in out.stdout
    assert "recording optotrak" not in out.stdout


# Bad input


def png() -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        crc = zlib.crc32(kind + body).to_bytes(4, "big")
        return len(body).to_bytes(4, "big") + kind + body + crc

    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", bytes(13)) + chunk(b"IEND", b"")


def recording(path: Path, n: int = 600, first_frame: int = 1, valid: bool = True) -> None:
    rng = np.random.default_rng(n + first_frame)
    points = 100 * np.arange(6).reshape(2, 3) + 0.01 * rng.normal(size=(n, 2, 3))
    if not valid:
        points[:, 1] = np.nan
    write_c3d(path, ["A", "B"], 100.0, [points.astype(np.float32)], n, first_frame=first_frame)


@pytest.fixture(scope="module")
def bad(tmp_path_factory, root, snakemake):
    """One run over a good recording, two minutes of the twin T40-10, and one recording of every
    kind that is refused."""
    folder = tmp_path_factory.mktemp("bad")
    recording(folder / "good.c3d")
    whole = (folder / "good.c3d").read_bytes()
    (folder / "truncated.c3d").write_bytes(whole[: len(whole) * 2 // 3])
    shutil.make_archive(str(folder / "archive"), "zip", folder, "good.c3d")
    shutil.move(folder / "archive.zip", folder / "zip.c3d")
    (folder / "png.c3d").write_bytes(png())
    (folder / "empty.c3d").write_bytes(b"")
    (folder / "directory.c3d").mkdir()
    counts = bytearray(whole)
    counts[8:10] = (7).to_bytes(2, "little")  # header: last frame
    at = whole.index(b"FRAMES") + 10  # POINT:FRAMES
    counts[at : at + 2] = (7000).to_bytes(2, "little")
    for name in (b"ACTUAL_END_FIELD", b"LONG_FRAMES"):
        if name in whole:
            at = whole.index(name)
            counts[at : at + 6] = b"UNUSED"
    (folder / "counts.c3d").write_bytes(bytes(counts))
    recording(folder / "single.c3d", n=1)
    recording(folder / "invalid.c3d", valid=False)
    recording(folder / "first.c3d", n=500)
    recording(folder / "second.c3d", n=500, first_frame=300)
    refused = {
        "truncated": "cut off",
        "zip": "ZIP",
        "png": "PNG",
        "empty": "empty",
        "directory": "directory",
        "counts": "frame",
        "single": "1 frame",
        "invalid": "valid in no frame",
        "overlap": "overlap",
    }
    files = {"overlap": "first.c3d;second.c3d"}
    (twin,) = (row for row in shipped("recordings") if row["recording"] == "T40-10")
    sheet = [
        {"recording": "good", "path": "good.c3d", "markers": "A;B", "group": "mixed"},
        twin,
    ] + [
        {
            "recording": name,
            "path": files.get(name, f"{name}.c3d"),
            "markers": "A;B",
            "group": "mixed",
        }
        for name in refused
    ]
    old = folder / "results/recordings/zip/allan.parquet"
    old.parent.mkdir(parents=True)
    old.write_text("of an earlier input")
    arguments = (
        *("--cores", "2", "tables", "--config"),
        f"recordings={folder / write_sheet(folder, list(twin), *sheet)}",
        *("calibrations=", f"results={folder / 'results'}", "duration_s=120", "fit_figures=[]"),
    )
    return folder / "results", refused, snakemake(root, *arguments), arguments


def test_every_bad_input_is_one_line_and_the_rest_is_computed(bad) -> None:
    results, refused, out, _ = bad
    assert out.returncode == 1
    for name, reason in refused.items():
        lines = [x for x in out.stdout.splitlines() if x.startswith(f"recording {name} refused:")]
        assert len(lines) == 1, (name, out.stdout)
        assert reason in lines[0], lines[0]
    table = rows(results / "tables/mixed_gaussian.csv")
    assert {(row["recording"], row["source"]) for row in table} == {("good", "measured")}
    table = rows(results / "tables/skurowski2019_gaussian.csv")
    assert {(row["recording"], row["source"]) for row in table} == {("T40-10", "twin")}
    assert "Traceback" not in out.stdout


def test_nothing_half_written_or_outdated_is_left(bad) -> None:
    results, refused, _, _ = bad
    assert not list(results.rglob(".part-*"))
    for name in refused:
        left = {path.name for path in (results / "recordings" / name).iterdir()}
        tables = {"trajectories.parquet", "clean.parquet", "outliers.csv"}
        assert left == {"check.json", *tables}, name
    assert not list(results.rglob("twin.c3d"))  # raw twins are temporary
    assert (results / "recordings/T40-10/truth.json").exists()


def test_rerun_repeats_the_verdict_alone(bad, root, snakemake) -> None:
    _, refused, _, arguments = bad
    again = snakemake(root, *arguments)
    assert again.returncode == 1
    assert set(finished(again.stdout)) == set()
    assert sum(x.startswith("recording ") for x in again.stdout.splitlines()) == len(refused)


def test_paper_tables_hold_every_published_number(bad, root) -> None:
    """Of T40-10 alone: the published columns are complete, the rest says what it is."""
    results, *_ = bad
    published = rows(root / "src/mocap_metrology/reference/gaussian_model_table4.csv")
    expected = {
        (row["camera_type"], key): float(value)
        for row in published
        for key, value in row.items()
        if key not in ("camera_type", "note")
    }
    table = rows(results / "tables/skurowski_table4.csv")
    found = {(r["camera_type"], r["quantity"]): float(r["published"]) for r in table}
    assert found == expected
    computed = {r["quantity"]: r for r in table if r["camera_type"] == "T40"}
    assert {r["source"] for r in computed.values()} == {"twin"}
    assert float(computed["mu_L_mm"]["regenerated"]) == pytest.approx(160.58, abs=0.05)
    missing = [r for r in table if r["camera_type"] == "Vantage"]
    assert {(r["regenerated"], r["source"]) for r in missing} == {("", "cited")}
    subsets = rows(results / "tables/skurowski_table3.csv")
    cited = rows(root / "src/mocap_metrology/reference/camera_subsets_table3.csv")
    assert [r["published"] for r in subsets] == [r["camera_ids"] for r in cited]
    assert "simulated" in (results / "tables/skurowski_table4.md").read_text()
    twin = pq.read_schema(results / "recordings/T40-10/trajectories.parquet").metadata
    assert json.loads(twin[b"mocap_metrology"])["form"] == "continuous"
    noise = rows(results / "recordings/T40-10/noise.csv")
    assert {r["model"] for r in noise if r["estimator"] == "likelihood"} == {"continuous"}


# The default sheet


def test_default_sheet_job_counts(root, tmp_path, snakemake) -> None:
    """One job and one figure for the twins of a setup: the dumps of one look alike."""
    own = write_shipped(tmp_path)
    out = snakemake(root, "-n", "--config", *own, f"results={tmp_path}/results")
    sheet, calibrations = shipped("recordings"), shipped("calibrations")
    per_recording = ("clean_twin", "noise", "verdict")
    once = (
        *("skurowski", "expected_noise", "jansen", "calibration_tables", "claims"),
        *("gate", "default"),
    )
    expected = dict.fromkeys(per_recording, len(sheet)) | dict.fromkeys(once, 1)
    expected |= {"group_tables": len({row["group"] for row in sheet})}
    setups = {row["setup"] for row in calibrations}
    expected |= {f"calibration_twins_{k}": 1 for k in range(1, len(setups) + 1)}
    expected |= {"calibration_figures": len(setups)}
    paper = [(r["camera_type"], r["n_cameras"]) for r in sheet if r["group"] == "skurowski2019"]
    found = planned(out.stdout)
    assert {rule: found[rule] for rule in expected} == expected, out.stdout
    cited = rows(root / "src/mocap_metrology/reference/camera_subsets_table3.csv")
    assert {(row["camera_type"], row["n_cameras"]) for row in cited} <= set(paper)
    expected |= {"skurowski_case": 3}
    others = {rule: count for rule, count in found.items() if rule not in expected}
    assert all(count <= 2 for count in others.values()), others  # none for each recording
    assert not {"clean", "sweeps", "pose"} & set(found)  # twins need no check
    assert sum(found.values()) <= 200


def test_no_more_than_two_raw_twins_at_once(root, tmp_path, snakemake) -> None:
    """Four twins on two cores: nine hours of one are 124 MB, so the disk they take is bounded."""
    lines = (root / "config/recordings.tsv").read_text().splitlines()
    chosen = [x for x in lines if x.split("\t")[0] == "recording" or x.startswith("Bonita-")][:5]
    (tmp_path / "sheet.tsv").write_text("\n".join(chosen) + "\n")
    names = [line.split("\t")[0] for line in chosen[1:]]
    with watching(
        lambda: len(list(tmp_path.glob("results/recordings/*/.part-*/twin.c3d")))
    ) as most:
        out = snakemake(
            root,
            *("--cores", "2"),
            *(tmp_path / f"results/recordings/{name}/trajectories.parquet" for name in names),
            *("--config", f"recordings={tmp_path / 'sheet.tsv'}", "calibrations="),
            *(f"results={tmp_path / 'results'}", "duration_s=600"),
        )
    assert out.returncode == 0, out.stdout
    assert len(list(tmp_path.glob("results/recordings/*/trajectories.parquet"))) == 4
    assert 1 <= max(most) <= 2
