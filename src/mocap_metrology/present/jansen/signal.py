"""Figures 3 and 5 of J: what one photodiode sees in a cycle, and the angles that follow from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import AXES, MASTER, ROLES, SLAVE, Path
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
from mocap_metrology.lighthouse.timing import CYCLE_S, SLAVE_OFFSET_S
from mocap_metrology.present.calibration.views import COLOURS
from mocap_metrology.present.drawing.axes import linear_axis
from mocap_metrology.present.drawing.legend import ROW_MM, Entry, strip
from mocap_metrology.present.drawing.style import (
    BODY_PT,
    GREY,
    INK,
    LOOKS,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    blank_sheet,
    label_axes,
    size_mm,
    styled,
)
from mocap_metrology.present.jansen.projection import BOX, Projection, Stage, stage
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Columns = Mapping[str, np.ndarray]
N_CYCLES = 4
ORDER = ((MASTER, 0), (MASTER, 1), (SLAVE, 0), (SLAVE, 1))  # station and axis of each cycle
SHORTEST_FLASH_S, NEAR_S = 45e-6, 40e-6
BEFORE_S, AFTER_S = 0.5e-3, 0.2e-3  # shown round the four cycles
BETWEEN_US = 240.0  # of a flash's zoom: before and behind
MOST_TRIED = 400


@dataclass(frozen=True)
class Sweep:
    """A sweep on the diode; times from the beginning of the recording, s."""

    station: int
    axis: int
    flash_s: float  # of the station that sweeps
    start_s: float
    length_s: float
    angle_rad: float

    @property
    def middle_s(self) -> float:
        return self.start_s + self.length_s / 2

    @property
    def delta_s(self) -> float:
        """From the flash to the middle of the sweep: Delta t of J."""
        return self.middle_s - self.flash_s


@dataclass(frozen=True)
class Signal:
    """Four cycles of a diode: flashes (start, length, station) and sweeps."""

    diode: int
    start_s: float
    flashes: tuple[tuple[float, float, int], ...]
    sweeps: tuple[Sweep, ...]


def signal_of(pulses: Columns, sweeps: Columns) -> Signal:
    """The first four cycles in which a diode saw every flash and sweep, the master's azimuth first,
    and nothing else.

    pulses: `start_s`, `diode` and `length_s` or `length_us`; sweeps as in sweeps.parquet. Raises
    `Refusal` where no diode saw them all.
    """
    start = np.asarray(pulses["start_s"], dtype=np.float64)
    length = pulses["length_s"] if "length_s" in pulses else 1e-6 * pulses["length_us"]
    own = {d: np.asarray(pulses["diode"]) == d for d in np.unique(sweeps["diode"])}
    for cycle, diode in _candidates(sweeps)[:MOST_TRIED]:
        found = _read(start[own[diode]], np.asarray(length)[own[diode]], sweeps, cycle, diode)
        if found is not None:
            return found
    raise Refusal(
        "pulses: no diode saw all flashes and sweeps of four cycles; expected one for Figure 3 of J"
    )


def _candidates(sweeps: Columns) -> np.ndarray:
    """(n, 2) first cycle and diode of four sweeps in the order of `ORDER`, earliest first."""
    code = np.asarray(sweeps["cycle"], dtype=np.int64) * 4096 + np.asarray(sweeps["diode"])
    common = None
    for k, (station, axis) in enumerate(ORDER):
        own = (np.asarray(sweeps["station"]) == station) & (np.asarray(sweeps["axis"]) == axis)
        shifted = code[own] - 4096 * k
        common = shifted if common is None else np.intersect1d(common, shifted)
    codes = np.unique(np.zeros(0, np.int64) if common is None else common)
    return np.column_stack([codes // 4096, codes % 4096])


def _read(
    start: np.ndarray, length: np.ndarray, sweeps: Columns, cycle: int, diode: int
) -> Signal | None:
    """Four cycles of a diode from its pulses, None where something is missing or too much."""
    hits = [_hit(sweeps, cycle + k, diode) for k in range(N_CYCLES)]
    begin = [_begin(sweeps, row) for row in hits]
    first = begin[0]  # of the master's cycle; cycles of the slave begin later
    near = (start > first - NEAR_S) & (start < first + N_CYCLES * CYCLE_S - NEAR_S)
    start, length = start[near], length[near]
    is_flash = length > SHORTEST_FLASH_S
    if is_flash.sum() != 2 * N_CYCLES or (~is_flash).sum() != N_CYCLES:
        return None
    flashes = []
    for at, long in zip(start[is_flash], length[is_flash], strict=True):
        after = (at - first + NEAR_S) % CYCLE_S
        flashes.append((float(at), float(long), int(after > SLAVE_OFFSET_S / 2)))
    found = []
    for k, (station, axis) in enumerate(ORDER):
        own = [at for at, _, by in flashes if by == station and abs(at - begin[k]) < NEAR_S]
        hit = np.flatnonzero(~is_flash)[k]
        if len(own) != 1 or abs(start[hit] - sweeps["time_s"][hits[k]]) > NEAR_S:
            return None
        angle = float(sweeps["angle_rad"][hits[k]])
        found.append(Sweep(station, axis, own[0], float(start[hit]), float(length[hit]), angle))
    return Signal(int(diode), flashes[0][0], tuple(flashes), tuple(found))


def _hit(sweeps: Columns, cycle: int, diode: int) -> int:
    own = (np.asarray(sweeps["cycle"]) == cycle) & (np.asarray(sweeps["diode"]) == diode)
    return int(np.flatnonzero(own)[0])


def _begin(sweeps: Columns, row: int) -> float:
    """Begin of the station's cycle: angle = pi (time - begin) / cycle - pi/2."""
    return float(sweeps["time_s"][row] - (sweeps["angle_rad"][row] / np.pi + 0.5) * CYCLE_S)


