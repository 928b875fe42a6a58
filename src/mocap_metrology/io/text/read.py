"""Read a take from text files: its positions, and the frame in which each row was measured."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.recording import (
    LONGEST_GAP,
    Array,
    Choice,
    Contents,
    SegmentReader,
    exclude_sentinels,
)
from mocap_metrology.io.resolution import SAMPLE, decimals, text_resolution
from mocap_metrology.io.text.layout import NULLS, Layout, cells_of
from mocap_metrology.io.text.rows import Floats, Rows, line_of, read_rows

NO_OPINION = "not asked (text)"
RATE_TOLERANCE = 1e-3

Whole = npt.NDArray[np.int64]


def readers(files: Sequence[Layout], choice: Choice) -> list[SegmentReader]:
    """How each file is read, whose rows are read at once. `n_invalid` by `empty`, `zero`,
    `not_finite`; frames whose numbers are missing count as `n_gap_frames`."""
    every = []
    for layout in files:
        rows = read_rows(layout, choice.points, choice.accept_truncated)
        first, span, index = find_frames(layout, rows, choice)
        every.append(
            SegmentReader(
                file=layout,
                first_frame=first,
                number=first,
                n_frames=span,
                n_measured=rows.n,
                frame_count_source=layout.declared[0] if layout.declared else "rows",
                dtype=np.dtype(np.float64),
                read=partial(_read_segment, layout, choice, rows, index),
            )
        )
    return every


def _read_segment(
    layout: Layout, choice: Choice, rows: Rows, index: Whole | None, out: Array
) -> Contents:
    """Copy the rows of one file to their frames in `out`."""
    sample = rows.blocks[0][:, :SAMPLE]
    _fill(out, rows, index, layout.unit.mm)
    n = None if layout.unit.name else 1  # of numbers without a unit the first three are a position
    said = exclude_sentinels(out[:n], choice.labels[:n], rows.counts[:n], layout.unit.mm)
    table = [cells_of(line, layout.delimiter) for line in rows.head[:SAMPLE]]
    columns = [c for point in choice.points for c in layout.columns[point]]
    written = [{row[c] for row in table if c < len(row)} - set(NULLS) for c in columns]
    resolution = text_resolution(out, layout.unit.mm, written, sample)
    notes = [*rows.notes, *_notes(layout, choice, rows), *said]
    return Contents(rows.counts, resolution, NO_OPINION, notes)


def _fill(out: Array, rows: Rows, index: Whole | None, mm_per_unit: float) -> None:
    """Blocks are let go as they are copied, so that memory holds the recording once."""
    if index is not None:
        out[:] = np.nan
    start = 0
    while rows.blocks:
        block = rows.blocks.pop(0).reshape(len(out), 3, -1)
        stop = start + block.shape[2]
        where = slice(start, stop) if index is None else index[start:stop]
        out[:, :, where] = block * mm_per_unit
        start = stop


def _notes(layout: Layout, choice: Choice, rows: Rows) -> list[str]:
    """What to say of the chosen labels."""
    notes = []
    for label, point, counts in zip(choice.labels, choice.points, rows.counts, strict=True):
        if point in layout.remarks:
            notes.append(f"{label}: {layout.remarks[point]}")
        if counts["zero"] and layout.zero_note:
            notes.append(f"{label}: x = y = z = 0 in {counts['zero']} frames, {layout.zero_note}")
    return notes


def find_frames(layout: Layout, rows: Rows, choice: Choice) -> tuple[int, int, Whole | None]:
    """Number of the first frame of a file, how many there are to its last, and the index (n,) of
    each row from 0, None where no frame is missing; with remarks in the notes of the rows.

    Frame numbers with holes, or times where there are no numbers, say which frames are missing.
    Refuses numbers that do not grow, times that do not fit, and other counts than declared.
    """
    notes = rows.notes
    steps, first = np.ones(rows.n - 1, np.int64), 1
    if rows.frame is not None:
        steps, first = _by_number(layout, rows.frame, notes)
    if rows.time is not None:
        steps = _by_time(layout, rows, rows.time, steps, choice.frame_rate_hz, notes)
    span = int(steps.sum()) + 1
    missing = span - rows.n
    if missing > LONGEST_GAP * rows.n:
        raise Refusal(
            f"{layout.name}: frame numbers or times skip {missing} frames, more than "
            f"{LONGEST_GAP} times the {rows.n} there are"
        )
    if missing:
        holes = int((steps > 1).sum())
        row = int(np.argmax(steps > 1))
        notes.append(
            f"{missing} frames are missing in {holes} places, the first before line "
            f"{line_of(layout, row + 1)}: treated as gaps"
        )
    notes += _check_declared(layout, rows, span, choice.accept_truncated)
    index = np.concatenate([[0], np.cumsum(steps)]) if missing else None
    return first, span, index


def _by_number(layout: Layout, frame: Floats, notes: list[str]) -> tuple[Whole, int]:
    """Steps between frame numbers, and the first number."""
    wrong = ~np.isfinite(frame) | (frame != np.round(frame)) | (np.abs(frame) > 2**53)
    if wrong.any():
        row = int(np.argmax(wrong))
        said = "there is none" if np.isnan(frame[row]) else f"{frame[row]:g}"
        where = f"{layout.name}: line {line_of(layout, row)}"
        raise Refusal(f"{where}: expected a whole frame number, {said}")
    steps = np.diff(frame).astype(np.int64)
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0))
        raise Refusal(
            f"{layout.name}: line {line_of(layout, row + 1)}: frame {frame[row + 1]:.0f} follows"
            f" frame {frame[row]:.0f}, expected a larger number"
        )
    if len(steps) and steps[0] > 1 and (steps == steps[0]).all():
        if layout.time_column is None:
            raise Refusal(
                f"{layout.name}: every frame number is {steps[0]} more than the one before, and "
                "no time column shows whether the frame rate is that of the rows"
            )
        notes.append(
            f"frame numbers increase by {steps[0]}: rows are treated as consecutive frames"
        )
        steps = np.ones_like(steps)
    return steps, int(frame[0])


def _by_time(
    layout: Layout, rows: Rows, time: Floats, steps: Whole, rate: float, notes: list[str]
) -> Whole:
    """Times against `steps` at `rate`; without frame numbers, steps by time."""
    there = np.isfinite(time)
    if len(steps) == 0 or not there.any():
        return steps
    if not there.all():
        line = line_of(layout, int(np.argmin(there)))
        raise Refusal(f"{layout.name}: line {line} has no time, as other lines have")
    duration = float(time[-1] - time[0])
    if not duration > 0:
        raise Refusal(
            f"{layout.name}: its times do not increase: {time[0]:.10g} s in line "
            f"{line_of(layout, 0)}, {time[-1]:.10g} s in line {line_of(layout, rows.n - 1)}"
        )
    table, c = [cells_of(line, layout.delimiter) for line in rows.head[:1000]], layout.time_column
    written = max((decimals(row[c]) for row in table if c is not None and c < len(row)), default=0)
    rounding = layout.second * 10.0**-written
    intervals = np.diff(time) * rate
    if rows.frame is None and rate * rounding < 0.25:
        steps = np.maximum(np.round(intervals), 1).astype(np.int64)
    elif rows.frame is None:
        notes.append(
            f"its times have steps of {rounding:g} s, a frame lasts {1 / rate:.3g} s: a missing or"
            " doubled frame would not be noticed"
        )
    off = np.abs(intervals - steps) > 0.5 + rate * rounding
    mean = float(steps.sum()) / duration
    typical = np.median(steps) != 1 and rows.frame is None
    if off.mean() > 0.5 or typical:
        raise _rates_differ(layout, rate, len(steps) / duration)
    if off.any():
        row = int(np.argmax(off))
        raise Refusal(
            f"{layout.name}: line {line_of(layout, row + 1)}: time goes from {time[row]:.10g} to"
            f" {time[row + 1]:.10g} s, expected {steps[row]} / ({rate:g} Hz) more"
        )
    if abs(mean / rate - 1) > RATE_TOLERANCE + rounding / duration:
        raise _rates_differ(layout, rate, mean)
    return steps


def _rates_differ(layout: Layout, rate: float, mean: float) -> Refusal:
    return Refusal(
        f"{layout.name}: its frame rate is {rate:g} Hz, by its time column {mean:.6g} Hz;"
        " they may differ by 0.1 %"
    )


def _check_declared(layout: Layout, rows: Rows, span: int, accept_truncated: bool) -> list[str]:
    """Refuse another number of frames than declared; what to say of a file that was cut off."""
    why = rows.cut_off
    if layout.declared is not None:
        name, n = layout.declared
        if rows.n > n and span != n:
            said = f"has {rows.n} frames, {name} states {n}"
            if not layout.declared_too_few:
                raise Refusal(f"{layout.name}: {said}")
            return [said]
        if rows.n < n and span != n:
            why = f"{rows.n} of the {n} frames that {name} states"
    if why and not accept_truncated:
        raise Truncated(f"{layout.name}: cut off: {why}")
    return [f"cut off: {why}; used as it is"] if why else []
