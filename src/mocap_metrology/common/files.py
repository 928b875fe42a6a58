"""Files that are whole or absent, and that say so when they are damaged; Parquet tables that
carry their origin."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
import shutil
import tempfile
import uuid
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib import metadata as package_metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.common import parquet
from mocap_metrology.common.errors import Damaged, Missing, Refusal
from mocap_metrology.common.large import LazyArrays, Spool, is_large
from mocap_metrology.common.spreadsheet import as_text
from mocap_metrology.common.types import Columns

if TYPE_CHECKING:
    import pyarrow.parquet as pq

Metadata = dict[str, Any]  # of a table, as JSON holds it
METADATA_KEY = b"mocap_metrology"
RUN = "MOCAP_METROLOGY_RUN"  # in the environment: mark of the run of the workflow
REFUSED = "refused"  # in the metadata of empty tables: why
CHECKSUM = "user.mocap_metrology.sha256"  # extended attributes of a file
PLACE = "user.mocap_metrology.place"
OF_ONE = ("recordings", "calibrations")  # folders with a folder for each
ROW_GROUP = 262_144  # 36 min at 120 Hz: one column of one group reads in 1.5 ms


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Yield a name beside `path` to write to; on success it replaces `path`, on failure it is
    removed.

    The name is unique, so a killed job leaves at most a `.part-*` file and never half a result. It
    begins with the mark of the run, by which the next run knows it.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{_own_prefix()}{uuid.uuid4().hex[:12]}-{path.name}")
    try:
        yield part
        _sign(part, path)
        part.replace(path)
    finally:
        with suppress(FileNotFoundError):
            part.unlink()


def part_prefix(run: str) -> str:
    """The prefix of the names of unfinished files of a run."""
    return f".part-{run[:12]}-" if run else ".part-"


def _own_prefix() -> str:
    return part_prefix(os.environ.get(RUN, ""))


def temporary_folder(folder: str | Path) -> tempfile.TemporaryDirectory[str]:
    """A folder in `folder` for what is no result, removed in the end; if this process is killed,
    the next run removes it, as it removes what `whole` leaves."""
    return tempfile.TemporaryDirectory(dir=folder, prefix=_own_prefix())


@contextmanager
def whole_folder(folder: str | Path) -> Iterator[Path]:
    """Yield an empty folder beside `folder` to fill; on success it replaces `folder`, on failure it
    goes."""
    folder = Path(folder)
    with whole(folder) as part:
        part.mkdir()
        try:
            yield part
            if folder.exists():
                shutil.rmtree(folder)
        except BaseException:
            shutil.rmtree(part)
            raise


def write_folder(folder: str | Path, texts: Mapping[str | Path, str]) -> None:
    """Write a folder of texts as UTF-8, by their paths in it; whole or not at all."""
    with whole_folder(folder) as part:
        for name, text in texts.items():
            write_text(part / name, text)


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


def _sign(part: Path, path: Path) -> None:
    """Store the checksum of a file and its place as extended attributes, where the file system has
    these: CSV has no place for them. Parquet has a checksum of its own."""
    if part.is_file():
        with suppress(OSError, AttributeError):  # AttributeError: not on this operating system
            if part.suffix != ".parquet":
                os.setxattr(part, CHECKSUM, sha256(part).encode())
            if not path.parent.name.startswith(".part-"):  # a folder that gets its name later
                os.setxattr(part, PLACE, _folder_and_name(path))


def _attribute(path: Path, name: str) -> bytes:
    with suppress(OSError, AttributeError):
        return os.getxattr(path, name)
    return b""


def _folder_and_name(path: Path) -> bytes:
    """Name of a file with that of its folder."""
    return os.fsencode("/".join(path.absolute().parts[-2:]))


def verify(path: str | Path) -> None:
    """Raise `Damaged` for a file of `whole` that is not as it was written, or not where; `Missing`
    for none.

    Where a file has no checksum, as after a copy that leaves attributes behind, CSV and JSON are
    examined for cuts and zeros, so digits that changed and whole rows that are missing go unseen.
    A Parquet file is examined when it is read, see `parquet`.
    """
    path = Path(path)
    if not path.exists():
        raise Missing(path)
    place, written = _attribute(path, PLACE), _attribute(path, CHECKSUM)
    if place not in (b"", _folder_and_name(path)):
        raise Damaged(path, f"it was written as {os.fsdecode(place)}")
    if not path.is_file() or path.suffix == ".parquet":
        return
    if written:
        if sha256(path).encode() != written:
            raise Damaged(path, "its content is not what was written")
    elif path.suffix in (".csv", ".json"):
        try:
            _examine(path.read_text(encoding="utf-8"), path.suffix)
        except ValueError as error:
            raise Damaged(path, str(error)) from None


def _examine(text: str, kind: str) -> None:
    """Raise ValueError for JSON or CSV that is cut or holds zeros."""
    if not text.endswith("\n"):
        raise ValueError("its end is missing")
    if "\0" in text:
        raise ValueError("it holds zeros")
    if kind == ".json":  # libsurvive's configuration is an object without its braces
        json.loads(f"{{{text}}}" if text.startswith('"') else text)
    elif len({len(row) for row in csv.reader(io.StringIO(text))}) > 1:
        raise ValueError("its rows are not of equal length")


def write_json(path: str | Path, value: object) -> None:
    """Write `value` as readable JSON (NaN becomes null, as JSON has none)."""
    write_text(path, json.dumps(_jsonable(value), indent=2, ensure_ascii=False) + "\n")


def read_json(path: str | Path) -> Any:
    """Contents of a JSON file."""
    return json.loads(Path(path).read_text(encoding="utf-8"))


def write_csv(
    path: str | Path, rows: Sequence[Mapping[str, object]], columns: Sequence[str] = ()
) -> None:
    """Write rows with equal keys as CSV (`columns`, by default those of the first row); NaN and
    None become empty cells, and what a spreadsheet would take for a formula becomes text."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(columns or rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: as_text(v) for k, v in row.items()} for row in rows)
    write_text(path, text.getvalue())


