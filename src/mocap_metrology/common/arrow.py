"""Columns to Arrow and back, without pandas: pyarrow's own converters import it to ask whether they
are given something of it. A process that reads and writes one table of sweeps takes 0.17 CPU s as
it is and 0.38 with them (medians of seven, in turn); most jobs need pandas for nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyarrow as pa


def to_arrow(values: np.ndarray | Sequence[object]) -> pa.Array:
    """An Arrow array of the values: the same numbers, or texts; NaN stays NaN."""
    import pyarrow as pa

    found = np.asarray(values)
    numbers = found.dtype.kind in "fiu" and found.dtype.isnative
    if numbers and (found.size or values is found):
        data = pa.py_buffer(np.ascontiguousarray(found))
        return pa.Array.from_buffers(pa.from_numpy_dtype(found.dtype), found.size, [None, data])
    listed = found.tolist() if found.dtype.kind == "U" else list(values)
    texts = [value.encode() for value in listed if isinstance(value, str)]
    if texts and len(texts) == len(listed):
        ends = np.cumsum([0, *map(len, texts)], dtype=np.int32)
        buffers = pa.py_buffer(ends), pa.py_buffer(b"".join(texts))
        return pa.StringArray.from_buffers(len(texts), *buffers)
    return pa.array(values)


def to_numpy(column: pa.ChunkedArray) -> np.ndarray:
    """What `column.to_numpy()` returns."""
    import pyarrow as pa

    if pa.types.is_string(column.type) and not column.null_count:
        return np.array(column.to_pylist(), dtype=object)
    if column.null_count or not (
        pa.types.is_integer(column.type) or pa.types.is_floating(column.type)
    ):
        return column.to_numpy()
    dtype = np.dtype(column.type.to_pandas_dtype())
    parts = [
        np.frombuffer(chunk.buffers()[1], dtype, len(chunk), chunk.offset * dtype.itemsize)
        for chunk in column.chunks
        if len(chunk)
    ]
    return parts[0] if len(parts) == 1 else np.concatenate(parts or [np.array([], dtype)])
