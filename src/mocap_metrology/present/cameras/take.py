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
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR
from mocap_metrology.noise.series import AXES
from mocap_metrology.present.cameras.camera_tables import addition_rows, law_rows
from mocap_metrology.present.tables import Row


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
        first = next(iter(self.origins.values()))
        return [
            name
            for name, origin in self.origins.items()
            if origin["frame_rate_hz"] == first["frame_rate_hz"]
            and len(origin["labels"]) == len(first["labels"])
        ]

    def n_frames(self, name: str) -> int:
        return len(read_table(self.paths[name], ["frame"])[0]["frame"])

    def _read(self, name: str, marker: int) -> np.ndarray:
        """(3, n) coordinates in mm of one marker, numbered from 1; NaN where missing or masked."""
        origin = self.origins[name]
        wanted = [f"{axis}{marker}_mm" for axis in AXES]
        columns, _ = read_table(self.paths[name], wanted)
        half = max(round(self.half_window_s * origin["frame_rate_hz"]), SHORT_WINDOW)
        step = origin["resolution_mm"]
        series = (columns[column] for column in wanted)
        return np.array([hampel(s, half, self.mask_sigma, "mask", step).values for s in series])


def of_take(
    camera_type: str,
    camera_ids: Mapping[str, Sequence[int | str]],
    take: Take,
    sigma_mm: Mapping[str, Mapping[str, float]],
    noise: Mapping[str, Sequence[Row]],
    rise: float,
    log: logging.Logger,
) -> tuple[list[Row], list[Row]]:
    """Rows of <group>_cameras and of <group>_camera_law; sigma_mm: by recording and series."""
    names = take.comparable()
    for name in camera_ids.keys() - set(names):
        log.warning("%s: frame rate or markers differ from those of %s; excluded", name, names[0])
    ids = {name: camera_ids[name] for name in names}
    found = additions(ids)
    rows: list[Row] = []
    if found:
        origin = take.origins[names[0]]
        labels = origin["labels"]
        n_frames = min(take.n_frames(name) for name in names)
        steps = {name: take.origins[name]["resolution_mm"] for name in names}
        rate = origin["frame_rate_hz"]
        try:
            sums = moments(found, take.read, len(labels), rate, n_frames, steps)
        except Refusal as refusal:  # the law needs no shared frames
            log.warning("%s: %s", camera_type, refusal)
        else:
            labels = [labels[k] for k in sums.markers]
            told = diagnose(sums, found, ids)
            rows = addition_rows(camera_type, found, ids, labels, told, rise)
    h_0 = {
        name: {
            row["series"]: row["value"]
            for row in noise[name]
            if row["parameter"] == "h_0" and row["estimator"] == DEFAULT_ESTIMATOR
        }
        for name in names
    }
    counts = {name: len(ids[name]) for name in names}
    return rows, law_rows(camera_type, counts, {n: sigma_mm[n] for n in names}, h_0)


def one_frame(covariance: pd.DataFrame) -> dict[str, float]:
    """Allan deviation at one frame in mm by coordinate, out of covariance.csv."""
    own = covariance[(covariance["m"] == 1) & (covariance["series_1"] == covariance["series_2"])]
    return dict(zip(own["series_1"], own["covariance_mm2"] ** 0.5, strict=True))


def levels_of(
    camera_ids: Mapping[str, Sequence[int | str]], sigma_mm: Mapping[str, Mapping[str, float]]
) -> dict[str, Row]:
    """What `camera_figure` needs of each recording: number of cameras, ids that the largest subset
    has and this one lacks, deviations."""
    largest = max(camera_ids.values(), key=len)
    return {
        name: {"n": len(ids), "without": [i for i in largest if i not in ids], **sigma_mm[name]}
        for name, ids in camera_ids.items()
    }
