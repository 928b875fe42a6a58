"""Kinds of slow wander: simulated shapes of known kind, in noise of known kind."""

import math
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

from benchmarks.sentences._kinds import gauss_markov
from benchmarks.sentences.signatures import KINDS, RATE, N, T
from mocap_metrology.noise.diagnosis.block_means import MOST_BLOCKS, block_length, spectra
from mocap_metrology.noise.diagnosis.export import hiding_step
from mocap_metrology.noise.diagnosis.findings import shift_near
from mocap_metrology.noise.diagnosis.one_series import decided
from mocap_metrology.noise.diagnosis.signatures import LEAST_BLOCKS, Wander, signature


def noise(seed: int, n: int = N) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, 0.02, n)


@pytest.mark.parametrize("case", KINDS)
def test_each_kind_is_named_and_nothing_else(case: str) -> None:
    """Nothing false in two recordings, and all that is true in one of them: in the study of 40 the
    least is 75 %, of a drift in flicker."""
    draw, *names = KINDS[case]
    true, also = (set(words.split()) for words in names)
    named = 0
    for seed in (3, 6):
        found = signature(draw(np.random.default_rng(seed), T) + noise(seed), RATE)
        assert found is not None
        said = {*found.kinds, *(("noise",) if found.noise else ())} - also
        assert said <= true, (said, found.possible)
        assert set(found.kinds) <= set(found.possible)
        named += said == true
    assert named


def test_the_interval_of_the_net_movement_holds_in_99_of_100() -> None:
    """Of 50 that do not move; t of the 14 degrees of freedom of two ends."""
    rng = np.random.default_rng(7)
    found = [signature(rng.normal(0, 0.02, 600), 10.0) for _ in range(50)]
    assert sum(abs(one.net_mm) > 2.98 * one.net_error_mm for one in found if one) <= 3


def test_spectra_of_correlated_block_means_are_the_closed_form() -> None:
    """Of a Gauss-Markov process the means of blocks of 1/a correlation times have the covariances
    2 (a - 1 + e^-a), (1 - e^-a)^2 and (1 - e^-a)^2 e^-a (over a^2) 0, 1 and 2 blocks apart. Of
    their differences the first two over the variance, from the spectrum."""
    n = 500
    f = np.arange(1, n + 1) / (2 * (n + 1))
    weight = 4 * np.sin(np.pi * f) ** 2
    for T_c, noise_name in zip((0.25, 1.0), ("fast", "correlated"), strict=True):
        slow = spectra(n)[noise_name][0] - weight  # of one ratio to white noise
        a = 1 / T_c
        r = np.array(
            [2 * (a - 1 + np.exp(-a)), *((1 - np.exp(-a)) ** 2 * np.exp(-a * np.arange(3)))]
        )
        variance = 2 * r[0] - 2 * r[1]
        for lag, covariance in ((1, 2 * r[1] - r[0] - r[2]), (2, 2 * r[2] - r[1] - r[3])):
            found = np.sum(slow * np.cos(2 * np.pi * f * lag)) / np.sum(slow)
            assert found == pytest.approx(covariance / variance, abs=0.003)


UNBOUNDED = np.array([[3.0, 3.5] * 15, [1.0] * 30])  # slowest differences larger than a walk's


@pytest.mark.parametrize(
    ("noise", "lowest", "kept"),
    [
        ("random_walk", [0.1], True),
        ("random_walk", [0.1, 0.0], False),
        ("random_walk", [math.nan], True),  # no interval
        ("flicker", [0.1], False),
        ("flicker", [], True),
    ],
)
def test_a_noise_is_named_where_the_likelihood_allows_it(noise, lowest, kept) -> None:
    """What is no longer named remains possible, beside what else is."""
    rows = [
        {"series": name, "estimator": "likelihood", "parameter": "h_-2", "lower_95": low}
        | {"status": "ok"}
        for name, low in [*(("x1", low) for low in lowest), ("x2", 0.0)]
    ]
    for possible in ((), ("drift",)):
        wander = Wander((), noise, possible, 0.1, 0.01, 0.1, slowest=UNBOUNDED)
        one = decided({"x1": wander}, rows)["x1"]
        assert one.noise == (noise if kept else "")
        assert one.possible == (possible if kept else possible or ("noise",))