@styled()
def signal_figure(signal: Signal, title: str, note: str = "") -> Figure:
    """J Figure 3: signal of a diode over four cycles, 33.3 ms, with Delta t of each sweep; below,
    a flash of each station and a sweep, magnified."""
    sheet = blank_sheet(ROW_MM + 97.5, title, f"Diode {signal.diode}. {note}".strip())
    strip(sheet, MARGIN_MM, 0.5, WIDTH_MM, [
        Entry("light of the master", patch={"color": COLOURS[MASTER]}),
        Entry("light of the slave", patch={"color": COLOURS[SLAVE]}),
    ])  # fmt: skip
    top = sheet.axes(12.0, ROW_MM + 12, WIDTH_MM - 15.0, 42.0)
    _overview(top, signal)
    below = ROW_MM + 12 + 42.0 + 10.0
    flash = sheet.axes(12.0, below, 84.0, 22.0)
    _flashes(flash, signal)
    sweep = sheet.axes(12.0 + 84.0 + 17.0, below, WIDTH_MM - 3.0 - 113.0, 22.0)
    _one_sweep(sweep, signal)
    middle = signal.sweeps[0].middle_s - signal.start_s
    for axes, place in ((flash, 0.2e-3), (sweep, middle)):
        _magnify(top, axes, 1e3 * place)
    return sheet.figure


def _light(axes: Axes, start: float, length: float, station: int, width: float = 0.9) -> None:
    how: Keywords = {"color": COLOURS[station], "lw": width, "zorder": 3, "joinstyle": "miter"}
    axes.fill_between([start, start + length], 0, 1, **how)


def _levels(axes: Axes) -> None:
    axes.set_ylim(0, 1.0)
    axes.set_yticks([0, 1])
    axes.spines[["top", "right"]].set_visible(False)


