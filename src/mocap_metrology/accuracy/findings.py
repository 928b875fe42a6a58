"""What a bar shows of a system, as codes and numbers."""

from __future__ import annotations

import math
import warnings
from dataclasses import asdict, dataclass

import numpy as np

from mocap_metrology.accuracy.bar import NORMAL, Bar, pass_scatter
from mocap_metrology.accuracy.clusters import ScaleSlope
from mocap_metrology.accuracy.components import FEWEST, repeated
from mocap_metrology.accuracy.effective import effective_number, robust_sd
from mocap_metrology.accuracy.take import Take
from mocap_metrology.common.types import Row

CODES = {  # unit of the value
    "length_bias": "mm",
    "angle_bias": "deg",
    "by_direction": "mm",
    "by_place": "mm",
    "by_speed": "",
    "more_than_still": "",
    "spikes": "",
    "scale_slope": "ppm/m",
}
SPIKE = 6.0  # robust standard deviations of the rest
LEAST_SPIKES, LEAST_SHARE = 3, 1e-4  # frames; share of frames
LEAST_BLOCK = 50  # frames that show a deviation
SPEEDS = 8  # bins of as many frames each
LEAST_SPEED = 20.0  # mm/s, below it the bar stands
CLAIMED = 1.5  # halves of its 95 % interval from which an exponent is a finding
CHANCE = 0.01


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
    if (way := bar.direction) is not None and way.between_lower > 0:
        findings.append(
            Finding("by_direction", "", way.between, way.between_lower, way.between_upper)
        )
    findings += [*_place_findings(bar), *_speed(bar)]
    if still_mm:
        rest = max(one.parts["rest"].value for one in bar.classes)
        findings.append(Finding("more_than_still", "", rest / still_mm))
    findings += _spikes(bar)
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


def _speed(bar: Bar) -> list[Finding]:
    """Exponent of the growth of the rest with speed, over all classes: between the speeds of the
    passes, or of one take's frames."""
    speeds = {take.name: take.speed_mm_s for take in bar.takes}
    slopes = [
        _exponent(rest, speeds[name])
        for one in bar.classes
        for name, rest in zip(one.passes, one.parts.rest, strict=True)
    ]
    slopes = [slope for slope in slopes if math.isfinite(slope[0])]
    if len(slopes) >= FEWEST:
        mean = repeated([slope for slope, _ in slopes])
        value, lower, upper = mean.value, mean.lower, mean.upper
    elif slopes:
        value, error = max(slopes, key=lambda slope: abs(slope[0]) / slope[1])
        lower, upper = value - NORMAL * error, value + NORMAL * error
    else:
        return []
    is_sure = value > CLAIMED * (value - lower)
    return [Finding("by_speed", "", value, lower, upper)] if is_sure else []


def _exponent(rest: np.ndarray, speed: np.ndarray) -> tuple[float, float]:
    """b of robust sd ~ speed^b, and its standard error, from SPEEDS bins of equal frames: the
    logarithm of the sd of n_eff values has the variance 1 / (2 n_eff) (of the MAD 1.36 / n_eff)."""
    known = np.flatnonzero(np.isfinite(rest) & (speed > LEAST_SPEED))
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
