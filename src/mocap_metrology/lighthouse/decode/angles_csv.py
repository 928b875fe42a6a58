"""Sweep angles decoded elsewhere, from a CSV."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.spreadsheet import delimiter, with_point
from mocap_metrology.lighthouse.records import AXES, ROLES, Hits
from mocap_metrology.lighthouse.timing import CYCLE_S

NEEDED = ("station", "axis", "cycle", "diode", "time_s", "angle_rad")
EXPECTED = "columns " + ",".join(NEEDED) + " and, if known, width_us"
STATIONS = {"0": 0, "1": 1, ROLES[0]: 0, ROLES[1]: 1}
WHOLE = (  # column, least and largest value, in words
    ("axis", 0, 1, "0 or 1"),
    ("cycle", -(1 << 30), 1 << 30, "a whole number"),
    ("diode", 0, (1 << 15) - 1, "a whole number from 0"),
)
FEWEST_SPACINGS = 10  # for a meaningful median
LARGEST_RAD = np.pi / 2  # a sweep sees half a turn
SWEEP_S = 1.2 * CYCLE_S  # all hits of a sweep lie within; logs round to 1 ms
SPACING_S = (0.9 * CYCLE_S, 8.5 * CYCLE_S)  # of sweeps of one axis: each turn, or each other


def read_angles(path: str | Path) -> Hits:
    """Hits from a CSV, sorted by time; a width that is not given is NaN.

    station is master, slave, 0 or 1; axis 0 (azimuth) or 1 (elevation); cycle is common to the hits
    of a sweep and grows with time; time_s is that of the hit; angle pi (time - flash) / T - pi/2,
    from the station's own flash, T its half turn, growing to its own left and upwards. Other
    columns are ignored. Raises `Refusal` for missing columns, cells that are none of that, angles
    in degrees, times that are not of sweeps or not in seconds.
    """
    import pandas as pd

    name = Path(path).name
    try:
        with Path(path).open(encoding="utf-8-sig") as stream:
            between = delimiter(stream.readline())
        table = pd.read_csv(
            path, sep=between, dtype=str, keep_default_na=False, encoding="utf-8-sig"
        )
    except (OSError, ValueError) as error:  # pandas raises ValueErrors of its own
        raise Refusal(f"{name}: cannot be read ({error}); expected a CSV: {EXPECTED}") from None
    if between == ";":
        table = table.map(with_point)
    table.columns = [str(column).strip() for column in table.columns]
    missing = [column for column in NEEDED if column not in table.columns]
    if missing:
        raise Refusal(f"{name}: no column {', '.join(missing)}; expected {EXPECTED}")
    if table.empty:
        raise Refusal(f"{name}: no rows; expected one row per hit of a diode")
    station = table["station"].str.strip().str.lower().map(STATIONS)
    _refuse_first(
        station.isna().to_numpy(),
        table["station"],
        name,
        "station is {!r}; expected master or slave",
    )
    columns = {"station": station.to_numpy(float)}
    for column in (*NEEDED[1:], "width_us"):
        if column in table:
            values = pd.to_numeric(table[column], errors="coerce").to_numpy(np.float64)
            words = column + " is {!r}; expected a finite number"
            _refuse_first(~np.isfinite(values), table[column], name, words)
            columns[column] = values
    _check(columns, name)
    width = columns.get("width_us", np.full(len(table), np.nan)) * 1e-6
    return Hits(
        station=station.to_numpy(np.int8),
        axis=columns["axis"].astype(np.int8),
        cycle=columns["cycle"].astype(np.int32),
        diode=columns["diode"].astype(np.int16),
        time_s=columns["time_s"],
        angle_rad=columns["angle_rad"],
        width_s=width,
    ).take(np.argsort(columns["time_s"], kind="stable"))


def _refuse_first(bad: np.ndarray, cells: Iterable[object], name: str, words: str) -> None:
    """Refuse the first row that is bad, naming its cell."""
    if bad.any():
        row = int(np.argmax(bad))
        raise Refusal(f"{name}, row {row + 1}: " + words.format(list(cells)[row]))


def _check(columns: dict[str, np.ndarray], name: str) -> None:
    """Refuse numbers that do not fit their column."""
    for column, least, most, expected in WHOLE:
        values = columns[column]
        bad = (values != np.round(values)) | (values < least) | (values > most)
        _refuse_first(bad, values, name, column + " is {:g}; expected " + expected)
    keys = np.stack([columns[name] for name in ("station", "axis", "cycle", "diode")])
    _, first, count = np.unique(keys, axis=1, return_index=True, return_counts=True)
    if (count > 1).any():
        row = int(first[np.argmax(count > 1)])
        raise Refusal(
            f"{name}, row {row + 1}: its station, axis, cycle and diode occur again; expected "
            "one row per hit"
        )
    for station, axis in np.ndindex(2, 2):
        of_laser = (columns["station"] == station) & (columns["axis"] == axis)
        if of_laser.any():
            sweeps = f"{name}: {AXES[axis]} sweeps of the {ROLES[station]}"
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
