"""Checks of a recording and of the fit to it, each with the best word a verdict can then have.

The wording for readers is made elsewhere, from case and numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from scipy.special import chdtri

from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.records import PoseEstimate
from mocap_metrology.lighthouse.timing import CYCLE_S

WORDS = ("good", "usable", "doubtful", "failed")
JITTER_URAD = 61.0  # of one angle: 53 common to a sweep, 30 of each diode
EXPECTED_URAD = 75.0  # with 38 by the two edges of a pulse at 2 MHz
# Residual over the expected one: (usable from, doubtful from). A board on its way adds what the
# interpolation of its path misses.
RESIDUAL = {"static": (2.0, 3.0), "kabsch": (10.0, 40.0), "final": (5.0, 30.0)}
RESIDUAL_BATCH = (1.4, 3.0)  # which interpolates nothing: sound ones reach 1.0
WEIGHT_LOST = (0.15, 0.35)  # of hits: wrong sweeps, reflections, stretches that fit no trajectory
PRIOR_P = (1e-2, 1e-8)
UNNOTICED = 5.0  # standard deviations of a known length by which it can be wrong unnoticed
SCALE_P = 1e-3  # the length or the board is not as stated, and gives the pose its scale
MISFIT = (1.2, 25.0)  # of variances; 1 within chance
# What no step in time explains of it: optics of another station leave 2.2 to 109, but 1.0 in some
# recordings of decks of four diodes; sound recordings of moved boards, real ones too, 1.0.
UNEXPLAINED = 2.0
HIDDEN_MRAD = 6.0  # phases differ by 25 to 37 mrad; of decks on short paths 4 to 25 are hidden
SCALE_SHARE = 0.5  # of the variance of the position: from then on a known length helps most
RESIDUAL_FAILED = 100.0  # over the expected one: no pose fits
BATCH_FAILED = 25.0  # likewise of a path and all hits: optics of other stations make 16 at most
# Over the noise, without errors of board poses. Sound ones reach 1.2, lasers 15 mm off 1.3; of a
# mirrored deep board a pose 5 m and 76° off can leave as little as 13 (of 50, the next 13.6).
WEIGHTED_FAILED = 10.0
USUAL_GAIN = 4.0  # of a board of 20 cm; errors of a smaller one's poses raise what is expected
FARTHEST_M = 20.0  # no station is seen from farther
BOARD = (1.2, 3.0)  # over the noise of an angle
BOARD_PLACES = 1.5  # doubtful, over noise and errors of the board
MIRRORED = (0.01, 0.05)
MIRRORED_FAILED = 0.5
COMMON = (200, 50)  # usable below, doubtful below; not of `batch`
SPAN_M = (0.3, 0.1)
CHI2_6 = 22.46  # of six degrees of freedom, exceeded with probability 0.001
WEIGHTED = (1.3, 3.0)  # over the noise, without errors of board poses: sound ones reach 1.2
# Reported standard deviations are too small by 3 to 5, as blocks of time share their time zeros.
# A difference of two parts has less of it: sound ones reach 35, a station moved by 5 mm 150.
HALVES_M2 = (2**2 * CHI2_6, 5**2 * CHI2_6)
# batch knows what both parts have in common, so its square is a chi squared: sound ones reach 14, a
# station moved by 5 mm 240, factory values of another station 24 to 720.
HALVES_BATCH = (CHI2_6, 150.0)
SIGMA = ((5.0, 0.1), (20.0, 0.5))  # mm, deg: largest axis
SIGMA_BATCH = ((10.0, 0.3), (30.0, 1.0))  # errors of board and optics included, but its scale
MOST_SCALE = 8 / 9  # of the variance: it raises limits threefold at most
FAR_M = 4.0  # from the reference: farther, an error of the scale in mm may grow with the distance
USUAL_S, USUAL_LONGEST_S, SHORT_S = 8.0, 8.4, 4.0  # 8.389 s is the memory of J's board


# What a check found: one for every sentence.
Case = StrEnum(
    "Case",
    "DISTANCE TOO_DISTANT RESIDUAL RESIDUAL_HIGH RESIDUAL_UNKNOWN WEIGHT WEIGHT_LOST"
    " WEIGHT_UNKNOWN PRIORS PRIORS_LEFT PRIORS_UNKNOWN LENGTH SCALE SCALE_OPEN MISFIT_NONE MISFIT"
    " MISFIT_OPEN MISFIT_UNKNOWN PATH_ERRORS BEYOND_PATH PATH_ERRORS_UNKNOWN HALVES HALVES_APART"
    " HALVES_MISFIT HALVES_OPEN HALVES_UNKNOWN RECORDINGS RECORDINGS_APART MIRRORED MIRRORED_FLAT"
    " MIRRORED_BOTH MIRRORED_UNKNOWN MOVED STILL COMMON COMMON_FEW COMMON_UNNEEDED BOARD_POSES"
    " BOARD_POSES_HIGH BOARD_POSES_NONE PATH PATH_SHORT PATH_UNNEEDED PATH_NONE UNCERTAINTY"
    " UNCERTAINTY_ALL UNCERTAINTY_SCALE UNCERTAINTY_NONE UNCERTAINTY_UNKNOWN DURATION"
    " DURATION_UNUSUAL DURATION_SHORT DURATION_UNKNOWN FACTORY FACTORY_FILE FACTORY_DOUBTED"
    " FACTORY_UNSEEN FACTORY_EXCHANGED IDEAL ESTIMATED ROTOR_CLEAR ROTOR_OPEN ROTOR_UNASKED"
    " STAGES STAGES_LOOSE STAGES_UNKNOWN OPTICS OPTICS_FAR GRAVITY GRAVITY_OFF GRAVITY_OFF_IDEAL"
    " GRAVITY_UNKNOWN"
    " REFERENCE REFERENCE_NONE OBJECTS OBJECTS_APART",
)


@dataclass(frozen=True)
class Check:
    """One check. ok None: not applicable or not known; level: the best word a verdict can have
    with it; limit: of `value`, for the next worse word, of a distance in mm and an angle in deg a
    pair. numbers, names: more of what was found, as the case needs; why: reasons by role."""

    name: str
    case: Case
    value: float | int | str | None
    unit: str
    limit: float | int | str | tuple[float, float] | None
    ok: bool | None
    level: str
    numbers: Mapping[str, float] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    why: Mapping[str, str] = field(default_factory=dict)


def graded(value: float, limits: Sequence[float]) -> tuple[str, float]:
    """Word of a value that had better be small, and the limit of the next worse word."""
    usable, doubtful = limits
    if not value >= usable:
        return "good", usable
    return ("usable" if value < doubtful else "doubtful"), doubtful


def graded_low(value: float, limits: Sequence[float]) -> tuple[str, float]:
    """Word of a value that had better be large, and the limit of the next worse word."""
    usable, doubtful = limits
    if value >= usable:
        return "good", usable
    return ("usable" if value >= doubtful else "doubtful"), doubtful


def worst(
    mm: float, deg: float, limits: Sequence[tuple[float, float]]
) -> tuple[str, tuple[float, float]]:
    """Word of a distance and an angle with limits for both, and the limits of the next worse."""
    first, second = limits
    word = max(
        (graded(v, (first[k], second[k]))[0] for k, v in enumerate((mm, deg))), key=WORDS.index
    )
    return word, first if word == "good" else second


def unknown(name: str, case: Case, unit: str, level: str = "good") -> Check:
    """A check that does not apply, or of something not known."""
    return Check(name, case, None, unit, None, None, level)


def judged(
    name: str,
    cases: tuple[Case, ...],
    value: float,
    unit: str,
    grade: tuple[str, float | tuple[float, float]],
    **numbers: float,
) -> Check:
    """A check by the word of its value and the limit of the next worse one; cases: of the word
    good, of others, and of a value that is not known."""
    word, limit = grade
    good = word == "good"
    if len(cases) > 2 and not math.isfinite(value):
        return unknown(name, cases[2], unit)
    return Check(name, cases[not good], value, unit, limit, good, word, numbers)


def expected_noise_urad(resolution_s: float | None) -> float:
    """Noise of one angle by jitter and by the clock's steps at both edges of a pulse, urad."""
    if resolution_s is None:
        return EXPECTED_URAD
    step = 1e6 * math.pi * resolution_s / CYCLE_S
    return math.hypot(JITTER_URAD, step / math.sqrt(24))


