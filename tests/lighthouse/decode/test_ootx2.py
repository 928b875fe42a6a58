"""Calibration of second-generation stations: frames of real recordings against the values that
libsurvive stored beside them, and damaged streams, which must give the truth or nothing."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.decode.factory_file import NAMES_OF, read_factory
from mocap_metrology.lighthouse.decode.turns import (
    Turns,
    decode_turns,
    encode_frame2,
    find_turns,
    unpack,
)
from mocap_metrology.lighthouse.decode.wander import Delay, TurnClock
from mocap_metrology.lighthouse.published import FACTORY2_MEAN, FACTORY2_SD
from mocap_metrology.lighthouse.records import Factory
from tests.lighthouse.decode.test_ootx import same

NAMES = NAMES_OF[2]
READ = {  # recording, object: channels with a readable frame; those of 12 s by vote alone
    ("lh2_test_cal", "T20"): [6, 10],
    ("tracker-cal-attempt", "WM0"): [0, 3, 7, 11],
    ("haagh-tracking2", "KN1"): [2, 8],
    ("index-yank-up-down", "T20"): [],  # 7 s
}


def a_factory(rng: np.random.Generator) -> Factory:
    """Values of a station as usual, as half floats."""
    drawn = {
        name: rng.normal(FACTORY2_MEAN[name], FACTORY2_SD[name]).astype(np.float16).astype(float)
        for name in NAMES
    }
    return Factory(**drawn, generation=2)


@pytest.mark.parametrize(("file", "name"), READ)
def test_frames_of_real_recordings(samples: Path, light_of: Callable, file: str, name: str) -> None:
    """Values as libsurvive printed them, with 6 digits or more; up is up to 40 deg."""
    stations = [decode_turns(turns) for turns in find_turns(light_of(file, name))[0]]
    assert [one.channel for one in stations if one.factory is not None] == READ[file, name]
    filed = {one.channel: one for one in read_factory(samples / f"lighthouse2/{file}.rec.gz.json")}
    for station in stations:
        if station.factory is None:
            assert "no calibration frame" in station.why
            continue
        other = filed[station.channel]
        assert station.id == other.id and station.gravity[2] > 0.75
        for value in NAMES:
            pair = getattr(station.factory, value), getattr(other.factory, value)
            assert np.abs(pair[0] - pair[1]).max() < 6e-7


def test_values_of_a_file_where_no_frame_is_in_the_recording(samples: Path) -> None:
    path = samples / "lighthouse2/index-yank-up-down.rec.gz"
    assert decode(path, "libsurvive-rec", "T20").stations[0].factory is None
    found = decode(path, "libsurvive-rec", "T20", f"{path}.json")
    assert [one.id for one in found.stations] == [3651042988, 4261648623]
    assert same(found.stations[1], read_factory(f"{path}.json")[1].factory)
    older = samples / "lighthouse/libsurvive_extras/lh1_test_cal.rec.gz.json"
    with pytest.raises(Refusal, match="of generation 1; the recording is of generation 2"):
        decode(path, "libsurvive-rec", "T20", older)


def turns_of(bits: np.ndarray, rng: np.random.Generator, lost: float, wrong: float) -> Turns:
    """Turns of channel 5 that carry these bits, some of them lost or misread."""
    kept = np.flatnonzero(rng.random(bits.size) >= lost)
    read = bits[kept] ^ (rng.random(kept.size) < wrong)
    clock, late = TurnClock(0.0, 0.0196, 0.0, *np.zeros(4)), Delay(0, np.zeros(2))
    return Turns(5, clock, kept, late, read.astype(np.int8))


def test_damaged_streams_give_the_truth_or_nothing() -> None:
    """20 to 60 s, begun anywhere, 0 to 20 % lost, 0 to 3 % misread."""
    rng = np.random.default_rng(4)
    read = 0
    for _ in range(40):
        factory = a_factory(rng)
        sent = np.roll(np.tile(encode_frame2(factory, 77, 5, (0, 127, 0)), 8), rng.integers(443))
        lost, wrong = rng.uniform(0, 0.2), rng.choice([0.0, 0.03])
        station = decode_turns(turns_of(sent[: rng.integers(1000, 3000)], rng, lost, wrong))
        if station.factory is not None:
            assert same(station, factory) and station.id == 77 and station.channel == 5
            read += 1
    assert read > 20


@pytest.mark.parametrize(("at", "message"), [(0, "protocol"), (0x1F, "channel"), (0x10, "curve")])
def test_values_that_no_station_has(at: int, message: str) -> None:
    data = bytearray(43)
    data[0], data[0x1F] = 8, 0x80
    assert unpack(bytes(data)).channel == 0
    data[at : at + 2] = b"\x21\x7b"
    with pytest.raises(Refusal, match=message):
        unpack(bytes(data))
