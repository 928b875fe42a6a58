"""Errors of the begins of turns, which all hits of some tenths of a second share.

A station of the second generation tells by its light when a turn began, with noise; `decode.wander`
smooths it. What is left moves both planes of neighbouring turns together. It is no unknown, but
what it does to the estimate goes into the covariance: an error u of the begins pulls at the global
unknowns, the trajectory and the offsets of sweeps eliminated, by P' u, so they are pulled with the
covariance P' C P, C as in `decode.wander`. The noise of sweeps is estimated with the variance of u
in it, which is taken out again.
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.kernel import POSE, SPAN
from mocap_metrology.lighthouse.batch.recording import Recording
from mocap_metrology.lighthouse.batch.solve import Reduced, Sums
from mocap_metrology.lighthouse.decode.wander import TurnClock


def pull_of_begins(one: Recording, sums: Sums, part: Reduced) -> Floats:
    """P' C P of a recording, or a piece of it, by its normal equations, and these without the
    trajectory; 0 for stations that tell no begins."""
    first, noise = one.sweeps.first[:-1], one.noise
    station, turn = one.sweeps.hits.station[first], one.sweeps.hits.cycle[first]
    open_ = 1 / (1 + (noise.sweep / noise.hit) ** 2 / sums.held * sums.weight)
    total, last = np.zeros_like(part.S), len(part.A_C) - 1
    for k, clock in enumerate(one.clocks):
        own = np.flatnonzero(station == k)
        if not isinstance(clock, TurnClock) or not own.size:
            continue
        pull, low = sums.of_sweep_inner[own], POSE * sums.begin[own]
        for j in range(SPAN):
            row = np.minimum(low + j, last)  # beyond the last, `of_sweep` is 0
            pull = pull - sums.of_sweep[own, j, None] * part.A_C[row]
        rad_per_s = 2 * np.pi / clock.cycle_s
        pull *= rad_per_s * open_[own, None] / noise.hit**2
        twice = min(clock.variance, (noise.sweep / rad_per_s) ** 2)
        total += clock.error_of(pull, turn[own]) - twice * pull.T @ pull
    return total
