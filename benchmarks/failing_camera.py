"""How often a camera twice as noisy as the others is found, and how often a sound one is blamed.

    python -m benchmarks.failing_camera [--twins 100]    # six minutes

Truth: ten cameras of one type (optics of Skurowski & Pawlyta 2019, Table 2) at random places round
a hall of 9 x 5 x 3 m, whose geometry scatters ln(n h_0) of x, y and z by at least 0.3 over the
subsets (S, Tables A1-A3: about 0.3 to 0.7). Centroid noise differs from camera to camera by a
factor exp(N(0, spread)); one camera has twice that. The covariances of the subsets' positions are
drawn from their sampling distribution (Wishart, degrees of freedom of the Allan variance at one
frame).

Printed as Markdown, per 100: `found`, the noisy camera, or the set added at once that holds it, is
named and nothing else; `itself`, by its own id; `blamed`, of sound systems in which anything is
named. `raised`: the greatest rise of the noise is at its addition; `false rise`: of sound systems
in which any addition is said to raise the noise.
"""

from __future__ import annotations

import argparse

import numpy as np

from benchmarks import head, line
from mocap_metrology.noise.allan.confidence import equivalent_dof
from mocap_metrology.noise.cameras.diagnosis import N_BLOCKS, Moments, additions, diagnose
from mocap_metrology.noise.cameras.findings import addition_rows, noisy, raising_additions
from mocap_metrology.noise.cameras.information import Addition
from mocap_metrology.noise.twins.take import Facility, joint_covariance, random_facility

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


def told(found: list[Addition], subsets: Subsets, values: Moments) -> tuple[list, list]:
    """Sets of ids named as noisy, and sets whose addition raised the noise, greatest first."""
    rows = addition_rows("", found, subsets, ("1", "2"), diagnose(values, found, subsets), RISE)
    sets = [[r["added"] for r in of] for of in (noisy(rows, NOISY), raising_additions(rows))]
    return tuple([{int(i) for i in s.split(";")} for s in own] for own in sets)


def run(name: str, twins: int, seed: int, duration: str, spread: float) -> list[list[str]]:
    """A line for each place of the noisy camera."""
    _, subsets, shared, places = next(s for s in SCENARIOS if s[0] == name)
    found = additions(subsets)
    rng = np.random.default_rng([seed, round(1000 * spread), len(duration), len(name)])

    def taken(bad: list[int]) -> tuple[list, list, int]:
        """What is told of a take, one of these cameras noisy; and which."""
        system, levels = facility(rng), np.exp(rng.normal(0, spread, CAMERAS))
        camera = int(rng.choice(bad)) if bad else -1
        levels[camera] *= 2 if bad else 1
        values = drawn(rng, system, levels, subsets, found, shared, DURATIONS[duration])
        return *told(found, subsets, values), camera

    sound = [taken([]) for _ in range(twins)]
    blamed, false_rise = (np.mean([bool(one[k]) for one in sound]) for k in (0, 1))
    lines = []
    for place, ids in places.items():
        takes = [taken(ids) for _ in range(twins)]
        hits = [bool(named) and all(bad in own for own in named) for named, _, bad in takes]
        itself = [hit and one[0][0] == {one[2]} for hit, one in zip(hits, takes, strict=True)]
        raised = np.mean([bool(rises) and bad in rises[0] for _, rises, bad in takes])
        shares = (np.mean(hits), np.mean(itself), blamed, raised, false_rise)
        per_100 = [f"{100 * share:.0f}" for share in shares]
        lines.append([name, place, duration, f"{100 * spread:.0f} %", *per_100])
    return lines


HEAD = (
    *("subsets", "noisy camera", "duration", "spread", "found", "itself", "blamed", "raised"),
    "false rise",
)


def main(twins: int) -> None:
    rng = np.random.default_rng(1)
    low, middle, high = np.percentile([scatter(facility(rng)) for _ in range(200)], [5, 50, 95])
    print(
        f"sd of ln(n h_0) over the subsets: median {middle:.2f}, "
        f"5 to 95 %: {low:.2f} to {high:.2f}\n"
    )
    head(*HEAD)
    for name, *_ in SCENARIOS:
        for duration in DURATIONS:
            for width in SPREADS:
                for cells in run(name, twins, 1, duration, width):
                    line(*cells)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--twins", type=int, default=100, help="a line")
    main(parser.parse_args().twins)
