"""Arrays to Arrow and back: as pyarrow's own converters, without what they import."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mocap_metrology.common.arrow import to_arrow, to_numpy

COLUMNS = {
    **{
        kind: np.array([3, 1, 2, 0, 7], kind)
        for kind in ("f4", "f8", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")
    },
    "gaps": np.array([np.nan, 1.5, np.inf, -0.0]),
    "stepped": np.arange(20.0)[::3],
    "integers": [1, -2, 3],
    "floats": [1.0, 2.5],
    "truths": [True, False],
    "texts": ["µm", "", "Größe 日本"],
    "fixed texts": np.array(["a", "bcd"]),
    "objects": np.array(["x", "yz"], dtype=object),
    "missing": ["a", None],
    "no numbers": [1.5, None],
    "nothing": [],
    "no floats": np.array([]),
    "no integers": np.array([], dtype=np.int32),
}


@pytest.mark.parametrize("name", COLUMNS)
def test_as_pyarrow_itself(name: str) -> None:
    values = COLUMNS[name]
    expected, found = pa.array(values), to_arrow(values)
    assert found.type == expected.type
    assert repr(found.to_pylist()) == repr(expected.to_pylist())  # NaN is NaN


@pytest.mark.parametrize("name", COLUMNS)
def test_back_from_whole_sliced_and_chunked_columns(name: str) -> None:
    whole = pa.array(COLUMNS[name])
    pieces = [whole.slice(1), whole.slice(0, 0), whole.slice(0, 1)]
    for column in (pa.chunked_array([whole]), pa.chunked_array(pieces)):
        expected = column.to_numpy()
        found = to_numpy(column)
        assert found.dtype == expected.dtype
        np.testing.assert_array_equal(found, expected)


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
