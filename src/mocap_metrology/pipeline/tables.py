"""A table with what it says of itself, and the order in which series are worked on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np

from mocap_metrology.common.files import Metadata, read_table, write_table
from mocap_metrology.common.types import Columns
from mocap_metrology.noise.series import all_series

T = TypeVar("T")
R = TypeVar("R")
Series = tuple[str, np.ndarray]  # name without unit, values


class Over(Protocol):
    """How a function is applied to each of some items; results in their order."""

    def __call__(self, function: Callable[[T], R], items: Iterable[T], /) -> Iterable[R]: ...


def in_turn(function: Callable[[T], R], items: Iterable[T], /) -> Iterable[R]:
    """One after another."""
    return map(function, items)


@dataclass(frozen=True)
class Table:
    """Columns, and the origin in a Parquet file's schema. The first column of coordinates is
    `frame`, the others end in `_mm`; `dictionary`: columns of few different values."""

    columns: Columns
    origin: Metadata
    dictionary: tuple[str, ...] = ()

    @classmethod
    def read(cls, path: str | Path) -> Table:
        return cls(*read_table(path))

    def write(self, path: str | Path) -> None:
        write_table(path, self.columns, self.origin, self.dictionary)

    @property
    def frame(self) -> np.ndarray:
        return self.columns["frame"]

    @property
    def coordinates(self) -> Columns:
        """Series by name without unit."""
        own = (name for name in self.columns if name != "frame")
        return {name.removesuffix("_mm"): self.columns[name] for name in own}

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
