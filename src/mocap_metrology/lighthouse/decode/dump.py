"""A logic dump of photodiodes: words -> pulses.

A dump is whole little-endian uint32 words, one a sample; bit i is diode i. A pulse begins at the
first sample that is lit and ends at the first that is not, so both edges come late by half a sample
on average: the middle of a pulse and the edge of a flash share that, and it cancels in angles.

A dump of 32 diodes with its bytes swapped looks whole: its bits are in use all the same, and only
the geometry of the hits decides (`check_byte_order`).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import Hits, Pulses

SAMPLE_RATE_HZ = 2e6
BITS = 32
SHORTEST_S, LONGEST_S = 0.5, 60.0
USUAL_WORDS = (16_000_000, 16_777_216)  # 8 s, and the whole memory of J's board
CHANGING_SHARE = 0.1  # of the words: a dump of two stations has about 0.01, random bytes 1
LIT_SHARE = 0.5  # of the time: a diode is lit 0.03 of it
SHORTEST_FLASH_S = 2250 / 48e6
LONGEST_RUN = 1.5  # words, on average; a pulse two samples wide gives 2
SWAPPED = np.arange(32).reshape(4, 8)[::-1].ravel()  # true diode of each bit of swapped words
ENOUGH_HITS = 8  # of a sweep that an affine fit can fail to meet
ENOUGH_SWEEPS = 120  # of a recording; more only cost time
CALM = 0.2  # quantile over sweeps: that many have no outlier
MISFIT_RAD = 2e-3  # of a right board; beyond, another order is looked at
BETTER = 0.3  # misfit of the swapped order over that as read, from which it is believed
AGREE = 0.8  # share of sweeps that see the board from one side


def read_dump(
    path: str | Path,
    sample_rate_hz: float = SAMPLE_RATE_HZ,
    active_level: int = 1,
    n_diodes: int | None = None,
) -> Pulses:
    """Pulses of a dump file; see `pulses_of_words`.

    Raises `Refusal` where the file is no such dump; big-endian and 16-bit dumps and an inverted
    level are named. With all 32 bits in use the byte order shows only in the geometry: see
    `check_byte_order`.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        if size == 0:
            raise Refusal(f"{path.name}: empty file; expected uint32 words")
        if size % 4:
            raise Refusal(
                f"{path.name}: {size} bytes are not a whole number of uint32 words (4 bytes)"
            )
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
        raise Refusal(f"{name}: {n_diodes} diodes; a uint32 dump contains 1 to {BITS}")
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
    _check_bits_in_use(rises, n_diodes, name)
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
        notes.append(f"light on bits {', '.join(map(str, above))}, beyond the board: ignored")
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
            f"{name}: {100 * changing / words.size:.0f} % of the words differ from the previous "
            "one; expected a dump of photodiodes, where it is about 1 %"
        )
    share = float(np.median(lit[rises > 0])) / words.size if rises.any() else 1.0
    if share > LIT_SHARE:
        raise Refusal(
            f"{name}: diodes are lit {100 * share:.0f} % of the time: the level is inverted;"
            f" expected active_level {1 - active_level}"
        )


def _check_bits_in_use(rises: np.ndarray, n_diodes: int, name: str) -> None:
    """Refuse a big-endian dump where the bits in use show it: none in the lowest byte, or fewer
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
            f"{name}: a 16-bit dump: both halves of each word contain the same diodes; expected "
            "uint32 words"
        )


@njit
def _survey(words: np.ndarray, idle: np.uint32) -> tuple[int, np.ndarray, np.ndarray]:
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
def _pulses(
    words: np.ndarray, idle: np.uint32, n_rises: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
def _differences(words: np.ndarray) -> tuple[int, int]:
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


def check_byte_order(hits: Hits, board: np.ndarray, name: str) -> None:
    """Refuse hits that fit the board only when the bytes of the words are swapped.

    An angle is nearly an affine function of the diodes' places within a sweep. Where both orders
    fit alike, as on a grid of 8 by 4, the swapped one is the mirror image: the board would be seen
    from behind. That is detected for flat boards in the plane x = const, which by convention face
    along +x.
    """
    if len(board) != SWAPPED.size:
        return
    sweeps = _full_sweeps(hits)
    if len(sweeps) < 8:
        return
    as_read = [_fit(hits, one, board) for one in sweeps]
    swapped = [_fit(hits, one, board[SWAPPED]) for one in sweeps]
    misfit, misfit_swapped = (
        float(np.quantile([rms for rms, _ in fits], CALM)) for fits in (as_read, swapped)
    )
    if misfit > MISFIT_RAD and misfit_swapped < BETTER * misfit:
        raise Refusal(
            f"{name}: the sweeps fit the board to {1e3 * misfit:.1f} mrad as read, to"
            f" {1e3 * misfit_swapped:.1f} mrad with the bytes swapped; expected little-endian"
            " words, and a board file in the order of the diodes"
        )
    if np.ptp(board[:, 0]) < 1e-6 and BETTER * misfit_swapped < misfit:
        behind = _share_from_behind(hits, sweeps, as_read)
        behind_swapped = _share_from_behind(hits, sweeps, swapped)
        if behind > AGREE and behind_swapped < 1 - AGREE:
            raise Refusal(
                f"{name}: the stations see the mirror image of the board: in the board file a"
                " coordinate has the wrong sign, two columns are exchanged or the diodes are in"
                " another order, or the words of the dump are big-endian; expected a board that"
                " faces +x, and little-endian words"
            )


def _full_sweeps(hits: Hits) -> list[np.ndarray]:
    """Indices of the hits of sweeps with enough of them, in order of time, evenly chosen pairs."""
    order = np.lexsort((hits.cycle, hits.station))
    new = (np.diff(hits.cycle[order], prepend=-1) != 0) | (
        np.diff(hits.station[order], prepend=-1) != 0
    )
    sweeps = np.split(order, np.flatnonzero(new)[1:]) if order.size else []
    sweeps = [one for one in sweeps if one.size >= ENOUGH_HITS]
    step = max(1, 2 * len(sweeps) // ENOUGH_SWEEPS)
    return [one for k, one in enumerate(sweeps) if k // 2 % step == 0]


def _fit(hits: Hits, one: np.ndarray, board: np.ndarray) -> tuple[float, np.ndarray]:
    """Rms in rad and gradient of the affine fit of a sweep."""
    design = np.column_stack([np.ones(one.size), board[hits.diode[one]]])
    angle = hits.angle_rad[one]
    solution, *_ = np.linalg.lstsq(design, angle, rcond=1e-9)
    return float(np.sqrt(np.mean((angle - design @ solution) ** 2))), solution[1:]


def _share_from_behind(
    hits: Hits, sweeps: list[np.ndarray], fits: list[tuple[float, np.ndarray]]
) -> float:
    """Share of azimuth and elevation sweeps running that turn the board's y, z the wrong way.

    From the front, azimuth falls along y and elevation rises along z: the determinant of the two
    gradients is negative.
    """
    wrong = []
    for k in range(len(sweeps) - 1):
        a, b = sweeps[k][0], sweeps[k + 1][0]
        if (
            hits.station[a] == hits.station[b]
            and hits.cycle[b] - hits.cycle[a] == 1
            and (hits.axis[a], hits.axis[b]) == (0, 1)
        ):
            azimuth, elevation = fits[k][1], fits[k + 1][1]
            wrong.append(azimuth[1] * elevation[2] - azimuth[2] * elevation[1] > 0)
    return float(np.mean(wrong)) if wrong else 0.5
