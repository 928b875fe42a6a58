"""Settings of recordings: cleaning, noise, verdict, comparison, bars and monitors."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from mocap_metrology.common.sections import Section, Unique, Words

Action = Literal["replace", "mask", "off"]
AllanEstimator = Literal["oadev", "mdev", "hdev"]
NoiseEstimator = Literal[
    "likelihood",
    "annealing-ant-colony",
    "annealing-ant-colony-plain",
    "levenberg-marquardt",
    "slopes",
]
Form = Literal["sampled", "continuous"]
Word = Literal["good", "usable", "bad"]

Limit = Annotated[float | None, Words("a number of mm > 0, or nothing", "> 0, or nothing")]
Share = Annotated[float, Words("a share from 0 to 1")]
Frequency = Annotated[float, Field(gt=0, le=1e6)]


class Hampel(Section):
    """Cleaning of outliers."""

    half_window_s: float = Field(1.0, gt=0)
    """Half length of the sliding window of the Hampel filter, in s."""
    n_sigma: float = Field(3.0, gt=0)
    """A value that deviates from the median of the window by more than this many 1.4826 MAD is an
    outlier. The MAD is at least half a step of the file."""
    action: Action = "replace"
    """Outliers are replaced by the median, become gaps, or are not changed."""


class Allan(Section):
    """Allan variances."""

    n_taus: Annotated[int, Words("a whole number >= 2 and <= 10000")] = Field(100, ge=2, le=10000)
    """Number of averaging times, evenly spaced in log tau."""
    min_m: int = Field(1, ge=1)
    """Shortest averaging time, in frames."""
    max_fraction: float = Field(0.3333333, gt=0, le=0.5)
    """Longest averaging time, as a share of the recording."""
    estimators: Annotated[tuple[AllanEstimator, ...], AfterValidator(Unique("oadev"))] = ("oadev",)
    """Overlapping Allan (always), modified Allan and Hadamard deviation."""
    confidence: float = Field(0.683, gt=0, lt=1)
    """Level of the confidence intervals."""
    min_coverage: float = Field(0.5, gt=0, le=1)
    """A window is used if at least this share of its frames is valid."""


class Spectrum(Section):
    """Spectra."""

    segment_s: float = Field(600.0, gt=0, le=1000000)
    """Length of the segments of Welch's method, in s."""
    overlap: float = Field(0.5, ge=0, lt=1)
    """Overlap of these segments, as a share of their length."""


class Still(Section):
    """What counts as standing still."""

    range_mm: float = Field(2.0, gt=0)
    """A marker moves if it covers more than this within `verdict.horizon_s`, and more than its
    noise explains. It also moves if it jumps by four standard deviations of a frame or more. Random
    walk, drift and warm-up below this value are not movement."""


class Verdict(Section):
    """Limits of the verdict."""

    horizon_s: float = Field(3600.0, gt=0)
    """Uncertainties are about the mean of this time (of the recording, if shorter), so they include
    the wander within it."""
    window_s: float = Field(1.0, gt=0)
    """The scatter of single frames is computed within this time."""
    mean_mm: float = Field(0.01, gt=0)
    """Expanded uncertainty (95 %) that is wanted of the mean of a recording: the verdict states how
    long one needs to be."""
    good_mm: float = Field(0.1, gt=0)
    """The verdict is `good` up to this uncertainty of one frame in the worst coordinate. A
    reference should be 10 times, at least 4 times, better than the device under test (S 2.2); the
    defaults are for a device of 1 mm."""
    usable_mm: float = Field(0.25, gt=0)
    """The verdict is `usable` up to this uncertainty, and `bad` above. No `usable_` limit may be
    below its `good_` limit."""
    good_drift_mm: Limit = Field(None, gt=0)
    """Limit of `good` for the drift over the horizon. Nothing: √12 times `good_mm`, because a drift
    by d scatters by d/√12 about its mean."""
    usable_drift_mm: Limit = Field(None, gt=0)
    """Limit of `usable` for the drift. Nothing: √12 times `usable_mm`."""
    good_missing: Share = Field(0.01, ge=0, le=1)
    """Limit of `good` for the share of missing frames."""
    usable_missing: Share = Field(0.1, ge=0, le=1)
    """Limit of `usable` for the share of missing frames."""
    good_outliers: Share = Field(0.01, ge=0, le=1)
    """Limit of `good` for the share of outliers, minus that of clean noise. The smallest share that
    is consistent with their number is used, because in a short recording some are random."""
    usable_outliers: Share = Field(0.05, ge=0, le=1)
    """Limit of `usable` for the share of outliers."""
    good_duration_s: float = Field(60.0, ge=0)
    """A shorter recording is `usable` at best. Below 100 frames or one second, which are too few to
    judge, it is `bad`. In a recording shorter than the horizon, the upper end of the interval must
    also be below `good_mm`."""
    good_markers: int = Field(2, ge=0)
    """With fewer markers the verdict is `usable` at best."""
    misfit: Word = "usable"
    """The best verdict if the noise of a coordinate fits no model. A marker that moves
    (`still.range_mm`) is `bad`, whatever its noise."""

    @property
    def drift_mm(self) -> tuple[float, float]:
        """Limits of good and of usable for the drift over the horizon."""
        good = self.good_drift_mm or math.sqrt(12) * self.good_mm
        return good, self.usable_drift_mm or math.sqrt(12) * self.usable_mm


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


