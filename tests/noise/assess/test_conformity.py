"""The verdict: its rule written out naively, special cases, and twins whose truth is known."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mocap_metrology.common.hampel import hampel
from mocap_metrology.common.parallel import in_turn
from mocap_metrology.noise.assess.checks import Code, Facts, _graded
from mocap_metrology.noise.assess.recording import (
    Assessment,
    Inputs,
    Verdict,
    assess_recording,
    verdict,
)
from mocap_metrology.noise.assess.uncertainty import SeriesNumbers, Span
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw
from mocap_metrology.noise.motion.movement import movement
from mocap_metrology.noise.series import all_series
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.twin import Outliers, Twin
from mocap_metrology.settings import Verdict as Limits

NAN = math.nan
FINE = SeriesNumbers(
    "ok", frame_mm=0.002, frame_lower_mm=0.0019, frame_upper_mm=0.0021, drift_mm_per_h=0.001
)
FACTS = Facts(7200.0, 3600.0, 2, {"x1": 0.0, "y1": 0.0}, {"x1": 0.0, "y1": 0.0})


def judged(facts: Mapping[str, Any] | None = None, **y1: Any) -> Verdict:
    """Of a fine x1, of a y1 with these numbers, and of a distance that must not count."""
    distance = replace(FINE, frame_mm=9.0, status="misfit")
    series = {"x1": FINE, "y1": replace(FINE, **y1), "L": distance}
    return verdict(series, replace(FACTS, **(facts or {})), Limits())


DRIFT = [math.sqrt(12) * 0.1, math.sqrt(12) * 0.25]  # a line of d scatters by d / sqrt(12)


def finding(code: str, **values: float) -> dict[str, Any]:
    return {"findings": [Finding(code, name, value) for name, value in values.items()]}


COARSE = finding("resolution_limited", x1=0.25, y1=0.25)
GAPS = {"frame_mm": NAN, "status": "refused"}
CONSTANT = {"status": "constant", "frame_mm": 0.0, "frame_upper_mm": 0.0}
LABELS = {"labels": ("Head",)}
# facts, numbers of y1 -> word, attributes of the check that decides, codes beside it
SPECIAL = {
    "drift of a walk": (finding("random_walk", y1=1e-9), {"drift_mm_per_h": 0.5}, "usable",
        {"code": Code.RANDOM_WALK, "series": "y1", "value": 0.5, "over_s": 3600.0}, []),
    "drift of another kind": (finding("creep", y1=1.0), {"drift_mm_per_h": -0.5}, "usable",
        {"code": Code.WANDER}, []),
    "drift that was found": (finding("drift", y1=0.5), {"drift_mm_per_h": 0.5}, "usable",
        {"code": Code.DRIFT}, []),
    "drift beside a change": ({"findings": [Finding(k, "y1", 0.5) for k in ("drift", "step")]},
        {"drift_mm_per_h": 0.5}, "usable", {"code": Code.WANDER}, []),
    "filled": (finding("gap_filled", y1=0.004) | {"missing": {"y1": 0.012}}, {}, "usable",
        {"code": Code.MISSING_OR_FILLED, "value": 0.012}, []),
    "low pass": (finding("low_pass", x1=6.1, y1=5.9), {}, "usable",
        {"code": Code.LOW_PASS, "value": 6.0, "unit": "Hz", "names": ()}, []),
    "low pass of one": (finding("low_pass", y1=NAN), {}, "usable",
        {"code": Code.LOW_PASS, "value": NAN, "names": ("y1",)}, []),
    "smoothed": (finding("smoothed", y1=0.1), {}, "usable",
        {"code": Code.PROCESSED, "value": "smoothed", "names": ("y1",)}, []),
    "held": (finding("repeated", y1=0.3) | {"outliers": {"y1": 0.02}}, {}, "usable",
        {"code": Code.PROCESSED, "value": "repeated", "names": ("y1",)}, []),
    "few held": (finding("repeated", y1=0.09) | {"outliers": {"y1": 0.02}}, {}, "usable",
        {"code": Code.OUTLIERS, "series": "y1", "value": 0.02}, []),
    "exchanged": (finding("exchanged", x1=0.1, y1=0.1) | LABELS, {}, "bad",
        {"code": Code.EXCHANGED, "value": 0.1, "names": ("Head",)}, []),
    "constant": ({}, CONSTANT, "bad",
        {"code": Code.CONSTANT, "series": "y1", "names": ("y1",), "limit": 0.25}, []),
    "steps at the limit": (COARSE, {"frame_mm": 0.003, "frame_upper_mm": 0.3}, "usable",
        {"code": Code.STEP, "value": 0.25, "limit": 0.25, "names": (), "unit": "mm"}, []),
    "steps beyond it": (finding("resolution_limited", y1=0.2501), {}, "bad",
        {"code": Code.STEP, "value": 0.2501, "names": ("y1",)}, []),
    "within one step": (COARSE, CONSTANT, "usable", {"code": Code.STEP}, []),
    "all within one step": (finding("resolution_limited", y1=0.1), CONSTANT, "bad",
        {"code": Code.CONSTANT}, [Code.STEP]),
    "wander beyond the steps": (COARSE, {"frame_mm": 0.3}, "bad",
        {"code": Code.FRAME, "series": "y1"}, [Code.STEP]),
    "moves": (finding("moves", x1=300.0, y1=2021.4, L=5.0) | LABELS,
        {"drift_mm_per_h": 5.0, "status": "misfit", "frame_mm": 693.0}, "bad",
        {"code": Code.MOVES, "series": "y1", "value": 2021.4, "names": ("Head",), "distance": "",
         "limit": 0.0, "still": (), "threshold": "still.range_mm", "over_s": 3600.0}, []),
    "moves, with gaps": (finding("moves", x1=1.0, y1=2.0) | {"missing": {"y1": 0.05}},
        {"status": "misfit"}, "bad", {"names": ("marker 1",), "distance": ""}, [Code.MISSING]),
}  # fmt: skip


@pytest.mark.parametrize("case", SPECIAL)
def test_special_cases(case: str) -> None:
    facts, y1, word, attributes, caps = SPECIAL[case]
    found = judged(facts, **y1)
    decided = {name: getattr(found.decided_by, name) for name in attributes}
    np.testing.assert_equal(decided, attributes)
    assert found.word == word and [cap.code for cap in found.caps] == caps
    of_another = word == "usable" and not case.endswith((" limit", "one step"))
    assert (found.uncertainty is not None) is (
        of_another or case in ("exchanged", "steps beyond it")
    )
    upper = max(y1.get("frame_upper_mm", FINE.frame_upper_mm), 0.25 if "step" in case else 0.0)
    reference = NAN if word == "bad" or "low pass" in case else 4 * upper
    assert found.reference_for_mm["4"] == pytest.approx(reference, nan_ok=True)


@pytest.mark.parametrize(
    ("value", "word", "limit"),
    [(0.1, "good", 0.1), (0.101, "usable", 0.1), (0.25, "usable", 0.1), (0.251, "bad", 0.25)],
)
def test_a_limit_itself_is_kept(value: float, word: str, limit: float) -> None:
    """It means "up to"; what is stated is the limit that was kept, or not."""
    assert _graded(value, 0.1, 0.25, "mm")[::2] == (word, limit)


def test_without_numbers() -> None:
    """No samples, too few, or gaps that are the reason."""
    none = SeriesNumbers("no valid samples")
    few = replace(FINE, **GAPS)
    gaps = replace(FACTS, missing={"x1": 0.614, "y1": 0.6})
    for series, facts, code in (
        (none, FACTS, Code.NO_SAMPLES),
        (few, FACTS, Code.FEW_SAMPLES),
        (few, gaps, Code.MISSING),
    ):
        found = verdict({"x1": series, "y1": series}, facts, Limits())
        assert (found.word, found.decided_by.code) == ("bad", code)
        assert math.isnan(found.reference_for_mm["10"])
    assert (found.decided_by.series, found.decided_by.value) == ("x1", 0.614)
    assert Code.FEW_SAMPLES not in {cap.code for cap in found.caps}


SPAN = Span(120.0, horizon_s=600.0)


def twin(sigma: float = 0.02, **more: Any) -> Twin:
    models = {
        name: NoiseModel((PowerLaw(0, 2 * (sigma if name == "z2" else 0.01) ** 2 / 120),))
        for name in ("x1", "y1", "z1", "x2", "y2", "z2")
    }
    return Twin("t", 7, models, duration_s=more.pop("duration_s", 70.0), **more)


def assessed(twin: Twin, span: Span = SPAN, n_missing: int = 0) -> Assessment:
    """Simulated, cleaned, and judged with the coefficients it was made of."""
    position = simulate(twin).position_mm
    raw = {f"{axis}{k + 1}": position[k, j] for k in (0, 1) for j, axis in enumerate("xyz")}
    series, outliers = {}, []
    for name, values in all_series(raw, [(1, 2)]):
        found = hampel(values, 120, 3.0, "replace", 0.0)
        series[name] = found.values
        shares = {"share": found.share, "share_of_clean_gaussian_noise": 0.003427}
        counts = {"n_frames": values.size, "n_valid": found.n_valid - n_missing}
        outliers.append({"series": name, **shares, **counts})
    noise = [
        {"series": name, "estimator": "likelihood", "parameter": k, "value": v, "status": "ok"}
        for name, model in twin.models.items()
        for k, v in model.coefficients().items()
    ]
    columns = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")
    # A curve of another estimator, or of another series, is none of x1
    allan = {
        "series": np.array(["x1", "y1", "x1"]),
        "estimator": np.array(["oadev", "oadev", "mdev"]),
    }
    allan |= {k: np.array([1.0, 2.0, 0.5]) for k in columns}
    moves = {k: movement(v, 120.0, 2.0, span.horizon_s) for k, v in all_series(raw, [(1, 2)])}
    findings = [Finding("moves", k, v.size_mm) for k, v in moves.items() if v.moves]
    return assess_recording(
        Inputs(series.items(), twin.labels, noise, allan, outliers, findings),
        span,
        Limits(),
        in_turn,
    )


@pytest.mark.parametrize(("n", "word"), [(120, "good"), (121, "usable")])
def test_one_missing_frame_in_a_hundred_is_the_limit(n: int, word: str) -> None:
    """Of 12,000: counted, as 1 - 0.99 is more than 0.01 in floating point."""
    found = assessed(twin(duration_s=100.0), n_missing=n).verdict
    assert (found.word, found.decided_by.code == Code.MISSING) == (word, word == "usable")


def drifting(mm: float, axis: int = 1, label: str = "Wand2") -> Twin:
    """By so much in its 70 s."""
    rate = [0.0, 0.0, 0.0]
    rate[axis] = mm * 3600 / 70
    return twin(drift_mm_per_h={label: tuple(rate)})


def struck(share: float) -> Twin:
    """Each outlier strikes one of six coordinates; the share is that of the worst."""
    rate = Outliers(6 * share * 120 * 3600, 2.0, "normal")
    return twin(outliers=rate, duration_s=100.0)


@pytest.mark.parametrize(
    ("made", "horizon_s", "word", "code"),
    [
        (struck(0.007), 600.0, "good", None),
        (struck(0.013), 600.0, "usable", Code.OUTLIERS),
        (struck(0.056), 600.0, "bad", Code.OUTLIERS),
        (drifting(0.3), 70.0, "good", None),
        (drifting(0.4), 70.0, "usable", None),
        (drifting(0.9), 70.0, "bad", None),
        (drifting(0.3), 600.0, "usable", Code.UPPER_END),  # nobody knows how it goes on
        (drifting(2.5, 0, "Wand1"), 600.0, "bad", Code.MOVES),
        (twin(duration_s=59.0), 600.0, "usable", Code.DURATION),
        (twin(duration_s=61.0), 600.0, "good", None),
        (Twin("p", 3, published_row("T40", 10), duration_s=600.0), 600.0, "good", None),
        (Twin("p", 3, published_row("Bonita", 10), duration_s=600.0), 600.0, "usable", None),
        (Twin("p", 3, published_row("Bonita", 2), duration_s=600.0), 600.0, "bad", None),
    ],
    ids=range(13),
)  # fmt: skip
def test_twins_by_what_else_they_have(made, horizon_s: float, word: str, code) -> None:
    found = assessed(made, Span(120.0, horizon_s=horizon_s))
    assert found.verdict.word == word
    checks = {c.code for c in (found.verdict.decided_by, *found.verdict.caps)}
    assert code is None or code in checks
    assert math.isfinite(found.series["x1"].drift_mm_per_h) is (made.duration_s >= 60)
    if made.drift_mm_per_h and horizon_s == 70:
        drift = found.series["y2"].drift_mm_per_h * 70 / 3600
        (rate,) = made.drift_mm_per_h.values()
        assert drift == pytest.approx(rate[1] * 70 / 3600, rel=0.01)
        assert found.series["y2"].basis == "measured"