def distance(chosen: PoseEstimate) -> Check:
    """Farther than stations can be: a search that ran away."""
    value, cases = float(np.linalg.norm(chosen.t_m)), (Case.DISTANCE, Case.TOO_DISTANT)
    word = "good" if value <= FARTHEST_M else "failed"
    return judged("distance", cases, value, "m", (word, FARTHEST_M))


def residual(chosen: PoseEstimate, noise: float) -> Check:
    """Residual of the fit, of `batch` by hits as it weighs them; of a small board what the errors
    of its poses make of it is expected."""
    value = float(_detail(chosen, "weighted_rms_urad", chosen.residual_rms_urad))
    expected, numbers = noise, {"noise": noise}
    if not math.isfinite(value):
        return unknown("residual", Case.RESIDUAL_UNKNOWN, "urad", "usable")
    if chosen.noise_gain > USUAL_GAIN:
        expected = noise * chosen.noise_gain / USUAL_GAIN
        numbers["made_by_poses"] = noise * chosen.noise_gain
    exact = weighs_hits(chosen)
    word, limit = graded(value / expected, RESIDUAL_BATCH if exact else RESIDUAL[chosen.stage])
    lost = chosen.weighted_rms_urad > WEIGHTED_FAILED * noise
    most = BATCH_FAILED if exact else RESIDUAL_FAILED
    if lost or not value < most * expected:
        word, limit = "failed", most
    numbers["times"] = value / noise
    cases = Case.RESIDUAL, Case.RESIDUAL_HIGH
    return judged("residual", cases, value, "urad", (word, limit * expected), **numbers)


