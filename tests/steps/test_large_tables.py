"""Steps of a recording whose tables are read one column at a time: the same results."""

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common import large
from mocap_metrology.common.files import open_table, write_table
from mocap_metrology.common.hampel import hampel
from mocap_metrology.common.large import LazyArrays, in_parts
from mocap_metrology.noise.motion.orientation import of_cluster
from mocap_metrology.recording.clean import cleaned, write_cleaned
from mocap_metrology.recording.noise import gaussian_model
from mocap_metrology.recording.results import Results, Table, masked
from mocap_metrology.recording.verdict import Diagnosed, diagnose
from mocap_metrology.settings import Gaussian, Hampel, Settings

N = 20_000
ORIGIN = {
    **{"recording": "r", "source": "measured", "labels": ["A", "B"], "pairs": [[1, 2]]},
    **{"frame_rate_hz": 100.0, "resolution_mm": 0.0, "resolution_kind": "float32"},
}


@pytest.fixture
def raw(tmp_path: Path) -> Path:
    """trajectories.parquet with gaps and outliers."""
    draw = np.random.default_rng(1)
    at = np.array([0, 0, 0, 300, 200, 100])[:, None]
    values = (at + 0.1 * draw.standard_normal((6, N))).astype(np.float32)
    values[2, 500:530] = np.nan
    values[4, ::997] += 5
    names = [f"{axis}{k}_mm" for k in (1, 2) for axis in "xyz"]
    columns = {"frame": np.arange(N, dtype=np.int32), **dict(zip(names, values, strict=True))}
    Table(columns, ORIGIN).write(tmp_path / "raw.parquet")
    return tmp_path / "raw.parquet"


def test_clean_and_gaussian(raw: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected, report = cleaned(Table.read(raw), Hampel())
    expected_rows = gaussian_model(expected, Gaussian())
    monkeypatch.setattr(large, "LARGE", 0)
    path = raw.with_name("clean.parquet")
    assert write_cleaned(Table.open(raw), Hampel(), path) == report
    found = Table.read(path)
    assert found.origin == expected.origin | {"pairs": [[1, 2]]}
    assert list(found.columns) == list(expected.columns)
    for name, values in expected.columns.items():
        assert found.columns[name].dtype == values.dtype
        np.testing.assert_array_equal(found.columns[name], values)
    assert gaussian_model(Table.open(path), Gaussian()) == expected_rows


def test_diagnosis(raw: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Events, repeats, spikes and lines; nothing is kept but what was found."""
    table = Table.read(raw)
    disturbed = {name: values.copy() for name, values in table.columns.items()}
    disturbed["x1_mm"][9000:9040] += 3.0
    for axis in "xyz":
        disturbed[f"{axis}2_mm"][12_000:12_040] = disturbed[f"{axis}2_mm"][12_000]
    origin = ORIGIN | {"n_filled_frames": {}}
    Table(disturbed, origin).write(raw)

    def diagnosed(table: Table, name: str) -> Diagnosed:
        results = Results(raw.parent / name)
        results.raw, results.noise = table, []
        results.psd = Table({"series": np.empty(0, object)}, {"psd": {}})
        return diagnose(results, Settings())

    expected = diagnosed(Table.read(raw), "expected")
    assert expected.diagnosis.events
    assert expected.diagnosis.repeats
    assert expected.diagnosis.spikes["y2"].size
    monkeypatch.setattr(large, "LARGE", 0)
    found = diagnosed(Table.open(raw), "found")
    assert isinstance(found.diagnosis.quiet, LazyArrays)
    for path in (raw.parent / "expected").iterdir():
        assert (raw.parent / "found" / path.name).read_bytes() == path.read_bytes()
    assert list(found.diagnosis.quiet) == list(expected.diagnosis.quiet)
    for name, values in expected.diagnosis.quiet.items():
        assert found.diagnosis.quiet[name].dtype == values.dtype
        np.testing.assert_array_equal(found.diagnosis.quiet[name], values)


def test_orientation_in_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of frames worked on, and of columns read, a part at a time."""
    draw = np.random.default_rng(1)
    shape = np.array([[0, 0, 0], [300, 0, 0], [0, 200, 50], [10, 20, 200.0]])
    points = shape[:, :, None] + 0.1 * draw.standard_normal((4, 3, 5000))
    points[0, :, 10:40] = np.nan
    points[1:, :, 20:22] = np.nan
    expected = of_cluster(points)
    monkeypatch.setattr("mocap_metrology.noise.motion.orientation.CHUNK", 977)
    found = of_cluster(points)
    np.testing.assert_array_equal(found.vectors_rad, expected.vectors_rad)
    np.testing.assert_array_equal(found.residual_mm, expected.residual_mm)
    names = [[f"{axis}{k}_mm" for axis in "xyz"] for k in range(4)]
    flat = {name: points[k][c] for k, row in enumerate(names) for c, name in enumerate(row)}
    write_table(tmp_path / "a.parquet", flat, {})
    monkeypatch.setattr(large, "LARGE", 0)
    monkeypatch.setattr(LazyArrays, "__getitem__", None)  # no column is read whole
    columns, _ = open_table(tmp_path / "a.parquet")
    stored = of_cluster([[in_parts(columns, name) for name in row] for row in names])
    np.testing.assert_array_equal(stored.vectors_rad, expected.vectors_rad)
    np.testing.assert_array_equal(stored.residual_mm, expected.residual_mm)


def test_gross_outliers_are_masked_without_looking_for_them_twice(raw: Path) -> None:
    """As recorded but for samples beyond 6 sigma: the variance is that of the noise, where the
    series cleaned as in S has 3 to 4 % less. By the filter on all samples the same."""
    table, settings = Table.read(raw), Settings()
    clean, _ = cleaned(table, settings.hampel)
    found = dict(masked(table, clean, settings))
    for name, values in table.with_distances():
        alone = hampel(values, 100, settings.noise.mask_sigma, "mask", 0.0).values
        np.testing.assert_array_equal(found[name], alone)
    assert np.isnan(found["y2"][::997]).all()
    assert np.nanvar(found["y2"]) / 0.01 == pytest.approx(1, abs=0.03)  # 3 standard errors
    replaced = clean.coordinates["y2"]
    assert np.nanvar(found["y2"][~np.isnan(found["y2"])]) > 1.025 * np.nanvar(replaced)
