"""Two objects of one recording: do their poses of the slave differ as their covariances say?

Each recording draws errors of phases and depths between the lasers, which both objects share, and
for each object errors of its diodes and time zeros, all from the priors of `batch`; `hand` says
where the stations are. The first object has the 32 diodes of the default board, the second 20 in
two planes, 16 x 12 cm. In distorted pairs the file of the second is stretched by 3 % along one
axis. Uniform: p of a Kolmogorov-Smirnov test of the probabilities by chance.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.stats import kstest

from benchmarks.moved_stations import SETTINGS, Setup
from benchmarks.poses import with_zeros
from benchmarks.sentences import Row
from mocap_metrology.lighthouse.assess.summary import APART_P, Summary, summary, with_objects
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.jansen import calibrate
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.twin import BoardTwin, LighthouseTwin

SECONDS, STRETCH = 6.0, 0.03
SECOND = BoardTwin(columns=5, rows=4, width_m=0.16, height_m=0.12, out_of_plane_m=0.015)


def calibrated(setup: Setup, twin: LighthouseTwin, seed: int, stretch: float = 0.0) -> Summary:
    """Of an object of the setup, whose file errs by the priors and is stretched."""
    rng, priors, made = np.random.default_rng([seed, 41]), Priors(), simulate(twin, seed)
    hits = with_zeros(made.hits, rng, priors.time_zero_rad)
    board = made.truth.board
    board = board + 1e-3 * priors.board_position_mm * rng.normal(size=board.shape)
    board *= 1 + priors.of_board(board).board_scale * rng.normal()
    board[:, rng.integers(1, 3)] *= 1 + stretch
    found = calibrate(clean_hits(hits, board)[0], board, setup.told, SETTINGS)
    return summary(found, setup.stations(frames_found=1), duration_s=8.0)


def pair(seed: int, stretch: float = 0.0) -> tuple[Summary, Summary]:
    """Both objects of a recording, each held against the other."""
    setup = Setup(seed, SECONDS)
    first = setup.twin
    x, y, z = first.motion.centre_m
    motion = first.motion.model_copy(update={"centre_m": (x - 0.2, y + 0.1, z - 0.1)})
    second = first.model_copy(update={"motion": motion, "board": SECOND})
    a = calibrated(setup, first, 2 * seed)
    b = calibrated(setup, second, 2 * seed + 1, stretch)
    return with_objects(a, {"second": b.document}), with_objects(b, {"first": a.document})


def rows(n: int) -> Iterator[Row]:
    """Sound pairs, n / 2.5, and distorted ones, n / 5."""
    sound = [pair(seed) for seed in range(max(2 * n // 5, 4))]
    p = [float(one.verdict.checks[-1].value or 0) for one, _ in sound]
    lowered = sum(own.verdict.checks[-1].level != "good" for both in sound for own in both)
    case = "two sound objects"
    yield case, "uniform", len(sound), "> 0.01", f"{kstest(p, 'uniform').pvalue:.2f}"
    yield case, f"p below {APART_P:g}: words lowered", 2 * len(sound), "1 %", str(lowered)
    bad = [pair(seed, STRETCH) for seed in range(max(n // 5, 2))]
    both = sum(all(own.verdict.checks[-1].level != "good" for own in one) for one in bad)
    yield "one board stretched by 3 %", "both words lowered", len(bad), "-", str(both)
