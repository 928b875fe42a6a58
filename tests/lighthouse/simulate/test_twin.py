"""Twins of the configuration: what is refused, what is merged, and the protocol they keep to."""

import numpy as np
import pytest
from mocap_workflow.calibration_twins import calibration_twin, twin_from_mapping

from mocap_metrology.common.faults import Faults

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
