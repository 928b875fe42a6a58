"""Tables that do not fit into memory: one column at a time, the same numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common import large
from mocap_metrology.common.files import (
    ROW_GROUP,
    open_table,
    read_table,
    write_series,
    write_table,
)
from mocap_metrology.common.large import Made, in_parts

N = 600_000  # frames: more than two row groups


def columns() -> dict[str, np.ndarray]:
    draw = np.random.default_rng(1)
    return {
        "frame": np.arange(N, dtype=np.int32),
        "x1_mm": draw.normal(size=N).astype(np.float32),
        "L_mm": np.where(draw.random(N) < 0.1, np.nan, draw.normal(size=N)),
    }


def test_written_one_at_a_time(tmp_path: Path) -> None:
    """Byte for byte what is written at once, and no other file is left."""
    write_table(tmp_path / "at_once.parquet", columns(), {"unit": "mm"})
    came = []

    def one_at_a_time():
        for name, values in columns().items():
            came.append(name)
            yield name, values

    write_series(tmp_path / "new/one.parquet", one_at_a_time(), {"unit": "mm"})
    assert came == list(columns())
    one = (tmp_path / "new/one.parquet").read_bytes()
    assert one == (tmp_path / "at_once.parquet").read_bytes()
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["one.parquet"]


def test_read_one_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Large tables only."""
    path = tmp_path / "table.parquet"
    write_table(path, columns(), {"unit": "mm"})
    assert isinstance(open_table(path)[0], dict)
    monkeypatch.setattr(large, "LARGE", 0)
    found, metadata = open_table(path)
    assert isinstance(found, Made)
    assert metadata == {"unit": "mm"}
    assert list(found) == list(read_table(path)[0])
    for name, values in columns().items():
        np.testing.assert_array_equal(found[name], values)


def test_slices_of_a_column_from_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within a row group, over several, behind the end; and any rising indices."""
    path = tmp_path / "table.parquet"
    write_table(path, columns(), {})
    small, _ = open_table(path)
    assert in_parts(small, "L_mm") is small["L_mm"]
    monkeypatch.setattr(large, "LARGE", 0)
    found, _ = open_table(path)
    draw = np.random.default_rng(2)
    chosen = np.flatnonzero(draw.random(N) < 1e-4)
    ends = ((0, 10), (ROW_GROUP - 1, ROW_GROUP + 1), (5, N - 5), (N - 3, N + 9), (7, 7), (9, 2))
    for name, values in columns().items():
        column = in_parts(found, name)
        assert len(column) == N
        for where in (chosen, chosen[-3:], *(slice(*pair) for pair in ends), slice(None)):
            np.testing.assert_array_equal(column[where], values[where])
        assert column[:1].dtype == values.dtype


def test_made_anew_each_time() -> None:
    asked = []

    def make(name: str) -> np.ndarray:
        asked.append(name)
        return np.array([len(asked)])

    found = Made(["a", "b"], make)
    assert "a" in found and "c" not in found
    assert len(found) == 2
    assert asked == []
    assert [int(found[name][0]) for name in ("b", "a", "b")] == [1, 2, 3]
    with pytest.raises(KeyError):
        found["c"]


def test_scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In memory, or in a file that leaves no name and holds what was put away."""
    for limit in (large.LARGE, 0):
        monkeypatch.setattr(large, "LARGE", limit)
        scratch = large.Scratch((2, 3, 5000), tmp_path)
        assert not list(tmp_path.iterdir())
        values = np.random.default_rng(1).normal(size=scratch.values.shape)
        scratch.values[0] = values[0]
        scratch.put_away()
        scratch.values[1] = values[1]
        scratch.put_away()
        scratch.values += 1.0
        np.testing.assert_array_equal(scratch.values, values + 1.0)
