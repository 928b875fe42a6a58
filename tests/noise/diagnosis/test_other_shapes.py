"""Slow curves that are in no library of signatures get no name of another."""

import numpy as np
import pytest

from benchmarks.sentences._kinds import coloured
from benchmarks.sentences.signatures import KINDS, RATE, N, T
from mocap_metrology.noise.diagnosis.signatures import Wander, signature
from tests.noise.diagnosis.test_signatures import fading, noise


def saw(rng: np.random.Generator) -> np.ndarray:
    """A mount that slips back after 60 to 160 s."""
    ends = np.concatenate([[0], np.cumsum(rng.uniform(60, 160, 20))])
    which = np.searchsorted(ends, T, "right") - 1
    return 0.06 * (T - ends[which]) / np.diff(ends)[which]


def bumps(rng: np.random.Generator) -> np.ndarray:
    """Of some seconds, at any times."""
    times = np.cumsum(rng.exponential(45, 60))
    return sum(0.05 * np.exp(-(((T - t) / rng.uniform(3, 8)) ** 2)) for t in times)


def occluded(rng: np.random.Generator) -> np.ndarray:
    """For half a minute, and then 0.05 mm beside."""
    since = T - rng.uniform(200, 600)
    return np.where((since > 0) & (since < 30), np.nan, 0.05 * (since > 0))


def clicks(rng: np.random.Generator) -> np.ndarray:
    """At random times, every 25 s on average; each fades."""
    since = T - np.cumsum(rng.exponential(25, 100))[:, None]
    return 0.12 * np.where(since > 0, np.exp(-np.maximum(since, 0) / 3), 0).sum(axis=0)


def ramp(rng: np.random.Generator, ramp_s: float) -> np.ndarray:
    """Of people who enter and stay."""
    return 0.1 * np.clip((T - rng.uniform(50, 450)) / ramp_s, 0, 1)


def dew(rng: np.random.Generator) -> np.ndarray:
    """Which grows, and is wiped off."""
    wiped = rng.uniform(500, 700)
    return np.where(wiped > T, 0.06 * (T / wiped) ** 2, 0.0)


def settles(rng: np.random.Generator, later_mm: float) -> np.ndarray:
    """By 0.1 mm, of which a part over some minutes."""
    since = T - rng.uniform(200, 400)
    return np.where(since > 0, 0.1 - later_mm * np.exp(-np.maximum(since, 0) / 60), 0.0)


def warm(*constants_s: float):
    return lambda r: sum(0.2 * np.exp(-T / T_w) for T_w in constants_s)


def only(*kinds: str):
    return lambda found: {*found.kinds} <= {*kinds} and not found.noise


def no_step(found: Wander) -> bool:
    return "step" not in found.kinds and found.undecided


def not_a_walk(found: Wander) -> bool:
    return found.noise in ("", "steep") and (not found.noise or "noise" not in found.possible)


# The density of the last two is that of no sum of other noises
OTHER = {
    "saw": (saw, only("step", "drift")),
    "bumps": (bumps, only()),
    "occluded": (occluded, only("step")),
    "dew": (dew, only("step")),
    **{f"settles by {s} mm": (lambda r, s=s: settles(r, s), no_step) for s in (0.03, 0.06)},
    "warm-up and step": (
        lambda r: 0.15 * np.exp(-T / 120) + 0.06 * (r.uniform(300, 600) < T),
        only("warm_up", "step"),
    ),
    "two approaches": (
        lambda r: 0.1 * np.exp(-T / 80) + 0.15 * np.exp(-T / 500),
        only("slowing"),
    ),
    "opposite approaches": (
        lambda r: 0.15 * np.exp(-T / T[-1]) - 0.12 * np.exp(-T / 300),
        only("warm_up"),
    ),
    "bent": (lambda r: 0.05 * np.minimum(T / 400, 1) + 0.05 * T / 400, only()),
    "part of a day": (lambda r: 0.15 * np.sin(2.36 * T / T[-1] + 6), only()),
    "parabola and cycle": (
        lambda r: 0.3 * (T / T[-1]) ** 2 + 0.03 * np.sin(T / 10 + r.uniform(0, 6)),
        only("cycle"),
    ),
    "stretched exponential": (lambda r: 0.4 * np.exp(-np.sqrt(T / 60)), only("slowing")),
    "two levels": (lambda r: KINDS["two levels"][0](r, T), only("two_levels")),
    "clicks": (clicks, lambda found: not found.of & {"levels", "step", "shift"}),
    "fast approaches": (warm(6.0, 20.0), lambda found: found.kinds == ("slowing",)),
    "less fast": (warm(12.0, 60.0), lambda found: found.kinds == ("slowing",)),
    **{f"ramp {s} s": (lambda r, s=s: ramp(r, s), no_step) for s in (12, 30, 60)},
    **{f"fading {s} s": (lambda r, s=s: fading(r, s), no_step) for s in (12, 30, 60)},
    "f^-2.5": (lambda r: coloured(-2.5, 2e-4)(r, N, RATE), not_a_walk),
    "f^-3": (lambda r: coloured(-3.0, 2e-6)(r, N, RATE), not_a_walk),
}


@pytest.mark.parametrize("case", OTHER)
def test_shapes_that_are_not_in_the_library_get_no_name_of_another(case: str) -> None:
    draw, holds = OTHER[case]
    for seed in range(2):
        found = signature(draw(np.random.default_rng(seed)) + noise(seed), RATE)
        assert found is not None and holds(found), found
