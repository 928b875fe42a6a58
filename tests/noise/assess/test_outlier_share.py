"""Outliers of clean noise in short recordings are chance, and no reason for a verdict."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.common.hampel import hampel, white_level_kept
from mocap_metrology.noise.assess.recording import excess_outliers
from mocap_metrology.present.verdict.words import reference_sentence


def excess(n: int, share: float, n_outliers: int) -> float:
    row = {"series": "x1", "n_valid": n, "share": n_outliers / n}
    return excess_outliers([row | {"share_of_clean_gaussian_noise": share}])["x1"]


def test_thirty_frames_of_clean_noise_are_not_bad() -> None:
    """Six coordinates of 0.3 s: 5 % of outliers (`usable_outliers`) in 2 of 300 recordings at most;
    the plain share is beyond it in 31 %."""
    rng = np.random.default_rng(1)
    clean, _ = white_level_kept(3.0, 100)
    bad = plain = 0
    for _ in range(300):
        found = [int(hampel(rng.standard_normal(30), 100).outlier.sum()) for _ in range(6)]
        bad += max(excess(30, clean, k) for k in found) > 0.05
        plain += max(found) / 30 - clean > 0.05
    assert bad <= 6
    assert plain > 60


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_of_long_recordings_the_share_is_as_counted(share: float) -> None:
    n = 1_000_000
    assert excess(n, 0.0034, round(share * n)) == pytest.approx(share - 0.0034, abs=0.0016)
    assert excess(n, 0.0034, 0) == 0.0


def test_without_a_number_it_is_no_reference() -> None:
    for nothing in (None, math.nan):
        found = {"reference_for_mm": {"4": nothing, "10": nothing}}
        assert reference_sentence(found) == "Not suitable as a reference."
