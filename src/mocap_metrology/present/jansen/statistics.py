"""Errors of calibrations summed up as J does: mean absolute error and standard deviation."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocap_metrology.lighthouse.published import QUANTITIES, SETUPS

Record = Mapping[str, Any]  # calibration, setup, source, pose (contents of pose.json)
ESTIMATORS = ("paper", "paper-tight", "paper-lm")
STAGES = ("kabsch", "final")
OPTICS = ("ideal", "factory")
QUANTISED, NOISY = "sim-", "noise-"  # setups of Table III: sample error alone, and further noise


@dataclass(frozen=True, order=True)
class Variant:
    """One way to calibrate."""

    estimator: str
    stage: str
    optics: str

    def __str__(self) -> str:
        return f"{self.estimator}, {self.stage}, {self.optics} optics"


VARIANTS = tuple(Variant(e, s, o) for o in OPTICS for e in ESTIMATORS for s in STAGES)


@dataclass(frozen=True)
class SetupErrors:
    """Errors of the calibrations of one setup by one variant: (n, 6) in mm and deg, see QUANTITIES;
    mirrored share of each (n,)."""

    errors: np.ndarray
    mirrored: np.ndarray

    @property
    def n(self) -> int:
        return len(self.errors)

    def mae(self) -> np.ndarray:
        """Mean absolute error (6,), NaN without a calibration."""
        return np.abs(self.errors).mean(axis=0) if self.n else np.full(6, np.nan)

    def sd(self) -> np.ndarray:
        """Standard deviation (6,), n - 1 in the denominator; NaN for fewer than two."""
        return self.errors.std(axis=0, ddof=1) if self.n > 1 else np.full(6, np.nan)


def paper_setup(setup: str) -> str | None:
    """Row of Tables I and II that a setup of the sheet stands for: `3` of `3`, `real-3`, `setup3`;
    None for those of the simulation and for numbers that J has not."""
    if setup.startswith((QUANTISED, NOISY)):
        return None
    found = re.fullmatch(r"(?:.*[^0-9])?0*([0-9]+)", setup)
    return found[1] if found and found[1] in SETUPS else None


def pose_of(record: Record, variant: Variant) -> Mapping[str, Any] | None:
    """The pose by a variant that has errors against a reference."""
    for pose in record["pose"]["poses"]:
        same = Variant(pose["estimator"], pose["stage"], pose["optics"]) == variant
        if same and pose.get("errors_mm") is not None:
            return pose
    return None


def setup_errors(records: Sequence[Record], variant: Variant) -> SetupErrors:
    """Errors of all records by one variant; records without it are left out."""
    poses = [pose for record in records if (pose := pose_of(record, variant)) is not None]
    errors = [[*pose["errors_mm"], *pose["errors_deg"]] for pose in poses]
    shares = [pose.get("mirrored_share") for pose in poses]
    return SetupErrors(
        np.array(errors, dtype=np.float64).reshape(-1, len(QUANTITIES)),
        np.array([math.nan if share is None else share for share in shares]),
    )


def mean_over(rows: Sequence[np.ndarray]) -> np.ndarray:
    """Mean (6,) over the setups that have a value; NaN without one."""
    values = np.array(rows, dtype=np.float64).reshape(-1, len(QUANTITIES))
    values = values[np.isfinite(values).all(axis=1)]
    return values.mean(axis=0) if len(values) else np.full(len(QUANTITIES), np.nan)


def source_of(records: Sequence[Record]) -> str:
    """`twin`, `measured`, `twin and measured`, or `cited` where there is no record."""
    kinds = sorted({record["source"] for record in records}, reverse=True)
    return " and ".join(kinds) if kinds else "cited"


def by_setup(records: Sequence[Record], rows: Sequence[str]) -> dict[str, list[Record]]:
    """Records of each setup of Tables I and II; empty lists for those that nothing stands for."""
    found: dict[str, list[Record]] = {row: [] for row in rows}
    for record in records:
        setup = paper_setup(record["setup"])
        if setup in found:
            found[setup].append(record)
    return found


def simulated(records: Sequence[Record], prefix: str) -> dict[str, list[Record]]:
    """Records of each simulated setup whose name begins so, in order of appearance."""
    found: dict[str, list[Record]] = {}
    for record in records:
        if record["setup"].startswith(prefix):
            found.setdefault(record["setup"], []).append(record)
    return found


def variants_of(records: Sequence[Record]) -> tuple[Variant, ...]:
    """Variants that at least one record has, in the order of `VARIANTS`; all without records."""
    have = tuple(v for v in VARIANTS if any(pose_of(record, v) for record in records))
    return have or VARIANTS
