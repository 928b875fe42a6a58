"""Write a C3D file frame by frame, of any length: Intel float, as a lab's exporter does.

Frame counts beyond 65535 stand in POINT:LONG_FRAMES and in TRIAL, while POINT:FRAMES and the header
stay at 65535. The data end with the last frame, without padding, and there is no ROTATION group:
so that a reader that goes to the end of the file finds the right number of frames.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.files import whole
from mocap_metrology.io.c3d.parameters import BLOCK

LIMIT = 65535
LABELS_EACH = 255  # strings in one parameter: a dimension is one byte
FLOAT_SCALE = -0.1  # negative = floats; the size is what the fourth word's residual counts in

Value = int | float | str | Sequence[int] | Sequence[float] | Sequence[str]


def write_c3d(
    path: str | Path,
    labels: Sequence[str],
    frame_rate_hz: float,
    chunks: Iterable[npt.NDArray[np.floating]],
    n_frames: int,
    units: str = "mm",
    description: str = "",
    first_frame: int = 1,
    manufacturer: str = "mocap-metrology",
) -> None:
    """Write `n_frames` frames, given in `chunks` of (n, n_points, 3): coordinates in `units`, NaN =
    not measured; or of (n, n_points, 4), with the fourth word as it is to be stored, negative = not
    measured.

    Frame rate in Hz. The file is whole or absent; ValueError where the chunks do not make it up.
    """
    if not labels or len(set(labels)) < len(labels) or not all(map(_is_label, labels)):
        raise ValueError("labels must be different, printable ASCII, at most 127 characters")
    if not (math.isfinite(frame_rate_hz) and frame_rate_hz > 0):
        raise ValueError(f"frame_rate_hz is {frame_rate_hz}, expected a positive number")
    if n_frames < 1 or first_frame < 1 or first_frame + n_frames > 2**31:
        raise ValueError(f"{n_frames} frames from frame {first_frame} cannot be written")
    groups = _groups(
        list(labels), frame_rate_hz, n_frames, units, description, first_frame, manufacturer
    )
    written = 0
    with whole(path) as part, part.open("wb") as stream:
        stream.write(_front(groups, len(labels), frame_rate_hz, n_frames, first_frame))
        for chunk in chunks:
            stored = _stored(np.asarray(chunk), len(labels))
            written += len(stored)
            if written > n_frames:
                raise ValueError(f"more than the {n_frames} frames announced")
            stream.write(stored.data)
        if written < n_frames:
            raise ValueError(f"{written} frames written, {n_frames} announced")


def _stored(frames: npt.NDArray[np.floating], n_points: int) -> npt.NDArray[np.float32]:
    """Frames as stored in the file, (n, n_points, 4)."""
    if frames.ndim != 3 or frames.shape[1] != n_points or frames.shape[2] not in (3, 4):
        raise ValueError(f"frames of shape {frames.shape}, expected (n, {n_points}, 3)")
    stored = np.zeros((len(frames), n_points, 4), "<f4")
    with np.errstate(over="ignore"):  # beyond float32: infinite, hence missing
        stored[..., : frames.shape[2]] = frames
    missing = ~np.isfinite(stored[..., :3]).all(axis=2)
    stored[missing] = (0, 0, 0, -1)
    return stored


def _is_label(label: str) -> bool:
    return label.isascii() and label.isprintable() and 0 < len(label.strip()) <= len(label) <= 127


def _groups(
    labels: list[str],
    rate: float,
    n_frames: int,
    units: str,
    description: str,
    first_frame: int,
    manufacturer: str,
) -> dict[str, dict[str, Value]]:
    """Groups and parameters; POINT:DATA_START is put in once the length is known."""
    point: dict[str, Value] = {
        "USED": len(labels),
        "SCALE": FLOAT_SCALE,
        "RATE": float(rate),
        "DATA_START": 0,
        "FRAMES": min(n_frames, LIMIT),
        "LONG_FRAMES": float(n_frames),
        "UNITS": units,
        "X_SCREEN": "+X",
        "Y_SCREEN": "+Z",
    }
    for i in range(0, len(labels), LABELS_EACH):
        number = "" if i == 0 else str(i // LABELS_EACH + 1)
        some = labels[i : i + LABELS_EACH]
        point["LABELS" + number] = some
        point["DESCRIPTIONS" + number] = [""] * len(some)
    last = first_frame + n_frames - 1
    analog: dict[str, Value] = {"USED": 0, "GEN_SCALE": 1.0, "RATE": float(rate)}
    analog |= {"SCALE": [], "OFFSET": [], "LABELS": [""], "UNITS": [""]}
    return {
        "POINT": point,
        "TRIAL": {
            "ACTUAL_START_FIELD": [first_frame % 65536, first_frame // 65536],
            "ACTUAL_END_FIELD": [last % 65536, last // 65536],
            "CAMERA_RATE": float(rate),
            "DESCRIPTION": description,
        },
        "ANALOG": analog,
        "FORCE_PLATFORM": {"USED": 0, "ZERO": [1, 0]},
        "MANUFACTURER": {"COMPANY": manufacturer, "SOFTWARE": "mocap-metrology"},
    }


def _front(
    groups: dict[str, dict[str, Value]], n_points: int, rate: float, n_frames: int, first: int
) -> bytes:
    """Header and parameter section."""
    blocks = -(-len(_section(groups, 0)) // BLOCK)
    groups["POINT"]["DATA_START"] = 2 + blocks
    header = np.zeros(BLOCK // 2, "<u2")
    header[:5] = 0x5002, n_points, 0, min(first, LIMIT), min(first + n_frames - 1, LIMIT)
    header[6:8] = np.array([FLOAT_SCALE], "<f4").view("<u2")
    header[8] = 2 + blocks
    header[10:12] = np.array([rate], "<f4").view("<u2")
    return header.tobytes() + _section(groups, blocks).ljust(blocks * BLOCK, b"\0")


def _section(groups: dict[str, dict[str, Value]], n_blocks: int) -> bytes:
    records = []
    for number, (group, parameters) in enumerate(groups.items(), start=1):
        records.append(_record(group, -number, b""))
        records += [_record(name, number, _body(value)) for name, value in parameters.items()]
    return bytes((1, 0x50, min(n_blocks, 255), 84)) + b"".join(records) + bytes(2)


def _record(name: str, number: int, body: bytes) -> bytes:
    """A record with an empty description."""
    front = bytes((len(name), number % 256)) + name.encode("ascii")
    return front + (len(body) + 3).to_bytes(2, "little") + body + b"\0"


def _body(value: Value) -> bytes:
    """Type, dimensions and values of a parameter."""
    if isinstance(value, str):
        raw = value.encode("utf-8")[:255]
        return bytes((0xFF, 1, len(raw))) + raw
    if isinstance(value, int):
        return bytes((2, 0)) + np.array(value, "<i8").astype("<u2").tobytes()
    if isinstance(value, float):
        return bytes((4, 0)) + np.array(value, "<f4").tobytes()
    if value and isinstance(value[0], str):
        texts = [str(text) for text in value]
        width = max(map(len, texts))
        raw = "".join(text.ljust(width) for text in texts).encode("ascii")
        return bytes((0xFF, 2, width, len(value))) + raw
    kind, dtype = (4, "<f4") if value and isinstance(value[0], float) else (2, "<u2")
    return bytes((kind, 1, len(value))) + np.array(value, dtype).tobytes()