@pytest.mark.parametrize(
    ("detected", "named"),
    [(("drift",), True), (("drift", "A_w", "T_w"), False), (("A_w", "T_w"), False), ((), False)],
)
def test_a_line_is_named_where_its_slope_is_all_the_movement(detected, named) -> None:
    """Beside an approach that is not named the slope is of a part of it."""
    rows = [
        {"series": "x1", "estimator": "likelihood", "parameter": name, "lower_95": 1.0}
        | {"status": "ok" if name in detected else "not_detected"}
        for name in ("drift", "A_w", "T_w")
    ]
    one = decided({"x1": Wander(("drift",), "", ("drift",), 0.1, 0.01, 0.1)}, rows)["x1"]
    assert one.allows("drift") is named and one.undecided is not named


def test_two_steps_beside_a_warm_up() -> None:
    """Its begin is no third one."""
    for seed, (size, constant_s) in enumerate(((0.1, 100), (0.03, 20))):
        curve = size * np.exp(-T / constant_s) + 0.03 * (T > 300) + 0.05 * (T > 700)
        found = signature(noise(seed) + curve, RATE)
        assert found.kinds == ("warm_up", "step")
        (first, small), (second, large) = found.jumps
        assert (first, second) == pytest.approx((300, 700), abs=1.5)
        assert (small, large, -found.moved_mm) == pytest.approx((0.03, 0.05, size), abs=0.003)


def test_a_change_over_a_long_gap_is_not_at_once() -> None:
    """What is missing for 80 blocks may have moved in any way; for 20 it may have done at any time
    of these."""
    x = noise(2) + np.where(T > 400, 0.06, 0)
    assert signature(x, RATE).kinds == ("step",) and signature(x, RATE).lost_s == 0
    lost = signature(np.where((T > 390) & (T < 410), np.nan, x), RATE)
    assert lost.kinds == ("step",) and (*lost.at_s, lost.lost_s) == pytest.approx((390, 20), abs=1)
    x[(T > 320) & (T < 400)] = np.nan
    found = signature(x, RATE)
    assert not found.kinds and found.undecided


def fading(rng: np.random.Generator, constant_s: float) -> np.ndarray:
    """Two steps of 0.05 mm that begin with 0.15 mm."""
    since = [np.maximum(T - at, 0) for at in rng.uniform((50, 400), (450, 800))]
    return sum((0.05 + 0.1 * np.exp(-s / constant_s)) * (s > 0) for s in since)


def test_size_and_place_of_a_step_a_cycle_and_two_levels() -> None:
    step = signature(noise(5) - np.where(T >= 300.4, 0.06, 0.0), RATE)
    assert step is not None and step.kinds == ("step",)
    assert step.size_mm == pytest.approx(-0.06, abs=0.001)
    assert step.at_s[0] == pytest.approx(300.4, abs=1)
    assert step.net_mm == pytest.approx(-0.06, abs=4 * step.net_error_mm)
    for period_s in (187.3, 182.1):  # to both sides of a place on the grid that is searched
        cycle = signature(noise(6) + 0.05 * np.sin(2 * np.pi * T / period_s), RATE)
        assert cycle is not None and cycle.kinds == ("cycle",)
        assert cycle.size_mm == pytest.approx(0.05, abs=0.001)
        assert cycle.at_s[-1] == pytest.approx(period_s, rel=0.005)
    stays = np.random.default_rng(8).uniform(5, 14, 200)  # which end within blocks
    for k in (np.floor(T / 45), np.searchsorted(np.cumsum(stays), T)):
        levels = signature(noise(7) + 0.04 * (k % 2), RATE)
        assert levels is not None and levels.kinds == ("two_levels",)
        assert abs(levels.size_mm) == pytest.approx(0.04, abs=0.0004)
        assert levels.at_s[0] == pytest.approx(T[-1] / (k.max() + 1), rel=0.05)


def test_size_of_a_step_between_two_slopes() -> None:
    slopes = 1e-4 * np.where(T < 400, T, 400 - 0.5 * (T - 400))
    step = signature(noise(9) + slopes + 0.05 * (T > 400), RATE)
    assert step is not None and step.kinds == ("step",)
    assert step.size_mm == pytest.approx(0.05, abs=0.002)


def test_a_shift_in_a_walk_that_moves_as_far() -> None:
    """Named in half of ten or more, its size within three standard errors; never steps."""
    shift, named = 0.1 * ((T > 344) & (T < 447)), 0
    for seed in range(10):
        walk = np.cumsum(np.random.default_rng(seed).normal(0, 0.1 / math.sqrt(N), N))
        found = signature(noise(seed) + walk + shift, RATE)
        assert found is not None and set(found.kinds) <= {"shift"}
        if found.kinds:
            named += 1
            assert found.size_mm == pytest.approx(0.1, abs=3 * found.error_mm)
    assert named >= 5


