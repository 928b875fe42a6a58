"""Light of second-generation stations: real recordings against libsurvive's own lines and counts,
and small made ones with every defect that a recording can have."""

import gzip
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.decode.libsurvive import read_libsurvive
from mocap_metrology.lighthouse.decode.turns import PERIOD_TICKS, Light, find_turn_hits, find_turns

FOLDER = "lighthouse2"
BOARD = np.array([[0.0, y, z] for y in (-0.05, 0.0, 0.05) for z in (-0.05, 0.05)])
STILL = {  # file, object: channels, hits counted by grep
    ("tracker-cal-attempt", "WM0"): ([0, 3, 7, 11], 138_259),
    ("lh2_test_cal", "LHR-EA80BDA9"): ([6, 10], 22_099),
    ("haagh-tracking2", "T20"): ([2, 8], 19_963),
}


def white(light: Light) -> list[float]:
    """Robust white noise in rad of a still object, each plane, from second differences over
    consecutive turns of each diode."""
    hits, _ = find_turn_hits(light, find_turns(light)[0])
    found = []
    for station, plane in np.ndindex(int(hits.station.max()) + 1, 2):
        own = hits.take((hits.station == station) & (hits.axis == plane))
        parts = []
        for diode in np.unique(own.diode):
            one = own.take(own.diode == diode)
            three = (np.diff(one.cycle)[1:] == 1) & (np.diff(one.cycle)[:-1] == 1)
            parts.append(np.diff(one.angle_rad, 2)[three])
        found.append(1.4826 * float(np.median(np.abs(np.concatenate(parts)))) / np.sqrt(6))
    return found


@pytest.mark.parametrize(("file", "name"), STILL)
def test_a_still_object(light_of: Callable, file: str, name: str) -> None:
    """Noise as measured by others on these receivers, 15 to 30 urad; no hit is lost but those of
    another count of the clock."""
    channels, n = STILL[file, name]
    light = light_of(file, name)
    turns, notes = find_turns(light)
    assert [one.channel for one in turns] == channels and notes == []
    assert n - 50 < light.hit_s.size <= n
    assert all(one.clock.rms_s < 0.4e-6 for one in turns)
    assert all(9e-6 < one < 40e-6 for one in white(light))


def test_planes_and_angles_are_those_of_libsurvive(samples: Path, light_of: Callable) -> None:
    """B lines: plane and angle as libsurvive computes them from a single begin of a turn, whose
    noise of 22 to 60 urad and the wander of the rotor are the difference. Two sensors hit in one
    tick exchange their lines."""
    path = samples / FOLDER / "index-yank-up-down.rec.gz"
    with gzip.open(path) as stream:
        text = stream.read()
    lines = re.findall(rb"^\S+ T20 B (\d+) (\d+) (\d+) (\d) (\S+)$", text, re.M)
    light = light_of("index-yank-up-down", "T20")
    assert len(lines) == light.hit_s.size
    hits, _ = find_turn_hits(light, find_turns(light)[0])
    theirs = np.array(lines, dtype=np.float64)
    first = np.floor(light.hit_s * 48e6 + 0.25).astype(np.int64)  # whole ticks of our clock
    unrolled = theirs[:, 2] - theirs[0, 2] + first[0]
    own = {
        (int(t), int(d)): (p, a)
        for t, d, p, a in zip(
            np.floor(hits.time_s * 48e6 + 0.25), hits.diode, hits.axis, hits.angle_rad, strict=True
        )
    }
    both = [
        (own[int(t), int(d)], p, a) for t, (_, d, _, p, a) in zip(unrolled, theirs, strict=True)
    ]
    assert all(mine[0] == plane for mine, plane, _ in both)
    off = np.array([mine[1] - angle for mine, _, angle in both])
    assert np.median(np.abs(off)) < 60e-6 and np.abs(off).max() < 1e-3


# Made recordings


