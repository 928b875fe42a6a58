"""How often the intervals of a moving bar hold: python -m benchmarks.bars (about 4 minutes).

Simulated bars: place 0 to 4 mm, pass 0.5 or 1.5 mm, correlation over 15 or 150 frames, 3 or 10
passes. For every statistic of `bar.csv`: how often its 95 % interval holds the expectation of a
pass's statistic (its logarithm's, where positive), and how often the next pass lies in the interval
of the next one. Then the mean of one take where it has an interval, the slope of scale of rigid
bodies of four markers that bend at random, and the share of the frames of a day left out that lie
within U of a statement by the other days.
"""

from __future__ import annotations

from collections import defaultdict
from itertools import product

import numpy as np

from benchmarks import arguments
from mocap_metrology.accuracy.bar import STATISTICS, Certificate, evaluate
from mocap_metrology.accuracy.clusters import scale_slope
from mocap_metrology.accuracy.statement import ANY, statements
from mocap_metrology.accuracy.statistics import half_interval, repeated
from mocap_metrology.accuracy.take import take_of
from mocap_metrology.accuracy.twin import BarErrors, BarMotion, BarTwin, gauss_markov, simulate_bar
from mocap_metrology.settings import Bar as Settings

RATE, FRAMES = 100.0, 3000
PASSES = (3, 5, 10)
PLACES, OFFSETS, CORRELATIONS = (0.0, 1.0, 4.0), (0.5, 1.5), (15, 150)


def errors_of(place: float, offset: float, frames: int, room: int, n: int) -> list[np.ndarray]:
    """Errors of n passes in one room, mm."""
    bar = BarErrors(500.0, place, offset, frames / RATE, rest=1.0, frame=0.3, room_seed=room)
    found = []
    for seed in range(n):
        twin = BarTwin("study", bar, 10_000 * room + seed, FRAMES / RATE, RATE)
        take = take_of("", "", RATE, simulate_bar(twin).position_mm, 1e-4)
        found.append(take.length_mm - bar.length)
    return found


def passes_study(n: int) -> None:
    """Each statistic over passes."""
    held, ahead, of_one = (defaultdict(list) for _ in range(3))
    for room, (place, offset, frames) in enumerate(product(PLACES, OFFSETS, CORRELATIONS), start=1):
        errors = errors_of(place, offset, frames, room, n)
        for name, statistic in STATISTICS.items():
            positive = name != "mean"
            every = np.array([statistic(e) for e in errors])
            truth = np.exp(np.log(every).mean()) if positive else 0.0
            for k in PASSES:
                for start in range(0, n - k, k + 1):
                    found = repeated(every[start : start + k], positive)
                    if positive or not place:  # a mean whose expectation depends on the room
                        held[name, k].append(found.lower < truth < found.upper)
                    ahead[name, k].append(found.next_lower < every[start + k] < found.next_upper)
        if not place:  # the mean over the room is known
            for e in errors_of(place, 0.0, frames, room, n):
                of_one[frames].append((half_interval(e), abs(np.nanmean(e))))
    print("statistic  passes  interval holds  next pass inside")
    for name, k in held:
        print(f"{name:9}  {k:6}  {np.mean(held[name, k]):14.1%}  {np.mean(ahead[name, k]):16.1%}")
    for frames, found in of_one.items():
        half, error = np.array(found)[~np.isnan([half for half, _ in found])].T
        share, holds = len(half) / len(found), np.mean(error < half) if len(half) else np.nan
        print(f"mean of one take, {frames} frames: interval in {share:.0%}, holds in {holds:.1%}")


def scale_study(n: int) -> None:
    """A body of four markers on a way of 12 m: scale rising by 150 ppm/m, every marker drifting off
    its place by bends mm/m of its own, noise correlated over 0.2 s."""
    for bend, noise in product((0.0, 0.03, 0.1), (0.2, 0.5)):
        held = []
        for seed in range(n):
            rng = np.random.default_rng([seed, int(100 * bend), int(10 * noise)])
            shape = rng.uniform(-250, 250, (4, 3))
            way = np.linspace(0, 12, 1500)
            place = np.stack([1000 * way, 200 * np.sin(way), 0 * way])
            grown = shape[:, :, None] * (1 + 150e-6 * way)
            bent = bend * rng.standard_normal((4, 3, 1)) * way
            waves = [[gauss_markov(rng, way.size, 20.0) for _ in range(3)] for _ in range(4)]
            slope = scale_slope(place + grown + bent + noise * np.array(waves), range(4))
            assert slope is not None
            held.append(slope.lower < 150 < slope.upper)
        print(f"scale slope, bends {bend} mm/m, noise {noise} mm: holds in {np.mean(held):.1%}")


def statement_study(rooms: int, dates: int = 5) -> None:
    """Frames of a day left out; days scatter by 0.4 mm, passes by 0.3 mm, along x and z. Beside U,
    1.96 times the noise from frame to frame alone."""
    held, certificate, settings = defaultdict(list), Certificate(500.0, 0.05), Settings()
    for room in range(1, 1 + rooms):
        days = np.random.default_rng(room).normal(0.0, 0.4, dates)
        takes = []
        for k, (day, along) in enumerate(product(range(dates), "xz")):
            bias, way = float(days[day]) + 2.0 * (along == "x"), BarMotion(along=along)
            bar = BarErrors(500.0, 0.8, 0.3, 0.3, way, 0.3, 0.1, bias, room)
            made = simulate_bar(BarTwin("study", bar, 1000 * room + k, 30.0, 50.0))
            takes.append(take_of(f"{k}", f"day {day}", 50.0, made.position_mm, 1e-3))
        for out in sorted({take.date for take in takes}):
            others, own = ([t for t in takes if (t.date == out) == of_it] for of_it in (0, 1))
            stated = statements(evaluate(others, certificate, settings))
            left = evaluate(own, certificate, settings)
            named = {one.name: one for one in (*left.classes, left.every)}
            for one in stated:
                e = np.concatenate(named["all" if one.direction == ANY else one.direction].errors)
                which = "any direction" if one.direction == ANY else "one direction"
                left_mm = np.abs(e[np.isfinite(e)] + one.correction_mm)
                noise = 1.96 * next(c.u for c in one.budget.components if c.name == "frame")
                held[which].append(np.mean(left_mm <= one.budget.expanded))
                held["noise alone"].append(np.mean(left_mm <= noise))
    for name, shares in held.items():
        print(f"{name}: {np.mean(shares):.1%} of the frames within, worst {np.min(shares):.0%}")


if __name__ == "__main__":
    RUNS = arguments(__doc__, runs=400)["runs"]
    passes_study(RUNS)
    scale_study(RUNS // 2)
    statement_study(RUNS // 10)
