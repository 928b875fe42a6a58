"""Stages `kabsch` and `final` of one estimator (J VI), and what a calibration chooses and finds."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate import pnp, weighted_station
from mocap_metrology.lighthouse.calibrate.agreement import agreed_paths
from mocap_metrology.lighthouse.calibrate.network import Network
from mocap_metrology.lighthouse.calibrate.scene import ESTIMATED, Scene
from mocap_metrology.lighthouse.calibrate.scene import NAME as BATCH
from mocap_metrology.lighthouse.calibrate.static import is_still, median_angles
from mocap_metrology.lighthouse.calibrate.superpose import at_times, superpose
from mocap_metrology.lighthouse.calibrate.variants import AUTO, VariantFit
from mocap_metrology.lighthouse.fit import board_pose
from mocap_metrology.lighthouse.fit.board_pose import MIRRORED_RAD, START_M, angle_between
from mocap_metrology.lighthouse.fit.simplex import MATLAB, TIGHT
from mocap_metrology.lighthouse.records import (
    COVARIANCE_UNITS,
    MASTER,
    SLAVE,
    Measurements,
    Path,
    PoseEstimate,
)
from mocap_metrology.lighthouse.rotation import mean

JANSEN = ("paper", "paper-tight", "paper-lm")
SIMPLEX = ("paper", "paper-tight")
PEERS = ("pnp", "geometric")
OPTICS = ("ideal", ESTIMATED, "factory")
INTERPOLATIONS = {"linear": 1, "cubic": 3}  # degree of the polynomial
FEWEST_POSES = 20  # moments of a station, and of both
MM_DEG = np.outer(COVARIANCE_UNITS, COVARIANCE_UNITS)  # of covariances in m and rad
LEAST_EPSILON = 1e-14  # rad^2: K_1 of noise-free angles, so that no weight is infinite


@dataclass(frozen=True)
class CalibrationSettings:
    """Named choices of a calibration.

    optics: `estimated` by batch only, and where `factory` is not possible or not requested;
    simplex_optics: those of paper and paper-tight, slow as they are; J's is ideal.
    lm_interpolation: linear or cubic, lm_weights: path or none, of paper-lm; the others
    interpolate linearly and take the path in K_2 as exact, as J;
    lasers_m (2 stations, 2 axes, 3): positions of the lasers in the station's frame, default its
    origin; variant: how factory values enter, one of `rotor.VARIANTS`, or `auto`: as the recording
    prefers, see `variants`; priors: of what is uncertain beside the poses, for `batch`.
    """

    estimators: Sequence[str] = (BATCH, *JANSEN)
    optics: Sequence[str] = ("ideal", "factory", ESTIMATED)
    simplex_optics: Sequence[str] = ("ideal",)
    reconstruction: str = "full-interpolation"
    lm_interpolation: str = "cubic"
    lm_weights: str = "path"
    start_distance_m: float = START_M
    lasers_m: np.ndarray | None = None
    variant: str = AUTO
    pnp_method: str = "auto"
    priors: Priors = field(default_factory=Priors)


@dataclass
class Calibration:
    """All estimates of one recording, and the paths they are based on.

    paths: (estimator, optics) -> paths of master and slave; why: reasons, one a line, for what
    could not be estimated; variants: of the rotor model, where the recording chose; joints: by
    optics, what `batch` was given, and its estimate; network: of any number of stations; exchanged:
    as `variants.exchanged`.
    """

    estimates: list[PoseEstimate] = field(default_factory=list)
    paths: dict[tuple[str, str], tuple[Path, ...]] = field(default_factory=dict)
    still: bool = False
    n_common: int = 0
    why: list[str] = field(default_factory=list)
    variants: list[VariantFit] = field(default_factory=list)
    joints: dict[str, tuple[Scene, Joint]] = field(default_factory=dict)
    network: Network | None = None
    exchanged: tuple[str, ...] = ()

    def paths_of(self, pose: PoseEstimate) -> tuple[Path, ...] | None:
        """Board poses behind an estimate; of `batch`, which has one trajectory, those of
        `paper-lm`."""
        name = "paper-lm" if pose.estimator == BATCH else pose.estimator
        return self.paths.get((name, "ideal" if pose.optics == ESTIMATED else pose.optics))


class Seen:
    """Measurements as some optics see them, by the degree of their interpolation, and board poses
    on which both stations agree; joint: the estimate by `batch` where the choice of the rotor model
    made it, in so many seconds."""

    def __init__(
        self,
        scene: Scene,
        measured: Mapping[int, tuple[Measurements, Measurements]],
        smooth: int,
        near: np.ndarray | None = None,
    ):
        self.scene, self.measured, self.smooth = scene, measured, smooth
        self.joint: tuple[Joint, str] | None = None
        self.seconds = 0.0
        self.seen = {order: scene.seen(both) for order, both in measured.items()}
        self.agreed = agreed_paths(self.seen[smooth], scene.board, smooth, near)
        self.still = all(is_still(path) for path in self.agreed.paths)

    @cached_property
    def middle(self) -> tuple[Measurements, Measurements]:
        """Median angles of each diode, of master and slave."""
        hits, n = self.scene.hits, len(self.scene.board)
        return median_angles(hits, MASTER, n), median_angles(hits, SLAVE, n)


def _path(
    estimator: str,
    measured: Measurements,
    rotors: np.ndarray,
    board: np.ndarray,
    settings: CalibrationSettings,
) -> Path:
    """Board poses in the frame of a station (J VI-A, VI-B) by another than `paper-lm`; the peers
    take both lasers to be at one point."""
    if estimator in JANSEN:
        tight = estimator == "paper-tight"
        how = TIGHT if tight else MATLAB, tight, settings.start_distance_m
        return board_pose.by_nelder_mead(measured, board, rotors, *how)
    if estimator == "pnp":
        R, t, cost = pnp.board_poses(measured.angles_rad, board, settings.pnp_method)
    else:
        R, t, cost = pnp.geometric_poses(measured.angles_rad, board)
    n_angles = 2 * measured.seen.sum(axis=1)
    path = Path(measured.time_s, R, t, cost, n_angles, np.full(len(measured), np.nan))
    return path.take(np.isfinite(cost) & np.isfinite(t).all(axis=1))


def both_stages(
    calibration: Calibration,
    estimator: str,
    seen: Seen,
    settings: CalibrationSettings,
    report: Callable[[str], None],
) -> None:
    """Stages `kabsch` and `final` of one estimator (J VI-C to VI-F)."""
    start, board, agreed = time.perf_counter(), seen.scene.board, seen.agreed
    order = seen.smooth if estimator == "paper-lm" else 1
    optics, paths = seen.seen[order], agreed.paths
    if estimator != "paper-lm":
        both = zip(optics.measurements, optics.rotors, strict=True)
        master, slave = (_path(estimator, *one, board, settings) for one in both)
        paths = master, slave
    master, slave = paths
    slave_then, inside = at_times(slave, master.time_s, order)
    master_then = master.take(inside)
    calibration.paths[estimator, optics.name] = paths
    if len(master_then) < FEWEST_POSES:
        calibration.why.append(
            f"{estimator}, {optics.name}: the board is seen by both stations at"
            f" {len(master_then)} moments; expected at least {FEWEST_POSES}"
        )
        return
    weight = 1 / np.maximum(master_then.epsilon + slave_then.epsilon, LEAST_EPSILON)
    R, t, spread = superpose(slave_then.t_m, master_then.t_m, weight, master_then.time_s)
    evidence = weighted_station.seen_on_path(paths, optics, board, order)
    share, turned = _mirrored_share(estimator, paths, agreed.paths, master_then, slave_then)

    def estimate(stage: str, R: np.ndarray, t: np.ndarray, cov: np.ndarray | None) -> PoseEstimate:
        there = weighted_station.residuals(R, t, evidence) if estimator == "paper-lm" else None
        return PoseEstimate(
            estimator=estimator,
            stage=stage,
            optics=optics.name,
            R=R,
            t_m=t,
            frame=optics.frame,
            covariance=None if cov is None else cov * MM_DEG,
            residual_rms_urad=1e6 * weighted_station.residual_rms(R, t, evidence),
            n_angles=2 * len(evidence.plain.points),
            mirrored_share=share,
            weighted_rms_urad=math.nan if there is None else there.rms_urad(),
            noise_gain=math.nan if there is None else there.noise_gain(),
            seconds=time.perf_counter() - start,
        )

    calibration.estimates.append(estimate("kabsch", R, t, spread))
    if estimator == "paper-lm":
        moved = np.median(master_then.t_m - slave_then.t_m @ turned.T, axis=0)
        # On a straight path positions leave the turn about it open, the board's rotations do not.
        starts = [(R, t), (turned, moved), *filter(None, [agreed.pose])]
        R, t, spread = weighted_station.last_step(starts, evidence, settings.lm_weights)
        parts = weighted_station.halves(R, t, evidence)
        calibration.estimates.append(replace(estimate("final", R, t, spread), halves=parts))
    elif estimator in JANSEN:
        tolerances = TIGHT if estimator == "paper-tight" else MATLAB
        R, t, _ = weighted_station.by_nelder_mead(R, t, evidence, tolerances)
        spread = weighted_station.covariance(R, t, evidence)
        calibration.estimates.append(estimate("final", R, t, spread))
    report(f"{estimator}, {optics.name}: {time.perf_counter() - start:.2f} s")
    calibration.n_common = max(calibration.n_common, len(master_then))


def _mirrored_share(
    estimator: str,
    paths: tuple[Path, Path],
    steady: tuple[Path, Path],
    master: Path,
    slave: Path,
) -> tuple[float, np.ndarray]:
    """Share of board poses more than 8 deg off those of `paper-lm`, or for these the share of
    moments at which both stations disagree so far; and the slave's rotation by that of the
    board."""
    relative = np.einsum("nij,nkj->nik", master.R, slave.R)
    turned = mean(relative)
    if estimator == "paper-lm":
        trace = np.einsum("nij,ij->n", relative, turned)
        off = np.arccos(np.clip((trace - 1) / 2, -1, 1))
    else:
        both = [
            (
                path.take(np.isin(path.time_s, best.time_s)),
                best.take(np.isin(best.time_s, path.time_s)),
            )
            for path, best in zip(paths, steady, strict=True)
        ]
        off = np.concatenate([angle_between(path, best) for path, best in both])
    return float((off > MIRRORED_RAD).mean()), turned