def made(  # one object before stations of channels 2 and 9
    path: Path,
    seconds: float = 3.0,
    begin: int = 2**32 - 48_000_000,
    change: Callable[[list[str]], list[str]] = lambda lines: lines,
    end: int | None = None,
) -> Path:
    """A recording whose counter wraps after a second: angles of diode d are 0.02 d + 0.1 station
    - 0.15 plane, and of half a tick more where d is odd."""
    events = []
    for station, channel in enumerate((2, 9)):
        period = PERIOD_TICKS[channel]
        for turn in range(int(seconds * 48e6 / period)):
            zero = 1000 * station + turn * period
            events.append((zero + period, f"Y {channel} {{}} {turn % 2} 1", zero))
            for plane in (0, 1):
                for diode in range(len(BOARD)):
                    angle = 0.02 * diode + 0.1 * station - 0.15 * plane
                    at = zero + period * (angle / (2 * np.pi) + (1 + plane) / 3)
                    half = diode % 2
                    tick = int(np.floor(at))
                    events.append((at, f"W {channel} {diode} {{}} {half}", tick))
    lines = [
        f"{5.0 + host / 48e6 + 0.004:.6f} T20 {text.format((begin + tick) % 2**32)}"
        for host, text, tick in sorted(events, key=lambda event: event[0])
    ]
    config = {
        "device_serial_number": "LHR-1",
        "lighthouse_config": {
            "modelPoints": BOARD.tolist(),
            "modelNormals": [[1, 0, 0]] * len(BOARD),
        },
    }
    text = [f"0.1 T20 CONFIG {json.dumps(config)}", *change(lines)]
    data = gzip.compress("".join(f"{line}\n" for line in text).encode())
    path.write_bytes(data[:end])
    return path


def check(light: object, share: float = 0.99) -> None:
    """Turns and angles as they were made, to a tick."""
    assert isinstance(light, Light)
    turns, notes = find_turns(light)
    assert notes == [] and [one.channel for one in turns] == [2, 9]
    hits, report = find_turn_hits(light, turns)
    total = sum(2 * len(BOARD) * int(3.0 * 48e6 / PERIOD_TICKS[channel]) for channel in (2, 9))
    assert share * total < sum(report["hit"]) <= total
    angle = 0.02 * hits.diode + 0.1 * hits.station - 0.15 * hits.axis
    half = 3.4e-6 * (hits.diode % 2)
    assert np.abs(hits.angle_rad - angle - half).max() < 8e-6  # of a tick, cut off
    for k in (0, 1):
        own = hits.take(hits.station == k)
        assert np.all(own.cycle == np.floor(own.time_s / turns[k].clock.cycle_s + 1e-4))
        assert np.all(turns[k].bit == turns[k].turn % 2)


def late(lines: list[str]) -> list[str]:
    """Begins half a second late, in file order: beyond 20 turns."""
    begins = [line for line in lines if " Y " in line]
    return [*(line for line in lines if " Y " not in line), *begins[::-1]]


def holes(lines: list[str]) -> list[str]:
    """A second without begins, and others twice."""
    return [
        line
        for line in lines
        for _ in range(1 + (" Y 2 " in line))
        if not (" Y " in line and 6.0 < float(line.split()[0]) < 7.0)
    ]


def strays(lines: list[str]) -> list[str]:
    """Ten lines of another count of the clock first, single ones off by 2^24 ticks later."""
    first = [line.replace(" Y ", " Y ").split() for line in lines[:10]]
    odd = [line.split() for line in lines]
    for some, shift in ((first, 5 * 48_000_000), (odd[100::400], 1 << 24)):
        for cells in some:
            at = 5 if cells[2] == "W" else 4
            cells[at] = str((int(cells[at]) + shift) % 2**32)
    return [" ".join(cells) for cells in [*first, *odd]]


def delayed(lines: list[str]) -> list[str]:
    """The host is later and later, by a tenth of the time."""
    cells = [line.split(maxsplit=1) for line in lines]
    return [f"{1.1 * float(time):.6f} {rest}" for time, rest in cells]


def wrong_begins(lines: list[str]) -> list[str]:
    """Every tenth begin a third of a turn late."""
    result = [line.split() for line in lines]
    for cells in [cells for cells in result if cells[2] == "Y"][5::10]:
        cells[4] = str((int(cells[4]) + 310_000) % 2**32)
    return [" ".join(cells) for cells in result]


@pytest.mark.parametrize("change", [late, holes, strays, delayed, wrong_begins])
def test_turns_are_counted_through_defects(
    tmp_path: Path, change: Callable[[list[str]], list[str]]
) -> None:
    path = made(tmp_path / "a.rec.gz", change=change)
    for name in ("T20", "LHR-1"):
        light, board = read_libsurvive(path, name)
        assert np.array_equal(board, BOARD)
        check(light)


