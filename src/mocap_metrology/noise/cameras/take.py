"""From the stored recordings of one take's camera subsets to rows of tables."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_metadata, read_table
from mocap_metrology.common.hampel import SHORT_WINDOW, hampel
from mocap_metrology.noise.cameras.diagnosis import additions, diagnose, moments
from mocap_metrology.noise.cameras.findings import Row, addition_rows, law_rows
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow
from mocap_metrology.noise.series import AXES

Ids = Mapping[str, Sequence[int | str]]  # ids of cameras by recording
Deviations = Mapping[str, Mapping[str, float]]  # mm, by recording and series


class Take:
    """Recordings of one take: paths of their trajectories.parquet by name.

    Outliers beyond `mask_sigma` are gaps, as for the noise coefficients: replacing them at 3 sigma,
    in each recording others, would add noise that its subsets do not share.
    """

    def __init__(self, paths: Mapping[str, Path], mask_sigma: float, half_window_s: float) -> None:
        self.paths, self.mask_sigma, self.half_window_s = paths, mask_sigma, half_window_s
        self.origins = {name: read_metadata(path) for name, path in paths.items()}
        self.read = lru_cache(maxsize=2)(self._read)  # a chain needs each recording twice in a row

    def comparable(self) -> list[str]:
        """Recordings with the frame rate and the number of markers of the first."""
        kinds = {n: (o["frame_rate_hz"], len(o["labels"])) for n, o in self.origins.items()}
        first = next(iter(kinds.values()))
        return [name for name, kind in kinds.items() if kind == first]

    def n_frames(self, name: str) -> int:
        """Frames of a recording."""
        return len(read_table(self.paths[name], ["frame"])[0]["frame"])

    def _read(self, name: str, marker: int) -> np.ndarray:
        """(3, n) coordinates in mm of one marker, numbered from 1; NaN where missing or masked."""
        origin = self.origins[name]
        names = [f"{axis}{marker}_mm" for axis in AXES]
        columns, _ = read_table(self.paths[name], names)
        half = max(round(self.half_window_s * origin["frame_rate_hz"]), SHORT_WINDOW)
        how = half, self.mask_sigma, "mask", origin["resolution_mm"]
        return np.array([hampel(columns[column], *how).values for column in names])


def take_rows(
    camera_type: str,
    camera_ids: Ids,
    take: Take,
    sigma_mm: Deviations,
    noise: Mapping[str, Sequence[NoiseRow]],
    rise: float,
    log: logging.Logger,
) -> tuple[list[Row], list[Row]]:
    """Rows of <group>_cameras and of <group>_camera_law; sigma_mm: by recording and series."""
    names = take.comparable()
    for name in camera_ids.keys() - set(names):
        log.warning("%s: frame rate or markers differ from those of %s; excluded", name, names[0])
    ids = {name: camera_ids[name] for name in names}
    rows: list[Row] = []
    if pairs := additions(ids):
        origin = take.origins[names[0]]
        labels, rate = origin["labels"], origin["frame_rate_hz"]
        n_frames = min(take.n_frames(name) for name in names)
        steps = {name: take.origins[name]["resolution_mm"] for name in names}
        try:
            sums = moments(pairs, take.read, len(labels), rate, n_frames, steps)
        except Refusal as refusal:  # the law needs no shared frames
            log.warning("%s: %s", camera_type, refusal)
        else:
            labels = [labels[k] for k in sums.markers]
            rows = addition_rows(camera_type, pairs, ids, labels, diagnose(sums, pairs, ids), rise)
    h_0 = {
        name: {
            row["series"]: row["value"]
            for row in noise[name]
            if row["parameter"] == "h_0" and row["estimator"] == DEFAULT_ESTIMATOR
        }
        for name in names
    }
    return rows, law_rows(camera_type, {n: len(i) for n, i in ids.items()}, sigma_mm, h_0)


def one_frame(covariance: pd.DataFrame) -> dict[str, float]:
    """Allan deviation at one frame in mm by coordinate, out of covariance.csv."""
    diagonal = covariance[
        (covariance["m"] == 1) & (covariance["series_1"] == covariance["series_2"])
    ]
    return dict(zip(diagonal["series_1"], diagonal["covariance_mm2"] ** 0.5, strict=True))


def levels_of(camera_ids: Ids, sigma_mm: Deviations) -> dict[str, Row]:
    """For each recording the number `n` of its cameras, the ids of those cameras of the largest
    subset that it is `without`, and its deviations."""
    largest = max(camera_ids.values(), key=len)
    return {
        name: {"n": len(ids), "without": [i for i in largest if i not in ids], **sigma_mm[name]}
        for name, ids in camera_ids.items()
    }
