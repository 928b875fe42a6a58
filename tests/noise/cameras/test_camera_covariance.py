"""Covariance of fast noise against Allan variances of sums and differences."""

import numpy as np
import pytest

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.cameras.covariance import block_sums, covariance_rows


def series(n: int = 20_000) -> np.ndarray:
    rng = np.random.default_rng(6)
    mixed = np.array([[1.0, 0.0, 0.0], [0.5, 0.8, 0.0], [-0.3, 0.2, 2.0]]) @ rng.normal(size=(3, n))
    return mixed + 0.02 * np.cumsum(rng.normal(size=n))


@pytest.mark.parametrize("m", [1, 3, 15])
def test_polarisation(m: int) -> None:
    x = series()
    sums, counts = block_sums(x, [m], 7)[m]
    found = sums.sum(axis=0) / counts.sum()
    factor = np.array([m])
    for i in range(3):
        assert found[i, i] == pytest.approx(allan_variance(x[i], factor).variance[0], rel=1e-9)
        for j in range(i):
            plus, minus = (allan_variance(x[i] + s * x[j], factor).variance[0] for s in (1, -1))
            assert found[i, j] == pytest.approx((plus - minus) / 4, rel=1e-9, abs=1e-12)


def test_rows_give_the_matrix_back() -> None:
    x = series()
    named = dict(zip(("x1", "y1", "z1"), x, strict=True))
    rows = covariance_rows(named, 1, 120.0)
    assert {row["m"] for row in rows} == {1, 12, 120, 1200} and len(rows) == 4 * 6
    sums, counts = block_sums(x, [12, 1], 1)[12]
    upper = [row["covariance_mm2"] for row in rows if row["m"] == 12]
    assert upper == pytest.approx((sums[0] / counts[0])[np.triu_indices(3)])
    # White noise at one frame: 2/3 as many degrees of freedom as terms, less a little for the walk
    first = rows[0]
    assert first["edf"] == pytest.approx(2 / 3 * first["n_terms"], rel=0.01)


def test_a_hidden_marker_takes_nothing_from_the_other() -> None:
    x = dict(zip(("x1", "y1", "z1", "x2", "y2", "z2"), [*series(), *series()], strict=True))
    whole = {(r["series_1"], r["series_2"], r["m"]): r for r in covariance_rows(x, 2, 120.0)}
    x |= {name: np.where(np.arange(20_000) < 5_000, np.nan, x[name]) for name in ("x2", "y2", "z2")}
    part = {(r["series_1"], r["series_2"], r["m"]): r for r in covariance_rows(x, 2, 120.0)}
    assert part.keys() == whole.keys()
    assert part["x1", "z1", 12] == whole["x1", "z1", 12]
    for pair in (("x1", "y2", 1), ("y2", "y2", 1)):
        assert part[pair]["n_terms"] == 14_999
        assert part[pair]["covariance_mm2"] == pytest.approx(whole[pair]["covariance_mm2"], rel=0.1)
    x |= dict.fromkeys(("x2", "y2", "z2"), np.full(20_000, np.nan))
    assert len(covariance_rows(x, 2, 120.0)) == 4 * 6
    assert covariance_rows({k: v[:2] for k, v in x.items()}, 2, 120.0) == []
