"""Twins of the configuration: what is refused, what is merged, and the protocol they keep to."""

import numpy as np
import pytest
import yaml
from mocap_workflow.calibration_twins import calibration_twin, twin_from_mapping

from mocap_metrology.common.faults import Faults
from mocap_metrology.lighthouse.simulate.motion import motion_of

MASTER = {"id": 1, "mode": "b"}
SLAVE = {"id": 2, "mode": "c", "position_m": [0, 2, 0]}
TWIN = {"seed": 1, "master": MASTER, "slave": SLAVE, "motion": {"centre_m": [3, 1, 0]}}
LINE = {"centre_m": [3, 1, 0], "pattern": "line"}
ALONE = {"slave": None, "master": {"id": 1, "mode": "A"}}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sed": 1}, "unknown key 'sed', expected one of seed, "),
        ({"seed": None}, "twin t: seed is missing"),
        ({"seed": -1}, "seed: -1, expected a whole number"),
        ({"seed": True}, "seed: True, expected a whole number"),
        ({"motion": {}}, "motion: centre_m is missing"),
        ({"motion": {"centre_m": [3, 1]}}, "centre_m: [3, 1], expected a list of 3 numbers"),
        ({"motion": {"centre_m": [3000, 1, 0]}}, "3000, expected a number from -20 to 20"),
        ({"motion": {"centre_m": [3, 1, 0], "pattern": "loop"}}, "expected one of line, arc"),
        ({"motion": {**LINE, "speed_m_s": 0}}, "speed or extent is 0"),
        ({"motion": {**LINE, "extent_m": 0}}, "speed or extent is 0"),
        ({"motion": 3}, "motion: 3, expected keys with values"),
        ({"slave": None}, "slave is missing"),
        ({"slave": {**SLAVE, "id": 1}}, "the master's too"),
        ({"slave": {**SLAVE, "mode": "b"}}, "modes b + b, expected b + c or b + A"),
        ({"slave": {**SLAVE, "position_m": [0, 0.0999, 0]}}, "0.0999 m apart"),
        ({"master": {**MASTER, "position_m": [1e-9, 0, 0]}}, "has a pose"),
        ({"master": {**MASTER, "rotation_deg": [0, 0, 1e-9]}}, "has a pose"),
        ({"master": {**MASTER, "factory": {"curve": [0.2, 0.2]}}}, "second-generation"),
        ({"master": {**MASTER, "factory": {"phase": [0.2]}}}, "expected a list of 2 numbers"),
        ({"master": {**MASTER, "lasers_m": [1, 2, 3]}}, "of axis 0 and axis 1"),
        ({"board": {"columns": 11, "rows": 3}}, "33 diodes, expected 3 to 32"),
        ({"board": {"columns": 2, "rows": 1}}, "2 diodes, expected 3 to 32"),
        ({"dropout": 1.5}, "dropout: 1.5, expected a number from 0 to 1"),
        ({"dropout": "many"}, "dropout: 'many', expected a number"),
        ({"common_urad": float("nan")}, "common_urad: nan, expected a number"),
        ({"blocked": [[0, 1, 1]]}, "1 to 1 s, expected an end after"),
        ({"blocked": [[0, 2, 8.0001]]}, "no such station or time"),
        ({"blocked": [[2, 0, 8]]}, "blocked: 2, expected a whole number from 0 to 1"),
        ({**ALONE, "blocked": [[1, 0, 8]]}, "no such station or time"),
        ({"blocked": [3]}, "expected a list of [station, from_s, to_s]"),
    ],
)
def test_refused_in_one_line(changes, message):
    with pytest.raises(Faults) as refusal:
        twin_from_mapping({**TWIN, **changes}, "t")
    text = str(refusal.value)
    assert text.startswith("twin t: ") and message in text and "\n" not in text


@pytest.mark.parametrize(
    "changes",
    [
        {"motion": {**LINE, "speed_m_s": 1e-9, "extent_m": 1e-9}},
        {"slave": {**SLAVE, "position_m": [0, 0.1, 0]}},
        {"board": {"columns": 3, "rows": 1}},
        {"board": {"columns": 8, "rows": 4}},
        {"blocked": [[1, 0, 8], [0, 1, 1.0001]]},
        {**ALONE, "blocked": [[0, 0, 8]]},
    ],
)
def test_accepted_at_the_limits(changes):
    twin_from_mapping({**TWIN, **changes}, "t")


