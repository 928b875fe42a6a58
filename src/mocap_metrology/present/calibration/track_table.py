"""Tracked receivers of a group: one row each, what noise and what the calibration do to a pose."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.lighthouse.rotation import log, mean
from mocap_metrology.present.tables import Record, Row, markdown

CAPTION = (
    "Poses of the board with the calibrated stations, 60 a second. Standard deviations are lengths"
    " of vectors of three axes, rms over all poses: by the noise of the hits (noise), by the error"
    " of the slave's pose (calibration), by both and errors of optics and board (total). gain:"
    " shift of the board for a slave shifted by 1 mm or turned by 1° in a random direction."
    " jitter: standard deviation of the poses of a board at rest, without those of more than twice"
    " the usual noise."
    " Seen: share of the moments with a pose, and of those that one station alone sees."
    " Stations: of the row's own calibration where empty."
)
AXES = (("mm", ("x_mm", "y_mm", "z_mm")), ("deg", ("rx_deg", "ry_deg", "rz_deg")))
KINDS = {"noise": "sd_noise_", "calibration": "sd_calibration_", "total": "sd_"}
AT_REST = ("jitter_mm", "jitter_deg")
Columns = Mapping[str, np.ndarray]


def track_row(named: Record, track: Columns, origin: Record) -> Row:
    """One row; named: `calibration`, `setup`, `source`; track, origin: of its track.parquet."""
    row: Row = {name: named[name] for name in ("calibration", "setup", "source")}
    row["stations"] = origin.get("tracked_with") or ""
    master, slave = track["n_hits_master"] > 0, track["n_hits_slave"] > 0
    seen = master | slave
    row["n_poses"] = int(seen.sum())
    share = 100 / max(seen.size, 1)
    row["seen_percent"] = share * float(seen.sum())
    row["one_station_percent"] = share * float((master ^ slave).sum())
    for kind in KINDS:
        row |= {f"{kind}_{unit}": _rms(lengths(track, kind, unit)) for unit, _ in AXES}
    row |= {name: _rms(track[name]) for name in ("gain_mm_per_mm", "gain_mm_per_deg")}
    row |= dict(zip(AT_REST, jitter(track) if origin.get("still") else (None, None), strict=True))
    row["residual_urad"] = _rms(track["residual_urad"])
    row["note"] = origin.get("reason") or origin.get("note") or ""
    return row


def track_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of some `track_row`."""
    if not rows:
        return f"# {title}\n\nNo calibrations.\n"
    return markdown(list(rows), title, f"{CAPTION} {note}".strip())


def lengths(track: Columns, kind: str, unit: str) -> np.ndarray:
    """Length (n,) of the vector of standard deviations; kind: one of `KINDS`; unit: mm or deg."""
    axes = dict(AXES)[unit]
    squares = [np.asarray(track[f"{KINDS[kind]}{axis}"], dtype=np.float64) ** 2 for axis in axes]
    return np.asarray(np.sqrt(np.sum(squares, axis=0)))


def settled(track: Columns) -> np.ndarray:
    """Poses (n,) of no more than twice the usual noise: not at an end, nor where hits are few."""
    noise = lengths(track, "noise", "mm")
    known = np.isfinite(noise)
    return known & (noise <= 2 * np.median(noise[known])) if known.any() else known


def deviations_mm(track: Columns) -> np.ndarray:
    """(n, 3) of the position from the mean of `settled` poses."""
    place = np.column_stack([track[f"{axis}_mm"] for axis in "xyz"])
    good = settled(track)
    return np.asarray(place - place[good].mean(axis=0)) if good.any() else place


def jitter(track: Columns) -> tuple[float, float]:
    """Standard deviation of the `settled` poses about their mean: lengths in mm and deg."""
    from scipy.spatial.transform import Rotation

    good = settled(track)
    if good.sum() < 2:
        return math.nan, math.nan
    q = np.column_stack([track[name][good] for name in ("qx", "qy", "qz", "qw")])
    R = Rotation.from_quat(q).as_matrix()
    both = deviations_mm(track)[good], np.degrees(log(R @ mean(R).T))
    mm, deg = (float(np.sqrt(own.var(axis=0, ddof=1).sum())) for own in both)
    return mm, deg


def _rms(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known.astype(np.float64) ** 2))) if known.size else None
