"""Shapes of slow wander, each against least squares over all places, and how fast a curve goes."""

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.recoveries import recoveries
from mocap_metrology.noise.diagnosis.shape import Shape, pace, refined_place, time_of
from mocap_metrology.noise.diagnosis.shapes import MOST_BENDS, MOST_STEPS, shapes
from mocap_metrology.noise.diagnosis.signatures import signature


def test_the_ends_of_a_shift_are_those_of_least_squares() -> None:
    """Against every pair of ends: squares about the mean inside and the mean outside."""
    n = 60
    pairs = [(a, b) for a in range(1, n - 1) for b in range(a + 1, n)]
    for seed in range(8):
        rng = np.random.default_rng(seed)
        z = rng.standard_normal(n)
        first = int(rng.integers(5, 50))
        z[first : first + int(rng.integers(2, 7))] += 2.5
        rest = [
            z[a:b].var() * (b - a) + np.delete(z, slice(a, b)).var() * (n - b + a) for a, b in pairs
        ]
        found = [s for s in shapes(z, np.arange(n)) if s.kinds == {"shift"}]
        assert pairs[int(np.argmin(rest))] in [s.at for s in found if len(s.columns) == 1]


@pytest.mark.parametrize("length", [1, 2, 3, 20])
@pytest.mark.parametrize("ends_within", [False, True])
def test_a_short_shift_changes_twice(length: int, ends_within: bool) -> None:
    """Of blocks between which others may be missing; also with blocks that it ends within."""
    t, first, last = np.arange(60), 25, 25 + length
    inside = ((t >= first) & (t < last)).astype(float)
    ends = np.array([t == place for place in (first - 1, last)], float)
    columns = np.vstack([inside, ends]) if ends_within else inside[None]
    shape = Shape(frozenset({"shift"}), columns, at=(first, last), main=-len(columns))
    jumps = shape.jumps(np.array([2.0, 0.5, 1.0])[: len(columns)])
    assert [size for _, size in jumps] == pytest.approx([2.0, -2.0])
    assert [place for place, _ in jumps] == [first, last + ends_within]


def test_each_of_several_steps_is_where_it_leaves_least() -> None:
    """Against every other place, by least squares beside a constant and the steps before it."""
    n, z = 40, np.random.default_rng(2).standard_normal(40).cumsum()
    rows, blocks = [np.ones(n)], np.arange(n)
    found = [s for s in shapes(z, blocks) if s.kinds & {"step", "shift", "steps"}]
    found = [s for s in found if "drift" not in s.kinds and (s.columns[:, -1] == 1).all()]
    for count in range(1, MOST_STEPS + 1):
        rest = {
            at: np.linalg.lstsq(np.array([*rows, blocks >= at]).T, z, rcond=None)[1]
            for at in range(2, n - 1)
            if not any((row == (blocks >= at)).all() for row in rows)
        }
        rows.append(blocks >= min(rest, key=lambda at: float(rest[at][0])))
        assert any(np.array_equal(s.columns, rows[1:]) for s in found), count


@pytest.mark.parametrize("count", [3, 16])
def test_each_of_the_shifts_that_fade_alike_is_a_column(count: int) -> None:
    k = np.arange(400)
    since = np.maximum(k - 24 * np.arange(1, count + 1)[:, None], -1)
    fading = np.where(since >= 0, np.exp(-since / np.sqrt(40)), 0)
    z = fading.sum(axis=0) + 1e-3 * np.random.default_rng(1).standard_normal(k.size)
    found = [s.columns for s in shapes(z, k) if "recoveries" in s.kinds]
    assert any(len(own) == count and np.allclose(own.sum(axis=0), z, atol=0.01) for own in found)


@pytest.mark.parametrize(("lasts", "at"), [(0.0, (150, 210)), (2.0, (150,))])
def test_a_shift_that_fades_has_two_places_and_a_step_has_one(lasts: float, at: tuple) -> None:
    """Three time constants, of 20 blocks, after its begin it is over."""
    k = np.arange(400)
    z = (k >= 150) * (lasts + np.exp(-np.maximum(k - 150, 0) / 20))
    z = z + 1e-3 * np.random.default_rng(1).standard_normal(k.size)

    def misfit(shape: Shape) -> float:
        columns = np.vstack([np.ones(k.size), shape.columns]).T
        return float(np.linalg.lstsq(columns, z, rcond=None)[1][0])

    best = min(recoveries(z, k), key=misfit)
    assert best.at == pytest.approx(at, abs=0.5)


@pytest.mark.parametrize(("fast", "slow", "line"), [(12, 92, 0.0), (5, 60, 0.4), (12, 300, -0.3)])
def test_two_approaches_are_those_of_least_squares(fast: float, slow: float, line: float) -> None:
    """Their valley is narrow, and a search in turn ends far from its bottom: that is no creep."""
    k = np.arange(400)
    z = 0.1 * np.exp(-k / fast) + 0.4 * np.exp(-k / slow) + line * k / 400
    z = z + 1e-3 * np.random.default_rng(5).standard_normal(k.size)
    columns = [s.columns for s in shapes(z, k) if s.kinds >= {"warm_up", "smooth"}]
    fits = [np.vstack([np.ones(k.size), own]).T for own in columns if len(own) < 4]
    assert min(np.linalg.lstsq(X, z, rcond=None)[1][0] for X in fits) < 1.1e-6 * k.size
    assert not any("creep" in found.kinds for found in [signature(z, 1.0)] if found)


