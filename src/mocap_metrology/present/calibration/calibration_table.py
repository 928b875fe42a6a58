"""Tables of a group of calibrations: poses to use, tracked receivers, noise of angles at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.lighthouse.assess.evidence import AXES, KINDS, Columns, jitter, lengths
from mocap_metrology.lighthouse.assess.pose_file import is_network, pairs
from mocap_metrology.lighthouse.published import QUANTITIES
from mocap_metrology.present.tables import Record, Row, aligned, markdown
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

NAMED = ("calibration", "setup", "source")
CHOSEN = ("estimator", "stage", "optics")
AXIS_NAMES = (*(f"{axis}_mm" for axis in "xyz"), *(f"r{axis}_deg" for axis in "xyz"))
PARTS = ("common", "independent")
OF_PART = (
    *("adev_1_urad", "adev_1_lower_urad", "adev_1_upper_urad", "exponent", "adev_min_urad"),
    *("tau_min_s", "h_0_urad2_hz"),
)
ANGLE_HEAD = (
    *(*NAMED, "rotor", "n_diodes", "n_sweeps", "sd_urad"),
    *(f"{part}_{name}" for part in PARTS for name in OF_PART),
    *("step_urad", "below_step", "independent_below_step"),
)


def calibration_rows(records: Sequence[Record]) -> list[Row]:
    """One row a calibration with the pose chosen in its pose.json, or one a station.

    records: `calibration`, `setup`, `source` and `pose` (contents of pose.json).
    """
    rows = []
    for record in records:
        for name, pose in pairs(record["pose"]).items():
            row = _calibration_row({**record, "pose": pose})
            if is_network(record["pose"]):
                row["calibration"] = f"{record['calibration']}, station {name}"
            rows.append(row)
    return rows


def _calibration_row(record: Record) -> Row:
    document = record["pose"]
    pose = {} if document["chosen"] is None else document["poses"][document["chosen"]]
    row: Row = {name: record[name] for name in NAMED}
    row |= {f"{role}_id": document["stations"][role]["id"] for role in ("master", "slave")}
    row |= {name: pose.get(name) for name in CHOSEN}
    t, turn = pose.get("translation_mm", [math.nan] * 3), pose.get("rotation_deg", {})
    angles = [turn.get(name, math.nan) for name in ("alpha", "beta", "gamma")]
    row |= dict(zip(QUANTITIES, [*map(float, t), *angles], strict=True))
    row["baseline_mm"] = float(np.linalg.norm(t))
    covariance = pose.get("covariance")
    variances = np.full(6, math.nan) if covariance is None else np.diag(np.array(covariance, float))
    sigma = np.sqrt(variances).tolist()
    row |= dict(zip((f"sigma_{axis}" for axis in AXIS_NAMES), sigma, strict=True))
    row |= {name: pose.get(name) for name in ("residual_rms_urad", "n_angles", "mirrored_share")}
    unknown = [math.nan] * 3
    errors = [*(pose.get("errors_mm") or unknown), *(pose.get("errors_deg") or unknown)]
    row |= dict(zip((f"error_{axis}" for axis in AXIS_NAMES), errors, strict=True))
    row |= {"verdict": document["verdict"]["word"], "reason": document["verdict"]["reason"]}
    row["check_against"] = (document.get("check_against") or {}).get("sentence")
    return row


def calibration_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of `calibration_rows`: the poses, then the reasons of the verdicts."""
    lines = [f"# {title}", "", f"{captions.CALIBRATION_TABLE} {note}".strip(), ""]
    if not rows:
        return "\n".join([*lines, "No calibrations.", ""])
    head = ["calibration", "source", "master", "slave", "by", "t mm", "α β γ °", "baseline mm"]
    head += ["σ", "residual µrad", "hits", "error", "verdict"]
    lines += [*aligned([head, *(_cells(row) for row in rows)]), "", "## Verdicts", ""]
    lines += [f"- {row['calibration']}: {row['verdict']}. {row['reason']}" for row in rows]
    moved = [f"- {row['calibration']}: {row['check_against']}" for row in rows
             if row["check_against"]]  # fmt: skip
    lines += ["", "## Against an earlier pose", "", *moved] if moved else []
    return "\n".join([*lines, ""])


