"""Tables of a group: its recordings as in the sheet, Allan deviations, noise coefficients."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from mocap_metrology.common.types import Record
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, limit_class, unit_key, unit_of
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.model.deterministic import PARAMETERS as DETERMINISTIC
from mocap_metrology.papers.subsets import source_of
from mocap_metrology.present.tables import Part, Row, document
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import MARKS, STATUS_SIGNS, significant, with_interval

FROM_CSV = (
    *("series", "estimator", "parameter", "value", "unit", "std_error"),
    *("lower_95", "upper_95", "status", "class", "note"),
)
COLUMNS = ("recording", "source", *FROM_CSV)
CAPTION = captions.NOISE_TABLE.format(signs=STATUS_SIGNS)
MOST_SERIES = 7  # columns of a table to read
SUBSETS = "The recordings of the group as in the sheet."
# Column of <group>_summary: title, what it is, format
MULTIQC = {
    "word": ("Verdict", "good, usable or bad", None),
    "worst": ("Worst", "Coordinate with the largest uncertainty of one frame", None),
    "frame_mm": ("One frame", "Standard uncertainty about the mean of the horizon, mm", "{:,.4f}"),
    "sigma_frame_mm": ("Within 1 s", "Scatter of single frames, mm", "{:,.4f}"),
    "adev_min_mm": ("Lowest deviation", "Lowest Allan deviation, mm", "{:,.5f}"),
    "tau_min_s": ("at", "Averaging time of the lowest Allan deviation, s", "{:,.1f}"),
    "dominating_noise": ("Noise", "Largest share of the variance of one frame", None),
    "n_findings": ("Findings", "Warnings of the diagnosis", "{:,.0f}"),
    "reason": ("Reason", "What decided the verdict", None),
}
RULES = {"pass": "good", "warn": "usable", "fail": "bad"}


def noise_table(noise: Mapping[str, Sequence[Record]], sources: Mapping[str, str]) -> list[Row]:
    """Rows of noise.csv of every recording, long form: `COLUMNS`.

    noise: rows of noise.csv, sources: `twin` or `measured`, both by recording.
    """
    return [
        {"recording": name, "source": sources.get(name)} | {k: row.get(k) for k in FROM_CSV}
        for name, rows in noise.items()
        for row in rows
    ]


def noise_markdown(rows: Sequence[Row], title: str, caption: str) -> str:
    """Markdown of `noise_table`: a block a recording, a column a series, by one estimator."""
    parts: list[Part] = [f"{caption}\nEstimator: {DEFAULT_ESTIMATOR}."]
    for name in dict.fromkeys(row["recording"] for row in rows):
        every = [row for row in rows if row["recording"] == name]
        by_default = [row for row in every if row["estimator"] == DEFAULT_ESTIMATOR]
        parts.append(f"## {name} ({every[0]['source']})")
        parts.append("" if by_default else f"No coefficients by {DEFAULT_ESTIMATOR}.")
        reasons: dict[str, list[str]] = {}
        cells: dict[str, dict[str, Row]] = {}  # by series and parameter
        for row in by_default:
            if row["status"] == "refused":
                reasons.setdefault(row["note"], []).append(row["series"])
            else:
                cells.setdefault(row["series"], {})[row["parameter"]] = row
        without = [f"- {', '.join(of)}: no coefficients: {why}." for why, of in reasons.items()]
        parts.append("\n".join(without))
        for k in range(0, len(cells), MOST_SERIES):
            series = list(cells)[k : k + MOST_SERIES]
            block = [["", "unit", *series]]
            for parameter in sorted({p for one in series for p in cells[one]}, key=_rank):
                texts = [_cell(cells[one].get(parameter)) for one in series]
                block.append([parameter, unit_of(parameter), *texts])
            parts.append(block)
    return document(title, *parts, "" if rows else "No coefficients.")


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
        if row["upper_95"] is None or math.isnan(row["upper_95"]):
            return "not detected"
        kind = limit_class(row)
        return f"< {significant(float(row['upper_95']))}{f' ({kind})' if kind else ''}"
    text = with_interval(row["value"], row["lower_95"], row["upper_95"])
    return text + MARKS.get(row["status"], "")


def subsets(recordings: Sequence[Record]) -> list[Row]:
    """One row for each recording: its entries in the sheet."""
    return [
        {"recording": row["recording"], "source": source_of(row)}
        | {"camera_type": row["camera_type"], "n_cameras": row["n_cameras"]}
        | {"camera_ids": ";".join(map(str, row["camera_ids"])), "comment": row["comment"]}
        for row in recordings
    ]


def multiqc(group: str, summary: Sequence[Row]) -> Row:
    """Contents of <group>_mqc.json. summary: rows of <group>_summary."""
    headers = {}
    for name, (title, description, number) in MULTIQC.items():
        headers[name] = {"title": title, "description": description, "scale": False}
        if number:
            headers[name] |= {"format": number, "scale": "Blues"}
    colours = {name: [{"s_eq": word}] for name, word in RULES.items()}
    headers["word"]["cond_formatting_rules"] = colours
    section = f"mocap-metrology: {group}"
    return {
        "id": f"mocap_metrology_{group}",
        "section_name": section,
        "description": "Noise of still markers; scale and distortion are not included.",
        "plot_type": "table",
        "pconfig": {"id": f"mocap_metrology_{group}_table", "title": section},
        "headers": headers,
        "data": {
            row["recording"]: {k: row[k] for k in MULTIQC if row.get(k) not in (None, "")}
            for row in summary
        },
    }
