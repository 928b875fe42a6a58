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

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import Hits, Pulses, is_new

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
    path: str | Path, sample_rate_hz: float = SAMPLE_RATE_HZ, active_level: int = 1
) -> Pulses:
    """Pulses of a dump file; see `pulses_of_words`. Raises `Refusal` where it is no such dump."""
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
    return pulses_of_words(words, sample_rate_hz, active_level, path.name)


def pulses_of_words(
    words: np.ndarray,
    sample_rate_hz: float = SAMPLE_RATE_HZ,
    active_level: int = 1,
    name: str = "dump",
) -> Pulses:
    """Pulses of a dump in memory, words (n,) uint32; active_level: the bit that means light. Pulses
    on at the first or last sample are dropped."""
    duration_s = words.size / sample_rate_hz
    if not SHORTEST_S <= duration_s <= LONGEST_S:
        raise Refusal(
            f"{name}: {duration_s:g} s ({words.size} words at {sample_rate_hz:g} Hz);"
            f" expected {SHORTEST_S:g} to {LONGEST_S:g} s"
        )
    words = np.asarray(words, np.uint32)
    changes = np.flatnonzero(words[1:] != words[:-1]) + 1
    if not changes.size:
        raise Refusal(f"{name}: no light: every word is 0x{int(words[0]):08x}; expected flashes")
    if changes.size > CHANGING_SHARE * words.size:
        raise Refusal(
            f"{name}: {100 * changes.size / words.size:.0f} % of the words differ from the previous"
            " one; expected a dump of photodiodes, where it is about 1 %"
        )
    flips = words[changes] ^ words[changes - 1]
    parts = []
    rises, lit = np.zeros(BITS, np.int64), np.zeros(BITS, np.int64)
    for bit in range(BITS):
        at = changes[flips >> np.uint32(bit) & 1 == 1]
        if at.size:  # edges of a diode alternate: what begins with one ends with the next
            begins = (words[at] >> np.uint32(bit) & 1) == active_level
            rises[bit] = np.count_nonzero(begins)
            to_end = words.size - at
            lit[bit] = to_end[begins].sum() - to_end[~begins].sum()
            lit[bit] += 0 if begins[0] else words.size
            whole = begins[:-1]
            parts.append((at[:-1][whole], at[1:][whole], np.full(whole.sum(), bit, np.int16)))
    _check_light(rises, lit / words.size, active_level, name)
    start, end, diode = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(start, kind="stable")
    length_s = (end - start)[order] / sample_rate_hz
    _check_word_size(words, length_s, name)
    notes = []
    if words.size not in USUAL_WORDS:
        notes.append(f"{duration_s:.6g} s long; a dump is usually 8 s or 8.389 s")
    dark = np.flatnonzero(rises == 0)
    if dark.size:
        notes.append(f"no light on diodes {', '.join(map(str, dark))}")
    return Pulses(
        start_s=start[order] / sample_rate_hz,
        length_s=length_s,
        diode=diode[order],
        n_diodes=BITS,
        duration_s=duration_s,
        resolution_s=1 / sample_rate_hz,
        notes=tuple(notes),
    )


def _check_light(rises: np.ndarray, lit: np.ndarray, active_level: int, name: str) -> None:
    """Refuse an inverted level, and swapped bytes where none of the lowest is in use, from the
    rising edges of each bit and the share of the time that it is lit."""
    share = float(np.median(lit[rises > 0])) if rises.any() else 1.0
    if share > LIT_SHARE:
        raise Refusal(
            f"{name}: diodes are lit {100 * share:.0f} % of the time: the level is inverted;"
            f" expected active_level {1 - active_level}"
        )
    if not rises[:8].any() and rises[24:].any():
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
    differ = words >> np.uint32(16) != words & np.uint32(0xFFFF)
    runs = np.count_nonzero(differ[1:] & ~differ[:-1]) + int(differ[0])
    if np.count_nonzero(differ) <= LONGEST_RUN * runs:
        raise Refusal(
            f"{name}: a 16-bit dump: both halves of each word contain the same diodes; expected "
            "uint32 words"
        )


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
    (rms, turned), (rms_swapped, turned_swapped) = (
        _fits(hits, sweeps, places) for places in (board, board[SWAPPED])
    )
    misfit, misfit_swapped = (float(np.quantile(one, CALM)) for one in (rms, rms_swapped))
    if misfit > MISFIT_RAD and misfit_swapped < BETTER * misfit:
        raise Refusal(
            f"{name}: the sweeps fit the board to {1e3 * misfit:.1f} mrad as read, to"
            f" {1e3 * misfit_swapped:.1f} mrad with the bytes swapped; expected little-endian"
            " words, and a board file in the order of the diodes"
        )
    mirrored = turned.size and turned.mean() > AGREE and turned_swapped.mean() < 1 - AGREE
    if np.ptp(board[:, 0]) < 1e-6 and BETTER * misfit_swapped < misfit and mirrored:
        raise Refusal(
            f"{name}: the stations see the mirror image of the board: in the board file a"
            " coordinate has the wrong sign, two columns are exchanged or the diodes are in"
            " another order, or the words of the dump are big-endian; expected a board that"
            " faces +x, and little-endian words"
        )


def _full_sweeps(hits: Hits) -> list[np.ndarray]:
    """Indices of the hits of sweeps with enough of them, in order of time, evenly chosen pairs."""
    order = np.lexsort((hits.cycle, hits.station))
    first = np.flatnonzero(is_new(hits.cycle[order], hits.station[order]))
    sweeps = [one for one in np.split(order, first[1:]) if one.size >= ENOUGH_HITS]
    step = max(1, 2 * len(sweeps) // ENOUGH_SWEEPS)
    return [one for k, one in enumerate(sweeps) if k // 2 % step == 0]


def _fits(hits: Hits, sweeps: list[np.ndarray], board: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rms in rad of the affine fits of sweeps; and of each azimuth sweep that an elevation sweep of
    the station follows, whether both turn the board's y, z the wrong way: from the front, azimuth
    falls along y and elevation rises along z, the determinant of the gradients is negative."""
    fits = []
    for one in sweeps:
        design = np.column_stack([np.ones(one.size), board[hits.diode[one]]])
        solution, *_ = np.linalg.lstsq(design, hits.angle_rad[one], rcond=1e-9)
        rms = np.sqrt(np.mean((hits.angle_rad[one] - design @ solution) ** 2))
        fits.append(np.r_[rms, solution[1:]])
    rms, _, y, z = np.transpose(fits)
    station, axis, cycle = (
        x[[one[0] for one in sweeps]] for x in (hits.station, hits.axis, hits.cycle)
    )
    pair = (np.diff(station) == 0) & (np.diff(cycle) == 1) & (np.diff(axis) == 1)
    return rms, (y[:-1] * z[1:] - z[:-1] * y[1:] > 0)[pair]
