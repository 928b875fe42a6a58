"""Writers of the text formats after their makers' documentation, and small files to spoil.

Positions (n_frames, n_labels, 3) in the file's unit, NaN = not measured.
"""

import struct
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.read import read_recording

LABELS = ("A", "B")


def still(n: int = 40, n_labels: int = 2) -> np.ndarray:
    """Markers that stand still, with noise of 0.05 mm, rounded to 1e-5 mm."""
    noise = np.random.default_rng(7).normal(0, 0.05, (n, n_labels, 3))
    return np.round(noise + 100.0 * np.arange(1, 3 * n_labels + 1).reshape(n_labels, 3), 5)


def triples(positions: np.ndarray, digits: int, gap: str = "") -> list[list[str]]:
    """Cells of each frame."""
    return [
        [gap if np.isnan(v) else f"{v:.{digits}f}" for v in frame.ravel()] for frame in positions
    ]


def trc(labels, rate, positions, unit="mm", digits=5, first=1) -> str:
    n, k = positions.shape[:2]
    lines = [
        "PathFileType\t4\t(X/Y/Z)\ttake.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame"
        "\tOrigNumFrames",
        f"{rate:.2f}\t{rate:.2f}\t{n}\t{k}\t{unit}\t{rate:.2f}\t{first}\t{n}",
        "Frame#\tTime\t" + "".join(f"{label}\t\t\t" for label in labels),
        "\t\t" + "".join(f"X{i}\tY{i}\tZ{i}\t" for i in range(1, k + 1)),
        "",
    ]
    for i, cells in enumerate(triples(positions, digits)):
        lines.append("\t".join([str(first + i), f"{(first + i - 1) / rate:.6f}", *cells]) + "\t")
    return "\n".join(lines) + "\n"


def motive(labels, rate, positions, unit="Millimeters", digits=6, first=0) -> str:
    n = len(positions)
    head = ["Format Version", "1.23", "Take Name", "Take 1", "Take Notes", ""]
    head += ["Capture Frame Rate", f"{rate:.6f}", "Export Frame Rate", f"{rate:.6f}"]
    head += ["Capture Start Time", "2026-11-20 10.11.12.345 AM", "Capture Start Frame", "0"]
    head += ["Total Frames in Take", str(n), "Total Exported Frames", str(n)]
    head += ["Rotation Type", "Quaternion", "Length Units", unit, "Coordinate Space", "Global"]
    three = [label for label in labels for _ in range(3)]
    lines = [
        ",".join(head),
        "",
        ",".join(["", "Type", *["Marker"] * len(three)]),
        ",".join(["", "Name", *(f'"{label}"' for label in three)]),
        ",".join(["", "ID", *(f'"{i // 3:X}F00"' for i in range(len(three)))]),
        ",".join(["", "", *["Position"] * len(three)]),
        ",".join(["Frame", "Time (Seconds)", *["X", "Y", "Z"] * len(labels)]),
    ]
    for i, cells in enumerate(triples(positions, digits)):
        lines.append(",".join([str(first + i), f"{(first + i) / rate:.6f}", *cells]))
    return "\r\n".join(lines) + "\r\n"


def qualisys(labels, rate, positions, digits=3, gap="0.000", leading=2, titles=False) -> str:
    n, k = positions.shape[:2]
    lines = [
        f"NO_OF_FRAMES\t{n}",
        "NO_OF_CAMERAS\t8",
        f"NO_OF_MARKERS\t{k}",
        f"FREQUENCY\t{rate:g}",
        "NO_OF_ANALOG\t0",
        "ANALOG_FREQUENCY\t0",
        "DESCRIPTION\t--",
        "TIME_STAMP\t2026-11-20, 10:11:12.345\t12345.67890123",
        "EVENT\tstart\t1\t0.00000",
        "EVENT\tend\t5\t0.04000",
        "DATA_INCLUDED\t3D",
        "MARKER_NAMES\t" + "\t".join(labels),
        "TRAJECTORY_TYPES\t" + "\t".join(["Measured"] * k),
    ]
    if titles:
        names = [f"{label} {axis}" for label in labels for axis in "XYZ"]
        lines.append("\t".join(["Frame", "Time"][:leading] + names))
    for i, cells in enumerate(triples(positions, digits, gap)):
        lines.append("\t".join([str(i + 1), f"{i / rate:.5f}"][:leading] + cells))
    return "\r\n".join(lines) + "\r\n"


