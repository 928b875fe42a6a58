"""What a change did to every number: two folders of results, file by file.

    python -m benchmarks.compare_results BEFORE AFTER [--relative 1e-12]

Text (CSV, JSON, YAML, XML, Markdown, HTML, SVG) is cut into numbers and what stands between them:
the numbers may differ by the relative tolerance, everything else must be the same. Parquet is
compared column by column, gaps included, and its metadata too. Pictures (PNG) are compared by their
bytes. Logs, run times and Snakemake's report, which differ at every run, are left out. Files that
differ are listed, those beyond tolerance first, with the largest difference; then the status is 1.

Make both folders on one machine with one lock: other libraries, other sums.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from mocap_metrology.common.parquet import SEAL

TEXT = {".csv", ".json", ".md", ".html", ".svg", ".yaml", ".xml"}
COMPARED = {*TEXT, ".parquet", ".png"}
RUN_OWN = ("logs/*", "benchmarks/*", "report.html", "provenance.*", "gate/*")  # of each run its own
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
VERSIONS = "versions"  # key of a table's origin that may differ: which versions wrote it


@dataclass(frozen=True)
class Difference:
    """How a file differs: the largest relative difference of its numbers, infinite where something
    else than a number does; and where that is."""

    file: str
    relative: float
    where: str


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what differs; 0 where nothing does beyond tolerance."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("before", type=Path, help="folder of results")
    parser.add_argument("after", type=Path, help="another, of the same sheets and settings")
    parser.add_argument("--relative", type=float, default=0.0, help="tolerance (default: 0)")
    given = parser.parse_args(arguments)
    for folder in (given.before, given.after):
        if not folder.is_dir():
            parser.error(f"{folder}: no such folder; expected one of results")
    files = [names_of(given.before), names_of(given.after)]
    found = list(missing(*files))
    common = sorted(files[0] & files[1])
    for name in common:
        found += differences(given.before / name, given.after / name, name)
    for one in sorted(found, key=lambda d: (-d.relative, d.file)):
        how = "DIFFERS" if one.relative > given.relative else "within tolerance"
        print(f"{how} {one.file}: {one.relative:.3g}, {one.where}")
    equal = set(common) - {one.file for one in found}
    print(f"{len(common)} files compared, {len(equal)} equal")
    return int(any(one.relative > given.relative for one in found))


def names_of(folder: Path) -> set[str]:
    """Files that are compared, as paths within the folder."""
    names = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    kept = (name for name in names if Path(name).suffix in COMPARED)
    return {name for name in kept if not any(fnmatch(name, glob) for glob in RUN_OWN)}


def missing(before: set[str], after: set[str]) -> Iterator[Difference]:
    """Files of one folder alone."""
    yield from (Difference(name, np.inf, "gone") for name in sorted(before - after))
    yield from (Difference(name, np.inf, "new") for name in sorted(after - before))


def differences(before: Path, after: Path, name: str) -> list[Difference]:
    """Differences of one file: none or one, or one a column of a Parquet table."""
    raw = before.read_bytes(), after.read_bytes()
    if raw[0] == raw[1]:
        return []
    if before.suffix == ".parquet":
        return _tables(before, after, name)
    if before.suffix not in TEXT:
        return [Difference(name, np.inf, "other bytes")]
    found = text_difference(*(part.decode("utf-8", errors="replace") for part in raw))
    return [Difference(name, *found)] if found else []


def text_difference(before: str, after: str) -> tuple[float, str] | None:
    """Largest relative difference of the numbers of two texts and its line; infinite where what
    stands between them differs; None where nothing does."""
    if NUMBER.split(before) != NUMBER.split(after):
        lines = zip(before.splitlines(), after.splitlines(), strict=False)
        pairs = enumerate(lines, start=1)
        line = next((k for k, (a, b) in pairs if NUMBER.split(a) != NUMBER.split(b)), 0)
        return np.inf, f"other text from line {line}" if line else "more or fewer lines"
    numbers = [np.array([float(n) for n in NUMBER.findall(text)]) for text in (before, after)]
    relative = _relative(*numbers)
    if not relative.size or relative.max() == 0:
        return None
    worst = int(relative.argmax())
    place = list(NUMBER.finditer(before))[worst].start()
    return float(relative[worst]), f"line {before.count(chr(10), 0, place) + 1}"


def _relative(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """|a - b| over the larger of both; 0 where both are NaN, infinite where one is."""
    with np.errstate(invalid="ignore", divide="ignore"):
        result = np.abs(a - b) / np.maximum(np.abs(a), np.abs(b))
    result[(a == b) | (np.isnan(a) & np.isnan(b))] = 0
    result[np.isnan(a) != np.isnan(b)] = np.inf
    return result


def _tables(before: Path, after: Path, name: str) -> list[Difference]:
    a, b = (pq.read_table(path, page_checksum_verification=True) for path in (before, after))
    if a.column_names != b.column_names or a.num_rows != b.num_rows:
        return [Difference(name, np.inf, "other columns or another number of rows")]
    found = [
        Difference(name, relative, f"column {column}")
        for column in a.column_names
        if (relative := _column(a[column], b[column])) > 0
    ]
    if _origin(a) != _origin(b):
        found.append(Difference(name, np.inf, "other metadata"))
    return found


def _column(a: pa.ChunkedArray, b: pa.ChunkedArray) -> float:
    if a.type != b.type:
        return np.inf
    if pa.types.is_floating(a.type) or pa.types.is_integer(a.type):
        values = [x.to_numpy().astype(float) for x in (a, b)]
        return float(_relative(*values).max(initial=0.0))
    return 0.0 if a.equals(b) else np.inf


def _origin(table: pa.Table) -> dict[str, object]:
    """Metadata of a table but the versions of the packages that wrote it."""
    found: dict[str, object] = {}
    for key, value in (table.schema.metadata or {}).items():
        if key == SEAL:
            continue
        text = value.decode("utf-8", errors="replace")
        try:
            content = json.loads(text)
        except json.JSONDecodeError:
            content = text
        if isinstance(content, dict):
            content = {k: v for k, v in content.items() if k != VERSIONS}
        found[key.decode()] = content
    return found


if __name__ == "__main__":
    sys.exit(main())
