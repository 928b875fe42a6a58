"""Every setting of config.yaml: type, range, default and help."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationError

from mocap_metrology.pipeline.settings import (
    DEFAULTS,
    Action,
    AllanEstimator,
    Form,
    NoiseEstimator,
    Word,
)
from mocap_workflow.configuration import WHOLE, Once, Section, Words, faults
from mocap_workflow.faults import Faults, shown
from mocap_workflow.lighthouse_settings import JansenStudies, Lighthouse

Sheet = Annotated[str | None, Words("the path of a sheet, or nothing", "a path or nothing")]
Share = Annotated[float, Words("a share from 0 to 1")]
Frequency = Annotated[float, Field(gt=0, le=1e6)]
SERIES = r"^([xyz][1-9][0-9]*|L|L_[1-9][0-9]*_[1-9][0-9]*)$"  # coordinate of a marker, distance


class Hampel(Section):
    """Cleaning of outliers."""

    half_window_s: float = Field(DEFAULTS.hampel.half_window_s, gt=0)
    """Half length of the sliding window of the Hampel filter, in s."""
    n_sigma: float = Field(DEFAULTS.hampel.n_sigma, gt=0)
    """A value that deviates from the median of the window by more than this many 1.4826 MAD is an
    outlier. The MAD is at least half a step of the file."""
    action: Action = DEFAULTS.hampel.action
    """Outliers are replaced by the median, become gaps, or are not changed."""


class Allan(Section):
    """Allan variances."""

    n_taus: Annotated[int, Words("a whole number >= 2 and <= 10000")] = Field(
        DEFAULTS.allan.n_taus, ge=2, le=10000
    )
    """Number of averaging times, evenly spaced in log tau."""
    min_m: int = Field(DEFAULTS.allan.min_m, ge=1)
    """Shortest averaging time, in frames."""
    max_fraction: float = Field(DEFAULTS.allan.max_fraction, gt=0, le=0.5)
    """Longest averaging time, as a share of the recording."""
    estimators: Annotated[tuple[AllanEstimator, ...], AfterValidator(Once("oadev"))] = (
        DEFAULTS.allan.estimators
    )
    """Overlapping Allan (always), modified Allan and Hadamard deviation."""
    confidence: float = Field(DEFAULTS.allan.confidence, gt=0, lt=1)
    """Level of the confidence intervals."""
    min_coverage: float = Field(DEFAULTS.allan.min_coverage, gt=0, le=1)
    """A window is used if at least this share of its frames is valid."""


class Spectrum(Section):
    """Spectra."""

    segment_s: float = Field(DEFAULTS.psd.segment_s, gt=0, le=1000000)
    """Length of the segments of Welch's method, in s."""
    overlap: float = Field(DEFAULTS.psd.overlap, ge=0, lt=1)
    """Overlap of these segments, as a share of their length."""


class Still(Section):
    """What counts as standing still."""

    range_mm: float = Field(DEFAULTS.still.range_mm, gt=0)
    """A marker moves if it covers more than this within `verdict.horizon_s`, and more than its
    noise explains. It also moves if it jumps by four standard deviations of a frame or more. Random
    walk, drift and warm-up below this value are not movement."""


