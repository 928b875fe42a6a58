"""Accuracy and coverage of the estimator `batch` by Monte Carlo.

    python -m benchmarks.joint_calibration accuracy [--setups 10] [--recordings 5]
    python -m benchmarks.joint_calibration coverage [--setups 40] [--recordings 5]
    python -m benchmarks.joint_calibration setups [--setups 10] [--recordings 5]

Each recording is drawn, written as a dump of 2 MHz, decoded and calibrated. Boards are 2 to 6 m
from both stations, stations 1 to 4 m apart, speeds 0.15 to 1 m/s, with tremor. The Cramer-Rao bound
is that of the joint estimate with the noise that made the data and exactly known board and optics
(time zeros with 0.15 us where flashes rise late). `setups` joins the recordings of each setup,
whose boards are up to 0.7 m from one place, with factory values and without.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from benchmarks import head, line
from benchmarks.poses import UNITS, decoded, held, mahalanobis, off, off_joint
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch import solve
from mocap_metrology.lighthouse.batch import view as views
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.problem import Priors, layout
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.scene import ESTIMATED, Scene
from mocap_metrology.lighthouse.calibrate.setup import by_setup
from mocap_metrology.lighthouse.calibrate.variants import AUTO
from mocap_metrology.lighthouse.decode.chain import Decoded
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, simulate
from mocap_metrology.lighthouse.simulate.twin import (
    BoardTwin,
    FactoryValues,
    LighthouseTwin,
    MotionTwin,
    StationTwin,
)

REAL = {"common_urad": 53.0, "independent_urad": 30.0, "flash_rise_us": 0.6}
# Of a hit at 2 MHz: 42.5 urad by two edges whose errors are related (37 to 45 by distance; 38 if
# they were independent), with jitter 52.
IDEAL_NOISE, REAL_NOISE = views.Noise(42.5e-6, 0.0), views.Noise(52e-6, 53e-6)
EXACT, ZEROS = Priors(0, 0, 0, 0, 0), Priors(0.15, 0, 0, 0, 0)
DECK = BoardTwin(columns=2, rows=2, width_m=0.03, height_m=0.015)


def stations(setup: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centre of the board, place and angles (deg) of the slave."""
    rng = np.random.default_rng([5, setup])
    while True:
        centre = rng.uniform([2, -1, -0.5], [4.5, 1, 0.5])
        side = rng.uniform(1, 4) * rng.choice([-1, 1])
        place = np.array([rng.uniform(-0.3, 1.5), side, rng.uniform(-0.5, 0.5)])
        way = centre - place
        far = np.linalg.norm(way)
        ahead = centre @ way / far / np.linalg.norm(centre)
        if 2 < far < 6 and ahead > np.cos(np.radians(85)):
            break
    yaw = np.degrees(np.arctan2(way[1], way[0])) + rng.uniform(-10, 10)
    pitch = -np.degrees(np.arcsin(way[2] / far)) + rng.uniform(-10, 10)
    return centre, place, np.array([rng.uniform(-26, 26), pitch, yaw])


def rotors(rng: np.random.Generator) -> Factory:
    """Factory values like those of eight real stations, as float16 carries them."""

    def half(values: np.ndarray) -> np.ndarray:
        return np.float16(values).astype(float)

    return Factory(
        half(rng.normal(0.028, 0.025, 2)),
        half(rng.normal(-0.0024, 0.0043, 2)),
        half(rng.normal(-0.002, 0.0043, 2)),
        half(np.r_[rng.normal(2, 0.4), rng.uniform(-3, 3)]),
        half(rng.normal([0.009, -0.010], [0.006, 0.004])),
    )


def twin(setup: int, recording: int, **more: object) -> LighthouseTwin:
    """A recording of a setup; master, slave: fields of the stations."""
    centre, place, angles = stations(setup)
    rng = np.random.default_rng([6, setup, recording])
    off = np.random.default_rng([7, setup, recording]).uniform(-1, 1, 3)
    motion = MotionTwin(
        centre_m=tuple(centre + more.pop("around_m", 0.0) * off),
        speed_m_s=float(np.exp(rng.uniform(np.log(0.15), 0))),
        extent_m=rng.uniform(0.2, 0.5),
        wobble_deg=rng.uniform(6, 14),
        tremor_mm=0.05,
        tremor_deg=0.014,
    )
    own = {"dropout": rng.uniform(0, 0.2), "clock_ppm": rng.normal(0, 20)} | more
    master, slave = dict(own.pop("master", {})), dict(own.pop("slave", {}))
    for station in (master, slave):
        if isinstance(values := station.get("factory"), Factory):
            names = FactoryValues.model_fields
            station["factory"] = {name: tuple(getattr(values, name)) for name in names}
    slave = {"position_m": tuple(place), "rotation_deg": tuple(angles)} | slave
    return LighthouseTwin(
        seed=1000 * setup + recording,
        master=StationTwin(id=1, mode="b", **master),
        slave=StationTwin(id=2, mode="c", **slave),
        motion=motion,
        **own,
    )


