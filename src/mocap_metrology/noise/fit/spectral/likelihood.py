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
from mocap_metrology.noise.fit.spectral import lines as periodic
from mocap_metrology.noise.fit.spectral.detrend import Alternative, alternatives, without_part
from mocap_metrology.noise.fit.spectral.detrend_rows import deterministic_rows
from mocap_metrology.noise.fit.spectral.gaps import bridged, filled, stretches
from mocap_metrology.noise.fit.spectral.intervals import coefficients
from mocap_metrology.noise.fit.spectral.line import Line
from mocap_metrology.noise.fit.spectral.order import choose, fit_known, penalty
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, Stretch, periodogram
from mocap_metrology.noise.fit.spectral.rivals import Rival, judged, undecided
from mocap_metrology.noise.fit.spectral.whittle import (
    Fit,
    Likelihood,
    Spectrum,
    dictionary,
    model_of,
)
from mocap_metrology.noise.model.components import ALPHAS, Form
from mocap_metrology.noise.model.deterministic import Deterministic

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
    if all(np.nanmin(series[cut]) == np.nanmax(series[cut]) for cut in cuts):
        raise Refusal("all samples of each stretch are equal, expected a series with noise")
    starts, rng = [cut.start for cut in cuts], np.random.default_rng(seed)
    search = _Search(starts, frame_rate_hz, components, settings, rng)
    parts, lines = search.converged([series[cut] for cut in cuts])
    data, fit = parts[0].data, parts[0].fit
    wants_line = components.sinusoid if components else settings.sinusoid
    line = lines[0] if lines and wants_line else None
    cost = penalty(settings.criterion, float(data.psd.size))
    most = settings.max_gauss_markov
    near: tuple[Rival, ...] = ()
    if components is None:
        fit, near = judged(parts, ALPHAS, most, cost)
    rows = coefficients(data, fit, line, components, most, wants_line, near, cost)
    if settings.either and fit.spectrum.size:
        rows = _of_either_form(rows, fit, data, line, wants_line)
    if components is None and settings.deterministic:
        rows += deterministic_rows(parts)
    notes = [_lines_note(lines[1:] if line else lines, len(lines) == settings.max_lines)]
    notes.append(undecided(fit, near, cost))
    beyond = Likelihood(data).misfit(fit)
    if beyond > MISFIT:
        notes.append(
            "the model does not describe the spectrum: its deviance is "
            f"{beyond:.0f} standard deviations more than chance explains"
        )
        rows = tuple(_misfit(c, notes[-1]) for c in rows)
    note = "; ".join(filter(None, notes))
    estimate = Estimate("likelihood", settings.form, rows, fit.deviance, note)
    return LikelihoodRun(estimate, data, tuple(lines), tuple(parts))


def _of_either_form(
    rows: tuple[Coefficient, ...], fit: Fit, data: Periodogram, line: Line | None, wants_line: bool
) -> tuple[Coefficient, ...]:
    """Coefficients where frames may be points or averages over the frame period: the mean of both,
    weighted by their likelihoods, with what they differ by in the errors. (An exposure of the whole
    period fitted as points has h_0 1.4 % low beside a correlation time of 0.3 s.)"""
    other: Form = "sampled" if data.bins.form == "continuous" else "continuous"
    anew = replace(data, bins=replace(data.bins, form=other))
    terms = len(fit.spectrum.T_c)
    refitted = fit_known(Likelihood(anew), list(fit.spectrum.h), terms)
    share = 1 / (1 + math.exp(min((refitted.deviance - fit.deviance) / 2, 700.0)))
    known = Components(tuple(fit.spectrum.h), terms, wants_line)
    others = {c.parameter: c for c in coefficients(anew, refitted, line, known, 0, wants_line)}
    return tuple(_between(c, others.get(c.parameter), share) for c in rows)


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


