"""Estimator `likelihood`: noise coefficients by maximum likelihood of the periodogram.

Lines are found and subtracted, gaps filled by draws from the model, and the sampled model fitted
to the binned DCT periodogram (`periodogram`, `whittle`); the number of components by BIC (`order`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.estimates import Components, Estimate
from mocap_metrology.noise.fisher import model_of
from mocap_metrology.noise.gaps import bridged, filled, stretches
from mocap_metrology.noise.intervals import coefficients
from mocap_metrology.noise.lines import Line, find_lines, find_slow_lines, line_at
from mocap_metrology.noise.model import ALPHAS
from mocap_metrology.noise.order import choose, fit_known
from mocap_metrology.noise.periodogram import Periodogram, binned, bins_of, joined
from mocap_metrology.noise.whittle import Fit, Likelihood, Spectrum, dictionary

LEAST_SAMPLES = 1000
MOST_MISSING = 0.5
LONGEST_GAP = 1200  # samples filled; a longer gap parts the series into two
MANY_MISSING = 0.002  # share from which on gaps are filled twice, the second time by a better model


@dataclass(frozen=True)
class LikelihoodSettings:
    """criterion: `bic` or `aicc`; max_gauss_markov: 0 ... 4; sinusoid: whether lines are looked
    for; max_lines: how many are taken out (the strongest is the model's sinusoid)."""

    criterion: str = "bic"
    max_gauss_markov: int = 4
    sinusoid: bool = True
    max_lines: int = 8


@dataclass(frozen=True)
class LikelihoodRun:
    """The estimate, the periodogram it was fitted to (lines subtracted), and the lines."""

    estimate: Estimate
    periodogram: Periodogram
    lines: tuple[Line, ...]


def check_series(series: np.ndarray, resolution: float = 0.0) -> None:
    """Refuse what has no noise to estimate, in one line: too short, mostly missing, constant."""
    valid = series[np.isfinite(series)]
    if valid.size < LEAST_SAMPLES:
        raise Refusal(f"{valid.size} valid samples, expected at least {LEAST_SAMPLES}")
    if valid.size < (1 - MOST_MISSING) * series.size:
        share = 100 * (1 - valid.size / series.size)
        raise Refusal(f"{share:.0f} % of the samples are missing, expected at most half")
    span = float(np.ptp(valid))
    if span == 0 or span < 0.5 * resolution:
        hidden = f": the file's resolution ({resolution:.3g}) hides the noise" if resolution else ""
        raise Refusal(f"all samples are equal{hidden}, expected a series with noise")


def likelihood(
    series: np.ndarray,
    tau0: float,
    components: Components | None = None,
    settings: LikelihoodSettings | None = None,
    seed: int = 0,
) -> LikelihoodRun:
    """Fit the sampled noise model to a series (n,), NaN where samples are missing.

    Give the series as recorded, with gross outliers masked: a filter that replaces one sample in
    three hundred of clean noise (Hampel, 3 sigma) lowers h_0 by 3.4 %. tau0: s a frame.
    components: what is fitted; without it, chosen by the criterion of the settings. seed: of the
    draws that fill gaps. Units: those of `NoiseModel`. Raises Refusal (see `check_series`).
    """
    settings = settings or LikelihoodSettings()
    check_series(series)
    parts = [series[s] for s in stretches(series, LONGEST_GAP, LEAST_SAMPLES)]
    if not parts:
        raise Refusal(
            f"no {LEAST_SAMPLES} valid samples without a gap of more than {LONGEST_GAP}, "
            "expected a longer stretch of recording"
        )
    data, fit, lines = _converged(parts, tau0, components, settings, seed)
    line = lines[0] if lines and _wants_line(components, settings) else None
    note = _note(lines[1:] if line else lines)
    found = coefficients(
        data, fit, line, components, settings.max_gauss_markov, _wants_line(components, settings)
    )
    return LikelihoodRun(
        Estimate("likelihood", "sampled", found, fit.deviance, note), data, tuple(lines)
    )


def _wants_line(components: Components | None, settings: LikelihoodSettings) -> bool:
    return components.sinusoid if components else settings.sinusoid


def _converged(
    parts: list[np.ndarray],
    tau0: float,
    components: Components | None,
    settings: LikelihoodSettings,
    seed: int,
) -> tuple[Periodogram, Fit, list[Line]]:
    """Lines, gaps and model in turn; `parts` are the stretches, with NaN in their short gaps."""
    rng = np.random.default_rng(seed)
    most = settings.max_lines if settings.sinusoid or components else 0
    longest = max(parts, key=lambda part: part.size)
    lines = find_lines(bridged(longest), tau0, most)
    bare = [_without(part, lines, tau0, part is longest) for part in parts]
    data, series = _filled(bare, tau0, rng)
    fit = _fitted(data, components, settings)
    at = max(range(len(parts)), key=lambda k: parts[k].size)
    density = _density(fit.spectrum, tau0)
    slow = find_slow_lines(series[at], tau0, density, most - len(lines))
    if slow:
        bare = [_without(part, slow, tau0, k == at) for k, part in enumerate(bare)]
        data, _ = _filled(bare, tau0, rng)
        fit = _fitted(data, components, settings)
    return data, fit, sorted([*lines, *slow], key=lambda line: -line.gain)


def _without(part: np.ndarray, lines: list[Line], tau0: float, theirs: bool) -> np.ndarray:
    """A stretch less the lines: with their phase where they were found, else with its own."""
    for line in lines:
        own = line if theirs else line_at(bridged(part), tau0, line.f_0, line.psd)
        part = part - own.wave(part.size, tau0)
    return part


def _filled(
    parts: list[np.ndarray], tau0: float, rng: np.random.Generator
) -> tuple[Periodogram, list[np.ndarray]]:
    """Periodogram of the stretches with their gaps filled, and the filled stretches."""
    series = [bridged(part) for part in parts]
    missing = [int(np.isnan(part).sum()) for part in parts]
    shares = [1 - gone / part.size for gone, part in zip(missing, parts, strict=True)]
    data = _periodogram(series, shares, tau0)
    rounds = 0 if not any(missing) else 1 if 1 - min(shares) < MANY_MISSING else 2
    for _ in range(rounds):
        # This model only fills gaps: a mixture needs no order
        likelihood = Likelihood(data, _bounds(data))
        density = _density(dictionary(likelihood, ALPHAS), tau0)
        series = [filled(part, density, tau0, rng) for part in parts]
        data = _periodogram(series, shares, tau0)
    return data, series


def _periodogram(series: list[np.ndarray], shares: list[float], tau0: float) -> Periodogram:
    bins = [bins_of(part.size, tau0) for part in series]
    psd = [binned(part, tau0, own) for part, own in zip(series, bins, strict=True)]
    weight = [own.n * share for own, share in zip(bins, shares, strict=True)]
    return Periodogram(joined(bins), np.concatenate(psd), np.concatenate(weight))


def _bounds(data: Periodogram) -> tuple[float, float]:
    """T_c between half a frame and a fifth of the longest stretch: faster is white noise, slower a
    random walk."""
    return data.bins.tau0 / 2, data.bins.span_s / 5


def _density(spectrum: Spectrum, tau0: float) -> Callable[[np.ndarray], np.ndarray]:
    return partial(model_of(spectrum).psd, tau0=tau0)


def _fitted(data: Periodogram, components: Components | None, settings: LikelihoodSettings) -> Fit:
    likelihood = Likelihood(data, _bounds(data))
    if components is None:
        return choose(likelihood, ALPHAS, settings.max_gauss_markov, settings.criterion)
    return fit_known(likelihood, components.alphas, components.gauss_markov)


def _note(further: list[Line]) -> str:
    """Lines beyond the model's one, in words."""
    if not further:
        return ""
    listed = ", ".join(f"{line.f_0:.5g} Hz ({line.A_s:.2g} mm)" for line in further)
    return f"further lines, taken out before the fit: {listed}"
