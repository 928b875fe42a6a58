"""A table with its metadata."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import Metadata, open_table, read_table, write_table
from mocap_metrology.common.large import Made, in_parts
from mocap_metrology.common.types import Row
from mocap_metrology.noise.series import all_series

Series = tuple[str, np.ndarray]  # name without unit, values


@dataclass(frozen=True)
class Table:
    """Columns, and the origin in a Parquet file's schema. The first column of coordinates is
    `frame`, the others end in `_mm`; `dictionary`: columns of few different values."""

    columns: Mapping[str, np.ndarray]
    origin: Metadata
    dictionary: tuple[str, ...] = ()

    @classmethod
    def read(cls, path: str | Path) -> Table:
        return cls(*read_table(path))

    @classmethod
    def open(cls, path: str | Path) -> Table:
        """Of columns that are read when they are asked for, see `open_table`."""
        return cls(*open_table(path))

    def write(self, path: str | Path) -> None:
        write_table(path, self.columns, self.origin, self.dictionary)

    def rows(self) -> list[Row]:
        """A row for each value of the columns."""
        names, columns = list(self.columns), [self.columns[name].tolist() for name in self.columns]
        return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]

    @property
    def frame(self) -> np.ndarray:
        return self.columns["frame"]

    @property
    def coordinates(self) -> Mapping[str, np.ndarray]:
        """Series by name without unit."""
        own = (name for name in self.columns if name != "frame")
        return Made(
            (name.removesuffix("_mm") for name in own),
            lambda name: self.columns[f"{name}_mm"],
            lambda name: in_parts(self.columns, f"{name}_mm"),
        )

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Numbers of the markers whose distances are analysed."""
        return [(first, second) for first, second in self.origin["pairs"]]

    def in_mm(self) -> Iterator[Series]:
        """Name and float64 values of each column but the frame."""
        return ((name, values.astype(np.float64)) for name, values in self.coordinates.items())

    def with_distances(self) -> Iterator[Series]:
        """Name and float64 values of every coordinate, then of every pair's distance."""
        return all_series(self.coordinates, self.pairs)
