"""How often a camera twice as noisy as the others is found, and how often a sound one is blamed.

    python benchmarks/failing_camera.py                # 100 twins a line, six minutes
    python benchmarks/failing_camera.py --series 20    # whole recordings only, of ten minutes

Truth: ten cameras of one type (optics of Skurowski & Pawlyta 2019, Table 2) at random places round
a hall of 9 x 5 x 3 m, whose geometry scatters ln(n h_0) of x, y and z by at least 0.3 over the
subsets (S, Tables A1-A3: about 0.3 to 0.7). Centroid noise differs from camera to camera by a
factor exp(N(0, spread)); one camera has twice that. The first kind of run draws the covariances of
the subsets' positions from their sampling distribution (Wishart, degrees of freedom of the Allan
variance at one frame); the second simulates centroids frame by frame, with a common random walk of
the markers, and a failing camera whose extra noise is white or correlated (T_c = 0.3 s).

Printed as Markdown, per 100: `found`, the noisy camera, or the set added at once that holds it, is
named and nothing else; `itself`, by its own id; `blamed`, of sound systems in which anything is
named. `raised`: the greatest rise of the noise is at its addition; `false rise`: of sound systems
in which any addition is said to raise the noise.
"""

from __future__ import annotations

import argparse
import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from mocap_metrology.noise.allan.confidence import equivalent_dof
from mocap_metrology.noise.cameras.diagnosis import (
    N_BLOCKS,
    Moments,
    additions,
    diagnose,
    moments,
)
from mocap_metrology.noise.cameras.findings import addition_rows, noisy, raising_additions
from mocap_metrology.noise.cameras.information import Addition
from mocap_metrology.noise.twins.take import (
    Facility,
    gain_matrices,
    joint_covariance,
    random_facility,
)

RATE_HZ, RISE, NOISY = 120.0, 0.05, 1.5
CAMERAS, LEAST_SCATTER = 10, 0.3
DURATIONS = {"10 min": 600.0, "9 h": 32400.0}
SPREADS = (0.05, 0.10, 0.15)
Subsets = dict[str, list[int]]


def wishart_blocks(
    rng: np.random.Generator, covariance: np.ndarray, dof: float, n_blocks: int
) -> np.ndarray:
    """(n_blocks, k, k) estimates of a covariance, each with `dof / n_blocks` degrees of freedom."""
    each = dof / n_blocks
    root = np.linalg.cholesky(covariance + 1e-13 * np.trace(covariance) * np.eye(len(covariance)))
    k = len(covariance)
    drawn = np.zeros((n_blocks, k, k))
    low = np.tril_indices(k, -1)
    drawn[:, low[0], low[1]] = rng.standard_normal((n_blocks, len(low[0])))
    diagonal = np.sqrt(rng.chisquare(each - np.arange(k), (n_blocks, k)))
    drawn[:, range(k), range(k)] = diagonal
    half = root @ drawn  # Bartlett's decomposition
    return half @ half.transpose(0, 2, 1) / each


def chain(numbers: list[int]) -> Subsets:
    return {f"{n}": list(range(n)) for n in numbers}


def left_out() -> Subsets:
    every = list(range(CAMERAS))
    return {"all": every} | {f"no {i}": [j for j in every if j != i] for i in every}


ONE, PAPER = chain(list(range(2, 11))), chain([2, 3, 4, 5, 6, 8, 10])
# Name, subsets, whether they share their frames, places of the noisy camera
SCENARIOS = (
    ("one at a time", ONE, True, {"of the first two": [0, 1], "added": list(range(2, 10))}),
    (
        "as S: 2 3 4 5 6 8 10",
        PAPER,
        True,
        {"of the first two": [0, 1], "added alone": [2, 3, 4, 5], "added in a pair": [6, 7, 8, 9]},
    ),
    ("each left out once", left_out(), True, {"any": list(range(10))}),
    ("one at a time, frames not shared", ONE, False, {"added": list(range(2, 10))}),
)


def scatter(facility: Facility) -> float:
    """Standard deviation of ln(n h_0) over the subsets, root mean square of x, y and z."""
    joint = joint_covariance(facility, 0, np.ones(facility.n), list(PAPER.values()))
    n = np.array([len(ids) for ids in PAPER.values()])
    levels = np.log(n[:, None] * np.diag(joint).reshape(-1, 3))
    return float(np.sqrt(levels.var(axis=0, ddof=1).mean()))


def facility(rng: np.random.Generator) -> Facility:
    while True:
        found = random_facility(rng, CAMERAS)
        if scatter(found) >= LEAST_SCATTER:
            return found


def drawn(
    rng: np.random.Generator,
    system: Facility,
    noise_px: np.ndarray,
    subsets: Subsets,
    found: list[Addition],
    shared: bool,
    duration_s: float,
) -> Moments:
    """Moments at one frame, drawn from their distribution."""
    names = list(subsets)
    dof = equivalent_dof(0, 1, round(duration_s * RATE_HZ))
    sums = np.zeros((2, 1, len(found), N_BLOCKS, 6, 6))
    for marker in range(2):
        joint = joint_covariance(system, marker, noise_px, list(subsets.values()))
        if not shared:
            own = np.arange(len(joint)) // 3
            joint = np.where(own[:, None] == own, joint, 0.0)
        blocks = wishart_blocks(rng, joint, dof, N_BLOCKS)
        for k, addition in enumerate(found):
            i, j = names.index(addition.smaller), names.index(addition.larger)
            pick = np.concatenate([3 * i + np.arange(3), 3 * j + np.arange(3)])
            sums[marker, 0, k] = blocks[:, pick[:, None], pick]
    return Moments((1 / RATE_HZ,), sums, np.ones(sums.shape[:4]))


