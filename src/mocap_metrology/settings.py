"""Every setting of config.yaml: type, range, default and help. Functions get the sections."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError

from mocap_metrology.common.faults import Faults, shown
from mocap_metrology.common.sections import WHOLE, Once, Section, Words, faults

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
PoseEstimator = Literal["batch", "paper", "paper-tight", "paper-lm", "pnp", "geometric"]
Optics = Literal["ideal", "factory", "estimated"]
SimplexOptics = Literal["ideal", "factory"]
WorldFrame = Literal["gravity", "master", "board-start", "points"]

Sheet = Annotated[str | None, Words("the path of a sheet, or nothing", "a path or nothing")]
Limit = Annotated[float | None, Words("a number of mm > 0, or nothing", "> 0, or nothing")]
Share = Annotated[float, Words("a share from 0 to 1")]
Frequency = Annotated[float, Field(gt=0, le=1e6)]
SERIES = r"^([xyz][1-9][0-9]*|L|L_[1-9][0-9]*_[1-9][0-9]*)$"  # coordinate of a marker, distance


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
    estimators: Annotated[tuple[AllanEstimator, ...], AfterValidator(Once("oadev"))] = ("oadev",)
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
        AfterValidator(Once()),
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
        AfterValidator(Once("likelihood")),
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


Millimetres = Annotated[float, Field(ge=-200, le=200)]


class Lighthouse(Section):
    """Calibration of base stations."""

    sample_rate_hz: float = Field(2000000.0, ge=100000, le=100000000)
    """Words per second of a GPIO dump."""
    active_level: Annotated[int, Words("0 or 1", "`0`, `1`")] = Field(1, ge=0, le=1)
    """Value of a bit while its diode is lit."""
    gate_mrad: float = Field(1.5, gt=0)
    """A hit is an outlier if it deviates from the others of its sweep by more than this and by more
    than `gate_mad`."""
    gate_mad: float = Field(8.0, ge=3)
    """The second limit, in MAD of the sweep."""
    still_half_window: int = Field(15, ge=2)
    """Hampel filter of each diode while the board is at rest: sweeps on each side."""
    still_n_sigma: float = Field(4.0, ge=3)
    """Threshold of this filter, in 1.4826 MAD."""
    estimators: Annotated[
        tuple[PoseEstimator, ...],
        AfterValidator(Once("paper-lm")),
    ] = ("batch", "paper", "paper-tight", "paper-lm")
    """Estimators of the pose, with `paper-lm` among them; each is described below. The pose of
    `batch` is chosen where it is among them and converges."""
    optics: Annotated[tuple[Optics, ...], AfterValidator(Once(least=1))] = (
        "ideal",
        "factory",
        "estimated",
    )
    """`ideal` is J's; `factory` uses the values of the maker that the flashes carry; `estimated`
    estimates them with the pose, by `batch`, where they are not known."""
    simplex_optics: Annotated[tuple[SimplexOptics, ...], AfterValidator(Once())] = ("ideal",)
    """Optics of `paper` and `paper-tight`, each of which takes a second."""
    reconstruction: Literal["full-interpolation", "dominant-axis", "pairs"] = "full-interpolation"
    """Method that brings both angles to one moment (J section IV)."""
    lm_interpolation: Literal["linear", "cubic"] = "cubic"
    """Interpolation of `paper-lm`; the others are linear, as in J."""
    lm_weights: Literal["path", "none"] = "path"
    """Whether the last stage of `paper-lm` includes the uncertainty of the path of the board; J
    treats it as exact."""
    start_distance_m: float = Field(3.0, ge=0.1, le=20)
    """Distance of the board in the first guess of `paper`, in m; J does not state it."""
    variant: Literal["auto", "crazyflie", "libsurvive", "astrobee"] = "auto"
    """Meaning of the factory values where open-source drivers differ (sign of curve, argument of
    the gibbous term). `auto` fits each variant and selects the one with the smallest residual of
    both stations; variants that the recording does not exclude increase the covariance. `pose.json`
    lists all under `variants`."""
    pnp_method: Literal["auto", "epnp", "ippe", "sqpnp"] = "auto"
    """Method of `pnp`; `auto` is `ippe` on flat boards."""
    lasers_mm: Annotated[
        tuple[Millimetres, ...] | None,
        Field(min_length=12, max_length=12),
        Words(
            "nothing, or twelve numbers of mm, x, y and z of the lasers of axis 0 and 1 of the "
            "master, then of the slave",
            "twelve numbers",
        ),
    ] = None
    """Positions of the lasers in their housings: x, y, z of axis 0 and axis 1 of the master, then
    of the slave. Poses are then of the housings, otherwise of the optics."""
    board_position_sd_mm: float = Field(0.2, ge=0, le=10)
    """Of `batch`, as are the next four: standard deviation of the coordinates of a diode in the
    board file. 0: exact. Less is used where the recording shows that they are better."""
    board_scale_sd: float = Field(0.001, ge=0, le=0.1)
    """Relative standard deviation of the board's scale, which no angle shows: the distance of the
    stations has the same. Of boards below 0.3 m it is at least 0.3 mm over the largest distance of
    two diodes, unless it is 0. Column `known_length` reduces it."""
    laser_depth_sd_mm: float = Field(10.0, ge=0, le=100)
    """Standard deviation of the distance in depth between both lasers of a station, with `factory`
    optics and where `lasers_mm` does not name it."""
    phase_sd_mrad: float = Field(1.0, ge=0, le=100)
    """Standard deviation of the phases of the maker, with `factory` optics. An error of a phase is
    not visible in the residual."""
    time_zero_sd_us: float = Field(0.15, ge=0, le=10)
    """Standard deviation of the time zero of a station and axis: diodes see a flash rise late, each
    by its own delay."""
    world: WorldFrame = "gravity"
    """Frame of the room in `crazyflie.yaml`, `libsurvive.json`, `ros2_static_transforms.launch.xml`
    and under `world` of `pose.json`. `gravity`: z up by the accelerometers of the stations, origin
    at the master, x horizontal as the master looks; `master`: the master's own frame;
    `board-start`: the board's frame, where it was at the start of the recording; `points`: that of
    column `world_points`, which a row with such a file always has. Where the data for a frame is
    missing, it is `gravity`, by the stations or by the geometry in a Crazyflie's file, else
    `board-start`, else `master`; files and terminal state it and why."""
    inertial: bool = False
    """Whether `batch` uses the gyroscope and the accelerometer of a `.rec` besides the light.
    Biases, scale, delay, orientation and place of both are estimated. It pays for small boards."""
    gravity: bool = False
    """Whether `batch` uses the way up that each station transmits, with a standard deviation of 1.5
    deg. It pays where the pose is known no better; the verdict compares both in any case."""
    joint: Literal["none", "setup"] = "none"
    """`setup`: besides each recording alone, all recordings of a setup in one estimate by `batch`,
    `setups/<group>/<setup>/pose.json`. Objects may differ, and a recording may see a part of the
    stations. It is the way to calibrate stations whose factory values are not known: record at five
    places or more."""

    def of_one(self) -> dict[str, Any]:
        """What determines the result of a single recording, by name."""
        return self.model_dump(exclude={"joint"})


Speed = Annotated[float, Field(ge=0.02, le=5)]
Distance = Annotated[float, Field(ge=1.25, le=10)]
Baseline = Annotated[float, Field(ge=0.2, le=5)]
Diodes = Annotated[int, Field(ge=3, le=32)]
Offset = Annotated[float, Field(ge=0, le=100)]
LaserDistance = Annotated[float, Field(ge=0.75, le=10)]
TWO = AfterValidator(Once(least=2))


def _numbers(low: str, high: str, unit: str = "") -> Words:
    """Of a list of numbers."""
    words = f"a list of numbers{unit} >= {low} and <= {high}, at least two, each at most once"
    return Words(words, f"each >= {low}, <= {high}")


class JansenStudies(Section):
    """Simulated studies of J's claims, by `snakemake jansen_studies`."""

    recordings: int = Field(20, ge=2, le=10000)
    """Simulated recordings at each point of a study. Fewer than six give no interval of a
    median."""
    duration_s: float = Field(4.0, ge=1, le=60)
    """Length of these recordings, in s; J's are of 8 s."""
    speeds_m_s: Annotated[tuple[Speed, ...], TWO, _numbers("0.02", "5", " of m/s")] = (
        *(0.1, 0.2, 0.5, 1.0, 2.0),
    )
    """Speeds of the board at which the ways of reconstruction are compared."""
    patterns: Annotated[tuple[Literal["line", "arc", "circle", "hand"], ...], TWO] = (
        *("line", "arc", "circle", "hand"),
    )
    """Motion patterns that are compared."""
    distances_m: Annotated[tuple[Distance, ...], TWO, _numbers("1.25", "10", " of m")] = (
        *(2.0, 3.0, 4.0, 5.0, 6.0),
    )
    """Distances of the board from both stations, which are 2 m apart."""
    baselines_m: Annotated[tuple[Baseline, ...], TWO, _numbers("0.2", "5", " of m")] = (
        *(1.0, 2.0, 3.0, 4.0),
    )
    """Distances between the stations, 3 m from the board."""
    diodes: Annotated[tuple[Diodes, ...], TWO, _numbers("3", "32")] = (3, 4, 8, 16, 32)
    """Numbers of diodes on a board of the same size."""
    laser_offsets_mm: Annotated[tuple[Offset, ...], TWO, _numbers("0", "100", " of mm")] = (
        *(0.0, 5.0, 10.0, 25.0),
    )
    """Distances of the lasers from the middle of their station, in random directions."""
    laser_distances_m: Annotated[
        tuple[LaserDistance, ...], AfterValidator(Once(least=1)), _numbers("0.75", "10", " of m")
    ] = (1.0, 2.5, 6.0)
    """Distances of the board at which these offsets are compared; the stations are 1 m apart."""


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
    seed: int = Field(2019, ge=0)
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
    bar: Bar = Bar()
    monitor: Monitor = Monitor()
    cameras: Cameras = Cameras()
    fit_figures: Annotated[
        tuple[Annotated[str, Field(pattern=SERIES)], ...] | None,
        Words("nothing, or a list of series such as z1, L, L_1_3, or []", "a list of series"),
    ] = None
    """Series whose fits are drawn, `fit/<series>.svg`, where a recording has them. Nothing: the one
    that decided the verdict, and L. `snakemake results/recordings/<name>/fits` draws all."""
    second_opinion: bool = True
    """Whether C3D files that are short enough are also read by ezc3d."""
    gaussian: Gaussian = Gaussian()
    diagnosis: Diagnosis = Diagnosis()
    noise: Noise = Noise()
    annealing: Annealing = Annealing()
    lighthouse: Lighthouse = Lighthouse()
    jansen_studies: JansenStudies = JansenStudies()


def checked(config: Mapping[str, object], whole: bool = True) -> Settings:
    """The configuration with every value of its type; `Faults` names all wrong ones. whole: whether
    every key must be there; otherwise those that are not have their defaults."""
    try:
        settings = Settings.model_validate(config, context=WHOLE if whole else None)
    except ValidationError as error:
        raise Faults(faults(error, Settings, config)) from None
    lines = []
    limits = {f"verdict.{key}": value for key, value in settings.verdict.model_dump().items()}
    drift = ("verdict.good_drift_mm", "verdict.usable_drift_mm")
    stated = any(limits[key] for key in drift)
    limits |= zip(drift, settings.verdict.drift_mm if stated else (0.0, 0.0), strict=True)
    limits |= {f"bar.{key}": value for key, value in settings.bar.model_dump().items()}
    for key, good in limits.items():
        other = key.replace("good_", "usable_")
        if other != key and other in limits and good > limits[other]:
            most = f"{other} ({limits[other]:g})"
            lines.append(f"config, key {key}: {shown(good)}; expected at most {most}")
    if lines:
        raise Faults(lines)
    return settings
