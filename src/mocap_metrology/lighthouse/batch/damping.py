"""Damping of steps of a joint estimate, of each control point: one stretch in which hits are few or
wrong fails at steps that all others need, and damped alone it holds up no other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.kernel import POSE, SPAN
from mocap_metrology.lighthouse.batch.recording import Recording

RISE, SHARE = 0.01, 0.03  # of the cost, which is a chi squared; of the largest rise
REACH = np.ones(SPAN // POSE)  # control points of a sweep


def more_damping(
    damping: Sequence[Floats],
    least: Sequence[Floats],
    before: Sequence[Recording],
    after: Sequence[Recording],
    everywhere: bool,
) -> list[Floats]:
    """Ten times as much for control points of stretches in which a step raised the cost of the
    sweeps most, at least so much; for all, where no stretch has, or everywhere.

    damping, least (control points,): of each recording, times the diagonal.
    """
    rises = [
        np.bincount(own.seen.begin, then.weights().cost - own.weights().cost, its.size)
        for own, then, its in zip(before, after, damping, strict=True)
    ]
    much = max(RISE, SHARE * max(float(rise.max()) for rise in rises))
    worse = [np.convolve(rise > much, REACH)[: rise.size] > 0 for rise in rises]
    everywhere |= not any(own.any() for own in worse)
    return [
        np.where(own | everywhere, np.maximum(10 * its, low), its)
        for own, its, low in zip(worse, damping, least, strict=True)
    ]
