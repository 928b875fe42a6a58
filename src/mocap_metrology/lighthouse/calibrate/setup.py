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
from mocap_metrology.lighthouse.batch import parts
from mocap_metrology.lighthouse.batch.estimate import Joint, estimate, expect_determined
from mocap_metrology.lighthouse.batch.recording import BatchInput
from mocap_metrology.lighthouse.calibrate import batch, fits, variants
from mocap_metrology.lighthouse.calibrate import network as networks
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
from mocap_metrology.lighthouse.calibrate.variants import AUTO, FALLBACK, NAMES, VariantFit
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
    """Poses of all stations of the second generation that are connected with the reference, the
    first of `stations`, or with most others where the reference is alone. The optics are `factory`
    where the values of all of these are known; else `estimated`, with the spread of real stations
    as the prior of those that are not. Raises `Refusal` where no two are connected, or the search
    does not converge.
    """
    names = [station.role for station in stations]
    factories = [station.factory for station in stations]
    how = None, FALLBACK if settings.variant == AUTO else settings.variant, settings.priors
    optics = optics_for(settings.optics, factories)
    known = sensors or Sensors()
    every = Scene(hits, board, optics, factories, *how, sensors=known, generation=2, names=names)
    began = time.perf_counter()
    seen = networks.look(every)
    shared = networks.shared_moments(seen)
    members, network = networks.network_of(names, shared)
    if len(members) < 2:
        raise Refusal(
            f"no two of the stations {', '.join(names)} see four diodes at"
            f" {networks.FEWEST_MOMENTS} common moments; expected a board that at least two"
            " stations see at a time"
        )
    scene = every.of(members)
    scene = replace(scene, optics=optics_for(settings.optics, scene.factories))
    views = [seen[k] for k in members]
    scene, why = faced(scene, (sightings(one.measurements, one.paths[0]) for one in views if one))
    still = None
    at_rest = all(view is not None and is_still(view.paths[0]) for view in views)
    if at_rest or is_constant(scene.hits, len(board)):
        still = [median_angles(scene.hits, k, len(board)) for k in range(len(members))]
    near = networks.start(scene, views) if still is None else None
    begun = batch.joint(scene, still, near)
    scene, begun, ways = _best_stations(scene, begun, settings, near is not None)
    poses, solution = batch.all_solved(scene, still, begun)
    seconds = time.perf_counter() - began
    report(f"{NAME}, {scene.optics}, {len(members)} stations: {seconds:.2f} s")
    open_ways = ways or [[] for _ in poses]
    return Calibration(
        estimates=[variants.widened(pose, way) for pose, way in zip(poses, open_ways, strict=True)],
        paths={(NAME, scene.optics): (poses[0].path,)} if poses[0].path is not None else {},
        still=still is not None,
        n_common=min(network.common[name] for name in network.connected),
        why=[*network.apart.values(), *filter(None, [why])],
        variants=ways[0] if ways else [],
        joints={scene.optics: (scene, solution)},
        network=replace(network, covariance=covariance_of_all(solution, open_ways)),
        exchanged=variants.exchanged(scene, solution, stations),
    )


def _best_stations(
    scene: Scene, begun: tuple[Joint, str], settings: CalibrationSettings, moved: bool
) -> tuple[Scene, tuple[Joint, str], list[list[VariantFit]]]:
    """The estimate by the variant of the rotor model that the recording prefers, and all of each
    station."""
    auto = scene.optics == "factory" and settings.variant == AUTO
    if not auto or not moved or variants.all_one(scene.factories):
        return scene, begun, []
    of = {name: replace(scene, variant=name) for name in OF_PLANES}

    def estimate_of(name: str) -> tuple[Joint, str]:
        return begun if name == scene.variant else (fits.refitted(of[name], begun[0]), begun[1])

    try:
        best, begun, ways = variants.preferred(of, scene.variant, estimate_of)
    except Refusal:  # the other variant fits no better than not at all
        return scene, begun, []
    return of[best], begun, ways