def nexus(labels, rate, positions, unit="mm", digits=5, first=1, before="", after="") -> str:
    k = positions.shape[1]
    lines = [
        "Trajectories",
        f"{rate:g}",
        ",," + ",".join(f"{label},," for label in labels),
        "Frame,Sub Frame," + ",".join(["X,Y,Z"] * k),
        ",," + ",".join([unit] * 3 * k),
    ]
    for i, cells in enumerate(triples(positions, digits)):
        lines.append(",".join([str(first + i), "0", *cells]))
    return before + "\r\n".join(lines) + "\r\n" + after


def table(labels, rate, positions, unit="mm", digits=5, gap="", time_digits=5) -> str:
    """Columns with names: the time, then A_x [mm] ... of each label."""
    names = [f"{label}_{axis} [{unit}]" for label in labels for axis in "xyz"]
    rows = enumerate(triples(positions, digits, gap))
    lines = [",".join(["time", *names])]
    lines += [",".join([f"{i / rate:.{time_digits}f}", *cells]) for i, cells in rows]
    return "\n".join([*lines, ""])


def first_principles(labels, rate, positions, unit="mm", digits=9, gap="") -> str:
    lines = [f"Number of frames: {len(positions)}", f"Frequency: {rate:g}", f"Units: {unit}", ""]
    lines.append("\t".join(["Frame", *(f"{label} {axis}" for label in labels for axis in "xyz")]))
    for i, cells in enumerate(triples(positions, digits, gap), start=1):
        lines.append("\t".join([str(i), *cells, ""]))
    return "\r\n".join([*lines, ""])


def n3d(positions, rate, mark=32, numbers=3, frames=None) -> bytes:
    """Positions in mm as float32, below a header of 256 bytes."""
    n, k = positions.shape[:2]
    head = struct.pack("<Bhhif", mark, k, numbers, n if frames is None else frames, rate)
    head += b"user".ljust(60) + b"system".ljust(60) + b"test".ljust(30)
    head += struct.pack("<h8s2s8s", 0, b"11:22:33", b"\0\0", b"02/20/19")
    return head.ljust(256, b"\0") + positions.astype("<f4").tobytes()


WRITERS = {".trc": trc, ".motive.csv": motive, ".tsv": qualisys, ".nexus.csv": nexus}
WRITERS |= {".table.csv": table, ".fp.tsv": first_principles}


def make(folder: Path, name: str, content: str, encoding: str = "utf-8") -> Path:
    """Write a file as it stands, line ends included."""
    path = folder / name
    path.write_bytes(content.encode(encoding))
    return path


def read(path, markers=("A", "B"), **keys):
    """`read_recording` of one file or several."""
    return read_recording(path if isinstance(path, list) else [path], markers, **keys)


TAKE = still(20)
TRC = trc(LABELS, 100, TAKE)
MOTIVE = motive(LABELS, 100, TAKE)
TSV = qualisys(LABELS, 100, TAKE)
NEXUS = nexus(LABELS, 100, TAKE)
PLAIN = {"a.trc": TRC, "m.csv": MOTIVE, "a.tsv": TSV, "n.csv": NEXUS}
FIRST_ROW = {"a.trc": 7, "m.csv": 8, "a.tsv": 14, "n.csv": 6}


def refusal(path, markers=LABELS, **keys) -> str:
    with pytest.raises(Refusal) as caught:
        read(path, markers, **keys)
    return str(caught.value)


def spoilt(tmp_path, name, old, new, n=1):
    assert old in PLAIN[name]
    return make(tmp_path, name, PLAIN[name].replace(old, new, n))


def row(name, number):
    """A row of numbers (from 1) as it stands in the file."""
    return PLAIN[name].splitlines()[FIRST_ROW[name] + number - 2]
