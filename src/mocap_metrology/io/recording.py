"""A recording of one or several files: what the files must agree in, their order, positions in mm.

A reader of any format reads the `Header` of each file, checks it, and hands the files as
`SegmentReader`s to `read_take`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal, UnknownUnit, Unseen
from mocap_metrology.common.files import sha256
from mocap_metrology.io.header import FASTEST_HZ, SLOWEST_HZ
from mocap_metrology.io.labels import find_points
from mocap_metrology.io.resolution import Resolution, coarsest
from mocap_metrology.io.units import LengthUnit, Unit

GIVE_RATE = "give it in column frame_rate_hz"
LONGEST_GAP = 10  # times all frames measured; beyond it a frame number is not believed
NEAR_MM = 20.0  # beyond all that a marker was at

Array = npt.NDArray[np.floating]
Counts = dict[str, int]  # invalid frames by reason


@dataclass(frozen=True)
class Segment:
    """One file of a recording; `path` is its name without the folder.

    `second_opinion`: `agrees`, `none` (ezc3d could not tell; a note says why), `not asked (...)`.
    """

    path: str
    sha256: str
    first_frame: int
    n_frames: int
    frame_count_source: str
    gap_before: int
    second_opinion: str


@dataclass(frozen=True)
class Recording:
    """Positions of chosen markers, from files of any format.

    `labels` as they were asked for; `position_mm` (n_markers, 3, n_frames), C-contiguous, NaN where
    invalid or where frames are missing; float32 where the file holds float32 in mm, else float64.
    `units`, `encoding`: of the files; `unit_source`: `file`, `assumed` (mm, where a file names
    none), `given` by the user. `resolution_mm`: the smallest step of the files, the largest
    over segments; `resolution_kind`: `int16`, `float32`, `rounded`, or `text` where the decimals
    limit it. `n_invalid`: frames by reason for each marker, missing frames not counted;
    `n_gap_frames`: missing frames, between segments and (by frame number or time) within them.
    """

    labels: tuple[str, ...]
    position_mm: Array
    frame_rate_hz: float
    units: str
    unit_source: str
    resolution_mm: float
    resolution_kind: str
    encoding: str
    n_invalid: tuple[Counts, ...]
    n_gap_frames: int
    segments: tuple[Segment, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Header:
    """The header of a file of any format; `frame_rate_hz` 0 where it has none; `notes`: what to say
    of the file."""

    path: Path
    labels: tuple[str, ...]
    unit: LengthUnit
    frame_rate_hz: float
    encoding: str
    notes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the file without its folder."""
        return self.path.name

    @property
    def bodies(self) -> frozenset[int]:
        """Places (from 0) of labels that are bodies, not markers."""
        return frozenset()


@dataclass(frozen=True)
class Choice:
    """The markers that are read: `labels` as asked for, `points` their places in the files; and
    how, as `io.read.read_recording` has it."""

    labels: tuple[str, ...]
    points: tuple[int, ...]
    frame_rate_hz: float
    second_opinion: bool
    accept_truncated: bool


@dataclass(frozen=True)
class Contents:
    """What the positions of one file showed when they were read; `n_invalid` for each marker."""

    n_invalid: Sequence[Counts]
    resolution: Resolution
    second_opinion: str
    notes: Sequence[str]


@dataclass(frozen=True)
class SegmentReader:
    """One file of a take, checked and not yet read into its place.

    `first_frame` as the file has it, `number` as it counts in the take. `n_frames` from its first
    to its last, `n_measured` of them in the file. `read` fills an array (n_markers, 3, n_frames)
    with positions in mm, NaN where invalid.
    """

    file: Header
    first_frame: int
    number: int
    n_frames: int
    n_measured: int
    frame_count_source: str
    dtype: np.dtype[np.floating]
    read: Callable[[Array], Contents]

    @property
    def numbers(self) -> range:
        """Numbers of its frames."""
        return range(self.number, self.number + self.n_frames)


def read_take(
    headers: Sequence[Header],
    readers: Callable[[Sequence[Any], Choice], list[SegmentReader]],
    markers: Sequence[str],
    frame_rate_hz: float | None,
    unit: Unit | None,
    second_opinion: bool,
    accept_truncated: bool,
) -> Recording:
    """Positions of `markers` in the files of one take; `readers`: of all files, whose units are
    stated, in the order given. Refuses files that cannot be of one take."""
    files = [replace(file, unit=file.unit.stated(unit, file.name)) for file in headers]
    check_alike(files)
    points = find_points(files[0].labels, markers, files[0].name)
    rate, labels = frame_rate(files[0], frame_rate_hz), tuple(marker.strip() for marker in markers)
    choice = Choice(labels, tuple(points), rate, second_opinion, accept_truncated)
    return assemble(readers(files, choice), choice)


