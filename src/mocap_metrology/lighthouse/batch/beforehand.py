"""A joint estimate held against what was known of board and optics, and against a known length."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations_with_replacement

import numpy as np
from scipy.special import chdtrc

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.problem import GROUPS

SHOWN = 0.03  # of the variance of a prior
EXTENT = 10.0  # standard deviations of places: less is no extent of a board


def prior_p(joint: Joint) -> float:
    """Probability by chance that board and optics are estimated so far from what is known of them.

    With M = S + L, errors of the standard deviations B make estimates v of the covariance
    C = G B G' + M^-1 S M^-1, G = I - M^-1 L; v' C^-1 v is a chi squared in the directions that the
    hits determine, in units of B, by `SHOWN` at least. A strain u of the board file would make
    estimates G u, so u' G' C^-1 v / sqrt(u' G' C^-1 G u) is a normal deviate, the most powerful one
    against this strain. The lowest of all n probabilities counts n times.
    """
    columns = np.isin(joint.of.group, [GROUPS.index(name) for name in ("depth", "offset", "place")])
    if not columns.any():
        return 1.0
    (M, known), sd, rows = joint.inverse, joint.of.sd[columns], np.ix_(columns, columns)
    by_prior = (np.eye(sd.size) - M[rows] * known[columns]) * sd / sd[:, None]
    C = by_prior @ by_prior.T + (M @ joint.pull @ M)[rows] / np.outer(sd, sd)
    size, axes = np.linalg.eigh((C + C.T) / 2)
    shown = np.sum((axes.T @ by_prior) ** 2, axis=1) > SHOWN
    white = axes[:, shown] / np.sqrt(size[shown])
    if not shown.any():
        return 1.0
    off = white.T @ (joint.state.values[columns] / sd)
    p = [float(chdtrc(off.size, off @ off))]
    if joint.of.places >= 0:
        first = int(np.count_nonzero(columns[: joint.of.places]))
        places = slice(first, first + joint.state.board.size)
        for strain in _strains(joint.state.board, EXTENT * float(sd[places].max())):
            shift = white.T @ by_prior[:, places] @ (strain / sd[places])
            p.append(float(chdtrc(1, (shift @ off) ** 2 / (shift @ shift))))
    return min(1.0, len(p) * min(p))


def of_length(joint: Joint) -> dict[str, float]:
    """What a known length says of the size of the board. scale_p: probability by chance that it
    differs so much from its file, 1 without such a length; with one also board_larger: than its
    file, a share; board_sigma: this over its standard deviation, by what is known of that size, in
    the notation of `prior_p`; length_share: of what is known of the scale; and `_size`."""
    at = joint.of.scale
    if at < 0 or joint.working[at] < joint.of.sd[at]:
        return {"scale_p": 1.0}
    M, known = joint.inverse
    by_prior = (np.eye(known.size)[at] - M[at] * known) * np.where(known > 0, joint.believed, 0.0)
    variance = by_prior @ by_prior + M[at] @ joint.pull @ M[at]
    larger = float(joint.state.values[at])
    sigma = larger / float(np.sqrt(variance))
    share = 1 - float(joint.covariance[at, at] / joint.believed[at] ** 2)
    by_chance = {"scale_p": float(chdtrc(1, sigma**2)), "length_share": share}
    return {"board_larger": larger, "board_sigma": sigma, **by_chance, **_size(joint)}


def _size(joint: Joint) -> dict[str, float]:
    """By how much the estimated board is larger than its file, a share, and this over its standard
    deviation: scale s and errors d_i of places x_i, from their mean, make it
    s + sum(x_i . d_i) / sum(x_i^2)."""
    at, places, board = joint.of.scale, joint.of.places, joint.state.board
    row, off = np.zeros(joint.of.size), np.zeros_like(board)
    if places >= 0:
        off = joint.state.values[places : places + board.size].reshape(-1, 3)
    x = (board - off - (board - off).mean(axis=0)) / (1 + joint.state.values[at])
    row[at] = 1.0
    if places >= 0:
        row[places : places + board.size] = (x / np.sum(x**2)).ravel()
    larger = float(row @ joint.state.values)
    sd = float(np.sqrt(row @ joint.covariance @ row))
    return {"size_larger": larger, "size_sigma": abs(larger) / sd}


def _strains(board: np.ndarray, least: float) -> Iterator[Floats]:
    """Places, (3 n,), of a board stretched along each of its principal axes and sheared between
    each two, those aside along which its extent (rms) is less than `least`: errors of places."""
    centred = board - board.mean(axis=0)
    _, size, axes = np.linalg.svd(centred)
    along = axes[size > least * np.sqrt(len(board))]
    for a, b in combinations_with_replacement(along, 2):
        yield (np.outer(centred @ a, b) + np.outer(centred @ b, a)).ravel()


def scale_share(joint: Joint, station: int) -> float:
    """Share that the scale of the board has in the variance of a position."""
    if joint.of.scale < 0:
        return 0.0
    M, known = joint.inverse
    rows, scale = joint.pose(station)[:3], joint.of.scale
    effect = M[rows, scale] * known[scale] * joint.believed[scale]
    return float(effect @ effect / np.trace(joint.pose_covariance(station)[:3, :3]))
