"""Which recording stands for a subset of cameras of S, and what the coefficients of a twin lead to
on average."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# The recording for each row of S Table 4. Its Vantage row agrees with nine cameras;
# the tenth was the failing one, which S 3.5 excludes.
TABLE_4 = {"T40": 10, "Bonita": 10, "Vantage": 9, "All": 30}
TYPES = ("T40", "Bonita", "Vantage")
Sheet = Mapping[str, Mapping[str, Any]]  # rows of the sheet by recording


def standing_for(recordings: Sheet, camera_type: str, n_cameras: int) -> str | None:
    """Name of the recording of that subset: a measured one before a twin, then the first."""
    names = [
        name
        for name, row in recordings.items()
        if (row["camera_type"], row["n_cameras"]) == (camera_type, n_cameras)
    ]
    return min(names, key=lambda name: recordings[name]["twin"] is not None, default=None)


def source_of(recording: Mapping[str, Any] | None) -> str:
    """`twin`, `measured`, or `cited` where the published row has no recording."""
    return "cited" if recording is None else "twin" if recording["twin"] else "measured"
