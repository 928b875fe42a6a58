"""How many frames a recording has: what the file declares, held against what it can hold.

Five places declare a count and each has its limits, so the size of the data section decides which
are possible: n frames of s bytes fit `available` bytes where n s <= available <= n s + 512, the
512 because some writers add a whole block of padding. Some add more, all zeros: then a count on
which all declarations agree fits, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.c3d.parameters import BLOCK, Parameters, unsigned

SATURATED = (65535, 32767)  # the largest unsigned and signed 16-bit counts
WRAP = 65536
CUT_OFF = "cut off"


@dataclass(frozen=True)
class Section:
    """Data section: `available` bytes, of which the last `zeros` are 0, and whether it ends on a
    block."""

    available: int
    zeros: int
    on_block: bool

    def empty_after(self, used: int) -> bool:
        """Whether nothing but zeros follows the first `used` bytes."""
        return self.available - used <= self.zeros

    def ends_cleanly(self, used: int) -> bool:
        """Whether a file of `used` data bytes would end here: no padding, or a filled block."""
        return used == self.available or (self.on_block and self.empty_after(used))


@dataclass(frozen=True)
class Trial:
    """TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD as words (low, high)."""

    start: tuple[int, int]
    end: tuple[int, int]

    def first(self, base: int = WRAP) -> int:
        """Number of the first frame; some writers multiply the high word by 65535."""
        return self.start[0] + base * self.start[1]

    def count(self, base: int = WRAP) -> int:
        """Number of frames from the first to the last."""
        return self.end[0] + base * self.end[1] - self.first(base) + 1


@dataclass(frozen=True)
class Declared:
    """Declared length of a file; None or absent where nothing is declared."""

    long_frames: int | None
    trial: Trial | None
    frames: int | None
    frames_is_float: bool
    header_first: int
    header_last: int

    @property
    def header(self) -> int | None:
        """Count of the header, whose words may have wrapped, where they say anything."""
        if self.header_last == 0 or self.header_first == self.header_last == SATURATED[0]:
            return None
        return (self.header_last - self.header_first + 1) % WRAP

    def wide(self) -> dict[str, int]:
        """Counts that are not limited to 16 bits."""
        counts = {"POINT:LONG_FRAMES": self.long_frames}
        counts["TRIAL"] = self.trial.count() if self.trial else None
        counts["POINT:FRAMES"] = self.frames if self.frames_is_float else None
        return {source: n for source, n in counts.items() if n and n > 0}

    def narrow(self) -> dict[str, int]:
        """Counts of 16 bits."""
        counts = {"POINT:FRAMES": None if self.frames_is_float else self.frames}
        counts["header"] = self.header
        return {source: n for source, n in counts.items() if n and n > 0}

    def in_words(self) -> str:
        """All counts, for a message."""
        counts = list(self.wide().items()) + list(self.narrow().items())
        return ", ".join(f"{n} by {source}" for source, n in counts) or "none"


@dataclass(frozen=True)
class FrameCount:
    """The count, the place it is from, TRIAL's base if TRIAL agrees with it, remarks."""

    n: int
    source: str
    trial_base: int | None = None
    notes: tuple[str, ...] = ()


def declared_counts(parameters: Parameters, header_first: int, header_last: int) -> Declared:
    """Collect the five declarations."""
    frames = parameters.get("POINT", "FRAMES")
    start = _words(parameters, "ACTUAL_START_FIELD")
    end = _words(parameters, "ACTUAL_END_FIELD")
    return Declared(
        long_frames=parameters.count("POINT", "LONG_FRAMES"),
        trial=Trial(start, end) if start and end and end != (0, 0) else None,
        frames=parameters.count("POINT", "FRAMES"),
        frames_is_float=frames is not None and frames.kind == 4,
        header_first=header_first,
        header_last=header_last,
    )


