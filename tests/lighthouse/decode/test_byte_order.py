"""Byte order of a full dump: told from the geometry, in words of the whole chain."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.dump import check_byte_order, pulses_of_words
from mocap_metrology.lighthouse.decode.flashes import find_flashes
from mocap_metrology.lighthouse.decode.sweeps import find_hits
from mocap_metrology.lighthouse.records import Hits

from . import synthetic
from .synthetic import BOARD, Scene


def hits_of(words: np.ndarray) -> Hits:
    pulses = pulses_of_words(words)
    return find_hits(pulses, find_flashes(pulses))[0]


@pytest.mark.parametrize("uneven", [False, True])
def test_byte_order(monkeypatch, uneven: bool) -> None:
    """A grid, whose rows swap to its mirror image, and diodes strewn about."""
    rng = np.random.default_rng(1)
    board = BOARD + uneven * 0.03 * rng.normal(size=BOARD.shape)
    monkeypatch.setattr(synthetic, "BOARD", board)
    words = Scene().build().words()
    check_byte_order(hits_of(words), board, "dump.bin")
    with pytest.raises(Refusal, match=r"dump\.bin: .*big-endian|dump\.bin: .*bytes swapped"):
        check_byte_order(hits_of(words.byteswap()), board, "dump.bin")


def test_boards_of_fewer_diodes_are_not_judged() -> None:
    hits = hits_of(Scene().build().words())
    check_byte_order(hits.take(hits.diode < 24), BOARD[:24], "dump.bin")
    check_byte_order(hits.take(hits.diode < 2), BOARD, "dump.bin")
