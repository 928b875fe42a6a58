"""The dump of a twin: 2 million words of 32 bit a second, bit d set where diode d sees light."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.files import whole
from mocap_metrology.lighthouse.records import Pulses

SAMPLES_PER_S = 2_000_000


def words_of(pulses: Pulses) -> np.ndarray:
    """Samples k at k/2e6 s, uint32 (duration * 2e6,): bit d is set where start <= t < start +
    length of a pulse on diode d, so that an edge is seen at the next sample. Pulses that overlap
    merge; what lies before or after the recording is cut off."""
    words = np.zeros(round(pulses.duration_s * SAMPLES_PER_S), dtype=np.uint32)
    _set_bits(words, pulses.start_s, pulses.length_s, pulses.diode.astype(np.int64))
    return words


def write_dump(path: str | Path, pulses: Pulses) -> None:
    """Write the words as a raw dump, little-endian, whole or not at all."""
    words = words_of(pulses).astype("<u4", copy=False)
    with whole(path) as part:
        words.tofile(part)


@njit
def _set_bits(
    words: np.ndarray, start_s: np.ndarray, length_s: np.ndarray, diode: np.ndarray
) -> None:
    for i in range(start_s.size):
        first = max(math.ceil(start_s[i] * SAMPLES_PER_S), 0)
        end = min(math.ceil((start_s[i] + length_s[i]) * SAMPLES_PER_S), words.size)
        bit = np.uint32(1) << np.uint32(diode[i])
        for k in range(first, end):
            words[k] |= bit


def warm_up() -> None:
    """Compile the kernel."""
    one = np.array([0.0])
    words_of(Pulses(one, one, np.array([0], dtype=np.int16), 1, 1e-6, 0.0))
