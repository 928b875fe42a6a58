"""Claims of J IV, VI, VII and VIII, from its tables and from calibrations of twins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from mocap_metrology.lighthouse.assess.influence import influence
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
    Finding,
    Missing,
    Rules,
    decided,
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
from mocap_metrology.present.text.numbers import mm, significant

decides = Rules()
KABSCH = Variant("paper", "kabsch", "ideal")
FINAL = Variant("paper", "final", "ideal")
BETTER = Variant("paper-lm", "final", "ideal")
FACTORY = Variant("paper-lm", "final", "factory")
ALPHA = 0.01 / 3  # of each of three influences
LEAST_CALIBRATIONS = 20  # for a test of influences
# Two standard errors, in logarithms, of a ratio of mean deviations: 8 and 10 setups of 5
SD_ERROR = 2 * math.hypot(1 / math.sqrt(2 * 4 * 8), 1 / math.sqrt(2 * 4 * 10))
CYCLE_MS, SEEN_MS = 8.3, (1.2, 6.7)  # of the laser, and when a diode can see it in a cycle


@dataclass(frozen=True)
class PublishedTables:
    """J's Tables I to III."""

    of_paper: ClassVar[bool] = True

    def table(self, number: int) -> dict[str, np.ndarray]:
        found = published_table(number)
        return {row: np.array([v[q] for q in QUANTITIES]) for row, v in found.items()}


@dataclass(frozen=True)
class Calibrations:
    """Calibrations of group jansen2019. `motion`: how the board of a twin was moved, by
    calibration; `reconstructions`: way -> (n, 2) errors in mm and deg of the same n recordings."""

    records: Sequence[Record]
    motion: Mapping[str, Record] = field(default_factory=dict)
    reconstructions: Mapping[str, np.ndarray] = field(default_factory=dict)
    seconds: float = math.nan  # time of `paper` for one recording, from sweeps to pose
    of_paper: ClassVar[bool] = False

    def table(self, number: int) -> dict[str, np.ndarray]:
        """The same rows, by `paper` at stage Kabsch with ideal optics."""
        setups = simulated(self.records, QUANTISED) if number == 3 else self.real()
        errors = {setup: setup_errors(own, KABSCH) for setup, own in setups.items()}
        mae, sd = ({s: getattr(e, k)() for s, e in errors.items()} for k in ("mae", "sd"))
        if number == 3:
            return {MAE: mean_over(list(mae.values())), AVERAGE_SD: mean_over(list(sd.values()))}
        rows, last = (mae, OVERALL) if number == 1 else (sd, "Average")
        return rows | {last: mean_over(list(rows.values()))}

    def real(self) -> dict[str, list[Record]]:
        return by_setup(self.records, SETUPS)

    def errors_mm(self, variant: Variant, prefix: str = QUANTISED) -> dict[str, np.ndarray]:
        """Error (3,) of each simulated calibration that has the variant."""
        own = [r for group in simulated(self.records, prefix).values() for r in group]
        found = {r["calibration"]: pose_of(r, variant) for r in own}
        return {k: np.asarray(p["errors_mm"], float) for k, p in found.items() if p}

    def medians(self) -> dict[str, np.ndarray]:
        """Median error (2,) by each way of reconstruction."""
        if not self.reconstructions:
            raise Missing("no simulated calibrations")
        return {way: np.median(found, axis=0) for way, found in self.reconstructions.items()}


Source = PublishedTables | Calibrations


def _real_over_simulated(source: Source, number: int, real: str, simulation: str) -> np.ndarray:
    """Row of Table I or II over one of Table III (6,)."""
    rows = source.table(number)[real], source.table(3)[simulation]
    if not np.isfinite(rows).all():
        raise Missing("no calibrations of both kinds")
    ratio: np.ndarray = rows[0] / rows[1]
    return ratio


def _ratios(ratio: np.ndarray) -> str:
    return f"real over simulated: {', '.join(f'{v:.1f}' for v in ratio)}"


@decides("J-VII-accuracy")
def _more_accurate(source: Source) -> Finding:
    ratio = _real_over_simulated(source, 1, OVERALL, MAE)
    return decided(_ratios(ratio), bool((ratio > 1).all()))


@decides("J-VII-precision")
def _as_precise(source: Source, low: float, high: float) -> Finding:
    ratio = _real_over_simulated(source, 2, "Average", AVERAGE_SD)
    words = [within(v, SD_ERROR, math.log(low), math.log(high)) for v in np.log(ratio).tolist()]
    return decided(f"{_ratios(ratio)}, each ± {100 * SD_ERROR:.0f} %", *words)


@decides("J-VIII-decent")
def _decent(source: Source) -> Finding:
    table = source.table(1)
    rows = np.array([table[s] for s in SETUPS if np.isfinite(table[s]).all()])
    if not len(rows):
        raise Missing("no calibrations")
    worst = rows.max(axis=0).tolist()
    lengths = ", ".join(significant(v) for v in worst[:3])
    angles = ", ".join(significant(v, 2) for v in worst[3:])
    return decided(f"worst of {len(rows)} setups {lengths} mm; {angles} deg", UNKNOWN)