def _cells(row: Row) -> list[object]:
    cells = [row["calibration"], row["source"], row["master_id"], row["slave_id"]]
    if row["estimator"] is None:
        return [*cells, *[""] * 8, row["verdict"]]
    cells.append(", ".join(row[name] for name in CHOSEN))
    cells.append(" ".join(f"{row[q]:.1f}" for q in QUANTITIES[:3]))
    cells.append(" ".join(f"{row[q]:.3f}" for q in QUANTITIES[3:]))
    cells += [f"{row['baseline_mm']:.1f}", _mm_and_deg(row, "sigma")]
    residual = row["residual_rms_urad"]
    cells += ["" if residual is None else f"{residual:.0f}", row["n_angles"]]
    return [*cells, _mm_and_deg(row, "error"), row["verdict"]]


def _mm_and_deg(row: Row, kind: str) -> str:
    """`0.52 mm, 0.011°`, the largest sigma or the length of an error; empty if unknown."""
    values = [row[f"{kind}_{axis}"] for axis in AXIS_NAMES]
    mm, deg = (
        max(own) if kind == "sigma" else math.hypot(*own) for own in (values[:3], values[3:])
    )
    return "" if math.isnan(mm) else f"{significant(mm)} mm, {significant(deg)}°"


def track_row(named: Record, track: Columns, origin: Record) -> Row:
    """One row of tracked receivers; named: `calibration`, `setup`, `source`; track, origin: of its
    track.parquet."""
    row: Row = {name: named[name] for name in NAMED}
    row["stations"] = origin.get("tracked_with") or ""
    hits = [track[name] > 0 for name in track if name.startswith("n_hits_")]
    seen, share = np.any(hits, axis=0), 100 / max(hits[0].size, 1)
    row |= {"n_poses": int(seen.sum()), "seen_percent": share * float(seen.sum())}
    row["one_station_percent"] = share * float((np.sum(hits, axis=0) == 1).sum())
    for kind in KINDS:
        row |= {f"{kind}_{unit}": _rms(lengths(track, kind, unit)) for unit in AXES}
    row |= {name: _rms(track[name]) for name in ("gain_mm_per_mm", "gain_mm_per_deg")}
    scatter = jitter(track) if origin.get("still") else (None, None)
    row |= dict(zip(("jitter_mm", "jitter_deg"), scatter, strict=True))
    row["residual_urad"] = _rms(track["residual_urad"])
    row["note"] = origin.get("reason") or origin.get("note") or ""
    return row


def _rms(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known.astype(np.float64) ** 2))) if known.size else None


def track_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of some `track_row`."""
    if not rows:
        return f"# {title}\n\nNo calibrations.\n"
    return markdown(list(rows), title, f"{captions.TRACK_TABLE} {note}".strip())


def angle_rows(named: Record, allan: Mapping[str, np.ndarray], origin: Record) -> list[Row]:
    """Rows of one calibration, one a rotor, none of a board that moved; named: `calibration`,
    `setup`, `source`; allan, origin: of its allan.parquet."""
    rows = []
    for rotor in origin["rotors"]:
        row: Row = {name: named[name] for name in NAMED}
        row |= {"rotor": rotor["rotor"].replace("_", ", "), "n_diodes": len(rotor["diodes"])}
        row |= {"n_sweeps": rotor["sweeps"], "sd_urad": 1e6 * rotor["sd_rad"]}
        for part in PARTS:
            of_part = _angle_cells(allan, f"{rotor['rotor']}_{part}")
            row |= {f"{part}_{name}": value for name, value in of_part.items()}
        step = rotor["step_rad"]
        row["step_urad"] = None if step is None else 1e6 * step
        rows.append(row | {name: rotor[name] for name in ANGLE_HEAD[-2:]})
    return rows


def _angle_cells(allan: Mapping[str, np.ndarray], series: str) -> Row:
    own = (allan["series"] == series) & (allan["estimator"] == "oadev")
    values: Row = dict.fromkeys(OF_PART)
    if not own.any():
        return values
    tau, adev, alpha = (allan[name][own] for name in ("tau_s", "adev_rad", "alpha"))
    best = int(adev.argmin())
    values |= {"adev_min_urad": 1e6 * float(adev[best]), "tau_min_s": float(tau[best])}
    if allan["m"][own][0] == 1:
        for end in ("", "_lower", "_upper"):
            values[f"adev_1{end}_urad"] = 1e6 * float(allan[f"adev{end}_rad"][own][0])
        values["exponent"] = int(alpha[0])
        if alpha[0] == 0:  # AVAR = h_0 / (2 tau)
            values["h_0_urad2_hz"] = 2e12 * float(tau[0] * adev[0] ** 2)
    return values


def angle_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of some `angle_rows`."""
    if not rows:
        return f"# {title}\n\nNo calibration of a board at rest.\n"
    return markdown(list(rows), title, f"{captions.ANGLE_TABLE} {note}".strip())
