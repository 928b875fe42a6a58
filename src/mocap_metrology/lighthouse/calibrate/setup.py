"""Any number of stations by `batch`, and several recordings of a setup in one estimate.

The stations keep their places, so all recordings share their poses, the optics and the boards, and
each has a trajectory of its own: their normal equations, without the trajectories, are added.
Recordings at different places determine what one cannot, above all the optics of stations that do
not transmit them. What the recordings say of each other is the check: the pose of each is held
against that from all others.

Recordings may see different stations, which common views in any of them connect: each begins from
its own estimate, in the frame of a station that it sees, and is brought to the reference's through
the stations that it shares with those before it. Objects may differ: then the diodes of all boards
are places of one, of which each recording sees its own. Their scales count as one, by the least
certain of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.estimate import Joint, determined, estimate
from mocap_metrology.lighthouse.batch.parts import misfit_of, predicted
from mocap_metrology.lighthouse.batch.recording import BatchInput
from mocap_metrology.lighthouse.calibrate import network as networks
from mocap_metrology.lighthouse.calibrate.batch import all_solved, details_of, joint, pose_of
from mocap_metrology.lighthouse.calibrate.fits import poses_of, refitted
from mocap_metrology.lighthouse.calibrate.scene import (
    NAME,
    Pose,
    Scene,
    Sensors,
    faced,
    optics_for,
    sightings,
)
from mocap_metrology.lighthouse.calibrate.stages import Calibration, CalibrationSettings
from mocap_metrology.lighthouse.calibrate.static import is_constant, is_still, median_angles
from mocap_metrology.lighthouse.calibrate.variants import (
    AUTO,
    FALLBACK,
    NAMES,
    VariantFit,
    all_one,
    exchanged,
    steps,
    weighed_stations,
    widened,
)
from mocap_metrology.lighthouse.records import (
    COVARIANCE_UNITS,
    Halves,
    Hits,
    Measurements,
    PoseEstimate,
    Station,
)

FEWEST = 2  # recordings
OF_PLANES = (FALLBACK, "crazyflie")  # variants of the rotor model of the second generation


def calibrate_stations(
    hits: Hits,
    board: np.ndarray,
    stations: Sequence[Station],
    settings: CalibrationSettings,
    report: Callable[[str], None],
    sensors: Sensors | None,
) -> Calibration:
    """Poses of all stations that are connected with the reference, the first of `stations`, or
    with most others where the reference is alone. Of the second generation the optics are
    `factory` where the values of all of these are known; else `estimated`, with the spread of real
    stations as the prior of those that are not. Raises `Refusal` where no two are connected, or the
    search does not converge.
    """
    names = [station.role for station in stations]
    factories = [station.factory for station in stations]
    generation = stations[0].generation
    how = None, FALLBACK if settings.variant == AUTO else settings.variant, settings.priors
    optics = optics_for(settings.optics, factories)
    every = Scene(hits, board, optics, factories, *how, generation=generation, names=names)
    every = replace(every, sensors=sensors or Sensors())
    began = time.perf_counter()
    seen = networks.look(every)
    shared = networks.shared_moments(seen)
    own, network = networks.network_of(names, shared)
    if len(own) < 2:
        raise Refusal(
            f"no two of the stations {', '.join(names)} see four diodes at"
            f" {networks.FEWEST_MOMENTS} common moments; expected a board that at least two"
            " stations see at a time"
        )
    scene = every.of(own)
    scene = replace(scene, optics=optics_for(settings.optics, scene.factories))
    views = [seen[k] for k in own]
    scene, why = faced(scene, (sightings(one.measurements, one.paths[0]) for one in views if one))
    still = None
    if all(view is not None and is_still(view.paths[0]) for view in views) or (
        generation == 2 and is_constant(scene.hits, len(board))
    ):
        still = [median_angles(scene.hits, k, len(board)) for k in range(len(own))]
    near = networks.start(scene, views) if still is None else None
    given = joint(scene, still, near)
    scene, given, ways = _best(scene, given, settings, near is not None)
    poses, found = all_solved(scene, still, given)
    seconds = time.perf_counter() - began
    report(f"{NAME}, {scene.optics}, {len(own)} stations: {seconds:.2f} s")
    open_ways = ways or [[] for _ in poses]
    return Calibration(
        estimates=[widened(pose, way) for pose, way in zip(poses, open_ways, strict=True)],
        paths={(NAME, scene.optics): (poses[0].path,)} if poses[0].path is not None else {},
        still=still is not None,
        n_common=min(network.common[name] for name in network.connected),
        why=[*network.apart.values(), *filter(None, [why])],
        variants=ways[0] if ways else [],
        joints={scene.optics: (scene, found)},
        network=replace(network, covariance=covariance_of_all(found, open_ways)),
        exchanged=exchanged(scene, found, stations),
    )


def _best(
    scene: Scene, given: tuple[Joint, str], settings: CalibrationSettings, moved: bool
) -> tuple[Scene, tuple[Joint, str], list[list[VariantFit]]]:
    """The estimate by the variant of the rotor model that the recording prefers, and all of each
    station."""
    auto = scene.optics == "factory" and settings.variant == AUTO and scene.generation == 2
    if not auto or not moved or all_one(scene.factories):
        return scene, given, []
    of = {name: replace(scene, variant=name) for name in OF_PLANES}
    try:
        ways = weighed_stations(of, dict.fromkeys(of, given[0]))
        best = next(way.variant for way in ways[0] if way.standing == "chosen")
        if best != scene.variant:
            given = refitted(of[best], given[0]), given[1]
            ways = weighed_stations(of, dict.fromkeys(of, given[0]))
    except Refusal:  # the other variant fits no better than not at all
        return scene, given, []
    return of[best], given, ways


def covariance_of_all(found: Joint, ways: Sequence[Sequence[VariantFit]]) -> np.ndarray:
    """Covariance of all poses in mm and deg, with the variants that are left open."""
    n = len(ways)
    rows = np.concatenate([found.pose(k) for k in range(1, n + 1)])
    units = np.tile(COVARIANCE_UNITS, n)
    own = found.covariance[np.ix_(rows, rows)] * np.outer(units, units)
    off = np.hstack([steps(way) for way in ways])
    return own + off.T @ off / (len(off) + 1)


@dataclass(frozen=True)
class Setup:
    """The estimate from all recordings, a pose of each station but the reference; by station and
    recording each held against the others; the variants of the rotor model; why recordings were
    left out; and, of any number of stations, which are connected."""

    poses: list[PoseEstimate]
    predicted: Mapping[str, Mapping[str, Halves]]
    variants: list[VariantFit]
    why: list[str]
    network: networks.Network | None = None

    @property
    def pose(self) -> PoseEstimate:
        return self.poses[0]


@dataclass(frozen=True)
class _Piece:
    """A recording alone, or what it sees of stations that it does not connect with its others:
    members (m,) among all stations, moments (n, n) that each two share; first: of its board's
    diodes among those of all boards."""

    recording: str
    title: str
    members: list[int]
    shared: np.ndarray
    found: Joint
    first: int


def by_setup(
    scenes: Mapping[str, Scene],
    still: Mapping[str, Sequence[Measurements]] | None = None,
    objects: Mapping[str, str] | None = None,
) -> Setup:
    """Poses from recordings that differ in their hits, boards and normals only; still: median
    angles of each station in those in which the board keeps its place; objects: which object each
    is of, where equal boards are not one.

    Raises `Refusal` where fewer than two of them can be used, or all together do not converge.
    """
    begun, why = time.perf_counter(), list[str]()
    scene, firsts = _of_all_boards(scenes, objects or {})
    pieces = [
        piece
        for (name, own), first in zip(scenes.items(), firsts, strict=True)
        for piece in _alone(name, own, (still or {}).get(name), first, why)
    ]
    scene, pieces, network = _connected(scene, pieces, why)
    if len(used := {piece.recording for piece in pieces}) < FEWEST:
        raise Refusal(
            f"{len(used)} recordings of the setup can be used; expected at least {FEWEST}"
            + "".join(f"; {reason}" for reason in why)
        )
    found, scene, ways = _by_variant(scene, scenes, pieces)
    with determined(scene.title):
        apart = predicted(found, scene.used_priors)
        details = details_of(scene, found)
        poses, by_station = [], {}
        for k, name in enumerate(scene.names[1:], start=1):
            pairs = zip(pieces, apart[k - 1], strict=True)
            by_name = {piece.title: pair for piece, pair in pairs if pair is not None}
            worst = max(by_name.values(), key=lambda pair: pair.m2, default=None)
            pose = replace(pose_of(scene, found, "final", details, k), halves=worst)
            pose = widened(pose, ways[k - 1])
            poses.append(replace(pose, seconds=time.perf_counter() - begun))
            by_station[name] = by_name
    network = network and replace(network, covariance=covariance_of_all(found, ways))
    return Setup(poses, by_station, ways[0], why, network)


def _of_all_boards(
    scenes: Mapping[str, Scene], objects: Mapping[str, str]
) -> tuple[Scene, list[int]]:
    """A scene with the diodes of all boards, and the first of them that each recording sees."""
    keys = [objects.get(name, own.board.tobytes()) for name, own in scenes.items()]
    of = dict(zip(keys, scenes.values(), strict=True))
    scene, every = next(iter(scenes.values())), list(of.values())
    if len(of) == 1:
        return scene, [0] * len(scenes)
    ends = np.cumsum([len(own.board) for own in every]).tolist()
    first = {key: end - len(own.board) for (key, own), end in zip(of.items(), ends, strict=True)}
    normals = [own.sensors.normals for own in every]
    known = any(one is not None for one in normals)
    none = [np.zeros_like(own.board) for own in every]  # a diode without a normal has no cover
    given = [a if b is None else b for a, b in zip(none, normals, strict=True)]
    scale = max(own.priors.of_board(own.board).board_scale for own in every)
    scene = replace(
        scene,
        board=np.concatenate([own.board for own in every]),
        priors=replace(scene.priors, board_scale=scale),
        sensors=replace(scene.sensors, normals=np.concatenate(given) if known else None),
    )
    return scene, [first[key] for key in keys]


def _alone(
    name: str, scene: Scene, still: Sequence[Measurements] | None, first: int, why: list[str]
) -> Iterator[_Piece]:
    """Estimates of one recording, or why there is none."""
    n = len(scene.names)
    scene = replace(scene, variant=NAMES[0] if scene.variant == AUTO else scene.variant)
    shared, parts, seen = np.ones((n, n), int), [list(range(n))], None
    if scene.generation == 2:
        seen = networks.look(scene)
        shared = networks.shared_moments(seen)
        parts = [own for own in networks.islands(shared) if len(own) > 1]
        if not parts:
            why.append(
                f"{name}: no two stations see four diodes at {networks.FEWEST_MOMENTS}"
                " common moments"
            )
    for own in parts:
        of = scene.of(own) if seen else scene
        stations = ", ".join(scene.names[k] for k in own)
        title = name if len(parts) == 1 else f"{name} (stations {stations})"
        try:
            middle = still and [still[k] for k in own]
            near = networks.start(of, [seen[k] for k in own]) if seen and not middle else None
            found, note = joint(of, middle, near)
        except Refusal as refusal:
            why.append(f"{title}: {refusal}")
            continue
        why += [f"{title}: {note}"] if note else []
        yield _Piece(name, title, own, shared, found, first)


def _connected(
    scene: Scene, pieces: list[_Piece], why: list[str]
) -> tuple[Scene, list[_Piece], networks.Network | None]:
    """The stations that common views in all recordings connect with the reference (or, if none
    does, most stations), and the recordings that see them."""
    if scene.generation != 2 or not pieces:
        return scene, pieces, None
    names, n = scene.names, len(scene.names)
    shared = np.zeros((n, n), int)
    for piece in pieces:
        both = np.ix_(piece.members, piece.members)
        shared[both] += piece.shared[both]
    own, network = networks.network_of(names, shared)
    kept = []
    for piece in pieces:
        if piece.members[0] in own:
            kept.append(replace(piece, members=[own.index(k) for k in piece.members]))
        else:
            why.append(f"{piece.title}: no station that is connected with {network.connected[0]}")
    why += network.apart.values()
    return scene.of(own), kept, network


def _by_variant(
    scene: Scene, scenes: Mapping[str, Scene], pieces: Sequence[_Piece]
) -> tuple[Joint, Scene, list[list[VariantFit]]]:
    """All recordings together, by the variant of the rotor model that fits best; all as each
    station's pose has them."""
    every = NAMES if scene.generation == 1 else OF_PLANES
    auto = scene.optics == "factory" and scene.variant == AUTO and not all_one(scene.factories)
    names = every if auto else (NAMES[0] if scene.variant == AUTO else scene.variant,)
    of = {name: replace(scene, variant=name) for name in names}
    found: dict[str, Joint] = {}
    ways: list[list[VariantFit]] = [[] for _ in scene.names[1:]]
    best = names[0]
    while best not in found:
        found[best] = _together(of[best], scenes, pieces)
        if len(names) > 1:
            ways = weighed_stations(of, dict.fromkeys(of, found[best]))
            best = next(way.variant for way in ways[0] if way.standing == "chosen")
    joined = found[best]
    if scene.generation == 2:
        joined = replace(joined, misfit=misfit_of(joined))
    return joined, of[best], ways


