"""One shape of slow wander as a fit to block means."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.types import Floats

PARTS = 20  # of a curve, by whose steps it becomes faster or slower
BENT = 0.8  # of the change of pace, that two neighbours of its parts may have
PLACE = 2  # parameters of a place in time, as it is searched among many
LEVELS = frozenset({"two_levels", "levels"})
AT_ONCE = LEVELS | {"step", "shift", "steps"}
CURVED = {"smooth", "warm_up", "creep", "fades"}  # of which some columns are, beside one change

Columns = Callable[[float], Floats]


@dataclass(frozen=True)
class Shape:
    """A fit to block means, (n,).

    kinds: what it is; columns (p, n), of which the first `line` are a line beside it; searched:
    parameters beside the coefficients; at: its places, period or dwell, in blocks; main: the column
    (counted from the end) whose coefficient is the size.
    """

    kinds: frozenset[str]
    columns: Floats
    searched: float = 0
    at: tuple[float, ...] = ()
    main: int = -1
    line: int = 0

    @property
    def placed(self) -> bool:
        """Whether `at` are places, not a period or a dwell."""
        return bool(self.kinds & {"step", "shift", "steps"})

    @property
    def separate(self) -> bool:
        """Whether it consists of steps or one shift, in blocks that are apart, beside a curve too,
        and no block has a column of its own."""
        alone = len(self.columns) - self.line in (1, len(self.at)) or bool(self.kinds & CURVED)
        apart = bool(self.at) and np.diff(self.at).min(initial=math.inf) > 2
        return self.placed and alone and apart

    @property
    def whole(self) -> Shape:
        """Without columns of one block, which say nothing of sizes."""
        many = np.count_nonzero(self.columns, axis=1) != 1
        main = int(many[self.main :].sum())
        return replace(self, columns=self.columns[many], main=-main)

    def solved(self, z: Floats) -> Floats:
        """Least-squares coefficients (p,); of levels without the blocks beside a switch, which may
        be of neither."""
        X = np.vstack([np.ones(z.size), self.columns])
        if self.kinds & LEVELS:
            switched = np.diff(self.columns[self.line :]).any(axis=0)
            inside = ~(np.append(switched, False) | np.append(False, switched))
            X, z = X[:, inside], z[inside]
        return np.asarray(np.linalg.lstsq(X.T, z, rcond=None)[0][1:], np.float64)

    def curve(self, solved: Floats) -> Floats:
        """The curve (n,) of coefficients (p,), without constant and line."""
        return np.asarray(solved[self.line :] @ self.columns[self.line :])

    def moved(self, solved: Floats) -> float:
        """From the first block to the last, with the straight line, without jumps and cycle, beside
        which a warm-up is the first column."""
        only = bool(self.kinds & {"fades", "cycle"})
        part = slice(self.line + ("warm_up" in self.kinds)) if only else slice(None)
        change = solved[part] @ np.diff(self.columns[part, [0, -1]])[:, 0]
        return float(change) - (0.0 if only else sum(size for _, size in self.jumps(solved)))

    def size(self, solved: Floats) -> float:
        """Amplitude of a cycle; of other shapes the coefficient of `main`, or of a smooth curve the
        range, with the sign of its change."""
        if not len(self.columns):
            return math.nan
        if "cycle" in self.kinds:
            return float(np.hypot(*solved[-2:]))
        if self.kinds & AT_ONCE:
            return float(solved[self.main])
        curve = self.curve(solved)
        change = curve[-1] - curve[0]
        return float(np.ptp(curve) * np.sign(change if change else solved[-1]))

    def jumps(self, solved: Floats) -> list[tuple[int, float]]:
        """Block and size of every change at once."""
        if not self.kinds & AT_ONCE:
            return []
        if "fades" in self.kinds or (self.placed and len(self.at) == 1):  # beside a curve, too
            return [(int(self.at[0]), self.size(solved))]
        steps = np.diff(self.curve(solved))
        middle = sum(self.at) / 2 - 1 if "shift" in self.kinds else math.inf
        places: list[tuple[int, float]] = []
        for place in np.flatnonzero(np.abs(steps) > 1e-9 * np.abs(steps).max(initial=0)).tolist():
            near = bool(places) and place - places[-1][0] <= 2  # within the blocks that it takes
            if near and not places[-1][0] < middle <= place:  # from begin to end of a short shift
                places[-1] = place, places[-1][1] + float(steps[place])
            else:
                places.append((place, float(steps[place])))
        least = max((abs(size) for _, size in places), default=0.0) / 10
        return [(place + 1, size) for place, size in places if abs(size) > least]


def on_line(shape: Shape, k: np.ndarray) -> Shape | None:
    """The shape beside a straight line; None where it has one, or would take its part."""
    straight = shape.line or shape.kinds & {"drift", "smooth", "accelerating"}
    if straight or shape.kinds <= {"slowing"}:
        return None
    kinds = shape.kinds - {"slowing"} | {"drift"}
    return replace(shape, kinds=kinds, columns=np.vstack([time_of(k), shape.columns]), line=1)


def pace(curve: Floats) -> frozenset[str]:
    """`accelerating` of a curve that goes one way, ever faster; `slowing`, ever more slowly;
    `drift`, about as fast everywhere; else none. By the steps between the means of its parts, of
    which none may be most of the way, nor two changes in a row most of all, as at a bend."""
    steps = np.diff([part.mean() for part in np.array_split(curve, PARTS)])
    way = steps.sum()
    share = steps / way if way else np.zeros(steps.size)
    if share.min() < -0.01 or share.max() > 0.4:
        return frozenset()
    if share.min() > 0.5 / steps.size and share.max() < 1.5 / steps.size:
        return frozenset({"drift"})
    for kind, ordered in (("accelerating", share), ("slowing", share[::-1])):
        change, far = np.diff(ordered), np.ptp(ordered)
        ever = np.convolve(change, [1, 1]).max() < BENT * far > -10 * np.minimum(change, 0.0).sum()
        if ever and ordered[-(PARTS // 3) :].sum() > 2 * ordered[: PARTS // 3].sum():
            return frozenset({kind})
    return frozenset()


def time_of(k: np.ndarray) -> Floats:
    """(n,) from -1/2 to 1/2, of blocks with these numbers."""
    return np.asarray((k - k[0]) / (k[-1] - k[0]) - 0.5)


def refined_place(
    z: Floats,
    t: Floats,
    columns: Columns,
    grid: Floats,
    line: bool = True,
    beside: Floats | None = None,
) -> float:
    """Place on a grid, and between its neighbours, where the columns leave least beside a constant,
    a straight line and further columns (p, n)."""
    from scipy.optimize import minimize_scalar

    fixed = np.vander(t, 2 if line else 1)
    basis, _ = np.linalg.qr(fixed if beside is None else np.hstack([fixed, beside.T]))
    left = z - basis @ (basis.T @ z)

    def gain(places: Sequence[float] | np.ndarray) -> Floats:
        """What the columns take from the sum of squares, by normal equations."""
        X = np.array([np.atleast_2d(columns(place)) for place in places])
        X = X - (X @ basis) @ basis.T
        b, G = X @ left, X @ X.transpose(0, 2, 1)
        G += np.eye(len(G[0])) * (1e-10 * G + 1e-300)  # of columns alike, or none
        return np.asarray((b * np.linalg.solve(G, b[..., None])[..., 0]).sum(axis=1))

    best = int(np.argmax(gain(grid)))
    bounds = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, grid.size - 1)])
    fine = {"xatol": 1e-4 * (bounds[1] - bounds[0])}
    found = minimize_scalar(
        lambda place: -gain([place])[0], bounds=bounds, method="bounded", options=fine
    )
    return float(found.x)
