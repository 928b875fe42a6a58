"""Noise of an orientation: rows and figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.noise.motion.orientation import AXES, Orientation
from mocap_metrology.present.plot import curves
from mocap_metrology.present.plot.figure import LOOKS, Picture, styled, words_picture
from mocap_metrology.present.recording.recording_figures import source_words
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text import captions

TURNS_RAD = 0.0175  # 1 degree: what turns further is moved, and not measured for its noise
TURNS = "the body turns: this is its motion, not noise"


def in_radians(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of an Allan table with the units of angles in their names."""
    return {name.replace("_mm", "_rad"): values for name, values in columns.items()}


def orientation_rows(
    recording: str,
    source: str,
    allan: Mapping[str, np.ndarray],
    orientation: Orientation,
    refused: str,
) -> list[Row]:
    """One row an axis: noise of one frame, smallest Allan deviation, and how rigid the body is.

    `note` states that the body turned, which the Allan variance assumes it did not, or why there is
    no orientation (`refused`).
    """
    best = {"adev_min_rad": "adev_rad", "adev_min_lower_rad": "adev_lower_rad"}
    best |= {"adev_min_upper_rad": "adev_upper_rad", "tau_min_s": "tau_s"}
    spread, turned = orientation.spread_mm, orientation.range_rad
    of_all = {
        "residual_rms_mm": _rms(orientation.residual_mm),
        "spread_mm": None if math.isnan(spread) else spread,
        "turned_rad": None if math.isnan(turned) else turned,
        "note": TURNS if turned > TURNS_RAD else refused,
    }
    rows = []
    for axis in AXES:
        at = np.flatnonzero(allan["series"] == axis)
        adev = allan["adev_rad"][at]
        row: Row = {"recording": recording, "source": source, "axis": axis}
        row["adev_1_rad"] = adev[0] if at.size else None
        row |= {k: allan[of][at[adev.argmin()]] if at.size else None for k, of in best.items()}
        rows.append(row | of_all)
    return rows


def _rms(values: np.ndarray) -> float | None:
    """None where there is no value, as of poses that come without markers."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None


@styled()
def orientation_figure(
    allan: Mapping[str, np.ndarray],
    orientation: Orientation,
    origin: Record,
    cluster: Sequence[str],
    refused: str,
) -> Picture:
    """Allan deviation of the three components of the rotation vector, with intervals; or the words
    why there is none (`refused`)."""
    title = f"{origin['recording']}: Allan deviation of orientation"
    source = f"Source: {source_words(origin)}."
    if refused:
        return words_picture(refused, title, source)
    words = [captions.ORIENTATION]
    residual = _rms(orientation.residual_mm)
    if residual is not None:
        words.append(
            f"Cluster: {', '.join(cluster)} (Kabsch, frame by frame). The markers are "
            f"{orientation.spread_mm:.0f} mm from their centre (rms) and {1000 * residual:.3g} µm "
            "off a rigid body (rms)."
        )
    if orientation.range_rad > TURNS_RAD:
        degrees = np.degrees(orientation.range_rad)
        words.append(f"It turns by {degrees:.3g} degrees: the figure shows motion, not noise.")
    adev = curves.adev_curves(allan, {axis: axis for axis in AXES}, unit="rad")
    adev[["y", "lower", "upper"]] *= 1e6
    return curves.curves_picture(
        {"Orientation": adev},
        (curves.ADEV_AXES[0], "Allan deviation (µrad)"),
        curves.ALLAN_SLOPES,
        (title, source, " ".join(words)),
        f"{100 * origin['allan']['confidence']:.3g} % interval",
        looks={f"r{axis}": look for axis, look in LOOKS.items()},
    )
