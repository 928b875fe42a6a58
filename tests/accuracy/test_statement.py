"""Budgets against published examples; coverage of left-out dates by twins of bars."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.accuracy.bar import Bar, Certificate, evaluate
from mocap_metrology.accuracy.statement import Statement, statements
from mocap_metrology.accuracy.take import Take, take_of
from mocap_metrology.accuracy.twin import BarErrors, BarTwin, Way, simulate_bar
from mocap_metrology.common.gum import Budget, Component, coverage_factor
from mocap_metrology.settings import Bar as Settings

ROOM = BarErrors(500.0, surface=0.8, pass_mm=0.3, correlation_s=0.3, rest=0.3, frame=0.1, bias=2.0)
TRUE = Certificate(500.0, 0.05)


def taken(errors: BarErrors, seed: int, date: str = "", day_mm: float = 0.0) -> Take:
    shifted = replace(errors, bias=errors.bias + day_mm)
    made = simulate_bar(BarTwin("t", shifted, seed, 30.0, 50.0))
    return take_of(f"pass {seed}", date, 50.0, made.position_mm, 1e-3)


def sizes(one: Statement) -> dict[str, Component]:
    return {component.name: component for component in one.budget.components}


def test_end_gauge_of_the_guide() -> None:
    """JCGM 100:2008, H.1, table H.1, in nm: u_c = 32, nu_eff = 16, U of 99 % = 93; and the dof of
    its comparator, H.1.6."""
    gauge = Budget(
        (
            Component("standard", "B", 25.0, 18),
            Component("difference", "A", 9.7, 25.6),
            Component("expansion", "B", 2.9, 50),
            Component("temperature", "B", 16.6, 2),
        )
    )
    assert round(gauge.u) == 32 and math.floor(gauge.dof) == 16
    assert round(coverage_factor(math.floor(gauge.dof), 0.99), 2) == 2.92
    assert round(gauge.u) * 2.92 == pytest.approx(93, abs=0.5)
    assert sum(map(gauge.share, gauge.components)) == pytest.approx(1)
    parts = ((5.8, 24), (3.9, 5), (6.7, 8))
    comparator = Budget(tuple(Component(str(u), "B", u, nu) for u, nu in parts))
    assert comparator.u == pytest.approx(9.7, abs=0.05)
    assert comparator.dof == pytest.approx(25.6, abs=0.3)


def test_effective_degrees_of_the_guide() -> None:
    """JCGM 100:2008, G.4.1: u = 0.25, 0.57, 0.82 % with 9, 4, 14: nu_eff = 19, t95 = 2.09; table
    G.2 for infinite degrees."""
    parts = ((0.25, 9), (0.57, 4), (0.82, 14))
    budget = Budget(tuple(Component(str(u), "A", u, nu) for u, nu in parts))
    assert budget.u == pytest.approx(1.03, abs=0.005)
    assert budget.dof == pytest.approx(19, abs=0.05)
    assert coverage_factor(19) == pytest.approx(2.09, abs=0.005)
    assert coverage_factor(math.inf) == pytest.approx(1.960, abs=0.0005)


def test_components_are_those_of_the_twin() -> None:
    takes = [taken(ROOM, seed) for seed in range(8)]
    (one,) = statements(evaluate(takes, TRUE, Settings()))
    found = sizes(one)
    slow = 0.3 * math.sqrt(1 - math.exp(-1 / 15))  # of the Gauss-Markov part in a frame
    truth = {"frame": math.hypot(0.1, slow), "rest": math.sqrt(0.3**2 - slow**2), "place": 0.8}
    for name, value in truth.items():
        assert found[name].u == pytest.approx(value, rel=0.25), name
    assert found["pass"].dof == 7 and found["reference"].u == 0.05
    assert found["resolution"].u == pytest.approx(1e-3 / math.sqrt(12))
    assert one.correction_mm == pytest.approx(-2.0, abs=0.8)
    (mean,) = statements(evaluate(takes, TRUE, Settings()), averaged=4)
    assert sizes(mean)["frame"].u == pytest.approx(found["frame"].u / 2)


def test_directions_monitor_and_scale() -> None:
    """Two directions 3 mm apart: half of it for any of them. The scatter of a monitor counts where
    fewer than three dates are known."""
    z = replace(ROOM, bias=-1.0, path=Way(along="z"))
    takes = [taken(ROOM, seed) for seed in range(3)] + [taken(z, seed) for seed in range(5, 8)]
    drift, scale = Component("drift", "A", 0.4, 12), Component("scale", "A", 1e-3, 9)
    every = statements(evaluate(takes, TRUE, Settings()), [drift, scale])
    assert [one.direction for one in every] == ["any", "bar x, way x", "bar z, way x"]
    found = sizes(every[0])
    assert found["class"].u == pytest.approx(1.5, abs=0.5) and found["drift"].u == 0.4
    assert found["scale"].u == pytest.approx(0.5)
    dated = [replace(take, date=f"2026-03-0{k % 3 + 1}") for k, take in enumerate(takes)]
    (first, *_) = statements(evaluate(dated, TRUE, Settings()), [drift])
    assert first.n_dates == 3
    assert "date" in sizes(first) and "drift" not in sizes(first)


def test_few_passes_state_nothing() -> None:
    assert statements(evaluate([taken(ROOM, 1), taken(ROOM, 2)], TRUE, Settings())) == ()


def facility(seed: int, dates: int, passes: int) -> list[list[Take]]:
    """Passes of each date of one room along x and z; days scatter by 0.4 mm."""
    days = np.random.default_rng(seed).normal(0.0, 0.4, dates)
    room = replace(ROOM, room_seed=seed)
    upright = replace(room, bias=0.0, path=Way(along="z"))
    return [
        [
            taken(errors, 1000 * seed + 100 * d + 10 * p + z, f"2026-03-{d + 1:02d}", float(day))
            for z, errors in enumerate((room, upright))
            for p in range(passes)
        ]
        for d, day in enumerate(days)
    ]


@pytest.mark.parametrize(("dates", "passes"), [(5, 1), (4, 2)])
def test_frames_of_a_date_left_out_lie_inside(dates: int, passes: int) -> None:
    """Mean over rooms and dates of the share of frames within U: 90 % at least, and U is not
    simply wide."""
    settings, shares = Settings(), []
    for seed in range(1, 4):
        days = facility(seed, dates, passes)
        for out in range(dates):
            others = [take for d, day in enumerate(days) if d != out for take in day]
            bar = evaluate(others, TRUE, settings)
            left: Bar = evaluate(days[out], TRUE, settings)
            by_name = {one.direction: one for one in statements(bar)}
            for name, one in (("any", left.every), *((c.name, c) for c in left.classes)):
                e = np.concatenate(one.errors) + by_name[name].correction_mm
                shares.append(np.mean(np.abs(e[np.isfinite(e)]) <= by_name[name].budget.expanded))
    assert 0.90 <= np.mean(shares) <= 0.995


def test_budgets_are_those_of_gtc() -> None:
    """Random budgets against the GUM Tree Calculator."""
    gtc = pytest.importorskip("GTC")
    rng = np.random.default_rng(5)
    for _ in range(20):
        n = int(rng.integers(2, 8))
        dof = [math.inf, *rng.integers(1, 60, n - 1).tolist()]
        u = rng.lognormal(0, 1, n)
        ours = Budget(tuple(Component("", "A", *one) for one in zip(u, dof, strict=True)))
        theirs = sum(gtc.ureal(0, *one) for one in zip(u, dof, strict=True))
        assert ours.u == pytest.approx(theirs.u) and ours.dof == pytest.approx(theirs.df)
        assert ours.k == pytest.approx(gtc.rp.k_factor(theirs.df), rel=1e-6)