def covariance_of_all(solution: Joint, ways: Sequence[Sequence[VariantFit]]) -> np.ndarray:
    """Covariance of all poses in mm and deg, with the variants that are left open."""
    n = len(ways)
    rows = np.concatenate([solution.pose(k) for k in range(1, n + 1)])
    units = np.tile(COVARIANCE_UNITS, n)
    covariance = solution.covariance[np.ix_(rows, rows)] * np.outer(units, units)
    off = np.hstack([variants.steps(way) for way in ways])
    return covariance + off.T @ off / (len(off) + 1)


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
    scene, firsts = of_all_boards(scenes, objects or {})
    pieces = [
        piece
        for (name, one), first in zip(scenes.items(), firsts, strict=True)
        for piece in single_estimates(name, one, (still or {}).get(name), first, why)
    ]
    scene, pieces, network = connected_pieces(scene, pieces, why)
    if len(used := {piece.recording for piece in pieces}) < FEWEST:
        raise Refusal(
            f"{len(used)} recordings of the setup can be used; expected at least {FEWEST}"
            + "".join(f"; {reason}" for reason in why)
        )
    solution, scene, ways = _by_variant(scene, pieces)
    with expect_determined(scene.title):
        members = parts.members_of(solution)
        apart = parts.predicted(solution, scene.used_priors, members)
        if scene.generation == 1:
            zeros = parts.pull_of_zeros(solution, scene.used_priors, members)
            solution = replace(solution, begins=solution.begins + zeros)
        usable = {piece.title: piece.usable for piece in pieces}
        solution, touched, left = parts.halves_of_all(solution)
        details = {**batch.details_of(scene, solution, usable), "misfit_left": left}
        poses, by_station = [], {}
        for k, name in enumerate(scene.names[1:], start=1):
            pairs = zip(usable, apart[k - 1], strict=True)
            by_name = {title: pair for title, pair in pairs if pair is not None}
            moved = zip(usable, touched[k - 1], strict=True)
            every = [*by_name.items(), *((t, one) for t, one in moved if one and one.stepped)]
            where, worst = max(every, key=lambda pair: pair[1].m2, default=("", None))
            of = {} if worst is None or worst.recordings else {"halves_of": where}
            pose = replace(batch.pose_of(scene, solution, "final", details | of, k), halves=worst)
            pose = variants.widened(pose, ways[k - 1])
            poses.append(replace(pose, seconds=time.perf_counter() - begun))
            by_station[name] = by_name
    network = network and replace(network, covariance=covariance_of_all(solution, ways))
    return Setup(poses, by_station, ways[0], why, network)


def _by_variant(
    scene: Scene, pieces: Sequence[Piece]
) -> tuple[Joint, Scene, list[list[VariantFit]]]:
    """All recordings together, by the variant of the rotor model that fits best; all as each
    station's pose has them."""
    every = NAMES if scene.generation == 1 else OF_PLANES
    auto, fixed = scene.variant == AUTO, NAMES[0] if scene.variant == AUTO else scene.variant
    of = {name: replace(scene, variant=name) for name in (*every, fixed)}
    if auto and scene.optics == "factory" and not variants.all_one(scene.factories):
        fixed, (joined, _), ways = variants.preferred(
            of, fixed, lambda name: (_joint_estimate(of[name], pieces), "")
        )
    else:
        joined, ways = _joint_estimate(of[fixed], pieces), [[] for _ in scene.names[1:]]
    if scene.generation == 2:
        joined = replace(joined, misfit=parts.misfit_of(joined))
    return joined, of[fixed], ways


def _joint_estimate(scene: Scene, pieces: Sequence[Piece]) -> Joint:
    """From the estimates of the single recordings, beginning at the most certain poses."""
    poses, frames = placed(pieces)
    inputs = []
    for piece, frame in zip(pieces, frames, strict=True):
        one, members = piece.joint.recordings[0], np.array(piece.members)
        its_hits = one.sweeps.hits
        hits = replace(
            its_hits,
            station=members.astype(its_hits.station.dtype)[its_hits.station],
            diode=its_hits.diode + its_hits.diode.dtype.type(piece.first),
        )
        series = None if one.sensors is None else one.sensors.windows.series
        lengths = tuple(length.known for length in one.lengths)
        clocks = dict(zip(piece.members, one.clocks, strict=False))
        of_all = tuple(clocks.get(k) for k in range(len(scene.names)))
        inputs.append(BatchInput(hits, one.trajectory.seen_from(*frame), series, lengths, of_all))
    R, t = zip(*(poses[k] for k in range(len(scene.names))), strict=True)
    with expect_determined(scene.title):
        how = scene.rotors, scene.board, scene.used_priors
        solution = estimate(inputs, R, t, *how, more=scene.more)
    return solution.sure(scene.title)


@dataclass(frozen=True)
class Piece:
    """A recording alone, or what it sees of stations that it does not connect with its others:
    members (m,) among all stations, moments (n, n) that each two share; first: of its board's
    diodes among those of all boards; usable: its hits as in `usable_hits`."""

    recording: str
    title: str
    members: list[int]
    shared: np.ndarray
    joint: Joint
    first: int
    usable: int


