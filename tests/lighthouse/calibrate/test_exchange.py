"""Factory values of two stations, each stated for the other."""

from dataclasses import dataclass
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.lighthouse_recordings import flight
from mocap_metrology.lighthouse.assess.fit_checks import Case
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.calibrate import variants
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.records import ROLES, Station
from tests.lighthouse.batch.planes_scene import factory, made

SETTINGS = CalibrationSettings(estimators=("batch",), optics=("factory",), variant="libsurvive")


def first_generation():
    """Ten seconds of a deck's flight; the error of a true pose is below 5 mm."""
    one = flight(1, seconds=10.0)
    hits, _ = clean_hits(one.hits, one.truth.board)
    factories = [station.factory for station in one.truth.stations]
    return hits, one.truth.board, factories, list(ROLES), one.truth.t_optical_m


def second_generation():
    one = made(2, 3, 2.5)
    scene = one.scene
    return scene.hits, scene.board, list(scene.factories), list(scene.names), one.poses[1][1]


@dataclass(frozen=True)
class Names:
    """What `exchanged` asks of a scene of stations without light."""

    names: tuple[str, ...]
    factories: tuple[int, ...]
    optics: str = "factory"

    @property
    def rotors(self) -> tuple[int, ...]:
        return self.factories


@pytest.mark.parametrize("pair", list(combinations(range(4), 2)))
def test_each_two_of_four_stations_may_be_exchanged(monkeypatch, pair) -> None:
    """Where the values are all of a file."""
    right = [0, 1, 2, 3]
    right[pair[0]], right[pair[1]] = right[pair[1]], right[pair[0]]
    monkeypatch.setattr(
        variants, "_fits_worse", lambda scene, solution, other: other.factories == right
    )
    solution = SimpleNamespace(
        misfit=2.0, recordings=[SimpleNamespace(trajectory=SimpleNamespace(still=False))]
    )
    found = variants.exchanged(Names(tuple("abcd"), (0, 1, 2, 3)), solution, [])
    assert found == tuple("abcd"[k] for k in pair)


@pytest.mark.parametrize("recording", [first_generation, second_generation])
def test_exchanged_values_are_named(recording) -> None:
    hits, board, factories, names, t_m = recording()
    errors = {}
    for exchanged in (False, True):
        stations = [
            Station(name, id=k, factory=own, frames_found=0, generation=own.generation)
            for k, (name, own) in enumerate(
                zip(names, factories[:: -1 if exchanged else 1], strict=True)
            )
        ]
        given = [station.factory for station in stations]
        found = calibrate(hits, board, given, SETTINGS, stations=stations)
        told = summary(found, stations, duration_s=8.0)
        cases = {check.case: check for check in told.verdict.checks}
        errors[exchanged] = 1e3 * np.linalg.norm(found.estimates[0].t_m - t_m)
        assert (Case.FACTORY_EXCHANGED in cases) is exchanged
        if exchanged:
            assert cases[Case.FACTORY_EXCHANGED].names == tuple(names)
            assert told.verdict.word in ("doubtful", "failed")
        else:
            assert told.verdict.word in ("good", "usable")
    assert errors[True] > 5 * errors[False]


def test_values_of_another_station_make_every_pose_doubtful() -> None:
    """As its light carries them, and where the pose is that of two other stations: the board's path
    is of all."""
    one = made(3, 4, 3.0)
    names, factories = list(one.scene.names), list(one.scene.factories)
    wrong = [*factories[:2], factory(np.random.default_rng(9))]
    words = {}
    for given in (factories, wrong):
        stations = [
            Station(name, id=k, factory=own, frames_found=2, generation=2)
            for k, (name, own) in enumerate(zip(names, given, strict=True))
        ]
        hits, board = one.scene.hits, one.scene.board
        found = calibrate(hits, board, given, SETTINGS, stations=stations)
        told = summary(found, stations, duration_s=8.0).verdict
        words[given is wrong] = set(told.words.values())
        cases = {check.case for check in told.checks}
        assert (Case.MISFIT_OPEN in cases) is (given is wrong)
    assert words == {False: {"good"}, True: {"doubtful"}}
