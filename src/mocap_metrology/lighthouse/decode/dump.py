"""A logic dump of photodiodes: words -> pulses.

A dump is whole little-endian uint32 words, one a sample; bit i is diode i. A pulse begins at the
first sample that is lit and ends at the first that is not, so both edges come late by half a sample
on average: the middle of a pulse and the edge of a flash share that, and it cancels in angles.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import Pulses

SAMPLE_RATE_HZ = 2e6
BITS = 32
SHORTEST_S, LONGEST_S = 0.5, 60.0
USUAL_WORDS = (16_000_000, 16_777_216)  # 8 s, and the whole memory of J's board
CHANGING_SHARE = 0.1  # of the words: a dump of two stations has about 0.01, random bytes 1
LIT_SHARE = 0.5  # of the time: a diode is lit 0.03 of it
SHORTEST_FLASH_S = 2250 / 48e6
LONGEST_RUN = 1.5  # words, on average; a pulse two samples wide gives 2


def read_dump(
    path: str | Path,
    sample_rate_hz: float = SAMPLE_RATE_HZ,
    active_level: int = 1,
    n_diodes: int | None = None,
) -> Pulses:
    """Pulses of a dump file; see `pulses_of_words`.

    Raises `Refusal` where the file is no such dump; big-endian and 16-bit dumps and an inverted
    level are told by name. With all 32 bits in use the byte order shows only in the geometry: see
    `order.check_byte_order`.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        if size == 0:
            raise Refusal(f"{path.name}: empty file; expected uint32 words")
        if size % 4:
            raise Refusal(f"{path.name}: {size} bytes are no whole uint32 words of 4 bytes")
        words = np.memmap(path, dtype="<u4", mode="r")
    except OSError as error:
        raise Refusal(f"{path.name}: cannot be read ({error.strerror})") from None
    return pulses_of_words(words, sample_rate_hz, active_level, n_diodes, path.name)


def pulses_of_words(
    words: np.ndarray,
    sample_rate_hz: float = SAMPLE_RATE_HZ,
    active_level: int = 1,
    n_diodes: int | None = None,
    name: str = "dump",
) -> Pulses:
    """Pulses of a dump in memory.

    words: (n,) uint32. active_level: the bit that means light. n_diodes: of the board; bits above
    it are left out (None: 32). Pulses on at the first or last sample are dropped.
    """
    if active_level not in (0, 1):
        raise Refusal(f"{name}: active_level {active_level}; expected 0 or 1")
    if not sample_rate_hz > 0:
        raise Refusal(f"{name}: sample_rate_hz {sample_rate_hz}; expected a positive rate")
    n_diodes = BITS if n_diodes is None else n_diodes
    if not 1 <= n_diodes <= BITS:
        raise Refusal(f"{name}: {n_diodes} diodes; a uint32 dump holds 1 to {BITS}")
    duration_s = words.size / sample_rate_hz
    if not SHORTEST_S <= duration_s <= LONGEST_S:
        raise Refusal(
            f"{name}: {duration_s:g} s ({words.size} words at {sample_rate_hz:g} Hz);"
            f" expected {SHORTEST_S:g} to {LONGEST_S:g} s"
        )
    words = np.ascontiguousarray(words, dtype=np.uint32).view(np.ndarray).view()
    words.flags.writeable = False  # one signature for files and arrays
    idle = np.uint32(0 if active_level else 0xFFFFFFFF)
    changing, rises, lit = _survey(words, idle)
    _check_light(words, changing, rises, lit, active_level, name)
    _check_byte_order(rises, n_diodes, name)
    start, length, diode = _pulses(words, idle, int(rises.sum()))
    _check_word_size(words, length / sample_rate_hz, name)
    whole = (length > 0) & (diode < n_diodes)
    return Pulses(
        start_s=start[whole] / sample_rate_hz,
        length_s=length[whole] / sample_rate_hz,
        diode=diode[whole],
        n_diodes=n_diodes,
        duration_s=duration_s,
        resolution_s=1 / sample_rate_hz,
        notes=_notes(words.size, sample_rate_hz, rises, n_diodes),
    )


def _notes(
    n_words: int, sample_rate_hz: float, rises: np.ndarray, n_diodes: int
) -> tuple[str, ...]:
    notes = []
    if n_words not in USUAL_WORDS:
        notes.append(f"{n_words / sample_rate_hz:.6g} s long; a dump is usually 8 s or 8.389 s")
    dark = np.flatnonzero(rises[:n_diodes] == 0)
    if dark.size:
        notes.append(f"no light on diodes {', '.join(map(str, dark))}")
    if rises[n_diodes:].any():
        above = np.flatnonzero(rises[n_diodes:]) + n_diodes
        notes.append(f"light on bits {', '.join(map(str, above))}, beyond the board: left out")
    return tuple(notes)