class Verdict(Section):
    """Limits of the verdict."""

    horizon_s: float = Field(DEFAULTS.verdict.horizon_s, gt=0)
    """Uncertainties are about the mean of this time (of the recording, if shorter), so they include
    the wander within it."""
    window_s: float = Field(DEFAULTS.verdict.window_s, gt=0)
    """The scatter of single frames is computed within this time."""
    good_mm: float = Field(DEFAULTS.verdict.good_mm, gt=0)
    """The verdict is `good` up to this uncertainty of one frame in the worst coordinate. A
    reference should be 10 times, at least 4 times, better than the device under test (S 2.2); the
    defaults are for a device of 1 mm."""
    usable_mm: float = Field(DEFAULTS.verdict.usable_mm, gt=0)
    """The verdict is `usable` up to this uncertainty, and `bad` above. No `usable_` limit may be
    below its `good_` limit."""
    good_drift_mm: float = Field(DEFAULTS.verdict.good_drift_mm, gt=0)
    """Limit of `good` for the drift over the horizon. A drift by d scatters by d/√12 about its
    mean: 0.1 mm."""
    usable_drift_mm: float = Field(DEFAULTS.verdict.usable_drift_mm, gt=0)
    """Limit of `usable` for the drift: a scatter of 0.25 mm."""
    good_missing: Share = Field(DEFAULTS.verdict.good_missing, ge=0, le=1)
    """Limit of `good` for the share of missing frames."""
    usable_missing: Share = Field(DEFAULTS.verdict.usable_missing, ge=0, le=1)
    """Limit of `usable` for the share of missing frames."""
    good_outliers: Share = Field(DEFAULTS.verdict.good_outliers, ge=0, le=1)
    """Limit of `good` for the share of outliers, minus that of clean noise. The smallest share that
    is consistent with their number is used, because in a short recording some are random."""
    usable_outliers: Share = Field(DEFAULTS.verdict.usable_outliers, ge=0, le=1)
    """Limit of `usable` for the share of outliers."""
    good_duration_s: float = Field(DEFAULTS.verdict.good_duration_s, ge=0)
    """A shorter recording is `usable` at best. Below 100 frames or one second, which are too few to
    judge, it is `bad`. In a recording shorter than the horizon, the upper end of the interval must
    also be below `good_mm`."""
    good_markers: int = Field(DEFAULTS.verdict.good_markers, ge=0)
    """With fewer markers the verdict is `usable` at best."""
    misfit: Word = DEFAULTS.verdict.misfit
    """The best verdict if the noise of a coordinate fits no model. A marker that moves
    (`still.range_mm`) is `bad`, whatever its noise."""


class Compare(Section):
    """Comparisons of recordings of different days."""

    margin: float = Field(0.05, ge=0)
    """A smaller relative change of the Allan deviation is ignored."""
    alpha: float = Field(0.01, gt=0, lt=1)
    """False-alarm rate: the share of unchanged recordings that are reported as changed, and of
    unrelated series that are reported as related to a covariate."""
    confidence: float = Field(0.95, gt=0, lt=1)
    """Level of the intervals of ratios and trends."""


class Place(Section):
    """Noise by place."""

    cell_mm: float = Field(250.0, gt=0)
    """Edge of the cubes in which the length of a moving pair is compared, in mm."""


class Cameras(Section):
    """Subsets of the cameras of one take."""

    rise: float = Field(0.05, ge=0)
    """An addition of cameras is reported if it increases the noise by more than this share in any
    direction. Of 100 systems without a bad camera at most one is reported if the cameras differ by
    10 %, and up to 11 if they differ by 15 % (`benchmarks/failing_camera.py`)."""
    noisy: float = Field(1.5, gt=1)
    """A camera with this many times the median noise of all is named (or the set with which it was
    added). Needs subsets of the same frames."""


class Gaussian(Section):
    """Moments and their tests."""

    n_bins: Annotated[int, Words("a whole number >= 4 and <= 100000")] = Field(
        DEFAULTS.gaussian.n_bins, ge=4, le=100000
    )
    """Bins of the chi-squared test for a normal distribution."""


class Diagnosis(Section):
    """Events, lines and filters."""

    false_alarm: Annotated[float, Words("a probability > 0 and <= 0.5")] = Field(
        DEFAULTS.diagnosis.false_alarm, gt=0, le=0.5
    )
    """Largest probability that an event is reported in an undisturbed recording: one half for
    bursts, one half for lasting changes."""
    side_s: float = Field(DEFAULTS.diagnosis.side_s, ge=10)
    """Length over which the noise before and after an event is compared, in s (or what the
    recording has)."""
    spike_sigma: float = Field(DEFAULTS.diagnosis.spike_sigma, ge=4)
    """One or two frames of a single marker that deviate from their neighbours by more than this are
    outliers, not an event."""
    cutoffs_hz: Annotated[
        tuple[Frequency, ...],
        AfterValidator(Once()),
        Words(
            "a list of frequencies in Hz > 0 and <= 1000000, each at most once, or []",
            "each > 0, <= 1000000",
        ),
    ] = DEFAULTS.diagnosis.cutoffs_hz
    """Butterworth low-pass filters whose effect is computed: second order, run both ways, half the
    amplitude at this frequency."""
    notch_width_hz: float = Field(DEFAULTS.diagnosis.notch_width_hz, gt=0)
    """Width of the notch filter whose effect is computed at each line, between its half-power
    points."""
    max_lines: int = Field(DEFAULTS.diagnosis.max_lines, ge=0)
    """Largest number of periodic disturbances that are reported in a series."""


