"""Hits of stations of the second generation by their model, without the project's simulator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.scene import Scene, Sensors
from mocap_metrology.lighthouse.published import FACTORY2_MEAN, FACTORY2_SD
from mocap_metrology.lighthouse.records import Factory, Hits
from mocap_metrology.lighthouse.rotation import exp
from mocap_metrology.lighthouse.rotor import LIBSURVIVE, angles, rotor_parameters

TICKS = (959000, 957000, 953000, 949000, 947000, 943000, 941000, 939000, 937000, 929000, 919000,
         911000, 907000, 901000, 893000, 887000)  # fmt: skip
BEGIN = np.array([2, 4]) * np.pi / 3  # of the planes: where theta is 0 in a turn
DIAGONAL = np.ones(3) / np.sqrt(3)
Pose = tuple[np.ndarray, np.ndarray]


def tracker(n: int = 32, radius_m: float = 0.09, seed: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Diodes on a flattened dome and their outward normals, (n, 3) each."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 1.6 * k / n, np.pi * (1 + 5**0.5) * k
    normals = np.column_stack(
        [np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z]
    )
    rng = np.random.default_rng(seed)
    return radius_m * normals * [1, 1, 0.7] * rng.uniform(0.8, 1.1, (n, 1)), normals


def room(n: int, seed: int = 0) -> list[Pose]:
    """Stations around a room of 6 x 5 m, 2 to 2.6 m high, that look down at its middle."""
    rng, poses = np.random.default_rng(seed), []
    for k in range(n):
        turn = 2 * np.pi * (k + 0.15 * rng.uniform(-1, 1)) / max(n, 4)
        place = np.array([3.0 * np.cos(turn), 2.5 * np.sin(turn), rng.uniform(0.9, 1.5)])
        x = rng.uniform(-0.4, 0.4, 3) - place
        x /= np.linalg.norm(x)
        y = np.cross([0, 0, 1.0], x)
        y /= np.linalg.norm(y)
        poses.append(
            (np.column_stack([x, y, np.cross(x, y)]) @ exp(np.r_[0.1 * rng.normal(), 0, 0]), place)
        )
    return poses


def factory(rng: np.random.Generator) -> Factory:
    """Drawn about the mean of real stations."""
    values = {k: FACTORY2_MEAN[k] + FACTORY2_SD[k] * rng.normal(size=2) for k in FACTORY2_MEAN}
    return Factory(**values, generation=2)


def uneven(
    rng: np.random.Generator, n_diodes: int, slow_mm: float, slow_deg: float = 7.0, waves: int = 16
) -> Callable[[np.ndarray], np.ndarray]:
    """How far a diode is seen from its place by the direction (..., n_diodes, 3) of the light in
    the board's axes: a Gaussian field on the sphere, of this standard deviation a coordinate, with
    the covariance exp(-(angle / slow_deg)^2 / 2), as a sum of random waves."""
    k = rng.normal(size=(n_diodes, waves, 3)) / np.radians(slow_deg)
    phase, size = rng.uniform(0, 6.28, (n_diodes, waves)), rng.normal(size=(n_diodes, waves, 3))

    def field(way: np.ndarray) -> np.ndarray:
        return np.stack(
            [
                1e-3 * slow_mm * np.sqrt(2 / waves)
                * np.cos(way[..., d, :] @ k[d].T + phase[d]) @ size[d]
                for d in range(n_diodes)
            ],
            axis=-2,
        )  # fmt: skip

    return field


@dataclass
class Made:
    scene: Scene
    poses: list[Pose]  # in the frame of the first station
    factories: list[Factory]


def motion(time_s: np.ndarray, seed: int, still: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Rotations and positions in the room: a hand's sum of sines about 1 m, and turns by 60 deg."""
    rng = np.random.default_rng(seed)
    t = np.asarray(time_s)[..., None, None]
    f, phase = rng.uniform(0.1, 0.5, (2, 3, 3)), rng.uniform(0, 6.28, (2, 3, 3))
    waves = np.sin(2 * np.pi * f * t[..., None] + phase).sum(-1)
    place = waves[..., 0, :] * [0.35, 0.3, 0.15] * (0 if still else 1)
    turn = waves[..., 1, :] * [0.25, 0.25, 0.6] * (0 if still else 1)
    return exp(turn.reshape(-1, 3)).reshape(*turn.shape, 3), place


