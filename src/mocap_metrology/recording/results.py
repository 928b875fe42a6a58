"""The results of a recording: tables in a folder, left in memory by the step that writes them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from mocap_metrology.noise.assess.recording import OutlierRow, read_outliers
from mocap_metrology.noise.fit.estimates import NoiseRow, read_noise
from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.recording.table import Table


class Results:
    """Tables of a recording in the folder of its results, read when they are first used.

    movements: of coordinates, where they are known.
    """

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
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
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"warnings": []}
