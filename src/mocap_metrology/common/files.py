"""Files that are whole or absent, and Parquet tables that carry their origin.

Columns go to Arrow and back without pandas: pyarrow's own converters import it to ask whether they
are given something of it. A process that reads and writes one table of sweeps takes 0.17 CPU s as
it is and 0.38 with them (medians of seven, in turn); most jobs need pandas for nothing else.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import shutil
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import metadata as package_metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.common.types import Columns

if TYPE_CHECKING:
    import pyarrow as pa

Metadata = dict[str, Any]  # of a table, as JSON holds it
METADATA_KEY = b"mocap_metrology"
ROW_GROUP = 262_144  # 36 min at 120 Hz: one column of one group reads in 1.5 ms


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Yield a name beside `path` to write to; on success it replaces `path`, on failure it goes.

    The name is unique, so a killed job leaves at most a `.part-*` file and never half a result.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".part-{uuid.uuid4().hex[:12]}-{path.name}")
    try:
        yield part
        part.replace(path)
    finally:
        with suppress(FileNotFoundError):
            part.unlink()


def empty_folder(folder: str | Path) -> None:
    """Remove all that is in a folder, and leave the folder."""
    for old in Path(folder).iterdir():
        if old.is_dir() and not old.is_symlink():
            shutil.rmtree(old)
        else:
            old.unlink()


def write_text(path: str | Path, text: str) -> None:
    """Write `text` as UTF-8, whole or not at all."""
    with whole(path) as part:
        part.write_text(text, encoding="utf-8")


def write_json(path: str | Path, value: object) -> None:
    """Write `value` as readable JSON (NaN becomes null, as JSON has none)."""
    write_text(path, json.dumps(_jsonable(value), indent=2, ensure_ascii=False) + "\n")


def write_csv(path: str | Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write rows with equal keys as CSV; NaN and None become empty cells."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: "" if v is None or v != v else v for k, v in row.items()} for row in rows)
    write_text(path, text.getvalue())


def _jsonable(value: object) -> object:
    if isinstance(value, Mapping):
        return {str(key): _jsonable(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_jsonable(item) for item in value]
    if isinstance(value, (np.generic, np.ndarray)):
        return _jsonable(value.tolist())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def sha256(path: str | Path) -> str:
    """SHA-256 of a file, hex."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def versions(*packages: str) -> dict[str, str]:
    """Installed versions of the named packages, and of this one."""
    return {name: package_metadata.version(name) for name in ("mocap-metrology", *packages)}


def write_table(
    path: str | Path,
    columns: Mapping[str, np.ndarray | Sequence[object]],
    metadata: Mapping[str, object],
    dictionary: Sequence[str] = (),
) -> None:
    """Write columns of equal length as Parquet (zstd 1), with `metadata` as JSON in the schema.

    Floating columns are byte-stream-split, which suits measured values, whole numbers stored as
    differences; text columns and those named in `dictionary` (few distinct values, as from an
    int16 recording) are dictionary-coded.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table({name: to_arrow(values) for name, values in columns.items()})
    text = json.dumps(_jsonable(metadata), ensure_ascii=False, sort_keys=True)
    table = table.replace_schema_metadata({METADATA_KEY: text.encode()})
    coded = [f.name for f in table.schema if f.name in dictionary or pa.types.is_string(f.type)]
    encoding = {
        f.name: "BYTE_STREAM_SPLIT" if pa.types.is_floating(f.type) else "DELTA_BINARY_PACKED"
        for f in table.schema
        if f.name not in coded and not pa.types.is_boolean(f.type)
    }
    with whole(path) as part:
        pq.write_table(
            table,
            part,
            compression="zstd",
            compression_level=1,
            use_dictionary=coded or False,
            column_encoding=encoding or None,
            row_group_size=ROW_GROUP,
        )


def read_table(path: str | Path, columns: Sequence[str] | None = None) -> tuple[Columns, Metadata]:
    """Read a table of `write_table`: columns as arrays, and the metadata."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        table = file.read(columns=list(columns) if columns is not None else None)
    arrays = {
        name: to_numpy(table[name]) if table.num_rows else np.array([])
        for name in columns or table.column_names
    }
    return arrays, read_metadata(path)


def read_metadata(path: str | Path) -> Metadata:
    """The metadata alone, without reading a column."""
    import pyarrow.parquet as pq

    return json.loads((pq.read_schema(path).metadata or {}).get(METADATA_KEY, b"{}"))


def read_series(path: str | Path) -> Iterator[tuple[str, np.ndarray]]:
    """Name, without its unit, and float64 values of each column but the first (the frame), one at a
    time: seven series of nine hours would be 220 MB together."""
    import pyarrow.parquet as pq

    for column in pq.read_schema(path).names[1:]:
        values = read_table(path, [column])[0][column]
        yield column.removesuffix("_mm"), values.astype(np.float64)


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