def test_switches_of_which_only_the_stays_are_seen_are_no_cycle() -> None:
    """Events blank four seconds round each."""
    named = []
    for seed in range(8):
        rng = np.random.default_rng([seed, 4])
        ends = np.cumsum(rng.uniform(9, 23, 100))
        k = np.searchsorted(ends, T)
        off = np.abs(T[:, None] - ends[None]).min(axis=1) < 2
        slow = gauss_markov(6.3, 0.017)(rng, N, RATE)
        found = signature(np.where(off, np.nan, noise(seed) + slow + 0.045 * (k % 2)), RATE)
        named += found.kinds if found else ()
    assert "cycle" not in named


def test_the_size_of_a_step_in_a_walk_has_the_error_of_a_local_level() -> None:
    """Of blocks with white noise r in a walk q the level at the last block before the step, and at
    the first after it, has the variance P r / (P + r), P^2 = q (P + r) [Harvey 1989, 4.1.2]; one or
    two blocks between them are not known, so there is q two or three times. Blocks of a second."""
    q, r = 0.004**2, 0.02**2 / 20
    P = (q + math.sqrt(q * q + 4 * q * r)) / 2
    least, most = (math.sqrt(2 * P * r / (P + r) + number * q) for number in (2, 3))
    found = []
    for seed in range(8):
        rng = np.random.default_rng([seed, 5])
        x = 0.02 * rng.standard_normal(12_000) + rng.normal(0, 0.004 / 20**0.5, 12_000).cumsum()
        x[int(rng.uniform(3000, 9000)) :] += 0.2
        found.append(signature(x, 20.0))
    assert all("step" in one.kinds and len(one.jumps) == 1 for one in found)
    assert 0.9 * least < np.mean([one.error_mm for one in found]) < 1.1 * most
    off = np.array([one.size_mm - 0.2 for one in found])
    assert math.sqrt(np.mean(off**2)) < 1.5 * most and np.abs(off).max() < 3 * most
    assert sum(low < 0.2 < high for low, high in (one.ends_mm for one in found)) >= 6


def test_a_walk_goes_on_where_blocks_are_missing() -> None:
    """Over a gap of 20 blocks it has moved by sqrt(21) of its steps: what a step there must exceed,
    and the error of its size."""
    for seed, step in product((0, 2), (1.5, 40.0)):
        x = np.random.default_rng(seed).normal(0, 1, 300).cumsum()
        x[140:160], x[160:] = np.nan, x[160:] + step - (x[160] - x[139] if step < 2 else 0)
        found = signature(x, 1.0)
        assert ("step" in found.kinds) is (step > 2)
        assert step < 2 or found.error_mm == pytest.approx(math.sqrt(21), rel=0.2)


def test_the_slope_beside_a_cycle() -> None:
    """Of a line under white noise: sigma sqrt(12 / n) / duration, n frames."""
    cycle = 0.06 * np.sin(2 * np.pi * T / 110)
    found = [signature(noise(seed) + cycle + 3 * T / 3600, RATE) for seed in range(4)]
    error = 0.02 * math.sqrt(12 / N) / T[-1]
    for one in found:
        assert one.kinds == ("drift", "cycle") and one.own("drift") and not one.own("warm_up")
        assert one.slope[1] == pytest.approx(error, rel=0.2)
        assert one.slope[0] == pytest.approx(3 / 3600, abs=4 * error)
        assert one.size_of("drift") == pytest.approx(3 * T[-1] / 3600, rel=0.01)


def test_gaps_leave_the_kind_and_a_short_recording_has_none() -> None:
    series = noise(8) + 0.2 * np.exp(-T / 150)
    series[np.random.default_rng(9).random(N) < 0.3] = np.nan
    series[20_000:24_000] = np.nan
    found = signature(series, RATE)
    assert found is not None and found.kinds == ("warm_up",)
    assert signature(noise(8)[: LEAST_BLOCKS - 1], RATE) is None
    assert signature(noise(8)[:LEAST_BLOCKS], RATE) is not None  # blocks of one frame
    spike = signature(noise(8)[:600] + 0.6 * (np.arange(600) == 300), 1.0)  # likewise
    assert spike is not None and spike.possible
    assert signature(np.full(N, np.nan), RATE) is None
    assert signature(np.zeros(N), RATE) is None


