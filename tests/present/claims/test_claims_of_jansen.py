"""Claims of J by its tables, and by calibrations with errors made up for the purpose."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mocap_metrology.present.claims.claim import DOES_NOT, HOLDS, UNKNOWN, Finding
from mocap_metrology.present.claims.jansen import Calibrations, PublishedTables
from mocap_metrology.present.claims.table import claims

BY_ID = {name: claim for name, claim in claims().items() if claim.paper == "J"}


def pose(stage: str, errors_mm: float, optics: str = "ideal", by: str = "paper") -> dict[str, Any]:
    return {
        "estimator": by,
        "stage": stage,
        "optics": optics,
        "errors_mm": [errors_mm, -errors_mm, errors_mm],
        "errors_deg": [0.01 * errors_mm] * 3,
        "truth_errors_mm": [errors_mm, 0.0, 0.0],
        "mirrored_share": 0.0,
    }


def record(name: str, setup: str, *poses: dict[str, Any]) -> dict[str, Any]:
    return {"calibration": name, "setup": setup, "source": "twin", "pose": {"poses": list(poses)}}


def test_published_tables() -> None:
    words = {name: claim.find(PublishedTables()).word for name, claim in BY_ID.items()}
    assert words["J-VII-accuracy"] == words["J-IV-time"] == HOLDS
    assert words["J-VIII-decent"] == UNKNOWN  # J does not say what is decent
    assert words["J-VII-precision"] == DOES_NOT
    assert words["J-IV-full"] == words["J-VI-last"] == words["J-VII-influence"] == UNKNOWN
    # Table I over Table III, by hand: 20.6/6.9, 19.7/9.3, 29.3/8.5, 1.19/0.10, 1.79/0.17, 1.43/0.16
    assert (
        BY_ID["J-VII-accuracy"]
        .find(PublishedTables())
        .value.endswith("3.0, 2.1, 3.4, 11.9, 10.5, 8.9")
    )


@pytest.mark.parametrize(
    ("after", "moved"), [(9.0, "1.73 mm"), (200.0, "333 mm"), (800.0, "1.37 m"), (-8.0, "27.7 mm")]
)
def test_last_step(after: float, moved: str) -> None:
    """How far it moves the pose is said (an error of the same size the other way round is another
    pose); what is very little, J does not say."""
    records = [
        record(f"s{k}", "sim-1", pose("kabsch", 8.0), pose("final", after)) for k in range(3)
    ]
    found = BY_ID["J-VI-last"].find(Calibrations(records))
    assert found.word == UNKNOWN
    assert found.value.startswith(f"changes it by {moved}; error 13.9 mm before")


def test_influence_of_speed_is_seen() -> None:
    """Beside setups that differ by a factor of 20: what they share is not what speed does."""
    rng = np.random.default_rng(1)
    speeds = rng.uniform(0.1, 1.0, 50)
    motion = {
        f"s{k}": {
            "pattern": ("arc", "line")[k % 3 == 0],
            "speed_m_s": v,
            "centre_m": [3.0, rng.normal(), 0.0],
        }
        for k, v in enumerate(speeds)
    }
    luck = rng.uniform(5, 15, 50)
    setup = np.geomspace(0.2, 4, 10)[np.arange(50) % 10]

    def found(errors: np.ndarray) -> Finding:
        records = [
            record(f"s{k}", f"sim-{k % 10}", pose("kabsch", error))
            for k, error in enumerate(errors)
        ]
        return BY_ID["J-VII-influence"].find(Calibrations(records, motion))

    assert found(luck * setup).word == HOLDS
    assert found(luck * setup * speeds).word == DOES_NOT
    assert found(luck * setup).value == found(luck).value
    assert found(luck**4).word == UNKNOWN  # a factor of 100 by luck hides one of 2.5
    assert found(luck[:5]).word == UNKNOWN
    for one in motion.values():
        one["pattern"] = "arc"
    assert "pattern: not varied" in found(luck).value and found(luck).word == UNKNOWN


def test_reconstructions_and_factory_values() -> None:
    ways = {
        "full-interpolation": np.full((4, 2), 1.0),
        "dominant-axis": np.full((4, 2), 1.1),
        "pairs": np.full((4, 2), 1.2),
    }
    found = Calibrations([], {}, ways)
    assert BY_ID["J-IV-full"].find(found).word == BY_ID["J-IV-marginal"].find(found).word == HOLDS
    ways["pairs"] = np.full((4, 2), 0.5)
    worse = Calibrations([], {}, ways)
    assert BY_ID["J-IV-full"].find(worse).word == DOES_NOT
    assert BY_ID["J-IV-marginal"].find(worse).word == DOES_NOT
    both = pose("final", 80.0, by="paper-lm"), pose("final", 10.0, "factory", by="paper-lm")
    claim = BY_ID["J-VIII-parameters"].find(Calibrations([record("a", "real-1", *both)]))
    assert claim.word == HOLDS and "8.0 times" in claim.value
