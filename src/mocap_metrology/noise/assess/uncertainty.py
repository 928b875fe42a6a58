"""Uncertainties of one series: every number of a verdict, from its noise model and from itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from mocap_metrology.noise.assess.mean import MeanOfAll, mean_of_all
from mocap_metrology.noise.assess.measured import Measured, measured_spread, measured_within
from mocap_metrology.noise.assess.spread import (
    Share,
    Spread,
    WithShares,
    expected_spread,
    spread,
    wide_line_error,
)
from mocap_metrology.noise.fit.estimates import NoiseRow, deterministic_of, model_of
from mocap_metrology.noise.fit.spectral.likelihood import LEAST_SAMPLES
from mocap_metrology.noise.gaussian.two_markers import drift
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.model.deterministic import Deterministic

MEANS_S = (1.0, 10.0, 60.0)
LEAST_EDF = 10.0  # degrees of freedom of an Allan deviation that may be the lowest
UNLIKELY = 1e-3  # probability below which a model and its recording do not agree
SURELY = 1.05  # ratio from which frames scatter otherwise, where it is sure
NEAR = 1.25  # ratio of standard deviations up to which they agree: a filter may take a little

# Noise, if any, what lies under it, and `wide_line_error`
Fitted = tuple[NoiseModel | None, Deterministic, float]


class Reason(StrEnum):
    """Why the numbers of a series are measured and not those of a model."""

    NO_SAMPLES = "no_samples"
    TOO_SHORT = "too_short"
    TOO_MANY_GAPS = "too_many_gaps"
    REFUSED = "refused"
    NO_MODEL = "no_model"
    MISFIT = "misfit"
    FRAMES_DISAGREE = "frames_disagree"
    MEANS_DISAGREE = "means_disagree"


@dataclass(frozen=True)
class Unmodelled:
    """Why no model is believed. value, expected: samples that are there and that a model needs
    (`TOO_SHORT`, `TOO_MANY_GAPS`), or scatter in mm as measured and by the model, of single frames
    or of means over `over_s` s; note: of a refused fit."""

    why: Reason
    value: float = math.nan
    expected: float = math.nan
    over_s: float = math.nan
    note: str = ""


@dataclass(frozen=True)
class Mean(WithShares):
    """u(n, N) of `spread` of a mean over duration_s with its interval, mm; measured_mm: of the
    series itself; kinds: of noise, with their shares of u^2; adev_mm: the Allan deviation there."""

    uncertainty_mm: float = math.nan
    lower_mm: float = math.nan
    upper_mm: float = math.nan
    measured_mm: float = math.nan
    kinds: tuple[Share, ...] = ()
    duration_s: float = math.nan
    adev_mm: float = math.nan


@dataclass(frozen=True)
class SeriesNumbers(WithShares):
    """Numbers of one series, as `assess_series` has them, mm; NaN where there is none.

    status: `ok`, `misfit`, `refused`, `no coefficients`, `constant`, `no valid samples`; basis:
    `model`, `measured`, or empty where there is nothing.
    """

    status: str
    basis: str = ""
    unmodelled: Unmodelled | None = None
    sigma_frame_mm: float = math.nan
    sigma_frame_lower_mm: float = math.nan
    sigma_frame_upper_mm: float = math.nan
    sigma_recording_mm: float = math.nan
    frame_mm: float = math.nan
    frame_lower_mm: float = math.nan
    frame_upper_mm: float = math.nan
    adev_min_mm: float = math.nan
    adev_min_lower_mm: float = math.nan
    adev_min_upper_mm: float = math.nan
    tau_min_s: float = math.nan
    adev_still_falls: bool = False
    means: tuple[Mean, ...] = tuple(Mean(duration_s=T) for T in MEANS_S)
    kinds: tuple[Share, ...] = ()
    floor_mm: float = 0.0
    drift_mm_per_h: float = math.nan
    range_mm: float = math.nan
    mean_of_all: MeanOfAll = field(default_factory=MeanOfAll)

    @property
    def frame_upper_end_mm(self) -> float:
        """Upper end of the interval of one frame; the value itself where there is no interval."""
        return self.frame_upper_mm if math.isfinite(self.frame_upper_mm) else self.frame_mm


@dataclass(frozen=True)
class Span:
    """Settings for every series: frame_rate_hz; horizon_s: uncertainties are about the mean of
    so long, or of the recording if it is shorter; window_s: stretch within which the scatter of
    single frames is taken; confidence of all intervals; step_mm: of the stored coordinates;
    mean_mm: expanded uncertainty that is wanted of a mean."""

    frame_rate_hz: float
    horizon_s: float = 3600.0
    window_s: float = 1.0
    confidence: float = 0.683
    step_mm: float = 0.0
    mean_mm: float = 0.01

    def frames(self, seconds: float) -> int:
        """So many seconds in frames, one at least."""
        return max(round(seconds * self.frame_rate_hz), 1)


def assess_series(
    series: np.ndarray, noise_rows: Sequence[NoiseRow], curve: Mapping[str, np.ndarray], span: Span
) -> SeriesNumbers:
    """Numbers of one series of a verdict.

    series: (n,) mm, gross outliers masked, NaN in gaps; noise_rows: of noise.csv, this series by
    `likelihood`; curve: `tau_s`, `adev_mm`, `adev_lower_mm`, `adev_upper_mm`, `edf` of its Allan
    deviations.

    sigma_frame_mm: scatter of single frames about what is near in time: root mean of the variances
    (n - 1) of frames within `window_s`. It holds white noise and what is correlated within the
    window, and none of the slower wander. (ADEV at one frame would lack what is correlated over
    two frames; the standard deviation of the recording, sigma_recording_mm, as S calls sigma,
    depends on its length.)
    frame_mm: uncertainty of one frame, u(1, N) of `spread`: about the mean of the horizon.
    means: u(n, N) of means over 1, 10, 60 s; kinds: of noise, with shares of frame_mm's square.

    `basis` says where they come from: `model`, expected of the fitted noise; or `measured`, from
    the series itself, where there is no model, or it is a misfit, or the series disagrees with it
    (wander it does not hold, as drift). Where frames scatter less than half a step of the file, the
    step's s/sqrt(12) is added in squares: means are no better, as nothing dithers it. Intervals:
    `_widened_spread`. adev_min: `lowest`.
    """
    valid = int(np.isfinite(series).sum())
    if valid < 2:
        return SeriesNumbers("no valid samples", unmodelled=Unmodelled(Reason.NO_SAMPLES))
    status = "constant" if np.nanmin(series) == np.nanmax(series) else _status(noise_rows)
    model = model_of(list(noise_rows)) if status in ("ok", "misfit") else None
    near = measured_within(series, span.frames(span.window_s))
    part = deterministic_of(noise_rows) if model else Deterministic()
    fitted = model, part, wide_line_error(noise_rows)
    reason = _unmodelled(series, fitted, status, near, span)
    if status == "refused":
        reason = _refused(noise_rows, valid, series.size) or reason
    if reason:
        fitted = None, Deterministic(), math.nan
    floor = span.step_mm / math.sqrt(12) if near.value < span.step_mm / 2 else 0.0
    frame = _uncertainty(series, fitted, 1, span, floor)
    moved = drift(series, span.frame_rate_hz)
    sigma, sigma_lower, sigma_upper = _sigma_frame(fitted, near, series.size, span)
    least, still_falls = _minimum(curve)
    return SeriesNumbers(
        status,
        "measured" if fitted[0] is None else "model",
        reason,
        *(sigma, sigma_lower, sigma_upper, float(np.nanstd(series, ddof=1))),
        *(frame.uncertainty_mm, frame.lower_mm, frame.upper_mm),
        *least,
        adev_still_falls=still_falls,
        means=tuple(
            replace(
                _uncertainty(series, fitted, span.frames(T), span, floor),
                duration_s=T,
                adev_mm=_adev_at(curve, T),
            )
            for T in MEANS_S
        ),
        kinds=frame.kinds,
        floor_mm=floor,
        drift_mm_per_h=moved.per_hour,
        range_mm=moved.range,
        mean_of_all=mean_of_all(series, span.frame_rate_hz, *fitted[:2], span.mean_mm),
    )


def _status(rows: Sequence[NoiseRow]) -> str:
    """`ok`, `misfit`, `refused`, or `no coefficients`."""
    statuses = {row["status"] for row in rows}
    if not statuses:
        return "no coefficients"
    return next((s for s in ("refused", "misfit") if s in statuses), "ok")


def _refused(rows: Sequence[NoiseRow], valid: int, recorded: int) -> Unmodelled | None:
    """Why nothing could be fitted; None if the rows give no reason."""
    if valid < LEAST_SAMPLES:
        few = Reason.TOO_SHORT if recorded < LEAST_SAMPLES else Reason.TOO_MANY_GAPS
        return Unmodelled(few, valid, LEAST_SAMPLES)
    notes = (row.get("note") for row in rows if row["status"] == "refused")
    note = next((note for note in notes if isinstance(note, str)), "")
    return Unmodelled(Reason.REFUSED, note=note) if note else None


def _unmodelled(
    series: np.ndarray, fitted: Fitted, status: str, near: Measured, span: Span
) -> Unmodelled | None:
    """Why the model is not believed; None if it is."""
    model, part, _ = fitted
    if status == "misfit":
        return Unmodelled(Reason.MISFIT)
    if model is None or not model.components:
        return Unmodelled(Reason.NO_MODEL)
    rate, n = span.frame_rate_hz, min(span.frames(span.window_s), series.size)
    tau0 = 1 / rate
    N = min(span.frames(span.horizon_s), series.size)
    if n > 1:
        within = sum(spread(c, 1, n, rate, model.form) for c in model.components)
        expected = math.sqrt(within * n / (n - 1))
        low, high = near.interval(1 - UNLIKELY)
        sure = not low <= expected <= high and not 1 / SURELY < near.value / expected < SURELY
        if sure or not 1 / NEAR < near.value / expected < NEAR:
            return Unmodelled(Reason.FRAMES_DISAGREE, near.value, expected)
    if 2 * n > N:
        return None
    wander = measured_spread(series, n, N)
    still = part.variance_of_means(n * tau0, N * tau0, series.size * tau0)
    expected = math.sqrt(sum(spread(c, n, N, rate, model.form) for c in model.components) + still)
    if _contradict(wander, expected, model, (n, N), rate, series.size):
        return Unmodelled(Reason.MEANS_DISAGREE, wander.value, expected, span.window_s)
    return None


def _contradict(
    measured: Measured,
    expected: float,
    model: NoiseModel,
    frames: tuple[int, int],
    frame_rate_hz: float,
    recorded: int,
) -> bool:
    """Whether a measured wander and the model's are apart by more than chance explains.

    Degrees of freedom of N/n means about their mean as the model has them: of the cosine transform,
    whose coefficients at f_k = k / (2 N tau0) are as good as independent.
    """
    from scipy.special import chdtrc

    tau0 = 1 / frame_rate_hz
    n, N = frames
    if not (measured.variance > 0 and expected > 0) or 1 / NEAR < measured.value / expected < NEAR:
        return False
    f = np.arange(1, max(N // n, 2)) / (2 * N * tau0)
    x = np.pi * f * tau0
    power = model.psd(f, frame_rate_hz) * (np.sin(n * x) / (n * np.sin(x))) ** 2
    if not power.sum() > 0:
        return True
    dof = power.sum() ** 2 / np.sum(power**2) * max(recorded / N, 1.0)
    above = float(chdtrc(dof, dof * measured.variance / expected**2))
    return min(above, 1 - above) < UNLIKELY / 2


def _sigma_frame(
    fitted: Fitted, near: Measured, recorded: int, span: Span
) -> tuple[float, float, float]:
    """Scatter of single frames within the window, and its interval."""
    model, _, A_error = fitted
    n = min(span.frames(span.window_s), recorded)
    if model is None or n < 2:
        return near.value, *near.interval(span.confidence)
    of_frame = expected_spread(
        model, 1, n, span.frame_rate_hz, recorded, span.confidence, A_error=A_error
    )
    unbiased = math.sqrt(n / (n - 1))
    return of_frame.value * unbiased, of_frame.lower * unbiased, of_frame.upper * unbiased


def _uncertainty(series: np.ndarray, fitted: Fitted, n: int, span: Span, floor: float) -> Mean:
    """Uncertainty of a mean of n frames: by the model, or measured in the series where there is no
    model."""
    model, part, A_error = fitted
    N = min(span.frames(span.horizon_s), series.size)
    if n > 1 and 2 * n > N:
        return Mean()
    measured = measured_spread(series, n, N)
    if model is None:
        low, high = measured.interval(span.confidence) if measured.variance > 0 else (0.0, 0.0)
        of_noise = Spread(measured.value, low, high, ())
    else:
        recorded = int(np.isfinite(series).sum())
        of_noise = expected_spread(
            model, n, N, span.frame_rate_hz, recorded, span.confidence, part, A_error
        )
        of_noise = _widened_spread(of_noise, measured, span.confidence)
    ends = of_noise.value, of_noise.lower, of_noise.upper
    value, low, high = (math.hypot(end, floor) for end in ends)
    return Mean(value, low, high, measured.value, of_noise.kinds)


def _widened_spread(of_noise: Spread, measured: Measured, confidence: float) -> Spread:
    """Expected of a model, its interval widened to hold the measured one as well.

    The model's interval is of the coefficients of the components that BIC chose: wander it did not
    detect, or took for another kind, is not in it. The measured one knows of no components, but is
    right on average only, of few degrees of freedom for slow wander. With N the whole recording of
    2 or 10 min, 68 % intervals of the model alone held the truth in 0 to 69 % (0 for a T_c of 100 s
    in 10 min), these in 63 to 96 %; 95 % ones in 0 to 95 % and in 88 to 100 % (eight kinds of
    noise, 200 or 60 recordings each; tests/noise/assess/test_coverage.py has some of them).
    """
    if not measured.variance > 0:
        return of_noise
    low, high = measured.interval(confidence)
    return replace(of_noise, lower=min(of_noise.lower, low), upper=max(of_noise.upper, high))


def _adev_at(curve: Mapping[str, np.ndarray], tau_s: float) -> float:
    """Allan deviation at tau, between two computed ones on a double logarithmic scale."""
    tau, adev = np.asarray(curve["tau_s"]), np.asarray(curve["adev_mm"])
    keep = adev > 0
    tau, adev = tau[keep], adev[keep]
    if not tau.size or not tau[0] * 0.999 <= tau_s <= tau[-1] * 1.001:
        return math.nan
    return float(np.exp(np.interp(math.log(tau_s), np.log(tau), np.log(adev))))


def _minimum(curve: Mapping[str, np.ndarray]) -> tuple[tuple[float, float, float, float], bool]:
    """The lowest Allan deviation, its interval and its tau; whether the curve still falls."""
    k, falls = lowest(np.asarray(curve["adev_mm"]), np.asarray(curve["edf"]))
    if k is None:
        return (math.nan, math.nan, math.nan, math.nan), falls
    adev, low, high = (float(curve[c][k]) for c in ("adev_mm", "adev_lower_mm", "adev_upper_mm"))
    return (adev, low, high, float(curve["tau_s"][k])), falls


def lowest(adev: np.ndarray, edf: np.ndarray) -> tuple[int | None, bool]:
    """Place of the lowest deviation, and whether the curve still falls there; None without any.

    adev, edf: (k,) deviations and their equivalent degrees of freedom, tau rising. Only points of
    LEAST_EDF or more count (if there are none, that of most): the least of many uncertain points is
    low by chance. (Of white and flicker noise in two minutes, 12000 frames, the lowest of all
    points was 0.63 of the true one in the median, that of these 0.89.) The curve still falls
    where the lowest is the last that counts.
    """
    known = np.flatnonzero(np.isfinite(adev) & np.isfinite(edf))
    if not known.size:
        return None, False
    least = min(LEAST_EDF, float(edf[known].max()))
    counts = known[edf[known] >= least]
    best = int(counts[adev[counts].argmin()])
    return best, best == int(counts[-1])
