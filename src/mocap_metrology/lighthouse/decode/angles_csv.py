"""Sweep angles decoded elsewhere, from a CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common import spreadsheet
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.turns import PERIOD_S, PLANE_RAD
from mocap_metrology.lighthouse.records import AXES, ROLES, Hits
from mocap_metrology.lighthouse.timing import CYCLE_S

NEEDED = ("station", "axis", "cycle", "diode", "time_s", "angle_rad")
EXPECTED = "columns " + ",".join(NEEDED) + " and, if known, width_us"
STATIONS = {"0": 0, "1": 1, ROLES[0]: 0, ROLES[1]: 1}
COUNTS = ("time_s", "channel", "count_0", "count_1")
COUNT_HZ = 6_000_000
Whole = tuple[str, int, int, str]
WHOLE = (  # column, least and largest value, in words
    ("axis", 0, 1, "0 or 1"),
    ("cycle", -(1 << 30), 1 << 30, "a whole number"),
    ("diode", 0, (1 << 15) - 1, "a whole number from 0"),
)
OF_COUNTS = ("channel", 0, 15, "a whole number from 0"), WHOLE[2]
FEWEST_SPACINGS = 10  # for a meaningful median
MOST_REPEATED = 0.02  # of the rows of counts, as by reflections; of two recordings in one more
LARGEST_RAD = np.pi / 2  # a sweep sees half a turn
SWEEP_S = 1.2 * CYCLE_S  # all hits of a sweep lie within; logs round to 1 ms
SPACING_S = (1.8 * CYCLE_S, 8.5 * CYCLE_S)  # of sweeps of one axis: each turn, or each other


def read_angles(path: str | Path) -> tuple[Hits, tuple[int, ...]]:
    """Hits from a CSV, sorted by time, and the channel indices of the stations of a second
    generation, rising; a width that is not given is NaN.

    station is master, slave, 0 or 1; axis 0 (azimuth) or 1 (elevation); cycle is common to the hits
    of a sweep and grows with time; time_s is that of the hit; angle pi (time - flash) / T - pi/2,
    from the station's own flash, T its half turn, growing to its own left and upwards. With a
    column generation of 2 in all rows, station is a channel index, 0 to 15, axis a plane, cycle a
    turn and the angle as in `Hits`. Other columns are ignored. Raises `Refusal` for missing
    columns, cells that are none of that, angles in degrees, times that are not of sweeps or not in
    seconds.
    """
    name = Path(path).name
    table = _table(path, NEEDED, EXPECTED)
    generation = np.array([cell.strip() for cell in table.get("generation", [])], str)
    if not (second := generation.size > 0 and bool((generation == "2").all())):
        words = "generation is {!r}; expected 1 in all rows or 2 in all rows"
        _refuse_first(generation != "1", table.get("generation", []), name, words)
    named = {str(k): k for k in range(PERIOD_S.size)} if second else STATIONS
    station = np.array([named.get(cell.strip().lower(), np.nan) for cell in table["station"]])
    words = "station is {!r}; expected " + ("a channel, 0 to 15" if second else "master or slave")
    _refuse_first(np.isnan(station), table["station"], name, words)
    columns = {"station": station} | numbers_of(table, (*NEEDED[1:], "width_us"), name)
    _check(columns, name, second)
    channels = np.unique(columns["station"]).astype(int)
    if second:
        columns["station"] = np.searchsorted(channels, columns["station"])
    whole = (columns[name] for name in NEEDED[:4])
    hits = Hits.of(*whole, time_s=columns["time_s"], angle_rad=columns["angle_rad"])
    if "width_us" in columns:
        hits = replace(hits, width_s=columns["width_us"] * 1e-6)
    hits = hits.take(np.argsort(hits.time_s, kind="stable"))
    return hits, tuple(channels.tolist()) if second else ()


def read_counts(path: str | Path) -> tuple[Hits, tuple[int, ...]]:
    """Hits, and channel indices, of a CSV of counts of the sequence in second-generation light, as
    DotBots report them: time_s, channel (index), count_0 and count_1 of the two sweeps of a turn,
    at 6 MHz from its begin, in any order; diode, 0 without it. time_s is the first sweep's.

    Rotor angle 2 pi count / (6 MHz T), T being the nominal period of the channel.
    """
    name = Path(path).name
    table = _table(path, COUNTS, f"columns {','.join(COUNTS)} and diode")
    columns = numbers_of(table, (*COUNTS, "diode"), name)
    channel = columns["channel"]
    diode = columns.get("diode", np.zeros(channel.size))
    check_whole({"channel": channel, "diode": diode}, OF_COUNTS, name)
    period = PERIOD_S[channel.astype(int)]
    count = np.sort(np.stack([columns["count_0"], columns["count_1"]]), axis=0)
    rotor = 2 * np.pi * count / (COUNT_HZ * period)
    bad = ((rotor < 0) | (rotor > 2 * np.pi)).any(axis=0)
    words = "counts up to {:g}; expected two within a turn"
    _refuse_first(bad, columns["count_1"], name, words)
    channels = np.unique(channel).astype(int)
    time_s = columns["time_s"]
    n = channel.size
    turn = _turns(time_s - count[0] / COUNT_HZ, channel)
    keys = np.stack([channel, turn, diode])
    other = np.unique(np.vstack([keys, count]), axis=1).shape[1] - np.unique(keys, axis=1).shape[1]
    if other > MOST_REPEATED * n:
        raise Refusal(
            f"{name}: {other} of {n} rows have the turn and diode of another row, but other counts;"
            " expected one recording"
        )
    hits = Hits.of(
        np.tile(np.searchsorted(channels, channel), 2),
        np.repeat([0, 1], n),
        np.tile(turn, 2),
        np.tile(diode, 2),
        time_s=np.r_[time_s, time_s + (count[1] - count[0]) / COUNT_HZ],
        angle_rad=(rotor - PLANE_RAD[:, None]).ravel(),
    )
    inside = np.abs(hits.angle_rad) <= LARGEST_RAD
    _, first = np.unique(
        np.stack([hits.station, hits.axis, hits.cycle, hits.diode]), axis=1, return_index=True
    )
    first = first[inside[first]]
    return hits.take(first[np.argsort(hits.time_s[first])]), tuple(channels.tolist())


def _turns(begin_s: np.ndarray, channel: np.ndarray) -> np.ndarray:
    """Number (n,) of the turn of its channel that begins then, from 0; times may be coarse."""
    turn = np.empty(begin_s.size)
    for one in np.unique(channel):
        rows = np.flatnonzero(channel == one)
        rows = rows[np.argsort(begin_s[rows], kind="stable")]
        steps = np.diff(begin_s[rows], prepend=begin_s[rows[0]]) / PERIOD_S[int(one)]
        turn[rows] = np.cumsum(np.round(steps))
    return turn


def _table(path: str | Path, needed: tuple[str, ...], expected: str) -> dict[str, list[str]]:
    name, table = Path(path).name, spreadsheet.columns(path, f"a CSV: {expected}")
    if missing := [column for column in needed if column not in table]:
        raise Refusal(f"{name}: no column {', '.join(missing)}; expected {expected}")
    if not table[needed[0]]:
        raise Refusal(f"{name}: no rows; expected one row per hit of a diode")
    return table


def numbers_of(
    table: Mapping[str, Sequence[str]], names: Sequence[str], file: str
) -> dict[str, np.ndarray]:
    """Those of the named columns that a table has, as finite numbers; refuses any other cell."""
    columns = {}
    for column in [name for name in names if name in table]:
        cells = table[column]
        columns[column] = values = np.full(len(cells), np.nan)
        for row, cell in enumerate(cells):
            with suppress(ValueError):
                values[row] = spreadsheet.number(cell)
        words = column + " is {!r}; expected a finite number"
        _refuse_first(~np.isfinite(values), cells, file, words)
    return columns


def _refuse_first(
    bad: np.ndarray, cells: Sequence[Any] | np.ndarray, name: str, words: str
) -> None:
    """Refuse the first row that is bad, naming its cell."""
    if bad.any():
        row = int(np.argmax(bad))
        raise Refusal(f"{name}, row {row + 1}: " + words.format(cells[row]))


def check_whole(columns: Mapping[str, np.ndarray], expected: Sequence[Whole], name: str) -> None:
    """Refuse the first value of some columns that is no whole number in its range."""
    for column, least, most, words in expected:
        values = columns[column]
        bad = (values != np.round(values)) | (values < least) | (values > most)
        _refuse_first(bad, values, name, column + " is {:g}; expected " + words)


def _check(columns: dict[str, np.ndarray], name: str, second: bool) -> None:
    check_whole(columns, WHOLE, name)
    keys = np.stack([columns[name] for name in ("station", "axis", "cycle", "diode")])
    _, first, count = np.unique(keys, axis=1, return_index=True, return_counts=True)
    if (count > 1).any():
        row = int(first[np.argmax(count > 1)])
        raise Refusal(
            f"{name}, row {row + 1}: its station, axis, cycle and diode occur again; expected "
            "one row per hit"
        )
    for station, axis in np.ndindex(PERIOD_S.size if second else 2, 2):
        of_laser = (columns["station"] == station) & (columns["axis"] == axis)
        of_whom = f"channel {station}" if second else f"the {ROLES[station]}"
        sweeps = f"{name}: {f'plane {axis}' if second else AXES[axis]} sweeps of {of_whom}"
        _check_times(columns["time_s"][of_laser], columns["cycle"][of_laser], sweeps)
    largest = float(np.abs(columns["angle_rad"]).max())
    if largest > LARGEST_RAD:
        raise Refusal(
            f"{name}: angle_rad reaches {largest:g}; expected radians, at most pi/2 either way "
            "(are they in degrees, or measured from the flash?)"
        )


def _check_times(time_s: np.ndarray, cycle: np.ndarray, sweeps: str) -> None:
    """Refuse cycles that are no sweeps, and times that are not seconds.

    All hits of a sweep lie within a half turn; the sweeps of one axis of a station come in the
    order of their cycles, in the median every turn or every second one.
    """
    numbers, row = np.unique(cycle, return_inverse=True)
    first, last = np.full(numbers.size, np.inf), np.full(numbers.size, -np.inf)
    np.minimum.at(first, row, time_s)
    np.maximum.at(last, row, time_s)
    spacing = np.diff((first + last) / 2)
    if spacing.size >= FEWEST_SPACINGS:
        usual = float(np.median(spacing))
        if not SPACING_S[0] <= usual <= SPACING_S[1]:
            raise Refusal(
                f"{sweeps} are {usual:.3g} s apart; expected about 0.017 or 0.033 s (is"
                " time_s in seconds, and does cycle number the sweeps in their order?)"
            )
    long = np.flatnonzero(last - first > SWEEP_S)
    if long.size:
        raise Refusal(
            f"{sweeps}: hits of cycle {numbers[long[0]]:g} are"
            f" {(last - first)[long[0]]:.3g} s apart; expected one sweep, within 0.0083 s"
        )
    back = np.flatnonzero(spacing <= 0)
    if back.size:
        raise Refusal(
            f"{sweeps}: cycle {numbers[back[0] + 1]:g} is not after cycle "
            f"{numbers[back[0]]:g}; expected cycles that increase with time_s"
        )
