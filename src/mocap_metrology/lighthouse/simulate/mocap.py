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
class MountRecording:
    """What the motion-capture system delivers."""

    labels: tuple[str, ...]  # the master's, then the slave's
    positions_mm: np.ndarray  # (markers, 3, frames), in the system's own frame
    rate_hz: float


def simulate_mounts(twin: LighthouseTwin, seed: int) -> MountRecording:
    """Markers of both stations over `mocap_frames`.

    The frame of the motion-capture system is drawn for each recording. A mount that is turned by
    `mount_error_deg`, about an axis of its own, is so in all recordings of the setup.
    """
    rng = np.random.default_rng([seed, MOCAP])
    R_world, t_world = exp(rng.normal(size=3) * 2), rng.uniform(-3, 3, 3)
    of_setup = np.random.default_rng([zlib.crc32(twin.setup.encode()), MOCAP])
    labels, places = list[str](), []
    for prefix, station in zip(PREFIXES, twin.stations, strict=False):
        labels += [f"{prefix}{i + 1}" for i in range(len(MOUNT_M))]
        axis = of_setup.normal(size=3)
        turned = exp(np.radians(twin.mount_error_deg) * axis / np.linalg.norm(axis))
        in_master = MOUNT_M @ (station.R @ turned).T + station.t
        places.append(in_master @ R_world.T + t_world)
    still = 1e3 * np.concatenate(places)[:, :, None]
    noise = twin.mocap_noise_mm * rng.standard_normal((*still.shape[:2], twin.mocap_frames))
    return MountRecording(tuple(labels), still + noise, twin.mocap_rate_hz)


def write_mounts(path: str | Path, labels: Sequence[str]) -> None:
    """Write the known geometry of mounts as CSV: label, x_m, y_m, z_m in the housing's frame."""
    places = np.tile(MOUNT_M, (len(labels) // len(MOUNT_M), 1)).tolist()
    rows = zip(labels, *zip(*places, strict=True), strict=True)
    write_csv(path, [dict(zip(("label", "x_m", "y_m", "z_m"), row, strict=True)) for row in rows])
