"""A simulated recording of second-generation light: any number of stations, one object.

The rotor of station s has made n turns at b + n T + z(n), z being how it swings. Its plane p meets
a diode at the time t of n = k + (theta_p(x(t)) + 2 pi (1 + p) / 3) / 2 pi in turn k. Periods vary,
so that the turns of two stations slide through each other; where two sweeps are on the object
within `GROUP_S`, a receiver loses hits or gives them to the wrong station. Results are what a
receiver reports, `Light` to be decoded like a recording's, or the lines of a libsurvive recording.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from mocap_metrology.common.files import whole
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.decode.ootx import accel_of
from mocap_metrology.lighthouse.decode.turns import (
    LARGEST_RAD,
    PERIOD_S,
    PLANE_RAD,
    Light,
    encode_frame2,
)
from mocap_metrology.lighthouse.planes import parameters
from mocap_metrology.lighthouse.published import FACTORY2_MEAN, FACTORY2_SD, OGEEMAG_CORRELATION
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotor import angles
from mocap_metrology.lighthouse.simulate.motion import Motion, facing_to, motion_of
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from mocap_metrology.lighthouse.timing import TICKS_PER_S

STATIONS, RECEIVER, NOISE, FAULTS = range(1, 5)  # streams of random numbers
PERIOD_PPM = -3.0, 5.0  # mean and SD of a period about its nominal one
SWING = 13.0, 0.88  # turns, and what is left of it after one: of real rotors 12 to 15, 0.7 to 0.9
GROUP_S = 170e-6  # hits within are one sweep to a receiver
LOST, MIXED = 0.6, 0.1  # shares of the hits of two sweeps that collide
REFRACTION = 1.5  # of the cover of a diode
GRAZING_DEG = 100.0  # diodes see reflections up to this incidence
REFLECTION_RAD = 2e-3, 10e-3  # off the direct light
FIELD_RAD = 1.0  # of a station, to each side and up and down
ROUNDS = 4  # of the time of a hit: each is 1e-3 of the one before


def ball_board(n: int = 32) -> tuple[Floats, Floats]:
    """Diodes all over a flattened ball, and the directions in which they look; (n, 3) each."""
    height = 1 - (2 * np.arange(n) + 1) / n
    turn = np.pi * (1 + 5**0.5) * np.arange(n)
    flat = np.sqrt(1 - height**2)
    normals = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    return normals * [0.07, 0.07, 0.049], normals


def stations_around(
    n: int, rng: np.random.Generator, radius_m: float = 2.5, height_m: float = 1.2
) -> tuple[Floats, Floats, Floats, Floats]:
    """Stations on the walls of a room that look at its middle: R (n, 3, 3), t (n, 3) in the frame
    of the first; and the middle and the way up in it, (3,)."""
    turn = 2 * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / max(n, 3)
    reach = radius_m * rng.uniform(0.9, 1.2, n)
    height = height_m * rng.uniform(0.7, 1.2, n)
    t = np.column_stack([reach * np.cos(turn), reach * np.sin(turn), height])
    aims = rng.normal(0, 0.2, (n, 3))
    R = np.array([facing_to(p, aim[None]) for p, aim in zip(t, aims, strict=True)])
    first, origin = R[0].T, t[0]
    return first @ R, (t - origin) @ first.T, -first @ origin, first[:, 2]


def usual_factory(rng: np.random.Generator) -> Factory:
    """Values of a station drawn from the spread of 18, as half floats."""
    common = rng.standard_normal()
    drawn = {}
    for name, mean in FACTORY2_MEAN.items():
        z = rng.standard_normal(2)
        if name == "ogeemag":
            z = OGEEMAG_CORRELATION**0.5 * common + (1 - OGEEMAG_CORRELATION) ** 0.5 * z
        drawn[name] = (mean + FACTORY2_SD[name] * z).astype(np.float16).astype(np.float64)
    return Factory(*drawn.values(), generation=2)


@dataclass(frozen=True)
class TurnsTwin:
    """Stations, an object and its motion; all in the frame of the first station, metres.

    seed: of stations and motion; receiver: of what the object has of its own, so that several
    objects before the same stations differ in it alone; take: another recording of these stations
    and this object, of another motion.
    """

    seed: int
    R: Floats  # (n, 3, 3), station to the first one's frame
    t: Floats  # (n, 3)
    channels: tuple[int, ...]  # rising
    motion: MotionTwin
    board: Floats = field(default_factory=lambda: ball_board()[0])
    normals: Floats = field(default_factory=lambda: ball_board()[1])
    mount: tuple[Floats, Floats] = field(default_factory=lambda: (np.eye(3), np.zeros(3)))
    receiver: int = 0
    take: int = 0
    duration_s: float = 20.0
    common_urad: float = 15.0  # noise of a sweep
    independent_urad: float = 15.0  # of a hit
    begin_ns: float = 50.0  # of a begin of a turn as it is told: of real ones 15 to 120
    wander_ns: float = 250.0  # rms of the swing of a rotor: of real ones 200 to 370
    clock_ppm: float = 2.0  # of the receiver
    place_mm: float = 0.15  # SD of each coordinate of a diode about the board's
    cover_mm: tuple[float, float] | None = None  # a, t: see `_seen_at`
    incidence_deg: float = 80.0
    dropout: float = 0.02
    reflections: float = 0.0  # share of hits
    collisions: bool = True
    lost_begins: float = 0.005
    up: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))  # likewise


@dataclass(frozen=True)
class MadeTurns:
    """What a receiver reports, and the truth."""

    twin: TurnsTwin
    light: Light
    factories: tuple[Factory, ...]
    ids: tuple[int, ...]
    motion: Motion
    places: Floats  # (diodes, 3) where they are
    wrong: np.ndarray  # of each hit of the light: of a reflection, or given to another station


def simulate_turns(twin: TurnsTwin) -> MadeTurns:
    """Light and truth of a twin of second-generation stations."""
    rng = np.random.default_rng([twin.seed, STATIONS])
    factories = tuple(usual_factory(rng) for _ in twin.channels)
    ids = tuple(int(x) for x in rng.integers(1, 1 << 32, len(twin.channels)))
    again = [twin.take] if twin.take else []
    motion = motion_of(twin.motion, twin.t, twin.seed + 1000 * twin.take)
    receiver_rng = np.random.default_rng([twin.seed, RECEIVER, twin.receiver])
    places = twin.board + 1e-3 * twin.place_mm * receiver_rng.standard_normal(twin.board.shape)
    noise = np.random.default_rng([twin.seed, NOISE, twin.receiver, *again])
    scale = 1 + 1e-6 * (twin.clock_ppm + receiver_rng.standard_normal())
    begins, hits = [], []
    for s, channel in enumerate(twin.channels):
        period_s = float(PERIOD_S[channel] * (1 + 1e-6 * rng.normal(*PERIOD_PPM)))
        begin_s = np.arange(rng.uniform(-1, 0) * period_s, twin.duration_s, period_s)
        late = 1e-9 * twin.wander_ns * _swing(begin_s.size, rng)
        told = begin_s + late + 1e-9 * twin.begin_ns * noise.standard_normal(late.size)
        frame = encode_frame2(factories[s], ids[s], channel, accel_of(twin.R[s].T @ twin.up))
        bit = frame[(np.arange(late.size) + rng.integers(frame.size)) % frame.size]
        received = noise.random(late.size) >= twin.lost_begins
        begins.append([np.full(received.sum(), s), told[received], bit[received]])
        rotor = Rotor(begin_s[0], period_s, CubicSpline(np.arange(late.size), late), late.size)
        hits.append(_hits(twin, s, rotor, factories[s], motion, places, noise))
    station, diode, time_s, wrong = (np.concatenate(column) for column in zip(*hits, strict=True))
    if twin.collisions:
        faults = np.random.default_rng([twin.seed, FAULTS, twin.receiver, *again])
        station, received, mixed = _collide(station, time_s, faults)
        wrong = (wrong | mixed)[received]
        station, diode, time_s = station[received], diode[received], time_s[received]
    order = np.argsort(time_s)
    channels = np.array(twin.channels, np.int8)
    begin_station, begin_s, bit = (np.concatenate(column) for column in zip(*begins, strict=True))
    light = Light(
        begin_channel=channels[begin_station.astype(np.int64)],
        begin_s=np.round(begin_s * scale * TICKS_PER_S) / TICKS_PER_S,
        begin_bit=bit.astype(np.int8),
        hit_channel=channels[station[order]],
        hit_diode=diode[order].astype(np.int16),
        hit_s=np.floor(2 * time_s[order] * scale * TICKS_PER_S) / (2 * TICKS_PER_S),
        n_diodes=len(twin.board),
        duration_s=twin.duration_s,
        resolution_s=0.5 / TICKS_PER_S,
        normals=twin.normals,
    )
    return MadeTurns(twin, light, factories, ids, motion, places, wrong[order])


def _swing(n: int, rng: np.random.Generator) -> Floats:
    """Autoregressive process of second order, of rms 1, at n turns."""
    turns, decay = SWING
    burn_in = round(10 / (1 - decay))
    past = [1.0, -2 * decay * np.cos(2 * np.pi / turns), decay**2]
    z = lfilter([1.0], past, rng.standard_normal(burn_in + n))[burn_in:]
    variance = (1 + past[2]) / (1 - past[2]) / ((1 + past[2]) ** 2 - past[1] ** 2)
    return z / np.sqrt(variance)


@dataclass(frozen=True)
class Rotor:
    """The rotor of a station: turn n, or a part of one, is at begin_s + n period_s + late(n)."""

    begin_s: float
    period_s: float
    late: Callable[[Floats], Floats]
    turns: int

    def time(self, turn: np.ndarray, angle: Floats) -> Floats:
        """When the rotor points to an angle in a turn, in s, its wander included."""
        turned = turn + angle / (2 * np.pi)
        late = self.late(np.clip(turned, 0, self.turns - 1))
        return self.begin_s + turned * self.period_s + late


def _hits(
    twin: TurnsTwin,
    s: int,
    rotor: Rotor,
    factory: Factory,
    motion: Motion,
    places: Floats,
    rng: np.random.Generator,
) -> tuple[np.ndarray, ...]:
    """Station, diode, time of the hits of a station, and whether each is a reflection."""
    rows, n = parameters(factory, full=True), len(places)
    turn, plane, diode = (
        x.ravel() for x in np.meshgrid(np.arange(rotor.turns), (0, 1), np.arange(n), indexing="ij")
    )
    ahead = PLANE_RAD[plane]
    time_s = rotor.time(turn, ahead)
    for _ in range(ROUNDS):
        point, incidence = _seen_at(twin, s, time_s, diode, places, motion)
        angle = angles(point, rows)[np.arange(plane.size), plane]
        time_s = rotor.time(turn, angle + ahead)
    common = np.repeat(rng.standard_normal(2 * rotor.turns), n)
    off = 1e-6 * (
        twin.common_urad * common + twin.independent_urad * rng.standard_normal(plane.size)
    )
    inside = (np.abs(angle) < LARGEST_RAD) & (point[:, 0] > 0)
    for k in (1, 2):
        inside &= np.abs(np.arctan2(point[:, k], point[:, 0])) < FIELD_RAD
    inside &= (time_s > 0) & (time_s < twin.duration_s)
    direct = inside & (incidence < np.radians(twin.incidence_deg))
    grazing = inside & ~direct & (incidence < np.radians(GRAZING_DEG))
    share = twin.reflections * direct.sum() / max(grazing.sum(), 1)
    reflected = grazing & (rng.random(plane.size) < share)
    shift = rng.uniform(*REFLECTION_RAD, plane.size) * rng.choice([-1.0, 1.0], plane.size)
    off = off + np.where(reflected, shift, 0.0)
    received = (direct & (rng.random(plane.size) >= twin.dropout)) | reflected
    time_s = time_s + rotor.period_s * off / (2 * np.pi)
    return np.full(received.sum(), s), diode[received], time_s[received], reflected[received]


def _seen_at(
    twin: TurnsTwin, s: int, time_s: Floats, diode: np.ndarray, places: Floats, motion: Motion
) -> tuple[Floats, Floats]:
    """Diodes in the frame of a station, and their incidence in rad.

    Behind a cover of refraction n a diode seems shifted along its normal by a + t (1 - cos i /
    sqrt(n^2 - sin^2 i)), i being the incidence.
    """
    turn, shift = twin.mount
    R, p = motion.poses(time_s)
    at = np.einsum("nij,nj->ni", R, (places @ turn.T + shift)[diode]) + p
    normal = np.einsum("nij,nj->ni", R, (twin.normals @ turn.T)[diode])
    way = twin.t[s] - at
    cosine = np.einsum("ni,ni->n", way, normal) / np.linalg.norm(way, axis=1)
    if twin.cover_mm is not None:
        a, t = 1e-3 * np.array(twin.cover_mm)
        into = np.sqrt(REFRACTION**2 - 1 + cosine**2)
        at = at + (a + t * (1 - cosine / into))[:, None] * normal
    return (at - twin.t[s]) @ twin.R[s], np.arccos(np.clip(cosine, -1, 1))


def _collide(
    station: np.ndarray, time_s: Floats, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stations as a receiver tells them, which hits remain, and which are of another station."""
    order = np.argsort(time_s)
    t, s = time_s[order], station[order]
    other = np.full(s.size, -1)
    for back in (1, -1):  # the neighbour in time of another station, if it is near
        near = np.roll(s, back)
        close = (np.abs(np.roll(t, back) - t) < GROUP_S) & (near != s)
        other[close] = near[close]
    # All hits of a sweep collide if one does.
    new = (np.diff(s, prepend=-1) != 0) | (np.diff(t, prepend=-1.0) > GROUP_S)
    group = np.cumsum(new) - 1
    of_group = np.full(int(group[-1]) + 1, -1)
    np.maximum.at(of_group, group, other)
    draw = rng.random(s.size)
    mixed = (of_group[group] >= 0) & (draw >= LOST) & (draw < LOST + MIXED)
    received = ~((of_group[group] >= 0) & (draw < LOST))
    unsorted = np.argsort(order)
    return np.where(mixed, of_group[group], s)[unsorted], received[unsorted], mixed[unsorted]


