"""Claims of S by published numbers that others counted, and by studies made to hold or not."""

import csv
import math
import re
from collections.abc import Callable, Mapping
from importlib.resources import files

import numpy as np
import pytest

from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.papers.claims import decide
from mocap_metrology.papers.claims.decide import DOES_NOT, HOLDS, UNKNOWN
from mocap_metrology.papers.claims.study import (
    TYPES,
    Published,
    Regenerated,
    active_terms,
    model_of,
)
from mocap_metrology.papers.claims.table import claims, decisions
from mocap_metrology.papers.shock import shock_effect
from mocap_metrology.present.claims import claim_rows, claims_markdown

KEYS = [(kind, n) for kind, ns in TYPES.items() for n in ns]
TAU = np.geomspace(1 / 120, 5000, 80)
BEST, LINES = "annealing-ant-colony", "likelihood"


def of_levels(level: Callable[[str, int, str], float], noise: Mapping | None = None) -> Regenerated:
    """White noise with this Allan deviation at one frame for (camera type, n, series)."""
    columns = {
        "series": np.repeat(np.array(SERIES, dtype=object), TAU.size),
        "estimator": np.full(TAU.size * len(SERIES), "oadev", dtype=object),
        "tau_s": np.tile(TAU, len(SERIES)),
    }
    adev = 1 / np.sqrt(120 * TAU)
    allan = {
        key: columns | {"adev_mm": np.concatenate([level(*key, s) * adev for s in SERIES])}
        for key in [*KEYS, ("Vantage", 10)]
    }
    return Regenerated(allan, noise or {}, {})


def rows(model: Mapping[str, float], *estimators: str, series=SERIES, ended=()) -> list[dict]:
    """Rows of noise.csv; those of `ended` are at a limit of the search."""
    return [
        {"series": s, "estimator": e, "parameter": k, "value": v,
         "status": "at_bound" if k in ended else "ok"}
        for s in series for e in estimators for k, v in model.items()
    ]  # fmt: skip


def of_models(model: Callable[[str, int], Mapping[str, float]], *estimators: str) -> Regenerated:
    return of_levels(
        lambda kind, n, s: 0.1, {k: rows(model(*k), *estimators or (BEST,)) for k in KEYS}
    )


def found(name: str, study: object) -> tuple[str, str]:
    """Word and text of a claim."""
    claim = claims()[name]
    value, word = claim.find(study)
    return word, "".join(p if isinstance(p, str) else f"{p.value:.3g}" for p in value)


