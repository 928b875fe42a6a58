"""Hits as a trajectory sees them: residuals, and what each hit counts for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.lighthouse.batch import kernel, sweep_kernel
from mocap_metrology.lighthouse.batch.problem import State, Sweeps
from mocap_metrology.lighthouse.batch.trajectory import Trajectory

LIMIT = 3.5  # of |z|, beyond which a hit loses weight: of good hits 1 in 2000


@dataclass(frozen=True)
class Noise:
    """Standard deviations in rad: of a hit alone, and of the offset that a sweep's hits share."""

    hit: float
    sweep: float


@dataclass(frozen=True)
class View:
    """Hits with what the trajectory's knots fix about them: first control point and weights of
    each, and the reference rotation at its time."""

    sweeps: Sweeps
    who: np.ndarray
    basis: np.ndarray
    turned: np.ndarray

    @property
    def light(self) -> kernel.Light:
        """Likewise, for the kernels."""
        return kernel.Light(self.who, self.basis, self.turned)

    @property
    def begin(self) -> np.ndarray:
        """First control point of each sweep."""
        return np.minimum.reduceat(self.who[:, 3], self.sweeps.first[:-1])


def sweeps_of(seen: View, chosen: np.ndarray) -> View:
    """The view of some sweeps, bool (sweeps,)."""
    hit = chosen[seen.sweeps.sweep]
    first = np.append(0, np.cumsum(np.diff(seen.sweeps.first)[chosen]))
    own = Sweeps(seen.sweeps.hits.take(hit), first)
    return View(own, seen.who[hit], seen.basis[hit], seen.turned[hit])


def stretch(seen: View, trajectory: Trajectory) -> tuple[View, Trajectory]:
    """Likewise through the control points alone that the hits touch: the others, of which only the
    bends are known, go straight on at no cost."""
    low, high = seen.who[:, 3].min(), seen.who[:, 3].max() + 4
    own = replace(trajectory, control=trajectory.control[low:high])
    return replace(seen, who=seen.who - np.array([0, 0, 0, low])), own


def view(sweeps: Sweeps, trajectory: Trajectory) -> View:
    """Of hits, through a trajectory."""
    hits = sweeps.hits
    first, basis = trajectory.basis(hits.time_s)
    who = np.column_stack([hits.station, hits.axis, hits.diode, first]).astype(np.int64)
    return View(sweeps, who, basis, np.ascontiguousarray(trajectory.reference(hits.time_s)))


def residuals(seen: View, trajectory: Trajectory, state: State) -> np.ndarray:
    """Predicted minus measured angle of every hit, rad."""
    return kernel.predicted(seen.light, trajectory.control, state) - seen.sweeps.hits.angle_rad


@dataclass(frozen=True)
class Weights:
    """Weight of each hit; offset in rad, the weight of what is known of it, and robust cost of
    each sweep."""

    hit: np.ndarray
    offset: np.ndarray
    held: np.ndarray
    cost: np.ndarray


def weights(
    seen: View, residual: np.ndarray, noise: Noise, share: np.ndarray | None = None
) -> Weights:
    """Of hits by their residuals; share: of each as `share.shares`, 1 without it."""
    n = seen.sweeps.first.size - 1
    found = Weights(np.empty(residual.size), *np.empty((3, n)))
    first, hit, sweep = seen.sweeps.first, noise.hit, noise.sweep
    share = np.ones(residual.size) if share is None else share
    of_sweep = found.offset, found.held, found.cost
    sweep_kernel.robust(first, residual, hit, sweep, LIMIT, share, found.hit, *of_sweep)
    return found
