"""What the scripts of recordings share: reading a table of coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from mocap_metrology.common.files import Metadata
    from mocap_metrology.common.large import LazyArrays


def read_coordinates(path: str) -> tuple[np.ndarray, LazyArrays, Metadata]:
    """Frame numbers, series by name without unit, and metadata of trajectories or clean.parquet."""
    from mocap_metrology.common.files import open_table
    from mocap_metrology.common.large import LazyArrays

    columns, origin = open_table(path)
    names = [name.removesuffix("_mm") for name in columns if name != "frame"]
    return columns["frame"], LazyArrays(names, lambda name: columns[f"{name}_mm"]), origin