def _together(scene: Scene, scenes: Mapping[str, Scene], pieces: Sequence[_Piece]) -> Joint:
    """From the estimates of the single recordings, beginning at the most certain poses."""
    poses, frames = _placed(pieces)
    given = []
    for piece, frame in zip(pieces, frames, strict=True):
        one, members = piece.found.recordings[0], np.array(piece.members)
        own = one.sweeps.hits
        hits = replace(
            own,
            station=members.astype(own.station.dtype)[own.station],
            diode=own.diode + own.diode.dtype.type(piece.first),
        )
        series = None if one.sensors is None else one.sensors.windows.series
        lengths = tuple(length.known for length in one.lengths)
        clocks = dict(zip(piece.members, one.clocks, strict=False))
        of_all = tuple(clocks.get(k) for k in range(len(scene.names)))
        given.append(BatchInput(hits, one.trajectory.seen_from(*frame), series, lengths, of_all))
    R, t = zip(*(poses[k] for k in range(len(scene.names))), strict=True)
    with determined(scene.title):
        how = scene.rotors, scene.board, scene.used_priors
        found = estimate(given, R, t, *how, more=scene.more)
    return found.sure(scene.title)


def _placed(pieces: Sequence[_Piece]) -> tuple[dict[int, Pose], list[Pose]]:
    """Poses of the stations in the frame of the first, and of the frame of each piece in it."""

    def variance(piece: _Piece) -> float:
        own = range(1, len(piece.members))
        return float(np.mean([np.trace(piece.found.pose_covariance(k)[:3, :3]) for k in own]))

    left = sorted(range(len(pieces)), key=lambda k: variance(pieces[k]))
    poses, frames = {0: networks.HERE}, dict[int, Pose]()
    while left:
        k = next(k for k in left if poses.keys() & set(pieces[k].members))
        left.remove(k)
        own = dict(zip(pieces[k].members, poses_of(pieces[k].found), strict=True))
        anchor = next(member for member in own if member in poses)
        (R_0, t_0), (R, t) = poses[anchor], own[anchor]
        turn = R_0 @ R.T
        frames[k] = turn, t_0 - turn @ t
        for member, (R, t) in own.items():
            poses.setdefault(member, (turn @ R, turn @ t + frames[k][1]))
    return poses, [frames[k] for k in range(len(pieces))]
