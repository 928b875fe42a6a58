"""What every kind of figure and table shows: the words below it on pages and in the report.

A figure adds to its caption what only its data can say. Plain text, no markup.
"""

CALIBRATION = (
    "Paths of the board from both stations, residuals, and the pose of the slave with its verdict."
)
CAMERAS = (
    "Noise of the positions from subsets of the cameras of one take, against the number of "
    "cameras and from each subset to the next larger one. Sound cameras cannot raise it in any "
    "direction; where the subsets share their frames, the noise of each added camera relative "
    "to the others is told too."
)
COMPARE = (
    "Allan deviation of a recording over that of the one it is held against: the one named in "
    "the sheet's column compare_with, or else the one before by date. Above 1 it is noisier; "
    "intervals are those of Fisher's F with the equivalent degrees of freedom of both. Of two "
    "recordings alike, a share compare.alpha at most has any word other than same, over all "
    "series and averaging times."
)
DIAGNOSIS = (
    "Above, the dynamic Allan deviation over time, events marked; below it the largest event "
    "(or, without one, the most unusual window, framed in the map) beside the noise before and "
    "after (or of both halves: alike if every interval lies within a factor of 1.5); at the "
    "bottom the spectrum with its spectral lines and the Allan deviation, as recorded and as "
    "filters would leave them."
)
FAMILIES = (
    "All recordings of the group side by side: subsets of one camera type by their number of "
    "cameras, others by name. Below the Allan deviations of subsets stands their ratio to those "
    "of the smallest one. Coefficients are those of the likelihood estimator with 95 % "
    "intervals; triangles are upper limits of what was not detected."
)
JANSEN = (
    "A figure of Jansen et al. 2019, drawn again from the calibration named in its source line."
)
ORIENTATION = (
    "Allan deviation of the rotation vector of a rigid cluster of markers, frame by frame from "
    "its mean orientation, about the axes of the room."
)
PLACE = (
    "Length of a pair of markers that was carried through the volume: noise of one frame, and "
    "mean, by place. dof are the degrees of freedom of the noise: fewer than frames, the fewer "
    "the more a filter has smoothed them."
)
ADEV = (
    "Overlapping Allan deviation of every coordinate and distance against the averaging time, as "
    "recorded, with gross outliers masked. The slope shows the kind of noise."
)
PSD = (
    "Welch's estimate of the power spectral density after outliers were cleaned. The line joins "
    "medians of 40 bins a decade; the shaded band reaches to the greatest value of each bin, so "
    "that a narrow spectral line shows."
)
RECORDING = (
    f"Figures of one recording. Allan deviation: {ADEV} Spectrum: {PSD} Trajectories and the fits "
    "of the noise model are in the recording's folder of results."
)
SCALING = (
    "Standard deviations and covariances of the group's recordings against the number of "
    "cameras, with the law σ/√n fitted; from the cleaned coordinates."
)
SKUROWSKI_FAMILIES = (
    "A figure of Skurowski & Pawlyta 2019 drawn again from the recordings of the sheet; its "
    "note says which of them are simulated from the published coefficients."
)
SKUROWSKI_GAUSSIAN = (
    "From the recordings of the sheet, twins where the paper's own were never published. How "
    "twins depend on the number of cameras comes from the coefficients the paper prints; the "
    "note below the figure says what else to know."
)
SKUROWSKI_NOISE = (
    "Coefficients as printed in Tables A1-A3 and as found again in the recordings of the sheet; "
    "the note below the figure says which of these are simulated from the printed ones."
)
SKUROWSKI_THEORY = (
    "Computed from the noise models and the printed numbers; no recording enters. The note "
    "below the figure says which numbers."
)
TREND = (
    "Change of the Allan deviation with the date of recording, per series and averaging time, "
    "in percent a month."
)
VERDICT = (
    "Uncertainty of one frame and of means over 1, 10 and 60 s about the mean of the horizon, "
    "against the limits of good and usable, and the share of each kind of noise in the variance "
    "of one frame where there is a noise model; T_c: correlation time."
)
TABLE = (
    "Numbers are rounded to be read, published ones as printed; all digits, and columns that "
    "are not shown here, are in the CSV behind the link at the foot of the page."
)
SUMMARY = (
    "A word, its reason, and the numbers behind it, of every recording and calibration. Refused "
    "inputs come first. Names lead to figures from the file summary.html, and from the front "
    "page of this report beside the results."
)
PROVENANCE = (
    "Code, configuration, seeds and checksums these results were made with, and how long each "
    "step took."
)
