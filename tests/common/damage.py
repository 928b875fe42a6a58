"""Damaged copies of files of results, and what becomes of each when a step reads it.

    python tests/common/damage.py results/quick [--mutants 1000] [--seed 1] [--without-checksums]

`found`: refused as damaged. `harmless`: all that is read of it is as before. `silent`: it is read,
and is not as before. `other`: any other error. `--without-checksums`: text as on a file system that
keeps no extended attributes.
"""

from __future__ import annotations

import argparse
import itertools
import os
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Damaged
from mocap_metrology.common.files import CHECKSUM, read_metadata, read_table, verify

BLOCK = 512  # bytes of a sector
KINDS = ("bit", "bit near the end", "zeros", "garbage", "garbage near the end", "cut")
END = 4096  # bytes from the end that hold the footer of a Parquet file


def mutants(content: bytes, seed: int) -> Iterator[tuple[str, bytes]]:
    """Kind and bytes of damaged copies without end, each different from the content."""
    draw = np.random.default_rng(seed)
    for kind in itertools.cycle(KINDS):
        first = max(len(content) - END, 0) if kind.endswith("near the end") else 0
        at = int(draw.integers(first, len(content)))
        end = min(at + BLOCK, len(content))
        found = bytearray(content)
        if kind.startswith("bit"):
            found[at] ^= 1 << int(draw.integers(8))
        elif kind == "zeros":
            found[at:end] = bytes(end - at)
        elif kind == "cut":
            del found[at:]
        else:
            found[at:end] = draw.bytes(end - at)
        if bytes(found) != content:
            yield kind, bytes(found)


def has_checksum(path: Path) -> bool:
    """Whether its file system keeps one."""
    return hasattr(os, "listxattr") and CHECKSUM in os.listxattr(path)


def content(path: Path) -> object:
    """All that a step can read of a file: every value and the metadata of Parquet, or the bytes."""
    verify(path)
    if path.suffix != ".parquet":
        return path.read_bytes()
    columns, metadata = read_table(path)
    assert read_metadata(path) == metadata
    exact = {name: (str(v.dtype), v.tobytes() if v.dtype != object else v.tolist())
             for name, v in columns.items()}  # fmt: skip
    return exact, metadata


def outcomes(path: Path, n: int, seed: int, checksum: bool = True) -> Counter[tuple[str, str]]:
    """Kind and outcome of `n` damaged copies of a file, counted."""
    counts: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        (Path(folder) / path.parent.name).mkdir()
        copy = Path(shutil.copy2(path, Path(folder) / path.parent.name))  # with its checksum
        if not checksum and has_checksum(copy):
            os.removexattr(copy, CHECKSUM)
        expected = content(copy)
        for kind, damaged in itertools.islice(mutants(path.read_bytes(), seed), n):
            copy.write_bytes(damaged)
            try:
                counts[kind, "harmless" if content(copy) == expected else "silent"] += 1
            except Damaged:
                counts[kind, "found"] += 1
            except Exception as error:
                counts[kind, f"other: {type(error).__name__}"] += 1
    return counts


def main() -> int:
    """Print what becomes of the mutants of all tables, CSV and JSON files of some results."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("--mutants", type=int, default=1000, help="of each kind of file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--without-checksums", action="store_true", help="of text")
    given = parser.parse_args()
    silent = 0
    for suffix in (".parquet", ".csv", ".json"):
        folders = ("recordings", "calibrations")
        paths = sorted(p for f in folders for p in (given.results / f).glob(f"*/*{suffix}"))
        names = {path.name: path for path in paths if path.stat().st_size}  # one of each name
        counts: Counter[tuple[str, str]] = Counter()
        for k, path in enumerate(names.values()):
            share = given.mutants // len(names) + (k < given.mutants % len(names))
            counts += outcomes(path, share, given.seed + k, not given.without_checksums)
        for (kind, outcome), n in sorted(counts.items()):
            print(f"{suffix:9} {kind:22} {outcome:10} {n:6d}")
            silent += n if outcome not in ("found", "harmless") else 0
    return 1 if silent else 0


if __name__ == "__main__":
    sys.exit(main())
