"""C3D files built byte by byte from the format's description, with any oddity asked for.

Written apart from the package's writer and reader, so that a mistake in one shows in a test.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

CODES = {"Intel": 84, "DEC": 85, "MIPS": 86}


def dec(values: np.ndarray) -> np.ndarray:
    """DEC F_floating of float32 values: 4 times the IEEE bits, 16-bit halves exchanged."""
    bits = np.asarray(values, "<f4").view("<u4").astype(np.uint64)
    bits = np.where(bits & 0x7F800000, bits + (2 << 23), 0)
    return ((bits >> 16) | ((bits & 0xFFFF) << 16)).astype("<u4")


def pack(values: Any, kind: str, processor: str) -> bytes:
    """`kind` i2 or f4, in the processor's order."""
    if processor == "DEC" and kind == "f4":
        return dec(np.asarray(values, "<f4")).tobytes()
    values = np.asarray(values)
    if kind == "i2":
        values = (values.astype(np.int64) & 0xFFFF).astype(np.uint16)
        kind = "u2"
    return values.astype((">" if processor == "MIPS" else "<") + kind).tobytes()


def record(name: str, number: int, body: bytes, processor: str, description: str = "") -> bytes:
    text = bytes([len(description)]) + description.encode()
    rest = body + text
    distance = pack([len(rest) + 2], "i2", processor)
    return bytes([len(name), number & 255]) + name.encode() + distance + rest


def body(value: Any, processor: str) -> bytes:
    """int -> int16, float -> float, str -> text, list of each -> array; bytes -> as they are."""
    if isinstance(value, bytes):
        return value
    if isinstance(value, str):
        return bytes([255, 1, len(value)]) + value.encode()
    if isinstance(value, (int, float)):
        kind = "i2" if isinstance(value, int) else "f4"
        return bytes([int(kind[1]), 0]) + pack([value], kind, processor)
    if all(isinstance(v, str) for v in value):
        width = max((len(v) for v in value), default=0)
        text = "".join(v.ljust(width) for v in value).encode("latin-1")
        return bytes([255, 2, width, len(value)]) + text
    kind = "f4" if any(isinstance(v, float) for v in value) else "i2"
    return bytes([int(kind[1]), 1, len(value)]) + pack(value, kind, processor)


def words(frame: int, base: int = 65536) -> list[int]:
    """A frame number as TRIAL stores it."""
    return [frame % base, frame // base]


def build(
    path: Path,
    points: np.ndarray,
    *,
    processor: str = "Intel",
    scale: float = -0.1,
    rate: float = 120.0,
    units: Any = "mm",
    labels: Sequence[str] | None = None,
    frames: int | float | None = -1,
    header: tuple[int, int] | None = None,
    trial: tuple[int, int] | None = None,
    trial_base: int = 65536,
    long_frames: float | None = None,
    analog: np.ndarray | None = None,
    pad: bool = True,
    point: dict[str, Any] | None = None,
    groups: dict[str, dict[str, Any]] | None = None,
    header_rate: float | None = None,
    header_scale: float | None = None,
    data_start: int | None = None,
    tail: bytes = b"",
) -> Path:
    """Write (n_frames, n_points, 4) as stored: int16 words where `scale` > 0, else float32.

    `frames` -1: the true count; None: no POINT:FRAMES; a float is stored as one.
    `header`: first and last frame as stored; (1, n) cut to 65535 if not given.
    `point` adds to or (None) removes from the POINT group; `groups` adds groups.
    """
    n, n_points, _ = points.shape
    kind = "i2" if scale > 0 else "f4"
    rows = points.reshape(n, -1)
    if analog is not None:
        rows = np.concatenate([rows, analog], axis=1)
    per_frame = rows.shape[1] - 4 * n_points
    content: dict[str, dict[str, Any]] = {
        "POINT": {
            "USED": n_points,
            "SCALE": float(scale),
            "RATE": float(rate),
            "DATA_START": 0,
            "UNITS": units,
            "LABELS": list(labels or [f"M{i + 1}" for i in range(n_points)]),
        },
        "ANALOG": {"USED": per_frame, "RATE": float(rate), "GEN_SCALE": 1.0},
    }
    if per_frame:
        content["ANALOG"] |= {
            "SCALE": [1.0] * per_frame,
            "OFFSET": [0] * per_frame,
            "LABELS": [f"A{i}" for i in range(per_frame)],
        }
    if frames is not None:
        content["POINT"]["FRAMES"] = n if frames == -1 else frames
    if long_frames is not None:
        content["POINT"]["LONG_FRAMES"] = float(long_frames)
    if trial is not None:
        content["TRIAL"] = {
            "ACTUAL_START_FIELD": words(trial[0], trial_base),
            "ACTUAL_END_FIELD": words(trial[1], trial_base),
        }
    content["POINT"] |= point or {}
    for name, group in (groups or {}).items():
        content[name] = content.get(name, {}) | group
    start = 2 + -(-len(_parameters(content, processor, 0)) // 512)
    if "DATA_START" in content["POINT"] and content["POINT"]["DATA_START"] == 0:
        content["POINT"]["DATA_START"] = start if data_start is None else data_start
    section = _parameters(content, processor, start - 2)
    first, last = header or (1, min(n, 65535))
    head = bytearray(512)
    head[:2] = 2, 0x50
    head[2:12] = pack([n_points, per_frame, first, last, 10], "i2", processor)
    head[12:16] = pack([scale if header_scale is None else header_scale], "f4", processor)
    head[16:20] = pack([start, 1 if per_frame else 0], "i2", processor)
    head[20:24] = pack([rate if header_rate is None else header_rate], "f4", processor)
    data = pack(rows, kind, processor) + tail
    padding = bytes(-len(data) % 512) if pad else b""
    path.write_bytes(bytes(head) + section.ljust((start - 2) * 512, b"\0") + data + padding)
    return path


def _parameters(groups: dict[str, dict[str, Any]], processor: str, n_blocks: int) -> bytes:
    out = bytes([1, 80, n_blocks, CODES[processor]])
    for number, (name, group) in enumerate(groups.items(), start=1):
        out += record(name, -number, b"", processor)
        for key, value in group.items():
            if value is not None:
                out += record(key, number, body(value, processor), processor)
    return out + b"\0\0"


def still(n: int, n_points: int = 2, seed: int = 1) -> np.ndarray:
    """Points at rest with noise, (n, n_points, 4) float32, fourth word 0."""
    rng = np.random.default_rng(seed)
    points = np.zeros((n, n_points, 4), np.float32)
    points[..., :3] = rng.uniform(-900, 900, (n_points, 3)) + rng.normal(0, 0.05, (n, n_points, 3))
    return points
