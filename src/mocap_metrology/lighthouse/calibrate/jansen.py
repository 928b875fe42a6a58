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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.calibrate.agreement import Agreed, agreed_paths
from mocap_metrology.lighthouse.calibrate.batch import ESTIMATED, Scene, solved
from mocap_metrology.lighthouse.calibrate.batch import NAME as BATCH
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics, optics_of, reconstruct
from mocap_metrology.lighthouse.calibrate.stages import (
    FEWEST_POSES,
    INTERPOLATIONS,
    MM_DEG,
    OPTICS,
    PEERS,
    SIMPLEX,
    Calibration,
    CalibrationSettings,
    both_stages,
)
from mocap_metrology.lighthouse.calibrate.static import is_still, median_angles, static_pose
from mocap_metrology.lighthouse.calibrate.variants import AUTO, best_variant, widened
from mocap_metrology.lighthouse.fit import board_pose
from mocap_metrology.lighthouse.records import (
    MASTER,
    ROLES,
    SLAVE,
    Factory,
    Hits,
    Measurements,
    PoseEstimate,
)

__all__ = [
    "Calibration",
    "CalibrationSettings",
    "calibrate",
    "chosen",
]


def calibrate(
    hits: Hits,
    board: np.ndarray,
    factories: Sequence[Factory | None],
    settings: CalibrationSettings | None = None,
    report: Callable[[str], None] = lambda line: None,
) -> Calibration:
    """Pose of the slave in the master's frame by every requested estimator and optics.

    hits: cleaned, of both stations; board (n, 3) in metres; factories: of master and slave, None
    where unknown (then `factory` optics are left out). `report` is called with one line a step.

    Raises `Refusal` where a station has fewer than `FEWEST_POSES` measurements of four diodes.
    """
    settings = settings or CalibrationSettings()
    smooth = INTERPOLATIONS[settings.lm_interpolation]
    orders = {smooth} if set(settings.estimators) <= {"paper-lm", BATCH} else {1, smooth}
    measured = {order: _measured(hits, board, settings, order) for order in orders}
    for role, moments in zip(ROLES, measured[smooth], strict=True):
        if len(moments) < FEWEST_POSES:
            raise Refusal(
                f"{role}: {len(moments)} moments with both angles of four diodes;"
                f" expected at least {FEWEST_POSES}"
            )
    found = Calibration()
    for name in settings.optics:
        if name == "factory" and any(factory is None for factory in factories):
            found.why.append("factory optics omitted: factory values of both stations are needed")
            continue
        if name == ESTIMATED and "factory" in settings.optics and None not in factories:
            continue  # these values are better known
        own, near = settings, None
        if name == "factory" and settings.variant == AUTO:
            middle, lasers = _middle(hits, len(board)), settings.lasers_m
            variant, ways = best_variant(measured[smooth], middle, board, factories, lasers, smooth)
            own = replace(settings, variant=variant)
            near = next((way.R for way in ways if way.standing == "chosen"), None)
            found = replace(found, variants=ways)
        seen = {
            order: optics_of(
                "ideal" if name == ESTIMATED else name,
                both,
                factories,
                settings.lasers_m,
                own.variant,
            )
            for order, both in measured.items()
        }
        agreed = agreed_paths(seen[smooth], board, smooth, near)
        scene = Scene(hits, board, name, factories, settings.lasers_m, own.variant, settings.priors)
        found = _by_optics(found, scene, seen, agreed, own, report)
    ways = found.variants
    return replace(
        found,
        estimates=[widened(e, ways) if e.optics == "factory" else e for e in found.estimates],
    )


