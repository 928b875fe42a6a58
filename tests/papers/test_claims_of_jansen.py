"""Claims of J by its tables, and by calibrations with errors made up for the purpose."""

from typing import Any

import numpy as np
import pytest
from test_claims_of_skurowski import found

from mocap_metrology.papers.claims.decide import DOES_NOT, HOLDS, UNKNOWN
from mocap_metrology.papers.claims.jansen import Calibrations, PublishedTables


def pose(stage: str, mm: float, optics: str = "ideal", by: str = "paper") -> dict[str, Any]:
    errors = {"errors_mm": [mm, -mm, mm], "errors_deg": [0.01 * mm] * 3}
    errors |= {"truth_errors_mm": [mm, 0.0, 0.0], "mirrored_share": 0.0}
    return {"estimator": by, "stage": stage, "optics": optics, **errors}


def record(name: str, setup: str, *poses: dict[str, Any]) -> dict[str, Any]:
    return {"calibration": name, "setup": setup, "source": "twin", "pose": {"poses": list(poses)}}


def test_published_tables() -> None:
    """Table I over Table III, by hand: 20.6/6.9, 19.7/9.3, 29.3/8.5, 1.19/0.10, 1.79/0.17,
    1.43/0.16."""
    word, text = found("J-VII-accuracy", PublishedTables())
    assert (word, text) == (HOLDS, "real over simulated: 3.0, 2.1, 3.4, 11.9, 10.5, 8.9")
    assert found("J-VII-precision", PublishedTables())[0] == DOES_NOT
    assert found("J-VIII-decent", PublishedTables())[0] == UNKNOWN  # J does not state what is
    assert found("J-IV-time", PublishedTables()) == (
        HOLDS, "8.3 + 6.7 - 1.2 = 13.8 ms, 13.8 mm at 1 m/s")  # fmt: skip


def test_real_over_simulated_errors() -> None:
    """Errors of -2 s, 0 and 2 s in each of two setups: MAE 4/3 s, SD 2 s, so both ratios are s; a
    ratio of SDs is known to a factor of 1.4."""
    for s, words in (
        (1.7, [HOLDS, UNKNOWN]),
        (0.2, [DOES_NOT, DOES_NOT]),
        (1.0, [DOES_NOT, HOLDS]),
    ):
        sizes = {"real-1": s, "real-2": s, "sim-1": 1.0, "sim-2": 1.0}
        records = [
            record(f"{setup}-{k}", setup, pose("kabsch", 2 * size * (k - 1)))
            for setup, size in sizes.items() for k in range(3)
        ]  # fmt: skip
        names = ("J-VII-accuracy", "J-VII-precision")
        decided = [found(name, Calibrations(records)) for name in names]
        assert [word for word, _ in decided] == words
        assert all(f"{s:.1f}, {s:.1f}" in text for _, text in decided)


@pytest.mark.parametrize(
    ("after", "moved"), [(9.0, "1.73"), (200.0, "333"), (800.0, "1.37e+03"), (-8.0, "27.7")]
)
def test_last_step(after: float, moved: str) -> None:
    """How far it moves the pose is stated (an error of the same size the other way round is another
    pose); J does not state what is very little."""
    poses = pose("kabsch", 8.0), pose("final", after)
    word, text = found("J-VI-last", Calibrations([record(f"s{k}", "sim-1", *poses) for k in "12"]))
    assert word == UNKNOWN and text.startswith(f"changes it by {moved}; error 13.9 before")


def test_influence_of_speed_is_detected() -> None:
    """Beside setups that differ by a factor of 20: what they share is not what speed does."""
    rng = np.random.default_rng(1)
    speeds, luck = rng.uniform(0.1, 1.0, 50), rng.uniform(5, 15, 50)
    setup = np.geomspace(0.2, 4, 10)[np.arange(50) % 10]
    motion = {
        f"s{k}": {"pattern": ("arc", "line")[k % 3 == 0], "speed_m_s": v,
                  "centre_m": [3.0, rng.normal(), 0.0]}
        for k, v in enumerate(speeds)
    }  # fmt: skip

    def by(errors: np.ndarray) -> tuple[str, str]:
        records = [
            record(f"s{k}", f"sim-{k % 10}", pose("kabsch", error))
            for k, error in enumerate(errors)
        ]
        return found("J-VII-influence", Calibrations(records, motion))

    assert by(luck * setup)[0] == HOLDS
    assert by(luck * setup * speeds)[0] == DOES_NOT
    assert by(luck * setup)[1] == by(luck)[1]
    assert by(luck**4)[0] == UNKNOWN  # a factor of 100 by luck hides one of 2.5
    assert by(luck[:5])[1] == "5 simulated calibrations of known motion; 20 are needed"
    for one in motion.values():
        one["pattern"] = "arc"
    assert by(luck)[0] == UNKNOWN and "pattern: not varied" in by(luck)[1]


def test_reconstructions_and_factory_values() -> None:
    ways = {"full-interpolation": 1.0, "dominant-axis": 1.1, "pairs": 1.2}
    for pairs, word in ((1.2, HOLDS), (0.5, DOES_NOT)):
        errors = {way: np.full((4, 2), v) for way, v in (ways | {"pairs": pairs}).items()}
        study = Calibrations([], {}, errors)
        assert found("J-IV-full", study)[0] == found("J-IV-marginal", study)[0] == word
    both = pose("final", 80.0, by="paper-lm"), pose("final", 10.0, "factory", by="paper-lm")
    parameters = found("J-VIII-parameters", Calibrations([record("a", "real-1", *both)]))
    assert parameters == (HOLDS, "error 8.0 times smaller in the median of 1")


@pytest.mark.parametrize(
    ("seconds", "word", "text"),
    [(2.0, HOLDS, "less than 10 s"), (100.0, HOLDS, "less than 180 s"),
     (400.0, DOES_NOT, "more than 180 s"), (float("nan"), UNKNOWN, "no simulated")],
)  # fmt: skip
def test_a_few_minutes(seconds: float, word: str, text: str) -> None:
    shown = found("J-VIII-minutes", Calibrations([], {}, {}, seconds))
    assert shown[0] == word and shown[1].startswith(text)
