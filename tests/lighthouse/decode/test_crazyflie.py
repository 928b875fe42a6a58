"""Frames of a Crazyflie's lighthouse deck, made byte by byte of a simulated recording as the deck
documents them: decoded to the angles that the model gives."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.decode.crazyflie import PERIOD_S, _continuous, _light
from mocap_metrology.lighthouse.simulate.turns import TurnsTwin, simulate_turns, stations_around
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from tests.lighthouse.simulate.test_turns import residuals

DECK = np.array([[x, y, 0.0] for x in (-0.015, 0.015) for y in (-0.0075, 0.0075)])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))
VARIABLES = ("sensor(B)", "basestation(B)", "offset(I)", "timestampFPGA(I)", "timestamp2FPGA(Q)")


@pytest.fixture(scope="module")
def frames() -> tuple[np.ndarray, object]:
    """Rows sensor, channel (-1 unknown), slow bit, offset and begin in 24 MHz ticks; the twin."""
    R, t, middle, up = stations_around(2, np.random.default_rng(1), height_m=2.0)
    motion = MotionTwin(centre_m=tuple(middle), speed_m_s=0.5, extent_m=0.5, wobble_deg=3)
    turn = R[0].T @ np.eye(3)  # flat, diodes upwards
    made = simulate_turns(
        TurnsTwin(3, R, t, (0, 1), motion, DECK, UP, (_upright(motion, t, up, turn), np.zeros(3)),
                  duration_s=20.0, place_mm=0.0, up=up, lost_begins=0.0)
    )  # fmt: skip
    light, rows = made.light, []
    stamp = np.floor(light.hit_s * 24e6).astype(np.int64)
    begin = np.round(light.begin_s * 24e6).astype(np.int64)
    for k in (0, 1):
        own = np.flatnonzero(light.hit_channel == k)
        starts, bits = begin[light.begin_channel == k], light.begin_bit[light.begin_channel == k]
        turn_of = np.searchsorted(starts, stamp[own], side="right") - 1
        fresh = np.diff(stamp[own], prepend=-(10**6)) > 10_000
        last = np.r_[fresh[1:], True]  # the offset comes with the last pulse of a sweep
        offset = np.where(last, (stamp[own] - starts[turn_of]) // 4 * 4, 0)
        channel = np.where(fresh & ~last, -1, k)
        rows.append(
            np.column_stack([light.hit_diode[own], channel, bits[turn_of], offset, stamp[own]])
        )
    table = np.concatenate(rows)
    return table[np.argsort(table[:, 4], kind="stable")], made


def _upright(motion: MotionTwin, t: np.ndarray, up: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Rotation of the deck on the body, which faces the stations, so that its diodes look up."""
    from mocap_metrology.lighthouse.simulate.motion import facing_to

    facing = facing_to(np.array(motion.centre_m), t)
    z = facing.T @ up
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def uart(rows: np.ndarray) -> bytes:
    out, seen = [b"\x07\x01\xff", b"\xff" * 12], 0
    for sensor, channel, bit, offset, stamp in rows.tolist():
        if stamp - seen > 12_000_000:
            out.append(b"\xff" * 12)
            seen = stamp
        first = sensor | bit << 2 | (0x80 if channel < 0 else channel << 3)
        parts = [(first, 1), (240, 2), (offset // 4, 3), (0x1A639, 3), (stamp % (1 << 24), 3)]
        out.append(b"".join(value.to_bytes(size, "little") for value, size in parts))
    return b"".join(out)


def log(rows: np.ndarray, version: int = 2, variables: tuple[str, ...] = VARIABLES) -> bytes:
    head = "<HI" if version == 1 else "<HQ"
    out = [b"\xbc", struct.pack("<HH", version, 2)]
    for event, name, own in ((7, "other", ("x(f)",)), (3, "lhUartFrame", variables)):
        out.append(struct.pack("<H", event) + name.encode() + b"\0" + struct.pack("<H", len(own)))
        out += [variable.encode() + b"\0" for variable in own]
    form = "<" + "".join(variable[-2] for variable in variables)
    for k, (sensor, channel, _, offset, stamp) in enumerate(rows.tolist()):
        if k % 50 == 0:
            out.append(struct.pack(head, 7, k) + struct.pack("<f", 1.5))
        values = (sensor, 2 if channel < 0 else channel, offset, stamp % (1 << 24), stamp)
        out.append(struct.pack(head, 3, k) + struct.pack(form, *values[: len(variables)]))
    data = b"".join(out)
    return data + struct.pack("<I", zlib.crc32(data))


def board(folder: Path) -> Path:
    lines = ["x_m,y_m,z_m", *(",".join(map(str, place)) for place in DECK.tolist())]
    (path := folder / "deck.csv").write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("kind", ["uart", "log", "log 1", "24 bits", "csv"])
def test_all_forms_give_the_angles_of_the_twin(
    tmp_path: Path, frames: tuple[np.ndarray, object], kind: str
) -> None:
    rows, made = frames
    path = tmp_path / "a.bin"
    data = {
        "uart": lambda: uart(rows),
        "log": lambda: log(rows),
        "log 1": lambda: log(rows, 1),
        "24 bits": lambda: log(rows, 2, VARIABLES[:4]),
        "csv": lambda: _csv(rows),
    }[kind]()
    path.write_bytes(data)
    found = decode(path, "crazyflie-uart" if kind == "uart" else "crazyflie-log", board(tmp_path))
    assert [one.channel for one in found.stations] == [0, 1] and found.generation == 2
    direct = made.light.hit_s.size
    assert 0.85 * direct < len(found.hits) <= direct
    assert all(clock.rms_s < 1e-6 for clock in found.clocks)
    # The clock begins with the first pulse. Ticks of 24 MHz and of 6 MHz, 15 + 15 urad
    off = [np.abs(residuals(made, found.hits, begin)) for begin in made.light.hit_s[:6]]
    best = min(off, key=np.median)
    assert all(1.48 * np.median(best[found.hits.station == k]) < 60e-6 for k in (0, 1))
    if kind == "uart":  # slow bits
        assert all(np.array_equal(one.factory.tilt, f.tilt) for one, f in
                   zip(found.stations, made.factories, strict=True))  # fmt: skip


def _csv(rows: np.ndarray) -> bytes:
    lines = ["timestamp,sensor,basestation,offset,timestamp2FPGA"]
    for k, (sensor, channel, _, offset, stamp) in enumerate(rows.tolist()):
        lines.append(f"{k},{sensor},{2 if channel < 0 else channel},{offset},{stamp}")
    return "\n".join(lines).encode()


def test_bytes_out_of_step_are_found_again(
    tmp_path: Path, frames: tuple[np.ndarray, object]
) -> None:
    data = uart(frames[0])
    path = tmp_path / "a.bin"
    path.write_bytes(data)
    whole = decode(path, "crazyflie-uart", board(tmp_path))
    path.write_bytes(data[3:])  # from the first sync on
    assert len(decode(path, "crazyflie-uart", board(tmp_path)).hits) == len(whole.hits)
    for lost in (5, 30_001):  # within a frame, and two seconds
        path.write_bytes(data[:70_000] + data[70_000 + lost :])
        found = decode(path, "crazyflie-uart", board(tmp_path))
        assert 0.75 * len(whole.hits) < len(found.hits) < len(whole.hits)
        assert "1 times out of step" in found.notes[0]
        for clock, same in zip(found.clocks, whole.clocks, strict=True):
            assert clock.cycle_s == pytest.approx(same.cycle_s, rel=1e-6)
            assert clock.rms_s < 1e-6


def test_what_is_refused(tmp_path: Path, frames: tuple[np.ndarray, object]) -> None:
    path, places, rows = tmp_path / "a.bin", board(tmp_path), frames[0][:500]
    cases = [
        ("crazyflie-uart", bytes(1000), "no frames of 12 bytes"),
        ("crazyflie-log", log(rows)[:-2], "is damaged"),
        ("crazyflie-log", log(rows, 3), "version 3"),
        ("crazyflie-log", log(rows[:0]), "no event lhUartFrame"),
        ("crazyflie-log", log(rows, 2, ("sensor(B)",)), "no basestation, offset"),
        ("crazyflie-log", b"hello\n1\n", "no sensor, basestation, offset"),
        ("crazyflie-log", b"", "no sensor, basestation, offset"),
        ("crazyflie-log", _csv(rows[:0]), "no rows; expected one row per pulse"),
        ("crazyflie-log", _csv(rows).replace(b",161392,", b",161.392,"), "offset is 161.392"),
        ("crazyflie-log", _csv(rows) + b"\n" + _csv(rows), "row 501: sensor is 'sensor'"),
        ("crazyflie-log", log(np.tile(frames[0], (2, 1))), "goes back by 20 s in pulse"),
        ("crazyflie-log", log(rows * [1, 0, 1, 0, 1]), "no sweep with one channel"),
    ]
    for kind, data, message in cases:
        path.write_bytes(data)
        with pytest.raises(Refusal, match=message):
            decode(path, kind, places)
    with pytest.raises(Refusal, match="cannot be read"):
        decode(tmp_path / "none", "crazyflie-uart", places)


RATE_HZ = 24e6
Row = tuple[int, int, int]  # sensor, channel, offset
GOOD: list[Row] = [(0, 3, 50_000), (1, -1, 0), (2, 3, 0), (3, -1, 0)]
WRONG: dict[str, list[Row]] = {
    "two channels": [(0, 3, 50_000), (1, 5, 0), (2, 3, 0)],
    "no channel": [(0, -1, 50_000), (1, -1, 0)],
    "no such channel": [(0, 16, 50_000), (1, -1, 0)],
    "no time in the turn": [(0, 3, 0), (1, 3, 0)],
    "two times in the turn": [(0, 3, 50_000), (1, 3, 50_010)],
    "a sensor twice": [(0, 3, 50_000), (1, 3, 0), (1, 3, 0)],
}


def decoded(*groups: list[Row], apart: int = 100_000, within: int = 300) -> object:
    rows = [
        (sensor, channel, offset, apart * k + within * i)
        for k, group in enumerate(groups)
        for i, (sensor, channel, offset) in enumerate(group)
    ]
    order = np.random.default_rng(1).permutation(len(rows))
    sensor, channel, offset, stamp = np.array(rows)[order].T
    return _light(sensor, channel, offset, stamp + 10**6, stamp % 2, [], "a.bin")


@pytest.mark.parametrize("fault", WRONG)
def test_a_sweep_that_is_of_no_single_station_is_left_out(fault: str) -> None:
    light = decoded(GOOD, WRONG[fault], [(1, 7, 90_000)])
    n = len(WRONG[fault])
    assert light.hit_channel.tolist() == [3, 3, 3, 3, 7]
    assert light.hit_diode.tolist() == [0, 1, 2, 3, 1]
    assert (light.hit_s * RATE_HZ).tolist() == pytest.approx([0, 300, 600, 900, 200_000])
    assert light.begin_channel.tolist() == [3, 7]
    assert (light.begin_s * RATE_HZ).tolist() == pytest.approx([-50_000, 110_000])
    assert light.notes == (f"{n} of {n + 5} pulses are of sweeps of no single station",)
    with pytest.raises(Refusal, match="no sweep with one channel and one time in the turn"):
        decoded(WRONG[fault])


def test_wraps_of_the_counter_between_pieces_are_those_that_fit_the_turns() -> None:
    """Of channel 3; channel 5 is seen in the second piece only."""
    turn = np.r_[0:10, 100:110]
    true = np.rint(turn * PERIOD_S[3] * RATE_HZ).astype(np.int64) + 60_000
    channel, offset = np.where(turn < 109, 3, 5), np.full(20, 50_000)
    ticks = _continuous(true % (1 << 24), channel, offset, np.array([10]))
    assert np.ptp(ticks - true) == 0
