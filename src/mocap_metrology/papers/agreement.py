"""Whether a regenerated number of a table of a paper agrees with the published one."""

from __future__ import annotations

from mocap_metrology.common.types import Record
from mocap_metrology.papers.jansen import FACTOR

AGREES, DIFFERS, CITED, OPEN = "agrees", "differs", "cited", "not compared"
BELOW, ALONE = "not detected", "no partner"
PERCENT, ERRORS = 0.1, 3.0  # Table 1 of S: rounding of the printed 1.038 is 0.05 %


def known(row: Record, *names: str) -> bool:
    return all(row.get(name) is not None and row[name] == row[name] for name in names)


def _agree(holds: object) -> str:
    return AGREES if holds else DIFFERS


def law(row: Record) -> str:
    """Point samples are what a camera takes, and no number of the paper."""
    if row["method"] == "point samples":
        return OPEN
    allowed = PERCENT / 100 * (abs(row["published"]) or 1.0)
    if row["method"] == "simulation":
        allowed = max(allowed, ERRORS * row["standard_error"])
    return _agree(abs(row["regenerated"] - row["published"]) <= allowed)


def cameras(row: Record) -> str:
    return _agree(row["published"] == row["regenerated"]) if known(row, "regenerated") else CITED


def moment(row: Record) -> str:
    if not known(row, "regenerated"):
        return CITED
    inside = [row[name] for name in ("inside", "published_inside") if known(row, name)]
    return _agree(all(inside)) if inside else OPEN


def coefficient(row: Record) -> str:
    value, status = row["published"], row["likelihood_status"]
    low, high = row["likelihood_lower_95"], row["likelihood_upper_95"]
    if row["source"] == CITED:
        return CITED
    if status == "unpaired":
        return ALONE
    if status == "not_detected" and known(row, "likelihood_upper_95"):
        return BELOW if value <= high else DIFFERS
    ends = known(row, "likelihood_lower_95", "likelihood_upper_95")
    return _agree(low <= value <= high) if ends else OPEN


def error(row: Record) -> str:
    if row["source"] == CITED:
        return CITED
    return _agree(1 / FACTOR <= row["ratio"] <= FACTOR) if known(row, "ratio") else OPEN
