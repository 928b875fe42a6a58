"""The header of a file of any format: its kind, labels, numbers and units."""

from __future__ import annotations

import math
import re
import stat
from pathlib import Path

from mocap_metrology.common.errors import Refusal

SIGNATURES = (
    (b"PK\x03\x04", "a ZIP archive (or an office document)"),
    (b"\x89PNG", "a PNG picture"),
    (b"%PDF", "a PDF document"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"\x89HDF", "an HDF5 file"),
    (b"MATLAB", "a MATLAB file"),
    (b"PAR1", "a Parquet file"),
)
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def regular_size(path: Path, expected: str) -> int:
    """Size in bytes of a regular file that is there and not empty; else refused."""
    try:
        status = path.stat()
    except FileNotFoundError:
        raise Refusal(f"{path.name}: no such file: {path}") from None
    except ValueError as error:  # a NUL in the name
        raise Refusal(f"{path.name}: not a file name: {error}") from None
    if stat.S_ISDIR(status.st_mode):
        raise Refusal(f"{path.name}: is a folder, expected {expected}")
    if not stat.S_ISREG(status.st_mode):
        raise Refusal(f"{path.name}: is a device or a pipe, expected {expected}")
    if status.st_size == 0:
        raise Refusal(f"{path.name}: is empty, expected {expected}")
    return status.st_size


def other_kind(block: bytes) -> str | None:
    """What a file that begins with `block` is, if it is of a kind that holds no trajectories."""
    return next((what for start, what in SIGNATURES if block.startswith(start)), None)


def number(text: str) -> float | None:
    """A finite decimal number, with a point or a comma; None for anything else."""
    text = text.strip().strip('"')
    if "." not in text:
        text = text.replace(",", ".", 1)
    value = float(text) if NUMBER.fullmatch(text) else math.nan
    return value if math.isfinite(value) else None