@dataclass(frozen=True)
class _Search:
    """Lines, gaps and model of the stretches of a series, which begin in the frames `starts`."""

    starts: list[int]
    frame_rate_hz: float
    components: Components | None
    settings: LikelihoodSettings
    rng: np.random.Generator

    def converged(self, parts: list[np.ndarray]) -> tuple[list[Alternative], list[Line]]:
        """Deterministic parts with the noise round them, the best first, and the lines; `parts` are
        the stretches, with NaN in their short gaps."""
        rate, settings = self.frame_rate_hz, self.settings
        most = settings.max_lines if settings.sinusoid else 0
        at = max(range(len(parts)), key=lambda k: parts[k].size)
        lines = periodic.find_lines(bridged(parts[at]), rate, most)
        bare = self._without(parts, lines, at)
        data, series = self._filled(bare, lines)
        for _ in range(_rounds(parts[at], LINES_TO) if lines else 0):
            # The first search saw nothing of the lines in the gaps
            lines = _lines_again(series[at], lines, rate)
            del bare, series  # of long recordings each is 300 MB
            bare = self._without(parts, lines, at)
            data, series = self._filled(bare, lines)
        best = self._fitted(data)
        still = series[at] - self.wave(best[0].part.values, at, series[at].size)
        level = self._density(best[0].fit.spectrum)
        slow = periodic.find_slow_lines(still, rate, level, most - len(lines))
        if slow:
            bare = self._without(bare, slow, at)
            data, _ = self._filled(bare, [*lines, *slow])
            best = self._fitted(data)
            # Found against a spectrum that still held them
            level = self._density(best[0].fit.spectrum)
            slow = [replace(s, psd=float(level(np.array([s.f_0]))[0])) for s in slow]
        return best, sorted([*lines, *slow], key=lambda line: -line.gain)

    def wave(self, part: Deterministic, at: int, n: int) -> np.ndarray:
        """The deterministic part in stretch `at` of n samples."""
        return part.at((self.starts[at] + np.arange(n)) * (1 / self.frame_rate_hz))

    def _fitted(self, data: Periodogram) -> list[Alternative]:
        settings, components = self.settings, self.components
        cost = penalty(settings.criterion, float(data.psd.size))

        def fit(data: Periodogram) -> Fit:
            likelihood = Likelihood(data)
            if components is None:
                return choose(likelihood, ALPHAS, settings.max_gauss_markov, settings.criterion)
            return fit_known(likelihood, components.alphas, components.gauss_markov)

        if components is None and settings.deterministic:
            return alternatives(data, fit, cost)
        return [without_part(data, fit(data), cost)]

    def _without(self, parts: list[np.ndarray], lines: list[Line], at: int) -> list[np.ndarray]:
        """The stretches less the lines: `at` with their phase, others each with its own."""
        rate, bare = self.frame_rate_hz, []
        for k, part in enumerate(parts):
            for line in lines:
                here = line if k == at else periodic.line_again(bridged(part), rate, line)
                part = part - here.wave(part.size, rate)
            bare.append(part)
        return bare

    def _filled(
        self, parts: list[np.ndarray], lines: list[Line]
    ) -> tuple[Periodogram, list[np.ndarray]]:
        """Periodogram of the stretches with their gaps filled, without the bands of wide lines, and
        the filled stretches."""
        rate, form = self.frame_rate_hz, self.settings.form
        shares = [float(np.isfinite(part).mean()) for part in parts]
        bands = [periodic.bands_of(lines, part.size * (1 / rate)) for part in parts]

        def spectrum(series: list[np.ndarray]) -> Periodogram:
            whole = map(Stretch, series, shares, self.starts, bands)
            return periodogram(list(whole), rate, form)

        series = [bridged(part) for part in parts]
        data = spectrum(series)
        for _ in range(max(_rounds(part, FILLED_TO) for part in parts)):
            # This model only fills gaps: a mixture needs no order
            density = self._density(dictionary(Likelihood(data), ALPHAS))
            del series
            series = [filled(part, density, rate, self.rng) for part in parts]
            data = spectrum(series)
        return data, series

    def _density(self, spectrum: Spectrum) -> Callable[[np.ndarray], np.ndarray]:
        model = model_of(spectrum, self.settings.form)
        return partial(model.psd, frame_rate_hz=self.frame_rate_hz)


def _lines_again(series: Floats, lines: list[Line], frame_rate_hz: float) -> list[Line]:
    """The lines that were taken out of a complete series, each measured anew without the others."""
    whole = periodic.waves(lines, series.size, frame_rate_hz)
    whole += series
    anew = []
    for one in lines:
        others = periodic.waves([x for x in lines if x is not one], whole.size, frame_rate_hz)
        alone = np.subtract(whole, others, out=others)
        anew.append(periodic.line_again(alone, frame_rate_hz, one))
    return anew


def _rounds(part: np.ndarray, left: float) -> int:
    """How often to fill the gaps: each round leaves the missing share of what the last left."""
    missing = float(np.isnan(part).mean())
    return math.ceil(math.log(left) / math.log(missing)) if missing else 0


def _lines_note(further: list[Line], all_taken: bool) -> str:
    """Lines beyond the model's one, in words."""
    if not further:
        return ""
    named = []
    for line in further[:NAMED]:
        width = f", wanders by {line.width_f:.2g} Hz" if line.wide else ""
        named.append(f"{line.f_0:.5g} Hz ({line.A_s:.2g} mm{width})")
    rest = f" and {len(further) - NAMED} more" if len(further) > NAMED else ""
    end = "; this is the largest number searched for, so there may be others" if all_taken else ""
    return f"further lines, removed before the fit: {', '.join(named)}{rest}{end}"
