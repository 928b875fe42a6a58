"""Hits of a moved board without the project's simulator: atan2, fixed-point times, rounding."""

from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotation import exp, from_angles

CYCLE_S = 1 / 120
LSB_S = 0.5e-6


@dataclass
class Scene:
    R: np.ndarray
    t_m: np.ndarray
    board: np.ndarray
    hits: Hits


def pose_at(time_s: np.ndarray, rng_seed: int, speed: float, still: bool = False):
    """Board rotation and position in the master's frame at times: a hand's sum of sines."""
    rng = np.random.default_rng(rng_seed)
    time = np.asarray(time_s)[..., None]
    f, phase = rng.uniform(0.15, 0.7, (2, 3, 3)), rng.uniform(0, 6.28, (2, 3, 3))
    size = np.array([0.12, 0.05, 0.02]) * speed / 0.4
    arm = (size[:, None] * np.sin(2 * np.pi * f[0] * time[..., None] + phase[0])).sum(-1)
    turn = 0.09 * np.sin(2 * np.pi * f[1] * time[..., None] + phase[1]).sum(-1)
    if still:
        arm, turn = np.zeros_like(arm), np.zeros_like(turn)
    centre = np.array([3.2, 0.2, -0.3])
    base = from_angles(0.05, 0.1, np.pi + 0.1)
    turned = exp(turn.reshape(-1, 3)) @ base
    return turned.reshape(*arm.shape[:-1], 3, 3), centre + arm


def scene(
    seed: int,
    speed: float = 0.4,
    seconds: float = 8.0,
    noise_rad: float = 0.0,
    still: bool = False,
    quantised: bool = True,
    board: np.ndarray | None = None,
    more: tuple[tuple[np.ndarray, np.ndarray], ...] = (),
) -> Scene:
    """Both stations, ideal optics, flat board 3.2 m away; the slave 2 m to the side, rolled; more:
    poses of further stations, which sweep in turn."""
    board = flat_board() if board is None else board
    rng = np.random.default_rng(seed)
    R = from_angles(0.2, -0.1, -0.65)
    t = np.array([0.4, 2.0, 0.25])
    stations = [(np.eye(3), np.zeros(3)), (R, t), *more]
    # slave axis 0, slave axis 1, master axis 0, master axis 1
    plan = [(1, 0), (1, 1), (0, 0), (0, 1), *((2 + k // 2, k % 2) for k in range(2 * len(more)))]
    cycles = np.arange(int(seconds / CYCLE_S))
    station, axis = np.array([plan[c % len(plan)] for c in cycles]).T
    angle = np.zeros((len(cycles), len(board)))
    for _ in range(4):
        hit = (cycles[:, None] + 0.5) * CYCLE_S + angle * CYCLE_S / np.pi
        Rb, tb = pose_at(hit, seed, speed, still)
        world = np.einsum("cdij,dj->cdi", Rb, board) + tb
        for s, (Rs, ts) in enumerate(stations):
            own = station == s
            p = (world[own] - ts) @ Rs
            ratio = np.where(axis[own][:, None] == 0, p[..., 1], p[..., 2])
            angle[own] = np.arctan2(ratio, p[..., 0])
    hit = (cycles[:, None] + 0.5) * CYCLE_S + angle * CYCLE_S / np.pi
    if quantised:  # middle of two rounded edges
        half = 2e-6
        hit = (np.ceil((hit - half) / LSB_S) + np.ceil((hit + half) / LSB_S) - 1) * LSB_S / 2
    angle = (hit - cycles[:, None] * CYCLE_S) * np.pi / CYCLE_S - np.pi / 2
    angle += rng.normal(0, noise_rad, angle.shape) if noise_rad else 0.0
    kept = rng.random(angle.shape) > 0.1
    c, d = np.nonzero(kept)
    order = np.argsort(hit[kept], kind="stable")
    c, d = c[order], d[order]
    hits = Hits(
        station=station[c].astype(np.int8),
        axis=axis[c].astype(np.int8),
        cycle=cycles[c].astype(np.int32),
        diode=d.astype(np.int16),
        time_s=hit[c, d],
        angle_rad=angle[c, d],
        width_s=np.full(c.size, 4e-6),
    )
    return Scene(R, t, board, hits)
