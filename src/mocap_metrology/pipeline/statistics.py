"""Power spectral density and moments of a recording, tables in and out."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology import settings as of
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import Metadata, versions
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.common.types import Columns, Row
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.gaussian.two_markers import gaussian_rows
from mocap_metrology.noise.series import joined
from mocap_metrology.pipeline.tables import Series, Table

if TYPE_CHECKING:
    from mocap_metrology.noise.cameras.covariance import CovarianceRow

log = logging.getLogger(__name__)
PSD = ("series", "f_hz", "psd_mm2_hz", "n_segments", "n_bridged")


def spectra(
    series: Iterable[Series], origin: Metadata, settings: of.Spectrum, over: Over = in_turn
) -> Table:
    """Welch's power spectral density of every series: psd.parquet."""

    def density(one: Series) -> Columns | None:
        name, values = one
        try:
            found = welch(values, origin["frame_rate_hz"], **settings.model_dump())
        except Refusal as refusal:  # the other series are whole enough
            log.warning("%s: %s", name, refusal)
            return None
        log.info("%s: %d segments of %d frames", name, found.n_segments, found.segment)
        count = found.f_hz.size
        return {
            "series": np.full(count, name, dtype=object),
            "f_hz": found.f_hz,
            "psd_mm2_hz": found.psd,
            "n_segments": np.full(count, found.n_segments, dtype=np.int64),
            "n_bridged": np.full(count, found.n_bridged, dtype=np.int64),
        }

    parts = [part for part in over(density, series) if part]
    origin = origin | {
        "psd": settings.model_dump(),
        "versions": versions("numpy", "scipy", "pyarrow"),
    }
    return Table(joined(parts, PSD), origin)


def gaussian_model(clean: Table, settings: of.Gaussian) -> tuple[list[Row], list[CovarianceRow]]:
    """The simple Gaussian model of every pair (S Table 4): gaussian.csv; and the covariance of fast
    noise between coordinates: covariance.csv."""
    from mocap_metrology.noise.cameras.covariance import covariance_rows  # with compiled kernels

    series, origin = clean.coordinates, clean.origin
    labels, rate = origin["labels"], origin["frame_rate_hz"]
    rows = gaussian_rows(series, labels, clean.pairs, rate, settings.n_bins)
    named = [{"recording": origin["recording"]} | row for row in rows]
    return named, covariance_rows(series, len(labels), rate)