def weighs_hits(chosen: PoseEstimate) -> bool:
    """Whether a pose is of all hits of a moving board, by weights, not of single board poses."""
    return chosen.estimator == "batch" and chosen.stage == "final"


def _detail(chosen: PoseEstimate, name: str, default: float = math.nan) -> float:
    """One of the numbers that `batch` alone knows."""
    value = (chosen.details or {}).get(name, default)
    return value if isinstance(value, float) else default


def optics_hidden(chosen: PoseEstimate, generation: int) -> bool:
    """Whether a moving board may not show that a station's values are those of another: of the
    first generation by how large errors of phases are hidden, which make most of these; of the
    second one by a board of four diodes, which leaves two angles a station to spare."""
    if chosen.stage == "static":
        return False
    ratios = (chosen.details or {}).get("residual_ratios")
    few = isinstance(ratios, dict) and len(ratios["diode"]) <= FEWEST_DIODES
    return few if generation == 2 else _detail(chosen, "hidden_optics_mrad") > HIDDEN_MRAD


def weight(chosen: PoseEstimate) -> Check:
    """Share of the hits' weight that `batch` does not use."""
    lost = _detail(chosen, "weight_lost")
    cases = Case.WEIGHT, Case.WEIGHT_LOST, Case.WEIGHT_UNKNOWN
    grade, names = graded(lost, WEIGHT_LOST), _recording(chosen, "weight_lost_in")
    check = judged("weight of hits", cases, lost, "", grade, percent=100 * lost)
    return replace(check, names=names)


def _recording(chosen: PoseEstimate, name: str) -> tuple[str, ...]:
    """The recording of a setup that a detail names, if any."""
    where = (chosen.details or {}).get(name)
    return (where,) if isinstance(where, str) else ()


def priors(chosen: PoseEstimate) -> Check:
    """Board and optics as estimated, held against what was known of them, and the size of the board
    against a known length."""
    p, of_scale = _detail(chosen, "prior_p"), _detail(chosen, "scale_p", 1.0)
    apart = p < PRIOR_P[1] or of_scale < SCALE_P
    p = min(p, of_scale)  # NaN where the first is
    word = "doubtful" if apart else "good" if p >= PRIOR_P[0] else "usable"
    cases = Case.PRIORS, Case.PRIORS_LEFT, Case.PRIORS_UNKNOWN
    return judged("board and optics", cases, p, "", (word, PRIOR_P[word != "good"]))


