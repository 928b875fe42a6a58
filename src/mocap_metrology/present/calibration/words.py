"""Sentences about a calibration as figures and tables show them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from mocap_metrology.lighthouse.assess.verdict import BOARD, EXPECTED_URAD

TIMES_SIGMA = 3.0
NOISE = re.compile(r"(\(noise of an angle: \d+)\)")
ALSO = re.compile(r"\s*Also not right: ([^.]*)\.")
UNITS = ((re.compile(r"(\d) urad\b"), r"\1 µrad"), (re.compile(r"(\d) deg\b"), r"\1°"))
BEYOND_SIGMA = (
    "Error beyond 3 σ: σ is the scatter within this recording; what stays the same in it is not"
    " in σ (optics, lasers off the origin of the housing, scale of the board)."
)


def shown(sentence: str) -> str:
    """A sentence with µrad and ° for urad and deg."""
    for pattern, sign in UNITS:
        sentence = pattern.sub(sign, sentence)
    return sentence


def reason_of(pose: Mapping[str, Any]) -> str:
    """The reason of a verdict (contents of pose.json), with what else was found in sentences in
    place of the names of checks, and the limit beside the noise; see `shown` for a reader."""
    reason = pose["verdict"]["reason"] or "No reason given."
    told = {check["name"]: check.get("sentence") for check in pose.get("checks", ())}
    found = ALSO.search(reason)
    names = found[1].split(", ") if found else []
    if names and all(told.get(name) for name in names):
        more = [told[name].split(", as by ")[0].rstrip(".") + "." for name in names]
        reason = " ".join([ALSO.sub("", reason).strip(), *more])
    limit = residual_limit(pose)
    return NOISE.sub(rf"\1; {limit})", reason) if limit else reason


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