class Bar(Section):
    """A bar, or another stiff object, that is carried through the volume (column `bar`)."""

    rigid_mm: float = Field(1.5, gt=0)
    """Markers form a rigid cluster if the spread of each of their distances, (p97.5 - p2.5) / 4, is
    below this."""
    least_path_mm: float = Field(500.0, gt=0)
    """A bar that is moved along a shorter way says nothing of a volume, and is refused."""
    classes_deg: float = Field(30.0, gt=0, le=54)
    """Bar and motion belong to an axis of the file up to this angle, and are `oblique` beyond."""
    good_mm: float = Field(0.5, gt=0)
    """Accuracy is `good` if 95 % of the errors of length in the worst class, plus twice the
    standard uncertainty of the certificate, are below this. Without a certificate no accuracy is
    stated."""
    usable_mm: float = Field(2.0, gt=0)
    """Accuracy is `usable` up to this, and `bad` above."""


class Tolerance(Section):
    """Changes that matter, see `Monitor`."""

    jitter: float = Field(0.15, gt=0)
    """Change of the jitter that matters, in natural logarithm: 0.15 is 16 %."""
    wander: float = Field(1.0, gt=0)
    """Change of the wander that matters, as a share: 1 is twice as much."""
    place_mm: float = Field(0.5, gt=0)
    """Change of a coordinate of the mean place that matters, in mm."""
    length_mm: float = Field(0.2, gt=0)
    """Change of a length that matters, in mm."""


class Scatter(Section):
    """Standard deviations from day to day, see `Monitor`."""

    jitter: float = Field(0.06, gt=0)
    """Standard deviation of the jitter from day to day that is expected, as a share. What the
    baseline shows is averaged with it, as if it came from four takes."""
    wander: float = Field(0.2, gt=0)
    """That of the wander, as a share."""
    place_mm: float = Field(0.1, gt=0)
    """That of a coordinate of the mean place, in mm."""
    length_mm: float = Field(0.05, gt=0)
    """That of a length, in mm."""


class Monitor(Section):
    """Charts of a facility over its takes."""

    tolerance: Tolerance = Tolerance()
    scatter: Scatter = Scatter()
    false_alarms: float = Field(0.05, gt=0, lt=1)
    """Probability that the statistical limits of all series of an unchanged facility are exceeded
    in `monitor.dates` takes. It leads to notes; alarms depend on `monitor.tolerance`."""
    dates: int = Field(50, ge=1, le=10000)
    """Number of takes after the baseline for which this probability holds."""
    frame: Literal["fixed", "fitted"] = "fixed"
    """`fixed`: the place is the mean of the markers, in a frame that stays. `fitted`: the frame may
    change from take to take, as that of a Lighthouse: each take of three markers or more is fitted
    to the first one, and the place is what the fit leaves of each marker."""
    wander_s: float = Field(2.0, gt=0)
    """Averaging time of the wander, in s. It is judged in takes of at least 22 times this
    length."""


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

    n_bins: Annotated[int, Words("a whole number >= 4 and <= 100000")] = Field(30, ge=4, le=100000)
    """Bins of the chi-squared test for a normal distribution."""


