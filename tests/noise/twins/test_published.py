"""Published numbers: against the reference tables, and against each other."""

import csv

import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.twins.published import (
    printed_row,
    published_gaussian,
    published_keys,
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
