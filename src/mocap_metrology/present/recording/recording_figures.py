"""Figure of one recording: Allan deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.present.plot import curves as plot
from mocap_metrology.present.plot.figure import Picture, styled
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import mm

MOST_NAMED = 2  # files
LEAST_STEP_MM = 1e-9  # as of float64; smaller sizes in mm are written as 0


def source_words(origin: Record) -> str:
    """`simulated stand-in (twin) T40-10`, or `measured, take.c3d`; many segments are counted.

    origin: metadata of a table of the recording.
    """
    if origin["twin"]:
        return f"simulated stand-in (twin) {origin['twin']}"
    paths = (part["path"] for part in origin.get("segments") or ())
    files = list(dict.fromkeys(path.rpartition("/")[2] for path in paths))
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

    columns: of `allan_masked.parquet`, one row a point (see `adev_curves`); `source`: the line at
    the foot; `remarks`: what the caption adds; `expected`: series that should be there, one that is
    not is drawn as without valid samples; `confidence` (0 ... 1) of the interval.
    """
    names = [*np.asarray(columns["series"]).astype(str).tolist(), *expected]
    curves = plot.adev_curves(columns, {name: name for name in names})
    facets = plot.facets(curves["curve"]).items()
    return plot.curves_picture(
        {title: curves[curves["curve"].isin(own)] for title, own in facets},
        plot.ADEV_AXES,
        plot.ALLAN_SLOPES,
        (title, source, f"{captions.ADEV} {remarks}"),
        "interval" if confidence is None else f"{100 * confidence:.3g} % interval",
    )
