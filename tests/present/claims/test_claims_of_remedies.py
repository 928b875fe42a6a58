"""Claims on a shock, a repair, weights and filters: by series and models made for the purpose."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.shock import shock_effect
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.present.claims.claim import DOES_NOT, HOLDS, UNKNOWN
from mocap_metrology.present.claims.jansen import Calibrations
from mocap_metrology.present.claims.study import TYPES, Published, Regenerated
from mocap_metrology.present.claims.table import claims

BY_ID = claims()
RATE = 60.0


def shaken(amplitude: float, after: float = 1.0, seed: int = 1) -> dict[str, np.ndarray]:
    """Fifteen minutes of six coordinates and L: a swing in the middle, noise times `after` then."""
    rng = np.random.default_rng(seed)
    n = round(900 * RATE)
    t = np.arange(n) / RATE - 450
    swing = np.where(t >= 0, amplitude * np.exp(-np.maximum(t, 0) / 4) * np.sin(2 * np.pi * t), 0)
    level = np.where(t >= 0, after, 1.0) * 0.01
    found = {s: level * rng.standard_normal(n) + swing for s in SERIES[:6]}
    return found | {"L": 160 + 1.4 * level * rng.standard_normal(n) + 0.7 * swing}


def words(study) -> list[str]:
    return [BY_ID[name].find(study).word for name in ("S-3.5-crump", "S-3.5-sides")]


def test_a_shock_and_its_sides() -> None:
    found = shock_effect(shaken(0.5), RATE)
    assert words(Regenerated({}, {}, {}, found)) == [HOLDS, HOLDS]
    assert 0.05 <= found.tau_s <= 2.0  # a swing of 1 Hz
    assert words(Regenerated({}, {}, {}, shock_effect(shaken(0.5, 1.15), RATE))) == [
        HOLDS,
        DOES_NOT,
    ]
    hairline = words(Regenerated({}, {}, {}, shock_effect(shaken(0.5, 1.03), RATE)))
    assert hairline == [HOLDS, UNKNOWN]
    faint = shock_effect(shaken(0.05), RATE)
    assert faint.raised < found.raised
    assert words(Regenerated({}, {}, {})) == words(Published()) == [UNKNOWN] * 2
    assert shock_effect({k: v[:18000] for k, v in shaken(0.5).items()}, RATE) is None


def rows(series: str, estimator: str, model: dict[str, float]) -> list[dict]:
    return [
        {"series": series, "estimator": estimator, "parameter": k, "value": v, "status": "ok"}
        for k, v in model.items()
    ]


def test_what_is_left_after_a_repair() -> None:
    claim = BY_ID["S-B-repair"]
    slow = {"h_0": 1e-6, "q_c1": 1e-3, "T_c1": 300.0, "A_s": 1e-3, "f_0": 14.4}
    fast = slow | {"q_c2": 0.01, "T_c2": 0.05}
    for models, word in (((slow, {"h_0": 1e-6}), HOLDS), ((slow, fast), DOES_NOT)):
        named = {str(k): rows("z1", "likelihood", m) for k, m in enumerate(models)}
        assert claim.find(Regenerated({}, {}, {}, None, named)).word == word
    assert claim.find(Regenerated({}, {}, {})).word == UNKNOWN


def test_weighted_against_ordinary_least_squares() -> None:
    """A fit that follows the curve everywhere, and one that is right at the longest tau only."""
    truth = {"h_-2": 4e-10, "h_0": 1e-6}
    tau = np.unique(np.round(np.geomspace(1, 1e5, 60))) / 120
    adev = np.sqrt(NoiseModel.from_coefficients(truth).avar(120 * tau, 120, "continuous"))
    keys = [(kind, n) for kind, ns in TYPES.items() for n in ns]
    columns = {
        "series": np.repeat(np.array(SERIES, dtype=object), tau.size),
        "estimator": np.full(tau.size * len(SERIES), "oadev", dtype=object),
        "tau_s": np.tile(tau, len(SERIES)),
        "adev_mm": np.tile(adev, len(SERIES)),
    }
    near, far = {"h_-2": 4.2e-10, "h_0": 1.01e-6}, {"h_-2": 4e-10, "h_0": 3e-6}
    for weighted, ordinary, word in ((near, far, HOLDS), (far, near, DOES_NOT)):
        of = [
            r
            for s in SERIES
            for r in (
                *rows(s, "annealing-ant-colony", weighted),
                *rows(s, "levenberg-marquardt", ordinary),
            )
        ]
        study = Regenerated(dict.fromkeys(keys, columns), dict.fromkeys(keys, of), {})
        assert BY_ID["S-3.4-weighted"].find(study).word == word


def test_filters() -> None:
    """White noise: a Butterworth of 6 Hz, both ways, keeps 3 pi 6 / (8 sqrt 2) = 5.0 Hz of it, so
    4.0 of 59 above 1 Hz; random walk stays."""
    keys = [(kind, n) for kind, ns in TYPES.items() for n in ns]
    white = {"h_0": 1e-6, "h_-2": 4e-10}
    line = white | {"A_s": 1e-3, "f_0": 14.4}
    for model, word in ((white, HOLDS), ({"h_-2": 1e-6}, DOES_NOT)):
        of = [r for s in SERIES for r in rows(s, "annealing-ant-colony", model)]
        study = Regenerated({}, dict.fromkeys(keys, of), {})
        assert BY_ID["S-5-low-pass"].find(study).word == word
    assert "retains 7 % above 1 Hz" in _low_pass_of_white(keys)
    of = [
        r
        for s in SERIES
        for r in (*rows(s, "annealing-ant-colony", line), *rows(s, "likelihood", line))
    ]
    found = BY_ID["S-5-band-stop"].find(Regenerated({}, dict.fromkeys(keys, of), {}))
    assert found.word == HOLDS and found.value.startswith("1.7 % of the noise")  # 1 of 59 Hz
    assert BY_ID["S-5-low-pass"].find(Published()).word in (HOLDS, DOES_NOT, UNKNOWN)


def _low_pass_of_white(keys) -> str:
    of = [r for s in SERIES for r in rows(s, "annealing-ant-colony", {"h_0": 1e-6})]
    return BY_ID["S-5-low-pass"].find(Regenerated({}, dict.fromkeys(keys, of), {})).value


@pytest.mark.parametrize(
    ("seconds", "word", "text"),
    [
        (2.0, HOLDS, "less than 10 s"),
        (100.0, HOLDS, "less than 180 s"),
        (400.0, DOES_NOT, "more than 180 s"),
        (float("nan"), UNKNOWN, "no simulated"),
    ],
)
def test_a_few_minutes(seconds: float, word: str, text: str) -> None:
    found = BY_ID["J-VIII-minutes"].find(Calibrations([], {}, {}, seconds))
    assert found.word == word and found.value.startswith(text)
