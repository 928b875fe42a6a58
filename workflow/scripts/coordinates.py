"""What the scripts of recordings share: reading a table of coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from mocap_metrology.common.files import Metadata
    from mocap_metrology.common.types import Columns


def read_coordinates(path: str) -> tuple[np.ndarray, Columns, Metadata]:
    """Frame numbers, series by name without unit, and metadata of trajectories or clean.parquet."""
    from mocap_metrology.common.files import read_table

    columns, origin = read_table(path)
    frame = columns.pop("frame")
    return frame, {name.removesuffix("_mm"): values for name, values in columns.items()}, origin
