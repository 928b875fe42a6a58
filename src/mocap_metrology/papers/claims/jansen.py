"""Claims of J IV, VI, VII and VIII, from its tables and from calibrations of twins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse import published as printed
from mocap_metrology.lighthouse.assess.influence import influence
from mocap_metrology.papers import jansen
from mocap_metrology.papers.claims.decide import UNKNOWN, Answer, Missing, Quantity, decides, within

KABSCH = jansen.Variant("paper", "kabsch", "ideal")
FINAL = jansen.Variant("paper", "final", "ideal")
BETTER = jansen.Variant("paper-lm", "final", "ideal")
FACTORY = jansen.Variant("paper-lm", "final", "factory")
ALPHA = 0.01 / 3  # of each of three influences
LEAST_CALIBRATIONS = 20  # for a test of influences
# Two standard errors, in logarithms, of a ratio of mean deviations: 8 and 10 setups of 5
SD_ERROR = 2 * math.hypot(1 / math.sqrt(2 * 4 * 8), 1 / math.sqrt(2 * 4 * 10))
CYCLE_MS, SEEN_MS = 8.3, (1.2, 6.7)  # of the laser, and when a diode can see it in a cycle


class PublishedTables:
    """J's Tables I to III."""

    def table(self, number: int) -> dict[str, np.ndarray]:
        """Row (6,) in the order of `QUANTITIES`, by setup or summary."""
        rows = printed.published_table(number).items()
        return {name: np.array([values[q] for q in printed.QUANTITIES]) for name, values in rows}


@dataclass(frozen=True)
class Calibrations:
    """Calibrations of group jansen2019. `motion`: how the board of a twin was moved, by
    calibration; `reconstructions`: way -> (n, 2) errors in mm and deg of the same n recordings."""

    records: Sequence[Record]
    motion: Mapping[str, Record] = field(default_factory=dict)
    reconstructions: Mapping[str, np.ndarray] = field(default_factory=dict)
    seconds: float = math.nan  # time of `paper` for one recording, from sweeps to pose

    def table(self, number: int) -> dict[str, np.ndarray]:
        """The same rows, by `paper` at stage Kabsch with ideal optics."""
        real = jansen.by_setup(self.records)
        setups = jansen.simulated(self.records, jansen.QUANTISED) if number == 3 else real
        errors = {setup: jansen.setup_errors(of_it, KABSCH) for setup, of_it in setups.items()}
        mae, sd = {s: e.mae() for s, e in errors.items()}, {s: e.sd() for s, e in errors.items()}
        if number == 3:
            means = jansen.mean_over(mae.values()), jansen.mean_over(sd.values())
            return dict(zip((printed.MAE, printed.AVERAGE_SD), means, strict=True))
        rows = mae if number == 1 else sd
        return rows | {jansen.LAST[number]: jansen.mean_over(rows.values())}

    def errors_mm(self, variant: jansen.Variant) -> dict[str, np.ndarray]:
        """Error (3,) of each simulated calibration that has the variant."""
        setups = jansen.simulated(self.records, jansen.QUANTISED).values()
        poses = {r["calibration"]: jansen.pose_of(r, variant) for of_it in setups for r in of_it}
        return {k: np.asarray(p["errors_mm"], float) for k, p in poses.items() if p}

    def medians(self) -> dict[str, np.ndarray]:
        """Median error (2,) by each way of reconstruction."""
        if not self.reconstructions:
            raise Missing("no simulated calibrations")
        return {way: np.median(errors, axis=0) for way, errors in self.reconstructions.items()}


Source = PublishedTables | Calibrations


def _real_over_simulated(source: Source, number: int, real: str, simulation: str) -> np.ndarray:
    """Row of Table I or II over one of Table III (6,)."""
    rows = source.table(number)[real], source.table(3)[simulation]
    if not np.isfinite(rows).all():
        raise Missing("no calibrations of both kinds")
    return np.asarray(rows[0] / rows[1])


def _ratios(ratio: np.ndarray) -> str:
    return f"real over simulated: {', '.join(f'{v:.1f}' for v in ratio)}"


@decides("J-VII-accuracy")
def _more_accurate(source: Source) -> Answer:
    ratio = _real_over_simulated(source, 1, printed.OVERALL, printed.MAE)
    return _ratios(ratio), (ratio > 1).all()


@decides("J-VII-precision")
def _as_precise(source: Source, low: float, high: float) -> Answer:
    ratio = _real_over_simulated(source, 2, jansen.LAST[2], printed.AVERAGE_SD)
    words = [within(v, SD_ERROR, math.log(low), math.log(high)) for v in np.log(ratio).tolist()]
    return f"{_ratios(ratio)}, each ± {100 * SD_ERROR:.0f} %", *words


