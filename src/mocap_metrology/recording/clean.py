"""First step of a recording: read or simulated, checked, and its coordinates cleaned."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import NotRequired, TypedDict

import numpy as np

from mocap_metrology import settings as of
from mocap_metrology.accuracy.clusters import SAME_MM
from mocap_metrology.accuracy.twin import BarTwin, simulate_bar
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal, Truncated, UnknownUnit
from mocap_metrology.common.hampel import (
    SHORT_WINDOW,
    hampel,
    own_step,
    share_of_rounded,
    white_level_kept,
)
from mocap_metrology.common.large import is_large
from mocap_metrology.common.parallel import MapFunction, in_turn
from mocap_metrology.common.types import Row
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.read import bodies_of, read_recording
from mocap_metrology.io.recording import Recording
from mocap_metrology.io.units import Unit
from mocap_metrology.noise.diagnosis.fills import filled_frames
from mocap_metrology.noise.motion.exchange import Exchange, put_right
from mocap_metrology.noise.motion.movement import Movement, most_moving, movements
from mocap_metrology.noise.series import coordinate_names, pair_numbers
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.take import TakeTwin, simulate_take
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.present.text.sentence import movement_words
from mocap_metrology.recording.progress import CALM, Progress
from mocap_metrology.recording.results import Results, Series, Table
from mocap_metrology.settings import Settings

log = logging.getLogger(__name__)
CHUNK = 65_536  # frames
SAMPLED = 4096  # frames in which two labels of one marker are seen to be
OF_READING = (  # what the metadata of tables have of `Recording` as it is
    *("labels", "frame_rate_hz", "resolution_mm", "resolution_kind", "unit_source"),
    *("n_gap_frames", "n_invalid", "notes"),
)
UNIT_ASSUMED = "the file names no unit, so its coordinates are assumed to be in mm"
OUTLIERS = (  # columns of outliers.csv
    *("series", "action", "n_sigma", "window_frames", "n_frames", "n_valid", "n_outliers", "share"),
    *("share_of_clean_gaussian_noise", "white_level_kept", "resolution_mm", "resolution_kind"),
)


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


def read(entry: Entry, second_opinion: bool, only_seen: bool = False) -> Recording:
    """The recording of these files; second_opinion: whether ezc3d reads a C3D file, too; only_seen:
    without markers that are seen in no frame. Raises `Refusal` for one that cannot be read with
    certainty, or whose checksum differs."""
    for path, expected in zip(entry.paths, entry.sha256, strict=False):
        if files.sha256(path) != expected:
            raise Refusal(
                f"{Path(path).name}: SHA-256 is {files.sha256(path)}; expected {expected}"
            )
    return read_recording(
        entry.paths,
        entry.markers,
        entry.frame_rate_hz,
        second_opinion,
        entry.accept_truncated,
        entry.unit,
        entry.column_names,
        only_seen,
    )


def examine(
    entry: Entry, recording: Recording, settings: Settings, over: MapFunction = in_turn
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
    duration = recording.position_mm.shape[2] / rate
    said = movement_words(moving, min(duration, horizon_s))
    return accepted(entry, recording, bool(moving), said), of_markers


def accepted(entry: Entry, recording: Recording, moving: bool, warnings: Sequence[str]) -> Check:
    """check.json of a recording that can be used."""
    assumed = [UNIT_ASSUMED] if "assumed" in recording.unit_source else []
    return {
        "ok": True,
        "why": "",
        "warnings": [*assumed, *warnings],
        "notes": list(recording.notes),
        "unit": recording.units,
        "unit_source": recording.unit_source,
        "moving": moving,
        "n_frames": recording.position_mm.shape[2],
        "bodies": bodies_of(entry.paths[0], entry.markers, entry.column_names),
    }


def refused(refusal: Refusal, to_accept: str, to_state: str = "") -> Check:
    """check.json of a recording that cannot be used; to_accept: how what is there of a file that is
    cut off is used all the same; to_state: how its unit is stated."""
    why = str(refusal)
    if isinstance(refusal, Truncated):
        why += f"; to use what is there, {to_accept}"
    elif isinstance(refusal, UnknownUnit) and to_state:
        why += f" ({to_state})"
    return {"ok": False, "why": why, "warnings": [], "notes": []}


@contextmanager
def simulated(twin: Twin | TakeTwin | BarTwin, seed: int, folder: Path) -> Iterator[Path]:
    """Path of the C3D file of a twin, which is removed in the end; truth.json in `folder`."""
    with files.temporary_folder(folder) as part:
        path, twin = Path(part) / "twin.c3d", replace(twin, seed=seed + twin.seed)
        if isinstance(twin, TakeTwin):
            simulation = simulate_take(twin)
        elif isinstance(twin, BarTwin):
            simulation = simulate_bar(twin)
        else:
            simulation = simulate(twin, folder=folder)
        n_frames, rate = simulation.position_mm.shape[2], simulation.frame_rate_hz
        log.info("%s: %d frames at %g Hz", twin.name, n_frames, rate)
        chunks = (
            np.moveaxis(simulation.position_mm[:, :, start : start + CHUNK], 2, 0).astype(
                np.float32
            )
            for start in range(0, n_frames, CHUNK)
        )
        write_c3d(path, twin.labels, rate, chunks, n_frames)
        files.write_json(folder / "truth.json", simulation.truth)
        del simulation, chunks
        yield path


def clean(
    entry: Entry,
    origin: files.Metadata,
    settings: Settings,
    folder: Path,
    *,
    tell: Callable[[Check, Recording], None] | None = None,
    progress: Progress = CALM,
) -> Results:
    """Read, examine and clean a recording: check.json, trajectories.parquet, clean.parquet,
    outliers.csv.

    origin: `recording`, `source`, `twin`, `pairs`, of a twin also `form`; a twin needs no check.
    tell: is called when the recording has been examined. Raises `Refusal` for a recording that
    cannot be used; then nothing has been written.
    """
    results, over, is_twin = Results(folder), progress.over, bool(origin["twin"])
    recording = read(entry, settings.second_opinion and not is_twin)
    if not is_twin:
        _refuse_one_marker(entry, recording)
    exchanged = put_right(recording.labels, recording.position_mm)
    for one in exchanged:
        log.warning("%s: labels exchanged in %d frames", " and ".join(one.labels), one.frames.sum())
    raw = trajectories(recording, origin | {"exchanged": exchanges(exchanged)}, over)
    if not is_twin:  # movement of what was measured, not of what was filled
        check, movements = examine(entry, recording, settings, over)
        files.write_json(folder / "check.json", check)
        if tell:
            tell(check, recording)
        for number, label in enumerate(recording.labels, start=1):
            results.movements |= {f"{axis}{number}": m for axis, m in movements[label].items()}
    progress.step("gap-filled frames and outliers")
    del recording  # its positions are those of the table, which may be read from the disk again
    if is_large(len(raw.columns), raw.frame.size):
        raw.write(folder / "trajectories.parquet")
        del raw
        report = write_cleaned(results.raw, settings.hampel, folder / "clean.parquet")
    else:
        results.raw = raw
        progress.later(raw.write, folder / "trajectories.parquet")
        results.clean, report = cleaned(raw, settings.hampel, over)
        progress.later(results.clean.write, folder / "clean.parquet")
    files.write_csv(folder / "outliers.csv", report, OUTLIERS)
    return results


def some_frames(position_mm: np.ndarray) -> np.ndarray:
    """Those of (..., n) that `are_one` needs."""
    return position_mm[..., :: max(position_mm.shape[-1] // SAMPLED, 1)].copy()


def are_one(first: np.ndarray, second: np.ndarray) -> bool:
    """Whether (3, n) in mm are of one marker, exported under two labels: nearer to each other than
    any two markers are."""
    apart = np.linalg.norm(first - second, axis=0)
    known = apart[np.isfinite(apart)]
    return bool(known.size) and float(np.median(known)) < SAME_MM


def _refuse_one_marker(entry: Entry, recording: Recording) -> None:
    """Of two labels of one marker there is no distance, and no second opinion on its noise."""
    places = zip(recording.labels, some_frames(recording.position_mm), strict=True)
    for (a, first), (b, second) in combinations(places, 2):
        if are_one(first, second):
            raise Refusal(
                f"{Path(entry.paths[0]).name}: {a} and {b} are within {SAME_MM:g} mm of each other:"
                " one marker under two labels; name one of them, and another marker"
            )


def exchanges(pairs: Sequence[Exchange]) -> list[Row]:
    """For the metadata: labels, frames, first and last of them."""
    return [
        {
            "labels": list(one.labels),
            "n_frames": int(one.frames.sum()),
            "first": int(np.argmax(one.frames)),
            "last": int(one.frames.size - 1 - np.argmax(one.frames[::-1])),
        }
        for one in pairs
    ]


def refused_in_sheet(refusal: Refusal) -> Check:
    """check.json of a recording of a sheet that cannot be used."""
    columns = 'write "accept" in column truncated of the sheet', "column unit of the sheet"
    return refused(refusal, *columns)


def refuse(refusal: Refusal, entry: Entry, origin: files.Metadata, folder: Path) -> None:
    """check.json of a recording that cannot be used, with the reason; tables without rows."""
    check = refused_in_sheet(refusal)
    files.write_json(folder / "check.json", check)
    names = [f"{name}_mm" for name in coordinate_names(len(entry.markers))]
    columns = {"frame": np.empty(0, np.int32)} | dict.fromkeys(names, np.empty(0, np.float32))
    table = Table(columns, {**origin, files.REFUSED: check["why"]})
    table.write(folder / "trajectories.parquet")
    table.write(folder / "clean.parquet")
    files.write_csv(folder / "outliers.csv", [], OUTLIERS)


def trajectories(recording: Recording, named: files.Metadata, over: MapFunction = in_turn) -> Table:
    """Chosen markers in mm, one row a frame, gaps as NaN; what an interpolation filled is a gap.

    named: `recording`, `source` (`twin` or `measured`), `twin` (its name, or None), `pairs` of
    labels (default: the first two); of a twin also `form`: frames of a camera are points, its
    exposure is far shorter than a frame. Changes the positions of `recording` in place.
    """
    filled = filled_frames(recording.position_mm, recording.resolution_mm, over)
    for label, xyz, mask in zip(recording.labels, recording.position_mm, filled, strict=True):
        xyz[:, mask] = np.nan  # no measurement
        if mask.any():
            log.warning("%s: %d frames are gap-filled and left out", label, mask.sum())
    coordinates = recording.position_mm.reshape(-1, recording.position_mm.shape[2])
    names = [f"{name}_mm" for name in coordinate_names(len(recording.labels))]
    columns = {"frame": np.arange(coordinates.shape[1], dtype=np.int32)}
    origin = named | {name: getattr(recording, name) for name in OF_READING}
    origin |= {
        "unit": "mm",
        "pairs": pair_numbers(recording.labels, named.get("pairs")),
        "file_units": recording.units,
        "file_encoding": recording.encoding,
        "n_filled_frames": dict(zip(recording.labels, filled.sum(axis=1).tolist(), strict=True)),
        "segments": [asdict(segment) for segment in recording.segments],
        "versions": files.versions("numpy", "pyarrow"),
    }
    few_values = tuple(names) if recording.resolution_kind == "int16" else ()
    return Table(columns | dict(zip(names, coordinates, strict=True)), origin, few_values)


def cleaned(
    raw: Table, settings: of.Hampel, over: MapFunction = in_turn
) -> tuple[Table, list[Row]]:
    """Every series, distances included, through the Hampel filter: clean.parquet, and rows of
    outliers.csv."""
    columns, report = {"frame": raw.frame}, []
    for name, values, row in _filtered(raw, settings, over):
        columns[f"{name}_mm"] = values
        report.append(row)
    return Table(columns, _clean_origin(raw, settings)), report


def write_cleaned(raw: Table, settings: of.Hampel, path: str | Path) -> list[Row]:
    """Clean like `cleaned`, written one series at a time to `path`; returns the report."""
    report = []

    def columns() -> Iterator[Series]:
        yield "frame", raw.frame
        for name, values, row in _filtered(raw, settings, in_turn):
            report.append(row)
            yield f"{name}_mm", values

    files.write_series(path, columns(), _clean_origin(raw, settings))
    return report


def _clean_origin(raw: Table, settings: of.Hampel) -> files.Metadata:
    record = {"hampel": settings.model_dump(), "window_frames": 2 * _half_window(raw, settings) + 1}
    return raw.origin | record | {"versions": files.versions("numpy", "numba", "pyarrow")}


def _half_window(raw: Table, settings: of.Hampel) -> int:
    return max(round(settings.half_window_s * raw.origin["frame_rate_hz"]), 1)


def _filtered(
    raw: Table, settings: of.Hampel, over: MapFunction
) -> Iterable[tuple[str, np.ndarray, Row]]:
    """Name without unit and cleaned values of every series, coordinates in their own type, and the
    row of outliers.csv."""
    origin, half_window = raw.origin, _half_window(raw, settings)
    share_of_noise, left = white_level_kept(settings.n_sigma, half_window, settings.action)
    if half_window < SHORT_WINDOW and settings.action != "off":
        log.warning(
            "the window holds %d frames, so the filter replaces many good samples too; "
            "raise hampel.half_window_s to %g or more",
            2 * half_window + 1,
            SHORT_WINDOW / origin["frame_rate_hz"],
        )
    coordinates = raw.coordinates
    kind = next(iter(coordinates.values())).dtype

    def filtered(one: Series) -> tuple[str, np.ndarray, Row]:
        name, values = one
        step = max(origin["resolution_mm"], own_step(values))
        result = hampel(values, half_window, settings.n_sigma, settings.action, step)
        log.info("%s: %.3f %% outliers", name, 100 * result.share)
        rounded = share_of_rounded(values, half_window, settings.n_sigma, step)
        row: Row = {
            "series": name,
            "action": settings.action,
            "n_sigma": settings.n_sigma,
            "window_frames": 2 * half_window + 1,
            "n_frames": values.size,
            "n_valid": result.n_valid,
            "n_outliers": int(result.outlier.sum()),
            "share": result.share,
            "share_of_clean_gaussian_noise": max(share_of_noise, rounded),
            "white_level_kept": left,
            "resolution_mm": origin["resolution_mm"],
            "resolution_kind": origin["resolution_kind"],
        }
        return name, result.values.astype(kind if name in coordinates else float), row

    return over(filtered, raw.with_distances())
