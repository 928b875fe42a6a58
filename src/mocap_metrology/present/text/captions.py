"""What every kind of figure and table shows: the words below it on pages and in the report.

A figure adds to its caption what depends on its data. Plain text, no markup.
"""

CALIBRATION = (
    "Above, the result: verdict, pose of the slave, and (a) stations and the path of the board "
    "from above; dotted lines join the stations and the middle of the path. Below, the evidence: "
    "(b) the same from the right. (c), (d) Uncertainty of the slave's position about the chosen "
    "estimate, from above and from the right: 95 % regions of the two coordinates and one "
    "standard deviation, and where other estimates with the same optics are; what is far off "
    "stands on the border. (e) The path enlarged, seen from the side on which it extends most; "
    "lines are of board poses by single stations."
)
DIODES_SEEN = (
    "Share of the sweeps of either station that each diode saw, pale where it is below half of "
    "the usual share (faint: these, and those that the station never sees). A diode is reported as "
    "dead if neither station sees it although other diodes that face the same way are seen."
)
CALIBRATION_BATCH = (
    "(f) to (h) Mean residuals of the hits (estimated minus measured), offsets of sweeps "
    "included, by angle and over time, with the standard deviation by noise. "
    "Noise leaves them near 0; a rotor that differs from "
    "its model leaves a slope or curve against an angle, a moved station a step in time. (i) Root "
    "mean square residual of each diode, offsets of sweeps removed; excluded diodes are "
    f"crossed. (j) {DIODES_SEEN}"
)
CALIBRATION_BOARD_POSES = (
    "(f) Distance between the paths by both stations after R and t; dashed: its median. (g) Root "
    f"mean square of the angles about each board pose. (h) {DIODES_SEEN}"
)
CALIBRATION_EITHER = (
    f"{CALIBRATION} Where the pose is by batch: {CALIBRATION_BATCH} Otherwise: "
    f"{CALIBRATION_BOARD_POSES}"
)
CAMERAS = (
    "Noise of the positions from subsets of the cameras of one take. (a) Allan deviation at one "
    "frame against the number of cameras; first marker filled, others open. (b) Noise of each "
    "subset relative to the next smaller one, with 95 % intervals: of the worst marker, in the "
    "direction of the largest rise. Cameras without a fault cannot raise the noise in any "
    "direction: their ratio is at most 1. (c), where the subsets share their frames: noise of "
    "each added camera, or of the noisiest where several were added at once, relative to the "
    "median of all cameras, with 95 % intervals. Some intervals are shorter than their marker, "
    "some extend beyond the panel."
)
COEFFICIENTS = (
    "Coefficients h of power-law noise, S ∝ f^α, by the likelihood estimator with 95 % "
    "intervals; triangles are upper 95 % limits of what was not detected. An arrow marks an "
    "interval that extends beyond the panel, or further than a factor of 100 below its estimate."
)
COMPARE = (
    "Allan deviation of a recording divided by that of its reference: the one named in the "
    "sheet's column compare_with, or else the one before by date. Above 1 the recording is "
    "noisier; within the yellow band no change is reported. Shaded: intervals of Fisher's F with "
    "the equivalent degrees of freedom of both; they may extend beyond a panel. If two "
    "recordings have the same noise, the probability of any word other than same is at most "
    "compare.alpha, over all series and averaging times."
)
CORRELATED = (
    "Gauss-Markov terms by the likelihood estimator with 95 % intervals: (a) correlation time T_c "
    "and (b) amplitude q_c by recording, (c) one against the other, the classes of T_c of S 4.6 "
    "shaded. Letters in (b) are upper 95 % limits of what was not detected, each for one class of "
    "T_c: s short, m medium, ℓ long."
)
CORRELATED_LIMITS = (
    "Letters are upper 95 % limits of the amplitude q_c of a Gauss-Markov term that the "
    "likelihood estimator did not detect, each for one class of its correlation time T_c (S 4.6): "
    "s short, m medium, ℓ long."
)
ONE_SERIES = "Series {series}; the table holds the others."
NOISIEST_FIRST = "Recordings are ordered by the white noise h₀ of that series, the greatest first."
SLOTS = "In each group from left to right: {order}."
DIAGNOSIS = (
    "Above, the dynamic Allan deviation over time, events marked; below it the largest event "
    "(or, without one, the most unusual window, framed in the map) beside the noise before and "
    "after (or of both halves: alike if every interval lies within a factor of 1.5); at the "
    "bottom the spectrum with its spectral lines and the Allan deviation, as recorded and after "
    "filters."
)
FAMILIES = (
    "All recordings of the group side by side: subsets of one camera type by their number of "
    "cameras, others by name. Below the Allan deviations of subsets is their ratio to those "
    "of the smallest one. Coefficients are those of the likelihood estimator with 95 % "
    "intervals; triangles are upper limits of what was not detected."
)
# Figures of Jansen et al. 2019, drawn again from the calibration named in their source line
JANSEN = {
    3: (
        "(a) What one photodiode sees in four measurement cycles: flashes of both stations and one "
        "sweep in each. Δt is the time from the flash of the station that sweeps to the middle of "
        "the sweep; azimuth θ and elevation φ follow from it and the speed of the rotors. (b) The "
        "flashes of the first cycle, (c) its sweep; dashed: its middle."
    ),
    5: (
        "P is a diode of the board, P′ its projection on the XZ plane of the station. A station "
        "measures the azimuth θ and φ′, the elevation of P′; φ is the elevation of P. x points "
        "forward, y left, z up."
    ),
    6: (
        "(a) Board poses estimated from the angles of either station alone, with both stations at "
        "the origin, (b), (c) enlarged. A dot is one measurement; the board is drawn in some of "
        "its poses, up to seven equally far apart along the path."
    ),
    7: (
        "(a) The slave's path is shifted so that its centroid coincides with that of the master's "
        "path and turned by R about it: (b) after the shift, (c) after the rotation. The shift is "
        "not the T of Figure 8, which applies after a rotation about the origin."
    ),
    8: (
        "R and T applied to the slave at the origin give its pose. α, β, γ are the angles of "
        "R = Rz(γ) Ry(β) Rx(α). T less the reference is in the frame of the master, and the "
        "rotation from the reference is about its x, y, z."
    ),
}


