"""Figures of one recording: Allan deviation, power spectrum, and trajectories."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.present.plot.curves import (
    ALLAN_SLOPES,
    PSD_SLOPES,
    Curve,
    arrange,
    curves_picture,
    log_limits,
)
from mocap_metrology.present.plot.decimate import log_bins
from mocap_metrology.present.plot.figure import Picture, styled
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import mm

MOST_NAMED = 2  # files


def source_words(origin: Record) -> str:
    """`simulated stand-in (twin) T40-10`, or `measured, take.c3d`; many segments are counted.

    origin: metadata of a table of the recording.
    """
    if origin["twin"]:
        return f"simulated stand-in (twin) {origin['twin']}"
    files = [part["path"].rpartition("/")[2] for part in origin.get("segments") or ()]
    files = list(dict.fromkeys(files))
    if len(files) > MOST_NAMED:
        return f"measured, {files[0]} and {len(files) - 1} more files"
    return ", ".join(["measured", " and ".join(files)] if files else ["measured"])


def step_words(resolution_mm: float, kind: str) -> str:
    """`step 61 nm (float32)`: of the stored values, in a unit that needs no power of ten."""
    if not resolution_mm > 0:
        return "step unknown"
    if resolution_mm < LEAST_STEP_MM:
        return f"step below 0.001 nm ({kind})"
    return f"step {mm(resolution_mm, 2)} ({kind})"


LEAST_STEP_MM = 1e-9  # as of float64; smaller sizes in mm are written as 0
ESTIMATORS = ("oadev", "mdev", "hdev")
BINS_PER_DECADE = 40  # of a power spectrum; 0.4 mm each where two panels share a row
ALLAN_DECADES, PSD_DECADES = 7, 14  # shown at most: below is rounding
FARTHEST_BAND = 4.0  # an interval counts for the limits up to so many times the deviation


@styled()
def allan_figure(
    columns: Mapping[str, np.ndarray],
    title: str,
    source: str,
    remarks: str = "",
    *,
    expected: Sequence[str] = (),
    confidence: float | None = None,
) -> Picture:
    """Allan deviation over averaging time of every series of a recording.

    columns: of `allan_masked.parquet`, one row a point: `series`, `estimator`, `tau_s`, `adev_mm`,
    `adev_lower_mm`, `adev_upper_mm`. oadev is drawn with its interval, other estimators as thin
    lines; without oadev, the first estimator available. `source`: the line
    at the foot; `remarks`: what the caption adds; `expected`: series that should be there, one that
    is not is drawn as without valid samples; `confidence` (0 ... 1) of the interval.
    """
    curves = _allan_curves(columns, expected)
    bands = [
        np.clip(bound, curve.y / FARTHEST_BAND, curve.y * FARTHEST_BAND)
        for curve in curves
        for bound in curve.band or ()
    ]
    return curves_picture(
        arrange(curves),
        (r"Averaging time $\tau$ (s)", "Allan deviation (mm)"),
        (
            log_limits([c.x for c in curves]),
            log_limits([c.y for c in curves] + bands, 1.0, ALLAN_DECADES),
        ),
        ALLAN_SLOPES,
        (title, source, f"{captions.ADEV} {remarks}"),
        "interval" if confidence is None else f"{100 * confidence:.3g} % interval",
    )


def _allan_curves(columns: Mapping[str, np.ndarray], expected: Sequence[str]) -> list[Curve]:
    """A curve a series, of the first estimator there is; the others beside it."""
    names = np.asarray(columns["series"]).astype(str)
    estimator = np.asarray(columns["estimator"]).astype(str)
    present = [e for e in ESTIMATORS if np.any(estimator == e)] or ["oadev"]
    tau, adev, lower, upper = (
        np.asarray(columns[key], dtype=np.float64)
        for key in ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
    )
    curves = []
    for name in _in_order(names, expected):
        rows = {e: np.flatnonzero((names == name) & (estimator == e)) for e in present}
        main = rows[present[0]]
        extra = tuple((e, tau[rows[e]], adev[rows[e]]) for e in present[1:])
        curves.append(Curve(name, tau[main], adev[main], (lower[main], upper[main]), extra=extra))
    return curves


@styled()
def psd_figure(
    columns: Mapping[str, np.ndarray],
    title: str,
    source: str,
    remarks: str = "",
    *,
    expected: Sequence[str] = (),
) -> Picture:
    """Power spectral density of every series of a recording.

    columns: of `psd.parquet`, one row a point: `series`, `f_hz`, `psd_mm2_hz`, f ascending within a
    series. 40 bins a decade: the line is the median of a bin, the band reaches to its greatest
    value, so a narrow line shows as high as it is. The rest as in `allan_figure`.
    """
    names = np.asarray(columns["series"]).astype(str)
    f_hz, psd = (np.asarray(columns[key], dtype=np.float64) for key in ("f_hz", "psd_mm2_hz"))
    curves = []
    for name in _in_order(names, expected):
        rows = names == name
        bins = log_bins(f_hz[rows], psd[rows], BINS_PER_DECADE)
        band = bins.median, bins.high
        curves.append(Curve(name, bins.centre, bins.median, band, outlined=True))
    highs = [curve.band[1] for curve in curves if curve.band]
    return curves_picture(
        arrange(curves),
        ("Frequency (Hz)", "Power spectral density (mm²/Hz)"),
        (
            log_limits([c.x for c in curves]),
            log_limits([c.y for c in curves] + highs, 2.0, PSD_DECADES),
        ),
        PSD_SLOPES,
        (title, source, f"{captions.PSD} {remarks}"),
        "median to greatest value",
    )


def _in_order(names: np.ndarray, expected: Sequence[str]) -> list[str]:
    """Distinct series in order of appearance, then those expected that are missing."""
    return list(dict.fromkeys([*names.tolist(), *expected]))