def test_times_and_sizes_of_changes_at_once() -> None:
    """Three steps; a lift, whose size is that of its middle and not of the blocks at its ends."""
    steps = 0.04 * (T > 150.5) - 0.02 * (T > 400.5) + 0.06 * (T > 700.5)
    found = signature(noise(10) + steps, RATE)
    assert found is not None and found.kinds == ("step",)
    assert [t for t, _ in found.jumps] == pytest.approx([150.5, 400.5, 700.5], abs=1)
    assert [size for _, size in found.jumps] == pytest.approx([0.04, -0.02, 0.06], abs=0.002)
    lift = signature(noise(11) + 0.06 * ((T > 300.3) & (T < 320.7)), RATE)
    assert lift is not None and lift.kinds == ("shift",)
    assert [size for _, size in lift.jumps] == pytest.approx([0.06, -0.06], abs=0.003)
    assert lift.size_mm == pytest.approx(0.06, abs=0.003)
    assert lift.lasting_s == pytest.approx(20.4, abs=1.5)
    wanders = {"x1": lift, "L": lift}
    assert shift_near(300, 301, wanders) == ("x1", pytest.approx(0.06, abs=0.003), False)
    assert shift_near(320, 321, wanders) == ("x1", pytest.approx(-0.06, abs=0.003), True)
    assert shift_near(310, 312, wanders) is None
    assert shift_near(304, 306, wanders) and not shift_near(307, 308, wanders)
    for lasting_s in (8, 13):  # of less than 10 s it is movement
        short = signature(noise(12) + 0.06 * ((T > 300) & (300 + lasting_s > T)), RATE)
        assert short is not None and ("shift" in short.kinds) is (lasting_s > 10)


def test_a_step_beside_a_curve_and_after_missing_blocks() -> None:
    """The curve has its own size, from start to end; a step after missing blocks has the time at
    which they begin."""
    at = 450.0
    step = 0.08 * (at < T)
    found = signature(0.05 * np.log1p(T / 8) + step + noise(13), RATE)
    assert found is not None and found.kinds == ("creep", "step")
    (jump,) = found.jumps
    assert jump == pytest.approx((at, 0.08), abs=1.01)
    assert found.size_of("step") == pytest.approx(0.08, abs=0.003)
    assert found.size_of("creep") == pytest.approx(0.05 * np.log1p(T[-1] / 8), abs=0.01)
    missing = signature(np.where((at <= T) & (at + 5 > T), np.nan, step + noise(14)), RATE)
    assert missing is not None and missing.jumps[0][0] == pytest.approx(at, abs=1.01)


@pytest.mark.parametrize(("at_s", "constant_s"), [(200, 20.0), (200, 45.0), (400, 90.0)])
def test_a_shift_that_fades_ends_after_three_of_its_constants(at_s: int, constant_s: float) -> None:
    """After which 95 % of it are over: exp(-3) = 5 %; or with the recording."""
    t = np.arange(6000) / 10
    since = t - at_s
    fading = 3.0 * (since > 0) * np.exp(-np.maximum(since, 0) / constant_s)
    found = signature(fading + 0.05 * np.random.default_rng(3).standard_normal(t.size), 10.0)
    assert found.kinds == ("shift",)
    assert found.at_s[0] == pytest.approx(at_s, abs=1.5)
    assert found.lasting_s == pytest.approx(min(3 * constant_s, 599 - at_s), rel=0.1)


def test_a_walk_is_not_named_where_correlated_noise_may_be_it() -> None:
    """Noise correlated over a tenth of the recording is called a walk in 2 of 40 at most, and a
    walk in most (study of both: 0 and 77 %)."""
    n, rate = 6000, 10.0
    named = {"walk": 0, "correlated": 0}
    for seed in range(8):
        rng = np.random.default_rng([seed, 3])
        walk, own = np.cumsum(rng.normal(0, 0.0015, n)), gauss_markov(60.0, 0.04)(rng, n, rate)
        for name, wandering in (("walk", walk), ("correlated", own)):
            found = signature(wandering + rng.normal(0, 0.0063, n), rate)
            named[name] += bool(found and found.noise == "random_walk")
    assert named["walk"] >= 4 and named["correlated"] <= 1