AT = {"T40": 3, "Bonita": 5, "Vantage": 4}
NOISE = {"T40": 1.0, "Vantage": 2.0, "Bonita": 5.0}
EXTENT = {"x1": 1.2, "x2": 2.0, "L": 1.5}
LAW = of_levels(lambda kind, n, s: 0.1 / math.sqrt(n))
OF_LAW = [f"S-4.2-law-{kind}" for kind in TYPES]
DROPS = [f"S-4.3-drop-{kind}" for kind in TYPES]
TYPES_COMPARED = ["S-4.3-distance-short", "S-4.3-distance-long", "S-4.4-Bonita", "S-4.4-Vantage"]
CASES = [
    (OF_LAW, LAW, [HOLDS] * 3),
    (OF_LAW, of_levels(lambda kind, n, s: 0.1 / n), [DOES_NOT] * 3),
    # jumps of e^±1 between subsets: an error of 0.7; of 1.1^±1: two errors below 0.25
    (OF_LAW[:1], of_levels(lambda k, n, s: math.e ** (-1) ** TYPES["T40"].index(n)
                           if k == "T40" else 1.0), [UNKNOWN]),
    (OF_LAW[:1], of_levels(lambda k, n, s: 1.1 ** (-1) ** TYPES["T40"].index(n) / n**0.5
                           if k == "T40" else 1.0), [HOLDS]),
    (DROPS, LAW, [DOES_NOT] * 3),
    (DROPS, of_levels(lambda k, n, s: (0.07 if n >= AT[k] else 0.1) / math.sqrt(n)), [HOLDS] * 3),
    (["S-4.3-gradual"], LAW, [HOLDS]),
    (["S-4.3-gradual"], of_levels(lambda k, n, s: 0.1 * n), [DOES_NOT]),
    (TYPES_COMPARED, of_levels(lambda k, n, s: NOISE[k] * (1.4 if s == "L" else 1.0)),
     [HOLDS, DOES_NOT, HOLDS, HOLDS]),
    (TYPES_COMPARED, of_levels(lambda k, n, s: 0.1 / NOISE[k]), [DOES_NOT, HOLDS, DOES_NOT,
                                                                DOES_NOT]),
    (TYPES_COMPARED[2:], of_levels(lambda k, n, s: NOISE[k] ** 0.2), [DOES_NOT, HOLDS]),
    (["S-3.5-tenth", "S-3.5-extents"],
     of_levels(lambda k, n, s: EXTENT.get(s, 1.0) if n == 10 else 1.0), [HOLDS, HOLDS]),
    (["S-3.5-tenth", "S-3.5-extents"], LAW, [DOES_NOT, DOES_NOT]),
    (["S-4.5-order-flicker-blue"], of_models(lambda k, n: {"h_-1": 1e-10, "h_1": 1e-10}), [HOLDS]),
    (["S-4.5-order-flicker-blue"],
     of_models(lambda k, n: {"h_-1": 1e-9 * n**-2.0, "h_1": 1e-10}), [DOES_NOT]),
    (["S-4.5-white-law", "S-4.5-walk-law"],
     of_models(lambda k, n: {"h_0": 1e-5 / n, "h_-2": 1e-5 * n}), [HOLDS, DOES_NOT]),
    (["S-4.5-order-white", "S-4.5-order-walk"],
     of_models(lambda k, n: {"h_0": 3e-5, "h_-2": 2e-4}), [HOLDS, DOES_NOT]),
    (["S-4.3-walk", "S-5-main"],
     of_models(lambda k, n: {"h_0": 1e-6, "h_-2": 4e-10}), [HOLDS, HOLDS]),
    (["S-4.3-walk", "S-5-main"],
     of_models(lambda k, n: {"h_0": 1e-6, "h_-2": 4e-14, "h_-1": 1e-5}), [DOES_NOT, DOES_NOT]),
    (["S-5-long-term"], of_models(lambda k, n: {"q_c1": 1e-3, "T_c1": 300.0}), [HOLDS]),
    (["S-5-long-term"], of_models(lambda k, n: {"q_c1": 1e-2, "T_c1": 300.0}), [DOES_NOT]),
    (["S-5-low-pass"], of_models(lambda k, n: {"h_0": 1e-6, "h_-2": 4e-10}), [HOLDS]),
    (["S-5-low-pass"], of_models(lambda k, n: {"h_-2": 1e-6}), [DOES_NOT]),
]  # fmt: skip


@pytest.mark.parametrize(("names", "study", "words"), CASES)
def test_studies_made_to_hold_or_not(names, study, words) -> None:
    assert [found(name, study)[0] for name in names] == words


LINE = {"h_0": 1e-6, "h_-2": 4e-10, "A_s": 1e-3, "f_0": 14.4}
TEXTS = [
    (OF_LAW[0], of_levels(lambda k, n, s: n**-0.75), "exponent 0.75 ± 0.00"),
    (DROPS[0], CASES[5][1], "up to 0.1 s -30 ± 0 % at 3, steepest at 3 (-30 %); 1 to 100 s -30 ±"),
    ("S-4.3-gradual", LAW, "one frame: 126 of 126 (100 %); 1 s: 126 of 126"),
    ("S-3.5-tenth", CASES[11][1], "x1: 1.20 times, x2: 2.00 times, L: 1.50 times"),
    ("S-4.4-Bonita", CASES[8][1], "L: 2.5 times (2.50 to 2.5); x1: 2.5 times (2.50 to 2.5)"),
    # (10 / 2)^2, and (9 / 2)^2 of the third type
    ("S-4.5-order-flicker-blue", CASES[14][1], "changes by a factor of 25 from fewest to most"),
    ("S-4.5-white-law", CASES[15][1], "exponent of h_0: T40: 1.00 ± 0.00 (1.0 to 1.0); Bonita"),
    ("S-4.5-general", CASES[15][1], "h_-2 +1.00 ± 0.00, h_-1 +nan ± inf, h_0 -1.00 ± 0.00"),
    ("S-5-long-term", CASES[19][1], "147 components, q_c 0.001 mm/s^0.5 (5 to 95 %: 0.001 to"),
    # a Butterworth of 6 Hz, both ways, retains 3 pi 6 / (8 sqrt 2) = 5.0 Hz: 4.0 of 59 above 1 Hz
    ("S-5-low-pass", of_models(lambda k, n: {"h_0": 1e-6}), "retains 7 % above 1 Hz, 100.0 % belo"),
    # a notch of 1 of 59 Hz
    ("S-5-band-stop", of_models(lambda k, n: LINE, BEST, LINES), "1.7 % of the noise above 1 Hz"),
    ("S-4.6-line-T40", of_models(lambda k, n: LINE, BEST, LINES), "in 7 of 7 (100 %) reconstruct"),
    ("S-4.6-vertical", of_models(lambda k, n: LINE, BEST, LINES), "x: 14 series, 0.001, y: 14 "),
    # A^2 (sin^2 x / x)^2 is 0.525 A^2 at 0.371 periods, against sigma^2 / 3.1 frames
    ("S-4.6-negligible", of_models(lambda k, n: LINE | {"A_s": 0.05}, BEST, LINES),
     f"{100 * 0.525 * 0.05**2 / (0.1**2 / (0.371 / 14.4 * 120)):.0f} % at most"),
    # 3 f_h h_2 / (2 pi tau)^2 of 0.1^2, f_h = 60 Hz
    ("S-4.5-violet", of_models(lambda k, n: {"h_2": 1e-9}),
     f"{100 * 3 * 60 * 1e-9 / (2 * np.pi / 120) ** 2 / 0.1**2:.1f} % of AVAR at one frame"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "study", "text"), TEXTS)