class Diagnosis(Section):
    """Events, lines and filters."""

    false_alarm: Annotated[float, Words("a probability > 0 and <= 0.5")] = Field(0.01, gt=0, le=0.5)
    """Largest probability that an event is reported in an undisturbed recording: one half for
    bursts, one half for lasting changes."""
    side_s: float = Field(300.0, ge=10)
    """Length over which the noise before and after an event is compared, in s (or what the
    recording has)."""
    spike_sigma: float = Field(6.0, ge=4)
    """One or two frames of a single marker that deviate from their neighbours by more than this are
    outliers, not an event."""
    cutoffs_hz: Annotated[
        tuple[Frequency, ...],
        AfterValidator(Unique()),
        Words(
            "a list of frequencies in Hz > 0 and <= 1000000, each at most once, or []",
            "each > 0, <= 1000000",
        ),
    ] = (6.0, 10.0)
    """Butterworth low-pass filters whose effect is computed: second order, run both ways, half the
    amplitude at this frequency."""
    notch_width_hz: float = Field(1.0, gt=0)
    """Width of the notch filter whose effect is computed at each line, between its half-power
    points."""
    max_lines: int = Field(10, ge=0)
    """Largest number of periodic disturbances that are reported in a series."""


class Noise(Section):
    """Estimates of noise coefficients."""

    estimators: Annotated[
        tuple[
            NoiseEstimator,
            ...,
        ],
        AfterValidator(Unique("likelihood")),
    ] = ("likelihood", "annealing-ant-colony", "levenberg-marquardt", "slopes")
    """Estimators of noise coefficients, with `likelihood` among them; `docs/noise.md` describes
    each. `annealing-ant-colony-plain` takes about 10 s a series."""
    mask_sigma: float = Field(6.0, ge=3)
    """`likelihood` uses the series as recorded, without the outliers of a Hampel filter with this
    threshold."""
    criterion: Literal["bic", "aicc"] = "bic"
    """Criterion that selects the components."""
    max_gauss_markov: int = Field(4, ge=0, le=4)
    """Largest number of Gauss-Markov terms."""
    sinusoid: bool = True
    """Whether periodic disturbances are detected."""
    form: Form = "continuous"
    """Allan variances that `annealing-ant-colony` and `levenberg-marquardt` fit; S used the
    continuous ones."""
    gauss_markov: int = Field(3, ge=0, le=4)
    """Number of Gauss-Markov terms in these two where the paper has no panel."""


class Annealing(Section):
    """Search of `annealing-ant-colony`, and -plain."""

    starts: int = Field(10, ge=1)
    """Runs of simulated annealing, each from a random point."""
    iterations: int = Field(3, ge=1)
    """Length of a run, in twice the number of coefficients."""
    temperature: float = Field(5230.0, gt=0.01, le=50000)
    """Temperature at the start of a run."""
    descent: int = Field(20, ge=1)
    """Steps of Levenberg-Marquardt that refine each trial of `annealing-ant-colony`;
    `annealing-ant-colony-plain` has none."""
    archive: int = Field(50, ge=2)
    """Ant colony: number of solutions in the archive."""
    ants: int = Field(10, ge=1)
    """New solutions in each iteration."""
    q: float = Field(0.1, gt=0)
    """Weight of the best solutions: the smaller, the more they count."""
    xi: float = Field(0.85, gt=0)
    """Spread of new solutions around old ones."""
    colony_iterations: int = Field(100, ge=0)
    """Iterations of the colony."""
    jitter: float = Field(0.1, gt=0)
    """Spread of the first archive around the result of the annealing, in natural logarithms."""
    plain_iterations: int = Field(1000, ge=1)
    """`annealing.iterations` of `annealing-ant-colony-plain`."""
    plain_colony_iterations: int = Field(2000, ge=0)
    """`annealing.colony_iterations` of `annealing-ant-colony-plain`."""
    negligible: float = Field(1e-05, gt=0, lt=0.1)
    """Smallest share of a component: root mean square over tau of its part of the relative Allan
    variance. A component that ends there is absent (`at_bound`)."""
    largest: float = Field(1.5, ge=1)
    """Largest share; a share above 1 never lowers the cost."""
    shortest_frames: float = Field(2.0, ge=0.1)
    """Shortest T_c that is searched, in frames. The shortest in S's tables is 10 ms, 1.2 frames.
    Allan variances cannot distinguish so short a term from white noise."""
    longest_share: float = Field(0.1, gt=0, le=1)
    """Longest T_c that is searched, as a share of the recording."""
    lowest_hz: float = Field(0.01, gt=0)
    """Lowest f_0 that is searched, or one period in the recording where that is more; slower ones
    fit random fluctuations. The highest is half of the frame rate."""
    longest_tau_share: float = Field(0.03, gt=0, le=1)
    """Longest tau that `annealing-ant-colony` and `-plain` fit, as a share of the recording.
    Relative residuals give longer tau, where the fluctuations are random, the same weight as short
    ones."""
