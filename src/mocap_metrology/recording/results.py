"""Tables of a recording: in a folder, left in memory by the step that writes them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common import files
from mocap_metrology.common.hampel import hampel, mask_half_window, own_step, tail
from mocap_metrology.common.large import LazyArrays, in_parts
from mocap_metrology.common.types import Row
from mocap_metrology.noise.assess.recording import OutlierRow, read_outliers
from mocap_metrology.noise.fit.estimates import NoiseRow, read_noise
from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.noise.series import all_series
from mocap_metrology.settings import Settings

Series = tuple[str, np.ndarray]  # name without unit, values


@dataclass(frozen=True)
class Table:
    """Columns, and the origin in a Parquet file's schema. The first column of coordinates is
    `frame`, the others end in `_mm`; `dictionary`: columns of few different values."""

    columns: Mapping[str, np.ndarray]
    origin: files.Metadata
    dictionary: tuple[str, ...] = ()

    @classmethod
    def read(cls, path: str | Path) -> Table:
        return cls(*files.read_table(path))

    @classmethod
    def open(cls, path: str | Path) -> Table:
        """A table whose columns are read when they are asked for, see `files.open_table`."""
        return cls(*files.open_table(path))

    def write(self, path: str | Path) -> None:
        files.write_table(path, self.columns, self.origin, self.dictionary)

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
        names = (name for name in self.columns if name != "frame")
        return LazyArrays(
            (name.removesuffix("_mm") for name in names),
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


class Results:
    """Tables of a recording in the folder of its results, read when they are first used.

    movements: of coordinates, where they are known; png: whether figures are also PNG.
    """

    def __init__(self, folder: str | Path, png: bool = True):
        self.folder, self.png = Path(folder), png
        self.movements: dict[str, Movement] = {}

    @cached_property
    def raw(self) -> Table:
        """Coordinates as recorded."""
        return Table.open(self.folder / "trajectories.parquet")

    @cached_property
    def clean(self) -> Table:
        """Coordinates and distances cleaned as in S."""
        return Table.open(self.folder / "clean.parquet")

    @cached_property
    def allan_masked(self) -> Table:
        """Allan deviations of the series with their gross outliers masked."""
        return Table.read(self.folder / "allan_masked.parquet")

    @cached_property
    def psd(self) -> Table:
        """Power spectral densities of the cleaned series."""
        return Table.read(self.folder / "psd.parquet")

    @cached_property
    def noise(self) -> list[NoiseRow]:
        """Rows of noise.csv."""
        return read_noise(self.folder / "noise.csv")

    @cached_property
    def outlier_rows(self) -> list[OutlierRow]:
        """Rows of outliers.csv."""
        return read_outliers(self.folder / "outliers.csv")

    @cached_property
    def check(self) -> Mapping[str, Any]:
        """Contents of check.json; a twin has none."""
        path = self.folder / "check.json"
        return files.read_json(path) if path.exists() else {"warnings": []}


def masked(raw: Table, clean: Table, settings: Settings) -> Iterator[Series]:
    """Every series as recorded, its gross outliers NaN but those of a tail: what verdicts are of.
    (A noise model is of the series without its tail, see `masked_curve`.)"""
    rate, step = raw.origin["frame_rate_hz"], raw.origin["resolution_mm"]
    half_window = mask_half_window(settings.hampel.half_window_s, rate)
    outliers = known_outliers(clean, settings)
    for name, values in raw.with_distances():
        among = outliers(name, values)
        options = half_window, settings.noise.mask_sigma, "replace", max(step, own_step(values))
        filtered = hampel(values, *options, among)
        gross = filtered.outlier
        if among is not None:
            gross = gross & ~tail(filtered, values, among, settings.hampel.n_sigma, half_window)
        yield name, np.where(gross, np.nan, values)


def known_outliers(
    clean: Table, settings: Settings
) -> Callable[[str, np.ndarray], np.ndarray | None]:
    """Name and values as recorded -> (n,) the samples that the filter of S changed, among which the
    grosser outliers are; None where it was another window, or a higher threshold."""
    chosen, rate = settings.hampel, clean.origin["frame_rate_hz"]
    same = round(chosen.half_window_s * rate) == mask_half_window(chosen.half_window_s, rate)
    same &= chosen.action != "off" and chosen.n_sigma <= settings.noise.mask_sigma
    return lambda name, values: (clean.coordinates[name] != values) if same else None