def test_equal_steps_at_equal_times_are_no_cycle() -> None:
    """Of 0.008 mm every 20 s: a line and what has their period. A cycle as large is one."""
    t = np.arange(6000) / 10.0
    for seed in range(3):
        stairs = signature(noise(seed, t.size) + 0.008 * np.floor(t / 20 + 0.1 * seed), 10.0)
        wave = signature(noise(seed, t.size) + 0.02 * np.sin(2 * np.pi * t / 50), 10.0)
        assert stairs is not None and "cycle" not in stairs.kinds
        assert wave is not None and wave.kinds == ("cycle",)


def test_what_steps_of_a_file_make_is_no_cycle() -> None:
    """A drift of 0.4 mm in steps of 0.1 mm that noise of 0.02 mm does not dither ripples."""
    t = np.arange(15_000) / 50
    for seed in range(3):
        rng = np.random.default_rng([seed, 7])
        x = 0.1 * np.round((0.4 * t / t[-1] + rng.normal(0, 0.02, t.size) + rng.uniform()) / 0.1)
        found = signature(x, 50.0)
        gaps = np.where(rng.random(x.size) < 0.01, np.nan, x)
        for series in (x, gaps):
            assert hiding_step(series, 0.0, distance=False) == pytest.approx(0.1)
        assert found is not None
        left = found.beyond(0.1)
        assert not set(left.kinds) - {"drift"} and (left.kinds or left.undecided)


def test_the_ends_of_what_was_left_out_are_no_levels() -> None:
    """Bumps of 16 s, of which an event has the middle."""
    x, since = noise(8), np.abs(np.subtract.outer(T, np.arange(50, 850, 100))).min(axis=1)
    found = signature(np.where(since < 6, np.nan, x + 0.015 * (since < 12)), RATE)
    assert found is not None and found.undecided and "two_levels" not in found.possible


def test_a_recording_has_no_more_blocks_than_are_worth_the_time() -> None:
    """Of a second, of more where it is long, and of less where it is short."""
    for n in (1, 59, 6000, 60_000, 60_001, 10**6 + 1, 10**8 + 999):
        length = block_length(n, 60.0)
        assert n <= MOST_BLOCKS * length and (length < 60 or 1000 * (length - 1) < max(n, 59_001))
        assert n < 100 or length == 60 or n // length >= 100


def test_the_way_of_a_warm_up_beside_a_cycle() -> None:
    curve = 0.1 * np.exp(-T / 200)
    found = signature(noise(3) + curve + 0.02 * np.sin(2 * np.pi * T / 110), RATE)
    assert found is not None and found.kinds == ("warm_up", "cycle") and found.own("warm_up")
    assert found.size_of("warm_up") == pytest.approx(curve[-1] - curve[0], rel=0.03)
    assert found.size_of("cycle") == pytest.approx(0.02, rel=0.03)


def test_a_coefficient_is_named_by_its_own_kind_alone() -> None:
    none = Wander((), "", (), 0.0, 0.0, 0.0)
    assert not any(none.allows(kind) for kind in ("drift", "warm_up", "random_walk"))
    assert not none.undecided
    slow = Wander(("drift",), "random_walk", ("drift",), 0.1, 0.01, 0.1)
    assert slow.allows("drift") and slow.allows("random_walk") and not slow.allows("warm_up")
    assert Wander((), "", ("cycle", "drift"), 0.1, 0.01, 0.1).undecided


def test_a_shift_that_is_mostly_missing_has_no_size_of_one_that_fades() -> None:
    """0.03 mm for 3.1 s, of which the last second and what comes after it are missing; named as one
    of 0.05 mm that fades before."""
    for seed in (1, 2):
        series = np.random.default_rng(seed).normal(0, 0.02, 60_000)
        time = np.arange(series.size) / 100
        series[(time > 300.5) & (time < 303.6)] += 0.03
        series[(time > 302.6) & (time < 308)] = np.nan
        found = signature(series, 100.0, 10)
        assert found is not None and "shift" not in found.kinds


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("kind", "curve"),
    {
        "drift": lambda t: 3000 * t,
        "step": lambda t: t > 0.5,
        "warm_up": lambda t: np.exp(-5 * t),
        "accelerating": lambda t: t**2,
        "cycle": lambda t: np.sin(12 * np.pi * t),
        "two_levels": lambda t: np.floor(20 * t) % 2,
    }.items(),
)
def test_kinds_without_any_noise(kind: str, curve: Callable[[np.ndarray], np.ndarray]) -> None:
    """As of computed positions: no noise is named, and nothing warns of sums that are zero."""
    found = signature(curve(np.arange(3000) / 3000).astype(float), RATE)
    assert found is not None and found.kinds == (kind,) and found.noise == ""