def read_csv(path: str | Path, numbers: Collection[str]) -> list[dict[str, Any]]:
    """Rows of a CSV file; in the columns `numbers` numbers, NaN where a cell is empty. Without
    pandas, which takes longer to import than this to read."""
    with Path(path).open(encoding="utf-8", newline="") as file:
        return [
            {name: float(cell or "nan") if name in numbers else cell for name, cell in row.items()}
            for row in csv.DictReader(file)
        ]


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

    table = pa.table({name: parquet.to_arrow(values) for name, values in columns.items()})
    table = table.replace_schema_metadata(_schema_metadata(metadata))
    with whole(path) as part, parquet.writing(part, table.schema, dictionary) as writer:
        writer.write_table(table, ROW_GROUP)


def write_series(
    path: str | Path, columns: Iterable[tuple[str, np.ndarray]], metadata: Mapping[str, object]
) -> None:
    """Write a table like `write_table`, from columns of numbers that come one at a time.

    In a Parquet file all columns of some rows come before the next rows, so the columns wait in a
    file without a name, which goes when the process ends, however it ends.
    """
    import pyarrow as pa

    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=Path(path).parent) as file:
        spool = Spool(file)
        for name, values in columns:
            spool.put(name, values)
        fields = [(name, pa.from_numpy_dtype(dtype)) for name, dtype in spool.dtypes.items()]
        schema = pa.schema(fields, _schema_metadata(metadata))
        with whole(path) as part, parquet.writing(part, schema, ()) as writer:
            for start in range(0, spool.size, ROW_GROUP):
                rows = {
                    name: parquet.to_arrow(spool.get(name, start, start + ROW_GROUP))
                    for name in spool.dtypes
                }
                writer.write_table(pa.table(rows, schema), ROW_GROUP)


def _schema_metadata(metadata: Mapping[str, object]) -> dict[bytes, bytes]:
    text = json.dumps(_jsonable(metadata), ensure_ascii=False, sort_keys=True)
    return {METADATA_KEY: text.encode()}


def read_table(path: str | Path, columns: Sequence[str] | None = None) -> tuple[Columns, Metadata]:
    """Read a table of `write_table`: columns as arrays, and the metadata."""
    with parquet.reading(path) as file:
        table = file.read(columns=None if columns is None else list(columns))
        metadata, n_rows = _metadata(file, path), file.metadata.num_rows
    if table.num_rows != n_rows:
        raise Damaged(path, f"{table.num_rows} rows; expected {n_rows}")
    arrays = {
        name: parquet.to_numpy(table[name]) if table.num_rows else np.array([])
        for name in columns or table.column_names
    }
    return arrays, metadata


def read_metadata(path: str | Path) -> Metadata:
    """The metadata alone, without reading a column."""
    with parquet.reading(path) as file:
        return _metadata(file, path)


def _metadata(file: pq.ParquetFile, path: str | Path) -> Metadata:
    """Metadata of a table; `Damaged` where it is of another recording than its folder, `Refusal`
    where that was refused."""
    metadata = json.loads((file.schema_arrow.metadata or {}).get(METADATA_KEY, b"{}"))
    kind, name = ("", "", *Path(path).absolute().parts)[-3:-1]
    if kind in OF_ONE and metadata.get("recording", name) != name:
        raise Damaged(path, f"it is of {metadata['recording']}")
    if why := metadata.get(REFUSED):
        raise Refusal(f"{name} was refused: {why}")
    return metadata


def open_table(path: str | Path) -> tuple[Mapping[str, np.ndarray], Metadata]:
    """Read a table like `read_table`, but each column of a large one whenever it is asked for: of
    90 hours of two markers at 120 Hz all would be 1.2 GB together."""
    with parquet.reading(path) as file:
        names, metadata = file.schema_arrow.names, _metadata(file, path)
        large = is_large(len(names), file.metadata.num_rows)
    if not large:
        return read_table(path)

    def column(name: str) -> np.ndarray:
        import pyarrow as pa

        values = read_table(path, [name])[0][name].copy()  # Arrow keeps what it has, and reuses it
        pa.default_memory_pool().release_unused()
        return values

    return LazyArrays(names, column, partial(parquet.Column, path)), metadata


def read_series(path: str | Path) -> Iterator[tuple[str, np.ndarray]]:
    """Name, without its unit, and float64 values of each column but the first (the frame), one at a
    time: seven series of nine hours would be 220 MB together."""
    columns, _ = open_table(path)
    for column in list(columns)[1:]:
        yield column.removesuffix("_mm"), columns[column].astype(np.float64)
