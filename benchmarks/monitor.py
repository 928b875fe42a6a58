"""How often the monitor of a facility calls an unchanged one changed, and finds what changed.

A facility has six series: log jitter, place x, y, z, two lengths. The scatter of each from day to
day is drawn anew, log-normal about 6 %, 0.1 mm, 0.05 mm (a factor of 1.35 is one standard
deviation). Days are independent, or correlated as a first-order process.

    python -m benchmarks.monitor [facilities] [seed]
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks import arguments
from mocap_metrology.accuracy.monitor import Chart, WatchLimits, chart, limits, words

JITTER, PLACE, LENGTH = WatchLimits(0.15, 0.06), WatchLimits(0.5, 0.1), WatchLimits(0.2, 0.05)
WATCHED = (JITTER, PLACE, PLACE, PLACE, LENGTH, LENGTH)
SPREAD = 0.3  # of the scatter among facilities, natural logarithm
DATES = 50

Facility = list[Chart]
Change = Callable[[np.ndarray], np.ndarray]  # dates after the baseline -> (6, dates) added


def facility(
    rng: np.random.Generator, baseline: int, dates: int, correlation: float, change: Change | None
) -> Facility:
    """Charts of the six series of one facility."""
    n = baseline + dates
    noise = rng.standard_normal((6, n))
    for k in range(1, n):
        noise[:, k] = correlation * noise[:, k - 1] + np.sqrt(1 - correlation**2) * noise[:, k]
    typical = np.array([watched.scatter for watched in WATCHED])
    x = (typical * np.exp(SPREAD * rng.standard_normal(6)))[:, None] * noise
    if change is not None:
        x[:, baseline:] += change(np.arange(1, dates + 1))
    limit = limits(len(WATCHED), 0.05, DATES)
    marked = np.arange(n) < baseline
    series = zip(x, WATCHED, strict=True)
    return [chart(one, range(n), marked, watched, limit) for one, watched in series]


def changed(series: int, of: Callable[[np.ndarray], np.ndarray]) -> Change:
    """A change of one series."""
    return lambda date: np.where(np.arange(6)[:, None] == series, of(date), 0.0)


def shares(facilities: list[Facility], baseline: int, last: int) -> dict[str, float]:
    """Share of facilities with a note or worse, an alert, a failure within so many dates."""
    at, worst = slice(baseline, baseline + last), ("failure", "alert", "note")
    said = [{word for one in every for word, _ in words(one)[at]} for every in facilities]
    return {
        word: float(np.mean([bool(some & set(worst[: k + 1])) for some in said]))
        for k, word in enumerate(worst)
    }


PLACE_1, PLACE_03 = changed(1, lambda d: 1.0 + 0 * d), changed(1, lambda d: 0.3 + 0 * d)
JITTER_50, JITTER_20 = (changed(0, lambda d, a=a: np.log(a) + 0 * d) for a in (1.5, 1.2))
CREEP = changed(4, lambda d: 0.02 * d)

# name, takes of the baseline, correlation, change, last date counted, what of it, what is asked, %
CASES = (
    ("unchanged", 10, 0.0, None, 50, "note", "<=", 18),
    ("unchanged", 10, 0.0, None, 50, "alert", "<=", 15),
    ("unchanged", 10, 0.0, None, 50, "failure", "<=", 1),
    ("unchanged", 10, 0.3, None, 50, "note", "<=", 30),
    ("unchanged", 10, 0.3, None, 50, "alert", "<=", 20),
    ("unchanged", 10, 0.3, None, 50, "failure", "<=", 3),
    ("unchanged", 5, 0.0, None, 50, "failure", "<=", 3),
    ("unchanged", 5, 0.3, None, 50, "failure", "<=", 8),
    ("place 1 mm", 10, 0.0, PLACE_1, 1, "alert", ">=", 97),
    ("place 1 mm", 10, 0.0, PLACE_1, 2, "failure", ">=", 95),
    ("jitter +50 %, capable", 10, 0.0, JITTER_50, 2, "failure", ">=", 99.5),
    ("jitter +20 %, capable", 10, 0.0, JITTER_20, 5, "alert", ">=", 90),
    ("length +0.02 mm a date", 10, 0.0, CREEP, 10, "note", ">=", 70),
    ("length +0.02 mm a date", 10, 0.0, CREEP, 20, "alert", ">=", 98),
    ("place 0.3 mm", 10, 0.0, PLACE_03, 20, "note", ">=", 75),
    ("place 0.3 mm", 10, 0.0, PLACE_03, 20, "failure", "<=", 10),
)


def study(n: int, seed: int) -> list[tuple[str, int, float, str, float, str, float]]:
    """Name, baseline, correlation, what is counted, share in %, asked, of each case."""
    rows, made = [], {}
    for name, baseline, correlation, change, last, word, sign, asked in CASES:
        key = name, baseline, correlation
        if key not in made:
            rng = np.random.default_rng([seed, len(made)])
            made[key] = [facility(rng, baseline, DATES, correlation, change) for _ in range(n)]
        chosen = made[key]
        if "capable" in name:
            chosen = [one for one in chosen if one[0].capable[baseline]]
        found = 100 * shares(chosen, baseline, last)[word]
        rows.append((name, baseline, correlation, f"{word} by {last}", found, sign, asked))
    return rows


def not_capable(n: int, seed: int, baseline: int = 10) -> list[float]:
    """Share of facilities, in %, in which jitter, place, length are not capable."""
    rng = np.random.default_rng([seed, 99])
    every = [facility(rng, baseline, 1, 0.0, None) for _ in range(n)]
    capable = np.array([[series.capable[-1] for series in one] for one in every])
    return [
        100 * float(np.mean(~capable[:, g].all(axis=1)))
        for g in (slice(1), slice(1, 4), slice(4, 6))
    ]


def main(facilities: int, seed: int) -> None:
    for name, baseline, correlation, what, found, sign, asked in study(facilities, seed):
        case = f"{name}, {baseline} takes, days correlated by {correlation:g}"
        print(f"{case:62s} {what:14s} {found:6.1f} %  {sign} {asked:g}")
    print(
        "not capable, jitter, place, length:",
        *(f"{p:.0f} %" for p in not_capable(facilities, seed)),
    )


if __name__ == "__main__":
    main(**arguments(__doc__, facilities=1000, seed=1))