def of_all_boards(
    scenes: Mapping[str, Scene], objects: Mapping[str, str]
) -> tuple[Scene, list[int]]:
    """A scene with the diodes of all boards, and the first of them that each recording sees."""
    keys = [objects.get(name, one.board.tobytes()) for name, one in scenes.items()]
    of = dict(zip(keys, scenes.values(), strict=True))
    scene, every = next(iter(scenes.values())), list(of.values())
    if len(of) == 1:
        return scene, [0] * len(scenes)
    ends = np.cumsum([len(one.board) for one in every]).tolist()
    first = {key: end - len(one.board) for (key, one), end in zip(of.items(), ends, strict=True)}
    normals = [one.sensors.normals for one in every]
    known = any(one is not None for one in normals)
    none = [np.zeros_like(one.board) for one in every]  # a diode without a normal has no cover
    filled = [a if b is None else b for a, b in zip(none, normals, strict=True)]
    scale = max(one.used_priors.board_scale for one in every)
    scene = replace(
        scene,
        board=np.concatenate([one.board for one in every]),
        priors=replace(scene.priors, board_scale=scale),
        sensors=replace(scene.sensors, normals=np.concatenate(filled) if known else None),
    )
    return scene, [first[key] for key in keys]


def single_estimates(
    name: str, scene: Scene, still: Sequence[Measurements] | None, first: int, why: list[str]
) -> Iterator[Piece]:
    """Estimates of one recording, or why there is none."""
    n = len(scene.names)
    scene = replace(scene, variant=NAMES[0] if scene.variant == AUTO else scene.variant)
    shared, together, seen = np.ones((n, n), int), [list(range(n))], None
    if scene.generation == 2:
        seen = networks.look(scene)
        shared = networks.shared_moments(seen)
        together = [island for island in networks.islands(shared) if len(island) > 1]
        if not together:
            why.append(
                f"{name}: no two stations see four diodes at {networks.FEWEST_MOMENTS}"
                " common moments"
            )
    for island in together:
        of = scene.of(island) if seen else scene
        stations = ", ".join(scene.names[k] for k in island)
        title = name if len(together) == 1 else f"{name} (stations {stations})"
        try:
            middle = still and [still[k] for k in island]
            near = networks.start(of, [seen[k] for k in island]) if seen and not middle else None
            solution, note = batch.joint(of, middle, near)
        except Refusal as refusal:
            why.append(f"{title}: {refusal}")
            continue
        why += [f"{title}: {note}"] if note else []
        usable = batch.usable_hits(of, solution)
        yield Piece(name, title, island, shared, solution, first, usable)


def connected_pieces(
    scene: Scene, pieces: list[Piece], why: list[str]
) -> tuple[Scene, list[Piece], networks.Network | None]:
    """The stations that common views in all recordings connect with the reference (or, if none
    does, most stations), and the recordings that see them."""
    if scene.generation != 2 or not pieces:
        return scene, pieces, None
    names, n = scene.names, len(scene.names)
    shared = np.zeros((n, n), int)
    for piece in pieces:
        both = np.ix_(piece.members, piece.members)
        shared[both] += piece.shared[both]
    members, network = networks.network_of(names, shared)
    connected = []
    for piece in pieces:
        if piece.members[0] in members:
            connected.append(replace(piece, members=[members.index(k) for k in piece.members]))
        else:
            why.append(f"{piece.title}: no station that is connected with {network.connected[0]}")
    why += network.apart.values()
    return scene.of(members), connected, network


def placed(pieces: Sequence[Piece]) -> tuple[dict[int, Pose], list[Pose]]:
    """Poses of the stations in the frame of the first, and of the frame of each piece in it."""

    def variance(piece: Piece) -> float:
        stations = range(1, len(piece.members))
        return float(np.mean([np.trace(piece.joint.pose_covariance(k)[:3, :3]) for k in stations]))

    left = sorted(range(len(pieces)), key=lambda k: variance(pieces[k]))
    poses, frames = {0: networks.HERE}, dict[int, Pose]()
    while left:
        k = next(k for k in left if poses.keys() & set(pieces[k].members))
        left.remove(k)
        piece_poses = dict(zip(pieces[k].members, fits.poses_of(pieces[k].joint), strict=True))
        anchor = next(member for member in piece_poses if member in poses)
        (R_0, t_0), (R, t) = poses[anchor], piece_poses[anchor]
        turn = R_0 @ R.T
        frames[k] = turn, t_0 - turn @ t
        for member, (R, t) in piece_poses.items():
            poses.setdefault(member, (turn @ R, turn @ t + frames[k][1]))
    return poses, [frames[k] for k in range(len(pieces))]