def write_rec(
    path: str | Path,
    simulation: MadeTurns,
    name: str = "T20",
    serial: str = "LHR-TWIN",
    begin: int = 0,
) -> None:
    """A recording of libsurvive, packed, whole or not at all; begin: of the 32-bit counter."""
    twin, light = simulation.twin, simulation.light
    lights = {"modelPoints": twin.board.tolist(), "modelNormals": twin.normals.tolist()}
    config = json.dumps({"device_serial_number": serial, "lighthouse_config": lights})
    half = np.round(2 * TICKS_PER_S * light.hit_s).astype(np.int64)
    ticks = np.round(TICKS_PER_S * light.begin_s).astype(np.int64)
    lines = [
        (t / 2, f"W {c} {d} {(t // 2 + begin) % 2**32} {t % 2}")
        for t, c, d in zip(half, light.hit_channel, light.hit_diode, strict=True)
    ]
    late = PERIOD_S[light.begin_channel] * TICKS_PER_S  # a turn is told after its sweeps
    lines += [
        (t + after, f"Y {c} {(t + begin) % 2**32} {b} 0")
        for t, after, c, b in zip(ticks, late, light.begin_channel, light.begin_bit, strict=True)
    ]
    text = [f"0.1 {name} CONFIG {config}"]
    text += [f"{1.002 + t / TICKS_PER_S:.6f} {name} {line}" for t, line in sorted(lines)]
    with whole(path) as part:
        part.write_bytes(gzip.compress(("\n".join(text) + "\n").encode(), 1))
