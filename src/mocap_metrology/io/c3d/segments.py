"""Several files of one take: their order and the gaps between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.frames import SATURATED, WRAP
from mocap_metrology.io.c3d.structure import Structure

LONGEST_GAP = 10  # times all frames measured; beyond it a frame number is not believed


class Numbered(Protocol):
    """A file, and how many frames it spans."""

    @property
    def name(self) -> str: ...
    @property
    def n_frames(self) -> int: ...


@dataclass(frozen=True)
class Plan:
    """`order` of the given segments, frames missing before each (in that order), remarks."""

    order: tuple[int, ...]
    gaps: tuple[int, ...]
    notes: tuple[str, ...] = ()


def plan_segments(segments: Sequence[Structure]) -> Plan:
    """Order and gaps of the segments of one take.

    Where TRIAL of every segment agrees with its frame count, it says both. Otherwise the given
    order holds, and the header's first frame, which counts modulo 65536, gives the gaps. Where all
    segments start at the same number nothing does, and no gap is assumed.
    Refuses segments that overlap, and headers whose first frame is at its 16-bit limit.
    """
    if len(segments) > 1 and all(s.trial is not None for s in segments):
        return plan_by_numbers(segments, _trial_firsts(segments))
    firsts = [s.header_first for s in segments]
    if len(set(firsts)) == 1:
        return _one_after_another(firsts)
    gaps = _header_gaps(segments)
    _check_gaps(segments, range(len(segments)), gaps)
    return Plan(tuple(range(len(segments))), (0, *gaps))


def plan_by_numbers(segments: Sequence[Numbered], firsts: Sequence[int]) -> Plan:
    """The same where the number of each segment's first frame is known."""
    if len(set(firsts)) == 1:
        return _one_after_another(firsts)
    order = tuple(sorted(range(len(segments)), key=lambda i: firsts[i]))
    gaps = [_gap(segments, firsts, a, b) for a, b in pairwise(order)]
    _check_gaps(segments, order, gaps)
    notes = []
    if order != tuple(range(len(segments))):
        names = ", ".join(segments[i].name for i in order)
        notes.append(f"segments were given out of order; taken as {names}")
    return Plan(order, (0, *gaps), tuple(notes))


def _one_after_another(firsts: Sequence[int]) -> Plan:
    order = tuple(range(len(firsts)))
    if len(firsts) == 1:
        return Plan(order, (0,))
    note = f"all segments start at frame {firsts[0]}: taken in the given order, without gaps"
    return Plan(order, (0,) * len(firsts), (note,))


def _check_gaps(segments: Sequence[Numbered], order: Sequence[int], gaps: Sequence[int]) -> None:
    if sum(gaps) > LONGEST_GAP * sum(s.n_frames for s in segments):
        raise Refusal(
            f"{segments[order[0]].name}: the segments' frame numbers leave out {sum(gaps)} frames,"
            f" more than {LONGEST_GAP} times those measured: are they of one take?"
        )


def _trial_firsts(segments: Sequence[Structure]) -> list[int]:
    """First frames by TRIAL, with one base for all where one goes with every count."""
    bases = [WRAP - 1, WRAP] if any(s.trial_base == WRAP - 1 for s in segments) else [WRAP]
    for base in bases:
        if all(s.trial is not None and s.trial.count(base) == s.n_frames for s in segments):
            return [s.trial.first(base) for s in segments if s.trial is not None]
    return [s.first_frame for s in segments]


def _gap(segments: Sequence[Numbered], firsts: Sequence[int], a: int, b: int) -> int:
    """Frames missing between segment `a` and the later `b`."""
    gap = firsts[b] - (firsts[a] + segments[a].n_frames)
    if gap < 0:
        raise _overlap(segments[a], firsts[a], segments[b], firsts[b])
    return gap


def _header_gaps(segments: Sequence[Structure]) -> list[int]:
    firsts = [s.header_first for s in segments]
    for s in segments:
        if s.header_first == s.header_last and s.header_first in SATURATED and s.n_frames > 1:
            raise Refusal(
                f"{s.name}: its first frame stands at the 16-bit limit {s.header_first} in the"
                " header and TRIAL does not tell it, so the gap before this segment is not known"
            )
    if len(set(firsts)) < len(firsts):
        twice = next(i for i, first in enumerate(firsts) if first in firsts[:i])
        a = firsts.index(firsts[twice])
        raise _overlap(segments[a], firsts[a], segments[twice], firsts[twice])
    gaps = []
    for a, b in pairwise(segments):
        gap = (b.header_first - a.header_first - a.n_frames) % WRAP
        if gap >= WRAP // 2:
            raise _overlap(a, a.header_first, b, b.header_first)
        gaps.append(gap)
    return gaps


def _overlap(a: Numbered, first_a: int, b: Numbered, first_b: int) -> Refusal:
    return Refusal(
        f"{b.name}: segments overlap or are out of order: frames"
        f" {first_b} to {first_b + b.n_frames - 1}, but {a.name} has frames"
        f" {first_a} to {first_a + a.n_frames - 1}"
    )
