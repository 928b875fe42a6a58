"""Whether a recording can be used, and what to beware of: check.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NotRequired, TypedDict

from mocap_metrology.common.errors import Refusal, Truncated, UnknownUnit
from mocap_metrology.common.files import sha256
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.io.read import bodies_of, labels_of, read_recording
from mocap_metrology.io.recording import Recording
from mocap_metrology.io.units import Unit
from mocap_metrology.noise.motion.movement import Movement, most_moving, movements
from mocap_metrology.present.text.movement import movement_words
from mocap_metrology.settings import Settings

UNIT_ASSUMED = "the file names no unit, so its coordinates are assumed to be in mm"


Movements = Mapping[str, Mapping[str, Movement]]  # label -> axis -> movement


class Check(TypedDict):
    """Contents of check.json; `bodies`: chosen labels that have an orientation."""

    ok: bool
    why: str
    warnings: list[str]
    notes: list[str]
    unit: NotRequired[str]
    unit_source: NotRequired[str]
    moving: NotRequired[bool]
    n_frames: NotRequired[int]
    bodies: NotRequired[tuple[str, ...]]


@dataclass(frozen=True)
class Entry:
    """What a user states of a recording: files in order, labels of markers, and what the files
    lack, with names of their columns; sha256: of each file, where it is known."""

    paths: Sequence[str]
    markers: Sequence[str]
    frame_rate_hz: float | None = None
    accept_truncated: bool = False
    unit: Unit | None = None
    sha256: Sequence[str] = ()
    column_names: str | None = None


def read(entry: Entry, second_opinion: bool) -> Recording:
    """The recording of these files; second_opinion: whether ezc3d reads a C3D file, too. Raises
    `Refusal` for one that cannot be read with certainty, or whose checksum differs."""
    for path, expected in zip(entry.paths, entry.sha256, strict=False):
        if sha256(path) != expected:
            raise Refusal(f"{Path(path).name}: SHA-256 is {sha256(path)}; expected {expected}")
    return read_recording(
        entry.paths,
        entry.markers or labels_of(entry.paths[0], entry.accept_truncated, entry.column_names),
        entry.frame_rate_hz,
        second_opinion,
        entry.accept_truncated,
        entry.unit,
        entry.column_names,
    )


def examine(
    entry: Entry, recording: Recording, settings: Settings, over: Over = in_turn
) -> tuple[Check, Movements]:
    """Contents of check.json of a recording that can be used, and how its markers move, by label
    and axis; over: how coordinates are worked on."""
    horizon_s = settings.verdict.horizon_s
    rate = recording.frame_rate_hz
    of_markers = movements(
        dict(zip(recording.labels, recording.position_mm, strict=True)),
        rate,
        settings.still.range_mm,
        horizon_s,
        recording.resolution_mm,
        over,
    )
    moving = most_moving(of_markers)
    n_frames = recording.position_mm.shape[2]
    duration = n_frames / rate
    assumed = [UNIT_ASSUMED] if "assumed" in recording.unit_source else []
    check: Check = {
        "ok": True,
        "why": "",
        "warnings": [*assumed, *movement_words(moving, min(duration, horizon_s))],
        "notes": list(recording.notes),
        "unit": recording.units,
        "unit_source": recording.unit_source,
        "moving": bool(moving),
        "n_frames": n_frames,
        "bodies": bodies_of(entry.paths[0], entry.markers, entry.column_names),
    }
    return check, of_markers


def refused(refusal: Refusal, to_accept: str, to_state: str = "") -> Check:
    """check.json of a recording that cannot be used; to_accept: how what is there of a file that is
    cut off is used all the same; to_state: how its unit is stated."""
    why = str(refusal)
    if isinstance(refusal, Truncated):
        why += f"; to use what is there, {to_accept}"
    elif isinstance(refusal, UnknownUnit) and to_state:
        why += f" ({to_state})"
    return {
        "ok": False,
        "why": why,
        "warnings": [],
        "notes": [],
    }