def length(chosen: PoseEstimate) -> Iterator[Check]:
    """Check of a known length: how much of the scale rests on it, how far the board disagrees with
    it, and whether an error of it would be noticed at all, which no recording changes."""
    sigma = _detail(chosen, "board_sigma")
    if math.isfinite(sigma):
        keys = {"larger": "board_larger", "percent": "length_share"}
        numbers = {name: 100 * _detail(chosen, key) for name, key in keys.items()}
        agrees = _detail(chosen, "scale_p") >= PRIOR_P[0]
        limit = float(np.sqrt(chdtri(1, PRIOR_P[0])))
        yield Check("known length", Case.LENGTH, sigma, "", limit, agrees, "good", numbers)
        error, own = limit * _detail(chosen, "length_check_sd"), _detail(chosen, "length_sd")
        numbers, seen = {"percent": 100 * error}, error < UNNOTICED * own
        case = Case.SCALE if seen else Case.SCALE_OPEN
        yield Check("scale", case, error / own, "", UNNOTICED, seen, "good", numbers)


def misfit(chosen: PoseEstimate) -> Check:
    """Pieces of a recording that differ by more than noise makes of them. What no step explains of
    that is of wrong optics or a wrong board, of which pieces show a small part only."""
    times = _detail(chosen, "misfit")
    cases, grade = (Case.MISFIT_NONE, Case.MISFIT, Case.MISFIT_UNKNOWN), graded(times, MISFIT)
    left = _detail(chosen, "misfit_left", times)
    if left >= UNEXPLAINED and chosen.stage != "static":
        cases = Case.MISFIT_NONE, Case.MISFIT_OPEN, Case.MISFIT_UNKNOWN
        grade = "doubtful", UNEXPLAINED
    return judged("pieces agree", cases, times, "", grade, times=math.sqrt(times))


def weighted(chosen: PoseEstimate, noise: float) -> Check:
    """What errors of the board's path do not explain."""
    name, value = "angles beyond the path", chosen.weighted_rms_urad
    word, limit = graded(value / noise, WEIGHTED)
    cases = Case.PATH_ERRORS, Case.BEYOND_PATH, Case.PATH_ERRORS_UNKNOWN
    return judged(name, cases, value, "urad", (word, limit * noise), noise=noise)


def halves(chosen: PoseEstimate) -> Check:
    """A station that was moved meanwhile, within a recording or between two: parts of the data have
    different poses."""
    parts = chosen.halves
    name = "recordings agree" if parts is not None and parts.recordings else "halves agree"
    if parts is None or not math.isfinite(parts.m2):
        return unknown(name, Case.HALVES_UNKNOWN, "")
    value, limits = parts.m2, HALVES_BATCH if chosen.estimator == "batch" else HALVES_M2
    if parts.stepped is False:  # sigma includes the misfit
        value /= max(_detail(chosen, "misfit", 1.0), 1.0)
    by_step = {True: Case.HALVES_APART, False: Case.HALVES_MISFIT, None: Case.HALVES_OPEN}
    cases = Case.HALVES, by_step[parts.stepped]
    if parts.recordings:
        cases = Case.RECORDINGS, Case.RECORDINGS_APART
    numbers = {"mm": parts.mm, "deg": parts.deg, "times": math.sqrt(parts.m2 / 6)}
    check = judged(name, cases, value, "", graded(value, limits), **numbers)
    return replace(check, names=_recording(chosen, "halves_of"))


def mirrored(chosen: PoseEstimate) -> Check:
    """Board poses in the wrong of two minima."""
    share, name = chosen.mirrored_share, "mirrored board poses"
    failed = share > MIRRORED_FAILED
    grade = ("failed", MIRRORED_FAILED) if failed else graded(share, MIRRORED)
    wrong = Case.MIRRORED_BOTH if chosen.estimator == "paper-lm" else Case.MIRRORED_FLAT
    cases = Case.MIRRORED, wrong, Case.MIRRORED_UNKNOWN
    return judged(name, cases, share, "", grade, percent=100 * share)


def motion(chosen: PoseEstimate) -> Check:
    """Whether the board moved: a board at rest gives no more than one pose."""
    moved = chosen.stage != "static"
    case, level = (Case.MOVED, "good") if moved else (Case.STILL, "usable")
    return Check("motion", case, chosen.stage, "", "moving", moved, level)


