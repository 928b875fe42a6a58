"""Dumps: edges against a plain reading of each bit, and what is refused by name."""

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.dump import check_byte_order, pulses_of_words, read_dump
from mocap_metrology.lighthouse.decode.flashes import find_flashes, find_hits
from mocap_metrology.lighthouse.records import Hits

from . import synthetic
from .synthetic import BOARD, Scene


@pytest.fixture(scope="module")
def words() -> np.ndarray:
    return Scene().build().words()


def plain(words: np.ndarray) -> set[tuple[int, int, int]]:
    """Pulses (first sample, samples, diode) that are whole, bit by bit."""
    found = set()
    for bit in range(32):
        lit = (words >> bit & 1).astype(int)
        edges = np.flatnonzero(np.diff(lit)) + 1
        rising = [int(e) for e in edges if lit[e]]
        falling = [int(e) for e in edges if not lit[e]]
        for start in rising:
            ends = [e for e in falling if e > start]
            if ends:
                found.add((start, ends[0] - start, bit))
    return found


@pytest.mark.parametrize("active_level", [0, 1])
def test_edges_of_every_bit(active_level: int) -> None:
    rng = np.random.default_rng(3)
    words = np.repeat(rng.integers(0, 2**32, 60, dtype=np.uint32), rng.integers(9, 60, 60))
    words &= np.repeat(rng.integers(0, 2**32, 60, dtype=np.uint32), 60)[: words.size]
    words &= np.repeat(rng.integers(0, 2**32, 80, dtype=np.uint32), 40)[: words.size]
    stored = words if active_level else ~words
    pulses = pulses_of_words(stored, sample_rate_hz=1000, active_level=active_level)
    found = {
        (round(s * 1000), round(n * 1000), int(d))
        for s, n, d in zip(pulses.start_s, pulses.length_s, pulses.diode, strict=True)
    }
    assert found == plain(words)
    assert (np.diff(pulses.start_s) >= 0).all()
    assert pulses.duration_s == words.size / 1000


def test_pulses_cut_by_the_ends_are_left_out() -> None:
    words = np.zeros(1000, np.uint32)
    words[0] = 8  # ends with the second sample
    words[1] = 16  # which another begins with
    words[:100] |= 1
    words[500:502] = 2
    words[600] = 4
    words[900:] = 1
    pulses = pulses_of_words(words, sample_rate_hz=1000)
    assert pulses.start_s.tolist() == [0.001, 0.5, 0.6]
    assert pulses.length_s.tolist() == [0.001, 0.002, 0.001]
    assert pulses.diode.tolist() == [4, 1, 2]


def write(tmp_path, data: bytes):
    path = tmp_path / "dump.bin"
    path.write_bytes(data)
    return path


def test_not_whole_words(tmp_path) -> None:
    with pytest.raises(Refusal, match="not a whole number of uint32 words"):
        read_dump(write(tmp_path, bytes(4_000_001)))
    with pytest.raises(Refusal, match="empty"):
        read_dump(write(tmp_path, b""))
    with pytest.raises(Refusal, match="cannot be read"):
        read_dump(tmp_path / "absent.bin")


@pytest.mark.parametrize("n_words, fits", [(999, 0), (1000, 1), (120_000, 1), (120_001, 0)])
def test_length(n_words: int, fits: bool) -> None:
    with pytest.raises(Refusal, match="no light" if fits else r"expected 0\.5 to 60 s"):
        pulses_of_words(np.zeros(n_words, np.uint32), sample_rate_hz=2000)


def test_random_bytes(tmp_path) -> None:
    data = np.random.default_rng(0).bytes(8_000_000)
    with pytest.raises(Refusal, match="expected a dump of photodiodes"):
        read_dump(write(tmp_path, data))


@pytest.mark.parametrize(("stored", "asked"), [(0, 1), (1, 0)])
def test_inverted_level(words: np.ndarray, stored: int, asked: int) -> None:
    with pytest.raises(Refusal, match=rf"lit 9\d % .* inverted; .* active_level {stored}"):
        pulses_of_words(words if stored else ~words, active_level=asked)


def test_big_endian_told_by_unused_bits(words: np.ndarray) -> None:
    few = words & 0xFFFFFF
    assert (
        pulses_of_words(few).notes[1] == f"no light on diodes {', '.join(map(str, range(24, 32)))}"
    )
    with pytest.raises(Refusal, match="big-endian dump: light on bits 8 to 31"):
        pulses_of_words(few.byteswap())


@pytest.mark.parametrize("mask", [0xFFFF, 0x3FF])
def test_sixteen_bits(words: np.ndarray, mask: int) -> None:
    halves = (np.concatenate([words, words]) & mask).astype("<u2")
    with pytest.raises(Refusal, match="16-bit"):
        pulses_of_words(halves.view("<u4"))


def hits_of(words: np.ndarray) -> Hits:
    pulses = pulses_of_words(words)
    return find_hits(pulses, find_flashes(pulses))[0]


@pytest.mark.parametrize("uneven", [False, True])
def test_byte_order_from_the_geometry(monkeypatch, uneven: bool) -> None:
    """A grid, whose rows swap to its mirror image, and diodes strewn about."""
    rng = np.random.default_rng(1)
    board = BOARD + uneven * 0.03 * rng.normal(size=BOARD.shape)
    monkeypatch.setattr(synthetic, "BOARD", board)
    words = Scene().build().words()
    check_byte_order(hits_of(words), board, "dump.bin")
    with pytest.raises(Refusal, match=r"dump\.bin: .*big-endian|dump\.bin: .*bytes swapped"):
        check_byte_order(hits_of(words.byteswap()), board, "dump.bin")


def test_boards_of_fewer_diodes_are_not_judged(words: np.ndarray) -> None:
    hits = hits_of(words)
    check_byte_order(hits.take(hits.diode < 24), BOARD[:24], "dump.bin")
    check_byte_order(hits.take(hits.diode < 2), BOARD, "dump.bin")
