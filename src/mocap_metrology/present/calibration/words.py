"""Sentences about a calibration as figures and tables show them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mocap_metrology.lighthouse.assess.fit_checks import BOARD, EXPECTED_URAD

TIMES_SIGMA = 3.0
BEYOND_SIGMA = (
    "Error beyond 3 σ: σ is the scatter within this recording; what stays the same in it is not"
    " in σ (optics, lasers off the origin of the housing, scale of the board)."
)


def residual_limit(pose: Mapping[str, Any]) -> str:
    """`good below 577`, or where it is not good `usable below 2164`: limit of the residual in µrad;
    empty where none is known."""
    limit, good = _limit(pose, "residual")
    return "" if limit is None else f"{'good' if good else 'usable'} below {limit:.0f}"


def expected_urad(pose: Mapping[str, Any]) -> float:
    """Noise of one angle that the checks went by, in µrad."""
    limit, good = _limit(pose, "board poses")
    return EXPECTED_URAD if limit is None else limit / BOARD[0 if good else 1]


def _limit(pose: Mapping[str, Any], name: str) -> tuple[float | None, bool]:
    """Limit of a check and whether it is that of the word good; None where it has none."""
    check = next((check for check in pose.get("checks", ()) if check["name"] == name), {})
    limit = check.get("limit")
    return (limit if isinstance(limit, int | float) else None), bool(check.get("ok"))


def beyond_sigma(entry: Mapping[str, Any]) -> bool:
    """Whether the error of an estimate against its reference is more than three standard deviations
    in a coordinate or about an axis."""
    if entry.get("covariance") is None or entry.get("errors_mm") is None:
        return False
    off = np.abs([*entry["errors_mm"], *entry["errors_deg"]])
    variance = np.diag(np.array(entry["covariance"], dtype=np.float64))
    return bool((off > TIMES_SIGMA * np.sqrt(np.clip(variance, 0, None))).any())
