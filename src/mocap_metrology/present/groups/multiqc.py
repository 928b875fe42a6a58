"""Verdicts of a group for MultiQC, as custom content: a table with a row a recording.

[MultiQC documentation, Custom content: files that end in _mqc.json]
"""

from __future__ import annotations

from collections.abc import Sequence

from mocap_metrology.common.types import Row

# Column of <group>_summary: title, what it is, format
COLUMNS = {
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


def multiqc(group: str, summary: Sequence[Row]) -> Row:
    """Contents of <group>_mqc.json. summary: rows of <group>_summary."""
    headers = {}
    for name, (title, description, number) in COLUMNS.items():
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
            row["recording"]: {k: row[k] for k in COLUMNS if row.get(k) not in (None, "")}
            for row in summary
        },
    }