def test_statistics_in_closed_form(name, study, text) -> None:
    assert text in found(name, study)[1]


def test_what_ended_at_a_limit_is_no_estimate() -> None:
    model = {"h_-1": 1e-10, "h_1": 1e-10}
    for most, text in ((6, "90 of 126 at the limit of the search"), (3, "36 of 126 zero")):
        noise = {k: rows(model, BEST, ended=model if k[1] <= most else ()) for k in KEYS}
        word, shown = found("S-4.5-order-flicker-blue", of_levels(lambda *_: 0.1, noise))
        assert text in shown and word == (UNKNOWN if most == 6 else DOES_NOT)
    terms = {"q_c1": 0.1, "T_c1": 0.2, "q_c2": 0.1, "T_c2": 3e3}
    one = Regenerated({}, {("T40", 2): rows(terms, BEST, series=["x1"], ended=["T_c2"])}, {})
    assert active_terms(one, ("T40", 2), "x1") == [(0.1, 0.2)]
    assert len(model_of(one, ("T40", 2), "x1").components) == 2  # the curve is that of the fit


def shaken(amplitude: float, after: float = 1.0) -> dict[str, np.ndarray]:
    """Fifteen minutes of six coordinates and L: a swing in the middle, noise times `after` then."""
    rng, t = np.random.default_rng(1), np.arange(54000) / 60 - 450
    swing = np.where(t >= 0, amplitude * np.exp(-np.maximum(t, 0) / 4) * np.sin(2 * np.pi * t), 0)
    level = np.where(t >= 0, after, 1.0) * 0.01
    series = {s: level * rng.standard_normal(t.size) + swing for s in SERIES[:6]}
    return series | {"L": 160 + 1.4 * level * rng.standard_normal(t.size) + 0.7 * swing}


@pytest.mark.parametrize(("after", "word"), [(1.0, HOLDS), (1.15, DOES_NOT), (1.03, UNKNOWN)])
def test_a_shock_and_its_sides(after: float, word: str) -> None:
    shock = shock_effect(shaken(0.5, after), 60.0)
    study = Regenerated({}, {}, {}, shock)
    assert [found(name, study)[0] for name in ("S-3.5-crump", "S-3.5-sides")] == [HOLDS, word]
    assert 0.05 <= shock.tau_s <= 2.0  # a swing of 1 Hz


def test_what_remains_after_a_repair() -> None:
    slow = {"h_0": 1e-6, "q_c1": 1e-3, "T_c1": 300.0, "A_s": 1e-3, "f_0": 14.4}
    fast = slow | {"q_c2": 0.01, "T_c2": 0.05}
    for models, word in (((slow, {"h_0": 1e-6}), HOLDS), ((slow, fast), DOES_NOT),
                         (({"h_0": 1.0},), DOES_NOT)):  # fmt: skip
        named = {str(k): rows(m, LINES, series=["z1"]) for k, m in enumerate(models)}
        assert found("S-B-repair", Regenerated({}, {}, {}, None, named))[0] == word