@decides("J-VI-last")
def _last_step(source: Calibrations) -> Finding:
    before, after = source.errors_mm(KABSCH), source.errors_mm(FINAL)
    both = sorted(before.keys() & after.keys())
    if not both:
        raise Missing("no calibration with both stages")
    first, last = (np.array([v[k] for k in both]) for v in (before, after))
    a, b, c = (float(np.median(np.linalg.norm(v, axis=1))) for v in (first, last, first - last))
    text = f"changes it by {mm(c)}; error {mm(a)} before, {mm(b)} after"
    return decided(f"{text}, medians of {len(both)}", UNKNOWN)


@decides("J-VII-influence")
def _no_influence(source: Calibrations, noticeable: float, power: float) -> Finding:
    """Pattern, speed and distance against errors within setups; see `influence`. noticeable: a
    factor in the error seen by eye, with five calibrations of each setup."""
    errors = {k: float(np.linalg.norm(v)) for k, v in source.errors_mm(KABSCH).items()}
    setup_of = {record["calibration"]: record["setup"] for record in source.records}
    moved = {k for k, motion in source.motion.items() if motion.get("speed_m_s", 0) > 0}
    known = [k for k, size in errors.items() if k in moved and size > 0]
    if len(known) < LEAST_CALIBRATIONS:
        raise Missing(
            f"{len(known)} simulated calibrations of known motion; {LEAST_CALIBRATIONS} are needed"
        )
    motion = [source.motion[k] for k in known]
    patterns = np.array([m["pattern"] for m in motion])
    circumstances = {
        "pattern": (patterns[:, None] == np.unique(patterns)).astype(float),
        "speed": np.log([[m["speed_m_s"]] for m in motion]),
        "distance": np.log([[np.linalg.norm(m["centre_m"])] for m in motion]),
    }
    size, setups = np.log([errors[k] for k in known]), [setup_of[k] for k in known]
    found = {k: influence(size, v, setups, ALPHA, power) for k, v in circumstances.items()}
    text = "; ".join(
        f"{name}: p = {one.p:.2g}, a factor of {one.detectable:.1f} would be detected"
        if math.isfinite(one.detectable)
        else f"{name}: not varied"
        for name, one in found.items()
    )
    sure = all(one.detectable <= noticeable for one in found.values())
    return decided(text, not any(one.p < ALPHA for one in found.values()), sure or UNKNOWN)


@decides("J-IV-full")
def _full_interpolation(source: Calibrations) -> Finding:
    median = source.medians()
    text = "; ".join(f"{way}: {mm:.2f} mm, {deg:.3f} deg" for way, (mm, deg) in median.items())
    best = min(median, key=lambda way: median[way][0])
    return decided(text, best == "full-interpolation")


@decides("J-IV-marginal")
def _marginal(source: Calibrations, most: float) -> Finding:
    errors_mm = [median[0] for median in source.medians().values()]
    spread = max(errors_mm) / min(errors_mm)
    return decided(f"the worst is {spread:.1f} times the best", bool(spread < most))


@decides("J-VIII-parameters")
def _parameters(source: Calibrations) -> Finding:
    own = [r for group in source.real().values() for r in group]
    pairs = [(pose_of(r, BETTER), pose_of(r, FACTORY)) for r in own]
    ratios = [
        np.linalg.norm(a["truth_errors_mm"]) / np.linalg.norm(b["truth_errors_mm"])
        for a, b in pairs
        if a and b and a.get("truth_errors_mm") and b.get("truth_errors_mm")
    ]
    if not ratios:
        raise Missing("no calibration with both optics and a truth")
    middle = float(np.median(ratios))
    return decided(f"error {middle:.1f} times smaller in the median of {len(ratios)}", middle > 1)


@decides("J-VIII-minutes")
def _minutes(source: Calibrations, most: float) -> Finding:
    """In steps, because it varies from run to run."""
    if not math.isfinite(source.seconds):
        raise Missing("no simulated calibrations")
    step = next((s for s in (10, 60, most) if source.seconds < s), math.inf)
    text = f"less than {step} s" if math.isfinite(step) else f"more than {most} s"
    return decided(f"{text} by paper, one recording", source.seconds < most)


@decides("J-IV-time")
def _cycle(source: Source) -> Finding:
    """From the start of one sweep to the end of the next: a cycle, and the time in which the laser
    is visible."""
    if not source.of_paper:
        raise Missing("arithmetic, no data needed")
    begin, end = SEEN_MS
    most = CYCLE_MS + end - begin
    text = f"{CYCLE_MS} + {end} - {begin} = {most:.1f} ms, {most:.1f} mm at 1 m/s"
    return decided(text, abs(most - 13.8) < 0.05 and 13 <= most <= 14)