@decides("J-VIII-decent")
def _decent(source: Source) -> Answer:
    table = source.table(1)
    rows = np.array([table[s] for s in printed.SETUPS if np.isfinite(table[s]).all()])
    if not len(rows):
        raise Missing("no calibrations")
    x, y, z, *angles = rows.max(axis=0).tolist()
    text: list[str | Quantity] = [f"worst of {len(rows)} setups "]
    for value, digits, end in (
        *((x, 3, ", "), (y, 3, ", "), (z, 3, " mm; ")),
        *zip(angles, (2, 2, 2), (", ", ", ", " deg"), strict=True),
    ):
        text += [Quantity(value, digits), end]
    return tuple(text), UNKNOWN


@decides("J-VI-last")
def _last_step(source: Calibrations) -> Answer:
    before, after = source.errors_mm(KABSCH), source.errors_mm(FINAL)
    both = sorted(before.keys() & after.keys())
    if not both:
        raise Missing("no calibration with both stages")
    first, last = (np.array([v[k] for k in both]) for v in (before, after))
    a, b, c = (
        Quantity(float(np.median(np.linalg.norm(v, axis=1))), 3, "mm")
        for v in (first, last, first - last)
    )
    text = ("changes it by ", c, "; error ", a, " before, ", b, " after")
    return (*text, f", medians of {len(both)}"), UNKNOWN


@decides("J-VII-influence")
def _no_influence(source: Calibrations, noticeable: float, power: float) -> Answer:
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
    tests = {k: influence(size, v, setups, ALPHA, power) for k, v in circumstances.items()}
    text = "; ".join(
        f"{name}: p = {one.p:.2g}, a factor of {one.detectable:.1f} would be detected"
        if math.isfinite(one.detectable)
        else f"{name}: not varied"
        for name, one in tests.items()
    )
    sure = all(one.detectable <= noticeable for one in tests.values())
    return text, not any(one.p < ALPHA for one in tests.values()), sure or UNKNOWN


@decides("J-IV-full")
def _full_interpolation(source: Calibrations) -> Answer:
    median = source.medians()
    text = "; ".join(f"{way}: {mm:.2f} mm, {deg:.3f} deg" for way, (mm, deg) in median.items())
    return text, min(median, key=lambda way: median[way][0]) == "full-interpolation"


@decides("J-IV-marginal")
def _marginal(source: Calibrations, most: float) -> Answer:
    errors_mm = [median[0] for median in source.medians().values()]
    spread = max(errors_mm) / min(errors_mm)
    return f"the worst is {spread:.1f} times the best", spread < most


@decides("J-VIII-parameters")
def _parameters(source: Calibrations) -> Answer:
    records = [r for of_it in jansen.by_setup(source.records).values() for r in of_it]
    pairs = [(jansen.pose_of(r, BETTER), jansen.pose_of(r, FACTORY)) for r in records]
    ratios = [
        np.linalg.norm(a["truth_errors_mm"]) / np.linalg.norm(b["truth_errors_mm"])
        for a, b in pairs
        if a and b and a.get("truth_errors_mm") and b.get("truth_errors_mm")
    ]
    if not ratios:
        raise Missing("no calibration with both optics and a truth")
    middle = float(np.median(ratios))
    return f"error {middle:.1f} times smaller in the median of {len(ratios)}", middle > 1


@decides("J-VIII-minutes")
def _minutes(source: Calibrations, most: float) -> Answer:
    """Whether a calibration takes less than `most` seconds; the answer is in steps, because times
    vary from run to run."""
    if not math.isfinite(source.seconds):
        raise Missing("no simulated calibrations")
    step = next((s for s in (10, 60, most) if source.seconds < s), math.inf)
    text = f"less than {step} s" if math.isfinite(step) else f"more than {most} s"
    return f"{text} by paper, one recording", source.seconds < most


@decides("J-IV-time")
def _cycle(source: Source) -> Answer:
    """From the start of one sweep to the end of the next: a cycle, and the time in which the laser
    is visible."""
    if isinstance(source, Calibrations):
        raise Missing("arithmetic, no data needed")
    begin, end = SEEN_MS
    most = CYCLE_MS + end - begin
    text = f"{CYCLE_MS} + {end} - {begin} = {most:.1f} ms, {most:.1f} mm at 1 m/s"
    return text, abs(most - 13.8) < 0.05 and 13 <= most <= 14
