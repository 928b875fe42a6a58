"""The table of white levels: numbers of the rows it is made of, and the counts said of it."""

from __future__ import annotations

import pytest
from noise_data import group

from mocap_metrology.noise.twins.published import printed_row, published_keys
from mocap_metrology.present.skurowski.appendix import TABLES, table_a
from mocap_metrology.present.skurowski.appendix_text import summary, white_levels


@pytest.fixture(scope="module")
def rows():
    sheet, noise, expected, crlb = group()
    made = []
    for kind in TABLES:
        bounds = {(n, series): found for (k, n, series), found in crlb.items() if k == kind}
        made += table_a(kind, sheet, noise, expected, bounds)
    return made


def test_every_published_white_level_once(rows):
    found = {(r["camera_type"], r["n_cameras"], r["series"]): r for r in white_levels(rows)}
    assert len(found) == 154
    for kind, n in published_keys():
        for series, printed in printed_row(kind, n).items():
            assert found[kind, n, series]["published"] == printed["h_0"]


def test_percentages_and_counts(rows):
    levels = white_levels(rows)
    for row in levels:
        assert row["likelihood"] == pytest.approx(
            row["published"] * (1 + row["likelihood_percent"] / 100)
        )
        assert row["regenerated"] == pytest.approx(
            row["expected"] * (1 + row["regenerated_percent"] / 100)
        )
    far = sum(abs(row["expected_percent"]) > 5 for row in levels)
    assert f"Of 154 series, expected deviates by more than 5 % in {far}," in summary(levels)
    odd = [dict(levels[0], likelihood_percent=31.0, likelihood_allowed_percent=30.0)]
    assert summary(odd).endswith("in 1 (T40-10 x1).")
    nothing = [dict(levels[0], likelihood_percent=None)]
    assert "in 1 (T40-10 x1)" in summary(nothing)
