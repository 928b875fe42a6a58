"""Tell what a file is that should be a C3D file and is not."""

from __future__ import annotations

import stat
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.numbers import BLOCK

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


def regular_size(path: Path, expected: str = "a C3D file") -> int:
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


def recognise(block: bytes, file: str) -> None:
    """Refuse what is not a C3D file, by its first block."""
    looks = next((what for start, what in SIGNATURES if block.startswith(start)), None)
    if looks is None and all(byte >= 32 or byte in b"\t\r\n" for byte in block):
        looks = "text"
    elif looks is None and not any(block):
        looks = "zeros only"
    elif looks is None and block[1:2] != b"\x50":
        looks = f"another binary format (bytes {block[:2].hex(' ')}, expected a second byte of 50)"
    if looks is not None:
        raise Refusal(f"{file}: is not a C3D file: it looks like {looks}")
    if len(block) < BLOCK:
        raise Refusal(f"{file}: cut off: {len(block)} bytes, the header alone has {BLOCK}")
