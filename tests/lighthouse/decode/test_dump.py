"""Dumps: edges against a plain reading of each bit, and what is refused by name."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.dump import pulses_of_words, read_dump

from .synthetic import Scene


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
    words[:100] = 1
    words[500:502] = 2
    words[600] = 4
    words[900:] = 1
    pulses = pulses_of_words(words, sample_rate_hz=1000)
    assert pulses.start_s.tolist() == [0.5, 0.6]
    assert pulses.length_s.tolist() == [0.002, 0.001]
    assert pulses.diode.tolist() == [1, 2]


def test_scene_from_file(tmp_path, words: np.ndarray) -> None:
    path = tmp_path / "dump.bin"
    words.astype("<u4").tofile(path)
    pulses, expected = read_dump(path), Scene().build().pulses()
    order = np.lexsort((pulses.diode, pulses.start_s))
    np.testing.assert_array_equal(pulses.start_s[order], expected.start_s)
    np.testing.assert_array_equal(pulses.length_s[order], expected.length_s)
    assert pulses.notes == ("2 s long; a dump is usually 8 s or 8.389 s",)


@pytest.mark.parametrize("n_words", [16_000_000, 16_777_216])
def test_usual_lengths_need_no_note(n_words: int) -> None:
    words = np.zeros(n_words, np.uint32)
    words[n_words - 300 : n_words - 100] = 0xFFFFFFFF
    pulses = pulses_of_words(words)
    assert pulses.notes == ()
    assert pulses.duration_s == n_words / 2e6
    np.testing.assert_allclose(pulses.start_s, (n_words - 300) / 2e6)


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


@pytest.mark.parametrize("n_words", [900_000, 121_000_000])
def test_length(n_words: int) -> None:
    with pytest.raises(Refusal, match=r"expected 0\.5 to 60 s"):
        pulses_of_words(np.broadcast_to(np.uint32(0), n_words))


@pytest.mark.parametrize("word", [0, 0xFFFFFFFF, 5])
def test_no_light(word: int) -> None:
    with pytest.raises(Refusal, match="no light"):
        pulses_of_words(np.full(2_000_000, word, np.uint32))


def test_random_bytes(tmp_path) -> None:
    data = np.random.default_rng(0).bytes(8_000_000)
    with pytest.raises(Refusal, match="expected a dump of photodiodes"):
        read_dump(write(tmp_path, data))


@pytest.mark.parametrize(("stored", "asked"), [(0, 1), (1, 0)])
def test_inverted_level(words: np.ndarray, stored: int, asked: int) -> None:
    with pytest.raises(Refusal, match=f"inverted; expected active_level {stored}"):
        pulses_of_words(words if stored else ~words, active_level=asked)


def test_big_endian_told_by_unused_bits(words: np.ndarray) -> None:
    swapped = (words & 0xFFFFFF).byteswap()
    for n_diodes in (None, 24):
        with pytest.raises(Refusal, match="big-endian"):
            pulses_of_words(swapped, n_diodes=n_diodes)


@pytest.mark.parametrize("mask", [0xFFFF, 0x3FF])
def test_sixteen_bits(words: np.ndarray, mask: int) -> None:
    halves = (np.concatenate([words, words]) & mask).astype("<u2")
    with pytest.raises(Refusal, match="16-bit"):
        pulses_of_words(halves.view("<u4"))


def test_light_beyond_the_board_is_left_out_and_said(words: np.ndarray) -> None:
    pulses = pulses_of_words(words, n_diodes=31)
    assert pulses.diode.max() == 30
    assert any("bits 31, beyond the board" in note for note in pulses.notes)