@pytest.mark.parametrize("jump_s", [0.8, -0.5, 1.7, 0.05, -1e-3])
def test_a_clock_that_jumps_ends_the_light_that_is_used(tmp_path: Path, jump_s: float) -> None:
    """The longer part of the recording remains, by whatever part of a turn the rest is off."""

    def jumped(lines: list[str]) -> list[str]:
        cells = [line.split() for line in lines]
        for some in cells[3 * len(cells) // 5 :]:
            at = 5 if some[2] == "W" else 4
            some[at] = str((int(some[at]) + round(48e6 * jump_s)) % 2**32)
        return [" ".join(some) for some in cells]

    whole, _ = read_libsurvive(made(tmp_path / "a.rec.gz"), "T20")
    light, _ = read_libsurvive(made(tmp_path / "b.rec.gz", change=jumped), "T20")
    assert light.hit_s.size == pytest.approx(0.6 * whole.hit_s.size, rel=0.02)
    turns, notes = find_turns(light)
    assert [one.channel for one in turns] == [2, 9] and notes == []
    hits, _ = find_turn_hits(light, turns)
    angle = 0.02 * hits.diode + 0.1 * hits.station - 0.15 * hits.axis
    right = np.abs(hits.angle_rad - angle) < 12e-6
    assert np.count_nonzero(right) > 0.99 * light.hit_s.size


def b_lines(lines: list[str]) -> list[str]:
    found = []
    for cells in map(str.split, lines):
        if cells[2] == "W":
            cells = [*cells[:2], "B", *cells[3:6], "0", "+0.1"]
        found.append(" ".join(cells))
    return found


def test_b_lines_serve_where_w_lines_are_missing(tmp_path: Path) -> None:
    light, _ = read_libsurvive(made(tmp_path / "a.rec.gz", change=b_lines), "T20")
    assert isinstance(light, Light) and "B lines" in light.notes[0]
    turns, _ = find_turns(light)
    assert sum(find_turn_hits(light, turns)[1]["hit"]) == light.hit_s.size


def of_the_first(lines: list[str]) -> list[str]:
    return [*lines, *(f"9.0 T20 C 1 {k} 100" for k in range(200))]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (of_the_first, r"light of both generations .*200 C lines"),
        (lambda lines: [x for x in lines if " 9 " not in x], "1 usable base stations"),
        (lambda lines: [x for x in lines if " Y " not in x], "0 begins of turns, too few"),
        (lambda lines: [x.replace("T20", "T21") for x in lines], r"object 'T20'; .* one of T21"),
    ],
)
def test_what_is_refused(
    tmp_path: Path, change: Callable[[list[str]], list[str]], message: str
) -> None:
    with pytest.raises(Refusal, match=message):
        decode(made(tmp_path / "a.rec.gz", change=change), "libsurvive-rec", "T20")


def test_a_dump_of_second_generation_light_is_refused_with_the_reason(tmp_path: Path) -> None:
    """Two stations, a moving board, samples of 2 MHz; noise at random is not taken for it."""
    from mocap_metrology.lighthouse.records import Pulses
    from mocap_metrology.lighthouse.simulate.recording import write_dump
    from mocap_metrology.lighthouse.simulate.turns import TurnsTwin, simulate_turns, stations_around
    from mocap_metrology.lighthouse.simulate.twin import MotionTwin

    R, t, middle, _ = stations_around(2, np.random.default_rng(1))
    motion = MotionTwin(centre_m=tuple(middle), speed_m_s=0.5, extent_m=0.5)
    light = simulate_turns(TurnsTwin(3, R, t, (4, 13), motion, duration_s=4.0)).light
    length = np.full(light.hit_s.size, 10e-6)
    write_dump(tmp_path / "a.bin", Pulses(light.hit_s, length, light.hit_diode, 32, 4.0, 0.0))
    (tmp_path / "board.csv").write_text(
        "x_m,y_m,z_m\n" + "".join(f"0,{k % 8 / 30},{k // 8 / 30}\n" for k in range(32))
    )
    with pytest.raises(Refusal, match=r"second-generation \(V2\) base stations \(channel 4, 13\)"):
        decode(tmp_path / "a.bin", "gpio-dump", tmp_path / "board.csv")
    start = np.sort(np.random.default_rng(2).uniform(0, 4, light.hit_s.size))
    write_dump(tmp_path / "a.bin", Pulses(start, length, light.hit_diode, 32, 4.0, 0.0))
    with pytest.raises(Refusal, match=r"^((?!V2).)*$"):
        decode(tmp_path / "a.bin", "gpio-dump", tmp_path / "board.csv")
