"""Recordings of a setup one by one: what each sees, its estimate, and what connects them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.calibrate import network as networks
from mocap_metrology.lighthouse.calibrate.batch import joint, usable_hits
from mocap_metrology.lighthouse.calibrate.fits import poses_of
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene
from mocap_metrology.lighthouse.calibrate.variants import AUTO, NAMES
from mocap_metrology.lighthouse.records import Measurements


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
    shared, parts, seen = np.ones((n, n), int), [list(range(n))], None
    if scene.generation == 2:
        seen = networks.look(scene)
        shared = networks.shared_moments(seen)
        parts = [island for island in networks.islands(shared) if len(island) > 1]
        if not parts:
            why.append(
                f"{name}: no two stations see four diodes at {networks.FEWEST_MOMENTS}"
                " common moments"
            )
    for island in parts:
        of = scene.of(island) if seen else scene
        stations = ", ".join(scene.names[k] for k in island)
        title = name if len(parts) == 1 else f"{name} (stations {stations})"
        try:
            middle = still and [still[k] for k in island]
            near = networks.start(of, [seen[k] for k in island]) if seen and not middle else None
            solution, note = joint(of, middle, near)
        except Refusal as refusal:
            why.append(f"{title}: {refusal}")
            continue
        why += [f"{title}: {note}"] if note else []
        usable = usable_hits(of, solution)
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
        piece_poses = dict(zip(pieces[k].members, poses_of(pieces[k].joint), strict=True))
        anchor = next(member for member in piece_poses if member in poses)
        (R_0, t_0), (R, t) = poses[anchor], piece_poses[anchor]
        turn = R_0 @ R.T
        frames[k] = turn, t_0 - turn @ t
        for member, (R, t) in piece_poses.items():
            poses.setdefault(member, (turn @ R, turn @ t + frames[k][1]))
    return poses, [frames[k] for k in range(len(pieces))]
