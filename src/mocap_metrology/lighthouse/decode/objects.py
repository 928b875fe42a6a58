"""Tracked objects that a libsurvive recording describes, in its CONFIG lines."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.lighthouse.decode.libsurvive import CONFIG, Seen, blocks

UNIT = 1e-2  # deviation of the axes of a head from right angles and unit length


@dataclass(frozen=True, eq=False)
class TrackedObject:
    """An object: its name in the recording, by order of enumeration, and serial number; R (3, 3)
    and t_m (3,): its head, whose pose other programs give, in the frame of its diodes."""

    name: str
    serial: str | None = None
    R: np.ndarray = field(default_factory=lambda: np.eye(3))
    t_m: np.ndarray = field(default_factory=lambda: np.zeros(3))


def tracked_objects(path: str | Path) -> list[TrackedObject]:
    """The objects of a recording; those without a head have it in the frame of their diodes.

    Raises `Refusal` for a description that cannot be read.
    """
    texts: dict[str, bytes] = {}
    for block in blocks(path, Seen()):
        for name, text in CONFIG.findall(block):
            texts.setdefault(name.decode("utf-8", "replace"), text)
    return [_described(name, text, Path(path).name) for name, text in texts.items()]


def _described(name: str, text: bytes, file: str) -> TrackedObject:
    try:
        config = json.loads(text)
        told, head = config.get("device_serial_number"), config.get("head")
        serial = told if isinstance(told, str) else None
        if head is None:
            return TrackedObject(name, serial)
        x, z, t = (np.array(head[k], np.float64) for k in ("plus_x", "plus_z", "position"))
        R = np.column_stack([x, np.cross(z, x), z])
        if t.shape == (3,) and np.abs(R.T @ R - np.eye(3)).max() <= UNIT:
            left, _, right = np.linalg.svd(R)
            return TrackedObject(name, serial, left @ right, t)
    except UNREADABLE:
        pass
    what = "with a head of position, and plus_x and plus_z of unit length and at right angles"
    raise Refusal(f"{file}, {name}: its CONFIG is unreadable; expected JSON {what}")
