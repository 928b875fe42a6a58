"""Fits of a recording by every variant of the rotor model, for `variants.weigh`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mocap_metrology.lighthouse.calibrate import station_pose
from mocap_metrology.lighthouse.calibrate.agreement import Agreed
from mocap_metrology.lighthouse.calibrate.final import agreed_paths, last_step, seen_on_path
from mocap_metrology.lighthouse.calibrate.optics import Optics, optics_of
from mocap_metrology.lighthouse.calibrate.reconstruction import Measurements
from mocap_metrology.lighthouse.calibrate.static import is_still, residuals_by_diode, static_pose
from mocap_metrology.lighthouse.calibrate.variants import (
    FALLBACK,
    NOISE_RAD,
    Fit,
    Weighed,
    expected_loss,
    units_of,
    weigh,
)
from mocap_metrology.lighthouse.calibrate.weighted_station import evidence, residuals
from mocap_metrology.lighthouse.records import MASTER, SLAVE, Factory
from mocap_metrology.lighthouse.rotor import VARIANTS, rotor_parameters

FEWEST = 20  # moments of both stations


def best_variant(
    measured: Sequence[Measurements],
    middle: Sequence[Measurements],
    board: np.ndarray,
    factories: Sequence[Factory],
    lasers_m: np.ndarray | None,
    order: int,
) -> tuple[str, list[Weighed]]:
    """The variant that leaves least of the recording, and how all of them stand.

    measured: of master and slave; middle: the median angles of each diode, which count where the
    board keeps its place. `FALLBACK` and no list where all are one or none can be fitted.
    """
    names = [FALLBACK, *(name for name in VARIANTS if name != FALLBACK)]
    models = [[rotor_parameters(f, None, VARIANTS[name]) for f in factories] for name in names]
    if all(np.array_equal(models[0], model) for model in models):  # as of ideal rotors
        return FALLBACK, []
    fits, near = [], None
    for name in names:
        optics = optics_of("factory", measured, factories, lasers_m, name)
        agreed = agreed_paths(optics, board, order, near)
        near = agreed.R
        if all(is_still(path) for path in agreed.paths):
            still = optics_of("factory", middle, factories, lasers_m, name)
            fit = _at_rest(name, still, board)
        else:
            fit = _moving(name, optics, agreed, board, order)
        if fit is None:
            return FALLBACK, []
        fits.append(fit)
    if len({fit.loss.size for fit in fits}) > 1:  # still by one variant, moving by another
        return FALLBACK, []
    weighed = weigh(fits)
    return next(w.variant for w in weighed if w.standing == "chosen"), weighed


def _moving(name: str, optics: Optics, agreed: Agreed, board: np.ndarray, order: int) -> Fit | None:
    """K_1 of the master's board poses and the weighted K_2 of the slave's angles, by stretches."""
    then, own = seen_on_path(agreed.paths, optics, order)
    if agreed.R is None or len(then) < FEWEST:
        return None
    given, rotors = station_pose.scene(then, own, board), optics.rotors[SLAVE]
    weighed = evidence(then, own, optics.measurements[MASTER], board, optics.rotors[MASTER])
    R, t, _ = last_step([(agreed.R, agreed.t_m)], given, weighed, rotors)
    left, master = residuals(R, t, weighed, rotors), agreed.paths[MASTER]
    time = np.concatenate([master.time_s, then.time_s])
    angles = np.concatenate([master.n_angles, left.count])
    loss = np.concatenate([master.epsilon / np.maximum(master.n_angles, 1), left.cost])
    noise = expected_loss(master.epsilon, master.n_angles, len(left.count))
    return Fit(name, R, t, loss, angles, units_of(time, time.min(), time.max()), noise)


def _at_rest(name: str, optics: Optics, board: np.ndarray) -> Fit | None:
    """K_1 of both stations by diode."""
    pose = static_pose(list(optics.measurements), board, list(optics.rotors))
    if pose is None:
        return None
    loss = residuals_by_diode(list(optics.measurements), board, list(optics.rotors))
    noise = np.full(loss.size, NOISE_RAD**2)
    return Fit(name, pose.R, pose.t_m, loss, np.full(loss.size, 2), np.arange(loss.size), noise)