def _words(parameters: Parameters, name: str) -> tuple[int, int] | None:
    """(low, high) of a TRIAL field; one value alone, as float perhaps, is split."""
    values = parameters.numbers("TRIAL", name)
    if len(values) == 0 or not all(abs(v) < 2**31 for v in values):  # NaN fails too
        return None
    if len(values) == 1:
        value = int(values[0])
        value = value & 0xFFFF if value < 0 else value
        return value % WRAP, value // WRAP
    return unsigned(values[0]), unsigned(values[1])


def count_frames(
    declared: Declared, section: Section, frame_bytes: int, by_size: bool
) -> FrameCount | str:
    """The frame count, or why there is none.

    Of several counts that fit, the one that goes with the data is taken, else a wide one before a
    16-bit one. `by_size` allows a count that only the size gives: where 16-bit counts are at their
    limit or have wrapped and nothing wider is declared.
    """
    low = max(1, -(-(section.available - BLOCK) // frame_bytes))
    high = section.available // frame_bytes
    wide, narrow = declared.wide(), declared.narrow()
    base = _trial_base(declared, section, frame_bytes, range(low, high + 1))
    if declared.trial is not None:
        wide["TRIAL"] = declared.trial.count(base)
    # A 16-bit remainder of a wide count that does not fit has no information of its own.
    echoes = {e for n in wide.values() if n > max(high, 32767) for e in (*SATURATED, n % WRAP)}
    counts = wide | {source: n for source, n in narrow.items() if n not in echoes}
    fits = {source: n for source, n in counts.items() if low <= n <= high}
    most = max(counts.values(), default=0)
    padded = section.on_block and most < low and section.empty_after(most * frame_bytes)
    if padded and not _remarks(most, [*counts.items()]):
        fits = {source: n for source, n in counts.items() if n == most}
    # Where several fit, the recording ends with its last frame that is not all zeros.
    full = {source: n for source, n in fits.items() if section.empty_after(n * frame_bytes)}
    n = min(full.values(), default=next(iter(fits.values()), 0))
    others = [other for other in fits.values() if other < n and other not in SATURATED]
    if others and not _ends_after(section, n * frame_bytes):
        return (
            f"frame counts disagree and the data do not decide: {declared.in_words()}, and the"
            f" data section holds {low} to {high} frames of {frame_bytes} bytes"
        )
    source = next((source for source, fitting in fits.items() if fitting == n), "")
    if n and (source in wide or n not in SATURATED or full):
        agrees = declared.trial is not None and wide["TRIAL"] == n
        notes = _remarks(n, [*wide.items(), *narrow.items()])
        if n < low:
            notes += (
                f"{section.available - n * frame_bytes} bytes of zeros follow the last frame",
            )
        return FrameCount(n, source, base if agrees else None, notes)
    count = None
    if by_size and not wide and section.ends_cleanly(high * frame_bytes):
        count = _from_size(declared, section, frame_bytes, range(low, high + 1))
    return count or _why_not(declared, section, low, frame_bytes)


def _ends_after(section: Section, used: int) -> bool:
    """Whether the data show that they end after `used` bytes: with zeros, or with the file. A block
    that is filled shows nothing, as some writers fill it with what was in memory."""
    if used == section.available:
        return not section.on_block
    return section.empty_after(used)


def _trial_base(declared: Declared, section: Section, frame_bytes: int, possible: range) -> int:
    """What TRIAL's high words count: 65536, or 65535 where that alone goes with file and counts."""
    if declared.trial is None:
        return WRAP
    usual, other = declared.trial.count(WRAP), declared.trial.count(WRAP - 1)
    if usual == other or other not in possible:
        return WRAP
    counts = [*declared.wide().items(), *declared.narrow().items()]
    rest = {n for source, n in counts if source != "TRIAL"}
    if usual in rest:
        return WRAP
    if usual in possible:  # a count at its limit shows nothing where data follow it
        shown = other not in SATURATED or section.empty_after(other * frame_bytes)
        return WRAP - (other in rest and shown)
    return WRAP - section.ends_cleanly(other * frame_bytes)


def _remarks(n: int, counts: Sequence[tuple[str, int]]) -> tuple[str, ...]:
    """Declared counts that differ from the one taken, 16-bit remainders of it aside."""
    harmless = {n, n % WRAP, *SATURATED} if n > 32767 else {n}
    others = [f"{other} by {source}" for source, other in counts if other not in harmless]
    return (f"{n} frames; the file also declares {', '.join(others)}",) if others else ()


def _from_size(
    declared: Declared, section: Section, frame_bytes: int, possible: range
) -> FrameCount | None:
    """Count from the size, where 16-bit counts are at their limit or wrapped, and it is clear.

    At their limit: the last frame that is not all zeros ends the recording; what follows it in the
    block is padding, or frames that would be invalid anyway.
    """
    narrow = declared.narrow()
    limit = declared.frames or declared.header_last
    if limit in SATURATED:
        n = min(-(-(section.available - section.zeros) // frame_bytes), possible[-1])
        note = (
            "the declared frame count is at its 16-bit limit: frames are counted by the file size, "
            "so a cut-off end would not be detected"
        )
        return FrameCount(n, "file size", notes=(note,)) if n > limit else None
    remainders = {n % WRAP for n in narrow.values()}
    wrapped = [n for n in possible if n > WRAP and {n % WRAP} == remainders]
    if len(wrapped) == 1 and section.ends_cleanly(wrapped[0] * frame_bytes):
        note = "the declared frame count has wrapped at 65536: it is corrected by the file size"
        return FrameCount(wrapped[0], "file size", notes=(note,))
    return None


def _why_not(declared: Declared, section: Section, low: int, frame_bytes: int) -> str:
    high = section.available // frame_bytes
    counts = list(declared.wide().values()) or list(declared.narrow().values())
    if not counts:
        return "no frame count is declared (POINT:FRAMES, header)"
    if high < min(counts):
        held = _whole_frames(section, frame_bytes)
        return f"{CUT_OFF}: frames declared: {declared.in_words()}; frames in the file: {held}"
    holds = f"{low} to {high}" if low < high else f"{high}"
    return (
        f"frame count and file size disagree: {declared.in_words()}, but the data section"
        f" holds {holds} frames of {frame_bytes} bytes"
    )


def _whole_frames(section: Section, frame_bytes: int) -> int:
    """Whole frames in the data section, those of zeros in its last block not counted."""
    high = section.available // frame_bytes
    low = -(-(section.available - BLOCK) // frame_bytes)
    return next((n for n in range(low, high) if section.empty_after(n * frame_bytes)), high)


def choose_frame_size(
    declared: Declared,
    section: Section,
    point_bytes: int,
    analog_bytes: Sequence[int],
    file: str,
    accept_truncated: bool,
) -> tuple[int, FrameCount]:
    """Bytes per frame and frame count, from the possible numbers of analog bytes per frame.

    The header's number (the first) and what ANALOG:USED and the rates give may differ; the file
    size decides, and where it cannot the file is refused. `accept_truncated` takes the frames that
    are there of a file that was cut off.
    """
    sizes = list(dict.fromkeys(point_bytes + n for n in analog_bytes))
    tried = {s: count_frames(declared, section, s, by_size=len(sizes) == 1) for s in sizes}
    good = {s: count for s, count in tried.items() if isinstance(count, FrameCount)}
    if not good:
        why = next(reason for reason in tried.values() if isinstance(reason, str))
        held = _whole_frames(section, sizes[0])
        usable = why.startswith(CUT_OFF) and len(sizes) == 1 and held
        if not (accept_truncated and usable):
            raise (Truncated if usable else Refusal)(f"{file}: {why}")
        note = f"{why}: only these are used, as requested in column truncated"
        return sizes[0], FrameCount(held, "file size", notes=(note,))
    if len(good) > 1:
        listed = " or ".join(str(s) for s in good)
        raise Refusal(
            f"{file}: header and ANALOG parameters disagree on the analog samples per frame, and"
            f" frames of {listed} bytes both fit the file size"
        )
    return next(iter(good.items()))
