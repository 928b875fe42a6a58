"""What a calibration by `batch` is given."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.batch.problem import Priors, SideInformation
from mocap_metrology.lighthouse.calibrate.pnp import is_flat
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics
from mocap_metrology.lighthouse.known_length import KnownLength
from mocap_metrology.lighthouse.published import FACTORY2_MEAN, FACTORY2_SD
from mocap_metrology.lighthouse.rotor import VARIANTS, directions, rotor_parameters

NAME = "batch"
ESTIMATED = "estimated"  # optics: the rotors' values are among the unknowns
IDEAL_PLANES = records.Factory(generation=2)
MEAN_PLANES = records.Factory(**FACTORY2_MEAN, generation=2)
MOST_BEHIND = 0.5  # of the sightings: reflections are fewer
Pose = tuple[np.ndarray, np.ndarray]


def _part_sd(size: str, phase: str) -> np.ndarray:
    """Standard deviation of either part, along and across, of a term with a size and a phase."""
    mean = FACTORY2_MEAN[size] * FACTORY2_SD[phase]
    return np.hypot(FACTORY2_SD[size], mean)


UNKNOWN_SD = np.stack(
    [
        *(FACTORY2_SD[name] for name in ("phase", "tilt", "curve")),
        *2 * [_part_sd("gibmag", "gibphase")],
        *2 * [_part_sd("ogeemag", "ogeephase")],
    ],
    axis=1,
)


def optics_for(kinds: Sequence[str], factories: Sequence[records.Factory | None]) -> str:
    """The best of the optics asked for, by what is known of all stations."""
    if "factory" in kinds and None not in factories:
        return "factory"
    return ESTIMATED if ESTIMATED in kinds else "ideal"


@dataclass(frozen=True)
class Sensors:
    """Data that are used besides hits: gyroscope and accelerometer of the board, and the way up in
    the frame of each station (stations, 3), NaN where it is unknown; lengths that were measured in
    the room; normals (n, 3) of the diodes, whose cover then is an unknown; clocks of the stations,
    where the recording tells them."""

    inertial: records.Inertial | None = None
    ups: np.ndarray | None = None
    lengths: tuple[KnownLength, ...] = ()
    normals: np.ndarray | None = None
    clocks: tuple[records.Clock | None, ...] = ()


@dataclass(frozen=True)
class Scene:
    """What a calibration is given: cleaned hits, board (n, 3) in m, optics as in `seen` or
    `estimated`, and what is known beforehand; known_pose: those of the stations are held; covered:
    the cover of a flat board is an unknown."""

    hits: records.Hits
    board: np.ndarray
    optics: str
    factories: Sequence[records.Factory | None]
    lasers_m: np.ndarray | None
    variant: str
    priors: Priors
    known_pose: bool = False
    sensors: Sensors = Sensors()
    generation: int = 1
    names: Sequence[str] = records.ROLES
    covered: bool = True

    @property
    def title(self) -> str:
        """The estimate, in messages."""
        return f"{NAME}, {self.optics}"

    @property
    def rotors(self) -> np.ndarray:
        """Parameters of all rotors, (stations, 2, 13), as the optics has them: of known factory
        values by the variant that is asked for, of unknown planes those of real ones on average."""
        second, known = self.generation == 2, self.optics == "factory"
        planes = IDEAL_PLANES if self.optics == "ideal" else MEAN_PLANES
        used = known or (second and self.optics == ESTIMATED)
        unknown = planes if second else None
        factories = [(factory if used else None) or unknown for factory in self.factories]
        lasers = [None] * len(factories) if self.lasers_m is None else self.lasers_m
        model = VARIANTS[self.variant if known else "libsurvive" if second else "crazyflie"]
        return np.array(
            [
                rotor_parameters(f, factory, model)
                for f, factory in zip(factories, lasers, strict=True)
            ]
        )

    @property
    def spreads(self) -> np.ndarray | None:
        """Spreads of planes as `problem.layout` expects them: of phases of plane 1, and of unknown
        stations."""
        if self.generation != 2:
            return None
        known = np.zeros((2, 7))
        if self.optics == "ideal":
            return np.array([known] * len(self.factories))
        known[1, 0] = 1e-3 * self.priors.phase_mrad
        return np.array([UNKNOWN_SD if factory is None else known for factory in self.factories])

    @property
    def more(self) -> SideInformation:
        """What an estimate knows besides. Before stations of the second generation diodes of a flat
        board look along its normal, to the side that the light comes from."""
        normals = self.sensors.normals
        if normals is None and self.generation == 2 and self.covered and is_flat(self.board):
            across = np.linalg.svd(self.board - self.board.mean(axis=0))[2][2]
            normals = np.tile(across, (len(self.board), 1))
        return SideInformation(self.sensors.ups, self.spreads, normals)

    def of(self, members: Sequence[int]) -> Scene:
        """Some of the stations, the first of them the reference."""
        place = np.full(len(self.factories), -1, self.hits.station.dtype)
        place[list(members)] = np.arange(len(members))
        hits = self.hits.take(place[self.hits.station] >= 0)
        ups = self.sensors.ups
        return replace(
            self,
            hits=replace(hits, station=place[hits.station]),
            factories=[self.factories[k] for k in members],
            sensors=replace(
                self.sensors,
                ups=None if ups is None else ups[list(members)],
                lengths=tuple(length.among(members) for length in self.sensors.lengths),
                clocks=tuple(self.sensors.clocks[k] for k in members if self.sensors.clocks),
            ),
            names=[self.names[k] for k in members],
        )

    @property
    def used_priors(self) -> Priors:
        """Ideal optics claim to have no phase and no depth, named lasers no depth. Where the light
        is received on a deep board shows in its cover before stations of the second generation."""
        priors = self.priors
        if self.generation == 2:
            covered = self.sensors.normals is not None and not is_flat(self.board)
            return priors if covered else priors.of_board(self.board)
        if self.optics == ESTIMATED:
            priors = priors.of_unknown_rotors()
        if self.optics == "ideal":
            priors = replace(priors, phase_mrad=0.0)
        if self.optics == "ideal" or self.lasers_m is not None:
            priors = replace(priors, laser_depth_mm=0.0)
        return priors.of_board(self.board)

    def seen(self, measured: Sequence[records.Measurements]) -> Optics:
        """Measurements as the optics see them; where these are estimated, it starts from ideal, of
        the second generation from usual ones. With lasers in the origin, factory values are
        subtracted from the angles once (to 1e-12 rad); with lasers elsewhere they stay in the
        model."""
        first, rotors = self.generation == 1, tuple(self.rotors)
        name = "ideal" if first and self.optics == ESTIMATED else self.optics
        housing = first and self.lasers_m is not None
        if housing or (first and name == "ideal"):
            frame = "housing" if housing else "optical"
            return Optics(name, tuple(measured), rotors, frame)
        seen = tuple(
            replace(angles, angles_rad=directions(angles.angles_rad, rotor))
            for angles, rotor in zip(measured, rotors, strict=True)
        )
        return Optics(name, seen, (rotor_parameters(),) * len(seen), "optical")


def sightings(measured: records.Measurements, path: records.Path) -> tuple[np.ndarray, ...]:
    """R (n, 3, 3) and t (n, 3) of the board in a frame whose origin is the station, and the diode
    (n,), of each that is seen where the board's pose is known."""
    row, diode = np.nonzero(measured.seen[np.isin(measured.time_s, path.time_s)])
    return path.R[row], path.t_m[row], diode


def faced(scene: Scene, seen: Iterable[tuple[np.ndarray, ...]]) -> tuple[Scene, str]:
    """The scene, without the normals of its diodes where most light would come from behind them;
    and why, or an empty text; seen: as `sightings`. A flat board fits its mirror image turned
    over."""
    if (normals := scene.sensors.normals) is None:
        return scene, ""
    R, t, diode = map(np.concatenate, zip(*seen, strict=True))
    place = t + np.einsum("nij,nj->ni", R, scene.board[diode])
    behind = np.einsum("nij,nj,ni->n", R, normals[diode], place) > 0
    if behind.sum() <= MOST_BEHIND * behind.size:
        return scene, ""
    why = f"directions of the diodes not used: {100 * behind.mean():.0f} % of the light would come"
    why += " from behind them. Is the board file a mirror image, or are its directions wrong?"
    return replace(scene, sensors=replace(scene.sensors, normals=None)), why
