"""What a row of a sheet says of a bar."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from mocap_metrology.accuracy.bar import Certificate
from mocap_metrology.common.errors import UNREADABLE, Refusal


@dataclass(frozen=True)
class Pose:
    """Quaternion (4,), x, y, z, w, of body B in A, and its standard uncertainty."""

    quaternion: np.ndarray
    u_deg: float


@dataclass(frozen=True)
class BarEntry:
    """Cells of a row: `A-B` or `auto`; certified length and its standard uncertainty; the stated
    rotation of B in A, as JSON."""

    bar: str
    length_mm: float | None = None
    length_u_mm: float | None = None
    bar_pose: str | None = None

    @property
    def certificate(self) -> Certificate | None:
        if self.length_mm is None:
            return None
        return Certificate(self.length_mm, self.length_u_mm or 0.0)

    @property
    def pose(self) -> Pose | None:
        """The stated rotation, refused where it is none."""
        if not self.bar_pose:
            return None
        try:
            told = json.loads(self.bar_pose)
            xyzw, u_deg = (
                np.array([*map(float, told["quaternion_xyzw"])]),
                float(told.get("u_deg", 0)),
            )
            if xyzw.size == 4 and abs(np.linalg.norm(xyzw) - 1) < 1e-3 and u_deg >= 0:
                return Pose(xyzw, u_deg)
        except UNREADABLE:
            pass
        what = 'expected JSON such as {"quaternion_xyzw": [0, 0, 0, 1], "u_deg": 0.1}'
        raise Refusal(f"bar_pose is {self.bar_pose}; {what}")
