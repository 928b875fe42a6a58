"""A calibration in words and numbers: pose with deviations, data behind it, stations; tables of
a group of calibrations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse.assess import calibration_files as data
from mocap_metrology.lighthouse.assess.pose_file import is_network
from mocap_metrology.lighthouse.assess.rows import AXIS_NAMES, CHOSEN
from mocap_metrology.lighthouse.published import QUANTITIES
from mocap_metrology.lighthouse.records import MASTER
from mocap_metrology.present.tables import Part, Row, document
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number, significant


def pose_rows(entry: Record) -> list[tuple[str, list[str]]]:
    """Rows of the pose: a label with its unit, and three numbers.

    The pose has as many decimals as its standard deviation, or its error against the reference
    where that is larger, has with two significant digits.
    """
    angles = [entry["rotation_deg"][k] for k in ("alpha", "beta", "gamma")]
    sd, errors = data.deviations(entry).tolist(), entry.get("errors_mm")
    off = [*errors, *entry["errors_deg"]] if errors else [np.nan] * 6
    rows, compared = [], []
    for name, values, part, usual in (
        ("t, slave in master (mm)", entry["translation_mm"], slice(3), 1),
        ("α, β, γ (°)", angles, slice(3, 6), 2),
    ):
        at_rest = "along x, y, z (mm)" if usual == 1 else "about x, y, z (°)"
        rows.append((name, _cells(values, _decimals([*sd[part], *off[part]], usual), sign=True)))
        if entry.get("covariance") is not None:
            rows.append((f"1 σ {at_rest}", _cells(sd[part], _decimals(sd[part], usual))))
        if errors:
            label = "t − reference (mm)" if usual == 1 else "rotation from it (°)"
            compared.append((label, _cells(off[part], _decimals(off[part], usual), sign=True)))
    return rows + compared


def all_rows(files: data.CalibrationFiles) -> list[tuple[str, list[str]]]:
    """The rows of `pose_rows` for two stations; for more of them the place and the standard
    deviations of each but the reference."""
    if not is_network(files.pose):
        return pose_rows(files.chosen) if files.chosen else []
    rows = []
    for name, entry in files.entries.items():
        if entry is None:
            rows.append((f"station {name}", ["no pose", "", ""]))
            continue
        sd = data.deviations(entry).tolist()
        digits = _decimals(sd[:3], 1)
        rows.append((f"{name}: t (mm)", _cells(entry["translation_mm"], digits, sign=True)))
        rows.append((f"{name}: 1 σ (mm)", _cells(sd[:3], digits)))
        rows.append((f"{name}: 1 σ (°)", _cells(sd[3:], _decimals(sd[3:], 2))))
    return rows


def _decimals(values: Sequence[float], usual: int) -> int:
    """Decimals that give the largest two significant digits, three at most; the usual number where
    none is known."""
    known = [abs(float(value)) for value in values if np.isfinite(value) and value]
    return int(np.clip(1 - np.floor(np.log10(max(known))), 0, 3)) if known else usual


def _cells(values: Iterable[float], digits: int, sign: bool = False) -> list[str]:
    return [number(float(value), digits, sign) for value in values]


def facts(files: data.CalibrationFiles) -> list[str]:
    """Lines beside the numbers: the data behind the pose, of two stations distances to where the
    board was on the whole, of more how parts of the recording differ, and the stations."""
    known = {name: entry for name, entry in files.entries.items() if entry is not None}
    entry, paths, lines = next(iter(known.values()), None), files.shown_paths(), []
    of_two = not is_network(files.pose)
    if entry is not None:
        lines.append(f"{entry['estimator']}, stage {entry['stage']}, {entry['optics']} optics")
        if of_two:
            baseline = np.linalg.norm(entry["translation_mm"]) / 1e3
            lines.append(f"baseline {number(float(baseline), 3)} m")
        if (residual := entry.get("residual_rms_urad")) is not None:
            limit, good = data.limit_of(files.pose, "residual") if of_two else (None, False)
            below = f" ({'good' if good else 'usable'} below {limit:.0f})" if limit else ""
            n = number(entry["n_angles"])
            lines.append(f"residual {residual:.0f} µrad of {n} angles{below}")
        if of_two and (share := entry.get("mirrored_share")) is not None:
            lines.append(f"mirrored board poses {100 * share:.2g} %")
    if of_two and paths is not None:
        both = files.agreement()
        board_m = np.median(paths[MASTER].t_m if both is None else both.master_m, axis=0)
        lines.append(f"board {number(float(np.linalg.norm(board_m)), 2)} m from the master")
        if entry is not None:
            slave = board_m - np.array(entry["translation_mm"]) / 1e3
            lines[-1] += f", {number(float(np.linalg.norm(slave)), 2)} m from the slave"
    halves = {} if of_two else {name: one["halves"] for name, one in known.items()}
    parts = [f"{name}: {h['mm']:.1f} mm, {h['deg']:.2f}°" for name, h in halves.items() if h]
    lines += [f"parts differ, {'; '.join(parts)}"] if parts else []
    return lines + [_station(station) for station in files.stations]


def _station(station: Record) -> str:
    """One station in a line: id, mode of the first generation, source of its factory values."""
    known = "id unknown" if station.get("id") is None else f"id {station['id']}"
    if station.get("factory") is None:
        factory = f"no factory values: {station.get('why') or 'none found'}"
    elif n := station.get("frames_found"):
        factory = f"factory values from {n} frame{'' if n == 1 else 's'}"
    else:
        factory = "factory values from a file"
    mode = f"mode {station.get('mode') or 'unknown'}, " if station.get("generation", 1) == 1 else ""
    return f"{station['role']}: {known}, {mode}{factory}"


def calibration_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of `calibration_rows`: the poses, then the reasons of the verdicts."""
    caption = f"{captions.CALIBRATION_TABLE} {note}".strip()
    if not rows:
        return document(title, caption, "No calibrations.")
    head = ["calibration", "source", "master", "slave", "by", "t mm", "α β γ °", "baseline mm"]
    head += ["σ", "residual µrad", "hits", "error", "verdict"]
    verdicts = [f"- {row['calibration']}: {row['verdict']}. {row['reason']}" for row in rows]
    known = (row for row in rows if row["check_against"])
    moved = [f"- {row['calibration']}: {row['check_against']}" for row in known]
    parts: list[Part] = [caption, [head, *map(_line, rows)], "## Verdicts", "\n".join(verdicts)]
    parts += ["## Against an earlier pose", "\n".join(moved)] if moved else []
    return document(title, *parts)


def _line(row: Row) -> list[object]:
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
    mm, deg = (max(v) if kind == "sigma" else math.hypot(*v) for v in (values[:3], values[3:]))
    return "" if math.isnan(mm) else f"{significant(mm)} mm, {significant(deg)}°"