class Noise(Section):
    """Estimates of noise coefficients."""

    estimators: Annotated[
        tuple[
            NoiseEstimator,
            ...,
        ],
        AfterValidator(Once("likelihood")),
    ] = DEFAULTS.noise.estimators
    """Estimators of noise coefficients, with `likelihood` among them; `docs/noise.md` describes
    each. `annealing-ant-colony-plain` takes about 10 s a series."""
    mask_sigma: float = Field(DEFAULTS.noise.mask_sigma, ge=3)
    """`likelihood` uses the series as recorded, without the outliers of a Hampel filter with this
    threshold."""
    criterion: Literal["bic", "aicc"] = DEFAULTS.noise.criterion
    """Criterion that selects the components."""
    max_gauss_markov: int = Field(DEFAULTS.noise.max_gauss_markov, ge=0, le=4)
    """Largest number of Gauss-Markov terms."""
    sinusoid: bool = DEFAULTS.noise.sinusoid
    """Whether periodic disturbances are detected."""
    form: Form = DEFAULTS.noise.form
    """Allan variances that `annealing-ant-colony` and `levenberg-marquardt` fit; S used the
    continuous ones."""
    gauss_markov: int = Field(DEFAULTS.noise.gauss_markov, ge=0, le=4)
    """Number of Gauss-Markov terms in these two where the paper has no panel."""


class Annealing(Section):
    """Search of `annealing-ant-colony`, and -plain."""

    starts: int = Field(DEFAULTS.annealing.starts, ge=1)
    """Runs of simulated annealing, each from a random point."""
    iterations: int = Field(DEFAULTS.annealing.iterations, ge=1)
    """Length of a run, in twice the number of coefficients."""
    temperature: float = Field(DEFAULTS.annealing.temperature, gt=0.01, le=50000)
    """Temperature at the start of a run."""
    descent: int = Field(DEFAULTS.annealing.descent, ge=1)
    """Steps of Levenberg-Marquardt that refine each trial of `annealing-ant-colony`;
    `annealing-ant-colony-plain` has none."""
    archive: int = Field(DEFAULTS.annealing.archive, ge=2)
    """Ant colony: number of solutions in the archive."""
    ants: int = Field(DEFAULTS.annealing.ants, ge=1)
    """New solutions in each iteration."""
    q: float = Field(DEFAULTS.annealing.q, gt=0)
    """Weight of the best solutions: the smaller, the more they count."""
    xi: float = Field(DEFAULTS.annealing.xi, gt=0)
    """Spread of new solutions around old ones."""
    colony_iterations: int = Field(DEFAULTS.annealing.colony_iterations, ge=0)
    """Iterations of the colony."""
    jitter: float = Field(DEFAULTS.annealing.jitter, gt=0)
    """Spread of the first archive around the result of the annealing, in natural logarithms."""
    plain_iterations: int = Field(DEFAULTS.annealing.plain_iterations, ge=1)
    """`annealing.iterations` of `annealing-ant-colony-plain`."""
    plain_colony_iterations: int = Field(DEFAULTS.annealing.plain_colony_iterations, ge=0)
    """`annealing.colony_iterations` of `annealing-ant-colony-plain`."""
    negligible: float = Field(DEFAULTS.annealing.negligible, gt=0, lt=0.1)
    """Smallest share of a component: root mean square over tau of its part of the relative Allan
    variance. A component that ends there is absent (`at_bound`)."""
    largest: float = Field(DEFAULTS.annealing.largest, ge=1)
    """Largest share; a share above 1 never lowers the cost."""
    shortest_frames: float = Field(DEFAULTS.annealing.shortest_frames, ge=0.1)
    """Shortest T_c that is searched, in frames. The shortest in S's tables is 10 ms, 1.2 frames.
    Allan variances cannot distinguish so short a term from white noise."""
    longest_share: float = Field(DEFAULTS.annealing.longest_share, gt=0, le=1)
    """Longest T_c that is searched, as a share of the recording."""
    lowest_hz: float = Field(DEFAULTS.annealing.lowest_hz, gt=0)
    """Lowest f_0 that is searched, or one period in the recording where that is more; slower ones
    fit random fluctuations. The highest is half of the frame rate."""
    longest_tau_share: float = Field(DEFAULTS.annealing.longest_tau_share, gt=0, le=1)
    """Longest tau that `annealing-ant-colony` and `-plain` fit, as a share of the recording.
    Relative residuals give longer tau, where the fluctuations are random, the same weight as short
    ones."""


