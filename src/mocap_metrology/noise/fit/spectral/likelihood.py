"""Estimator `likelihood`: noise coefficients by maximum likelihood of the periodogram.

Lines are found and subtracted, gaps filled by draws from the model, and the noise model fitted
to the binned DCT periodogram (`periodogram`, `whittle`); the number of components by BIC (`order`),
and so whether a straight line or a warm-up lies under the noise (`detrend`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.fit.estimates import Z_95, Coefficient, Components, Estimate
from mocap_metrology.noise.fit.spectral.detrend import Alternative, alternatives, without_part
from mocap_metrology.noise.fit.spectral.detrend_rows import deterministic_rows
from mocap_metrology.noise.fit.spectral.fisher import model_of
from mocap_metrology.noise.fit.spectral.gaps import bridged, filled, stretches
from mocap_metrology.noise.fit.spectral.intervals import coefficients
from mocap_metrology.noise.fit.spectral.lines import (
    Line,
    bands_of,
    find_lines,
    find_slow_lines,
    line_again,
    waves,
)
from mocap_metrology.noise.fit.spectral.order import choose, fit_known, penalty
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, periodogram
from mocap_metrology.noise.fit.spectral.rivals import Rival, judged, undecided
from mocap_metrology.noise.fit.spectral.whittle import Fit, Likelihood, Spectrum, dictionary
from mocap_metrology.noise.model.components import ALPHAS, Form

LEAST_SAMPLES = 1000
NAMED = 8  # of the lines found, in a note
MOST_MISSING = 0.5
LEAST_SPAN = 1e-20  # mm; squares of spectra must be numbers
LONGEST_GAP = 1200  # samples filled; a longer gap parts the series into two
FILLED_TO = 3e-4  # share of its power that the first guess for the gaps may leave its mark on
LINES_TO = 1e-3  # the same of a line's amplitude
MISFIT = 5.0  # standard deviations of the deviance beyond which the model does not describe it


@dataclass(frozen=True)
class LikelihoodSettings:
    """criterion: `bic` or `aicc`; max_gauss_markov: 0 ... 4; sinusoid: whether lines are looked
    for; max_lines: how many are taken out (the one that raises the likelihood most is the model's
    sinusoid); deterministic: whether a line or a warm-up is looked for (not where the components
    are given); form: of the frames, points or averages over the frame period (`model`); either:
    the frames may be of the other form, too, as the exposure is not known (`_of_either_form`)."""

    criterion: str = "bic"
    max_gauss_markov: int = 4
    sinusoid: bool = True
    max_lines: int = 40
    deterministic: bool = True
    form: Form = "sampled"
    either: bool = False


@dataclass(frozen=True)
class LikelihoodRun:
    """The estimate, the periodogram it was fitted to (lines and deterministic part subtracted), the
    lines, and the deterministic parts that were compared, the best first."""

    estimate: Estimate
    periodogram: Periodogram
    lines: tuple[Line, ...]
    alternatives: tuple[Alternative, ...] = ()


def check_series(series: np.ndarray, resolution: float = 0.0) -> None:
    """Refuse what has no noise to estimate, in one line: too short, mostly missing, constant."""
    finite = np.isfinite(series)
    valid = series if finite.all() else series[finite]
    if valid.size < LEAST_SAMPLES:
        raise Refusal(f"{valid.size} valid samples, expected at least {LEAST_SAMPLES}")
    if valid.size < (1 - MOST_MISSING) * series.size:
        share = 100 * (1 - valid.size / series.size)
        raise Refusal(f"{share:.1f} % of the samples are missing, expected at most half")
    span = float(np.ptp(valid))
    if not LEAST_SPAN < span < 1 / LEAST_SPAN and span != 0:
        raise Refusal(f"samples span {span:.3g} mm, expected millimetres")
    if span == 0 or span < 0.5 * resolution:
        hidden = f": the file's resolution ({resolution:.3g}) hides the noise" if resolution else ""
        raise Refusal(f"all samples are equal{hidden}, expected a series with noise")


def likelihood(
    series: np.ndarray,
    frame_rate_hz: float,
    components: Components | None = None,
    settings: LikelihoodSettings | None = None,
    seed: int = 0,
) -> LikelihoodRun:
    """Fit the noise model to a series (n,), NaN where samples are missing.

    Give the series as recorded, with gross outliers masked: a filter that replaces one sample in
    three hundred of clean noise (Hampel, 3 sigma) lowers h_0 by 3.4 %.
    components: what is fitted; without it, chosen by the criterion of the settings. seed: of the
    draws that fill gaps. Units: those of `NoiseModel`. Raises Refusal (see `check_series`).
    """
    settings = settings or LikelihoodSettings()
    check_series(series)
    cuts = stretches(series, LONGEST_GAP, LEAST_SAMPLES)
    if not cuts:
        raise Refusal(
            f"no {LEAST_SAMPLES} valid samples without a gap of more than {LONGEST_GAP}, "
            "expected a longer stretch of recording"
        )
    asked = _Asked([cut.start for cut in cuts], frame_rate_hz, components, settings)
    found_parts, lines = _converged([series[cut] for cut in cuts], asked, seed)
    best = found_parts[0]
    data, fit = best.data, best.fit
    line = lines[0] if lines and _wants_line(components, settings) else None
    cost = penalty(settings.criterion, float(data.psd.size))
    most = settings.max_gauss_markov
    near: tuple[Rival, ...] = ()
    if components is None:
        fit, near = judged(found_parts, ALPHAS, most, cost)
    wants_line = _wants_line(components, settings)
    found = coefficients(data, fit, line, components, most, wants_line, near, cost)
    if settings.either and fit.spectrum.size:
        found = _of_either_form(found, fit, data, line, most, wants_line)
    if components is None and settings.deterministic:
        found += deterministic_rows(found_parts, frame_rate_hz)
    beyond = Likelihood(data, data.bins.T_c_range).misfit(fit)
    notes = [_lines_note(lines[1:] if line else lines, len(lines) == settings.max_lines)]
    notes.append(undecided(fit, near, cost))
    if beyond > MISFIT:
        notes.append(
            "the model does not describe the spectrum: its deviance is "
            f"{beyond:.0f} standard deviations more than chance explains"
        )
        found = tuple(_misfit(c, notes[-1]) for c in found)
    note = "; ".join(filter(None, notes))
    return LikelihoodRun(
        Estimate("likelihood", settings.form, found, fit.deviance, note),
        data,
        tuple(lines),
        tuple(found_parts),
    )


def _of_either_form(
    found: tuple[Coefficient, ...],
    fit: Fit,
    data: Periodogram,
    line: Line | None,
    most: int,
    wants_line: bool,
) -> tuple[Coefficient, ...]:
    """Coefficients where frames may be points or averages over the frame period: the mean of both,
    weighted by their likelihoods, with what they differ by in the errors. (An exposure of the whole
    period fitted as points has h_0 1.4 % low beside a correlation time of 0.3 s.)"""
    other: Form = "sampled" if data.bins.form == "continuous" else "continuous"
    anew = replace(data, bins=replace(data.bins, form=other))
    second = Likelihood(anew, anew.bins.T_c_range)
    refitted = fit_known(second, list(fit.spectrum.h), len(fit.spectrum.T_c))
    share = 1 / (1 + math.exp(min((refitted.deviance - fit.deviance) / 2, 700.0)))
    asked = Components(tuple(fit.spectrum.h), len(fit.spectrum.T_c), wants_line)
    others = {c.parameter: c for c in coefficients(anew, refitted, line, asked, most, wants_line)}
    return tuple(_between(c, others.get(c.parameter), share) for c in found)


def _between(c: Coefficient, other: Coefficient | None, share: float) -> Coefficient:
    """c, and the other with this share."""
    if other is None or c.status != "ok" or other.status != "ok" or not c.value > 0:
        return c
    off = other.value - c.value
    apart = math.sqrt(share * (1 - share)) * abs(off)
    error = math.sqrt((1 - share) * c.std_error**2 + share * other.std_error**2 + apart**2)
    middle = c.value + share * off
    ends = {}
    for level, z in ((68, 1.0), (95, Z_95)):
        low, high = getattr(c, f"lower_{level}"), getattr(c, f"upper_{level}")
        ends[f"lower_{level}"] = max(middle - math.hypot(c.value - low, z * apart), min(low, 0.0))
        ends[f"upper_{level}"] = middle + math.hypot(high - c.value, z * apart)
    return replace(c, value=middle, std_error=error, **ends)


def _misfit(c: Coefficient, why: str) -> Coefficient:
    """A coefficient of a model that does not describe the data: its status, and no limit."""
    if c.status == "not_detected":
        return replace(c, upper_95=np.nan)
    return replace(c, note=why, status="misfit" if c.status == "ok" else c.status)


def _wants_line(components: Components | None, settings: LikelihoodSettings) -> bool:
    return components.sinusoid if components else settings.sinusoid


@dataclass(frozen=True)
class _Asked:
    """starts: first frames of the stretches; what is fitted, and how."""

    starts: list[int]
    frame_rate_hz: float
    components: Components | None
    settings: LikelihoodSettings

    def fitted(self, data: Periodogram) -> list[Alternative]:
        """Deterministic parts with the noise round them, the best first."""
        cost = penalty(self.settings.criterion, float(data.psd.size))
        choice = partial(_fitted, components=self.components, settings=self.settings)
        if self.components is None and self.settings.deterministic:
            return alternatives(data, choice, cost)
        return [without_part(data, choice(data), cost)]

    def wave(self, best: Alternative, at: int, n: int) -> np.ndarray:
        """The deterministic part in stretch `at` of n samples."""
        tau0 = 1 / self.frame_rate_hz
        return best.part.values.at((self.starts[at] + np.arange(n)) * tau0)


def _converged(
    parts: list[np.ndarray], asked: _Asked, seed: int
) -> tuple[list[Alternative], list[Line]]:
    """Lines, gaps and model in turn; `parts` are the stretches, with NaN in their short gaps."""
    rng, rate, settings = np.random.default_rng(seed), asked.frame_rate_hz, asked.settings
    most = settings.max_lines if settings.sinusoid else 0
    at = max(range(len(parts)), key=lambda k: parts[k].size)
    lines = find_lines(bridged(parts[at]), rate, most)
    bare = _without(parts, lines, rate, at)
    data, series = _filled(bare, asked, rng, lines)
    for _ in range(_rounds(parts[at], LINES_TO) if lines else 0):
        # The first search saw nothing of the lines in the gaps
        lines = _again(series[at], lines, rate)
        del bare, series  # of long recordings each is 300 MB
        bare = _without(parts, lines, rate, at)
        data, series = _filled(bare, asked, rng, lines)
    found = asked.fitted(data)
    still = series[at] - asked.wave(found[0], at, series[at].size)
    level = _density(found[0].fit.spectrum, rate, settings.form)
    slow = find_slow_lines(still, rate, level, most - len(lines))
    if slow:
        bare = _without(bare, slow, rate, at)
        data, _ = _filled(bare, asked, rng, [*lines, *slow])
        found = asked.fitted(data)
        # Found against a spectrum that still held them
        level = _density(found[0].fit.spectrum, rate, settings.form)
        slow = [replace(s, psd=float(level(np.array([s.f_0]))[0])) for s in slow]
    return found, sorted([*lines, *slow], key=lambda line: -line.gain)


def _without(
    parts: list[np.ndarray], lines: list[Line], frame_rate_hz: float, at: int
) -> list[np.ndarray]:
    """The stretches less the lines: stretch `at` with their phase, others each with its own."""
    bare = []
    for k, part in enumerate(parts):
        for line in lines:
            own = line if k == at else line_again(bridged(part), frame_rate_hz, line)
            part = part - own.wave(part.size, frame_rate_hz)
        bare.append(part)
    return bare


def _again(series: Floats, lines: list[Line], frame_rate_hz: float) -> list[Line]:
    """The lines that were taken out of a complete series, each measured anew without the others."""
    whole = waves(lines, series.size, frame_rate_hz)
    whole += series

    def alone(one: Line) -> Floats:
        others = waves([x for x in lines if x is not one], whole.size, frame_rate_hz)
        return np.subtract(whole, others, out=others)

    return [line_again(alone(one), frame_rate_hz, one) for one in lines]


def _rounds(part: np.ndarray, left: float) -> int:
    """How often to fill the gaps: each round leaves the missing share of what the last left."""
    missing = float(np.isnan(part).mean())
    return math.ceil(math.log(left) / math.log(missing)) if missing else 0


def _filled(
    parts: list[np.ndarray], asked: _Asked, rng: np.random.Generator, lines: list[Line]
) -> tuple[Periodogram, list[np.ndarray]]:
    """Periodogram of the stretches with their gaps filled, without the bands of wide lines, and the
    filled stretches."""
    series = [bridged(part) for part in parts]
    shares = [float(np.isfinite(part).mean()) for part in parts]
    tau0 = 1 / asked.frame_rate_hz
    bands = [bands_of(lines, part.size * tau0) for part in parts]
    form = asked.settings.form
    data = periodogram(series, shares, asked.starts, asked.frame_rate_hz, bands, form)
    for _ in range(max(_rounds(part, FILLED_TO) for part in parts)):
        # This model only fills gaps: a mixture needs no order
        likelihood = Likelihood(data, data.bins.T_c_range)
        density = _density(dictionary(likelihood, ALPHAS), asked.frame_rate_hz, form)
        del series
        series = [filled(part, density, asked.frame_rate_hz, rng) for part in parts]
        data = periodogram(series, shares, asked.starts, asked.frame_rate_hz, bands, form)
    return data, series


def _density(
    spectrum: Spectrum, frame_rate_hz: float, form: Form
) -> Callable[[np.ndarray], np.ndarray]:
    return partial(model_of(spectrum, form).psd, frame_rate_hz=frame_rate_hz)


def _fitted(data: Periodogram, components: Components | None, settings: LikelihoodSettings) -> Fit:
    likelihood = Likelihood(data, data.bins.T_c_range)
    if components is None:
        return choose(likelihood, ALPHAS, settings.max_gauss_markov, settings.criterion)
    return fit_known(likelihood, components.alphas, components.gauss_markov)


def _lines_note(further: list[Line], all_taken: bool) -> str:
    """Lines beyond the model's one, in words."""
    if not further:
        return ""
    listed = ", ".join(_named(line) for line in further[:NAMED])
    rest = f" and {len(further) - NAMED} more" if len(further) > NAMED else ""
    said = "; this is the largest number searched for, so there may be others" if all_taken else ""
    return f"further lines, removed before the fit: {listed}{rest}{said}"


def _named(line: Line) -> str:
    """`49.98 Hz (0.015 mm)`, or `49.98 Hz (0.015 mm, wanders by 0.02 Hz)`."""
    width = f", wanders by {line.width_f:.2g} Hz" if line.wide else ""
    return f"{line.f_0:.5g} Hz ({line.A_s:.2g} mm{width})"
