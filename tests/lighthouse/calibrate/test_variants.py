"""Which variant of the rotor model a recording prefers; what others do to the covariance."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from mocap_workflow.calibration_twins import twin_from_mapping

from benchmarks.lighthouse_recordings import factories
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.fit_checks import Case
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.batch.estimate import ROUNDS, Joint
from mocap_metrology.lighthouse.calibrate import variants
from mocap_metrology.lighthouse.calibrate.jansen import Calibration, CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.variants import NOISE_RAD, Fit, weigh
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, simulate
from tests.lighthouse import pairs

UNITS = 20
R = np.eye(3)


def fit(name: str, loss: np.ndarray, mm: float = 0.0) -> Fit:
    """A fit with so much left in each of 20 stretches, 100 parts of 8 angles each."""
    unit = np.repeat(np.arange(UNITS), 100)
    expected = np.full(unit.size, NOISE_RAD**2)
    t = np.array([1.0 + 1e-3 * mm, 0, 0])
    return Fit(name, R, t, loss, np.full(unit.size, 8), unit, expected)


def noise(rng: np.random.Generator, rms: float = 60e-6) -> np.ndarray:
    return rms**2 * rng.chisquare(8, 100 * UNITS) / 8


def test_by_chance_alone_a_variant_is_hardly_ever_ruled_out() -> None:
    """Two equally good ones, 400 recordings: at most 0.5 % of each side, so 1 %, within 3 sigma of
    the count; the poses are 5 mm apart and stay open."""
    rng = np.random.default_rng(1)
    ruled_out = 0
    for _ in range(400):
        found = weigh([fit("a", noise(rng)), fit("b", noise(rng), 5.0)])
        ruled_out += any(w.standing == "worse" for w in found)
    assert ruled_out <= 4 + 3 * np.sqrt(4)


@pytest.mark.parametrize(("odds", "standing"), [(150, "open"), (250, "worse")])
def test_likelihoods_must_differ_by_the_same_odds(odds: float, standing: str) -> None:
    """Errors that all stretches share make a gap that is alike in all of them, however small."""
    loss = noise(np.random.default_rng(2), 30e-6)
    gap = 2 * np.log(odds) * NOISE_RAD**2 / (8 * loss.size)
    both = [fit("a", loss), fit("b", loss + gap)]
    found = weigh([replace(one, variance=NOISE_RAD**2) for one in both])
    assert [w.standing for w in found] == ["chosen", standing]


FIRST = {"phase": [0.05, 0.0241], "tilt": [-0.0091, 0.0008], "curve": [-0.0038, -0.0055],
         "gibphase": [1.8633, -0.792], "gibmag": [0.0113, -0.0112]}  # fmt: skip
SECOND = {"phase": [-0.00832, -0.0082], "tilt": [0.00035, 0.00778], "curve": [0.00161, -0.01471],
          "gibphase": [-4.543, 1.2656], "gibmag": [0.01801, -0.0193]}  # fmt: skip


@cache
def made(variant: str, seed: int) -> SimulatedSweeps:
    """Five seconds by hand before rotors of two real stations that obey this variant."""
    return simulate(
        twin_from_mapping(
            {
                "seed": seed,
                "variant": variant,
                "duration_s": 5.0,
                "master": {"id": 1, "mode": "b", "factory": FIRST},
                "slave": {
                    "id": 2,
                    "mode": "c",
                    "factory": SECOND,
                    "position_m": [0.4, 2.0, 0.25],
                    "rotation_deg": [11, -6, -37],
                },
                "motion": {"centre_m": [2.8, 0.7, -0.2], "extent_m": 0.5},
                "common_urad": 53,
                "independent_urad": 30,
            }
        )
    )


def calibrated(own: SimulatedSweeps, estimator: str = "paper-lm", off_mm: float = 0) -> Calibration:
    """off_mm: standard deviation of the diodes from their stated places."""
    factories = [station.factory for station in own.truth.stations]
    settings = CalibrationSettings(estimators=(estimator,), optics=("factory",))
    board = own.truth.board + 1e-3 * off_mm * np.random.default_rng(1).normal(size=(32, 3))
    return calibrate(own.hits, board, factories, settings)


@pytest.mark.parametrize(
    ("variant", "estimator"), [("crazyflie", "batch"), ("libsurvive", "paper-lm")]
)
def test_simulated_rotors_of_either_kind(variant: str, estimator: str) -> None:
    """The right sign is taken, the other ruled out; 1 mm, where the other sign gives more."""
    own = made(variant, 7)
    found = calibrated(own, estimator)
    standing = {w.variant: w.standing for w in found.variants}
    wrong = {"crazyflie": "libsurvive", "libsurvive": "crazyflie"}[variant]
    assert standing[wrong] == "worse" and standing[variant] in ("chosen", "open")
    told = summary(found, own.truth.stations)
    assert {w["variant"] for w in told.document["variants"]} == {*standing}
    check = next(c for c in told.verdict.checks if c.name == "rotor model")
    assert check.case in (Case.ROTOR_CLEAR, Case.ROTOR_OPEN)
    final = found.estimates[-1]
    off = np.r_[1e3 * (final.t_m - own.truth.t_optical_m)]
    turn = np.degrees(rotation.error(final.R, own.truth.R))
    assert np.linalg.norm(off) < 2.5
    assert (np.abs(np.r_[off, turn]) < 4 * np.sqrt(np.diag(final.covariance))).all()
    others = [np.linalg.norm(w.t_m - own.truth.t_optical_m) for w in found.variants
              if w.variant == wrong]  # fmt: skip
    assert others[0] > 3e-3


def test_where_a_board_is_off_no_variant_is_ruled_out() -> None:
    """It leaves as much beyond the noise as another sign does."""
    found = calibrated(made("libsurvive", 7), off_mm=1.0)
    assert {w.standing for w in found.variants} == {"chosen", "open"}


@pytest.mark.parametrize("at_once", [True, False], ids=["first", "judged"])
def test_what_batch_cannot_solve_is_chosen_by_board_poses(
    monkeypatch: pytest.MonkeyPatch, at_once: bool
) -> None:
    """Normal equations without a solution, in the first steps or where the variants are judged."""
    solve = variants.with_rotors

    def failing(found: Joint, rotors: np.ndarray, rounds: int = ROUNDS) -> Joint:
        if at_once or rounds == ROUNDS:
            raise np.linalg.LinAlgError("not positive definite")
        solved = solve(found, rotors, rounds)
        assert solved.rounds == rounds or solved.converged
        return solved

    own = made("libsurvive", 7)
    monkeypatch.setattr(variants, "with_rotors", failing)
    found = calibrated(own, "batch")
    standing = {w.variant: w.standing for w in found.variants}
    assert standing["crazyflie"] == "worse"
    assert [e.estimator for e in found.estimates] == ["batch"]


def test_a_board_at_rest_leaves_variants_open_as_far_as_its_estimate_has_them() -> None:
    """With the curve of one station of another sign, depths of lasers imitate it: 60 mm off the
    truth, 2.9 standard deviations where those of the static pose were 5 mm."""
    rng, known = np.random.default_rng(14), factories()
    curved = int(np.argmax([np.abs(one["curve"]).max() for one in known]))
    other = int(rng.choice([k for k in range(len(known)) if k != curved]))
    still = {"pattern": "still", "centre_m": (2.2, 0.9, -1.2), "tremor_mm": 0.0, "tremor_deg": 0.0}
    stations = {"master": {"factory": known[curved]}, "slave": {"factory": known[other]}}
    board = {"columns": 5, "rows": 3}
    how = {"variant": "libsurvive", "duration_s": 2.0, "board": board, "motion": still}
    truth = (made := simulate(pairs.twin(14, **stations, **how))).truth
    board = truth.board + 1e-4 * rng.normal(size=truth.board.shape)
    settings = CalibrationSettings(("batch",), ("factory",))
    values = [station.factory for station in truth.stations]
    found = calibrate(made.hits, board, values, settings)
    pose = next(one for one in found.estimates if one.estimator == "batch")
    off = pairs.UNITS * pairs.error(pose.R, pose.t_m, truth.R, truth.t_optical_m)
    assert np.linalg.norm(off[:3]) > 50  # mm
    assert (np.abs(off) < 2 * np.sqrt(np.diag(pose.covariance))).all()
