"""Several recordings of any number of stations in one estimate."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.calibration.setup import same_stations
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess import fit_checks
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import solved
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.calibrate.setup import Setup, by_setup
from mocap_metrology.lighthouse.calibrate.static import median_angles
from mocap_metrology.lighthouse.records import Factory, Hits, Station
from mocap_metrology.lighthouse.simulate import recording
from tests.lighthouse import pairs
from tests.lighthouse.batch.planes_scene import Made, made
from tests.lighthouse.pairs import twin

ALL, NEVER = (0.0, 1.0), (0.0, 0.0)


def misses(found: Setup, given: Made, stations: list[int]) -> float:
    """Squared distance of all poses together from the truth, by their covariance."""
    assert found.network is not None and found.network.covariance is not None
    off = []
    for pose, k in zip(found.poses, stations, strict=True):
        R, t = given.poses[k]
        off += [*(1e3 * (pose.t_m - t)), *np.degrees(rotation.error(pose.R, R))]
    return float(np.array(off) @ np.linalg.solve(found.network.covariance, off))


def subsets(
    seed: int, seen: Mapping[str, tuple[int, ...]], n: int = 4, last_mm: float = 0.0
) -> dict[str, Made]:
    """Recordings in each of which some of the stations see the board; last_mm: that the last
    station is moved before the last of them."""
    given = {}
    for take, (name, own) in enumerate(seen.items(), start=1):
        keep = [ALL if k in own else NEVER for k in range(n)]
        bump_mm = last_mm * (take == len(seen))
        given[name] = made(n, seed, 2.0, keep=keep, take=take, bump_mm=bump_mm)
    return given


def test_recordings_that_see_different_stations_place_all_of_them() -> None:
    """No recording sees the reference and station 3 or 2; a chain does. The errors of all poses
    are within the 99.9 % ellipsoid of their covariance (18 degrees of freedom)."""
    given = subsets(3, {"a": (0, 1), "b": (1, 2), "c": (2, 3), "d": (1, 2, 3)})
    found = by_setup({name: own.scene for name, own in given.items()})
    assert [pose.station for pose in found.poses] == ["1", "2", "3"]
    assert not found.network.apart and found.network.connected == ["0", "1", "2", "3"]
    assert misses(found, given["a"], [1, 2, 3]) < chi2.ppf(0.999, 18)
    sd = [np.sqrt(np.trace(pose.covariance[:3, :3])) for pose in found.poses]
    assert max(sd) < 3.0, sd
    # Only a shows where station 1 is, but each of the others sees a pair that d sees, too.
    assert {k: "".join(of) for k, of in found.predicted.items()} == {
        "1": "bd",
        "2": "bcd",
        "3": "cd",
    }
    every = [one.m2 for of in found.predicted.values() for one in of.values()]
    assert max(every) < chi2.ppf(0.999, 6)


def test_a_station_moved_between_recordings_without_the_reference_is_found() -> None:
    """Stations 1 and 2 are seen by both recordings that disagree, the reference by neither."""
    given = subsets(3, {"a": (0, 1), "b": (1, 2), "c": (1, 2)}, 3, 20.0)
    found = by_setup({name: own.scene for name, own in given.items()})
    for of in found.predicted.values():
        assert [*of] == ["b", "c"] and min(one.m2 for one in of.values()) > 10 * chi2.ppf(0.999, 6)


def test_recordings_of_all_stations_predict_each_other() -> None:
    given = subsets(5, {"a": (0, 1, 2), "b": (0, 1, 2)}, 3)
    found = by_setup({name: own.scene for name, own in given.items()})
    assert misses(found, given["a"], [1, 2]) < chi2.ppf(0.999, 12)
    for name in "12":
        assert {k: one.m2 < chi2.ppf(0.999, 6) for k, one in found.predicted[name].items()} == {
            "a": True,
            "b": True,
        }
    alone = solved(given["a"].scene)[0]
    assert np.trace(found.pose.covariance[:3, :3]) < 0.8 * np.trace(alone.covariance[:3, :3])


def test_stations_that_nothing_connects_are_named() -> None:
    given = subsets(3, {"a": (0, 1), "b": (0, 1), "c": (2, 3)})
    found = by_setup({name: own.scene for name, own in given.items()})
    assert found.network.connected == ["0", "1"]
    assert "station 2 (connected with 3 only) shares no view" in found.network.apart["2"]
    assert "c: no station that is connected with 0" in found.why
    with pytest.raises(Refusal, match="1 recordings of the setup can be used"):
        by_setup({name: given[name].scene for name in "ac"})


FACTORY = Factory(generation=2)


def station(channel: int, uid: int | None, factory: Factory | None = None) -> Station:
    return Station(str(channel), uid, factory=factory, generation=2, channel=channel)


def test_stations_are_matched_by_id_then_by_channel() -> None:
    """A station that changed its channel between recordings is one by its id, named by the first;
    where a recording has no id, its channel decides."""
    every = {
        "a": [station(3, 33), station(7, 77)],
        "b": [station(1, None), station(5, 77, FACTORY), station(7, None)],
        "c": [station(3, None)],
    }
    with pytest.raises(Refusal, match="b: two of its stations are one in the other recordings"):
        same_stations(every)
    every["b"] = every["b"][:2]
    found, places = same_stations(every)
    assert [(one.role, one.channel, one.id) for one in found] == [
        ("1", 1, None),
        ("3", 3, 33),
        ("7", 7, 77),
    ]
    assert places == {"a": [1, 2], "b": [0, 2], "c": [1]}
    assert [one.factory for one in found] == [None, None, FACTORY]


@pytest.mark.parametrize(
    ("other", "why"),
    [
        ([station(3, 34)], "station 3 is 34 in b and 33 in a; expected one station a channel"),
        ([Station("master", 1), Station("slave", 2)], "stations of both generations"),
    ],
)
def test_other_stations_are_refused(other: list[Station], why: str) -> None:
    with pytest.raises(Refusal, match=why):
        same_stations({"a": [station(3, 33)], "b": other})


def test_a_channel_of_two_stations_does_not_tell_which() -> None:
    every = {"a": [station(3, 33), station(5, 55)], "b": [station(5, 33), station(3, 55)]}
    found, places = same_stations(every)
    assert [one.id for one in found] == [33, 55] and places["b"] == [0, 1]
    with pytest.raises(Refusal, match="c: station 3 has no id, and 33 and 55 have that channel"):
        same_stations(every | {"c": [station(3, None)]})


PLACES = ((3.0, 0.8, 0.2), (3.6, 0.3, -0.4), (2.5, 1.3, 0.5), (3.3, 1.5, -0.1), (2.7, 0.2, 0.4))


def of_pair(k: int, **slave: object) -> recording.SimulatedSweeps:
    """Recording k of a setup, at a place of its own."""
    return recording.simulate(
        twin(40 + k, duration_s=4.0, motion={"centre_m": PLACES[k]}, slave=slave)
    )


def one_of(own: recording.SimulatedSweeps) -> Scene:
    return pairs.scene(own, priors=Priors())


def test_a_station_moved_between_recordings_is_found() -> None:
    recordings = [of_pair(k) for k in range(2)]
    recordings.append(of_pair(2, position_m=(0.505, 2.5, 0.3)))
    found = by_setup({str(k): one_of(own) for k, own in enumerate(recordings)})
    assert max(pair.m2 for pair in found.predicted["slave"].values()) > 10 * chi2.ppf(0.999, 6)
    assert found.pose.halves.m2 == max(pair.m2 for pair in found.predicted["slave"].values())


@pytest.mark.parametrize(("bump_mm", "share"), [(5.0, 0.5), (1500.0, 0.75)])
def test_a_station_moved_within_a_recording_is_found(bump_mm: float, share: float) -> None:
    """By the step, or by the hits that then fit no path of the board."""
    own, other = (made(2, 3, 3.0, take=take).scene for take in (1, 2))
    end = share * own.hits.time_s.max()
    after = made(2, 3, 3.0, take=1, bump_mm=bump_mm).scene.hits
    parts = own.hits.take(own.hits.time_s < end), after.take(after.time_s >= end)
    columns = {k: np.concatenate([getattr(p, k) for p in parts]) for k in vars(after)}
    found = by_setup({"own": replace(own, hits=Hits(**columns)), "other": other}).pose
    checks = fit_checks.weight(found), fit_checks.halves(found)
    assert any(one.level != "good" and one.names == ("own",) for one in checks)


def test_a_bad_recording_is_left_out_by_name_and_one_is_too_few() -> None:
    own, other = one_of(of_pair(0)), one_of(of_pair(1))
    short = replace(other, hits=other.hits.take(other.hits.time_s < other.hits.time_s.min() + 0.2))
    with pytest.raises(Refusal, match=r"1 recordings of the setup can be used; .*short: "):
        by_setup({"own": own, "short": short})
    found = by_setup({"own": own, "other": other, "short": short})
    assert found.why[0].startswith("short: ") and set(found.predicted["slave"]) == {"own", "other"}


@pytest.mark.parametrize("zero_urad", [0.0, 57.0])
def test_time_zeros_of_each_recording_are_in_the_covariance(zero_urad: float) -> None:
    """A board at rest in each of five recordings, hundreds of hits a diode: with zeros that differ
    between recordings, six directions err by far more than noise makes; without, by noise alone."""
    squares = []
    for seed in range(4):
        rng, scenes, still = np.random.default_rng([6, seed]), {}, {}
        for k, place in enumerate(PLACES):
            turn = tuple(rng.uniform(-20, 20, 3).tolist())
            motion = {"pattern": "still", "centre_m": place, "turn_deg": turn}
            own = recording.simulate(twin(50 + 10 * seed + k, duration_s=1.0, motion=motion))
            zero = 1e-6 * zero_urad * rng.normal(size=(2, 2))
            angle = own.hits.angle_rad + zero[own.hits.station, own.hits.axis]
            hits = replace(own.hits, angle_rad=angle)
            scenes[str(k)] = pairs.scene(own, hits, Priors(0.15, 0, 0, 0, 0))
            still[str(k)] = [median_angles(hits, s, len(own.truth.board)) for s in (0, 1)]
        found = by_setup(scenes, still).pose
        off = pairs.error(found.R, found.t_m, own.truth.R, own.truth.t_optical_m) * pairs.UNITS
        squares.append(pairs.squared(off, found.covariance))
    assert chi2.ppf(0.001, 24) < sum(squares) < chi2.ppf(0.999, 24)