DOCUMENT = {
    "factories": {"one": {"phase": [0.05, 0.02]}},
    "defaults": {"calibration": {"dropout": 0.1, "motion": {"tremor_mm": 0.05}}},
    "setups": {"s": {"master": {**MASTER, "factory": "one"}, "slave": SLAVE, "dropout": 0.2}},
    "twins": {
        "a": {"setup": "s", "seed": 1, "motion": {"centre_m": [3, 1, 0]}},
        "b": {"like": "a", "common_urad": 53, "motion": {"speed_m_s": 0.7}},
    },
}


def of_document(document, *names):
    return {n: calibration_twin(document, n) for n in names or document["twins"]}


def test_keys_of_defaults_setup_and_like_are_merged():
    twins = of_document(DOCUMENT)
    assert twins["a"].dropout == 0.2 and twins["a"].setup == "s"
    assert twins["b"].common_urad == 53 and twins["b"].seed == 1
    assert twins["b"].motion.speed_m_s == 0.7
    assert twins["b"].motion.centre_m == (3, 1, 0) and twins["b"].motion.tremor_mm == 0.05
    # Factory values are what half floats can say.
    assert twins["a"].master.optics.phase[0] == float(np.float16(0.05))


@pytest.mark.parametrize(
    ("twin", "message"),
    [
        ({"setup": "none"}, "setup: 'none', expected one of s"),
        ({"like": "none"}, "like: 'none'"),
        ({"like": ["b"]}, "like: ['b'], expected"),
        ({"setup": ["s"]}, "setup: ['s'], expected"),
        ({"like": "b"}, "like: 'b', expected a twin without a key like"),
        ({"setup": "s", "slave": {"factory": "two"}}, "slave.factory: 'two', expected one of one"),
        (3, "twin c: 3, expected keys"),
    ],
)
def test_document_refused(twin, message):
    with pytest.raises(Faults, match="twin c") as refusal:
        of_document({**DOCUMENT, "twins": {**DOCUMENT["twins"], "c": twin}})
    assert message in str(refusal.value)


@pytest.fixture(scope="module")
def twins(root):
    """Twins of the default sheet, as the default seed draws them."""
    document = yaml.load((root / "config/twins.yaml").read_text(), yaml.CSafeLoader)
    seed = yaml.safe_load((root / "config/config.yaml").read_text())["seed"]
    names = [name for name in document["twins"] if name.split("-")[0] in FAMILIES]
    found = of_document(document, *names)
    return {
        name: twin.model_copy(update={"seed": twin.seed + seed}) for name, twin in found.items()
    }


FAMILIES = ("sim", "noise", "real")


def angles_ranges_incidence(twin):
    """Greatest angle of a diode in deg, range of the centre in m, greatest incidence in deg."""
    places = np.array([s.t for s in twin.stations])
    R, p = motion_of(twin.motion, places, twin.seed).poses(np.linspace(0, 8, 201))
    diodes = np.einsum("nij,dj->ndi", R, twin.board.positions()) + p[:, None]
    angle, ranges, incidence = [], [], []
    for station in twin.stations:
        q = (diodes - station.t) @ station.R
        angle.append(np.abs(np.arctan2(q[..., 1:], q[..., :1])).max())
        ranges.append(np.linalg.norm(p - station.t, axis=1))
        way = station.t - diodes
        cos = np.einsum("ndi,ni->nd", way, R[:, :, 0]) / np.linalg.norm(way, axis=2)
        incidence.append(np.arccos(cos.min()))
    return np.degrees(max(angle)), np.array(ranges), np.degrees(max(incidence))


def test_twins_keep_to_the_protocol(twins):
    """J section VII: 1-4 m between the stations, 2-6 m to the board, varied motion."""
    assert len(twins) == 140
    for name, twin in twins.items():
        apart = np.linalg.norm(twin.slave.position_m)
        assert 1 <= apart <= 4, name
        if name.startswith("noise"):
            quiet = twins[name.replace("noise", "sim")]
            assert (twin.motion, twin.seed) == (quiet.motion, quiet.seed)
            continue
        angle, ranges, incidence = angles_ranges_incidence(twin)
        assert angle < 49 and incidence < 66, name
        assert ranges.min() >= 2 and ranges.max() <= 6, name
        assert 0.15 <= twin.motion.speed_m_s <= 1 and 0.2 <= twin.motion.extent_m <= 0.5
        assert (twin.master.factory is None) == name.startswith("sim")
