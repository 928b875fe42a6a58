"""Calibration frames: against zlib, published values, random noise and real flashes."""

import itertools
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mocap_metrology.lighthouse.decode.chain import Decoded
from mocap_metrology.lighthouse.decode.factory_file import FACTORY_NAMES, NAMES_OF
from mocap_metrology.lighthouse.decode.libsurvive_solution import FROM_LIBSURVIVE, read_solution
from mocap_metrology.lighthouse.decode.ootx import (
    ACCEL_TO_STATION,
    accel_of,
    decode_station,
    encode_frame,
    frame_bits,
    frame_of,
)
from mocap_metrology.lighthouse.records import Clock, Factory, Flashes, Station
from mocap_metrology.lighthouse.timing import CYCLE_S

DUMP = 960  # cycles in 8 s
SOLUTION = "lighthouse/libsurvive_extras/lh1_test_cal.rec.gz.json"


def a_factory(rng: np.random.Generator) -> Factory:
    """Spread of the real stations, in half precision."""
    spread = ((0.028, 0.025), (-0.0024, 0.0043), (-0.002, 0.0043), (1.0, 2.0), (0.0, 0.01))
    return Factory(*(np.float16(rng.normal(m, s, 2)).astype(np.float64) for m, s in spread))


def flashes_of(
    bits: np.ndarray,
    start: int,
    n: int,
    rng: np.random.Generator,
    flipped: float = 0.0,
    missed: float = 0.0,
) -> Flashes:
    """Flashes that send `bits` over and over, some misread, some missed, some undecided."""
    cycle = np.arange(n)
    sent = bits[(start + cycle) % bits.size] ^ (rng.random(n) < flipped)
    code = np.where(rng.random(n) < missed / 2, -1, 2 * sent.astype(int) + cycle % 2)
    seen = rng.random(n) >= missed / 2
    cycle, code = cycle[seen].astype(np.int32), code[seen].astype(np.int8)
    clock = Clock(0.0, CYCLE_S, 0.0)
    return Flashes(0, clock, cycle, cycle * CYCLE_S, np.zeros(cycle.size), code)


def same(station: Station, factory: Factory) -> bool:
    return station.factory is not None and all(
        np.array_equal(getattr(station.factory, n), getattr(factory, n))
        for n in NAMES_OF[factory.generation]
    )


def test_frame_has_the_published_length_and_checksum() -> None:
    """LighthouseRedox: 33 bytes, padded, CRC32, a stuffing one after each 16 bits."""
    bits = encode_frame(Factory(), 0x4242089A, "b", unlock=7)
    assert bits.size == frame_bits(33) == 358
    assert bits[:18].tolist() == [0] * 17 + [1]
    words = bits[18:].reshape(-1, 17)
    assert (words[:, 16] == 1).all()
    body = np.packbits(words[:, :16]).tobytes()
    assert body[:2] == b"\x21\x00" and body[35] == 0
    assert body[36:] == zlib.crc32(body[2:35]).to_bytes(4, "little")
    assert body[4:8] == bytes.fromhex("9a084242")  # little-endian
    assert body[2] & 63 == 6 and body[2 + 0x0E] == 7 and body[2 + 0x1F] == 1
    assert body[2 + 0x20] == 0  # no faults


@given(
    start=st.integers(0, 357), seed=st.integers(0, 999), n=st.sampled_from((358, 716, DUMP)),
    up=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    mode=st.sampled_from("Abc"), firmware=st.integers(0, 1023),
)  # fmt: skip
def test_every_start_bit(start, seed, n, up, mode, firmware) -> None:
    """One frame's time, 2.98 s, is enough wherever it begins, and without a misread bit; the way up
    is known to the accelerometer's step."""
    rng = np.random.default_rng(seed)
    factory, id_, up = a_factory(rng), int(rng.integers(1 << 32)), np.array(up)
    frame = encode_frame(factory, id_, mode, accel_of(up), firmware=firmware, hardware=seed % 256)
    station = decode_station(flashes_of(frame, start, n, rng))
    assert same(station, factory) and (station.id, station.mode) == (id_, mode)
    assert (station.firmware, station.hardware) == (firmware, seed % 256)
    assert station.frames_found in ((1,) if n == 358 else (1, 2))
    assert station.gravity @ up / np.linalg.norm(up) > np.cos(np.radians(0.5))


def turned(bits: np.ndarray, positions: object) -> np.ndarray:
    bits = bits.copy()
    bits[positions] ^= 1
    return bits


SENT = encode_frame(a_factory(np.random.default_rng(4)), 77, "A")
EIGHT = [60, 90, 115, 140, 165, 190, 215, 240]  # in every repetition: votes agree, the CRC does not
WILD = {"phase": 0.31, "tilt": -0.31, "curve": 0.11, "gibphase": 7.1, "gibmag": -0.31}
NOT_READ = {
    "checksum": (turned(SENT, EIGHT), 960, "the checksum is wrong"),
    "stuffing": (turned(SENT, [*EIGHT, 18 + 5 * 17 + 16]), 960, "a stuffing bit is wrong"),
    "length": (turned(SENT, [*EIGHT, 18 + 15]), 960, "the length of the payload is not 33 or"),
    "cut off": (SENT, 340, "the recording shows less than one, of 341 bits"),
    "no sync": (np.ones(358, int), 960, "no sync of 17 zeros and a one"),
    **{f"{n} flashes": (np.zeros(358, int), n, f"{n} bits") for n in (0, 5, 100)},
    **{name: (encode_frame(Factory(**{name: np.array([0.0, v])}), 1, "A"), 960, f"{name} is [0.0, ")
       for name, v in WILD.items()},
}  # fmt: skip


