"""Noise of the hits of a recording, by restricted likelihood."""

from __future__ import annotations

import numpy as np
from scipy import linalg, optimize

from mocap_metrology.lighthouse.batch import sweep_kernel
from mocap_metrology.lighthouse.batch.inverse import selected_inverse
from mocap_metrology.lighthouse.batch.kernel import Equations
from mocap_metrology.lighthouse.batch.solve import Sums, known_of, reduced
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.batch.view import Noise

WRONG = 0.5  # of the weight of a sweep: below it is farther off than five standard deviations
NOISE_ROUNDS = 2  # of its estimate beside other data
RATIOS = (0.05, 20.0)  # of common to independent noise that are told from none and from only


def estimated_noise(sums: Sums, trajectory: Trajectory, start: Noise) -> Noise:
    """Standard deviations of the greatest restricted likelihood (Patterson & Thompson 1971).

    For a ratio r = (sweep / hit)^2 of the variances, with A and g of the trajectory alone,

        Q = sum(w e^2) - sum_m r / (1 + r W_m) (sum_m w e)^2 - g' A^-1 g,
        -2 log L = (n - p) log Q + sum_m log(1 + r W_m) + log det A,   hit^2 = Q / (n - p),

    p unknowns of the trajectory, less what other data determine of them; those of the border are
    few beside it and count as known. r of a sweep is divided by its weight in `Sums.held`; as much
    of its offset as this leaves open counts as an unknown. The offset of a sweep that lost most of
    its weight is one more unknown, with r infinite and no term in the second sum: by the limited
    loss of `sweep_kernel.robust` alone a few wrong sweeps make the noise of all larger. The ratio
    is found by bounded search; 0 is tried, too.
    """
    if sums.more is None:
        return _estimated_noise(sums, trajectory, start, 0.0)
    for _ in range(NOISE_ROUNDS):
        start = _estimated_noise(sums, trajectory, start, _by_more(sums, trajectory, start))
    return start


def _by_more(sums: Sums, trajectory: Trajectory, noise: Noise) -> float:
    """How many unknowns of the trajectory other data determine: trace(A^-1 A_more)."""
    assert sums.more is not None
    Z = selected_inverse(reduced(sums, trajectory, noise).factor)
    both = (Z * sums.more.band).sum(axis=1)
    return noise.hit**2 * float(2 * both.sum() - both[0])


def _estimated_noise(sums: Sums, trajectory: Trajectory, start: Noise, by_more: float) -> Noise:
    bend, bend_g = known_of(trajectory, sums.more, start.hit)
    p = int((sums.hits.band[0] > 0).sum())
    wrong = sums.held < WRONG
    free = max(sums.n_hits - p + by_more - float(np.sum(np.where(wrong, 1, 1 - sums.held))), 1)
    nothing, none = np.zeros((sums.begin.size, 0)), Equations.zeros(sums.hits.g.size, 0)

    def at(ratio: float) -> tuple[float, float]:
        band, g = sums.hits.band + bend, sums.hits.g + bend_g
        own = ratio / sums.held
        factor = np.where(wrong, 1 / sums.weight, own / (1 + own * sums.weight))
        of_sweeps = sums.begin, factor, sums.of_sweep, nothing, sums.residual
        sweep_kernel.without_offsets(*of_sweeps, none._replace(band=band, g=g))
        L = linalg.cholesky_banded(band, overwrite_ab=True, lower=True, check_finite=False)
        x = linalg.cho_solve_banded((L, True), g, check_finite=False)
        Q = max(sums.square - float(factor @ sums.residual**2) - float(g @ x), 1e-30)
        log_det = 2 * float(np.log(L[0]).sum())
        rest = float(np.log1p((own * sums.weight)[~wrong]).sum())
        return free * np.log(Q) + rest + log_det, Q / free

    low, high = 2 * np.log(RATIOS)
    found = optimize.minimize_scalar(
        lambda x: at(np.exp(x))[0], bounds=(low, high), method="bounded", options={"xatol": 0.05}
    )
    ratio = float(np.exp(found.x))
    ratio = min((0.0, ratio), key=lambda r: at(r)[0])
    hit = float(np.sqrt(at(ratio)[1]))
    return Noise(hit, hit * float(np.sqrt(ratio)))
