"""Noise coefficients of a group of recordings: every estimate in long form, the default to read."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, unit_key, unit_of
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.model.deterministic import PARAMETERS as DETERMINISTIC
from mocap_metrology.present.fits.matching import limit_class
from mocap_metrology.present.numbers import MARKS, STATUS_SIGNS, three_digits, with_interval
from mocap_metrology.present.tables import Row, aligned

FROM_CSV = (
    "series",
    "estimator",
    "parameter",
    "value",
    "unit",
    "std_error",
    "lower_95",
    "upper_95",
    "status",
    "class",
    "note",
)
COLUMNS = ("recording", "source", *FROM_CSV)
CAPTION = (
    "Coefficients of the noise, 95 % intervals in brackets; < not detected, upper 95 % limit (of a "
    "further correlated component: for every T_c of the class named); "
    f"{STATUS_SIGNS}. Gauss-Markov terms by rising T_c. "
    "All estimators, with standard errors, are in the CSV."
)
NUMBERS = ("value", "std_error", "crlb", "lower_68", "upper_68", "lower_95", "upper_95")
MOST_SERIES = 7  # columns of a table to read


def read_noise(path: str | Path) -> list[Row]:
    """Rows of a noise.csv with numbers as numbers; NaN where a cell is empty."""
    with Path(path).open(encoding="utf-8", newline="") as stream:
        return [
            row
            | {k: float(row[k]) if row[k] else math.nan for k in NUMBERS}
            | {"detected": row["detected"] == "True"}
            for row in csv.DictReader(stream)
        ]


def noise_table(
    noise: Mapping[str, Sequence[Mapping[str, Any]]], sources: Mapping[str, str]
) -> list[Row]:
    """Rows of noise.csv of every recording, long form: `COLUMNS`.

    noise: rows of noise.csv, sources: `twin` or `measured`, both by recording.
    """
    return [
        {"recording": name, "source": sources.get(name)} | {k: row.get(k) for k in FROM_CSV}
        for name, rows in noise.items()
        for row in rows
    ]


def noise_markdown(
    rows: Sequence[Row], title: str, caption: str, estimator: str = DEFAULT_ESTIMATOR
) -> str:
    """Markdown of `noise_table`: a block a recording, a column a series, by one estimator."""
    lines = [f"# {title}", "", caption, f"Estimator: {estimator}.", ""]
    for name in dict.fromkeys(row["recording"] for row in rows):
        of_it = [r for r in rows if r["recording"] == name]
        lines += [f"## {name} ({of_it[0]['source']})", ""]
        asked = [r for r in of_it if r["estimator"] == estimator]
        chosen = [r for r in asked if r["status"] != "refused"]
        series = list(dict.fromkeys(r["series"] for r in chosen))
        lines += _refused([r for r in asked if r["status"] == "refused"])
        if not asked:
            lines += [f"No coefficients by {estimator}.", ""]
        for k in range(0, len(series), MOST_SERIES):
            lines += [*_block(chosen, series[k : k + MOST_SERIES]), ""]
    if not rows:
        lines += ["No coefficients.", ""]
    return "\n".join(lines)


def _refused(rows: Sequence[Row]) -> list[str]:
    """Why there are no numbers: one line a reason."""
    reasons: dict[str, list[str]] = {}
    for row in rows:
        reasons.setdefault(row["note"], []).append(row["series"])
    lines = [f"- {', '.join(series)}: none: {why}." for why, series in reasons.items()]
    return [*lines, ""] if lines else []


def _block(rows: Sequence[Row], series: Sequence[str]) -> list[str]:
    cells = {(r["parameter"], r["series"]): r for r in rows if r["series"] in series}
    names = sorted({parameter for parameter, _ in cells}, key=_rank)
    lines: list[list[str]] = [["", "unit", *series]]
    for name in names:
        texts = [_cell(cells.get((name, one))) for one in series]
        lines.append([name, unit_of(name), *texts])
    return aligned(lines)


def _rank(parameter: str) -> tuple[int, int, int]:
    """Power laws by alpha, then q_c1, T_c1, q_c2, ..., then the sinusoid, then what is no noise."""
    kinds = [*NoiseModel.UNITS, *DETERMINISTIC]
    kind = unit_key(parameter)
    if kind in ("q_c", "T_c"):
        return 1, int(parameter[3:]), kinds.index(kind)
    return (0 if kind.startswith("h_") else 2), 0, kinds.index(kind)


def _cell(row: Row | None) -> str:
    if row is None:
        return ""
    if row["status"] == "not_detected":
        upper = row["upper_95"]
        known = upper is not None and upper == upper
        kind = limit_class(row)
        of_class = f" ({kind})" if kind else ""
        return f"< {three_digits(float(upper))}{of_class}" if known else "not detected"
    text = with_interval(row["value"], row["lower_95"], row["upper_95"])
    return text + MARKS.get(row["status"], "")
