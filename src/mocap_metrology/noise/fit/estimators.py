"""Every estimator of noise coefficients on one series, beside the published row.

    found = estimate_series(raw, (m, avar), 120, NoiseSettings(), components, seed=1)

`likelihood` gets the series as recorded with gross outliers masked; S's estimator and its baselines
get the Allan variances of the series cleaned as in S.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import hampel, mask_half_window
from mocap_metrology.noise.allan.confidence import AllanCurve, allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.fit.allan.annealing import (
    AnnealingRun,
    AnnealingSettings,
    annealing_run,
)
from mocap_metrology.noise.fit.allan.baselines import levenberg_marquardt, slopes
from mocap_metrology.noise.fit.estimates import Coefficient, Components, Estimate
from mocap_metrology.noise.fit.spectral.fisher import crlb
from mocap_metrology.noise.fit.spectral.likelihood import (
    LikelihoodSettings,
    check_series,
    likelihood,
)
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram
from mocap_metrology.noise.model.components import Form, NoiseModel
from mocap_metrology.noise.twins.published import printed_row, published_keys
from mocap_metrology.settings import Settings

ESTIMATORS = ("likelihood", "annealing-ant-colony", "levenberg-marquardt", "slopes")


@dataclass(frozen=True)
class NoiseSettings:
    """estimators: which are run; mask_sigma, half_window: of the Hampel filter that masks gross
    outliers (samples to each side); criterion, max_gauss_markov, sinusoid: of the choice of order;
    form: of the model the estimators of S fit; gauss_markov: terms they fit where the paper prints
    no panel; n_taus, min_m, max_fraction, min_coverage, confidence: of the Allan variances; curves:
    kinds of these; frames: form of the recording's, for `likelihood`, None where the exposure is
    not known; seed: of all draws; subset: type and number of cameras whose panel of Tables A1-A3
    they fit."""

    estimators: tuple[str, ...] = ESTIMATORS
    mask_sigma: float = 6.0
    half_window: int = 120
    criterion: str = "bic"
    max_gauss_markov: int = 4
    sinusoid: bool = True
    form: Form = "continuous"
    gauss_markov: int = 3
    n_taus: int = 100
    min_m: int = 1
    max_fraction: float = 1 / 3
    min_coverage: float = 0.5
    confidence: float = 0.683
    curves: tuple[str, ...] = ("oadev",)
    annealing: AnnealingSettings = field(default_factory=AnnealingSettings)
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
        averaging = settings.allan.model_dump(exclude={"estimators"})
        return cls(
            half_window=mask_half_window(settings.hampel.half_window_s, frame_rate_hz),
            **settings.noise.model_dump(),
            **averaging,
            curves=settings.allan.estimators,
            annealing=AnnealingSettings(**settings.annealing.model_dump()),
            frames=frames,
            seed=settings.seed,
            subset=subset and (subset[0], subset[1]),
        )

    def components(self, series: str = "") -> Components:
        """What S's estimators fit: the series' panel, where the paper prints one."""
        printed = panel(*self.subset, series) if self.subset else None
        return printed or Components(gauss_markov=self.gauss_markov, sinusoid=self.sinusoid)


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
    tau0 = 1 / frame_rate_hz
    found = hampel(raw, settings.half_window, settings.mask_sigma, "mask", resolution, among)
    masked = found.values
    m = averaging_factors(raw.size, settings.n_taus, settings.min_m, settings.max_fraction)
    how = (settings.confidence, settings.min_coverage)
    curve = allan_curve(masked, 1 / tau0, m, estimator, *how)
    return masked, curve.as_scattered(masked, settings.confidence)


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
    tau0 = 1 / frame_rate_hz
    check_series(raw, resolution)
    masked, curve = masked_curve(raw, frame_rate_hz, settings, resolution, among=among)
    check_series(masked, resolution)
    n = raw.size
    components = components or settings.components()
    order = LikelihoodSettings(
        settings.criterion,
        settings.max_gauss_markov,
        settings.sinusoid,
        form=settings.frames or "sampled",
        either=settings.frames is None,
    )
    kept: list[Periodogram] = []

    def by_likelihood() -> Estimate:
        run = likelihood(masked, frame_rate_hz, None, order, seed)
        kept.append(run.periodogram)
        return _coarse(run.estimate, masked, resolution)

    fit = (*cleaned, frame_rate_hz, components)

    def annealing(how: AnnealingSettings) -> Estimate:
        return annealing_run(*fit, how, seed, settings.form, n * tau0).estimate

    runs: dict[str, Callable[[], Estimate]] = {
        "likelihood": by_likelihood,
        "annealing-ant-colony": lambda: annealing(settings.annealing),
        "annealing-ant-colony-plain": lambda: annealing(settings.annealing.plain),
        "levenberg-marquardt": lambda: levenberg_marquardt(
            *fit, seed, settings.form, within=settings.annealing.every_tau, duration=n * tau0
        ),
        "slopes": lambda: slopes(*cleaned, frame_rate_hz),
    }
    estimates, refused = [], {}
    for name in settings.estimators:
        try:
            estimates.append(
                with_crlb(runs[name](), n, frame_rate_hz, settings.frames or "sampled")
            )
        except Refusal as refusal:
            refused[name] = str(refusal)
    return SeriesNoise(tuple(estimates), curve, kept[0] if kept else None, refused)


def _coarse(estimate: Estimate, series: np.ndarray, resolution: float) -> Estimate:
    """A note where the stored step is twice the noise or more: the steps then set the numbers."""
    steps = np.diff(series)
    noise = float(np.sqrt(np.mean(steps[np.isfinite(steps)] ** 2) / 2))
    if noise >= 0.5 * resolution:
        return estimate
    why = f"the file's resolution ({resolution:.3g} mm) hides the noise of a frame ({noise:.2g} mm)"
    coefficients = tuple(
        replace(c, note=why) if c.parameter == "h_0" else c for c in estimate.coefficients
    )
    return replace(
        estimate, coefficients=coefficients, note="; ".join(filter(None, [estimate.note, why]))
    )


def regression(
    m: np.ndarray, avar: np.ndarray, frame_rate_hz: float, settings: NoiseSettings, series: str
) -> tuple[AnnealingRun, Estimate]:
    """What S Figure 6 compares: every start of annealing with its result, and ordinary least
    squares, of one series."""
    asked, seed = settings.components(series), settings.seed
    run = annealing_run(m, avar, frame_rate_hz, asked, settings.annealing, seed, settings.form)
    return run, levenberg_marquardt(
        m, avar, frame_rate_hz, asked, seed, settings.form, within=settings.annealing.every_tau
    )


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
    tau0 = 1 / frame_rate_hz
    avar = truth.avar(m, frame_rate_hz)
    asked, duration = settings.components(series), n * tau0
    found = annealing_run(
        m, avar, frame_rate_hz, asked, settings.annealing, settings.seed, settings.form, duration
    ).estimate
    return with_crlb(found, n, frame_rate_hz, truth.form)


def published_estimate(truth: NoiseModel, n: int, frame_rate_hz: float) -> Estimate:
    """The model itself as an estimate, with the Cramer-Rao bounds of n samples."""
    bounds = crlb(truth, n, frame_rate_hz)
    found = tuple(
        Coefficient(name, value, crlb=bounds[name]) for name, value in truth.coefficients().items()
    )
    return Estimate("published", truth.form, found, np.nan)


def with_crlb(
    estimate: Estimate, n: int, frame_rate_hz: float, frames: Form = "sampled"
) -> Estimate:
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
