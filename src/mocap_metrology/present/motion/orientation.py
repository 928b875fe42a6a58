"""Noise of an orientation: rows and figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.noise.motion.orientation import AXES, Orientation
from mocap_metrology.present.plot.curves import (
    ADEV_AXES,
    ALLAN_SLOPES,
    adev_curves,
    curves_picture,
)
from mocap_metrology.present.plot.figure import LOOKS, Picture, styled, words_picture
from mocap_metrology.present.recording.recording_figures import source_words
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text import captions

TURNS_RAD = 0.0175  # 1 degree: what turns further is moved, and not measured for its noise


def in_radians(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of an Allan table with the units of angles in their names."""
    return {
        name.replace("_mm2", "_rad2").replace("_mm", "_rad"): values
        for name, values in columns.items()
    }


def orientation_rows(
    recording: str,
    source: str,
    allan: Mapping[str, np.ndarray],
    found: Orientation,
    refused: str = "",
) -> list[Row]:
    """One row an axis: noise of one frame, smallest Allan deviation, and how rigid the body is.

    `note` states that the body turned, which the Allan variance assumes it did not, or why there is
    no orientation (`refused`).
    """
    rows = []
    for axis in AXES:
        pick = allan["series"] == axis
        tau, adev = allan["tau_s"][pick], allan["adev_rad"][pick]
        best = int(adev.argmin()) if adev.size else None
        values = {
            "adev_1_rad": adev[0] if adev.size else None,
            "adev_min_rad": None if best is None else adev[best],
            "adev_min_lower_rad": None if best is None else allan["adev_lower_rad"][pick][best],
            "adev_min_upper_rad": None if best is None else allan["adev_upper_rad"][pick][best],
            "tau_min_s": None if best is None else tau[best],
        }
        turned = found.range_rad > TURNS_RAD
        rows.append(
            {
                "recording": recording,
                "source": source,
                "axis": axis,
                **values,
                "residual_rms_mm": _rms(found.residual_mm),
                "spread_mm": None if math.isnan(found.spread_mm) else found.spread_mm,
                "turned_rad": None if math.isnan(found.range_rad) else found.range_rad,
                "note": "the body turns: this is its motion, not noise" if turned else refused,
            }
        )
    return rows


def _rms(values: np.ndarray) -> float | None:
    """None where there is no value, as of poses that come without markers."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None


@styled()
def orientation_figure(
    allan: Mapping[str, np.ndarray],
    found: Orientation,
    origin: Record,
    cluster: Sequence[str],
    refused: str = "",
) -> Picture:
    """Allan deviation of the three components of the rotation vector, with intervals; or the words
    why there is none (`refused`)."""
    title = f"{origin['recording']}: Allan deviation of orientation"
    source = f"Source: {source_words(origin)}."
    if refused:
        return words_picture(refused, title, source)
    words = [captions.ORIENTATION]
    residual = _rms(found.residual_mm)
    if residual is not None:
        words.append(
            f"Cluster: {', '.join(cluster)} (Kabsch, frame by frame). The markers are "
            f"{found.spread_mm:.0f} mm from their centre (rms) and {1000 * residual:.3g} µm off a "
            "rigid body (rms)."
        )
    if found.range_rad > TURNS_RAD:
        degrees = np.degrees(found.range_rad)
        words.append(f"It turns by {degrees:.3g} degrees: the figure shows motion, not noise.")
    curves = adev_curves(allan, {axis: axis for axis in AXES}, unit="rad")
    curves[["y", "lower", "upper"]] *= 1e6
    return curves_picture(
        {"Orientation": curves},
        (ADEV_AXES[0], "Allan deviation (µrad)"),
        ALLAN_SLOPES,
        (title, source, " ".join(words)),
        f"{100 * origin['allan']['confidence']:.3g} % interval",
        looks={f"r{axis}": look for axis, look in LOOKS.items()},
    )
