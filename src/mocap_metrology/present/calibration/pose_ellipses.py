"""Uncertainty of the slave's position: ellipses in a plane, and where other estimates are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.assess.pose_file import PoseEntry
from mocap_metrology.present.calibration.calibration_files import CalibrationFiles
from mocap_metrology.present.plot.figure import INK, LOOKS, Keywords, panel_title, say
from mocap_metrology.present.text.numbers import mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AREA = float(np.sqrt(-2 * np.log(0.05)))  # half axes of a 95 % ellipse of two coordinates over σ
FARTHEST = 3.0  # of what is drawn at its place, in extents of the largest ellipse
ROOM = 1.2
PLANES = {(0, 1): "from above", (0, 2): "from the right"}
OTHERS: tuple[Keywords, ...] = (
    {"marker": "s", "color": LOOKS["x"].colour},
    {"marker": "^", "color": LOOKS["z"].colour},
    {"marker": "D", "color": INK},
)
POINT: Keywords = {"ls": "", "markersize": 4.5, "markerfacecolor": "none", "zorder": 4}
REFERENCE: Keywords = {"marker": "+", "color": INK, "markersize": 8.0, "mew": 1.1}
ELLIPSES: tuple[tuple[str, float, str, Keywords], ...] = (
    ("covariance", AREA, "95 % region of the position", {"color": INK, "lw": 1.1}),
    ("covariance", 1.0, "1 σ of the position", {"color": INK, "lw": 0.7, "ls": (0, (5, 2))}),
    (
        "covariance_noise",
        AREA,
        "95 % region by noise alone",
        {"color": LOOKS["y"].colour, "lw": 0.9},
    ),
)


def ellipse(covariance: np.ndarray, plane: tuple[int, int], scale: float) -> np.ndarray:
    """Points (n, 2) with d^T C^-1 d = scale^2, C the block of the plane of a covariance."""
    values, vectors = np.linalg.eigh(covariance[np.ix_(plane, plane)])
    turn = np.linspace(0, 2 * np.pi, 121)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    points: np.ndarray = scale * (circle * np.sqrt(np.clip(values, 0, None))) @ vectors.T
    return points


def draw_ellipses(panels: Mapping[tuple[int, int], Axes], given: CalibrationFiles) -> None:
    """Ellipses about the chosen position in mm, a panel a plane, on one scale; other estimates of
    the same frame and optics, and the reference, on the border where they are far off."""
    from matplotlib.ticker import MaxNLocator

    entry = given.chosen
    known = [] if entry is None else [one for one in ELLIPSES if _known(entry, one[0])]
    for plane, axes in panels.items():
        panel_title(axes, f"Slave {PLANES[plane]}")
        if not known:
            axes.set(xticks=[], yticks=[])
            say(axes, "No covariance")
    if entry is None or not known:
        return
    covariances = {name: np.array(entry[name], dtype=np.float64) for name, *_ in known}  # type: ignore[literal-required]
    reach = AREA * np.sqrt(max(np.diag(covariances["covariance"])[:3]))
    others = _others(given, entry)
    near = [r for _, off, _ in others if (r := np.abs(off).max()) < FARTHEST * reach]
    half = ROOM * float(max([reach, *near]))
    for plane, axes in panels.items():
        for name, scale, label, how in known:
            axes.plot(*ellipse(covariances[name], plane, scale).T, label=label, **how)
        axes.plot(0, 0, "o", color=INK, ms=3.0, label=f"chosen estimate: {_kind(entry)}")
        for label, off, how in others:
            at = off[list(plane)]
            at = at / max(np.abs(at).max() / half, 1.0)
            axes.plot(*at, clip_on=False, label=label, **POINT | how)
        axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
        axes.set(xlabel=f"{'xyz'[plane[0]]} (mm)", ylabel=f"{'xyz'[plane[1]]} (mm)")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))


def _known(entry: PoseEntry, name: str) -> bool:
    values = np.array(entry.get(name) or [[np.nan]], dtype=np.float64)
    return bool(np.isfinite(values).all())


def _kind(entry: PoseEntry) -> str:
    return f"{entry['estimator']}, {entry['stage']}"


def _others(given: CalibrationFiles, entry: PoseEntry) -> list[tuple[str, np.ndarray, Keywords]]:
    """Label, distance (3,) in mm from the chosen estimate, and look."""
    at = np.array(entry["translation_mm"])
    same = [
        p
        for p in given.pose["poses"]
        if (p["optics"], p["frame"]) == (entry["optics"], entry["frame"])
        and p["stage"] != "kabsch"
        and p["estimator"] != entry["estimator"]
    ]
    found = [
        (_kind(p), np.array(p["translation_mm"]) - at, how)
        for p, how in zip(same, OTHERS, strict=False)
    ]
    if given.reference is not None:
        found.append(("reference", 1e3 * given.reference[1] - at, REFERENCE))
    return [
        (f"{label}: {mm(float(np.linalg.norm(off)), 2)} away", off, how)
        for label, off, how in found
        if np.isfinite(off).all()
    ]
