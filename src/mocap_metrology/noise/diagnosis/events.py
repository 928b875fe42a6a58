"""Events: what happened once, found in time by the dynamic Allan variance (S 3.5, the crump)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mocap_metrology.noise.diagnosis.dynamic import Dynamic
from mocap_metrology.noise.diagnosis.levels import JOINED_BLOCKS, changes
from mocap_metrology.noise.diagnosis.outliers import mad_spread
from mocap_metrology.noise.diagnosis.sides import WHITE, Blocks, Sides, compare, likeness
from mocap_metrology.noise.fit.estimates import Z_95

JOIN_S = 1.0  # alarms so close are one event
REST_S = 0.5  # between excursions, at least
CONTEXT_S = 10.0  # round an event: its level and noise
SMOOTHED = 4  # part of the surest averaging time that excursions are averaged over
MOVED = 5.0  # standard deviations off the level that count as moved
NEAR = 2 * JOINED_BLOCKS  # blocks from a burst within which a change of level is of it
CLEAR_S = 1.0  # left out on each side before sides are compared
SIDES_MISS = 0.01  # probability that some series beside some event is reported as changed falsely
# Shorter recordings decide nothing: an event in the middle needs its context on both sides
LEAST_S = 2 * (CONTEXT_S + CLEAR_S)
LEVEL_MATTERS = 1.1  # ratio of noise after to before from which a reader is warned
MOST = 200  # events that are measured; more, and the recording is no still one
MEDIAN_ERROR = math.sqrt(math.pi / 2)  # times that of the mean, of Gaussian noise
NO_FRAMES = np.empty(0, int)


@dataclass(frozen=True)
class Alarm:
    """Windows of one series and m that the noise does not explain; x as in `Dynamic`; sure: by
    themselves, not beside others alone."""

    start_s: float
    stop_s: float
    series: str
    tau_s: float
    x: float
    ratio: float
    sure: bool


@dataclass(frozen=True)
class Event:
    """kind: `burst` (something moved) or `level` (noise became another). series: those with alarms,
    most significant first. size_mm: largest excursion of a coordinate, `largest`; nan for a level.
    shift_mm: where that coordinate was after less where it was before, NaN where one is unknown;
    shift_error: its standard error. p: probability of anything so unlikely in the whole recording,
    at most. ratio: of the dynamic Allan variance to that of the noise, at tau_s. sides: of every
    series. of: number of bursts in the recording. moved: whether any excursion is less white than
    the noise, which else was loud; white: least whiteness, of that beside it. often: whether it is
    several excursions, at rest between them most of the time. level_s: time of a lasting change of
    level near it.
    """

    time_s: float
    duration_s: float
    kind: str
    series: tuple[str, ...]
    largest: str
    size_mm: float
    shift_mm: float
    p: float
    ratio: float
    tau_s: float
    sides: tuple[Sides, ...] = ()
    of: int = 1
    moved: bool = True
    often: bool = False
    white: float = 0.0
    shift_error: float = math.nan
    level_s: float = math.nan

    @property
    def stop_s(self) -> float:
        return self.time_s + self.duration_s

    @property
    def shift_ends_mm(self) -> tuple[float, float]:
        """95 % interval of |shift_mm|."""
        reach = Z_95 * self.shift_error
        return abs(self.shift_mm) - reach, abs(self.shift_mm) + reach

    @property
    def stays(self) -> bool:
        """Whether more than half of it is left afterwards, surely a quarter."""
        sure = not self.shift_ends_mm[0] < self.size_mm / 4
        return sure and abs(self.shift_mm) > self.size_mm / 2

    @property
    def level_changed(self) -> bool:
        return any(side.changed for side in self.sides)

    @property
    def most_changed(self) -> Sides | None:
        """The side that departs most from equality, in units of its interval."""
        known = [side for side in self.sides if side.upper > side.lower]
        return max(known, key=lambda s: abs(math.log(s.ratio, s.upper / s.lower)), default=None)

    @property
    def outcome(self) -> Literal["level changed", "once", "repeated", "unknown"]:
        """What is left of it, or how often it was; `unknown` where a side is too short."""
        if self.kind == "level" or self.level_changed:
            return "level changed"
        if not self.most_changed:
            return "unknown"
        return "once" if self.of == 1 else "repeated"

    @property
    def noise_after(self) -> Literal["changed", "alike", "undecided"]:
        """Against that before, over all series."""
        if self.level_changed:
            return "changed"
        unsure = any(side.word == "undecided" for side in self.sides)
        return "undecided" if unsure else "alike"

    @property
    def matters(self) -> bool:
        """Whether a reader is warned: not of a small change of level alone."""
        side = self.most_changed
        if side is None or self.kind == "burst":
            return True
        return max(side.ratio, 1 / side.ratio) >= LEVEL_MATTERS

    def of_level(self) -> Event:
        """The change of the level of noise alone."""
        level = replace(self, kind="level", duration_s=0.0, largest=self.series[0])
        level = replace(level, time_s=self.level_s)
        return replace(level, size_mm=math.nan, shift_mm=math.nan, ratio=math.nan, tau_s=math.nan)

    def markers(self, labels: Sequence[str]) -> list[str]:
        """Labels of the markers whose coordinates it is seen in."""
        numbers = {int(s[1:]) for s in self.series if s[0] in "xyz"}
        return [label for k, label in enumerate(labels, start=1) if k in numbers]


def alarms(
    dynamics: Mapping[str, Sequence[Dynamic]], false_alarm: float
) -> tuple[list[list[Alarm]], float]:
    """Windows less likely than false_alarm over the number of all, `merged`, and that number;
    and beside these windows less likely than that over the number of those within CONTEXT_S, as the
    parts of an event are not all as sure."""
    every = [d for of_series in dynamics.values() for d in of_series]
    n_tests = sum(d.n_tests for d in every)
    limit = math.log(max(n_tests, 1) / false_alarm)
    seconds = max((d.x.size * d.hop_s for d in every), default=CONTEXT_S)
    beside = limit - math.log(max(seconds / CONTEXT_S, 1.0))
    raised = [
        Alarm(
            k * d.hop_s, k * d.hop_s + d.window_s, name, d.tau_s, d.x[k], d.ratio[k], d.x[k] > limit
        )
        for name, of_series in dynamics.items()
        for d in of_series
        for k in np.flatnonzero(d.x > beside)
    ]  # fmt: skip
    return [group for group in merged(raised) if any(a.sure for a in group)], n_tests


def merged(raised: Iterable[Alarm]) -> list[list[Alarm]]:
    """Alarms of all series that overlap or nearly so, in order of time."""
    groups: list[list[Alarm]] = []
    reached = -math.inf
    for alarm in sorted(raised, key=lambda a: a.start_s):
        if alarm.start_s > reached + JOIN_S:
            groups.append([])
        groups[-1].append(alarm)
        reached = max(reached, alarm.stop_s)
    return groups


def measured_events(
    groups: Sequence[list[Alarm]], series: Mapping[str, np.ndarray], rate_hz: float, n_tests: float
) -> list[Event]:
    """The events of groups of alarms: when each moved what how far.

    series: coordinates (and distances, which do not count for the size), each asked for once. Off
    its level is what departs by more than five standard deviations from the median before, both of
    up to ten seconds. What neither moves nor scatters more, as a sweep does, is no event.
    """
    moved: list[dict[str, _Excursion]] = [{} for _ in groups]
    for name in series:
        numbers = [k for k, group in enumerate(groups) if any(a.series == name for a in group)]
        values = series[name] if numbers else np.empty(0)
        for k in numbers:
            moved[k][name] = _excursion(values, groups[k], rate_hz)
    return [
        _event(group, parts, n_tests, rate_hz)
        for group, parts in zip(groups, moved, strict=True)
        if any(one.loud or one.white < WHITE for one in parts.values())
    ]


def _event(
    group: list[Alarm], moved: Mapping[str, _Excursion], n_tests: float, rate_hz: float
) -> Event:
    surest = max(group, key=lambda a: a.x)
    order = sorted(
        {a.series for a in group}, key=lambda s: -max(a.x for a in group if a.series == s)
    )
    sized = {k: m for k, m in moved.items() if not k.startswith("L")} or moved
    sized = {k: m for k, m in sized.items() if m.moved} or sized  # others may be loud beside it
    off = np.unique(np.concatenate([m.off for m in moved.values()] or [NO_FRAMES]))
    shortest_s = min(a.tau_s for a in group if a.sure)
    brief = [a for a in group if a.tau_s == shortest_s]
    start = float(off[0]) / rate_hz if off.size else min(a.start_s for a in brief)
    stop = float(off[-1] + 1) / rate_hz if off.size else max(a.stop_s for a in brief)
    rests = np.diff(off) / rate_hz
    largest = max(sized, key=lambda k: sized[k].size)
    return Event(
        start, stop - start, "burst", tuple(order), largest, sized[largest].size,
        sized[largest].shift, min(1.0, n_tests * math.exp(-min(surest.x, 700))), surest.ratio,
        surest.tau_s, moved=any(m.moved for m in moved.values()),
        often=(stop - start) / 2 < float(rests[rests > REST_S].sum()),
        white=min(m.white for m in moved.values()), shift_error=sized[largest].error,
    )  # fmt: skip


@dataclass(frozen=True)
class _Excursion:
    """size, shift, error (standard, of the shift): mm; off: frames off the level, of what is less
    white; others as of `Event`."""

    size: float
    shift: float
    error: float
    off: np.ndarray
    white: float
    moved: bool
    loud: bool


def _excursion(values: np.ndarray, group: list[Alarm], rate_hz: float) -> _Excursion:
    """Extremes of an event in centred means, over few enough frames to leave its shape as it is."""
    surest = max(group, key=lambda a: a.x)
    width = max(round(surest.tau_s * rate_hz / SMOOTHED), 1)
    first, last = _frames(group, rate_hz, values.size)
    far = round(CONTEXT_S * rate_hz)
    start = max(first - far, 0)
    near = values[start : last + far].astype(float)
    sure = merged(a for a in group if a.sure)
    whites, less, moved, loud = zip(
        *(_likeness(values, part, rate_hz) for part in sure), strict=True
    )
    padded = np.pad(near, (width // 2, (width - 1) // 2), "edge")  # a recording may begin there
    near = np.convolve(padded, np.full(width, 1 / width), "valid")
    first, last = first - start, last - start
    sides = [near[width:first], near[last:-width]]
    sides = [side[np.isfinite(side)] for side in sides]
    both = min(side.size for side in sides) >= 16  # else nothing is known of a shift
    sides = [side if side.size >= 16 else sides[1 - k] for k, side in enumerate(sides)]
    few = round(CONTEXT_S / 5 * rate_hz)
    levels = [np.median(s) if s.size else np.nan for s in (sides[0][-few:], sides[1][:few])]
    inside = near[first:last] - levels[0]
    noise = min((mad_spread(s) for s in sides if s.size), default=0.0)
    with np.errstate(invalid="ignore"):
        off = np.flatnonzero(np.abs(inside) > MOVED * noise) if any(less) else NO_FRAMES
    size = float(np.nanmax(np.abs(inside))) if np.isfinite(inside).any() else math.nan
    shift = float(levels[1] - levels[0]) if both else math.nan
    error = MEDIAN_ERROR * noise * math.sqrt(2 * width / max(few, 1))
    error = max(error, math.sqrt(2) * _scatter_of_levels(sides, few))
    return _Excursion(size, shift, error, start + first + off, min(whites), any(moved), any(loud))


def _scatter_of_levels(sides: Sequence[np.ndarray], few: int) -> float:
    """Standard deviation of medians over `few` frames about their mean of each side, which noise
    that is correlated for seconds makes larger; 0 where there are no two of them on a side."""
    off, n = 0.0, 0
    for side in sides:
        count = side.size // max(few, 1)
        if count > 1:
            levels = np.median(side[: count * few].reshape(count, few), axis=1)
            off, n = off + float(np.var(levels)) * count, n + count - 1
    return math.sqrt(off / n) if n else 0.0


def _likeness(
    values: np.ndarray, part: list[Alarm], rate_hz: float
) -> tuple[float, bool, bool, bool]:
    """`likeness` of a sure part of an event, among as many series as alarm in it."""
    first, last = _frames(part, rate_hz, values.size)
    return likeness(values, first, last, round(CONTEXT_S * rate_hz), len({a.series for a in part}))


def _frames(group: Sequence[Alarm], rate_hz: float, n: int) -> tuple[int, int]:
    begin, end = min(a.start_s for a in group), max(a.stop_s for a in group)
    return round(begin * rate_hz), min(round(end * rate_hz), n)


def inside_events(events: Sequence[Event], n: int, length_s: float) -> np.ndarray:
    """(n,) of consecutive pieces of length_s: whether they lie in a burst or within a second."""
    flags = np.zeros(n, bool)
    for event in events:
        if event.kind == "burst":
            first = max(math.floor((event.time_s - CLEAR_S) / length_s), 0)
            flags[first : math.ceil((event.stop_s + CLEAR_S) / length_s)] = True
    return flags


def with_sides(
    event: Event,
    levels: Mapping[str, Blocks],
    out_of: np.ndarray,
    side_s: float,
    levels_s: Sequence[float],
    tail: float,
) -> Event:
    """The event with every series compared before and after, at most side_s on each side and up to
    the next of `levels_s`, times at which the level changes. tail: as of `compare`."""
    start, stop = event.time_s - CLEAR_S, event.stop_s + CLEAR_S
    first = max([start - side_s, *(t for t in levels_s if t < start)])
    last = min([stop + side_s, *(t for t in levels_s if t > stop)])
    sides = (
        compare(name, one.between(first, start, out_of), one.between(stop, last, out_of), tail)
        for name, one in levels.items()
    )
    return replace(event, sides=tuple(sides))


def find_events(
    dynamics: Mapping[str, Sequence[Dynamic]],
    levels: Mapping[str, Blocks],
    series: Mapping[str, np.ndarray],
    rate_hz: float,
    false_alarm: float,
    side_s: float,
) -> list[Event]:
    """Bursts and lasting changes of level in order of time; half of the false alarms for each.

    dynamics, levels, series: of the same recording, outliers bridged, by series.
    """
    groups, n_tests = alarms(dynamics, false_alarm / 2)
    groups = sorted(groups, key=lambda g: -max(a.x for a in g))[:MOST]
    events = measured_events(groups, series, rate_hz, n_tests)
    events = [replace(event, of=len(events)) for event in events]
    first = next(iter(levels.values()))
    out_of = inside_events(events, first.mean.size, first.length_s)
    for change in changes(levels, out_of, side_s, false_alarm / 2):
        time_s, near = change.time_s, NEAR * first.length_s
        beside = [e for e in events if e.time_s - near <= time_s <= e.stop_s + near]
        if beside:
            one = min(beside, key=lambda e: abs(e.time_s - time_s))
            events[events.index(one)] = replace(one, level_s=time_s)
        else:
            name, nan = change.series, math.nan
            level = (time_s, 0.0, "level", (name,), name, nan, nan, change.p, nan, nan)
            events.append(Event(*level, level_s=time_s))
    for _ in range(2):  # of bursts it is known once their sides are
        levels_s = [e.time_s for e in events if e.kind == "level" or e.level_changed]
        how = levels, out_of, side_s, levels_s, SIDES_MISS / max(len(levels) * len(events), 1)
        events = [with_sides(event, *how) for event in events]
    return sorted(events, key=lambda e: e.time_s)
