"""What a bar shows of a system, as codes and numbers."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from mocap_metrology.accuracy.bar import NORMAL, Bar, pass_scatter
from mocap_metrology.accuracy.clusters import ScaleSlope
from mocap_metrology.accuracy.parts import shifted, surface_terms
from mocap_metrology.accuracy.statistics import FEWEST, effective_number, repeated, robust_sd
from mocap_metrology.accuracy.take import MOVING_MM_S, Take
from mocap_metrology.common.types import Row

CODES = {  # unit of the value
    "length_bias": "mm",
    "angle_bias": "deg",
    "by_direction": "mm",
    "by_pass": "mm",
    "by_place": "mm",
    "by_speed": "",
    "latency": "ms",
    "more_than_still": "",
    "spikes": "",
    "scale_slope": "ppm/m",
}
SPIKE = 6.0  # robust standard deviations of the rest
LEAST_SPIKES, LEAST_SHARE = 3, 1e-4  # frames; share of frames
LEAST_BLOCK = 50  # frames that show a deviation
SPEEDS = 8  # bins of as many frames each
CLAIMED = 1.5  # halves of its 95 % interval from which an exponent or a latency is a finding
CHANCE = 0.01
LEAST_EXPLAINED = 0.05  # of the variance of what remains, by the velocity


@dataclass(frozen=True)
class Finding:
    """One finding in one class of a bar ("" where it is of all); lower, upper: its 95 % interval,
    NaN where there is none."""

    code: str
    series: str
    value: float
    lower_95: float = math.nan
    upper_95: float = math.nan

    @property
    def unit(self) -> str:
        return CODES[self.code]

    def as_dict(self) -> Row:
        """For JSON, as findings of noise."""
        return asdict(self) | {"unit": self.unit}


def findings_of(
    bar: Bar,
    scale: ScaleSlope | None = None,
    still_mm: float | None = None,
    pose_u_deg: float = 0.0,
) -> list[Finding]:
    """All of a bar, in the order of CODES; still_mm: standard deviation of the length at rest;
    pose_u_deg: standard uncertainty of a stated rotation."""
    findings = _bias(bar)
    turned = repeated([take.angle_bias_deg for take in bar.takes])
    least = NORMAL * pose_u_deg + float(np.nan_to_num(turned.upper - turned.value))
    if turned.value > least:  # than the stated rotation, by more than its uncertainty
        ends = turned.value - least, turned.value + least
        findings.append(Finding("angle_bias", "", turned.value, *ends))
    if (way := bar.direction) is not None and way.chance < CHANCE:
        findings.append(
            Finding("by_direction", "", way.between, way.between_lower, way.between_upper)
        )
    findings += [
        Finding("by_pass", one.name, part.value, part.lower, part.upper)
        for one in bar.classes
        for part in [one.parts["pass"]]
        if len(one.passes) >= FEWEST and one.parts.pass_chance < CHANCE
    ]
    late = _latency(bar)
    without = _without_latency(bar, late[0].value) if late else bar
    findings += [*_place_findings(without), *_speed(without), *late]
    if still_mm:
        rest = max(one.parts["rest"].value for one in bar.classes)
        findings.append(Finding("more_than_still", "", rest / still_mm))
    findings += _spikes(without)
    if scale is not None and not scale.lower <= 0 <= scale.upper:
        findings.append(Finding("scale_slope", "", scale.slope, scale.lower, scale.upper))
    return findings


def _spikes(bar: Bar) -> list[Finding]:
    """Classes with LEAST_SPIKES frames or more whose rest is beyond SPIKE robust standard
    deviations of the pass, and of the second around the frame and of those beside: noise that is
    larger in some places, or at some speeds, has no spikes."""
    beyond = {}
    for take in bar.takes:
        rest = _rest_of(bar, take)
        size = max(round(take.frame_rate_hz), LEAST_BLOCK)
        blocks = np.array_split(rest, max(rest.size // size, 1))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of seconds without a frame
            middle = np.array([np.nanmedian(block) for block in blocks])
            sd = np.nan_to_num([robust_sd(block) for block in blocks])
            least = robust_sd(rest)
        sd = np.max([sd, np.append(sd[1:], 0), np.append(0, sd[:-1])], axis=0)
        lengths = [block.size for block in blocks]
        off = np.minimum(np.abs(rest), np.abs(rest - np.repeat(middle, lengths)))
        beyond[take.name] = off > SPIKE * np.repeat(np.maximum(sd, least), lengths)
    counts = [
        (one, sum(int(beyond[name][np.isfinite(rest)].sum())
                  for name, rest in zip(one.passes, one.parts.rest, strict=True)))
        for one in bar.classes
    ]  # fmt: skip
    return [
        Finding("spikes", one.name, count / one.n_frames)
        for one, count in counts
        if count >= max(LEAST_SPIKES, LEAST_SHARE * one.n_frames)
    ]


def _rest_of(bar: Bar, take: Take) -> np.ndarray:
    """(n,) rest of a pass in all classes, NaN where it is in none."""
    whole = np.full(take.length_mm.size, math.nan)
    for one in bar.classes:
        for name, rest in zip(one.passes, one.parts.rest, strict=True):
            if name == take.name:
                whole = np.where(np.isfinite(rest), rest - np.nanmedian(rest), whole)
    return whole


def _bias(bar: Bar) -> list[Finding]:
    """Beyond the uncertainties of mean and certificate together, in quadrature. Of a class of one
    or two passes the mean is at least as uncertain as passes of the others scatter. One of several
    classes is a finding where it is beyond the 95 % of all of them (Bonferroni)."""
    from scipy.special import stdtrit

    if bar.certificate is None:
        return []
    findings, (scatter, dof) = [], pass_scatter(bar.classes)
    every = 1 - 0.025 / len(bar.classes)
    for one in bar.classes:
        mean, k = one.statistics["mean"], len(one.passes)
        half = (mean.upper - mean.lower) / 2
        usual, sure = stdtrit(dof or max(one.n_eff - 1, 1.0), [0.975, every]).tolist()
        of_passes = math.sqrt(scatter / k)
        if k < FEWEST and dof:
            half = max(half, usual * of_passes)
        least = max(half, sure * of_passes) if dof else half * sure / usual
        least = math.hypot(least, NORMAL * bar.certificate.u_mm)
        half = math.hypot(half, NORMAL * bar.certificate.u_mm)
        if abs(mean.value) > least:
            findings.append(
                Finding("length_bias", one.name, mean.value, mean.value - half, mean.value + half)
            )
    return findings


def _place_findings(bar: Bar) -> list[Finding]:
    """Findings for classes whose error depends on the place by more than chance: fewer than CHANCE
    of its shifts in time are explained as well by the place, which explains some of each part that
    it was not fitted to."""
    return [
        Finding("by_place", one.name, part.value, part.lower, part.upper)
        for one in bar.classes
        for part in [one.parts["place"]]
        if part.value > 0 and one.parts.predicts and one.parts.alike < CHANCE
    ]


def _without_latency(bar: Bar, time_ms: float) -> Bar:
    """The classes of a bar less the errors by this time between the ends."""
    errs = {take.name: 1e-3 * time_ms * take.along_mm_s for take in bar.takes}
    classes = [
        replace(one, errors=tuple(e - errs[n] for e, n in zip(one.errors, one.passes, strict=True)))
        for one in bar.classes
    ]
    return replace(bar, classes=tuple(classes))


def _latency(bar: Bar) -> list[Finding]:
    """Time from the measurement of end A to that of end B, in ms, by the velocity of the bar along
    itself: of both ends v, so that the length errs by v times that time. From what the place leaves
    of errors and velocities (Frisch and Waugh 1933), over passes, or of one pass by the effective
    number of its products."""
    velocities = {take.name: take.along_mm_s for take in bar.takes}
    by_pass: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for one in bar.classes:
        for name, rest, terms in zip(
            one.passes, one.parts.rest, surface_terms(one.middles), strict=True
        ):
            known = np.isfinite(rest) & np.isfinite(velocities[name])
            if known.sum() < LEAST_BLOCK:
                continue
            left = np.full((2, rest.size), math.nan)
            of = np.column_stack([np.ones(known.sum()), terms[known]])
            both = np.column_stack([velocities[name][known], rest[known]])
            left[:, known] = (both - of @ np.linalg.lstsq(of, both, rcond=1e-10)[0]).T
            by_pass.setdefault(name, []).append((left[0], left[1]))
    times = []
    for pairs in by_pass.values():
        v, e = (np.concatenate(both) for both in zip(*pairs, strict=True))
        time = float(np.nansum(v * e) / np.nansum(v * v))
        product = v * (e - time * v)
        worth = max(effective_number(product), 1.0)
        error = float(np.nanstd(product)) / math.sqrt(worth) / float(np.nanmean(v * v))
        times.append((time, error, time**2 * float(np.nanvar(v) / np.nanvar(e))))
    if not times:
        return []
    every, errors, shares = (np.array(column) for column in zip(*times, strict=True))
    value = float(every.mean())
    half = NORMAL * float(np.sqrt((errors**2).sum())) / every.size
    if every.size >= FEWEST:
        half = (over := repeated(every)).upper - over.value
    pairs = [pair for of_pass in by_pass.values() for pair in of_pass]
    is_sure = abs(value) > CLAIMED * half and shares.mean() > LEAST_EXPLAINED
    if not is_sure or shifted([v[:, None] for v, _ in pairs], [e for _, e in pairs]) >= CHANCE:
        return []
    return [Finding("latency", "", 1e3 * value, 1e3 * (value - half), 1e3 * (value + half))]


def _speed(bar: Bar) -> list[Finding]:
    """Exponent of the growth of the rest with speed, over all classes: between the speeds of the
    passes, or of one take's frames; none where CHANCE of the shifts of the rest in time, or more,
    is explained as well by the speed."""
    speeds = {take.name: take.speed_mm_s for take in bar.takes}
    pairs = [
        (rest, speeds[name])
        for one in bar.classes
        for name, rest in zip(one.passes, one.parts.rest, strict=True)
    ]
    slopes = [slope for pair in pairs if math.isfinite((slope := _exponent(*pair))[0])]
    if len(slopes) >= FEWEST:
        mean = repeated([slope for slope, _ in slopes])
        value, lower, upper = mean.value, mean.lower, mean.upper
    elif slopes:
        value, error = max(slopes, key=lambda slope: abs(slope[0]) / slope[1])
        lower, upper = value - NORMAL * error, value + NORMAL * error
    else:
        return []
    if value <= CLAIMED * (value - lower) or _at_any_time(pairs) >= CHANCE:
        return []
    return [Finding("by_speed", "", value, lower, upper)]


def _at_any_time(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> float:
    """Share of the shifts in time of the size of the rest, as its logarithm, that the logarithm of
    the speed explains as well."""
    terms, sizes = [], []
    for rest, speed in pairs:
        away = np.abs(rest - np.nanmedian(rest))
        known = np.isfinite(rest) & (speed > MOVING_MM_S) & (away > 0)
        if known.any():
            logs = np.full((2, rest.size), math.nan)
            logs[:, known] = np.log([speed[known], away[known]])
            term, size = logs - np.nanmean(logs, axis=1, keepdims=True)
            terms.append(term[:, None])
            sizes.append(size)
    return shifted(terms, sizes) if sizes else 1.0


def _exponent(rest: np.ndarray, speed: np.ndarray) -> tuple[float, float]:
    """b of robust sd ~ speed^b, and its standard error, from SPEEDS bins of equal frames: the
    logarithm of the sd of n_eff values has the variance 1 / (2 n_eff) (of the MAD 1.36 / n_eff)."""
    known = np.flatnonzero(np.isfinite(rest) & (speed > MOVING_MM_S))
    if known.size < 100 * SPEEDS:
        return math.nan, math.nan
    bins = np.array_split(known[np.argsort(speed[known])], SPEEDS)
    x = np.array([math.log(float(np.median(speed[rows]))) for rows in bins])
    sd = np.array([robust_sd(rest[rows]) for rows in bins])
    if not (sd > 0).all() or np.ptp(x) < math.log(1.5):
        return math.nan, math.nan
    y = np.log(sd)
    centred = x - x.mean()
    slope = float(centred @ y / (centred @ centred))
    worth = max(effective_number(rest**2) / SPEEDS, 1.0)
    left = float(np.sum((y - y.mean() - slope * centred) ** 2)) / (SPEEDS - 2)
    variance = max(1.36 / worth, left) / float(centred @ centred)
    return slope, math.sqrt(variance)
