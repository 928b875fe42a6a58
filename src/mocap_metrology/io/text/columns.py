"""What the columns of a table are, by their names: frame, time, positions, quaternions.

A name is a label and an axis, as exporters write them: `A_x`, `A.X`, `A X`, `A:x`, `A/x`, `x_A`,
`C7[0]`, `X1`, or an axis under a label in the row above. A position without a label is that of the
only marker or body. `i j k` beside `w` and `x y z` of a group that has a `w` are a quaternion; its
group belongs to a position of the same label, apart from words as `position` and `orientation`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.text.layout import RotationColumns, Triple
from mocap_metrology.io.units import MM, LengthUnit, read_unit, unknown

BODY_LABEL = "tracker"
MARKER_LABEL = "marker"
FRAME = re.compile(r"(frame|sample|index)([ _]?(#|no\.?|nr\.?|number))?|#|field #", re.I)
TIME = re.compile(r"(%|__)?time|time[ _]?stamps?|elapsed[ _]time|t|secs?|seconds", re.I)
SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
SECONDS |= {"msec": 1e-3, "milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*([a-zA-Z].*?|)\s*[\])]")
LENGTH = re.compile(
    r"(.*\b[xyz]\d*|.*_[xyz])(?:[_ ]|\s*/\s*)(mm|cm|m|[u\u00b5\u03bc]m|in|inch|ft)", re.I
)
DURATION = re.compile(r"(t|time|time_?stamp)(?:_|\s*/\s*)(s|ms|us|ns)", re.I)
INDEX = re.compile(r"(.*)\[([0-3])\]")
BARE = {"x": ("", "x"), "y": ("", "y"), "z": ("", "z")}
BARE |= {"w": ("q", "w"), "i": ("q", "x"), "j": ("q", "y"), "k": ("q", "z")}
SHORT = re.compile(r"((?:.*[ _./:-])?[ptq])([wxyz]|(?<=q)0)", re.I)  # NDI: Q0 Qx Qy Qz
LABEL_FIRST = re.compile(
    r"(.*?)[ _./:-]+([wxyz])|(.*(?:pos|position|quat|quaternion|orientation))([wxyz])", re.I
)
AXIS_FIRST = re.compile(r"([xyz])(?:[ _./:-]+(.+)|(\d+))", re.I)
OF_TURN = r"q|quat|quaternion|orientation"
PART = re.compile(
    rf"(^|[ _./:-])(p|pos|position|t|trans|translation|rot|rotation|{OF_TURN})(?=$|[ _./:-])", re.I
)
TURN = re.compile(rf"(?:^|[ _./:-])(?:{OF_TURN})(?=$|[ _./:-])", re.I)
OTHER = re.compile(
    r"(?:^|[ _./:-])(?:v|vel|velocity|acc|accel|acceleration|accelerometer|gyro?|gyroscope|mag|"
    r"magnetometer|omega|force|moment|torque|angles?|euler|rpy|twist|linear|angular|rot|rotation|"
    r"dot|sd|std|sigma|cov)(?=$|[ _./:-])",
    re.I,
)
NO_UNIT = "no column names the unit of its coordinates: state it, m or mm"


@dataclass(frozen=True)
class Columns:
    """Places (from 0) of what is known; `second`: of the unit of the times."""

    labels: tuple[str, ...]
    positions: tuple[Triple, ...]
    rotations: Mapping[int, RotationColumns]
    unit: LengthUnit
    frame: int | None
    time: int | None
    second: float


def find_columns(names: Sequence[str], where: str) -> Columns | None:
    """What the columns with these names are; None where no three of them are a position.

    Refuses a name that stands twice, and a group that lacks an axis. `where`: file and line of
    the names, for messages.
    """
    groups: dict[str, dict[str, int]] = {}
    units: list[str] = []
    frame = time = None
    second = 1.0
    for place, name in enumerate(names):
        bare, unit = _unit_of(name)
        if (TIME.fullmatch(bare) or FRAME.fullmatch(bare)) and name in names[:place]:
            raise _twice(where, names, names.index(name), place)
        if TIME.fullmatch(bare) and unit.lower() in SECONDS:
            if time is None:
                time, second = place, SECONDS[unit.lower()]
        elif FRAME.fullmatch(bare):
            frame = place if frame is None else frame
        elif (match := _axis(bare)) and (not unit or unit.lower() in MM):
            label, axis = match
            group = groups.setdefault(label, {})
            if axis in group:
                raise _twice(where, names, group[axis], place)
            group[axis] = place
            units += [unit] if unit else []
    positions, turns = _kinds(groups, where)
    if not positions:
        return None
    pairs = _pairs(positions, turns)
    labels = [
        PART.sub("", label).strip(" _./:-") if label in pairs else label for label in positions
    ]
    return Columns(
        tuple(label or (BODY_LABEL if pairs else MARKER_LABEL) for label in labels),
        tuple(positions.values()),
        {
            k: RotationColumns(turns[pairs[label]], "quaternion")
            for k, label in enumerate(positions)
            if label in pairs
        },
        read_unit(units, "unit of the columns", where) if units else unknown(NO_UNIT),
        frame,
        time,
        second,
    )


def _twice(where: str, names: Sequence[str], first: int, second: int) -> Refusal:
    one, other = names[first][:40], names[second][:40]
    what = f"both {one!r}" if one == other else f"the same coordinate, {one!r} and {other!r}"
    return Refusal(f"{where}: columns {first + 1} and {second + 1} are {what}")


def _unit_of(name: str) -> tuple[str, str]:
    """A name without its unit, and the unit, empty where it names none."""
    match = BRACKETS.fullmatch(name) or LENGTH.fullmatch(name) or DURATION.fullmatch(name)
    return (match[1].strip(), match[2]) if match else (name.strip(), "")


def _axis(name: str) -> tuple[str, str] | None:
    """Label and axis (w, x, y, z) of a column; None for any other."""
    if match := INDEX.fullmatch(name):
        return (match[1].strip(), "xyz"[int(match[2])]) if match[2] != "3" else None
    if name.lower() in BARE:
        return BARE[name.lower()]
    if match := SHORT.fullmatch(name) or LABEL_FIRST.fullmatch(name):
        label, axis = (part for part in match.groups() if part is not None)
        return label.strip(), axis.lower().replace("0", "w")
    if match := AXIS_FIRST.fullmatch(name):
        return (match[2] or match[3]).strip(), match[1].lower()
    return None


def _kinds(
    groups: Mapping[str, Mapping[str, int]], where: str
) -> tuple[dict[str, Triple], dict[str, tuple[int, ...]]]:
    """Columns of positions and of quaternions x, y, z, w by label; velocities and the like go."""
    positions: dict[str, Triple] = {}
    turns: dict[str, tuple[int, ...]] = {}
    for label, group in groups.items():
        of_turn = "w" in group or bool(TURN.search(label))
        if group.keys() == {"w"} or (OTHER.search(label) and not of_turn):
            continue
        axes = "xyzw" if of_turn else "xyz"
        if lacking := [axis for axis in axes if axis not in group]:
            there = ", ".join(axis for axis in axes if axis in group)
            named = f"{label!r} has the columns {there}" if label else f"there are {there}"
            raise Refusal(f"{where}: {named}, but not {', '.join(lacking)}")
        if of_turn:
            turns[label] = tuple(group[axis] for axis in axes)
        else:
            positions[label] = (group["x"], group["y"], group["z"])
    return positions, turns


def _pairs(positions: Iterable[str], turns: Iterable[str]) -> dict[str, str]:
    """Label of the quaternion of each position that has one."""
    if len(list(positions)) == 1 == len(list(turns)):
        return dict(zip(positions, turns, strict=True))
    by_label = {PART.sub("", label).strip(" _./:-"): label for label in turns}
    pairs = {label: by_label.get(PART.sub("", label).strip(" _./:-")) for label in positions}
    return {label: turn for label, turn in pairs.items() if turn is not None}
