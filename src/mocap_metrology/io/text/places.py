"""Where each row of a text recording lies in time: frame numbers, times, and the count declared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.c3d.segments import LONGEST_GAP
from mocap_metrology.io.text.layout import Layout
from mocap_metrology.io.text.rows import Rows, cells_of, line_of

RATE_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Places:
    """`place` (n,) of each row from 0, None where no frame is missing; `n_frames` spanned."""

    name: str
    first_frame: int
    n_frames: int
    place: np.ndarray | None
    notes: tuple[str, ...]


def find_places(layout: Layout, rows: Rows, rate: float, accept_truncated: bool) -> Places:
    """Check frame numbers, times and the declared count of a file at `rate` Hz.

    Frame numbers with holes, or times where there are no numbers, say which frames are missing.
    Refuses numbers that do not grow, times that do not fit, and other counts than declared.
    """
    notes = list(rows.notes)
    steps, first = np.ones(rows.n - 1, np.int64), 1
    if rows.frame is not None:
        steps, first = _by_number(layout, rows.frame, notes)
    if rows.time is not None:
        steps = _by_time(layout, rows, steps, rate)
    span = int(steps.sum()) + 1
    missing = span - rows.n
    if missing > LONGEST_GAP * rows.n:
        raise Refusal(
            f"{layout.name}: frame numbers or times leave out {missing} frames, more than"
            f" {LONGEST_GAP} times the {rows.n} there are"
        )
    if missing:
        holes = int((steps > 1).sum())
        row = int(np.argmax(steps > 1))
        notes.append(
            f"{missing} frames are missing in {holes} places, the first before line"
            f" {line_of(layout, row + 1)}: taken as gaps"
        )
    notes += _check_declared(layout, rows, span, accept_truncated)
    place = np.concatenate([[0], np.cumsum(steps)]) if missing else None
    return Places(layout.name, first, span, place, tuple(notes))


def _by_number(layout: Layout, frame: np.ndarray, notes: list[str]) -> tuple[np.ndarray, int]:
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
                f"{layout.name}: every frame number is {steps[0]} more than the one before, and no"
                " time tells whether the frame rate is that of the rows"
            )
        notes.append(f"frame numbers count by {steps[0]}: rows are taken as consecutive frames")
        steps = np.ones_like(steps)
    return steps, int(frame[0])


def _by_time(layout: Layout, rows: Rows, steps: np.ndarray, rate: float) -> np.ndarray:
    """Times against `steps` at `rate`; without frame numbers, steps by time."""
    time = rows.time
    if time is None or len(steps) == 0 or not np.isfinite(time).all():
        return steps
    digits = max(
        (
            _decimals(cells_of(layout, t)[layout.time_column])
            for t in rows.head[:1000]
            if len(cells_of(layout, t)) > layout.time_column
        ),
        default=0,
    )
    rounding = 10.0**-digits
    found = np.diff(time) * rate
    if rows.frame is None and rate * rounding < 0.25:
        steps = np.maximum(np.round(found), 1).astype(np.int64)
    off = np.abs(found - steps) > 0.5 + rate * rounding
    duration = float(time[-1] - time[0])
    mean = float(steps.sum()) / duration if duration > 0 else 0.0
    typical = np.median(steps) != 1 and rows.frame is None
    if off.mean() > 0.5 or typical:
        raise _rates_differ(layout, rate, len(steps) / duration if duration > 0 else 0.0)
    if off.any():
        row = int(np.argmax(off))
        raise Refusal(
            f"{layout.name}: line {line_of(layout, row + 1)}: time goes from {time[row]:.10g} to"
            f" {time[row + 1]:.10g} s, expected {steps[row]} / ({rate:g} Hz) more"
        )
    if abs(mean / rate - 1) > RATE_TOLERANCE + rounding / duration:
        raise _rates_differ(layout, rate, mean)
    return steps


def _decimals(cell: str) -> int:
    return len(cell.replace(",", ".").partition(".")[2])


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
            said = f"has {rows.n} frames, {name} says {n}"
            if not layout.declared_too_few:
                raise Refusal(f"{layout.name}: {said}")
            return [said]
        if rows.n < n and span != n:
            why = f"{rows.n} of the {n} frames that {name} says"
    if why and not accept_truncated:
        raise Truncated(f"{layout.name}: cut off: {why}")
    return [f"cut off: {why}; taken as it is"] if why else []