@pytest.mark.parametrize("order", [2, 3])
def test_a_cycle_beside_a_polynomial_has_two_coefficients_more(order: int) -> None:
    k = np.arange(400)
    z = 3 * (k / 200 - 1) ** order + np.sin(2 * np.pi * k / 57)
    z = z + 1e-3 * np.random.default_rng(4).standard_normal(k.size)
    cycles = [s.columns for s in shapes(z, k) if "cycle" in s.kinds and len(s.columns) == order + 2]
    fits = [np.vstack([np.ones(k.size), columns]).T for columns in cycles]
    assert min(np.linalg.lstsq(X, z, rcond=None)[1][0] for X in fits) < 2e-6 * k.size


def test_what_two_blocks_show_has_no_size_beyond_them() -> None:
    """A shift for eight blocks, of which two are known."""
    k = np.delete(np.arange(300), [*range(174, 180), *range(182, 187)])
    z = 0.08 * ((k >= 176) & (k < 184)) + 1e-3 * np.random.default_rng(2).standard_normal(k.size)
    found = [abs(s.size(s.solved(z))) for s in shapes(z, k) if s.kinds >= {"shift", "fades"}]
    assert max(found, default=0.0) < 0.1


def test_the_last_of_ten_bends_is_where_it_leaves_least_beside_all_others() -> None:
    """Of places a hundredth of the time apart."""
    n = 150
    t = np.arange(n) / (n - 1) - 0.5
    hinges = np.maximum(t - np.linspace(-0.48, 0.48, 97)[:, None], 0)

    def rest(columns: np.ndarray) -> float:
        X = np.vstack([np.ones(n), columns]).T
        return float(np.sum((z - X @ np.linalg.lstsq(X, z, rcond=None)[0]) ** 2))

    for seed in range(6):
        z = np.random.default_rng(seed).standard_normal(n).cumsum()
        bent = [s for s in shapes(z, np.arange(n)) if "smooth" in s.kinds]
        (own,) = (s.columns for s in bent if s.searched == MOST_BENDS)
        assert rest(own) <= min(rest(np.vstack([own[:-1], one])) for one in hinges) + 1e-6


def test_the_size_of_a_shape_is_what_it_does() -> None:
    """In mm: how far a curve goes, with the sign of its change; the height of a step. Of the
    shape that fits best."""
    t = np.arange(301.0)
    for true, size in (
        (0.2 * np.exp(-t / 150), -0.2 * (1 - np.exp(-300 / 150))),
        (1e-6 * t**2, 1e-6 * 300**2),
        (0.002 * np.minimum(t, 90), 0.18),
        (-0.002 * np.maximum(t - 90, 0), -0.42),
        (-0.3 * (t >= 120), -0.3),
    ):
        z = true + 1e-5 * np.random.default_rng(1).standard_normal(t.size)
        every = [s for s in shapes(z, np.arange(t.size)) if s.kinds and "cycle" not in s.kinds]
        fits = [(s, s.solved(z)) for s in every]
        rest = [(float(np.var(z - s.curve(solved))) * 1.001 ** len(s.columns), s.size(solved))
                for s, solved in fits]  # fmt: skip
        assert min(rest)[1] == pytest.approx(size, rel=0.02)
    others = {"cycle", "step", "warm_up"}
    bends = [s for s in shapes(t, t) if "smooth" in s.kinds and not s.kinds & others]
    bends = [s for s in bends if 0 < s.searched < len(s.columns)]
    of_a_cycle, *bends = [(len(s.columns), s.searched) for s in bends]
    assert of_a_cycle == (2, 1)
    assert bends == [(places + 1, places) for places in range(1, MOST_BENDS + 1)]


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        (lambda t: t**3, {"accelerating"}),
        (lambda t: -np.exp(3 * t), {"accelerating"}),
        (lambda t: np.sqrt(t), {"slowing"}),
        (lambda t: np.log1p(30 * t), {"slowing"}),
        (lambda t: t, {"drift"}),
        (lambda t: 1 / (1 + np.exp(-20 * (t - 0.5))), set()),  # fast in the middle
        (lambda t: np.sin(4 * t), set()),  # turns
        (lambda t: t > 0.9, set()),  # at once
        (lambda t: np.minimum(t, 0.4), set()),  # and rests
        (lambda t: np.maximum(t, 0.63), set()),
        (lambda t: -np.exp(-t / 0.11), {"slowing"}),
    ],
)
def test_pace_of_a_curve(curve, expected: set[str]) -> None:
    assert pace(np.asarray(curve(np.linspace(0, 1, 600)), float)) == expected


def test_a_place_is_found_to_a_thousandth_of_the_grid() -> None:
    t, grid = time_of(np.arange(200)), np.linspace(-0.4, 0.4, 9)
    z = 3 * np.maximum(t - 0.1234, 0) + 2 * t
    found = refined_place(z, t, lambda place: np.maximum(t - place, 0), grid)
    assert found == pytest.approx(0.1234, abs=1e-4)


def test_a_frame_alone_is_no_shift_that_fades() -> None:
    """At 1 Hz a block is a frame, of which one is off in five recordings of ten minutes: nothing is
    named; what fades in 15 frames is a shift in four of five at least."""
    time = np.arange(600.0)
    off, fades = np.where(time == 300, 0.5, 0.0), 0.06 * np.exp(-(time - 250) / 15) * (time >= 250)
    noises = 0.02 * np.random.default_rng(12).normal(size=(5, 600))
    spikes, shifts = ([signature(z + own, 1.0) for z in noises] for own in (off, fades))
    assert not any(one.kinds for one in spikes)
    assert sum(one.kinds == ("shift",) for one in shifts) >= 4
