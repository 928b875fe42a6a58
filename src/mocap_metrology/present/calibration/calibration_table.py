"""Calibrations of a group: one row each, the pose to use and how far to trust it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from mocap_metrology.lighthouse.published import QUANTITIES
from mocap_metrology.present.tables import Record, Row, aligned
from mocap_metrology.present.text.numbers import significant

CAPTION = (
    "Pose of the slave in the master's frame, p_master = R p_slave + t, R = Rz(γ) Ry(β) Rx(α); the"
    " frame of a station: x forwards, y to its left, z up. σ: one standard deviation, largest of"
    " three axes. Error against the reference: length of t - t_true, and the angle of R R_true^T."
    " All numbers, by axis, are in the CSV."
)
CHOSEN = ("estimator", "stage", "optics")


def calibration_rows(records: Sequence[Record]) -> list[Row]:
    """One row a calibration with the pose chosen in its pose.json.

    records: `calibration`, `setup`, `source` and `pose` (contents of pose.json).
    """
    return [_row(record) for record in records]


def _row(record: Record) -> Row:
    given = record["pose"]
    pose = {} if given["chosen"] is None else given["poses"][given["chosen"]]
    row: Row = {name: record[name] for name in ("calibration", "setup", "source")}
    row |= {f"{role}_id": given["stations"][role]["id"] for role in ("master", "slave")}
    row |= {name: pose.get(name) for name in CHOSEN}
    t = np.array(pose.get("translation_mm", [math.nan] * 3))
    angles = [
        pose.get("rotation_deg", {}).get(name, math.nan) for name in ("alpha", "beta", "gamma")
    ]
    row |= dict(zip(QUANTITIES, [*t.tolist(), *angles], strict=True))
    row["baseline_mm"] = float(np.linalg.norm(t))
    sigma = _sigma(pose.get("covariance"))
    axes = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")  # of a vector in master axes
    row |= dict(zip((f"sigma_{a}" for a in axes), sigma.tolist(), strict=True))
    row |= {name: pose.get(name) for name in ("residual_rms_urad", "n_angles", "mirrored_share")}
    found = pose.get("errors_mm") or [math.nan] * 3, pose.get("errors_deg") or [math.nan] * 3
    row |= dict(zip((f"error_{a}" for a in axes), [*found[0], *found[1]], strict=True))
    row["verdict"] = given["verdict"]["word"]
    row["reason"] = given["verdict"]["reason"]
    row["check_against"] = (given.get("check_against") or {}).get("sentence")
    return row


def _sigma(covariance: list[list[float]] | None) -> np.ndarray:
    if covariance is None:
        return np.full(6, math.nan)
    sigma: np.ndarray = np.sqrt(np.diag(np.array(covariance, dtype=np.float64)))
    return sigma


def calibration_markdown(
    rows: Sequence[Row], title: str, caption: str = CAPTION, note: str = ""
) -> str:
    """Markdown of `calibration_rows`: the poses, then the reasons of the verdicts."""
    lines = [f"# {title}", "", " ".join(filter(None, (caption, note))), ""]
    if not rows:
        return "\n".join([*lines, "No calibrations.", ""])
    head = ["calibration", "source", "master", "slave", "by", "t mm", "α β γ °", "baseline mm"]
    head += ["σ", "residual µrad", "hits", "error", "verdict"]
    lines += [*aligned([head, *(_cells(row) for row in rows)]), "", "## Verdicts", ""]
    lines += [f"- {row['calibration']}: {row['verdict']}. {row['reason']}" for row in rows]
    moved = [row for row in rows if row["check_against"]]
    if moved:
        lines += ["", "## Against an earlier pose", ""]
        lines += [f"- {row['calibration']}: {row['check_against']}" for row in moved]
    return "\n".join([*lines, ""])


def _cells(row: Row) -> list[str]:
    cells = [row["calibration"], row["source"], row["master_id"], row["slave_id"]]
    if row["estimator"] is None:
        return [*map(_text, cells), *[""] * 8, row["verdict"]]
    by = ", ".join(row[name] for name in CHOSEN)
    t = " ".join(f"{row[q]:.1f}" for q in QUANTITIES[:3])
    angles = " ".join(f"{row[q]:.3f}" for q in QUANTITIES[3:])
    residual = row["residual_rms_urad"]
    shown = [by, t, angles, f"{row['baseline_mm']:.1f}", _mm_deg(row, "sigma", max)]
    shown += ["" if residual is None else f"{residual:.0f}", row["n_angles"]]
    return [*map(_text, [*cells, *shown]), _mm_deg(row, "error", math.hypot), row["verdict"]]


def _mm_deg(row: Row, kind: str, together: Callable[..., float]) -> str:
    """`0.52 mm, 0.011°`; empty for what is unknown."""
    mm = together(*(row[f"{kind}_{axis}_mm"] for axis in "xyz"))
    deg = together(*(row[f"{kind}_r{axis}_deg"] for axis in "xyz"))
    return "" if math.isnan(mm) else f"{significant(mm)} mm, {significant(deg)}°"


def _text(value: object) -> str:
    return "" if value is None else str(value)