def of_jansen(*figures: int) -> str:
    """Captions of several figures one after the other, each with its number."""
    return " ".join(f"Figure {figure}: {JANSEN[figure]}" for figure in figures)


ORIENTATION = (
    "Allan deviation of the rotation vector of a rigid cluster of markers, frame by frame from "
    "its mean orientation, about the axes of the room."
)
PLACE = (
    "Length of a pair of markers that was carried through the volume: noise of one frame, and "
    "mean, by place. dof: degrees of freedom of the noise. There are fewer than frames, and the "
    "fewest where a filter has smoothed most."
)
ADEV = (
    "Overlapping Allan deviation of every coordinate and distance against the averaging time, as "
    "recorded, with gross outliers masked. The slope shows the kind of noise."
)
ADEV_RATIOS = "Below each panel: the same relative to the smallest subset."
ADEV_ENDS = "Lowest and highest recording of {names}."
TRAJECTORY = (
    "Every coordinate and distance about its mean, against time. Grey: raw samples; light blue: "
    "after outliers were cleaned. Where there are more samples than columns of pixels, a column "
    "shows the range of its samples and the dark line their mean. Red: outliers more than 6 "
    "standard deviations of one frame from the mean of their column; smaller ones, which noise "
    "alone leaves beyond the limit of the filter, are only counted. A few samples far from the "
    "rest lie beyond the axis: triangles at its edge mark where they are, and the number beside "
    "the panel is the largest of them."
)
FIT = (
    "(a) Allan deviation and (b) power spectral density of one series, with the fitted noise model "
    "and its components. (c) Residuals: data/model - 1, between -1 and 1 % on a linear axis and "
    "beyond on a logarithmic one; shaded is the interval of the data. (d) Residuals of the "
    "spectrum over its standard deviation, the square root of 2/dof; shaded are 1 and 2 sigma."
)
OTHER_FITS = "(e) and (f): the same of other estimators, residuals and spectra of their models."
GAUSS_MARKOV = (
    "GM: Gauss-Markov component, its number under its peak, the class of T_c after S 4.6."
)
SCALING = (
    "(a) Standard deviations of the cleaned coordinates along the line between the markers (of a "
    "single marker, along x) and of their distance against the number of cameras, (b) covariances "
    "of the two markers along that line. Lines: σ/√n, fitted to the points of each series by the "
    "mean of their logarithms; in each panel the exponent of n with its standard error if it is "
    "free (−0.5 by the law)."
)
PAPER = "Skurowski & Pawlyta 2019"  # whose figures these are
SKUROWSKI: dict[int | str, str] = {
    1: (
        "Computed from the numbers printed in Table 4, row T40: normal densities of x of either "
        "marker, and of the distance L with each of the four standard deviations of section 2.2."
    ),
    2: (
        "Line: the standard error σ/√N in units of σ (Equation 3). Points: root of the printed "
        "white noise h₀ (Tables A1-A3; correlated noise shorter than a frame counts as white), "
        "geometric mean over x, y, z of both markers, with n cameras. Each type is divided by "
        "the value of its fitted law at one camera, so only the decrease can be compared. The "
        "legend gives the exponent of n with its standard error if it is free; the law gives "
        "−0.5. Vantage without the failing tenth camera."
    ),
    3: (
        "Computed from noise models, continuous-time forms with f_h = 500 Hz: (a) power laws, "
        "(b) correlated and periodic noise. The coefficients are chosen so that each component "
        "dominates in its own decades; the values on the axes have no other meaning. The numbers "
        "are the slopes of the computed curves at that place. Beyond six periods a sinusoid is "
        "drawn by the envelope of its bumps, and the sum with their mean."
    ),
    6: (
        "The Allan deviation of one series with the model that annealing and an ant colony find by "
        "weighted least squares (relative residuals, Equation 13), every start of annealing, and "
        "ordinary least squares (Levenberg-Marquardt, no weights). Below: the data relative to "
        "each model."
    ),
    7: (
        "(a) The coordinates of marker 1 round a shock. (b) Allan deviation of the distance L as "
        "recorded, after the Hampel filter, and with the frames of the shock cut out."
    ),
    8: (
        "Overlapping Allan deviation of (a) x1, (b) x2 and (c) the distance L: Vantage with all "
        "ten cameras, of which one was failing, and without that camera."
    ),
    9: (
        "Kernel estimates (Gaussian kernels, Silverman's bandwidth) of the cleaned coordinates; "
        "normal densities with the same mean and standard deviation, and with those of Table 4. "
        "Zero is the mean of Table 4, where a twin starts. Slow noise makes the density of one "
        "recording uneven and moves its mean."
    ),
    10: (
        "(a) Kernel estimates of the density of the cleaned distance, and normal densities with "
        "the mean and standard deviation of Table 4. (b) Mean distances; bars: standard error of "
        "the mean of a twin about its first frame, whose mean is that of Table 4 for its type "
        "(line) at every number of cameras: the paper prints no others. A measured recording has "
        "no such bar. An arrow with a number: a mean beyond the axis."
    ),
    11: (
        "(a) Variances along x and of the distance, (b) covariances of x1 and x2. Lines: σ²/n "
        "(Equation 3), fitted to the points of each series by the mean of their logarithms; in "
        "each panel the exponent of n with its standard error if it is free (−1 by the law). The "
        "axis of (b) is linear near zero and logarithmic beyond. How variances and covariances "
        "depend on n comes from the printed coefficients, of which the twins are made; bars: the "
        "average that these coefficients lead to in recordings of this length. Twins of one type "
        "share their slow noise (below 0.1 Hz), as subsets of one recording do, so they lie "
        "above or below their bars together. The tenth Vantage camera was failing and is "
        "excluded from the fits. Stars: Table 4, which refers to the nine-hour recordings of the "
        "paper."
    ),
    12: (
        "Overlapping Allan deviation of x1, x2 and the distance L by the number of cameras, "
        "Vantage without the failing one; in the last column the deviation at one averaging time. "
        "Shaded: the number of cameras that section 4.3 calls notably better suited."
    ),
    13: (
        "Overlapping Allan deviation of (a) x1, (b) x2 and (c) the distance L by all sound cameras "
        "of each type, and of all types together."
    ),
    14: (
        "Coefficients of power-law noise by the number of cameras, logarithmic: (a) T40, (b) "
        "Bonita, (c) Vantage. At each number from left to right: x1, y1, z1, x2, y2, z2, L; the "
        "numbers of one series are in one line. Grey circles: published numbers below the "
        "least standard error that the length of the recording allows. A cross marks an end of "
        "the range searched by annealing-ant-colony, which is not an estimate. Bars are 95 % "
        "intervals of the likelihood estimator, cut at an arrow a factor of 100 below the "
        "estimate; triangles are its 95 % upper limits where it detects nothing. In the grey "
        "band: less than 10⁻²⁰."
    ),
    15: (
        "The coefficients of Figure 14 on linear axes, where zero can be seen: each panel in its "
        "own power of ten, up to nine tenths of its numbers that are not zero. Arrows at the "
        "top: larger numbers, and intervals that extend beyond the panel. Upper limits beyond a "
        "panel are not drawn."
    ),
    16: (
        "Correlated noise of (a) T40, (b) Bonita, (c) Vantage: correlation time T_c and amplitude "
        "q_c by the number of cameras, symbols as in Figure 14; an upper limit of q_c applies to "
        "one class of T_c and is drawn as its letter: s short, m medium, ℓ long. In the grey "
        "band: less than 10⁻⁷ mm/√s. (d) to (f) q_c against T_c by source, the classes of "
        "section 4.6 shaded; published terms below their least standard error are pale. Dashed: "
        "ends of the range of T_c that annealing-ant-colony searched, where terms accumulate if "
        "no T_c within the range fits."
    ),
    17: (
        "Power spectral density of z1 by the largest set of each camera type, its number of "
        "cameras in brackets: (a) as medians of 40 bins a decade with bands up to the greatest "
        "value, (b) to (d) every point close to the line, and over each panel the peak over the "
        "median. The paper reports the line for T40 and "
        "Vantage, negligibly small for Vantage; Tables A1-A3 print its amplitude for T40 alone, so "
        "a twin of Vantage or Bonita has none."
    ),
    "A1": (
        "Overlapping Allan deviation of z1 by the largest set of each camera type, (a) before and "
        "(b) after the failing camera was replaced. The paper's recordings last nine hours before "
        "the repair; it does not state their length after it."
    ),
}


