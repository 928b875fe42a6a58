"""Slow curves that are in no library of signatures get no name of another."""

import numpy as np
import pytest

from benchmarks.sentences._kinds import coloured
from benchmarks.sentences.signatures import RATE, N, T
from mocap_metrology.noise.diagnosis.signatures import Wander, signature
from tests.noise.diagnosis.test_signatures import fading, noise


def saw(rng: np.random.Generator) -> np.ndarray:
    """A mount that slips back after 60 to 160 s."""
    ends = np.concatenate([[0], np.cumsum(rng.uniform(60, 160, 20))])
    which = np.searchsorted(ends, T, "right") - 1
    return 0.06 * (T - ends[which]) / np.diff(ends)[which]


def occluded(rng: np.random.Generator) -> np.ndarray:
    """For half a minute, and then 0.05 mm beside."""
    since = T - rng.uniform(200, 600)
    return np.where((since > 0) & (since < 30), np.nan, 0.05 * (since > 0))


def clicks(rng: np.random.Generator) -> np.ndarray:
    """At random times, every 25 s on average; each fades."""
    since = T - np.cumsum(rng.exponential(25, 100))[:, None]
    return 0.12 * np.where(since > 0, np.exp(-np.maximum(since, 0) / 3), 0).sum(axis=0)


def fading_out(since: np.ndarray, share: float, constant_s: float) -> np.ndarray:
    """A step of 1, of which a share comes later."""
    return np.where(since > 0, 1 - share * np.exp(-np.maximum(since, 0) / constant_s), 0.0)


def only(*kinds: str):
    return lambda found: {*found.kinds} <= {*kinds} and not found.noise


def no_step(found: Wander) -> bool:
    return "step" not in found.kinds and found.undecided


def not_a_walk(found: Wander) -> bool:
    return found.noise in ("", "steep") and (not found.noise or "noise" not in found.possible)


# The density of the last is that of no sum of other noises
OTHER = {
    "saw": (saw, only("step", "drift")),
    "occluded": (occluded, only("step")),
    "settles by 0.1 mm, of which 0.06 mm over some minutes": (
        lambda r: 0.1 * fading_out(T - r.uniform(200, 400), 0.6, 60),
        no_step,
    ),
    "warm-up and step": (
        lambda r: 0.15 * np.exp(-T / 120) + 0.06 * (r.uniform(300, 600) < T),
        only("warm_up", "step"),
    ),
    "opposite approaches": (
        lambda r: 0.15 * np.exp(-T / T[-1]) - 0.12 * np.exp(-T / 300),
        only("warm_up"),
    ),
    "part of a day": (lambda r: 0.15 * np.sin(2.36 * T / T[-1] + 6), only()),
    "parabola and cycle": (
        lambda r: 0.3 * (T / T[-1]) ** 2 + 0.03 * np.sin(T / 10 + r.uniform(0, 6)),
        only("cycle"),
    ),
    "clicks": (clicks, lambda found: not found.of & {"levels", "step", "shift"}),
    "fast approaches": (
        lambda r: 0.2 * np.exp(-T / 12) + 0.2 * np.exp(-T / 60),
        lambda found: found.kinds == ("slowing",),
    ),
    "ramp of people who enter and stay": (
        lambda r: 0.1 * np.clip((T - r.uniform(50, 450)) / 30, 0, 1),
        no_step,
    ),
    "fading": (lambda r: fading(r, 30), no_step),
    "f^-2.5": (lambda r: coloured(-2.5, 2e-4)(r, N, RATE), not_a_walk),
}


@pytest.mark.parametrize("case", OTHER)
def test_shapes_that_are_not_in_the_library_get_no_name_of_another(case: str) -> None:
    draw, holds = OTHER[case]
    found = signature(draw(np.random.default_rng(1)) + noise(1), RATE)
    assert found is not None and holds(found), found