def common_measurements(chosen: PoseEstimate, n_common: int | None) -> Check:
    """Moments at which both stations saw the board, which `batch` does not need."""
    name = "common measurements"
    if n_common is None or chosen.stage == "static":
        return unknown(name, Case.COMMON_UNNEEDED, "")
    grade = graded_low(n_common, (0, 0) if chosen.estimator == "batch" else COMMON)
    return judged(name, (Case.COMMON, Case.COMMON_FEW), n_common, "", grade)


def places_urad(places_m: float, range_m: float, n_diodes: int) -> float:
    """rms of angles that errors of the diodes' places, of so large a standard deviation, make
    beside a board pose at a range, one time in a thousand."""
    freedom = max(2 * n_diodes - 6, 1)
    return 1e6 * places_m / range_m * math.sqrt(float(chdtri(freedom, 1e-3)) / freedom)


def board_poses(
    board_rms_urad: float | None, noise: float, by_places: float = 0.0, unused: bool = False
) -> Check:
    """K_1 of single board poses: what a wrong board file or reflections raise, and motion or the
    optics of the other station do not. by_places: as large as errors of the board make it; unused:
    the pose is of none of them."""
    name = "board poses"
    if board_rms_urad is None:
        return unknown(name, Case.BOARD_POSES_NONE, "urad")
    both = math.hypot(noise, by_places)
    limits = BOARD[0] * both, max(BOARD[1] * noise, BOARD_PLACES * both)
    cases = Case.BOARD_POSES, Case.BOARD_POSES_HIGH
    check = judged(name, cases, board_rms_urad, "urad", graded(board_rms_urad, limits))
    return replace(check, level="good") if unused else check


def path(chosen: PoseEstimate, span_m: float | None) -> Check:
    """Whether the path is long enough for estimators that superpose paths."""
    if chosen.stage == "final" and chosen.estimator in ("batch", "paper-lm"):
        return unknown("path", Case.PATH_UNNEEDED, "m")
    if span_m is None or chosen.stage == "static":
        return unknown("path", Case.PATH_NONE, "m")
    return judged("path", (Case.PATH, Case.PATH_SHORT), span_m, "m", graded_low(span_m, SPAN_M))


def uncertainty(chosen: PoseEstimate) -> Check:
    """The worst axes of the covariance. The share of the scale of the board, which the sentence
    states, raises the limit: it is the same for every distance, and no sign of a wrong pose."""
    name = "uncertainty"
    if chosen.covariance is None:
        return unknown(name, Case.UNCERTAINTY_NONE, "mm")
    sd = np.sqrt(np.diag(chosen.covariance))
    mm, deg = float(sd[:3].max()), float(sd[3:].max())
    if not np.isfinite(sd).all():
        case, level = Case.UNCERTAINTY_UNKNOWN, "doubtful"
        return Check(name, case, mm, "mm", "finite", False, level, {"deg": deg})
    whole = chosen.estimator == "batch"
    far = max(float(np.linalg.norm(chosen.t_m)) / FAR_M, 1.0)
    limits: Sequence[tuple[float, float]] = SIGMA
    case, numbers = Case.UNCERTAINTY, {"deg": deg}
    if whole:
        share = _detail(chosen, "scale_share", 0.0)
        far /= math.sqrt(1 - min(share, MOST_SCALE))
        limits = [(far * most, angle) for most, angle in SIGMA_BATCH]
        case = Case.UNCERTAINTY_ALL if share < SCALE_SHARE else Case.UNCERTAINTY_SCALE
        of_scale_mm, far_m = math.sqrt(share) * np.linalg.norm(sd[:3]), np.linalg.norm(chosen.t_m)
        numbers |= {"percent": 100 * share, "size": 0.1 * float(of_scale_mm / far_m)}
    return judged(name, (case, case), mm, "mm", worst(mm, deg, limits), **numbers)


def duration(duration_s: float | None) -> Check:
    """Whether the recording has a usual length."""
    if duration_s is None:
        return unknown("duration", Case.DURATION_UNKNOWN, "s")
    usual = USUAL_S - 0.01 <= duration_s <= USUAL_LONGEST_S
    short = duration_s < SHORT_S
    case = Case.DURATION if usual else Case.DURATION_SHORT if short else Case.DURATION_UNUSUAL
    level = "usable" if short else "good"
    return Check("duration", case, duration_s, "s", SHORT_S, not short, level)
