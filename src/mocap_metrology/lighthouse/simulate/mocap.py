"""The reference of a twin: markers on both base stations, seen by a motion-capture system.

Each housing carries a printed mount with markers at known places in the housing's frame. The
system sees them in a frame of its own, with noise, and perhaps the mount is not quite straight.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import write_csv
from mocap_metrology.lighthouse.rotation import exp
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin

MOCAP = 5  # stream of random numbers
# Markers of a mount in the housing's frame, metres: around the front, above and behind it, no two
# distances alike, so that no other order of labels fits.
MOUNT_M = np.array(
    [
        [0.057, 0.067, 0.058],
        [0.035, -0.071, 0.053],
        [-0.057, 0.005, 0.085],
        [-0.065, -0.055, 0.024],
        [0.000, 0.084, -0.040],
    ]
)
PREFIXES = ("M", "S")  # of the labels: M1 ... on the master, S1 ... on the slave


@dataclass(frozen=True)
class Mount:
    """Markers on a housing, in its frame."""

    labels: tuple[str, ...]
    positions_m: np.ndarray  # (n, 3)


@dataclass(frozen=True)
class MountRecording:
    """What the motion-capture system delivers, and the mounts as they are known."""

    labels: tuple[str, ...]  # the master's, then the slave's
    positions_mm: np.ndarray  # (markers, 3, frames), in the system's own frame
    rate_hz: float
    mounts: tuple[Mount, ...]


def simulate_mounts(twin: LighthouseTwin, seed: int) -> MountRecording:
    """Markers of both stations over `mocap_frames`.

    The frame of the motion-capture system is drawn for each recording. A mount that is turned by
    `mount_error_deg`, about an axis of its own, is so in all recordings of the setup.
    """
    rng = np.random.default_rng([seed, MOCAP])
    R_world, t_world = exp(rng.normal(size=3) * 2), rng.uniform(-3, 3, 3)
    of_setup = np.random.default_rng([zlib.crc32(twin.setup.encode()), MOCAP])
    mounts, places = [], []
    for prefix, station in zip(PREFIXES, twin.stations, strict=False):
        mounts.append(Mount(tuple(f"{prefix}{i + 1}" for i in range(len(MOUNT_M))), MOUNT_M))
        axis = of_setup.normal(size=3)
        turned = exp(np.radians(twin.mount_error_deg) * axis / np.linalg.norm(axis))
        in_master = MOUNT_M @ (station.R @ turned).T + station.t
        places.append(in_master @ R_world.T + t_world)
    still = 1e3 * np.concatenate(places)[:, :, None]
    noise = twin.mocap_noise_mm * rng.standard_normal((*still.shape[:2], twin.mocap_frames))
    labels = tuple(label for mount in mounts for label in mount.labels)
    return MountRecording(labels, still + noise, twin.mocap_rate_hz, tuple(mounts))


def write_mounts(path: str | Path, mounts: Sequence[Mount]) -> None:
    """Write the known geometry of mounts as CSV: label, x_m, y_m, z_m in the housing's frame."""
    rows = [
        {"label": label, **dict(zip(("x_m", "y_m", "z_m"), place.tolist(), strict=True))}
        for mount in mounts
        for label, place in zip(mount.labels, mount.positions_m, strict=True)
    ]
    write_csv(path, rows)