def simulated(
    rng: np.random.Generator,
    system: Facility,
    noise_px: np.ndarray,
    extra_px: np.ndarray,
    subsets: Subsets,
    found: list[Addition],
    duration_s: float,
) -> Moments:
    """Moments of whole recordings; extra_px: correlated noise of each camera."""
    from scipy.signal import lfilter

    n = round(duration_s * RATE_HZ)
    kept = np.exp(-1 / (0.3 * RATE_HZ))
    recordings = {}
    for marker in range(2):
        pixels = rng.standard_normal((CAMERAS, 2, n)) * noise_px[:, None, None]
        for k in np.flatnonzero(extra_px):
            white = rng.standard_normal((2, n)) * np.sqrt(1 - kept**2)
            pixels[k] += extra_px[k] * lfilter([1.0], [1.0, -kept], white, axis=1)
        moved = np.cumsum(rng.standard_normal((3, n)), axis=1) * 1e-4
        gains = gain_matrices(system, marker, list(subsets.values()))
        for name, gain in zip(subsets, gains, strict=True):
            recordings[name, marker + 1] = moved + np.einsum("idk,kdt->it", gain, pixels)
    return moments(found, lambda name, marker: recordings[name, marker], 2, RATE_HZ, n)


def told(found: list[Addition], subsets: Subsets, values: Moments) -> tuple[list, list]:
    """Sets of ids named as noisy, and sets whose addition raised the noise, greatest first."""
    rows = addition_rows("", found, subsets, ("1", "2"), diagnose(values, found, subsets), RISE)
    sets = [[r["added"] for r in of] for of in (noisy(rows, NOISY), raising_additions(rows))]
    return tuple([{int(i) for i in s.split(";")} for s in own] for own in sets)


class Count:
    """Of twins with a noisy camera, and of sound ones."""

    def __init__(self) -> None:
        self.n = self.found = self.itself = self.up = self.blamed = self.false_rise = 0

    def noisy(self, bad: int, named: list, rises: list) -> None:
        hit = bool(named) and all(bad in ids for ids in named)
        self.n += 1
        self.found += hit
        self.itself += hit and named[0] == {bad}
        self.up += bool(rises) and bad in rises[0]

    def sound(self, named: list, rises: list) -> None:
        self.blamed += bool(named)
        self.false_rise += bool(rises)

    def shown(self) -> list[str]:
        share = [100 * k / self.n for k in (self.found, self.itself, self.blamed, self.up)]
        return [f"{v:.0f}" for v in (*share, 100 * self.false_rise / self.n)]


def run(name: str, twins: int, seed: int, duration: str, spread: float) -> list[list[str]]:
    _, subsets, shared, places = next(s for s in SCENARIOS if s[0] == name)
    found = additions(subsets)
    rng = np.random.default_rng([seed, round(1000 * spread), len(duration), len(name)])
    sound = Count()
    lines = []
    for _ in range(twins):
        system, levels = facility(rng), np.exp(rng.normal(0, spread, CAMERAS))
        values = drawn(rng, system, levels, subsets, found, shared, DURATIONS[duration])
        sound.sound(*told(found, subsets, values))
    for place, ids in places.items():
        count = Count()
        count.blamed, count.false_rise = sound.blamed, sound.false_rise
        for _ in range(twins):
            system, levels = facility(rng), np.exp(rng.normal(0, spread, CAMERAS))
            bad = int(rng.choice(ids))
            levels[bad] *= 2
            values = drawn(rng, system, levels, subsets, found, shared, DURATIONS[duration])
            count.noisy(bad, *told(found, subsets, values))
        lines.append([name, place, duration, f"{100 * spread:.0f} %", *count.shown()])
    return lines


def run_series(twins: int, seed: int) -> list[list[str]]:
    lines = []
    found = additions(PAPER)
    for kind in ("white", "correlated"):
        rng = np.random.default_rng([seed, len(kind)])
        count = Count()
        for _ in range(twins):
            for bad in (None, int(rng.integers(CAMERAS))):
                system, levels = facility(rng), 0.05 * np.exp(rng.normal(0, 0.1, CAMERAS))
                extra = np.zeros(CAMERAS)
                if bad is not None and kind == "white":
                    levels[bad] *= 2
                elif bad is not None:
                    extra[bad] = levels[bad]
                values = simulated(rng, system, levels, extra, PAPER, found, 600.0)
                named, rises = told(found, PAPER, values)
                count.sound(named, rises) if bad is None else count.noisy(bad, named, rises)
        lines.append([f"recordings, noise {kind}", "any", "10 min", "10 %", *count.shown()])
    return lines


HEAD = (
    *("subsets", "noisy camera", "duration", "spread", "found", "itself", "blamed", "raised"),
    "false rise",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--twins", type=int, default=100, help="a line")
    parser.add_argument("--series", type=int, default=0, help="whole recordings a line, alone")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--subsets", default="", help="only those whose name begins so")
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    spread = np.percentile([scatter(facility(rng)) for _ in range(200)], [5, 50, 95])
    print(
        f"sd of ln(n h_0) over the subsets: median {spread[1]:.2f}, "
        f"5 to 95 %: {spread[0]:.2f} to {spread[2]:.2f}\n"
    )
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD), flush=True)
    if given.series:
        for line in run_series(given.series, given.seed):
            print("| " + " | ".join(line) + " |", flush=True)
        return
    for name in (s[0] for s in SCENARIOS if s[0].startswith(given.subsets)):
        for duration in DURATIONS:
            for width in SPREADS:
                for line in run(name, given.twins, given.seed, duration, width):
                    print("| " + " | ".join(line) + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
