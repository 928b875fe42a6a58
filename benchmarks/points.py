"""How often a frame that jumps among reference points is found, and how often one is found that did
not: python -m benchmarks.points [sets] [seed] (about a minute).

26 or 12 places in a room of 4 x 4 x 2 m, of markers or of a tracked body with a lever and turned by
20 degrees, and a smooth distortion of 2 to 12 mm rms (a quadratic surface in each axis), noise of
0.5 mm. Half of the sets jump by 50 mm (rms over the points) between two points.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks import arguments
from mocap_metrology.accuracy.points import LEAST_SEGMENT, Points, frame_changes

ROOM_MM, NOISE_MM, JUMP_MM = np.array([4000.0, 4000.0, 2000.0]), 0.5, 50.0


def drawn(rng: np.random.Generator, n: int, body: bool, distortion_mm: float) -> Points:
    """A set whose frame does not change."""
    at = rng.uniform(-1, 1, (n, 3))
    first, second = np.triu_indices(3)
    terms = np.concatenate([at, at[:, first] * at[:, second]], axis=1)
    bent = (terms - terms.mean(axis=0)) @ rng.standard_normal((9, 3))
    bent *= distortion_mm / np.sqrt((bent**2).sum(axis=1).mean())
    turns = Rotation.from_rotvec(np.radians(20) * rng.standard_normal((n, 3)) * body).as_matrix()
    frame = Rotation.random(random_state=int(rng.integers(1 << 31)))
    seen = frame.apply(at * ROOM_MM / 2) + bent + NOISE_MM * rng.standard_normal((n, 3))
    lever = np.array([30.0, -20.0, 60.0]) * body
    return Points(seen - turns @ lever, turns, at * ROOM_MM / 2)


def jumped(rng: np.random.Generator, points: Points, after: int) -> Points:
    """The same, moved by a turn and a shift after a point."""
    later = np.arange(len(points)) >= after
    turn = Rotation.from_rotvec(0.005 * rng.standard_normal(3))
    moved = turn.apply(points.places) + 30.0 * rng.standard_normal(3) - points.places
    moved *= JUMP_MM / np.sqrt((moved**2).sum(axis=1).mean())
    return Points(points.places + later[:, None] * moved, points.turns, points.reference)


def main(sets: int, seed: int) -> None:
    print("points  body  distortion  false  found  within one point")
    for size, body, distortion in product((26, 12), (False, True), (2.0, 6.0, 12.0)):
        rng = np.random.default_rng([seed, size, body, int(distortion)])
        false = found = near = 0
        for _ in range(sets):
            points = drawn(rng, size, body, distortion)
            false += bool(frame_changes(points).cuts)
            after = int(rng.integers(LEAST_SEGMENT, size - LEAST_SEGMENT + 1))
            cuts = frame_changes(jumped(rng, points, after)).cuts
            found += bool(cuts)
            near += len(cuts) == 1 and abs(cuts[0] - after) <= 1
        shares = (f"{count / sets:6.0%}" for count in (false, found, near))
        print(f"{size:6}  {body!s:5}  {distortion:7.0f} mm", *shares)


if __name__ == "__main__":
    main(**arguments(__doc__, sets=100, seed=1))