@dataclass(frozen=True)
class Case:
    """What is drawn for a setup and recording; its noise; the bound's priors, the estimate's."""

    made: Callable[[int, int], SimulatedSweeps]
    noise: views.Noise
    bound: Priors
    priors: Priors
    optics: str = "factory"
    board: Callable[[np.ndarray, np.random.Generator], np.ndarray] = lambda board, _: board


def both(factories: list[Factory], depths_m: Iterable[float] = ()) -> dict[str, object]:
    """Fields of master and slave; depths_m: between the lasers of each."""
    fields: list[dict[str, object]] = [{"factory": factory} for factory in factories]
    for own, d in zip(fields, depths_m, strict=False):
        own["lasers_m"] = ((d / 2, 0.0, 0.0), (-d / 2, 0.0, 0.0))
    return dict(zip(("master", "slave"), fields, strict=True))


def real(setup: int, recording: int, **more: object) -> SimulatedSweeps:
    """Rotors as real ones, with real noise."""
    rng = np.random.default_rng([11, setup])
    return simulate(twin(setup, recording, **REAL | both([rotors(rng), rotors(rng)]) | more))


def lasers_apart(setup: int) -> dict[str, object]:
    """Fields of the stations of `real`, lasers 5 mm off in depth."""
    rng = np.random.default_rng([11, setup])
    return both([rotors(rng), rotors(rng)], (0.01, -0.01))


def drawn(setup: int, recording: int) -> SimulatedSweeps:
    """With laser depths and phases drawn from their priors; the flashes carry other phases."""
    rng = np.random.default_rng([12, setup, recording])
    depths = rng.normal(0, 0.01, 2)
    phases = [Factory(phase=rng.normal(0, 1e-3, 2)) for _ in depths]
    return simulate(twin(setup, recording, **REAL | both(phases, depths)))


def zeros(setup: int, recording: int) -> SimulatedSweeps:
    """With a time zero of each station and axis from its prior, as a phase that is not known."""
    rng = np.random.default_rng([14, setup, recording])
    phases = [Factory(phase=rng.normal(0, ZEROS.time_zero_rad, 2)) for _ in range(2)]
    return simulate(twin(setup, recording, **REAL | both(phases) | {"flash_rise_us": 0.0}))