def of_skurowski(*figures: int | str) -> str:
    """Captions of several figures one after the other, each with its number."""
    known = {str(figure): caption for figure, caption in SKUROWSKI.items()}
    return " ".join(f"Figure {figure}: {known[str(figure)]}" for figure in figures)


TRACK_PATH = (
    "The board tracked with the calibrated stations, 60 poses a second. (a) Path from above, "
    "coloured by the standard deviation of the position. (b) Standard deviations of the position "
    "against the distance from the master."
)
TRACK_AT_REST = (
    "The board at rest, tracked with the calibrated stations, 60 poses a second. (a), (b) Allan "
    "deviation of the angles, 30 sweeps a second: of what all diodes of a sweep share, and of "
    "single diodes beyond it, with 68.3 % intervals. The independent noise of a diode cannot be "
    "less than the dotted line, if the clock's rounding is dithered; where the spread is below the "
    "step, it may not be."
)
TRACK = (
    "(c) Position about its mean. (d), (e) Standard "
    "deviations of position and rotation over time: by the noise of the hits, by the error of the "
    "slave's pose, and by all, which includes errors of optics and board. Each is the length of a "
    "vector of three axes. With the recording's own calibration, errors of board and optics move "
    "slave and board alike, so all is not the sum of its parts. Moments without hits have no pose."
)
TREND = (
    "Allan deviation at three averaging times by the date of recording, with 68 % intervals; a "
    "line marks a change that chance does not explain over the averaging times of a series. The "
    "table has the change in percent a month, per series and averaging time."
)
VERDICT = (
    "Uncertainty of one frame and of means over 1, 10 and 60 s about the mean of the horizon, "
    "with the limits of good and usable. Where there is a noise model, the share of each kind of "
    "noise in the variance of one frame is shown; T_c: correlation time."
)
TABLE = (
    "Numbers are rounded, published ones are as printed. All digits, and columns that are not "
    "shown here, are in the CSV behind the link at the foot of the page."
)
SUMMARY = (
    "Verdict, reason and numbers of every recording and calibration. Refused inputs come first. "
    "Names lead to figures from the file summary.html, and from the front page of this report "
    "beside the results."
)
PROVENANCE = (
    "Code, configuration, seeds and checksums of these results, and the duration of each step."
)
