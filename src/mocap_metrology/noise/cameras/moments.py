"""Moments of a take's subsets out of its recordings, additions of cameras one by one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.cameras.covariance import block_sums, factors
from mocap_metrology.noise.cameras.diagnosis import N_BLOCKS, Moments
from mocap_metrology.noise.cameras.subsets import Addition

Read = Callable[[str, int], np.ndarray]  # recording, marker from 1 -> (3, n) coordinates in mm


def moments(
    found: Sequence[Addition],
    read: Read,
    n_markers: int,
    frame_rate_hz: float,
    n_frames: int,
    resolution_mm: Mapping[str, float] | None = None,
) -> Moments:
    """Moments at one frame, 0.1, 1 and 10 s as far as `n_frames`, the shortest recording, allows.

    Frames are matched by their number. Rounding to steps of `resolution_mm` (by recording) adds
    step^2 / 12 to the variance of every coordinate, white and on its own in each recording
    [Bennett 1948]; it is taken off. Markers without noise or that half of the time
    lacks are left out; refused if none is left.
    """
    chosen = factors(frame_rate_hz, n_frames, N_BLOCKS)
    if not chosen:
        raise Refusal(f"cameras: recordings of {n_frames} frames; expected {3 * N_BLOCKS} at least")
    sums = np.zeros((n_markers, len(chosen), len(found), N_BLOCKS, 6, 6))
    counts = np.zeros(sums.shape[:4])
    for marker in range(n_markers):
        for k, addition in enumerate(found):
            names = addition.smaller, addition.larger
            parts = [read(name, marker + 1) for name in names]
            both = np.concatenate([part[:, :n_frames] for part in parts])
            steps = [(resolution_mm or {}).get(name, 0.0) for name in names]
            rounding = np.diag(np.repeat(np.square(steps) / 12, 3))
            for t, m in enumerate(chosen):
                total, count = block_sums(both, m, N_BLOCKS)
                sums[marker, t, k] = total - count[:, None, None] * rounding / m
                counts[marker, t, k] = count
    markers = [k for k in range(n_markers) if _usable(sums[k, 0], counts[k, 0])]
    if not markers:
        raise Refusal(
            "cameras: no marker with noise in every direction and enough frames in all of "
            f"{', '.join(dict.fromkeys(n for a in found for n in (a.smaller, a.larger)))}"
        )
    enough = [
        t for t in range(len(chosen)) if all(_usable(sums[k, t], counts[k, t]) for k in markers)
    ]
    kept = np.ix_(markers, enough)
    taus = tuple(chosen[t] / frame_rate_hz for t in enough)
    return Moments(taus, sums[kept], counts[kept], tuple(markers))


def _usable(sums: np.ndarray, counts: np.ndarray) -> bool:
    """Whether half of the blocks have terms, and positions noise, in all additions.

    Not noise of both subsets together: a camera leaves one direction exactly as it was.
    """
    if not ((counts > 0).sum(axis=1) >= N_BLOCKS / 2).all():
        return False
    whole = sums.sum(axis=1)
    values = np.linalg.eigvalsh(np.concatenate([whole[:, :3, :3], whole[:, 3:, 3:]]))
    return bool((values[:, 0] > 1e-12 * values[:, 2]).all())
