"""Ant colony optimisation for continuous coordinates, ACO_R.

Socha & Dorigo, "Ant colony optimization for continuous domains", Eur. J. Oper. Res. 185 (2008)
1155-1173; the second stage of Skurowski & Pawlyta 2019 (S 3.4), who fill its archive by jittering
round the result of the annealing (`jittered`) where the original draws it at random.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal


@dataclass(frozen=True)
class Colony:
    """Settings of ACO_R, named as in the paper.

    archive: solutions kept, k. ants: new solutions an iteration, m. q: how far down the archive
    guides are drawn from, as a share of k (small: the best only). xi: width of a kernel over the
    mean distance of its guide to the archive (larger: slower, and less easily trapped).
    """

    archive: int = 50
    ants: int = 10
    q: float = 0.1
    xi: float = 0.85
    iterations: int = 100

    def __post_init__(self) -> None:
        whole = self.archive >= 2 and self.ants >= 1 and self.iterations >= 0
        if not (whole and self.q > 0 and self.xi > 0):
            raise Refusal(
                f"{self}, expected archive >= 2, ants >= 1, iterations >= 0, q > 0, xi > 0"
            )


@dataclass(frozen=True)
class Found:
    """Best point (d,) and its cost; history: (iterations + 1,) best cost so far."""

    x: np.ndarray
    cost: float
    history: np.ndarray


def jittered(
    centre: np.ndarray,
    n: int,
    width: float | np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """(n, d) points: `centre` (d,) itself, then normal deviates about it of standard deviation
    `width` (a number or (d,)), moved into the bounds."""
    points = centre + width * rng.normal(size=(n, centre.size))
    points[0] = centre
    return np.clip(points, lower, upper)


def colony(
    costs: Callable[[np.ndarray], np.ndarray],
    archive: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    settings: Colony,
    rng: np.random.Generator,
) -> Found:
    """Minimise from a filled archive (k, d); `costs` takes (n, d) points and returns (n,).

    An ant draws a guide l of the archive, sorted by cost, with weight
    exp(-(l - 1)^2 / (2 q^2 k^2)) (Eq. 12), then every coordinate i from a normal distribution
    about the guide's, of standard deviation xi sum_e |s_e^i - s_l^i| / (k - 1) (Eq. 16); the best
    k of archive and ants stay. Coordinates are drawn as they are, without the rotation of the
    paper's section 3.2; what leaves the bounds is moved onto them.
    """
    k = archive.shape[0]
    values = costs(archive)
    order = np.argsort(values, kind="stable")
    archive, values = archive[order], values[order]
    weights = np.exp(-(np.arange(k) ** 2) / (2 * (settings.q * k) ** 2))
    edges = np.cumsum(weights / weights.sum())
    history = [values[0]]
    for _ in range(settings.iterations):
        guides = archive[np.searchsorted(edges[:-1], rng.random(settings.ants), side="right")]
        spread = np.abs(archive[None] - guides[:, None]).sum(axis=1) * (settings.xi / (k - 1))
        ants = np.clip(guides + spread * rng.normal(size=guides.shape), lower, upper)
        pool = np.concatenate([values, costs(ants)])
        order = np.argsort(pool, kind="stable")[:k]
        archive, values = np.concatenate([archive, ants])[order], pool[order]
        history.append(values[0])
    return Found(archive[0].copy(), float(values[0]), np.array(history))