def off_board(board: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A board file with errors of the default priors."""
    return (board + 2e-4 * rng.normal(size=board.shape)) * (1 + 1e-3 * rng.normal())


def exact(simulated: Callable[[int, int], SimulatedSweeps]) -> Case:
    """Default priors for the estimate, board and optics exactly known for the bound."""
    return Case(simulated, REAL_NOISE, ZEROS, Priors())


CASES = {
    "ideal lasers, quantisation": Case(
        lambda s, r: simulate(twin(s, r)), IDEAL_NOISE, EXACT, Priors(), "ideal"
    ),
    "real noise": exact(real),
    "20 % dropouts, 1 % reflections": exact(lambda s, r: real(s, r, dropout=0.2, reflections=0.01)),
    "four diodes, 30 x 15 mm, 8 s": exact(lambda s, r: real(s, r, board=DECK)),
    "four diodes, 30 x 15 mm, 60 s": exact(lambda s, r: real(s, r, board=DECK, duration_s=60.0)),
    "lasers 5 mm off in depth": exact(lambda s, r: real(s, r, **lasers_apart(s))),
}
COVERAGE = {
    "real noise, priors off": Case(
        lambda s, r: simulate(twin(s, r, **REAL)), REAL_NOISE, ZEROS, ZEROS, "ideal"
    ),
    "time zeros from their prior, other priors off": Case(zeros, REAL_NOISE, ZEROS, ZEROS, "wrong"),
    "board, phases, depths from their priors": Case(
        drawn, REAL_NOISE, ZEROS, Priors(), "wrong", off_board
    ),
}


def bound(found: Joint, priors: Priors, noise: views.Noise) -> np.ndarray:
    """Cramer-Rao bound (6, 6) of the pose at what was found."""
    one, of = found.recordings[0], layout(2, len(found.state.board), priors)
    ones = np.ones(one.residual.size)
    sums = solve.linearised(one.seen, one.trajectory, found.state, 0 * ones, ones, of)
    S = solve.reduced(sums, one.trajectory, noise).S
    return np.linalg.inv(S + np.diag(1 / of.sd**2))[:6, :6]


def recorded(case: Case, setup: int, recording: int) -> tuple[SimulatedSweeps, Decoded]:
    """A recording, and what its dump says."""
    made = case.made(setup, recording)
    rng = np.random.default_rng([13, setup, recording])
    with tempfile.TemporaryDirectory() as folder:
        return made, decoded(made, case.board(made.truth.board, rng), folder)


def by_batch(case: Case, made: SimulatedSweeps, given: Decoded) -> tuple[np.ndarray, ...]:
    """Error (6,), covariance and bound (6, 6) in mm and deg; CPU seconds, rms over noise."""
    factories, optics = [station.factory for station in given.stations], case.optics
    if optics == "wrong":  # the flashes are of stations without phases
        optics, factories = "factory", [Factory(), Factory()]
    scene = Scene(given.hits, given.board, optics, factories, None, "crazyflie", case.priors)
    begun = time.process_time()
    found, _ = joint(scene)
    seconds = time.process_time() - begun
    alone, unit = found.recordings[0], np.outer(UNITS, UNITS)
    rms = np.sqrt(np.mean(alone.alone**2)) / alone.noise.hit
    return (
        off_joint(made, found),
        found.pose_covariance() * unit,
        bound(found, case.bound, case.noise) * unit,
        np.array([seconds, rms]),
    )


def one(case: Case, setup: int, recording: int) -> tuple[np.ndarray, ...] | None:
    try:
        return by_batch(case, *recorded(case, setup, recording))
    except Refusal as refusal:
        print(f"  {setup}-{recording}: {refusal}", flush=True)
        return None


def numbers(name: str, rows: list[tuple[np.ndarray, ...]], n: int) -> None:
    """A line of Markdown: ratios to the bound, errors, coverage, times."""
    error, C, B, rest = (np.array(column) for column in zip(*rows, strict=True))
    bounds = np.diagonal(B, axis1=1, axis2=2)
    ratios = [
        np.sqrt(np.sum(error[:, own] ** 2) / bounds[:, own].sum())
        for own in (slice(3), slice(3, 6))
    ]
    inside = held([mahalanobis(e, c) for e, c in zip(error, C, strict=True)])
    mae = np.abs(error).mean(axis=0)
    line(
        name,
        f"{len(rows)} of {n}",
        f"{ratios[0]:.2f}, {ratios[1]:.2f}",
        " / ".join(f"{x:.2f}" for x in mae[:3]),
        " / ".join(f"{x:.4f}" for x in mae[3:]),
        f"{np.linalg.norm(error[:, :3], axis=1).max():.1f}",
        f"{inside[0]:.0f}, {inside[1]:.0f}",
        f"{np.median(rest[:, 1]):.3f}",
        f"{np.median(rest[:, 0]):.2f}",
    )


def accuracy(cases: dict[str, Case], setups: int, recordings: int) -> None:
    """A line for each case."""
    head(
        *("case", "converged", "RMSE over bound: position, angle", "MAE x / y / z mm", "MAE deg"),
        *("largest mm", "68 %, 95 % ellipsoids hold, %", "rms / noise", "CPU s"),
    )
    for name, case in cases.items():
        found = [one(case, s, r) for s in range(setups) for r in range(recordings)]
        numbers(name, [row for row in found if row is not None], len(found))


def by_setups(setups: int, recordings: int) -> None:
    """A line with known and one with unknown factory values."""
    head("optics", "MAE x / y / z mm", "MAE deg", "largest error / sigma", "m2", "CPU s")
    for optics in ("factory", ESTIMATED):
        rows = []
        for setup in range(setups):
            made = [real(setup, k, around_m=0.7) for k in range(recordings)]
            rows.append(joined(made, optics))
        error, sigma, m2, seconds = (np.array(column) for column in zip(*rows, strict=True))
        mae = np.abs(error).mean(axis=0)
        line(
            optics,
            " / ".join(f"{x:.2f}" for x in mae[:3]),
            " / ".join(f"{x:.3f}" for x in mae[3:]),
            f"{np.abs(error / sigma).max():.1f}",
            " ".join(f"{x:.1f}" for x in m2),
            f"{np.median(seconds):.1f}",
        )


def joined(made: list[SimulatedSweeps], optics: str) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Error and standard deviation (6,) of the pose by all recordings, m2, CPU seconds."""
    scenes = {}
    for k, own in enumerate(made):
        with tempfile.TemporaryDirectory() as folder:
            one = decoded(own, own.truth.board, folder)
        factories = [None if optics == ESTIMATED else s.factory for s in one.stations]
        scenes[str(k)] = Scene(one.hits, one.board, optics, factories, None, AUTO, Priors())
    begun = time.process_time()
    pose = by_setup(scenes).pose
    seconds, error = time.process_time() - begun, off(made[0], pose)
    assert pose.covariance is not None
    m2 = mahalanobis(error, pose.covariance)
    return error, np.sqrt(np.diag(pose.covariance)), m2, seconds


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("accuracy", "coverage", "setups"))
    parser.add_argument("--setups", type=int)
    parser.add_argument("--recordings", type=int, default=5, help="of each setup")
    asked = parser.parse_args()
    asked.setups = asked.setups or {"coverage": 40}.get(asked.what, 10)
    if asked.what == "setups":
        by_setups(asked.setups, asked.recordings)
    else:
        cases = CASES if asked.what == "accuracy" else COVERAGE
        accuracy(cases, asked.setups, asked.recordings)