def check_alike(files: Sequence[Header]) -> None:
    """Refuse files that cannot be of one take."""
    first = files[0]
    for i, other in enumerate(files[1:], start=1):
        if any(other.path.resolve() == s.path.resolve() for s in files[:i]):
            raise Refusal(f"{other.name}: is given twice")
        if other.labels != first.labels:
            only = sorted(set(other.labels) ^ set(first.labels))
            what = f"{only[0]!r} is in one of them only" if only else "in another order"
            raise Refusal(f"{other.name}: its labels are not those of {first.name}: {what}")
        if other.unit.mm != first.unit.mm:
            raise UnknownUnit(
                f"{other.name}: its unit is {other.unit.name}, that of {first.name}"
                f" {first.unit.name}: segments of one take have one unit"
            )
        rates = first.frame_rate_hz, other.frame_rate_hz
        if not math.isclose(*rates, rel_tol=1e-6):
            raise Refusal(
                f"{other.name}: its frame rate is {rates[1]:g} Hz, that of {first.name}"
                f" {rates[0]:g} Hz"
            )


def frame_rate(first: Header, stated_hz: float | None) -> float:
    """Frame rate in Hz: `stated_hz`, which may differ from the file's by 0.1 % where that is one of
    a tracking system, else the file's."""
    if stated_hz is not None and not (math.isfinite(stated_hz) and stated_hz > 0):
        raise Refusal(f"{first.name}: frame_rate_hz is {stated_hz}, expected a positive number")
    known, rate = first.frame_rate_hz, stated_hz
    if rate is None:
        if known == 0:
            raise Refusal(f"{first.name}: has no frame rate; {GIVE_RATE}")
        rate = known
    if not SLOWEST_HZ <= rate <= FASTEST_HZ:
        most = f"at most {FASTEST_HZ:g} Hz" if rate > 1 else f"at least {SLOWEST_HZ:g} Hz"
        what = "its frame rate, by the file or its times," if stated_hz is None else "frame_rate_hz"
        hint = f"; {GIVE_RATE}" if stated_hz is None else ""
        raise Refusal(f"{first.name}: {what} is {rate:g} Hz; expected {most}{hint}")
    if SLOWEST_HZ <= known <= FASTEST_HZ and not math.isclose(rate, known, rel_tol=1e-3):
        raise Refusal(
            f"{first.name}: its frame rate is {known:g} Hz, {rate:g} Hz is stated; they may differ"
            " by 0.1 %"
        )
    return float(rate)


def _in_order(given: Sequence[SegmentReader]) -> tuple[list[SegmentReader], list[int], list[str]]:
    """Segments by their numbers, frames missing before each, and remarks.

    If all start at the same number, no gap is assumed. Refuses segments that overlap, and gaps far
    longer than what was measured.
    """
    ordered = sorted(given, key=lambda one: one.number)
    first, last = ordered[0].number, ordered[-1].number
    if first == last:
        note = f"all segments start at frame {first}: joined in the given order, without gaps"
        return ordered, [0] * len(ordered), [note] * (len(ordered) > 1)
    gaps = [0]
    for one, other in pairwise(ordered):
        gaps.append(other.number - one.numbers.stop)
        if gaps[-1] < 0:
            raise overlap(one.file.name, one.numbers, other.file.name, other.numbers)
    if sum(gaps) > LONGEST_GAP * sum(one.n_frames for one in ordered):
        raise Refusal(
            f"{ordered[0].file.name}: the segments' frame numbers skip {sum(gaps)} frames, "
            f"more than {LONGEST_GAP} times those measured: do they belong to one take?"
        )
    names = [one.file.name for one in ordered]
    moved = names != [one.file.name for one in given]
    notes = [f"segments were given out of order; joined as {', '.join(names)}"] * moved
    return ordered, gaps, notes


def overlap(a: str, frames_a: range, b: str, frames_b: range) -> Refusal:
    """The refusal of file `b`, which starts before the end of `a`."""
    return Refusal(
        f"{b}: segments overlap or are out of order: frames {frames_b[0]} to {frames_b[-1]}, but"
        f" {a} has frames {frames_a[0]} to {frames_a[-1]}"
    )