def test_weighted_against_ordinary_least_squares() -> None:
    """A fit that follows the curve everywhere, and one that is right at the longest tau only."""
    truth = NoiseModel.from_coefficients({"h_-2": 4e-10, "h_0": 1e-6})
    adev = np.sqrt(truth.avar(120 * TAU, 120, "continuous"))
    near, far = {"h_-2": 4.2e-10, "h_0": 1.01e-6}, {"h_-2": 4e-10, "h_0": 3e-6}
    for weighted, ordinary, word in ((near, far, HOLDS), (far, near, DOES_NOT)):
        fits = rows(weighted, BEST) + rows(ordinary, "levenberg-marquardt")
        study = of_levels(lambda *_: 1.0, dict.fromkeys(KEYS, fits))
        allan = {k: v | {"adev_mm": np.tile(adev, len(SERIES))} for k, v in study.allan.items()}
        assert found("S-3.4-weighted", Regenerated(allan, study.noise, {}))[0] == word


def test_a_result_near_its_limit_is_undecided() -> None:
    """Counts by their binomial interval, medians by two standard errors."""
    for hits, total, least, word in ((42, 42, 0.9, HOLDS), (78, 100, 0.76, UNKNOWN),
                                     (90, 100, 0.76, HOLDS), (60, 100, 0.76, DOES_NOT),
                                     (0, 9, 0.5, DOES_NOT), (0, 0, 0.5, UNKNOWN)):  # fmt: skip
        assert decide.at_least([k < hits for k in range(total)], least) == word
    for value, word in ((2.02, UNKNOWN), (1.8, HOLDS), (2.4, DOES_NOT), (0.3, DOES_NOT)):
        assert decide.within(value, 0.1, 0.5, 2.0) == word
    values = np.random.default_rng(11).normal(size=(2000, 21))
    near = np.abs(np.median(values, axis=1)) < [decide.median_error(v) for v in values]
    assert 0.90 < near.mean() < 0.98  # two standard errors contain the true median


def test_published_numbers_as_counted_by_hand() -> None:
    """Against counts of the printed table itself, without the code under test."""
    text = (files("mocap_metrology") / "reference/noise_coefficients_wide.csv").read_text("utf-8")
    printed = [r for r in csv.DictReader(text.splitlines())
               if (r["camera_type"], r["n_cameras"]) != ("Vantage", "10")]  # fmt: skip
    near = [r for r in printed if r["f_0"] and 13 <= float(r["f_0"]) <= 16]
    assert len(near) == 8  # as reference/README counts them
    vertical = sum(r["series"][0] == "z" for r in near)
    assert f"z: {vertical} series" in found("S-4.6-vertical", Published())[1]
    middle = np.median([float(r["h_-2"]) for r in printed if r["series"] != "L"])
    assert f"h_-2 {middle:.3g} mm^2 Hz" in found("S-4.5-order-walk", Published())[1]
    assert "at most 1.2 %" in found("S-4.5-violet", Published())[1]
    drop = found("S-4.3-drop-T40", Published())  # the seven series differ too much
    assert drop[0] == UNKNOWN
    assert re.search(r"1 to 100 s -20 ± \d+ % at 3, steepest at 3", drop[1])
    for name, word in (("S-3.5-tenth", HOLDS), ("S-4.5-violet", HOLDS),
                       ("S-4.6-line-T40", DOES_NOT),
                       ("S-4.6-longer-lower", HOLDS), ("S-4.5-order-walk", DOES_NOT),
                       ("S-4.2-means", HOLDS), ("S-4.2-sigma-C", HOLDS)):  # fmt: skip
        assert found(name, Published())[0] == word, name


def test_the_table_has_every_claim() -> None:
    rows_ = claim_rows(decisions(None, None, ("", "")))
    assert [row["id"] for row in rows_] == list(claims())
    assert {claim.rule for claim in claims().values()} == set(decide.RULES)
    assert {row["regenerated_word"] for row in rows_} == {UNKNOWN}
    assert all(row["criterion"] and row["statistic"] and row["section"] for row in rows_)
    by_id = {row["id"]: row for row in claim_rows(decisions(LAW, None, ("twin", "")))}
    assert by_id[OF_LAW[0]]["source"] == "twin" and by_id["J-IV-full"]["source"] == ""
    assert by_id["S-4.2-chi-squared"]["published"] == "S reports no p-values"
    text = claims_markdown(list(by_id.values()))
    assert f"Of {len(rows_)} claims, published: " in text
    assert "holds: exponent 0.50 ± 0.00" in text
    part = Regenerated({k: v for k, v in LAW.allan.items() if k[0] != "T40"}, {}, {})
    assert found(OF_LAW[0], part) == (UNKNOWN, "no recording T40 with 2 cameras")
    assert found("S-4.4-Bonita", part)[0] != UNKNOWN
