"""Published numbers: against the reference tables, and against each other."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.model.synthesis import clipped_bands, coherence
from mocap_metrology.noise.twins.published import (
    COEFFICIENTS,
    SERIES,
    printed_row,
    published_gaussian,
    published_keys,
    published_notes,
    published_row,
    published_subsets,
)

RATE = 120.0
NINE_HOURS = 9 * 3600 * 120


def test_every_printed_coefficient_is_there(reference):
    with (reference / "noise_coefficients.csv").open(encoding="utf-8") as stream:
        lines = list(csv.DictReader(stream))
    assert len(lines) == 1862
    for line in lines:
        row = printed_row(line["camera_type"], int(line["n_cameras"]))
        assert row[line["series"]][line["parameter"]] == float(line["value"])
    held = sum(len(c) for key in published_keys() for c in printed_row(*key).values())
    assert held == 1862


def test_the_22_rows_are_those_of_table_3():
    counts = {"T40": [2, 3, 4, 5, 6, 8, 10], "Bonita": [2, 3, 4, 5, 6, 8, 10]}
    counts["Vantage"] = [2, 3, 4, 5, 6, 8, 9, 10]
    keys = [(kind, n) for kind, numbers in counts.items() for n in numbers]
    assert sorted(published_keys()) == sorted(keys)
    subsets = published_subsets()
    assert sorted(subsets) == sorted(keys)
    for (kind, n), ids in subsets.items():
        assert len(set(ids)) == n
        smaller = max((k for t, k in subsets if t == kind and k < n), default=None)
        assert smaller is None or ids[:smaller] == subsets[kind, smaller]
    assert subsets["T40", 2] == (21, 26)


def test_only_what_cannot_be_used_is_changed():
    changed = []
    for key in published_keys():
        models, printed = published_row(*key), printed_row(*key)
        assert tuple(models) == SERIES
        for series in SERIES:
            used, given = models[series].coefficients(), printed[series]
            assert set(given) <= set(COEFFICIENTS)
            changed += [(*key, series, name) for name in given if used.get(name) != given[name]]
    tones = [("T40", n, "L") for n in (6, 5, 4, 3, 2)] + [("T40", n, "z1") for n in (4, 3)]
    expected = [(*tone, name) for tone in tones for name in ("A_s", "f_0")]
    assert sorted(changed) == sorted([*expected, ("Bonita", 2, "y1", "q_c2")])
    assert published_row("Bonita", 2)["y1"].coefficients()["q_c2"] == 3.84e-02
    # each change is said
    assert sum("omitted" in note for key in published_keys() for note in published_notes(*key)) == 7
    assert any("3084e-02" in note for note in published_notes("Bonita", 2))
    assert published_notes("T40", 10) == []


def test_table_4_fits_together():
    for kind in ("T40", "Bonita", "Vantage", "All"):
        row = published_gaussian(kind)
        s1, s2, rho = row["sigma_1_mm"], row["sigma_2_mm"], row["rho_12"]
        difference = math.sqrt(s1**2 + s2**2 - 2 * rho * s1 * s2)
        assert row["sigma_C_mm"] == pytest.approx(difference, abs=1e-4)
        assert row["mu_e_mm"] == pytest.approx(row["mu_1_mm"] - row["mu_2_mm"], abs=1.5e-4)
        assert 0 < row["mu_L_mm"] - row["mu_e_mm"] < 0.005


def test_coherence_of_x1_and_x2_is_possible_in_18_of_22_rows():
    f = np.geomspace(1 / 32400, 60, 5000)
    beyond = {}
    for key in published_keys():
        models = published_row(*key)
        bands = clipped_bands(models, 120.0, NINE_HOURS)
        if bands:
            beyond[key] = bands
        inside = np.ones(f.size, bool)
        for low, high in bands:
            inside &= (f < low / 1.01) | (f > high * 1.01)
        assert np.all(np.abs(coherence(models, f, RATE)[inside]) <= 1)
    assert set(beyond) == {("Bonita", 3), ("Bonita", 5), ("Bonita", 10), ("Vantage", 8)}
    (low, high), *more = beyond.pop(("Bonita", 5))
    assert not more and low == pytest.approx(5.8, abs=0.1) and high == pytest.approx(60)
    # the others only at periods of hours: 9 h is 3.1e-5 Hz
    for bands in beyond.values():
        assert len(bands) == 1 and bands[0][1] < 1.1e-4


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: published_row("T40", 7), "expected T40 with [2, 3, 4, 5, 6, 8, 10] cameras"),
        (lambda: published_row("T41", 2), "expected T40, Bonita or Vantage"),
        (lambda: published_gaussian("all"), "expected T40, Bonita, Vantage or All"),
    ],
)
def test_what_was_not_published_is_refused(call, words):
    with pytest.raises(Refusal, match=r"^[^\n]*$") as refusal:
        call()
    assert words in str(refusal.value)
