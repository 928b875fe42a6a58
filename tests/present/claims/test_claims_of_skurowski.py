"""Claims by published numbers that others counted, and by studies made to hold and not to hold."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence
from importlib.resources import files

import numpy as np
import pytest

from mocap_metrology.noise.fit.estimates import S_ESTIMATOR
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.present.claims.claim import (
    DOES_NOT,
    HOLDS,
    UNKNOWN,
    at_least,
    median_error,
    within,
)
from mocap_metrology.present.claims.coefficients import independent
from mocap_metrology.present.claims.study import (
    TYPES,
    Drawn,
    Published,
    Regenerated,
    active_terms,
    model_of,
)
from mocap_metrology.present.claims.table import DECIDED_BY, claim_rows, claims, claims_markdown

BY_ID = {name: claim for name, claim in claims().items() if claim.paper == "S"}


def printed() -> list[dict[str, str]]:
    text = (files("mocap_metrology") / "reference/noise_coefficients_wide.csv").read_text("utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    return [row for row in rows if (row["camera_type"], row["n_cameras"]) != ("Vantage", "10")]


def study(level: Callable[[str, int, str], float]) -> Regenerated:
    """White noise of the given deviation at one frame for (camera type, n, series)."""
    tau = np.geomspace(1 / 120, 5000, 80)
    keys = [(kind, n) for kind, ns in TYPES.items() for n in ns] + [("Vantage", 10)]
    allan = {
        key: {
            "series": np.repeat(np.array(SERIES, dtype=object), tau.size),
            "estimator": np.full(tau.size * len(SERIES), "oadev", dtype=object),
            "tau_s": np.tile(tau, len(SERIES)),
            "adev_mm": np.concatenate([level(*key, s) / np.sqrt(120 * tau) for s in SERIES]),
        }
        for key in keys
    }
    return Regenerated(allan, {}, {})


def words(found: Regenerated, ids: Sequence[str]) -> list[str]:
    return [BY_ID[name].find(found).word for name in ids]


LAWS = [f"S-4.2-law-{kind}" for kind in TYPES]
DROPS = [f"S-4.3-drop-{kind}" for kind in TYPES]


def test_standard_error_law() -> None:
    assert words(study(lambda kind, n, s: 0.1 / np.sqrt(n)), LAWS) == [HOLDS] * 3
    assert words(study(lambda kind, n, s: 0.1 / n), LAWS) == [DOES_NOT] * 3
    exact = BY_ID[LAWS[0]].find(study(lambda kind, n, s: 0.1 * n**-0.75)).value
    assert exact == "exponent 0.75 ± 0.00"


def test_a_law_with_wide_errors_cannot_be_told() -> None:
    """Noise that jumps by e^±1 between subsets: an error of 0.7, and no word for any exponent."""
    jump = {n: np.exp((-1) ** k) for k, n in enumerate(TYPES["T40"])}
    for b in (0.0, 0.5, 1.0):
        found = study(lambda kind, n, s, b=b: 0.1 * jump.get(n, 1.0) * n**-b)
        assert words(found, LAWS[:1]) == [UNKNOWN]
    # two standard errors below 0.25: 1.2^±1 about the law, and about none
    small = {n: 1.1 ** ((-1) ** k) for k, n in enumerate(TYPES["T40"])}
    law = study(lambda kind, n, s: 0.1 * small.get(n, 1.0) / np.sqrt(n))
    flat = study(lambda kind, n, s: 0.1 * small.get(n, 1.0))
    assert words(law, LAWS[:1]) + words(flat, LAWS[:1]) == [HOLDS, DOES_NOT]


def test_independence_needs_precision() -> None:
    """2000 draws of seven subsets: with scatter of 0.1 what falls as n^-1/2 is called independent
    in less than 1 %, what is independent in 85 % and more; with 0.5 hardly anything is told. What
    is independent is said to depend on n in 5 % (3.5 to 6.5)."""
    rng = np.random.default_rng(3)
    n = np.array(TYPES["T40"])

    def shares(b: float, scatter: float) -> list[float]:
        told = [independent(n, n**b * np.exp(scatter * rng.normal(size=7))) for _ in range(2000)]
        return [told.count(word) / 2000 for word in (HOLDS, DOES_NOT, UNKNOWN)]

    assert shares(-0.5, 0.1)[0] < 0.01 and shares(-0.5, 0.1)[1] > 0.95
    even = shares(0.0, 0.1)
    assert even[0] > 0.85 and 0.035 < even[1] < 0.065
    assert shares(-0.5, 0.5)[0] < 0.05 and shares(-0.5, 0.5)[2] > 0.6


def coefficients(value: Callable[[str, int], float | None]) -> Regenerated:
    """h_-1 and h_1 alike for (camera type, n), the same in all series; None is not there."""
    rows = {
        (kind, n): [
            {"series": s, "estimator": S_ESTIMATOR, "parameter": name, "value": value(kind, n)}
            for s in SERIES
            for name in ("h_-1", "h_1")
        ]
        for kind, ns in TYPES.items()
        for n in ns
    }
    return Regenerated({}, rows, {})


def test_constant_noise_is_constant_and_there() -> None:
    claim = BY_ID["S-4.5-order-flicker-blue"]
    assert claim.find(coefficients(lambda kind, n: 1e-10)).word == HOLDS
    falls = claim.find(coefficients(lambda kind, n: 1e-9 * n**-2.0))
    assert falls.word == DOES_NOT and "a factor of 25 from fewest" in falls.value  # (10/2)^2
    some = claim.find(coefficients(lambda kind, n: None if n == 4 else 1e-10))
    assert some.word == DOES_NOT and "18 of 126 zero" in some.value


def test_covariance_over_the_cameras_a_type_has() -> None:
    """A change of 0.26 of sigma_1 sigma_2 from 4 to most cameras is too much, 0.24 is not; Vantage
    has nine, so its change is over ln(9/4)."""

    def draws(change: float) -> Drawn:
        return Drawn(
            {
                (kind, n): {
                    "sigma_1_mm": 1.0,
                    "sigma_2_mm": 1.0,
                    "sigma_12_mm2": change * np.log(n / 4) / np.log(ns[-1] / 4),
                }
                for kind, ns in TYPES.items()
                for n in ns
            }
        )

    claim = BY_ID["S-4.2-covariance"]
    assert (claim.find(draws(0.24)).word, claim.find(draws(0.26)).word) == (HOLDS, DOES_NOT)
    assert "Vantage: +0.24 of 1" in claim.find(draws(0.24)).value


def test_drops_are_steps_beyond_the_law() -> None:
    at = {"T40": 3, "Bonita": 5, "Vantage": 4}
    smooth = study(lambda kind, n, s: 0.1 / np.sqrt(n))
    assert words(smooth, DROPS) == [DOES_NOT] * 3
    stepped = study(lambda kind, n, s: (0.07 if n >= at[kind] else 0.1) / np.sqrt(n))
    assert words(stepped, DROPS) == [HOLDS] * 3
    assert (
        BY_ID["S-4.3-drop-T40"]
        .find(stepped)
        .value.startswith(
            "up to 0.1 s -30 ± 0 % at 3, steepest at 3 (-30 %); 1 to 100 s -30 ± 0 % at 3"
        )
    )


def test_distance_and_camera_types() -> None:
    factor = {"T40": 1.0, "Vantage": 2.0, "Bonita": 5.0}
    found = study(lambda kind, n, s: 0.1 * factor[kind] * (1.4 if s == "L" else 1.0))
    ids = ["S-4.3-distance-short", "S-4.3-distance-long", "S-4.4-Bonita", "S-4.4-Vantage"]
    assert words(found, ids) == [HOLDS, DOES_NOT, HOLDS, HOLDS]
    quiet = study(lambda kind, n, s: 0.1 / factor[kind])
    assert words(quiet, ids) == [DOES_NOT, HOLDS, DOES_NOT, DOES_NOT]


def test_tenth_camera() -> None:
    ids = ["S-3.5-tenth", "S-3.5-extents"]
    extent = {"x1": 1.2, "x2": 2.0, "L": 1.5}
    failing = study(lambda kind, n, s: 0.1 * (extent.get(s, 1.0) if n == 10 else 1.0))
    assert words(failing, ids) == [HOLDS, HOLDS]
    sound = study(lambda kind, n, s: 0.1 / np.sqrt(n))
    assert words(sound, ids) == [DOES_NOT, DOES_NOT]


def test_the_line_beside_the_noise_of_its_time() -> None:
    """50 um at 14.4 Hz in white noise of 0.1 mm: A^2 (sin^2 x / x)^2 is 0.525 A^2 at its maximum,
    0.371 periods or 3.1 frames, against sigma^2 / 3.1."""
    line = [
        {"series": s, "estimator": "likelihood", "parameter": name, "value": value}
        for s in SERIES
        for name, value in (("f_0", 14.4), ("A_s", 0.05))
    ]
    white = study(lambda kind, n, s: 0.1)
    none = {(kind, n): [] for kind, ns in TYPES.items() for n in ns}
    most = f"{100 * 0.525 * 0.05**2 / (0.1**2 / (0.371 / 14.4 * 120)):.0f} % at most"
    found = BY_ID["S-4.6-negligible"].find(Regenerated(white.allan, none | {("T40", 10): line}, {}))
    assert (found.word, found.value) == (HOLDS, f"a tenth or more in 7 of 98 series, {most}")
    everywhere = Regenerated(white.allan, dict.fromkeys(none, line), {})
    assert BY_ID["S-4.6-negligible"].find(everywhere).word == DOES_NOT


def test_t40_drops_at_three_cameras_at_long_times() -> None:
    """By the printed table: y is noisier up to 0.1 s, everything quieter from 1 to 100 s."""
    found = BY_ID["S-4.3-drop-T40"].find(Published())
    assert re.search(r"1 to 100 s -20 ± \d+ % at 3, steepest at 3", found.value)
    assert found.word == UNKNOWN  # the seven series differ too much to tell 20 % from 10 %


def test_limits_of_a_search_are_no_estimates() -> None:
    """What ended at a limit is not in the median; where most did, the order is undecided."""
    claim = BY_ID["S-4.5-order-flicker-blue"]
    free = coefficients(lambda kind, n: 1e-10)
    ended = {
        key: [row | {"status": "at_bound" if key[1] in (2, 3, 4, 5, 6) else "ok"} for row in rows]
        for key, rows in free.noise.items()
    }
    found = claim.find(Regenerated({}, ended, {}))
    assert found.word == UNKNOWN and "90 of 126 at the limit of the search" in found.value
    few = {k: v if k[1] in (2, 3) else free.noise[k] for k, v in ended.items()}
    assert "36 of 126 zero" in claim.find(Regenerated({}, few, {})).value
    terms = [
        {"series": "x1", "estimator": S_ESTIMATOR, "parameter": p, "value": v, "status": status}
        for p, v, status in (
            ("q_c1", 0.1, "ok"), ("T_c1", 0.2, "ok"), ("q_c2", 0.1, "ok"), ("T_c2", 3e3, "at_bound")
        )
    ]  # fmt: skip
    one = Regenerated({}, {("T40", 2): terms}, {})
    assert active_terms(one, ("T40", 2), "x1") == [(0.1, 0.2)]
    assert len(model_of(one, ("T40", 2), "x1").components) == 2  # the curve is that of the fit


def test_a_hairline_is_no_word() -> None:
    """Counts by their binomial interval, medians by two standard errors."""
    assert at_least([True] * 42, 0.9) == HOLDS
    assert at_least([True] * 78 + [False] * 22, 0.76) == UNKNOWN
    assert at_least([True] * 90 + [False] * 10, 0.76) == HOLDS
    assert at_least([True] * 60 + [False] * 40, 0.76) == DOES_NOT
    assert within(2.02, 0.1, 0.5, 2.0) == UNKNOWN
    assert (within(1.8, 0.1, 0.5, 2.0), within(2.4, 0.1, 0.5, 2.0)) == (HOLDS, DOES_NOT)
    rng = np.random.default_rng(11)
    values = rng.normal(size=(2000, 21))
    near = np.abs(np.median(values, axis=1)) < [median_error(v) for v in values]
    assert 0.90 < near.mean() < 0.98  # two standard errors hold the true median


def test_published_numbers_as_counted_by_hand() -> None:
    """Against counts of the printed table itself, without the code under test."""
    rows = printed()
    near = [row for row in rows if row["f_0"] and 13 <= float(row["f_0"]) <= 16]
    vertical = sum(row["series"][0] == "z" for row in near)
    value = BY_ID["S-4.6-vertical"].find(Published()).value
    assert f"z: {vertical} series" in value and len(near) == 8  # as reference/README counts them
    coordinates = [row for row in rows if row["series"] != "L"]
    middle = np.median([float(row["h_-2"]) for row in coordinates])
    assert f"{middle:.1e}" == "1.0e-07"
    assert "h_-2 1.0×10⁻⁷ mm^2 Hz" in BY_ID["S-4.5-order-walk"].find(Published()).value
    assert "at most 1.2 %" in BY_ID["S-4.5-violet"].find(Published()).value


def test_what_the_published_tables_say_of_the_text() -> None:
    found = {name: BY_ID[name].find(Published()).word for name in BY_ID}
    assert found["S-3.5-tenth"] == found["S-4.5-violet"] == found["S-4.6-longer-lower"] == HOLDS
    # the appendix contradicts the text
    assert found["S-4.5-order-walk"] == found["S-4.5-order-flicker-blue"] == DOES_NOT
    assert found["S-4.2-covariance"] == found["S-4.6-line-Vantage"] == UNKNOWN


def test_rows_without_recordings_cannot_be_told() -> None:
    rows = claim_rows(None, None, ("", ""))
    assert [row["id"] for row in rows] == list(claims())
    assert {claim.function for claim in claims().values()} == set(DECIDED_BY.values())
    assert {row["regenerated_word"] for row in rows} == {UNKNOWN}
    assert all(row["criterion"] and row["statistic"] and row["section"] for row in rows)
    short = study(lambda kind, n, s: 0.1)
    found = claim_rows(short, None, ("twin", ""))
    assert {row["regenerated_word"] for row in found} == {HOLDS, DOES_NOT, UNKNOWN}
    assert f"Of {len(rows)} claims" in claims_markdown(found)


@pytest.mark.parametrize("kept", [["T40"], ["Vantage", "Bonita"], []])
def test_parts_of_the_group_tell_what_they_can(kept: list[str]) -> None:
    """A sheet with some of the recordings: no claim fails, those of the others are undecided."""
    full = study(lambda kind, n, s: 0.1 / np.sqrt(n))
    part = Regenerated({k: v for k, v in full.allan.items() if k[0] in kept and k[1] > 3}, {}, {})
    rows = {row["id"]: row for row in claim_rows(part, None, ("twin", ""))}
    assert rows["S-4.2-law-T40"]["regenerated_word"] == UNKNOWN
    assert rows["S-4.4-Vantage"]["regenerated_word"] == UNKNOWN
    known = "Vantage" in kept
    assert (rows["S-4.4-Bonita"]["regenerated_word"] != UNKNOWN) == known