def _by_optics(
    found: Calibration,
    scene: Scene,
    seen: Mapping[int, Optics],
    agreed: Agreed,
    settings: CalibrationSettings,
    report: Callable[[str], None],
) -> Calibration:
    """By all estimators. seen: measurements by the degree of their interpolation."""
    name, board = scene.optics, scene.board
    if all(is_still(path) for path in agreed.paths):
        middle = _middle(scene.hits, len(board))
        if name != ESTIMATED:
            found.estimates.extend(_static(middle, board, name, scene.factories, settings))
            found.paths["paper-lm", name] = agreed.paths
        return _with_batch(replace(found, still=True), scene, settings, report, middle)
    smooth = INTERPOLATIONS[settings.lm_interpolation]
    for estimator in settings.estimators if name != ESTIMATED else (BATCH,):
        if estimator == BATCH:
            found = _with_batch(found, scene, settings, report)
            continue
        if estimator in SIMPLEX and name not in settings.simplex_optics:
            continue
        if estimator in PEERS and settings.lasers_m is not None:
            found.why.append(
                f"{estimator}, {name}: omitted, it does not model the positions of the lasers"
            )
            continue
        order = smooth if estimator == "paper-lm" else 1
        found = both_stages(found, estimator, seen[order], order, board, agreed, settings, report)
    return found


def _with_batch(
    found: Calibration,
    scene: Scene,
    settings: CalibrationSettings,
    report: Callable[[str], None],
    still: tuple[Measurements, Measurements] | None = None,
) -> Calibration:
    """The estimate by `batch`, or why there is none."""
    if BATCH not in settings.estimators:
        return found
    try:
        pose, joint = solved(scene, still)
    except Refusal as refusal:
        report(str(refusal))
        return replace(found, why=[*found.why, str(refusal)])
    report(f"{BATCH}, {scene.optics}: {pose.seconds:.2f} s")
    joints = {**found.joints, scene.optics: (scene, joint)}
    return replace(found, estimates=[*found.estimates, pose], joints=joints)


def _middle(hits: Hits, n_diodes: int) -> tuple[Measurements, Measurements]:
    """Median angles of each diode, of master and slave."""
    return median_angles(hits, MASTER, n_diodes), median_angles(hits, SLAVE, n_diodes)


def _measured(
    hits: Hits, board: np.ndarray, settings: CalibrationSettings, order: int
) -> tuple[Measurements, Measurements]:
    """Measurements of master and slave (J IV)."""
    master, slave = (
        reconstruct(hits, station, len(board), settings.reconstruction, order)
        for station in (MASTER, SLAVE)
    )
    return board_pose.well_posed(master, board), board_pose.well_posed(slave, board)


def _static(
    middle: tuple[Measurements, Measurements],
    board: np.ndarray,
    name: str,
    factories: Sequence[Factory | None],
    settings: CalibrationSettings,
) -> list[PoseEstimate]:
    """Stage `static` from the median angles of each diode."""
    still = optics_of(name, middle, factories, settings.lasers_m, settings.variant)
    pose = static_pose(list(still.measurements), board, list(still.rotors))
    if pose is None:
        return []
    return [
        PoseEstimate(
            estimator="paper-lm",
            stage="static",
            optics=name,
            R=pose.R,
            t_m=pose.t_m,
            frame=still.frame,
            covariance=pose.covariance * MM_DEG,
            residual_rms_urad=1e6 * pose.residual_rms_rad,
            n_angles=pose.n_angles,
            note="; ".join(pose.notes),
        )
    ]


def chosen(estimates: Sequence[PoseEstimate]) -> int | None:
    """Index of the estimate to use: factory optics before estimated before ideal, batch before
    paper-lm before the simplex, final before Kabsch; None if there is none."""
    order = [
        (BATCH, "static"),
        (BATCH, "final"),
        ("paper-lm", "static"),
        ("paper-lm", "final"),
        ("paper-lm", "kabsch"),
        *((e, s) for e in ("paper", "paper-tight", *PEERS) for s in ("kabsch", "final")),
    ]
    ranked = [
        (OPTICS[::-1].index(e.optics), order.index((e.estimator, e.stage)), index)
        for index, e in enumerate(estimates)
        if np.isfinite(e.t_m).all()
    ]
    return min(ranked)[2] if ranked else None
