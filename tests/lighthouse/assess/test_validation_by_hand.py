"""Checks of a pose against what else is known of it, of poses made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2, rayleigh

from mocap_metrology.lighthouse.assess import fit_checks, validation
from mocap_metrology.lighthouse.assess.fit_checks import Case
from mocap_metrology.lighthouse.records import Factory, PoseEstimate, Station

T = np.array([0.5, 2.0, -0.1])
POSE = PoseEstimate("batch", "final", "factory", np.eye(3), T)
STATIONS = [Station(role, factory=Factory(), frames_found=3) for role in ("master", "slave")]


def turned(deg: float, axis: tuple[float, float, float] = (0, 0, 1.0)) -> np.ndarray:
    return Rotation.from_rotvec(math.radians(deg) * np.array(axis)).as_matrix()


def gravity(deg: float, optics: str = "factory") -> validation.Check:
    """Of stations whose own ways up differ by an angle, seen from the pose."""
    R = turned(40.0, (0.3, -0.5, 0.2))
    up = np.array([0.2, 0.1, 0.9])
    across = np.cross(up, [1.0, 0, 0])
    tilt = Rotation.from_rotvec(math.radians(deg) * across / np.linalg.norm(across)).apply(up)
    stations = [replace(STATIONS[0], gravity=up), replace(STATIONS[1], gravity=3 * R.T @ tilt)]
    return validation.gravity(replace(POSE, R=R, optics=optics), stations)


def test_ways_up_of_two_stations_differ_as_rayleigh_has_it() -> None:
    """1.5 deg in each of two directions: one sound pair in 200, one in 1e9."""
    first, second = (rayleigh.isf(p, scale=1.5) for p in (5e-3, 1e-9))
    for deg, level in (
        (0.0, "good"),
        (0.999 * first, "good"),
        (1.001 * first, "doubtful"),
        (0.999 * second, "doubtful"),
        (1.001 * second, "failed"),
        (179.0, "failed"),
    ):
        check = gravity(deg)
        assert check.value == pytest.approx(deg, abs=1e-6)
        assert (check.level, check.ok) == (level, level == "good")
        assert check.limit == pytest.approx(first if level == "good" else second)
        assert check.case == (Case.GRAVITY if level == "good" else Case.GRAVITY_OFF)
    assert gravity(20.0, "ideal").case == Case.GRAVITY_OFF_IDEAL
    assert validation.gravity(POSE, STATIONS).case == Case.GRAVITY_UNKNOWN
    none = [replace(one, gravity=np.zeros(3)) for one in STATIONS]
    assert math.isnan(validation.gravity_angle_deg(np.eye(3), none))


@pytest.mark.parametrize(
    ("misfit", "frames", "stage", "case", "level"),
    [
        (1.0, 0, "final", Case.FACTORY_FILE, "usable"),
        (19.0, 0, "final", Case.FACTORY_DOUBTED, "doubtful"),  # those of another station: 4 deg off
        (19.0, 3, "final", Case.FACTORY, "good"),
        (11.0, 0, "static", Case.FACTORY_FILE, "usable"),  # as of a sound headset at rest
    ],
)
def test_values_of_a_file_that_pieces_contradict(misfit, frames, stage, case, level) -> None:
    stations = [replace(STATIONS[0], frames_found=frames), STATIONS[1]]
    pose = replace(POSE, stage=stage, details={"misfit": misfit}, covariance=np.eye(6))
    checks = validation.verdict(pose, [pose], stations).checks
    (found,) = (check for check in checks if check.name == "factory values")
    assert (found.case, found.level) == (case, level)
    assert found.names == (() if frames else ("master",))


@pytest.mark.parametrize(
    ("generation", "diodes", "hidden", "frames", "stage", "case"),
    [
        (1, 4, 7.8, 0, "final", Case.FACTORY_UNSEEN),  # a deck that moved little: 15 sigma off
        (1, 4, 0.9, 0, "final", Case.FACTORY_FILE),  # far: shown by the pieces of 22 of 22
        (1, 4, 7.8, 3, "final", Case.FACTORY),
        (1, 4, 94.0, 0, "static", Case.FACTORY_FILE),
        (2, 4, 0.6, 0, "final", Case.FACTORY_UNSEEN),  # up to 21 sigma off at a misfit of 1
        (2, 5, 0.6, 0, "final", Case.FACTORY_FILE),
    ],
)
def test_values_of_a_file_that_need_not_show(
    generation, diodes, hidden, frames, stage, case
) -> None:
    stations = [replace(one, frames_found=frames, generation=generation) for one in STATIONS]
    ratios = {"diode": {str(k): 1.0 for k in range(diodes)}}
    details = {"misfit": 1.0, "residual_ratios": ratios, "hidden_optics_mrad": hidden}
    batch = replace(POSE, estimator="batch", stage=stage, details=details, covariance=np.eye(6))
    checks = validation.verdict(batch, [batch], stations).checks
    (found,) = (check for check in checks if check.name == "factory values")
    assert found.case is case and found.level == ("usable" if frames == 0 else "good")


@pytest.mark.parametrize(
    ("left", "stage", "case", "level"),
    [(1.0, "final", Case.MISFIT, "usable"), (1.9, "final", Case.MISFIT, "usable"),
     (2.0, "final", Case.MISFIT_OPEN, "doubtful"), (9.0, "static", Case.MISFIT, "usable")],
)  # fmt: skip
def test_pieces_that_no_step_makes_agree(left, stage, case, level) -> None:
    pose = replace(POSE, stage=stage, details={"misfit": 9.0, "misfit_left": left})
    check = fit_checks.misfit(pose)
    assert (check.case, check.level, check.numbers["times"]) == (case, level, 3.0)


def test_the_least_certain_of_equally_good_stations_is_told() -> None:
    sd = {"1": 2.0, "4": 5.0, "9": 3.0}
    poses = {
        k: replace(POSE, station=k, covariance=np.eye(6) * (1e-2 * v) ** 2) for k, v in sd.items()
    }
    told = {k: validation.verdict(pose, [pose], STATIONS) for k, pose in poses.items()}
    assert validation.worst_of(told, ()).station == "4"


@pytest.mark.parametrize(
    ("mm", "deg", "level"),
    [
        *((29.9, 1.99, "good"), (30.1, 0.0, "usable"), (0.0, 2.01, "usable")),
        *((99.9, 4.99, "usable"), (100.1, 0.0, "doubtful"), (0.0, 5.01, "doubtful")),
    ],
)
def test_against_a_reference(mm: float, deg: float, level: str) -> None:
    errors = mm * np.array([0.6, 0, -0.8]), deg * np.array([0, 0.6, 0.8])
    check = validation.against_reference(errors)
    assert (check.level, check.value) == (level, pytest.approx(mm))
    assert check.numbers["deg"] == pytest.approx(deg)
    assert validation.against_reference(None).case == Case.REFERENCE_NONE


def stages(mm: float, deg: float, covariance: np.ndarray | None) -> validation.Check:
    other = replace(POSE, stage="kabsch", R=turned(deg), t_m=np.add(T, [0, 1e-3 * mm, 0]))
    both = [replace(one, covariance=covariance) for one in (POSE, other)]
    (check,) = validation.agreements(both[0], both)
    assert (check.value, check.numbers["deg"]) == (pytest.approx(mm), pytest.approx(deg))
    return check


@pytest.mark.parametrize(
    ("mm", "deg", "level"),
    [
        *((19.9, 0.49, "good"), (20.1, 0.0, "usable"), (0.0, 0.51, "usable")),
        *((59.9, 1.99, "usable"), (60.1, 0.0, "doubtful"), (0.0, 2.01, "doubtful")),
    ],
)
def test_stages_of_one_estimator_agree(mm: float, deg: float, level: str) -> None:
    check = stages(mm, deg, None)
    assert (check.level, check.case, check.ok) == (level, Case.STAGES, level == "good")


def test_a_difference_that_the_covariances_allow_is_no_fault() -> None:
    """d^T (2 C)^-1 d of six degrees of freedom, exceeded once in a thousand."""
    limit = chi2.isf(1e-3, 6)
    sd = 50.0 / math.sqrt(2 * limit)
    C = np.diag([9.0, sd**2, 9.0, 1.0, 1.0, 1.0])
    assert stages(49.99, 0.0, C).case == Case.STAGES_LOOSE
    assert stages(50.01, 0.0, C).case == Case.STAGES
    C[5, 5] = 3.0**2 / (2 * limit)
    assert stages(0.0, 2.99, C).level == "good"
    assert stages(0.0, 3.01, C).level == "doubtful"
    for place in ((0, 0), (0, 5)):
        unknown = C.copy()
        unknown[place] = unknown[place[::-1]] = np.nan
        check = stages(50.0, 0.0, unknown)
        assert (check.case, check.level, check.ok) == (Case.STAGES_UNKNOWN, "usable", None)


@pytest.mark.parametrize(("times", "level"), [(16.0, "doubtful"), (36.0, "failed")])
def test_a_path_that_hits_do_not_follow_is_no_pose(times: float, level: str) -> None:
    """16 times the noise: optics of another station; 36: both planes of a station exchanged, the
    pose 4.7 m off."""
    pose = replace(POSE, details={"weighted_rms_urad": 75.0 * times}, residual_rms_urad=1.0)
    checks = validation.verdict(pose, [pose], STATIONS).checks
    assert {check.name: check.level for check in checks}["residual"] == level