def _check_light(
    words: np.ndarray,
    changing: int,
    rises: np.ndarray,
    lit: np.ndarray,
    active_level: int,
    name: str,
) -> None:
    """Refuse a constant file, random bytes and an inverted level."""
    if changing == 0:
        raise Refusal(f"{name}: no light: every word is 0x{int(words[0]):08x}; expected flashes")
    if changing > CHANGING_SHARE * words.size:
        raise Refusal(
            f"{name}: {100 * changing / words.size:.0f} % of the words differ from the one before;"
            " expected a dump of photodiodes, where about 1 % do"
        )
    share = float(np.median(lit[rises > 0])) / words.size if rises.any() else 1.0
    if share > LIT_SHARE:
        raise Refusal(
            f"{name}: diodes are lit {100 * share:.0f} % of the time: the level is inverted;"
            f" expected active_level {1 - active_level}"
        )


def _check_byte_order(rises: np.ndarray, n_diodes: int, name: str) -> None:
    """Refuse a big-endian dump where the bits in use tell: none in the lowest byte, or fewer
    beyond the board when the bytes are swapped."""
    per_byte = rises.reshape(4, 8) > 0
    swapped = per_byte[::-1].ravel()
    beyond = int((rises[n_diodes:] > 0).sum()), int(swapped[n_diodes:].sum())
    if (not per_byte[0].any() and per_byte[3].any()) or beyond[1] < beyond[0]:
        used = np.flatnonzero(rises)
        raise Refusal(
            f"{name}: a big-endian dump: light on bits {used[0]} to {used[-1]} of each word;"
            f" expected diodes from bit 0, little-endian"
        )


def _check_word_size(words: np.ndarray, length_s: np.ndarray, name: str) -> None:
    """Refuse words of 16 bits: read as 32, their halves are neighbours in time, so that they differ
    in single words, at edges, hardly ever in two running; and flashes look half as long."""
    long = length_s[length_s > SHORTEST_FLASH_S / 2]
    if not long.size or np.quantile(long, 0.1) >= SHORTEST_FLASH_S:
        return
    differing, runs = _differences(words)
    if differing <= LONGEST_RUN * runs:
        raise Refusal(
            f"{name}: a 16-bit dump: both halves of each word hold the same diodes;"
            " expected uint32 words"
        )


@njit
def _survey(words, idle):
    """Words that differ from the one before; rising edges and lit samples of each bit."""
    rises = np.zeros(32, np.int64)
    lit = np.zeros(32, np.int64)
    changing = 0
    before = words[0] ^ idle
    for bit in range(32):
        if before >> np.uint32(bit) & np.uint32(1):
            lit[bit] = words.size
    limit = words.size // 4  # random bytes need no exact count
    for i in range(1, words.size):
        word = words[i] ^ idle
        if word != before:
            changing += 1
            if changing > limit:
                return words.size, rises, lit
            edges = word ^ before
            for bit in range(32):
                if edges >> np.uint32(bit) & np.uint32(1):
                    if word >> np.uint32(bit) & np.uint32(1):
                        rises[bit] += 1
                        lit[bit] += words.size - i
                    else:
                        lit[bit] -= words.size - i
            before = word
    return changing, rises, lit


@njit
def _pulses(words, idle, n_rises):
    """First sample, samples and diode of each pulse by its start; 0 samples if it never ends."""
    start = np.empty(n_rises, np.int64)
    length = np.zeros(n_rises, np.int64)
    diode = np.empty(n_rises, np.int16)
    running = np.full(32, -1, np.int64)
    count = 0
    before = words[0] ^ idle
    for i in range(1, words.size):
        word = words[i] ^ idle
        if word != before:
            edges = word ^ before
            for bit in range(32):
                if edges >> np.uint32(bit) & np.uint32(1):
                    if word >> np.uint32(bit) & np.uint32(1):
                        running[bit] = count
                        start[count] = i
                        diode[count] = bit
                        count += 1
                    elif running[bit] >= 0:
                        length[running[bit]] = i - start[running[bit]]
            before = word
    return start, length, diode


@njit
def _differences(words):
    """Words whose halves of 16 bits differ, and runs of such words."""
    differing = 0
    runs = 0
    before = False
    for i in range(words.size):
        now = words[i] >> np.uint32(16) != words[i] & np.uint32(0xFFFF)
        if now:
            differing += 1
            if not before:
                runs += 1
        before = now
    return differing, runs


def warm_up() -> None:
    """Compile for read-only uint32 words."""
    words = np.array([0, 1, 0], dtype=np.uint32)
    words.flags.writeable = False
    _survey(words, np.uint32(0))
    _pulses(words, np.uint32(0), 1)
    _differences(words)
