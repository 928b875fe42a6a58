"""Noise of single cameras from that of camera subsets, without knowing where they are.

Let p_a, p_b be positions of one marker from the cameras a and from those and more, b, in the same
frames; A = sum J_i^T J_i and G = A^-1 as in `twins.take`, V = sum s_i^2 J_i^T J_i. With camera
noises that are independent of each other, least squares gives

    Cov(p_b, p_a) = G_b V_a G_a,   Cov(p_a) = G_a V_a G_a,

so F = Cov(p_b, p_a) Cov(p_a)^-1 = G_b A_a, whatever the noises are: geometry alone. F gives every G
from that of one subset, and that one is given, up to a factor, by the symmetry of all (three
equations a subset for five unknowns: three nested subsets are enough). Then the added cameras' own
part of the noise of p_b

    Cov(p_b - F p_a) = G_b (V_b - V_a) G_b   against   G_b (A_b - A_a) G_b = G_b - F G_b

is their s^2: exactly for one camera; for more, the largest ratio of the two forms is that of the
noisiest. Likewise the least and the greatest generalised eigenvalue of (Cov(p_a), G_a) are the s^2
of the two cameras of a first pair. All s have one factor in common, so they are relative to
their median. At longer tau F stays, and with D = p_b - p_a, in which motion of the marker cancels,

    Cov(p_b - F p_a) = Cov(D) + Cov(D, p_a) (1 - F)^T   for everything but that motion.

Where the frames are not the same, only Cov(p_a) and Cov(p_b) can be held against each other: sound
cameras add a positive form to A, so the noise falls or stays in every direction. A camera s times
as noisy as the others can raise it by s^2 / (2 sqrt(s^2 - 1)) at most.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats

SAME_FRAMES = 0.05  # mean squared canonical correlation from which positions share their frames
KEPT = 0.002  # directions with less than this share of the most added information are ignored


@dataclass(frozen=True)
class Addition:
    """The cameras `added` make recording `larger` out of `smaller`."""

    smaller: str
    larger: str
    added: tuple[int | str, ...]


@dataclass(frozen=True)
class Chain:
    """Additions among recordings of `n_cameras` cameras each, as `camera_noise` needs them.

    firsts: recordings whose cameras no addition distinguishes.
    """

    steps: tuple[Addition, ...]
    n_cameras: Mapping[str, int]
    firsts: tuple[str, ...] = ()


def position_factors(joint: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Largest and mean factor of the standard deviation from the smaller to the larger subset.

    joint: (..., 6, 6) covariances of (p_a, p_b). Largest: square root of the largest generalised
    eigenvalue of (Cov p_b, Cov p_a), in the direction (..., 3), a unit vector, which is where the
    ratio of standard deviations is that; mean: the geometric mean over all directions.
    """
    root = np.linalg.inv(np.linalg.cholesky(joint[..., :3, :3]))
    values, vectors = np.linalg.eigh(root @ joint[..., 3:, 3:] @ _turned(root))
    direction = np.einsum("...ji,...j->...i", root, vectors[..., -1])
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    values = np.maximum(values, 1e-300)
    return np.sqrt(values[..., -1]), np.exp(np.log(values).mean(axis=-1) / 2), direction


def least_camera_noise(factor: np.ndarray | float) -> np.ndarray:
    """How many times as noisy as the others one camera must be, at least, to raise a standard
    deviation by `factor` >= 1: the inverse of s^2 / (2 sqrt(s^2 - 1)) for s^2 >= 2."""
    squared = np.maximum(np.asarray(factor, dtype=np.float64), 1.0) ** 2
    return np.sqrt(2 * squared * (1 + np.sqrt(1 - 1 / squared)))


def coherence(joint: np.ndarray) -> np.ndarray:
    """(...) mean squared canonical correlation of p_a and p_b: 0 for different frames."""
    a, b = np.linalg.inv(joint[..., :3, :3]), np.linalg.inv(joint[..., 3:, 3:])
    x = joint[..., 3:, :3]
    return np.trace(b @ x @ a @ _turned(x), axis1=-2, axis2=-1) / 3


def camera_noise(joint: np.ndarray, chain: Chain) -> tuple[np.ndarray, np.ndarray]:
    """(t, e) noise s of the noisiest camera of each addition, and (f,) that of each first subset.

    joint: (t, e, 6, 6) covariances of (p_a, p_b) of one marker at rising tau, the first the
    shortest, for each step of the chain. Relative to the median over all of them at each tau; with
    one addition only, to the cameras that were there before. NaN where it is undetermined.
    """
    shortest = joint[0]
    transfer = shortest[:, 3:, :3] @ np.linalg.inv(shortest[:, :3, :3])
    known = _geometry(shortest, transfer, chain)
    if known is None:
        before: np.ndarray = shortest[:, :3, :3]
        firsts: np.ndarray = np.full(len(chain.firsts), np.nan)
    else:
        before = np.array([known[step.smaller] for step in chain.steps])
        firsts = np.array([_of_first(shortest, known, chain, f) for f in chain.firsts])
        firsts = firsts.reshape(-1, 2)
    after = _symmetric_part(transfer @ before)
    added = _symmetric_part(after - transfer @ after)
    variances = np.array([_of_added(c, transfer, added, chain) for c in joint])
    if known is None:
        return np.sqrt(variances), firsts
    with np.errstate(invalid="ignore"):
        typical = [np.nanmedian(row) for row in variances]
        typical[0] = np.nanmedian([*variances[0], *firsts.ravel()])
        return np.sqrt(variances / np.array(typical)[:, None]), np.sqrt(
            firsts.max(axis=1, initial=0.0) / typical[0]
        )


