"""Is each diode where the board says? A dump of 32 diodes with its bytes swapped looks whole: its
bits are in use all the same, and only the geometry tells."""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import Hits

SWAPPED = np.arange(32).reshape(4, 8)[::-1].ravel()  # true diode of each bit of swapped words
ENOUGH_HITS = 8
ENOUGH_SWEEPS = 120
CALM = 0.2  # quantile over sweeps: that many have no outlier
MISFIT_RAD = 2e-3  # of a right board; beyond, another order is looked at
BETTER = 0.3
AGREE = 0.8


def check_byte_order(hits: Hits, board: np.ndarray, name: str) -> None:
    """Refuse hits that fit the board only when the bytes of the words are swapped.

    An angle is nearly an affine function of the diodes' places within a sweep. Where both orders
    fit alike, as on a grid of 8 by 4, the swapped one is the mirror image: the board would be seen
    from behind. That is told for flat boards in the plane x = const, which by convention face along
    +x.
    """
    if len(board) != SWAPPED.size:
        return
    sweeps = _full_sweeps(hits)
    if len(sweeps) < 8:
        return
    as_read = [_fit(hits, one, board) for one in sweeps]
    swapped = [_fit(hits, one, board[SWAPPED]) for one in sweeps]
    misfit, misfit_swapped = (
        float(np.quantile([rms for rms, _ in fits], CALM)) for fits in (as_read, swapped)
    )
    where = f"{name}: a big-endian dump:"
    if misfit > MISFIT_RAD and misfit_swapped < BETTER * misfit:
        raise Refusal(
            f"{where} the sweeps fit the board to {1e3 * misfit:.1f} mrad as read, to"
            f" {1e3 * misfit_swapped:.1f} mrad with the bytes swapped; expected little-endian words"
        )
    if np.ptp(board[:, 0]) < 1e-6 and BETTER * misfit_swapped < misfit:
        behind = _share_from_behind(hits, sweeps, as_read)
        behind_swapped = _share_from_behind(hits, sweeps, swapped)
        if behind > AGREE and behind_swapped < 1 - AGREE:
            raise Refusal(
                f"{where} the stations see the board's mirror image as read, and its front (+x)"
                " with the bytes swapped; expected little-endian words, and a board that faces +x"
            )


def _full_sweeps(hits: Hits) -> list[np.ndarray]:
    """Indices of the hits of sweeps with enough of them, in order of time, evenly chosen pairs."""
    order = np.lexsort((hits.cycle, hits.station))
    new = (np.diff(hits.cycle[order], prepend=-1) != 0) | (
        np.diff(hits.station[order], prepend=-1) != 0
    )
    sweeps = np.split(order, np.flatnonzero(new)[1:]) if order.size else []
    sweeps = [one for one in sweeps if one.size >= ENOUGH_HITS]
    step = max(1, 2 * len(sweeps) // ENOUGH_SWEEPS)
    return [one for k, one in enumerate(sweeps) if k // 2 % step == 0]


def _fit(hits: Hits, one: np.ndarray, board: np.ndarray) -> tuple[float, np.ndarray]:
    """Rms in rad and gradient of the affine fit of a sweep."""
    design = np.column_stack([np.ones(one.size), board[hits.diode[one]]])
    angle = hits.angle_rad[one]
    solution, *_ = np.linalg.lstsq(design, angle, rcond=1e-9)
    return float(np.sqrt(np.mean((angle - design @ solution) ** 2))), solution[1:]


def _share_from_behind(
    hits: Hits, sweeps: list[np.ndarray], fits: list[tuple[float, np.ndarray]]
) -> float:
    """Share of azimuth and elevation sweeps running that turn the board's y, z the wrong way.

    From the front, azimuth falls along y and elevation rises along z: the determinant of the two
    gradients is negative.
    """
    wrong = []
    for k in range(len(sweeps) - 1):
        a, b = sweeps[k][0], sweeps[k + 1][0]
        if (
            hits.station[a] == hits.station[b]
            and hits.cycle[b] - hits.cycle[a] == 1
            and (hits.axis[a], hits.axis[b]) == (0, 1)
        ):
            azimuth, elevation = fits[k][1], fits[k + 1][1]
            wrong.append(azimuth[1] * elevation[2] - azimuth[2] * elevation[1] > 0)
    return float(np.mean(wrong)) if wrong else 0.5
