"""Tables of a group of calibrations: poses to use, tracked receivers, noise of angles at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mocap_metrology.lighthouse.assess.rows import AXIS_NAMES, CHOSEN
from mocap_metrology.lighthouse.published import QUANTITIES
from mocap_metrology.present.tables import Row, aligned, markdown
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant


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


def track_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of some `track_row`."""
    if not rows:
        return f"# {title}\n\nNo calibrations.\n"
    return markdown(list(rows), title, f"{captions.TRACK_TABLE} {note}".strip())


def angle_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of some `angle_rows`."""
    if not rows:
        return f"# {title}\n\nNo calibration of a board at rest.\n"
    return markdown(list(rows), title, f"{captions.ANGLE_TABLE} {note}".strip())
