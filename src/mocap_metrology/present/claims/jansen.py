"""Claims of J IV, VI, VII and VIII, from its tables and from calibrations of twins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mocap_metrology.lighthouse.published import (
    AVERAGE_SD,
    MAE,
    OVERALL,
    QUANTITIES,
    SETUPS,
    published_table,
)
from mocap_metrology.present.claims.claim import (
    UNKNOWN,
    Claim,
    Finding,
    decided,
    together,
    unknown,
    within,
)
from mocap_metrology.present.jansen.jansen_tables import (
    QUANTISED,
    Variant,
    by_setup,
    mean_over,
    pose_of,
    setup_errors,
    simulated,
)
from mocap_metrology.present.tables import Record

SPAN = (0.05, 0.95)  # of a circumstance within its groups: from here to there it was tried


@dataclass(frozen=True)
class Influence:
    """`p` that errors go with a circumstance so much by chance; `seen`: by what factor it would
    have to change the error to be found with the given power (inf: it was not varied)."""

    p: float
    seen: float


def influence(
    log_errors: np.ndarray,
    circumstance: np.ndarray,
    groups: Sequence[str],
    alpha: float,
    power: float,
) -> Influence:
    """Log errors (n,) against a circumstance (n, k), both less their group's mean.

    Circumstance: one column of numbers, or an indicator (0 or 1) of each of k kinds. Given that
    within a group every order of the errors is equally likely, T = sum a x (a, x less their group's
    mean) has the mean 0 and, by groups g of n_g, the covariance sum_g (sum a^2) (sum x x') /
    (n_g - 1); T' cov^-1 T is chi-squared with its rank (Strasser & Weber 1999). `seen`: of a number
    the factor between the 5 and the 95 % points of what was tried within groups; of kinds that of
    one against the others, of the kind least often varied.
    """
    from scipy.optimize import brentq
    from scipy.stats import chi2, ncx2

    names = np.asarray(groups)
    a, x = np.array(log_errors, dtype=float), np.array(circumstance, dtype=float)
    cov, free = np.zeros((x.shape[1], x.shape[1])), 0
    for name in np.unique(names):
        own = names == name
        a[own] -= a[own].mean()
        x[own] -= x[own].mean(axis=0)
        x[own] *= np.ptp(x[own], axis=0) > 1e-9  # the same in the whole group, but for rounding
        if own.sum() > 1:
            cov += np.sum(a[own] ** 2) * (x[own].T @ x[own]) / (own.sum() - 1)
            free += own.sum() - 1
    rank = int(np.linalg.matrix_rank(cov))
    if not rank:
        return Influence(np.nan, np.inf)
    total = a @ x
    p = float(chi2.sf(total @ np.linalg.pinv(cov) @ total, rank))
    limit = chi2.isf(alpha, rank)
    needed = brentq(lambda shift: ncx2.sf(limit, rank, shift) - power, 1e-3, 1e3)
    spread = np.sum(x**2, axis=0)
    reach = np.ptp(np.quantile(x, SPAN, axis=0), axis=0) if x.shape[1] == 1 else 1.0
    steps = np.sqrt(needed * np.sum(a**2) / free / spread[spread > 0]) * reach
    return Influence(p, float(np.exp(np.max(steps))))


KABSCH = Variant("paper", "kabsch", "ideal")
FINAL = Variant("paper", "final", "ideal")
BETTER = Variant("paper-lm", "final", "ideal")
FACTORY = Variant("paper-lm", "final", "factory")
FEW_MINUTES_S = 180
NO_TABLE = "not in the tables"
ALPHA = 0.01 / 3  # of each of three influences
POWER = 0.8
# Two standard errors, in logarithms, of a ratio of mean deviations: 8 and 10 setups of 5
SD_ERROR = 2 * math.hypot(1 / math.sqrt(2 * 4 * 8), 1 / math.sqrt(2 * 4 * 10))
NOTICEABLE = 2.5  # times the error: seen by eye, with five calibrations of each setup


@dataclass(frozen=True)
class PublishedTables:
    """J's Tables I to III."""

    def table(self, number: int) -> dict[str, np.ndarray]:
        found = published_table(number)
        return {row: np.array([v[q] for q in QUANTITIES]) for row, v in found.items()}


@dataclass(frozen=True)
class Calibrations:
    """Calibrations of group jansen2019. `motion`: what a twin was moved like, by calibration;
    `reconstructions`: way -> (n, 2) errors in mm and deg of the same n recordings."""

    records: Sequence[Record]
    motion: Mapping[str, Record] = field(default_factory=dict)
    reconstructions: Mapping[str, np.ndarray] = field(default_factory=dict)
    seconds: float = math.nan  # that `paper` took for one recording, from sweeps to pose

    def table(self, number: int) -> dict[str, np.ndarray]:
        """The same rows, by `paper` at stage Kabsch with ideal optics."""
        setups = simulated(self.records, QUANTISED) if number == 3 else self._real()
        errors = {setup: setup_errors(own, KABSCH) for setup, own in setups.items()}
        mae, sd = ({s: getattr(e, k)() for s, e in errors.items()} for k in ("mae", "sd"))
        if number == 3:
            return {MAE: mean_over(list(mae.values())), AVERAGE_SD: mean_over(list(sd.values()))}
        rows, last = (mae, OVERALL) if number == 1 else (sd, "Average")
        return rows | {last: mean_over(list(rows.values()))}

    def _real(self) -> dict[str, list[Record]]:
        return by_setup(self.records, SETUPS)

    def errors_mm(self, variant: Variant, prefix: str = QUANTISED) -> dict[str, np.ndarray]:
        """Error (3,) of each simulated calibration that has the variant."""
        own = [r for group in simulated(self.records, prefix).values() for r in group]
        found = {r["calibration"]: pose_of(r, variant) for r in own}
        return {k: np.asarray(p["errors_mm"], float) for k, p in found.items() if p}


Source = PublishedTables | Calibrations


def _numbers(values: np.ndarray) -> str:
    mm, deg = values[:3], values[3:]
    return f"{', '.join(f'{v:.3g}' for v in mm)} mm; {', '.join(f'{v:.2g}' for v in deg)} deg"


def _whole(*rows: np.ndarray) -> bool:
    return all(np.isfinite(row).all() for row in rows)


def _more_accurate(source: Source) -> Finding:
    real, simulation = source.table(1)[OVERALL], source.table(3)[MAE]
    if not _whole(real, simulation):
        return unknown("no calibrations of both kinds")
    ratio = real / simulation
    text = f"real over simulated: {', '.join(f'{v:.1f}' for v in ratio)}"
    return decided(text, bool((ratio > 1).all()))


def _as_precise(source: Source) -> Finding:
    real, simulation = source.table(2)["Average"], source.table(3)[AVERAGE_SD]
    if not _whole(real, simulation):
        return unknown("no calibrations of both kinds")
    ratio = real / simulation
    words = [within(v, SD_ERROR, *np.log((0.5, 2.0))) for v in np.log(ratio)]
    text = f"real over simulated: {', '.join(f'{v:.1f}' for v in ratio)}, each ± {SD_ERROR:.0%}"
    return Finding(text, together(words))


def _decent(source: Source) -> Finding:
    table = source.table(1)
    rows = np.array([table[s] for s in SETUPS if np.isfinite(table[s]).all()])
    if not len(rows):
        return unknown("no calibrations")
    worst = rows.max(axis=0)
    text = f"worst of {len(rows)} setups {_numbers(worst)}"
    return Finding(text, UNKNOWN)


def _last_step(source: Source) -> Finding:
    if isinstance(source, PublishedTables):
        return unknown(NO_TABLE)
    before, after = source.errors_mm(KABSCH), source.errors_mm(FINAL)
    both = sorted(before.keys() & after.keys())
    if not both:
        return unknown("no calibration with both stages")
    first, last = ([v[k] for k in both] for v in (before, after))
    moved = np.subtract(first, last)
    a, b, c = (float(np.median(np.linalg.norm(v, axis=1))) for v in (first, last, moved))
    text = f"changes it by {c:.3g} mm; error {a:.3g} mm before, {b:.3g} mm after"
    return Finding(f"{text}, medians of {len(both)}", UNKNOWN)


def _no_influence(source: Source) -> Finding:
    """Pattern, speed and distance against errors within setups; see `influence`."""
    if isinstance(source, PublishedTables):
        return unknown(NO_TABLE)
    errors = {k: float(np.linalg.norm(v)) for k, v in source.errors_mm(KABSCH).items()}
    setup_of = {record["calibration"]: record["setup"] for record in source.records}
    moved = {k for k, motion in source.motion.items() if motion.get("speed_m_s", 0) > 0}
    known = [k for k, size in errors.items() if k in moved and size > 0]
    if len(known) < 20:
        return unknown(f"{len(known)} simulated calibrations of known motion; 20 are needed")
    size = np.log([errors[k] for k in known])
    motion = [source.motion[k] for k in known]
    setups = [setup_of[k] for k in known]
    patterns = np.array([m["pattern"] for m in motion])
    speed = np.log([m["speed_m_s"] for m in motion])
    distance = np.log([np.linalg.norm(m["centre_m"]) for m in motion])
    found = {
        "pattern": influence(
            size, (patterns[:, None] == np.unique(patterns)).astype(float), setups, ALPHA, POWER
        ),
        "speed": influence(size, speed[:, None], setups, ALPHA, POWER),
        "distance": influence(size, distance[:, None], setups, ALPHA, POWER),
    }
    text = "; ".join(
        f"{name}: p = {one.p:.2g}, a factor of {one.seen:.1f} would be detected"
        if math.isfinite(one.seen)
        else f"{name}: not varied"
        for name, one in found.items()
    )
    if any(one.p < ALPHA for one in found.values()):
        return decided(text, False)
    if all(one.seen <= NOTICEABLE for one in found.values()):
        return decided(text, True)
    return Finding(text, UNKNOWN)


def _full_interpolation(source: Source) -> Finding:
    if isinstance(source, PublishedTables):
        return unknown(NO_TABLE)
    if not source.reconstructions:
        return unknown("no simulated calibrations")
    median = {way: np.median(found, axis=0) for way, found in source.reconstructions.items()}
    text = "; ".join(f"{way}: {mm:.2f} mm, {deg:.3f} deg" for way, (mm, deg) in median.items())
    best = min(median, key=lambda way: median[way][0])
    return decided(text, best == "full-interpolation")


def _marginal(source: Source) -> Finding:
    if isinstance(source, PublishedTables):
        return unknown(NO_TABLE)
    if not source.reconstructions:
        return unknown("no simulated calibrations")
    median = {way: float(np.median(found[:, 0])) for way, found in source.reconstructions.items()}
    spread = max(median.values()) / min(median.values())
    return decided(f"the worst is {spread:.1f} times the best", spread < 1.25)


def _parameters(source: Source) -> Finding:
    if isinstance(source, PublishedTables):
        return unknown("future work in J")
    own = [r for group in source._real().values() for r in group]
    pairs = [(pose_of(r, BETTER), pose_of(r, FACTORY)) for r in own]
    ratios = [
        np.linalg.norm(a["truth_errors_mm"]) / np.linalg.norm(b["truth_errors_mm"])
        for a, b in pairs
        if a and b and a.get("truth_errors_mm") and b.get("truth_errors_mm")
    ]
    if not ratios:
        return unknown("no calibration with both optics and a truth")
    middle = float(np.median(ratios))
    return decided(f"error {middle:.1f} times smaller in the median of {len(ratios)}", middle > 1)


def _minutes(source: Source) -> Finding:
    """In steps, as it changes from run to run."""
    if isinstance(source, PublishedTables):
        return unknown(NO_TABLE)
    if not math.isfinite(source.seconds):
        return unknown("no simulated calibrations")
    step = next((s for s in (10, 60, FEW_MINUTES_S) if source.seconds < s), math.inf)
    text = f"less than {step} s" if math.isfinite(step) else f"more than {FEW_MINUTES_S} s"
    return decided(f"{text} by paper, one recording", source.seconds < FEW_MINUTES_S)


def _cycle(source: Source) -> Finding:
    """From the start of one sweep to the end of the next: a cycle of 8.3 ms, in which the laser is
    seen from 1.2 to 6.7 ms."""
    if not isinstance(source, PublishedTables):
        return unknown("arithmetic, no data needed")
    cycle, begin, end = 8.3, 1.2, 6.7
    most = cycle + end - begin
    text = f"{cycle} + {end} - {begin} = {most:.1f} ms, {most:.1f} mm at 1 m/s"
    return decided(text, abs(most - 13.8) < 0.05 and 13 <= most <= 14)


CLAIMS: Sequence[Claim[Source]] = (
    Claim(
        "J-IV-time",
        "IV",
        "consecutive measurements are at most 13.8 ms apart, 1.3 cm at 1 m/s",
        "sum of the printed times",
        "13.8 ms; 1.3 to 1.4 cm",
        _cycle,
        "between sweeps of one station, the turn of the other station adds 16.7 ms",
    ),
    Claim(
        "J-IV-full",
        "IV",
        "full interpolation is the most accurate of three ways to complete measurements",
        "median error of the pose by each way, first recording of each simulated setup",
        "the smallest",
        _full_interpolation,
        "by paper-lm, last step: J's simplex would hide the difference",
    ),
    Claim(
        "J-IV-marginal",
        "IV",
        "the difference between the three ways is marginal",
        "largest over smallest median error",
        "below 1.25",
        _marginal,
    ),
    Claim(
        "J-VI-last",
        "VI-F",
        "the last step changes the pose very little",
        "median change of the slave's position in simulated calibrations, in mm, and the error",
        "none: J does not state how little, and the tables of J contain the last stage alone",
        _last_step,
        "as described by J; the settings are not stated",
    ),
    Claim(
        "J-VII-influence",
        "VII, VIII",
        "motion pattern, speed and distance have no noticeable influence",
        "simulated errors against each, in logarithms less the setup's mean; permutations in it",
        f"p above 0.01 / 3 in all; undecided if a factor of {NOTICEABLE:g} in the error would "
        f"not be detected in one (power {POWER:g})",
        _no_influence,
        "by setup, as in J: over calibrations of the same configuration",
    ),
    Claim(
        "J-VII-accuracy",
        "VII",
        "accuracy is better in simulation",
        "mean absolute error: Table I over Table III, six axes",
        "above 1 in all",
        _more_accurate,
    ),
    Claim(
        "J-VII-precision",
        "VII",
        "precision is similar in simulation and reality",
        "average standard deviation: Table II over Table III, six axes",
        "between 1/2 and 2 in all",
        _as_precise,
        "similar in mm; angles scatter two to three times more in reality",
    ),
    Claim(
        "J-VIII-decent",
        "VIII",
        "decent results in every tested configuration",
        "largest mean absolute error of a setup, six axes",
        "none: J does not state what is decent",
        _decent,
    ),
    Claim(
        "J-VIII-minutes",
        "VIII",
        "a calibration takes no longer than a few minutes on a laptop",
        "time from sweeps to pose by J's simplex, first simulated recording, on this machine",
        f"below {FEW_MINUTES_S} s",
        _minutes,
        "J used a laptop of 2018",
    ),
    Claim(
        "J-VIII-parameters",
        "VIII",
        "estimating parameters of the lasers would further improve accuracy",
        "error with ideal optics over that with factory values, between optical frames",
        "above 1",
        _parameters,
    ),
)
