"""The header of a file of any format: its kind, labels, numbers and units."""

from __future__ import annotations

import math
import re
import stat
from pathlib import Path

from mocap_metrology.common.errors import Refusal

SLOWEST_HZ, FASTEST_HZ = 1e-3, 1e6  # beyond any system: damaged, or times in another unit
READ = (
    "what is read: C3D, TRC, CSV (Motive, Vicon, NDI First Principles, columns of markers or"
    " poses), TSV (Qualisys, First Principles), text of poses, N3D"
)
OFFICE = {
    ".xlsx": "an Excel workbook (export CSV)",
    ".xlsm": "an Excel workbook (export CSV)",
    ".docx": "a Word document",
    ".npz": "an archive of NumPy arrays",
}
SIGNATURES = (  # how a file begins, after a byte order mark
    (b"PK\x03\x04", "a ZIP archive (or an office document)"),
    (b"\xd0\xcf\x11\xe0", "an office document of the older kind (.xls, .doc; export CSV)"),
    (b"\x89PNG", "a PNG picture"),
    (b"%PDF", "a PDF document"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"<svg", "an SVG picture"),
    (b"\x1f\x8b", "a gzip archive (unpack it)"),
    (b"BZh", "a bzip2 archive"),
    (b"\xfd7zXZ", "an xz archive"),
    (b"7z\xbc\xaf", "a 7z archive"),
    (b"\x89HDF", "an HDF5 file"),
    (b"MATLAB", "a MATLAB file"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"PAR1", "a Parquet file"),
    (b"SQLite format 3\0", "an SQLite database (a ROS 2 bag?)"),
    (b"#ROSBAG", "a ROS 1 bag"),
    (b"\x89MCAP", "an MCAP file (a ROS 2 bag)"),
    (b"HIERARCHY", "a BVH file (angles of a skeleton)"),
    (b"BTS ASCII", "an EMT file (BTS; export C3D or TRC)"),
    (b"\x82K\x60A\xd3\x11\x84\xca", "a TDF file (BTS; export C3D or TRC)"),
    (b"version https://git-lfs", "a pointer to a file in Git LFS (git lfs pull fetches the file)"),
    (b"Kaydara FBX", "an FBX file (animation)"),
    (b"; FBX", "an FBX file (animation)"),
    (b"#!OML:ASF", "an AMC file (angles of a skeleton)"),
    (b"{", "a JSON file"),
)
INSIDE = (  # text in lower case within the first kilobytes
    (b"<mvnx", "an MVNX file (Xsens)"),
    (b"<svg", "an SVG picture"),
    (b":fully-specified", "an AMC file (angles of a skeleton)"),
    (b":version 1", "an ASF file (a skeleton)"),
    (b"endheader", "a MOT or STO file of OpenSim (angles, forces)"),
    (b"<html", "an HTML page"),
    (b"<?xml", "an XML file"),
)
SUFFIXES = {  # of what its contents do not show
    ".amc": "an AMC file (angles of a skeleton)",
    ".asf": "an ASF file (a skeleton)",
    ".avi": "a video",
    ".bag": "a ROS 1 bag",
    ".bvh": "a BVH file (angles of a skeleton)",
    ".db3": "a ROS 2 bag",
    ".fbx": "an FBX file (animation)",
    ".mat": "a MATLAB file",
    ".mcap": "an MCAP file (a ROS 2 bag)",
    ".md": "a Markdown document",
    ".mot": "a MOT file of OpenSim (angles, forces)",
    ".mp4": "a video",
    ".mvn": "an MVN file (Xsens)",
    ".mvnx": "an MVNX file (Xsens)",
    ".py": "a Python program",
    ".qtm": "a QTM measurement (Qualisys; export C3D or TSV)",
    ".rst": "a text document",
    ".sto": "an STO file of OpenSim (angles, forces)",
    ".tak": "a take of Motive (export C3D or CSV)",
    ".trb": "a TRB file (Motion Analysis; export TRC or C3D)",
    ".x1d": "raw data of Vicon (export C3D)",
    ".x2d": "raw data of Vicon (export C3D)",
    ".xcp": "a camera calibration of Vicon",
    ".yaml": "a YAML file",
    ".yml": "a YAML file",
}
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def regular_size(path: Path, expected: str) -> int:
    """Size in bytes of a regular file that is there and not empty; else refused."""
    try:
        status = path.stat()
    except FileNotFoundError:
        raise Refusal(f"{path.name}: no such file: {path}") from None
    except OSError as error:
        raise Refusal(f"{path.name}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # a NUL in the name
        raise Refusal(f"{path.name}: not a file name: {error}") from None
    if stat.S_ISDIR(status.st_mode):
        raise Refusal(f"{path.name}: is a folder, expected {expected}")
    if not stat.S_ISREG(status.st_mode):
        raise Refusal(f"{path.name}: is a device or a pipe, expected {expected}")
    if status.st_size == 0:
        raise Refusal(f"{path.name}: is empty, expected {expected}")
    return status.st_size


def other_kind(block: bytes, suffix: str) -> str | None:
    """What a file that begins with `block` is, if it is of a known kind that is not read here: by
    its contents, else by its suffix."""
    text = block.removeprefix(b"\xef\xbb\xbf").lstrip()
    kind = next((what for start, what in SIGNATURES if text.startswith(start)), None)
    if kind and text.startswith(b"PK"):
        return OFFICE.get(suffix.lower(), kind)
    head = text[:4096].lower()
    inside = (what for part, what in INSIDE if part in head)
    return kind or next(inside, None) or SUFFIXES.get(suffix.lower())


def refuse_other(path: Path, block: bytes, expected: str, read: str = READ) -> None:
    """Refuse a file that begins with `block` if it is of a known kind that is not read here."""
    looks = other_kind(block, path.suffix)
    if looks is None and block[1:2] == b"\x50" and b"\0" in block:
        looks = "a C3D file (suffix .c3d)"
    if looks is not None:
        raise not_read(path.name, expected, looks, read)


def not_read(file: str, expected: str, looks: str, read: str = READ) -> Refusal:
    """The refusal of a file that is something else, and what is read instead, if anything is."""
    return Refusal(
        "; ".join(filter(None, [f"{file}: is not {expected}: it looks like {looks}", read]))
    )


def number(text: str) -> float | None:
    """A finite decimal number, with a point or a comma, perhaps in a pair of quotes; None for
    anything else."""
    text = re.sub('^"(.*)"$', r"\1", text.strip())
    if "." not in text:
        text = text.replace(",", ".", 1)
    value = float(text) if NUMBER.fullmatch(text) else math.nan
    return value if math.isfinite(value) else None
