"""Contents of the files that sheets name, for the `params` of rules that read them.

Snakemake compares dates, so it does not notice a file that is replaced by one with an older date.
A hash in `params` tells them apart, and a file that is touched but not changed computes nothing.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from mocap_metrology.common.files import sha256, write_text

RECORD = Path(".snakemake/contents.json")  # so that a file is read again only if its date changes
ANNOUNCED = 2e9  # bytes to read: some seconds


def contents(paths: Iterable[str], record: Path = RECORD) -> Mapping[str, str | None]:
    """SHA-256 of each file, hex, or None where it cannot be read.

    A file whose size, identity and times are those in `record` is not read again.
    """
    known = _read(record)
    stamps = {path: _stamp(Path(path)) for path in dict.fromkeys(paths)}
    changed = [path for path, stamp in stamps.items() if stamp and known.get(path, [])[1:] != stamp]
    size = sum(stamps[path][0] for path in changed)
    if size > ANNOUNCED:
        print(f"Reading {len(changed)} new files, {size / 1e9:.1f} GB", file=sys.stderr)
    for path in changed:
        with suppress(OSError):
            known[path] = [sha256(path), *stamps[path]]
    if changed:
        with suppress(OSError):  # a folder that cannot be written to is Snakemake's to report
            write_text(record, json.dumps(known, indent=0))
    return {path: known[path][0] if stamps[path] and path in known else None for path in stamps}


def _stamp(path: Path) -> list[int]:
    """What changes with a file, as far as its folder shows: size, number, times of the data and of
    the entry (ns); empty where there is none."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return []
    return [status.st_size, status.st_ino, status.st_mtime_ns, status.st_ctime_ns]


def _read(record: Path) -> dict[str, list[Any]]:
    """What an earlier run wrote, or nothing where that is damaged."""
    try:
        stamps = json.loads(record.read_text(encoding="utf-8"))
        whole = all(isinstance(value, list) and len(value) == 5 for value in stamps.values())
    except (OSError, ValueError, AttributeError):
        return {}
    return stamps if whole else {}
