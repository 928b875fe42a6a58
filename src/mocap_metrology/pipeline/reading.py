"""The files of a recording -> its coordinates as they are analysed: trajectories.parquet."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from mocap_metrology.common.files import Metadata, versions
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.io.recording import Recording
from mocap_metrology.noise.diagnosis.export import filled_frames
from mocap_metrology.noise.series import coordinate_names, pair_numbers
from mocap_metrology.pipeline.tables import Table

log = logging.getLogger(__name__)


def trajectories(
    recording: Recording,
    named: Metadata,
    pairs: Sequence[Sequence[str]] | None = None,
    over: Over = in_turn,
) -> Table:
    """Chosen markers in mm, one row a frame, gaps as NaN; what an interpolation filled is a gap.

    named: `recording`, `source` (`twin` or `measured`), `twin` (its name, or None); of a twin also
    `form`: frames of a camera are points, its exposure is far shorter than a frame. Changes the
    positions of `recording` in place.
    """
    filled = filled_frames(recording.position_mm, recording.resolution_mm, over)
    for label, own, mask in zip(recording.labels, recording.position_mm, filled, strict=True):
        own[:, mask] = np.nan  # no measurement
        if mask.any():
            log.warning("%s: %d frames are gap-filled and left out", label, mask.sum())
    coordinates = recording.position_mm.reshape(-1, recording.position_mm.shape[2])
    names = [f"{name}_mm" for name in coordinate_names(len(recording.labels))]
    columns = {"frame": np.arange(coordinates.shape[1], dtype=np.int32)}
    origin = named | {
        "unit": "mm",
        "labels": recording.labels,
        "pairs": pair_numbers(recording.labels, pairs),
        "frame_rate_hz": recording.frame_rate_hz,
        "resolution_mm": recording.resolution_mm,
        "resolution_kind": recording.resolution_kind,
        "file_units": recording.units,
        "unit_source": recording.unit_source,
        "file_encoding": recording.encoding,
        "n_gap_frames": recording.n_gap_frames,
        "n_invalid": recording.n_invalid,
        "n_filled_frames": dict(zip(recording.labels, filled.sum(axis=1).tolist(), strict=True)),
        "segments": [asdict(segment) for segment in recording.segments],
        "notes": recording.notes,
        "versions": versions("numpy", "pyarrow"),
    }
    few_values = tuple(names) if recording.resolution_kind == "int16" else ()
    return Table(columns | dict(zip(names, coordinates, strict=True)), origin, few_values)