def made(
    n: int,
    seed: int,
    seconds: float = 6.0,
    *,
    hit_urad: float = 20.0,
    sweep_urad: float = 15.0,
    place_mm: float = 0.0,
    cover: tuple[float, float] | None = None,
    lost: float = 0.1,
    known: bool = True,
    farthest_deg: float = 75.0,
    priors: Priors | None = None,
    still: bool = False,
    ideal: bool = False,
    slow_mm: float = 0.0,
    wrong: float = 0.0,
    bump_mm: float = 0.0,
    keep: Sequence[tuple[float, float]] | None = None,
    take: int = 0,
    board_seed: int = 5,
    larger: float = 0.0,
) -> Made:
    """place_mm: errors of the board file; larger: share by which the board is larger than it;
    slow_mm: as `uneven`; wrong: share of hits that are reflections, 2 to 10 mrad off; bump_mm: of
    the last station, from its place; keep: when each station sees the board, as shares; take:
    another recording before the same stations.
    """
    rng = np.random.default_rng(seed)
    board, normals = tracker(seed=board_seed)
    real = (1 + larger) * board + 1e-3 * place_mm * rng.normal(size=board.shape)
    stations, factories = room(n, seed), [factory(rng) for _ in range(n)]
    R, t = stations[-1]
    placed = [*stations[:-1], (R, t + 1e-3 * bump_mm * DIAGONAL)]
    moved = seed + 1000 * take
    rng = np.random.default_rng([seed, take]) if take else rng
    if ideal:
        factories = [Factory(generation=2)] * n
    field = uneven(np.random.default_rng([board_seed, seed]), len(board), slow_mm)
    parts = []
    for s, (R, t) in enumerate(placed):
        T, begin = TICKS[s] / 48e6 * (1 + 5e-6 * rng.normal()), rng.uniform(0, 0.02)
        rows = rotor_parameters(factories[s], None, LIBSURVIVE)
        turns = np.arange(int(seconds / T) - 1)
        theta = np.zeros((turns.size, 2, len(board)))
        for _ in range(5):
            time = begin + turns[:, None, None] * T + (theta + BEGIN[:, None]) * T / (2 * np.pi)
            Rb, tb = motion(time, moved, still)
            out = np.einsum("cpdij,dj->cpdi", Rb, normals)
            world = np.einsum("cpdij,dj->cpdi", Rb, real) + tb
            far = world - t
            cos = -(out * far).sum(-1) / np.linalg.norm(far, axis=-1)
            if cover is not None:
                c = np.clip(cos, 0, 1)
                shift = cover[0] + cover[1] * (1 - c / np.sqrt(1.5**2 - 1 + c**2))
                far = far + shift[..., None] * out
            if slow_mm:
                way = np.einsum("cpij,cpdi->cpdj", Rb[:, :, 0], far)
                way /= -np.linalg.norm(way, axis=-1, keepdims=True)
                far = far + np.einsum("cpdij,cpdj->cpdi", Rb, field(way))
            p = far @ R
            both = angles(np.ascontiguousarray(p.reshape(-1, 3)), rows).reshape(*theta.shape, 2)
            theta = np.stack([both[:, k, :, k] for k in (0, 1)], axis=1)
        seen = (cos > np.cos(np.radians(farthest_deg))) & (p[..., 0] > 0.3) & (np.abs(theta) < 1.2)
        seen &= rng.random(theta.shape) > lost
        reflected = np.random.default_rng([seed, 2, s, take]).random(theta.shape) < wrong
        if keep is not None:
            seen &= (time >= keep[s][0] * seconds) & (time <= keep[s][1] * seconds)
        noisy = theta + 1e-6 * sweep_urad * rng.normal(size=(turns.size, 2, 1))
        noisy += 1e-6 * hit_urad * rng.normal(size=theta.shape)
        off = np.random.default_rng([seed, 3, s, take]).uniform(2e-3, 10e-3, theta.shape)
        noisy += (
            reflected * off * np.random.default_rng([seed, 4, s, take]).choice([-1, 1], theta.shape)
        )
        c, plane, d = np.nonzero(seen)
        parts.append((np.full(c.size, s), plane, c, d, time[seen], noisy[seen]))
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    order = np.argsort(columns[4], kind="stable")
    station, axis, cycle, diode, time_s, angle = (column[order] for column in columns)
    hits = Hits(
        station.astype(np.int8), axis.astype(np.int8), cycle.astype(np.int32),
        diode.astype(np.int16), time_s, angle, np.full(time_s.size, 4e-6),
    )  # fmt: skip
    scene = Scene(
        hits,
        board,
        "factory" if known else "estimated",
        factories if known else [None] * n,
        None,
        "libsurvive",
        priors or Priors(time_zero_us=0, phase_mrad=0, board_scale=0, board_position_mm=place_mm),
        generation=2,
        names=[str(k) for k in range(n)],
        sensors=Sensors(normals=None if cover is None else normals),
    )
    R0, t0 = stations[0]
    return Made(scene, [(R0.T @ R, R0.T @ (t - t0)) for R, t in stations], factories)


def without(made: Made, station: int) -> Scene:
    return replace(made.scene, hits=made.scene.hits.take(made.scene.hits.station != station))