def _overview(axes: Axes, signal: Signal) -> None:
    end = N_CYCLES * CYCLE_S + AFTER_S
    linear_axis(axes, "x", (-1e3 * BEFORE_S, 1e3 * end), 14)
    _levels(axes)
    label_axes(axes, y="Light", y_mm=7.0)
    axes.set_ylim(0, 1.88)
    axes.spines[["top"]].set_visible(True)
    axes.xaxis.tick_top()
    axes.set_xlabel("Time from the master's flash (ms)", va="center")
    axes.xaxis.set_label_coords(0.5, 1 + 7.0 / size_mm(axes)[1])
    for start, length, station in signal.flashes:
        _light(axes, 1e3 * (start - signal.start_s), 1e3 * length, station, 0.6)
    for k, sweep in enumerate(signal.sweeps):
        colour = COLOURS[sweep.station]
        flash, middle = (1e3 * (v - signal.start_s) for v in (sweep.flash_s, sweep.middle_s))
        _light(axes, 1e3 * (sweep.start_s - signal.start_s), 1e3 * sweep.length_s, sweep.station)
        arrow = {"arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": INK, "lw": 0.8}
        arrow |= {"shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (middle, 0.62), (flash, 0.62), arrowprops=arrow, zorder=4)
        how: Keywords = {"size": SMALL_PT, "ha": "center", "va": "bottom", "zorder": 4}
        axes.text((flash + middle) / 2 + 0.2, 0.66, "Δt", **how)
        begin = 1e3 * k * CYCLE_S
        centre = begin + 1e3 * CYCLE_S / 2
        degrees = number(float(np.degrees(sweep.angle_rad)), 2, sign=True)
        angle = f"{'θφ'[sweep.axis]} = {degrees}°"
        title = f"{ROLES[sweep.station]}, {AXES[sweep.axis]}"
        axes.text(centre, 1.66, title, color=colour, weight="bold", **how)
        axes.text(centre, 1.42, f"Δt = {1e3 * sweep.delta_s:.3f} ms", color=colour, **how)
        axes.text(centre, 1.18, angle, color=colour, **how)
        axes.axvline(begin, color=GREY, lw=0.5, ls=(0, (1, 2)), zorder=0)


def _flashes(axes: Axes, signal: Signal) -> None:
    """The flashes of both stations at the first cycle."""
    from matplotlib.patheffects import withStroke

    (first, long, _), (second, longer, _) = signal.flashes[:2]
    end = 1e6 * (second + longer - first) + BETWEEN_US / 3
    linear_axis(axes, "x", (-BETWEEN_US / 3, end), 8)
    _levels(axes)
    axes.set_ylim(0, 1.75)
    label_axes(axes, x="Time from the master's flash (µs)", y="Light", x_mm=7.0, y_mm=7.0)
    for start, length, station in signal.flashes[:2]:
        at = 1e6 * (start - first)
        _light(axes, at, 1e6 * length, station)
        how: Keywords = {
            "size": SMALL_PT,
            "ha": "center",
            "va": "bottom",
            "color": COLOURS[station],
        }
        text = f"{ROLES[station]}'s flash\n{1e6 * length:.1f} µs"
        axes.text(at + 0.5e6 * length, 1.06, text, linespacing=1.25, **how)
    arrow = {"arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": INK, "lw": 0.8}
    arrow |= {"shrinkA": 0, "shrinkB": 0}
    offset = 1e6 * (second - first)
    arrow["path_effects"] = [withStroke(linewidth=2.4, foreground="white")]
    axes.annotate("", (offset, 0.42), (0.0, 0.42), arrowprops=arrow, zorder=5)
    middle = (offset + 1e6 * long) / 2
    how = {"size": SMALL_PT, "ha": "center", "va": "bottom"}
    axes.text(middle, 0.48, f"begins {offset:.1f} µs later", **how)


def _one_sweep(axes: Axes, signal: Signal) -> None:
    """The first sweep; its middle is what Delta t ends at."""
    sweep = signal.sweeps[0]
    half = max(2.2e6 * sweep.length_s, 6.0)
    linear_axis(axes, "x", (-half, half), 6)
    _levels(axes)
    axes.set_ylim(0, 1.75)
    label_axes(axes, x="Time from its middle (µs)", x_mm=7.0)
    _light(axes, -0.5e6 * sweep.length_s, 1e6 * sweep.length_s, sweep.station)
    axes.plot([0, 0], [0, 1.0], color="white", lw=1.0, ls=(0, (2, 1)), zorder=4)
    text = f"{ROLES[sweep.station]}'s sweep\n{1e6 * sweep.length_s:.1f} µs"
    how: Keywords = {
        "size": SMALL_PT,
        "ha": "center",
        "va": "bottom",
        "color": COLOURS[sweep.station],
    }
    axes.text(0, 1.06, text, linespacing=1.25, **how)


def _magnify(above: Axes, below: Axes, place: float) -> None:
    """Lines from a place in the overview to both upper corners of its magnification."""
    from matplotlib.patches import ConnectionPatch

    for corner in (0.0, 1.0):
        line = ConnectionPatch(
            (place, 0.0), (corner, 1.0), above.get_xaxis_transform(), below.transAxes,
            color=GREY, lw=0.6, ls=(0, (4, 2)),
        )  # fmt: skip
        above.figure.add_artist(line)


LEAST_DEG = 22.0  # as drawn, so that arcs can be told apart
MOST_MOMENTS = 60
BOLD = {"weight": "bold", "bbox": BOX}
AZIMUTH, ELEVATION, SPHERICAL = COLOURS[0], COLOURS[1], LOOKS["z"].colour


def clearest_point(paths: tuple[Path, Path], board: np.ndarray) -> np.ndarray:
    """Of the diodes at some moments, in the frame of a station: the one farthest off both axes."""
    points = []
    for path in paths:
        few = path.take(np.arange(0, len(path), max(len(path) // MOST_MOMENTS, 1)))
        points.append((few.R @ board.T).transpose(0, 2, 1) + few.t_m[:, None])
    every = np.concatenate(points).reshape(-1, 3)
    every = every[every[:, 0] > 0]
    seen = np.abs(angles(np.ascontiguousarray(every), rotor_parameters()))
    clearest: np.ndarray = every[int(np.argmax(seen.min(axis=1)))]
    return clearest


@styled()
def angles_figure(point: np.ndarray, title: str, note: str = "") -> Figure:
    """P and its projection P' on the XZ plane, with theta = atan2(y, x), phi' = atan2(z, x) (J
    Eq. 1, from the rotor model) and phi = atan2(z, sqrt(x^2 + y^2)).

    point (3,) in m in the station's frame. Where its angles are small, y and z are drawn some times
    as long, and the note says so.
    """
    theta, phi = np.degrees(angles(point[None], rotor_parameters())[0])
    spherical = np.degrees(np.arctan2(point[2], np.hypot(point[0], point[1])))
    stretch = next((k for k in range(1, 9) if _least_deg(point, k) >= LEAST_DEG), 8)
    if stretch > 1:
        note = f"y and z are drawn {stretch} times as long as x. {note}".strip()
    P = point * [1, stretch, stretch]
    flat, behind = P * [1, 1, 0], P * [1, 0, 1]
    tips = np.diag(np.where(P > 0, 1.18, 0.5) * np.abs(P))
    corners = np.vstack([np.zeros(3), tips, P, flat, behind])
    side = 1 if P[1] < 0 else -1
    look = _clearest_look(np.vstack([tips, P, flat, behind]), side)
    sheet, drawing = stage(corners, title, note, floor=False, projection=look)
    _plane(drawing, P)
    for tip in tips:
        drawing.arrow(np.zeros(3), tip, color=GREY, lw=1.0)
    origin = np.zeros(3)
    dashed: Keywords = {"lw": 1.0, "ls": (0, (4, 1.6))}
    drawing.line(np.array([origin, P]), color=INK, lw=1.3)
    drawing.line(np.array([origin, behind]), color=ELEVATION, **dashed)
    drawing.line(np.array([origin, flat]), color=AZIMUTH, **dashed)
    for foot in (flat, behind):
        drawing.line(np.array([P, foot]), color=GREY, lw=0.7, ls=(0, (1, 1.6)))
    for foot in (flat, behind):
        drawing.line(np.array([tips[0] * P[0] / tips[0, 0], foot]), color=GREY, lw=0.5, ls=":")
    along = np.array([P[0], 0.0, 0.0])
    said = []
    for ends, share, colour, name, value in (
        ((along, flat), 0.82, AZIMUTH, "θ", theta),
        ((along, behind), 0.62, ELEVATION, "φ′", phi),
        ((flat, P), 0.72, SPHERICAL, "φ", spherical),
    ):
        way = _angle(drawing, *ends, share, colour)
        said.append((way[12:29:4], f"{name} = {number(value, 2, sign=True)}°", colour))
    for place in (P, behind):
        drawing.line(place[None], marker="o", color=INK, ms=4.0, zorder=5, weight=5.0)
    drawing.line(np.zeros((1, 3)), marker="s", color=INK, ms=6.0, zorder=5, weight=5.0)
    _names(drawing, point, P, behind, side)
    for way, text, colour in said:
        how: Keywords = {"weight": "bold", "color": colour, "size": BODY_PT, "bbox": BOX}
        drawing.name(way, text, **how)
    for tip, name in zip(tips, ("x, forward", "y, left", "z, up"), strict=True):
        drawing.name(tip, name, color=GREY)
    inside = np.array([[x, 0.0, z] for z in (0.85, 0.7, 0.97) for x in (0.3, 0.5, 0.2, 0.7, 0.9)])
    drawing.name(inside * P, "XZ plane", (0, 0), color=ELEVATION)
    return sheet.figure


def _names(drawing: Stage, point: np.ndarray, P: np.ndarray, behind: np.ndarray, side: int) -> None:
    """Names of P, P' and the station; `side` is +1 where x points to the left."""
    metres = ", ".join(number(float(v), 3, sign=True) for v in point)
    up = np.sign(P[2])
    drawing.name(P, f"P = ({metres}) m", (14.0 * side, 5.0 * up), **BOLD)
    drawing.name(behind, "P′", (-4.0 * side, 2.5 * up), **BOLD)
    drawing.name(np.zeros(3), "laser of the station", (15.0 * side, 2.5), bbox=BOX)


def _clearest_look(points: np.ndarray, side: int) -> Projection:
    """The view in which the lines from the origin to these points are farthest apart."""

    def least(look: Projection) -> float:
        turn = np.sort(np.arctan2(*look.flat(points).T[::-1]))
        return float(np.diff(np.append(turn, turn[0] + 2 * np.pi)).min())

    every = [Projection(side * a, e) for a in range(36, 70, 4) for e in range(14, 38, 4)]
    return max(every, key=least)


def _least_deg(point: np.ndarray, stretch: int) -> float:
    ratio = stretch * np.abs(point[1:]) / point[0]
    return float(np.degrees(np.arctan(ratio)).min())


def _plane(drawing: Stage, P: np.ndarray) -> None:
    corners = np.array([[0, 0, 0], [1.1, 0, 0], [1.1, 0, 1.1], [0, 0, 1.1]]) * P
    drawing.fill(corners, color=ELEVATION, alpha=0.07, lw=0, zorder=0)


def _angle(
    drawing: Stage, start: np.ndarray, end: np.ndarray, share: float, colour: str
) -> np.ndarray:
    """Draw an arc from the direction of one point to that of another; return its points."""
    a, b = start / np.linalg.norm(start), end / np.linalg.norm(end)
    whole = np.arccos(np.clip(a @ b, -1, 1))
    s = np.linspace(0, 1, 40)[:, None]
    way: np.ndarray = (np.sin((1 - s) * whole) * a + np.sin(s * whole) * b) / np.sin(whole)
    way = share * np.linalg.norm(start) * way
    drawing.curve(way, color=colour, lw=1.2)
    return way
