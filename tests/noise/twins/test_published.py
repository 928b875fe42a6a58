"""Published numbers: against the reference tables, and against each other."""

import csv

import pytest

from mocap_metrology.common.errors import Refusal
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