def assemble(given: Sequence[SegmentReader], choice: Choice) -> Recording:
    """Read all segments, each into its place in the take."""
    readers, gaps, notes = _in_order(given)
    file = given[0].file.name
    total = sum(reader.n_frames for reader in readers) + sum(gaps)
    if total < 2:
        raise Refusal(f"{file}: has 1 frame, expected at least 2 frames")
    dtype = np.result_type(*(reader.dtype for reader in readers))
    position = np.empty((len(choice.points), 3, total), dtype)
    contents, end = [], 0
    for reader, gap in zip(readers, gaps, strict=True):
        start, end = end + gap, end + gap + reader.n_frames
        position[:, :, start - gap : start] = np.nan
        content = reader.read(position[:, :, start:end])
        contents.append(content)
        reader.file.unit.check_size(position[:, :, start:end], reader.file.name)
        said = (*reader.file.notes, reader.file.unit.remark, *content.notes)
        notes += [f"{reader.file.name}: {text}" for text in said if text]
    n_invalid = _sum_counts([content.n_invalid for content in contents])
    n_measured = sum(reader.n_measured for reader in readers)
    check_seen(choice.labels, n_measured, n_invalid, file)
    resolution = coarsest([content.resolution for content in contents])
    return Recording(
        labels=choice.labels,
        position_mm=position,
        frame_rate_hz=choice.frame_rate_hz,
        units="; ".join(dict.fromkeys(reader.file.unit.name for reader in readers)),
        unit_source="; ".join(dict.fromkeys(reader.file.unit.source for reader in readers)),
        resolution_mm=resolution.step_mm,
        resolution_kind=resolution.kind,
        encoding="; ".join(dict.fromkeys(reader.file.encoding for reader in readers)),
        n_invalid=n_invalid,
        n_gap_frames=total - n_measured,
        segments=tuple(
            Segment(
                path=reader.file.name,
                sha256=sha256(reader.file.path),
                first_frame=reader.first_frame,
                n_frames=reader.n_frames,
                frame_count_source=reader.frame_count_source,
                gap_before=gap,
                second_opinion=content.second_opinion,
            )
            for reader, gap, content in zip(readers, gaps, contents, strict=True)
        ),
        notes=tuple(notes),
    )


def exclude_sentinels(
    position: Array, labels: Sequence[str], counts: Sequence[Counts], mm_per_unit: float
) -> list[str]:
    """Make frames of positions (n_markers, 3, n_frames) NaN, count them and return notes on them,
    where all three coordinates are one number and the marker was nowhere near it (`NEAR_MM`), or
    none of the markers where it has no other: so programs write a marker that they did not see, as
    0, -1 or -9999."""
    alike = (position[:, 0] == position[:, 1]) & (position[:, 1] == position[:, 2])
    if not alike.any():
        return []
    other, notes = ~alike[:, None], []
    low = np.nanmin(position, axis=2, where=other, initial=np.inf)
    high = np.nanmax(position, axis=2, where=other, initial=-np.inf)
    unseen = (low > high).any(axis=1)
    if unseen.all():
        return []
    low[unseen], high[unseen] = low.min(axis=0), high.max(axis=0)
    low, high = low[..., None] - NEAR_MM, high[..., None] + NEAR_MM
    for k, (label, xyz, count) in enumerate(zip(labels, position, counts, strict=True)):
        far = alike[k] & ((xyz < low[k]) | (xyz > high[k])).any(axis=0)
        zero = alike[k] & ~far & (xyz[0] == 0)
        for frames, said in ((far, "taken as missing"), (zero, "treated as measured")):
            if n := int(np.count_nonzero(frames)):
                values = np.unique(xyz[0, frames] / mm_per_unit + 0.0)[::-1]
                written = " or ".join(f"{value:.7g}" for value in values[:3])
                rest = " or another number" * (len(values) > 3)
                notes.append(f"{label}: x = y = z = {written}{rest} in {n} frames, {said}")
        if far.any():
            count["sentinel"] = int(np.count_nonzero(far))
            xyz[:, far] = np.nan
    return notes


def _sum_counts(segments: Sequence[Sequence[Counts]]) -> tuple[Counts, ...]:
    """Invalid frames by reason for each marker, over all segments."""
    return tuple(
        {
            reason: sum(counts.get(reason, 0) for counts in of_marker)
            for reason in {reason: None for counts in of_marker for reason in counts}
        }
        for of_marker in zip(*segments, strict=True)
    )


def check_seen(
    labels: Sequence[str], n_frames: int, counts: Sequence[Mapping[str, int]], file: str
) -> None:
    """Refuse markers that are valid in no frame; `counts` of invalid frames by reason."""
    unseen = {
        label: [f"{n} {reason.replace('_', ' ')}" for reason, n in by_reason.items() if n]
        for label, by_reason in zip(labels, counts, strict=True)
        if sum(by_reason.values()) == n_frames
    }
    for label, reasons in unseen.items():
        why = f"marker {label!r} is valid in no frame of {n_frames} ({', '.join(reasons)})"
        raise Unseen(f"{file}: {why}", list(unseen))
