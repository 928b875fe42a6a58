"""Files that are not read are named for what they are, by content first and suffix second."""

import gzip
import io
import sqlite3
import zipfile

import matplotlib.pyplot as plt
import numpy as np
import pyarrow as pa
import pytest
import scipy.io
from pyarrow import parquet

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.header import READ
from mocap_metrology.io.read import labels_of, read_recording

BVH = b"HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 0\n  CHANNELS 6 Xposition\n}\nMOTION\nFrames: 2\n"
MOT = b"Coordinates\nversion=1\nnRows=2\nnColumns=3\nendheader\ntime\thip\tknee\n0\t1\t2\n"


def picture(kind: str) -> bytes:
    figure, stream = plt.figure(figsize=(1, 1)), io.BytesIO()
    figure.savefig(stream, format=kind)
    plt.close(figure)
    return stream.getvalue()


def archive() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as one:
        one.writestr("a.txt", "a")
    return stream.getvalue()


def matlab() -> bytes:
    scipy.io.savemat(stream := io.BytesIO(), {"x": np.arange(3)})
    return stream.getvalue()


def table() -> bytes:
    parquet.write_table(pa.table({"x": [1.0, 2.0]}), stream := io.BytesIO())
    return stream.getvalue()


KINDS = {  # suffix, content, what it is; real writers where there are such
    "bvh": (BVH, "a BVH file"),
    "mot": (MOT, "a MOT or STO file of OpenSim"),
    "sto": (MOT, "a MOT or STO file of OpenSim"),
    "mvnx": (b'<?xml version="1.0"?>\n<mvnx version="4">\n</mvnx>\n', "an MVNX file"),
    "emt": (b"BTS ASCII format\n\nType:\tPoint tracks\n", "an EMT file (BTS"),
    "tdf": (b"\x82K\x60A\xd3\x11\x84\xca" + bytes(99), "a TDF file (BTS"),
    "dat": (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d\n", "a pointer to a file"),
    "xml": (b'<?xml version="1.0"?>\n<a/>\n', "an XML file"),
    "bag": (b"#ROSBAG V2.0\n", "a ROS 1 bag"),
    "mcap": (b"\x89MCAP0\r\n\x01", "an MCAP file"),
    "xlsx": (archive(), "an Excel workbook"),
    "zip": (archive(), "a ZIP archive"),
    "gz": (gzip.compress(b"abc"), "a gzip archive"),
    "png": (picture("png"), "a PNG picture"),
    "svg": (picture("svg"), "an SVG picture"),
    "pdf": (picture("pdf"), "a PDF document"),
    "jpg": (picture("jpeg"), "a JPEG picture"),
    "gif": (b"GIF89a\1\0\1\0", "a GIF picture"),
    "mat": (matlab(), "a MATLAB file"),
    "h5": (b"\x89HDF\r\n\x1a\n\0\0", "an HDF5 file"),
    "parquet": (table(), "a Parquet file"),
    "amc": (b"#!OML:ASF F:\\a.ASF\n:FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3\n", "an AMC file"),
    "asf": (b"# AST/ASF file\n:version 1.10\n:name VICON\n", "an ASF file"),
    "fbx": (b"Kaydara FBX Binary  \0\x1a\0", "an FBX file"),
    "md": (b"# Notes\n\nThe markers stood still.\n", "a Markdown document"),
    "qtm": (b"\1\2\3\4\5", "a QTM measurement"),
    "x1d": (b"\1\2\3\4\5", "raw data of Vicon"),
    "x2d": (b"\1\2\3\4\5", "raw data of Vicon"),
    "tak": (b"\1\2\3\4\5", "a take of Motive"),
}


BY_SUFFIX = ("xlsx", "md", "qtm", "x1d", "x2d", "tak")
OTHERS = ("c3d", "csv", "n3d")


@pytest.mark.parametrize(
    ("kind", "suffix"),
    [(kind, kind) for kind in KINDS]
    + [(kind, other) for kind in KINDS if kind not in BY_SUFFIX for other in OTHERS],
)
def test_named_and_with_the_list_of_what_is_read(tmp_path, kind, suffix):
    """Under its own suffix; by its content under another, where this shows it."""
    content, what = KINDS[kind]
    (path := tmp_path / f"a.{suffix}").write_bytes(content)
    for use in (labels_of, lambda path: read_recording([path], ["A"])):
        with pytest.raises(Refusal) as caught:
            use(path)
        assert f"it looks like {what}" in str(caught.value)
        assert str(caught.value).endswith(READ)


def test_a_database_and_a_c3d_file_under_another_suffix(tmp_path):
    sqlite3.connect(bag := tmp_path / "a.db3").execute(
        "CREATE TABLE messages (id)"
    ).connection.commit()
    write_c3d(c3d := tmp_path / "a.csv", ["A"], 100, [np.ones((5, 1, 3))], 5)
    for path, what in ((bag, "ROS 2 bag"), (c3d, "a C3D file (suffix .c3d)")):
        with pytest.raises(Refusal, match="it looks like") as caught:
            labels_of(path)
        assert what in str(caught.value)