def _of_added(
    joint: np.ndarray, transfer: np.ndarray, added: np.ndarray, chain: Chain
) -> list[float]:
    """s^2 of the noisiest added camera of each step, in the unit of the geometry."""
    a, b, x = joint[:, :3, :3], joint[:, 3:, 3:], joint[:, 3:, :3]
    increase = _symmetric_part(a + b - x - _turned(x) + (x - a) @ (np.eye(3) - _turned(transfer)))
    root = np.linalg.inv(np.linalg.cholesky(b))
    noise, information = root @ increase @ _turned(root), root @ added @ _turned(root)
    values = []
    for q, p, step in zip(noise, information, chain.steps, strict=True):
        weights, vectors = np.linalg.eigh(p)
        main = vectors[:, weights > KEPT * weights[-1]] if weights[-1] > 0 else vectors[:, :0]
        if not main.shape[1]:
            values.append(np.nan)
        elif len(step.added) == 1:
            values.append(np.trace(main.T @ q @ main) / np.trace(main.T @ p @ main))
        else:
            scaled = main / np.sqrt(weights[weights > KEPT * weights[-1]])
            values.append(np.linalg.eigvalsh(scaled.T @ q @ scaled)[-1])
    return [max(value, 1e-12) if value == value else value for value in values]


def _of_first(
    joint: np.ndarray, known: Mapping[str, np.ndarray], chain: Chain, first: str
) -> tuple[float, float]:
    """s^2 of the cameras of a first pair; of a larger subset, its mean and what one is at least."""
    of_it = next(k for k, step in enumerate(chain.steps) if step.smaller == first)
    root = np.linalg.inv(np.linalg.cholesky(known[first]))
    values = np.linalg.eigvalsh(root @ joint[of_it, :3, :3] @ root.T)
    low = values[0] if chain.n_cameras[first] == 2 else values.mean()
    return max(low, 1e-12), max(values[-1], 1e-12)


def _geometry(
    joint: np.ndarray, transfer: np.ndarray, chain: Chain
) -> dict[str, np.ndarray] | None:
    """G of every subset up to a common factor; None with fewer than three subsets, or where the
    found form is not positive."""
    paths, covariances = _paths(joint, transfer, chain)
    if len(paths) < 3:
        return None
    start = next(iter(paths))
    root = np.linalg.cholesky(covariances[start])
    basis = [root @ e @ root.T for e in SYMMETRIC]
    equations = []
    for subset, path in paths.items():
        scale = np.linalg.inv(np.linalg.cholesky(covariances[subset]))
        parts = [scale @ path @ e @ scale.T for e in basis]
        equations.append([(part - part.T)[[0, 0, 1], [1, 2, 2]] for part in parts])
    shape = np.linalg.svd(np.concatenate(equations, axis=1).T)[2][-1]
    geometry = np.tensordot(shape, basis, 1)
    if np.trace(geometry) < 0:
        geometry = -geometry
    known = {}
    for subset, path in paths.items():
        known[subset] = _symmetric_part(path @ geometry)
        if np.linalg.eigvalsh(known[subset])[0] <= 0:
            return None
    return known


def _paths(
    joint: np.ndarray, transfer: np.ndarray, chain: Chain
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """What turns G of the first step's smaller subset into that of each reached from it, and the
    covariance of each."""
    start = chain.steps[0].smaller
    paths, covariances = {start: np.eye(3)}, {start: joint[0, :3, :3]}
    while True:
        reached = len(paths)
        for c, f, step in zip(joint, transfer, chain.steps, strict=True):
            if step.smaller in paths and step.larger not in paths:
                paths[step.larger] = f @ paths[step.smaller]
                covariances[step.larger] = c[3:, 3:]
            elif step.larger in paths and step.smaller not in paths:
                paths[step.smaller] = np.linalg.solve(f, paths[step.larger])
                covariances[step.smaller] = c[:3, :3]
        if len(paths) == reached:
            return paths, covariances


def _symmetric_basis() -> np.ndarray:
    basis = np.zeros((6, 3, 3))
    for form, (i, j) in zip(basis, [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)], strict=True):
        form[i, j] = form[j, i] = 1.0
    return basis


SYMMETRIC = _symmetric_basis()


def _turned(matrix: Floats) -> Floats:
    return np.swapaxes(matrix, -1, -2)


def _symmetric_part(matrix: Floats) -> Floats:
    return (matrix + _turned(matrix)) / 2
