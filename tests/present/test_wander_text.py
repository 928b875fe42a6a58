"""Slow wander in words: what is measured, and a kind only where it is sure."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from mocap_metrology.noise.assess.recording import _unnamed
from mocap_metrology.noise.diagnosis.findings import model_findings
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.present.text.drift import at_once_words, wander_sentences

RECORDING = SimpleNamespace(duration_s=900.0, coordinates={"x1": np.zeros(1)})
MOVED = (0.05, 0.001, 0.06)


def words(one: Wander, events=()) -> list[str]:
    found = SimpleNamespace(wanders={"x1": one, "L": one}, events=list(events))
    return [sentence.words for sentence in wander_sentences(found, [], RECORDING)]


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (Wander((), False, (), *MOVED), ""),
        (Wander((), True, ("drift",), *MOVED), ""),
        (Wander((), False, ("cycle", "drift"), *MOVED), "Slow wander of 60 µm in 15 min (x1); its "
         "kind cannot be decided from this recording, one of an hour may show it."),
        (Wander(("warm_up",), False, (), *MOVED, 0.06, ()), "x1 approaches a position: it moved by "
         "50 µm in 15 min, ever more slowly."),
        (Wander(("accelerating",), False, (), *MOVED, 0.06, ()), "x1 moved by 50 µm in 15 min, "
         "ever faster: check that the marker and the cameras are mounted firmly."),
        (Wander(("creep",), False, (), *MOVED, 0.06, ()), "x1 creeps: it moved by 50 µm in 15 min, "
         "ever more slowly."),
        (Wander(("cycle",), False, (), *MOVED, 0.03, (200.0,)), "x1 goes to and fro with a period "
         "of 3.33 min, amplitude 30 µm."),
        (Wander(("two_levels",), False, (), *MOVED, 0.03, (50.0,)), "x1 switches between two "
         "positions 30 µm apart, every 50 s on average: a camera may gain and lose the marker."),
    ],
)  # fmt: skip
def test_a_kind_in_words(one: Wander, said: str) -> None:
    assert words(one) == ([said] if said else [])


def test_a_step_is_said_once() -> None:
    step = Wander(("step",), False, ("step",), *MOVED, -0.05, (300.0,))
    assert words(step) == ["At 5 min x1 shifted by 50 µm and stayed there."]
    assert words(step, [SimpleNamespace(time_s=299.0, stop_s=301.0)]) == []
    assert at_once_words(299.0, 301.0, {"x1": step}) == "shifted by 50 µm (x1) and stayed there"
    assert at_once_words(399.0, 401.0, {"x1": step}) == ""


def test_both_ends_of_a_shift() -> None:
    shift = {"y1": Wander(("shift",), False, ("shift",), *MOVED, 0.05, (300.0, 320.0))}
    assert at_once_words(299, 301, shift) == "shifted by 50 µm (y1) and came back within 20 s"
    assert at_once_words(319, 321, shift) == "shifted back by 50 µm (y1)"
    short = {"y1": Wander(("shift",), False, ("shift",), *MOVED, 0.05, (300.0, 303.0))}
    assert at_once_words(299, 301, short) == ""


def test_a_coefficient_of_another_kind_is_no_finding() -> None:
    row = {
        "series": "x1", "estimator": "likelihood", "parameter": "h_-2", "status": "ok",
        "value": 1e-6, "std_error": 1e-7, "lower_95": 8e-7, "upper_95": 1.2e-6,
    }  # fmt: skip
    step = Wander(("step",), False, ("step",), *MOVED, 0.05, (300.0,))
    slow = Wander((), True, (), *MOVED)
    assert [one.code for one in model_findings([row], {"x1": slow})] == ["random_walk"]
    assert model_findings([row], {"x1": step}) == []
    assert [one.code for one in model_findings([row])] == ["random_walk"]


def test_shares_of_another_kind_are_of_slow_wander() -> None:
    from dataclasses import dataclass, field

    @dataclass
    class Numbers:
        shares: dict = field(default_factory=dict)
        means: tuple = ()

    found = _unnamed(Numbers({"white": 0.3, "random walk": 0.5, "drift": 0.2}))
    assert found.shares == {"white": 0.3, "slow wander": pytest.approx(0.7)}
