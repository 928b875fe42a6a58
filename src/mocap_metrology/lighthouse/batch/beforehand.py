"""A joint estimate held against what was known of board and optics, and against a known length."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations_with_replacement

import numpy as np
from scipy.special import chdtrc

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.problem import GROUPS
from mocap_metrology.lighthouse.batch.recording import Recording
from mocap_metrology.lighthouse.batch.solve import reduced, solved

SHOWN = 0.03  # of the variance of a prior
ANY_OFFSET = 0.1  # rad
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
    """What known lengths say of the size of the board, and all else of them; scale_p alone, 1,
    without any. board_larger: than its file, a share; board_sigma: this over its standard
    deviation, by what is known of that size, in the notation of `prior_p`; length_share: of what is
    known of the scale; scale_p: probability by chance that the lengths differ so much from all
    else; length_check_sd: standard deviation, a share, with which an error of the length shows that
    all else checks least, and length_sd, its own (Baarda 1968, reliability of an observation).

    With D the derivatives of the lengths, V their variances, C the covariance of their residuals
    and K = D M D' V^-1 - 1, an error e of them changes these by K e: it shows to sqrt(C) / K.
    """
    at, of = joint.of.scale, [row for one in joint.recordings for row in _lengths(one, joint)]
    if at < 0 or not of:
        return {"scale_p": 1.0}
    size, D, off, V = (np.array(column) for column in zip(*of, strict=True))
    (M, known), pull, n = joint.inverse, joint.pull, len(V)
    rows = np.vstack([np.eye(known.size)[at], D])
    moved = np.vstack([rows[0], np.zeros_like(D)]) - rows @ M * known
    noise = rows @ M
    K = D @ M @ (D.T / V) - np.eye(n)
    C = (moved * joint.sd) @ (moved * joint.sd).T + noise @ pull @ noise.T
    larger, sd = float(joint.state.values[at]), float(np.sqrt(C[0, 0]))
    C = C[1:, 1:] - (K + np.eye(n)) * V @ (K + np.eye(n)).T + K * V @ K.T
    check, own = np.sqrt(np.diag(C)) / np.abs(np.diag(K)) / size, np.sqrt(V) / size
    least = int(np.argmax(check / own))
    return {
        "board_larger": larger,
        "board_sigma": larger / sd,
        "scale_p": float(chdtrc(n, off @ np.linalg.solve(C, off))),
        "length_share": 1 - float(joint.covariance[at, at] / joint.believed[at] ** 2),
        "length_check_sd": float(check[least]),
        "length_sd": float(own[least]),
    }


def _lengths(one: Recording, joint: Joint) -> Iterator[tuple[float, Floats, float, float]]:
    """Size in m of each known length of a recording, and its `seen_length`."""
    if one.lengths:
        part = reduced(one.sums(joint.state, joint.of), one.trajectory, one.noise)
    for seen in one.lengths:
        yield seen.known.size_m, *one.seen_length(seen, joint.state, joint.of, part)


def _strains(board: np.ndarray, least: float) -> Iterator[Floats]:
    """Places, (3 n,), of a board stretched along each of its principal axes and sheared between
    each two, those aside along which its extent (rms) is less than `least`: errors of places."""
    centred = board - board.mean(axis=0)
    _, size, axes = np.linalg.svd(centred)
    along = axes[size > least * np.sqrt(len(board))]
    for a, b in combinations_with_replacement(along, 2):
        yield (np.outer(centred @ a, b) + np.outer(centred @ b, a)).ravel()


def hidden_optics(joint: Joint) -> float:
    """Standard deviation in rad of the better known combination of a station's offsets, if nothing
    were known of them, of the station of which it is largest: as large errors of its optics, which
    another station's values make, a recording does not show. 0 of known optics."""
    hidden = 0.0
    for of_station in joint.of.columns[..., 2]:
        at, known = of_station[of_station >= 0], 1 / joint.believed**2
        known[at] = 1 / ANY_OFFSET**2
        C = solved(joint.S + np.diag(known), np.eye(known.size)[:, at])[at]
        hidden = max([hidden, *np.sqrt(np.linalg.eigvalsh(C))[:1]])
    return float(hidden)


def scale_share(joint: Joint, station: int) -> float:
    """Share that the scale of the board has in the variance of a position."""
    if joint.of.scale < 0:
        return 0.0
    M, known = joint.inverse
    rows, scale = joint.pose(station)[:3], joint.of.scale
    effect = M[rows, scale] * known[scale] * joint.believed[scale]
    return float(effect @ effect / np.trace(joint.pose_covariance(station)[:3, :3]))
