"""The calibration of J from hits to the slave's pose, step by step, and its variants.

For each station: measurements (J IV), board poses (V-A, VI-A and VI-B); then the path of the slave
at the times of the master's (VI-C), Kabsch (VI-D, VI-E: stage `kabsch`), and the slave's pose from
its own angles of the master's path (V-B, VI-F: stage `final`).

    paper         simplex with the settings of MATLAB, each board pose from J's first guess
    paper-tight   simplex with tight tolerances, each from the pose before it
    paper-lm      Levenberg-Marquardt with the mirror test in place of the simplex, cubic
                  interpolation in place of linear (J IV: a more accurate way is left to others),
                  and K_2 weighted for the errors of the path, which J assumes exact
    batch         all hits at their own times, board and stations in one estimate: see `batch`
    pnp           EPnP or IPPE for board poses (J V-A, Zheng, Yang): stage `kabsch` only
    geometric     root finding on ranges (J V-A, Islam, Kleinschmidt): stage `kabsch` only

A board at rest has no path for Kabsch: then there is one stage, `static`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.parallel import MapFunction, in_turn
from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.calibrate import stages, variants
from mocap_metrology.lighthouse.calibrate.batch import solved
from mocap_metrology.lighthouse.calibrate.network import views
from mocap_metrology.lighthouse.calibrate.reconstruction import reconstruct
from mocap_metrology.lighthouse.calibrate.scene import ESTIMATED, Scene, Sensors, faced, sightings
from mocap_metrology.lighthouse.calibrate.scene import NAME as BATCH
from mocap_metrology.lighthouse.calibrate.setup import calibrate_stations
from mocap_metrology.lighthouse.calibrate.stages import Calibration, CalibrationSettings, Seen
from mocap_metrology.lighthouse.calibrate.static import static_pose
from mocap_metrology.lighthouse.calibrate.variants import best_joint, exchanged
from mocap_metrology.lighthouse.fit import board_pose

FAILED_M2 = 22.46  # of halves of batch: by chance one time in a thousand
FAILED_RATIO = 0.5  # of the differences of halves

__all__ = ["Calibration", "CalibrationSettings", "calibrate", "chosen"]


def calibrate(
    hits: records.Hits,
    board: np.ndarray,
    factories: Sequence[records.Factory | None],
    settings: CalibrationSettings | None = None,
    report: Callable[[str], None] = lambda line: None,
    over: MapFunction = in_turn,
    sensors: Sensors | None = None,
    stations: Sequence[records.Station] | None = None,
) -> Calibration:
    """Pose of the slave in the master's frame by every requested estimator and optics.

    hits: cleaned, of both stations; board (n, 3) in metres; factories: of master and slave, None
    where unknown (then `factory` optics are left out). `report` is called with one line a step;
    over: how the optics are worked on; sensors: what `batch` uses besides hits; stations:
    they, where they may be of the second generation, which `batch` alone estimates
    (`calibrate_stations`).

    Raises `Refusal` where a station has fewer than `FEWEST_POSES` measurements of four diodes.
    """
    settings = settings or CalibrationSettings()
    if stations is not None and stations[0].generation == 2:
        return calibrate_stations(hits, board, stations, settings, report, sensors)
    smooth = stages.INTERPOLATIONS[settings.lm_interpolation]
    orders = {smooth} if set(settings.estimators) <= {"paper-lm", BATCH} else {1, smooth}
    measured = {}
    for order in orders:  # of master and slave (J IV)
        master, slave = (
            reconstruct(hits, station, len(board), settings.reconstruction, order)
            for station in (records.MASTER, records.SLAVE)
        )
        both = board_pose.well_posed(master, board), board_pose.well_posed(slave, board)
        measured[order] = both
    if len(hits) and min(map(len, measured[smooth])) < stages.FEWEST_POSES:  # most hits are lost
        master, slave = views(hits, board)
        measured = dict.fromkeys(orders, (master, slave))
    for role, moments in zip(records.ROLES, measured[smooth], strict=True):
        if len(moments) < stages.FEWEST_POSES:
            raise Refusal(
                f"{role}: {len(moments)} moments with both angles of four diodes;"
                f" expected at least {stages.FEWEST_POSES}"
            )

    def by_optics(name: str) -> Calibration:
        if name == "factory" and any(factory is None for factory in factories):
            why = "factory optics omitted: factory values of both stations are needed"
            return Calibration(why=[why])
        if name == ESTIMATED and "factory" in settings.optics and None not in factories:
            return Calibration()  # these values are better known
        auto = name == "factory" and settings.variant == variants.AUTO
        how = settings.lasers_m, variants.FALLBACK if auto else settings.variant, settings.priors
        scene = Scene(hits, board, name, factories, *how, sensors=sensors or Sensors())
        try:
            seen, calibration = Seen(scene, measured, smooth), Calibration()
            seen.scene, why = faced(scene, map(sightings, measured[smooth], seen.agreed.paths))
            if why:
                calibration.why.append(f"{scene.title}: {why}")
            if auto:
                seen, calibration.variants = _best_variant(seen, BATCH in settings.estimators)
            _by_optics(calibration, seen, settings, report)
            return calibration
        except np.linalg.LinAlgError as error:
            return Calibration(why=[f"{name} optics: the hits do not determine a pose ({error})"])

    calibration = Calibration()
    for one in over(by_optics, settings.optics):
        calibration.estimates += one.estimates
        calibration.paths |= one.paths
        calibration.still |= one.still
        calibration.n_common = max(calibration.n_common, one.n_common)
        calibration.why += one.why
        calibration.variants += one.variants
        calibration.joints |= one.joints
    known = calibration.joints.get("factory")
    calibration.exchanged = exchanged(*known, stations) if known and stations else ()
    for k, pose in enumerate(calibration.estimates):
        if pose.optics == "factory":
            calibration.estimates[k] = variants.widened(pose, calibration.variants)
    return calibration


def _best_variant(seen: Seen, by_batch: bool) -> tuple[Seen, list[variants.VariantFit]]:
    """The optics with the best variant of the rotor model, and all variants; by_batch: the board
    moves."""
    scene, joint, begun = seen.scene, None, time.perf_counter()
    ways: list[variants.VariantFit] = []
    if variants.all_one(scene.factories):
        return seen, []
    if by_batch and not seen.still:
        try:
            ways, joint = best_joint(scene)
        except Refusal:  # where `batch` fails, its own estimate will say why
            joint = None
    if joint is None:
        ways = variants.best_variant(scene, seen.measured[seen.smooth], seen.middle, seen.smooth)
    best = next((way for way in ways if way.standing == "chosen"), None)
    seconds = time.perf_counter() - begun
    if best is not None and best.variant != scene.variant:
        scene = replace(scene, variant=best.variant)
        seen = Seen(scene, seen.measured, seen.smooth, best.R)
    seen.joint, seen.seconds = joint, seconds if joint else 0.0
    return seen, ways


def _by_optics(
    calibration: Calibration,
    seen: Seen,
    settings: CalibrationSettings,
    report: Callable[[str], None],
) -> None:
    """The calibration with the estimates of all estimators for these optics."""
    name = seen.scene.optics
    if seen.still:
        calibration.still = True
        if name != ESTIMATED:
            _static(calibration, seen)
            calibration.paths["paper-lm", name] = seen.agreed.paths
        if BATCH in settings.estimators:
            _with_batch(calibration, seen, report)
            if name == "factory":
                calibration.variants = [_by_batch(way, seen) for way in calibration.variants]
        return
    for estimator in settings.estimators:
        if estimator == BATCH:
            _with_batch(calibration, seen, report)
        elif name == ESTIMATED or (
            estimator in stages.SIMPLEX and name not in settings.simplex_optics
        ):
            continue
        elif estimator in stages.PEERS and settings.lasers_m is not None:
            why = "omitted, it does not model the positions of the lasers"
            calibration.why.append(f"{estimator}, {name}: {why}")
        else:
            stages.both_stages(calibration, estimator, seen, settings, report)


def _by_batch(way: variants.VariantFit, seen: Seen) -> variants.VariantFit:
    """A variant that is not excluded with its pose by `batch`, in which the depths of lasers
    imitate others; as it is where that finds none."""
    if way.standing == "worse":
        return way
    try:
        pose, _ = solved(replace(seen.scene, variant=way.variant), seen.middle)
    except Refusal:
        return way
    return replace(way, R=pose.R, t_m=pose.t_m)


def _with_batch(calibration: Calibration, seen: Seen, report: Callable[[str], None]) -> None:
    """The estimate by `batch`, or why there is none."""
    try:
        pose, joint = solved(seen.scene, seen.middle if seen.still else None, seen.joint)
    except Refusal as refusal:
        report(str(refusal))
        calibration.why.append(str(refusal))
        return
    pose = replace(pose, seconds=pose.seconds + seen.seconds)
    report(f"{BATCH}, {seen.scene.optics}: {pose.seconds:.2f} s")
    calibration.joints[seen.scene.optics] = seen.scene, joint
    calibration.estimates.append(pose)


def _static(calibration: Calibration, seen: Seen) -> None:
    """Stage `static` from the median angles of each diode."""
    scene, still = seen.scene, seen.scene.seen(seen.middle)
    pose = static_pose(list(still.measurements), scene.board, list(still.rotors))
    if pose is not None:
        calibration.estimates.append(
            records.PoseEstimate(
                estimator="paper-lm",
                stage="static",
                optics=scene.optics,
                R=pose.R,
                t_m=pose.t_m,
                frame=still.frame,
                covariance=pose.covariance * stages.MM_DEG,
                residual_rms_urad=1e6 * pose.residual_rms_rad,
                n_angles=pose.n_angles,
                note="; ".join(pose.notes),
            )
        )


def chosen(estimates: Sequence[records.PoseEstimate]) -> int | None:
    """Index of the estimate to use: factory optics before estimated before ideal, batch before
    paper-lm before the simplex, final before Kabsch; None if there is none.

    paper-lm comes before a batch that fails at what neither used: from one part of the recording
    the pose by the other, which batch misses by more than chance, and paper-lm less than half as
    far."""
    order = [(e, s) for e in (BATCH, "paper-lm") for s in ("static", "final", "kabsch")]
    order += [(e, s) for e in ("paper", "paper-tight", *stages.PEERS) for s in ("kabsch", "final")]
    final = {(e.optics, e.estimator): e.halves for e in estimates if e.stage == "final"}

    def failed(e: records.PoseEstimate) -> bool:
        halves, other = e.halves, final.get((e.optics, "paper-lm"))
        if e.estimator != BATCH or halves is None or other is None or halves.m2 < FAILED_M2:
            return False
        return max(other.mm / halves.mm, other.deg / halves.deg) < FAILED_RATIO

    ranked = [
        (stages.OPTICS[::-1].index(e.optics), failed(e), order.index((e.estimator, e.stage)), index)
        for index, e in enumerate(estimates)
        if np.isfinite(e.t_m).all()
    ]
    return min(ranked)[3] if ranked else None
