"""Tables: what is written is read, whole or a column at a time, and carries its origin."""

import subprocess
import sys
from pathlib import Path
from unittest import mock

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from mocap_metrology.common import files, large
from mocap_metrology.common.files import (
    open_table,
    read_metadata,
    read_series,
    read_table,
    sha256,
    write_series,
    write_table,
)
from mocap_metrology.common.parquet import to_arrow, to_numpy

NUMBERS = ["f4", "f8", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"]
OTHERS = {
    "stepped": np.arange(20.0)[::3], "big-endian": np.arange(4, dtype=">i4"),
    "integers": [1, -2, 3], "truths": [True, False], "texts": ["µm", "", "Größe 日本"],
    "fixed texts": np.array(["a", "bcd"]), "objects": np.array(["x", "yz"], dtype=object),
    "missing": ["a", None], "no numbers": [1.5, None], "nothing": [], "no floats": np.array([]),
    "no integers": np.array([], dtype=np.int32),
}  # fmt: skip
COLUMNS = {kind: np.array([3, 1, 2, 0, 7], kind) for kind in NUMBERS} | OTHERS


@pytest.mark.parametrize("name", COLUMNS)
def test_arrays_to_arrow_and_back_as_pyarrow_itself(name: str) -> None:
    values = COLUMNS[name]
    native = np.asarray(values, np.int32) if name == "big-endian" else values
    expected, found = pa.array(native), to_arrow(native)
    assert found.type == expected.type
    assert repr(found.to_pylist()) == repr(expected.to_pylist())  # NaN is NaN
    pieces = [expected.slice(1), expected.slice(0, 0), expected.slice(0, 1)]
    for column in (pa.chunked_array([expected]), pa.chunked_array(pieces)):
        back = to_numpy(column)
        assert back.dtype == column.to_numpy().dtype
        np.testing.assert_array_equal(back, column.to_numpy())


@st.composite
def tables(draw) -> dict[str, np.ndarray]:
    n = draw(st.integers(1, 40))
    kinds = draw(st.lists(st.sampled_from(NUMBERS), min_size=1, max_size=3))
    numbers = {f"c{k}_mm": draw(arrays.arrays(kind, n)) for k, kind in enumerate(kinds)}
    return {"frame": np.arange(n, dtype=np.int32), **numbers}


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(columns=tables(), data=st.data())
def test_read_as_written_at_once_or_a_column_at_a_time(tmp_path, columns, data) -> None:
    """In groups of any length, from the disk or not, and any slice or rising indices of it."""
    n, group = len(columns["frame"]), data.draw(st.integers(1, 9))
    metadata = {"frame_rate_hz": 120.0, "n": np.int64(3), "nan": np.nan, "path": Path("a/b")}
    with mock.patch.object(files, "ROW_GROUP", group):
        write_table(tmp_path / "once", columns, metadata)
        write_series(tmp_path / "new/series", iter(columns.items()), metadata)
    assert sha256(tmp_path / "once") == sha256(tmp_path / "new/series")
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["series"]
    expected = {"frame_rate_hz": 120.0, "n": 3, "nan": None, "path": "a/b"}
    assert read_metadata(tmp_path / "once") == expected
    start, stop = data.draw(st.integers(0, n)), data.draw(st.integers(0, n + 3))
    rising = np.array(sorted(data.draw(st.sets(st.integers(0, n - 1)))), int)
    for limit, kind in ((large.LARGE, dict), (0, large.LazyArrays)):
        with mock.patch.object(large, "LARGE", limit):
            found, known = open_table(tmp_path / "once")
            assert isinstance(found, kind) and known == expected
        assert list(found) == list(columns) and len(found) == len(columns)
        for name, values in columns.items():
            np.testing.assert_array_equal(found[name], values)
            assert found[name].dtype == values.dtype
            column = large.in_parts(found, name)
            assert len(column) == n
            for where in (slice(start, stop), slice(None), rising):
                np.testing.assert_array_equal(column[where], values[where])
    series = dict(read_series(tmp_path / "once"))
    assert list(series) == [name.removesuffix("_mm") for name in list(columns)[1:]]
    assert {values.dtype for values in series.values()} == {np.dtype(float)}
    last = list(columns)[-1]
    assert list(read_table(tmp_path / "once", [last])[0]) == [last]


def test_tables_are_read_and_written_without_pandas(tmp_path: Path) -> None:
    code = f"""
import sys, numpy as np
from mocap_metrology.common.files import read_table, write_table
write_table({str(tmp_path / "t")!r}, {{"a": np.zeros(3), "s": ["x", "y", "z"]}}, {{}})
read_table({str(tmp_path / "t")!r}, ["a"])
read_table({str(tmp_path / "t")!r})
sys.exit("pandas" in sys.modules)
"""
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In memory, or in a file that leaves no name and holds what was put away."""
    for limit in (large.LARGE, 0):
        monkeypatch.setattr(large, "LARGE", limit)
        scratch = large.Scratch((2, 3, 5000), tmp_path)
        assert not list(tmp_path.iterdir())
        values = np.random.default_rng(1).normal(size=scratch.values.shape)
        for k in (0, 1):
            scratch.values[k] = values[k]
            scratch.put_away()
        scratch.values += 1.0
        np.testing.assert_array_equal(scratch.values, values + 1.0)