class Settings(Section):
    """config.yaml."""

    recordings: Sheet = "config/recordings.tsv"
    """Sheet of recordings. Nothing (`recordings=`) is an empty sheet."""
    calibrations: Sheet = "config/calibrations.tsv"
    """Sheet of Lighthouse calibrations."""
    twins: Annotated[
        str | None, Words("the path of a file of twins, or nothing", "a path or nothing")
    ] = "config/twins.yaml"
    """Simulated recordings and calibrations by name, with all their parameters."""
    results: Annotated[
        str,
        Field(pattern=r"^[^<>{}]*[^<>{}./][^<>{}]*$"),
        AfterValidator(os.path.normpath),
        Words(
            "a folder of its own, without any of < > { } "
            "(and not a name that reads as 1.5 or True)",
            "a folder",
        ),
    ] = "results"
    """Folder of all outputs. It is created if missing."""
    duration_s: float = Field(32400.0, ge=1)
    """Length of twin recordings, in s, unless a twin has a shorter one of its own. Nothing else
    depends on it."""
    seed: int = Field(DEFAULTS.seed, ge=0)
    """Added to the seed of every twin: another value simulates all recordings anew."""
    twin_form: Literal["continuous", "sampled"] = "continuous"
    """Meaning of a frame of a twin. `continuous`: an average over the frame period, whose Allan
    variance is that of the textbook formulas, in which the paper gives its coefficients. `sampled`:
    a point, as with cameras, whose exposure is far shorter than a frame. A twin with a `form` of
    its own is not affected (set `sampled` if its coefficients come from `likelihood` on a recording
    of a camera); subsets of a take are points."""
    hampel: Hampel = Hampel()
    allan: Allan = Allan()
    psd: Spectrum = Spectrum()
    still: Still = Still()
    verdict: Verdict = Verdict()
    compare: Compare = Compare()
    place: Place = Place()
    cameras: Cameras = Cameras()
    fit_figures: Annotated[
        tuple[Annotated[str, Field(pattern=SERIES)], ...] | None,
        Words("nothing, or a list of series such as z1, L, L_1_3, or []", "a list of series"),
    ] = None
    """Series whose fits are drawn, `fit/<series>.svg`, where a recording has them. Nothing: all."""
    second_opinion: bool = DEFAULTS.second_opinion
    """Whether C3D files that are short enough are also read by ezc3d."""
    gaussian: Gaussian = Gaussian()
    diagnosis: Diagnosis = Diagnosis()
    noise: Noise = Noise()
    annealing: Annealing = Annealing()
    lighthouse: Lighthouse = Lighthouse()
    jansen_studies: JansenStudies = JansenStudies()


def checked(config: Mapping[str, object]) -> Settings:
    """The configuration with every value of its type; `Faults` names all wrong ones."""
    try:
        settings = Settings.model_validate(config, context=WHOLE)
    except ValidationError as error:
        raise Faults(faults(error, Settings, config)) from None
    limits, lines = settings.verdict.model_dump(), []
    for key, good in limits.items():
        other = key.replace("good_", "usable_")
        if other != key and other in limits and good > limits[other]:
            most = f"verdict.{other} ({limits[other]:g})"
            lines.append(f"config, key verdict.{key}: {shown(good)}; expected at most {most}")
    if lines:
        raise Faults(lines)
    return settings