@pytest.mark.parametrize("case", NOT_READ)
def test_what_is_not_read_and_why(case: str) -> None:
    bits, n, why = NOT_READ[case]
    station = decode_station(flashes_of(bits, 0, n, np.random.default_rng(0)))
    assert station.factory is None and station.id is None and station.frames_found == 0
    assert why in station.why and "\n" not in station.why


@pytest.mark.parametrize("position", [5, 17, 18 + 15, 18 + 16, 18 + 19 * 17 + 16])
def test_a_wrong_bit_of_sync_length_or_stuffing_is_outvoted(position: int) -> None:
    """These are known beforehand; the whole frame is not, so that one voted frame is found."""
    station = decode_station(flashes_of(turned(SENT, position), 0, 960, np.random.default_rng(0)))
    assert station.id == 77 and station.frames_found == 1


def test_fourteen_bits_that_no_repetition_shows_are_tried() -> None:
    """All 2^14 readings: the padding beside them, which is not seen either, is known."""
    rng = np.random.default_rng(5)
    payload = [place for place in range(40, 280) if (place - 18) % 17 != 16]
    hidden = [*range(SENT.size - 43, SENT.size - 35), *rng.choice(payload, 14, replace=False)]
    seen = flashes_of(SENT, 0, 960, rng)
    code = np.where(np.isin(seen.cycle % SENT.size, hidden), -1, seen.code).astype(np.int8)
    assert decode_station(replace(seen, code=code)).id == 77


@pytest.mark.parametrize(
    ("flipped", "missed", "least"), [(0.0, 0.03, 1.0), (0.01, 0.02, 0.95), (0.03, 0.03, 0.6)]
)
def test_votes_over_8_s(flipped: float, missed: float, least: float) -> None:
    """Share of dumps that are read: 100 %, 98-100 % and about 80 %; never a wrong one."""
    rng = np.random.default_rng(1)
    read = 0
    for _ in range(24):
        factory = a_factory(rng)
        frame = encode_frame(factory, int(rng.integers(1 << 32)), "b", (10, 127, 7))
        station = decode_station(
            flashes_of(frame, int(rng.integers(358)), DUMP, rng, flipped, missed)
        )
        assert station.factory is None or same(station, factory)
        assert (station.factory is None) == bool(station.why)
        read += station.factory is not None
    assert read >= 24 * least


def test_older_protocol_has_no_mode() -> None:
    data = bytearray(31)
    data[0], data[2] = 5, 9
    bits = frame_of(bytes(data))
    assert bits.size == frame_bits(31) == 341
    station = decode_station(flashes_of(bits, 3, 700, np.random.default_rng(0), 0.0, 0.01))
    assert station.id == 9 and station.mode is None and station.factory is not None
    assert station.gravity is None


@pytest.mark.parametrize("name", ["HMD", "T20"])
def test_real_stations_have_the_values_libsurvive_found(
    headset: dict[str, Decoded], name: str, samples: Path
) -> None:
    """Both stations, from headset and controller; the file prints six decimals."""
    solution = {s.index: s for s in read_solution(samples / SOLUTION)}
    real = headset[name].stations
    assert len(real) == 2
    for station, index, role, mode in zip(real, (1, 0), ("master", "slave"), "bA", strict=True):
        truth = solution[index]
        assert (station.role, station.id, station.mode) == (role, truth.id, mode)
        for value in FACTORY_NAMES:
            error = getattr(station.factory, value) - getattr(truth.factory, value)
            assert np.abs(error).max() <= 0.5001e-6, value


def test_real_accelerometers_agree_with_the_poses(
    headset: dict[str, Decoded], samples: Path
) -> None:
    """Of 48 signed permutations of axes, the used one fits libsurvive's poses best: 2.1, 1.1 deg.

    Its world is level only as well as the headset's own accelerometer.
    """
    solution = {s.id: s for s in read_solution(samples / SOLUTION)}
    read = headset["HMD"].stations
    up = [
        FROM_LIBSURVIVE @ solution[s.id].pose[0][2] for s in read
    ]  # world z in the station's frame
    raw = [ACCEL_TO_STATION.T @ s.gravity for s in read]
    worst = {}
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            mapped = np.zeros((3, 3))
            mapped[range(3), order] = signs
            angles = [np.degrees(np.arccos(u @ mapped @ r)) for u, r in zip(up, raw, strict=True)]
            worst[order, signs] = max(angles)
    rows = [int(np.flatnonzero(row)[0]) for row in ACCEL_TO_STATION]
    used = (tuple(rows), tuple(ACCEL_TO_STATION.sum(axis=1)))
    assert min(worst, key=worst.__getitem__) == used
    assert worst[used] < 2.2
