"""Every estimator of noise coefficients on one series, beside the published row.

`likelihood` gets the series as recorded with gross outliers masked; S's estimator and its baselines
get the Allan variances of the series cleaned as in S.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import hampel, mask_half_window, own_step
from mocap_metrology.noise.allan.confidence import AllanCurve, allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.fit.allan import annealing
from mocap_metrology.noise.fit.allan.baselines import levenberg_marquardt, slopes
from mocap_metrology.noise.fit.estimates import (
    PLAIN_ESTIMATOR,
    S_ESTIMATOR,
    Coefficient,
    Components,
    Estimate,
)
from mocap_metrology.noise.fit.spectral import likelihood as spectral
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram
from mocap_metrology.noise.fit.spectral.whittle import crlb
from mocap_metrology.noise.model.components import Form, NoiseModel
from mocap_metrology.noise.twins.published import printed_row, published_keys
from mocap_metrology.settings import Allan, Annealing, Noise, Settings


@dataclass(frozen=True)
class NoiseSettings:
    """noise, allan, annealing, seed: of the configuration; half_window: of the Hampel filter that
    masks gross outliers (samples to each side); frames: form of the recording's, for `likelihood`,
    None where the exposure is not known; subset: type and number of cameras whose panel of Tables
    A1-A3 the estimators of S fit."""

    noise: Noise = field(default_factory=Noise)
    allan: Allan = field(default_factory=Allan)
    annealing: Annealing = field(default_factory=Annealing)
    half_window: int = 120
    frames: Form | None = "sampled"
    seed: int = 0
    subset: tuple[str, int] | None = None

    @classmethod
    def of(
        cls,
        settings: Settings,
        frame_rate_hz: float,
        frames: Form | None = "sampled",
        subset: tuple[str, int] | None = None,
    ) -> NoiseSettings:
        """Out of the configuration; frames: of the recording, `form` in its metadata where it has
        one."""
        half_window = mask_half_window(settings.hampel.half_window_s, frame_rate_hz)
        sections = settings.noise, settings.allan, settings.annealing
        return cls(*sections, half_window, frames, settings.seed, subset)

    def components(self, series: str = "") -> Components:
        """What S's estimators fit: the series' panel, where the paper prints one."""
        printed = panel(*self.subset, series) if self.subset else None
        noise = self.noise
        return printed or Components(gauss_markov=noise.gauss_markov, sinusoid=noise.sinusoid)

    def averaging_factors(self, n: int) -> np.ndarray:
        """Averaging factors m of the Allan variances of n samples."""
        allan = self.allan
        return averaging_factors(n, allan.n_taus, allan.min_m, allan.max_fraction)


@dataclass(frozen=True)
class SeriesNoise:
    """estimates: in the order requested; curve: Allan variances of the masked series; periodogram:
    what the likelihood was fitted to (None if it was not); refused: estimator -> why."""

    estimates: tuple[Estimate, ...]
    curve: AllanCurve
    periodogram: Periodogram | None
    refused: dict[str, str]


def panel(camera_type: str, n_cameras: int, series: str) -> Components | None:
    """Components of the panel of Tables A1-A3 that the series has, None if there is none."""
    if (camera_type, n_cameras) not in published_keys():
        return None
    printed = printed_row(camera_type, n_cameras).get(series)
    if printed is None:
        return None
    terms = sum(name.startswith("q_c") for name in printed)
    return Components(gauss_markov=terms, sinusoid="A_s" in printed)


def masked_curve(
    raw: np.ndarray,
    frame_rate_hz: float,
    settings: NoiseSettings,
    resolution: float = 0.0,
    estimator: str = "oadev",
    among: np.ndarray | None = None,
) -> tuple[np.ndarray, AllanCurve]:
    """The series without its gross outliers (NaN), and its Allan curve: what a lab is shown.
    among: as of `hampel`."""
    window, threshold, allan = settings.half_window, settings.noise.mask_sigma, settings.allan
    step = max(resolution, own_step(raw))
    masked = hampel(raw, window, threshold, "mask", step, among).values
    m, how = settings.averaging_factors(raw.size), (allan.confidence, allan.min_coverage)
    curve = allan_curve(masked, frame_rate_hz, m, estimator, *how)
    return masked, curve.as_scattered(masked, allan.confidence)


def estimate_series(
    raw: np.ndarray,
    cleaned: tuple[np.ndarray, np.ndarray],
    frame_rate_hz: float,
    settings: NoiseSettings,
    components: Components | None = None,
    seed: int = 0,
    resolution: float = 0.0,
    among: np.ndarray | None = None,
) -> SeriesNoise:
    """Run every estimator of `settings` on one series.

    raw: (n,) as recorded, NaN in gaps; cleaned: m and Allan variances (mm^2) of the series cleaned
    as in S; components: what S's estimators fit (default: all power laws, `gauss_markov` terms,
    a sinusoid); among: as of `hampel`. Raises Refusal for a series without noise to estimate; the
    refusal of a single estimator is in the result.
    """
    spectral.check_series(raw, resolution)
    masked, curve = masked_curve(raw, frame_rate_hz, settings, resolution, among=among)
    spectral.check_series(masked, resolution)
    noise, frames, search = settings.noise, settings.frames or "sampled", settings.annealing
    fit = (*cleaned, frame_rate_hz, components or settings.components())
    duration = raw.size * (1 / frame_rate_hz)
    periodograms: list[Periodogram] = []

    def by_likelihood() -> Estimate:
        order = noise.criterion, noise.max_gauss_markov, noise.sinusoid
        how = spectral.LikelihoodSettings(*order, form=frames, either=settings.frames is None)
        run = spectral.likelihood(masked, frame_rate_hz, None, how, seed)
        periodograms.append(run.periodogram)
        return _coarse_step_note(run.estimate, masked, resolution)

    def by_annealing(search: Annealing) -> Estimate:
        return annealing.annealing_run(*fit, search, seed, noise.form, duration).estimate

    runs: dict[str, Callable[[], Estimate]] = {
        "likelihood": by_likelihood,
        S_ESTIMATOR: lambda: by_annealing(search),
        PLAIN_ESTIMATOR: lambda: by_annealing(annealing.without_descents(search)),
        "levenberg-marquardt": lambda: levenberg_marquardt(
            *fit, seed, noise.form, search, duration
        ),
        "slopes": lambda: slopes(*cleaned, frame_rate_hz),
    }
    estimates, refused = [], dict[str, str]()
    for name in noise.estimators:
        try:
            estimates.append(with_crlb(runs[name](), raw.size, frame_rate_hz, frames))
        except Refusal as refusal:
            refused[name] = str(refusal)
    return SeriesNoise(tuple(estimates), curve, next(iter(periodograms), None), refused)


def _coarse_step_note(estimate: Estimate, series: np.ndarray, resolution: float) -> Estimate:
    """A note where the stored step is twice the noise or more: the steps then set the numbers."""
    steps = np.diff(series)
    noise = float(np.sqrt(np.mean(steps[np.isfinite(steps)] ** 2) / 2))
    if noise >= 0.5 * resolution:
        return estimate
    why = f"the file's resolution ({resolution:.3g} mm) hides the noise of a frame ({noise:.2g} mm)"
    marked = [replace(c, note=why) if c.parameter == "h_0" else c for c in estimate.coefficients]
    note = "; ".join(filter(None, [estimate.note, why]))
    return replace(estimate, coefficients=tuple(marked), note=note)


def regression(
    m: np.ndarray, avar: np.ndarray, frame_rate_hz: float, settings: NoiseSettings, series: str
) -> tuple[annealing.AnnealingRun, Estimate]:
    """What S Figure 6 compares: every start of annealing with its result, and ordinary least
    squares, of one series."""
    fit, search = (m, avar, frame_rate_hz, settings.components(series)), settings.annealing
    form, seed = settings.noise.form, settings.seed
    run = annealing.annealing_run(*fit, search, seed, form)
    return run, levenberg_marquardt(*fit, seed, form, search)


def expected_estimate(
    truth: NoiseModel,
    m: np.ndarray,
    n: int,
    frame_rate_hz: float,
    settings: NoiseSettings,
    series: str,
) -> Estimate:
    """S's estimator on the Allan variances the model has in frames of its form, without chance.

    Of point samples it differs from the truth where S's formulas, for continuous time, do.
    """
    fit = m, truth.avar(m, frame_rate_hz), frame_rate_hz, settings.components(series)
    how = settings.annealing, settings.seed, settings.noise.form, n * (1 / frame_rate_hz)
    return with_crlb(annealing.annealing_run(*fit, *how).estimate, n, frame_rate_hz, truth.form)


def published_estimate(truth: NoiseModel, n: int, frame_rate_hz: float) -> Estimate:
    """The model itself as an estimate, with the Cramer-Rao bounds of n samples."""
    printed = tuple(Coefficient(name, value) for name, value in truth.coefficients().items())
    estimate = Estimate("published", truth.form, printed, np.nan)
    return with_crlb(estimate, n, frame_rate_hz, truth.form)


def with_crlb(estimate: Estimate, n: int, frame_rate_hz: float, frames: Form) -> Estimate:
    """The estimate with the bounds of its own model, of frames of that form, where it has none of
    its own."""
    if all(np.isfinite(c.crlb) for c in estimate.coefficients if c.detected):
        return estimate
    bounds = crlb(replace(estimate.model, form=frames), n, frame_rate_hz)
    coefficients = tuple(
        replace(c, crlb=bounds.get(c.parameter, np.nan)) if c.detected else c
        for c in estimate.coefficients
    )
    return replace(estimate, coefficients=coefficients)
