"""Recordings of shared hardware with the errors of real ones: moved stations are found, others are
not called moved. `benchmarks/moved_stations.py` does the same with more setups and whole dumps."""

import json

import numpy as np
import pytest

from mocap_metrology.lighthouse.assess.comparison import Comparison, compare_with_earlier
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.records import Factory, Station
from mocap_metrology.lighthouse.rotation import exp, to_angles
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.twin import (
    FactoryValues,
    LighthouseTwin,
    MotionTwin,
    StationTwin,
)

STATIONS = [Station("master", 1, "b"), Station("slave", 2, "c")]
SETTINGS = CalibrationSettings(estimators=("batch",), optics=("factory",))


def setup(seed: int) -> tuple[LighthouseTwin, np.ndarray, np.random.Generator]:
    """A twin with errors of phases and lasers, and a board file with errors of place and scale."""
    rng, priors = np.random.default_rng([seed, 7]), Priors()
    phase, depth = 1e-3 * rng.normal(size=(2, 2)), 5e-3 * rng.normal(size=2)
    optics = [
        {
            "factory": FactoryValues(phase=tuple(phase[k])),
            "lasers_m": ((d, 0.0, 0.0), (-d, 0.0, 0.0)),
        }
        for k, d in enumerate(depth)
    ]
    where = {"position_m": (0.5, 2.5, 0.3), "rotation_deg": (5.0, 4.0, -40.0)}
    twin = LighthouseTwin(
        seed=seed,
        master=StationTwin(id=1, mode="b", **optics[0]),
        slave=StationTwin(id=2, mode="c", **where, **optics[1]),
        motion=MotionTwin(centre_m=(2.6, 1.0, 0.2), extent_m=0.5, wobble_deg=12.0),
        duration_s=4.0,
        common_urad=53.0,
        independent_urad=49.0,
    )
    board = twin.board.positions()
    board = board + 1e-3 * priors.board_position_mm * rng.normal(size=board.shape)
    return twin, board * (1 + priors.board_scale * rng.normal()), rng


def document(twin: LighthouseTwin, board: np.ndarray, seed: int):
    made = simulate(twin, seed)
    found = calibrate(made.hits, board, [Factory(), Factory()], SETTINGS)
    return json.loads(json.dumps(summary(found, STATIONS).document, default=str))


def moved(twin: LighthouseTwin, mm: np.ndarray, deg: np.ndarray) -> LighthouseTwin:
    t, R = twin.slave.t + 1e-3 * mm, exp(np.radians(deg)) @ twin.slave.R
    angles = tuple(np.degrees(to_angles(R)))
    return twin.model_copy(
        update={
            "slave": twin.slave.model_copy(update={"position_m": tuple(t), "rotation_deg": angles})
        }
    )


@pytest.mark.parametrize("setups", [1, pytest.param(10, marks=pytest.mark.study)])
def test_moved_stations_are_found_and_others_are_not_called_moved(setups: int) -> None:
    """Setups of 4 s, each unchanged, shifted by 4 mm, turned by 0.12 deg: at most one comparison in
    nine is wrong, although sigma of each pose is more than 2 mm."""
    found: dict[str, list[Comparison]] = {"unchanged": [], "shifted": [], "turned": []}
    sigma = []
    for k in range(setups):
        twin, board, rng = setup(k)
        way = rng.normal(size=3)
        way /= np.linalg.norm(way)
        earlier = document(twin, board, 10 * k)
        sigma.append(np.sqrt(np.diag(earlier["poses"][0]["covariance"])[:3]).max())
        for j, (case, mm, deg) in enumerate(
            (("unchanged", 0, 0), ("shifted", 4.0, 0), ("turned", 0, 0.12))
        ):
            new = document(moved(twin, mm * way, deg * way), board, 10 * k + 1 + j)
            found[case].append(compare_with_earlier(new, earlier))
    assert np.median(sigma) > 2
    assert all(one.basis == "difference" for case in found.values() for one in case)
    wrong = sum(not one.valid for one in found["unchanged"])
    wrong += sum(one.valid for case in ("shifted", "turned") for one in found[case])
    assert 9 * wrong <= 3 * setups
    assert np.median([one.shift[0] for one in found["unchanged"]]) < 1.5
