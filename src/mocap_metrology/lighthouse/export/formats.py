"""Poses of stations in the files of other programs.

    Crazyflie   system configuration (YAML) of Bitcraze's cfclient and cflib: poses `geos`, factory
                values `calibs`; station 0 flashes first
                [crazyflie-lib-python, cflib/localization/lighthouse_config_manager.py]
    libsurvive  configuration: factory values, and poses of stations that look along -Z, X right,
                Y up; lighthouse 1 of two flashes first [libsurvive, src/survive_config.c]
    ROS 2       launch file with a static transform for each station
                [geometry2, tf2_ros/src/static_transform_broadcaster_program.cpp]

All worlds are right-handed, lengths are in metres. Numbers are written without exponents: PyYAML
takes `1e-05` for text.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np

from mocap_metrology.lighthouse.decode.factory_file import (
    CRAZYFLIE_TYPE,
    CRAZYFLIE_VERSIONS,
)
from mocap_metrology.lighthouse.decode.libsurvive_solution import (
    FACTORY2_KEYS,
    FACTORY_KEYS,
    FROM_LIBSURVIVE,
    MODES,
)
from mocap_metrology.lighthouse.export.world import Pose
from mocap_metrology.lighthouse.records import Station
from mocap_metrology.lighthouse.rotation import quaternions

DECIMALS = 12
STATION = "A station's frame: origin at its optics, x out of its glass, y to its own left, z up."
ROS_WORLD = "lighthouse_world"
AXES = ("x", "y", "z", "qx", "qy", "qz", "qw")
OGEE = ("ogeemag", "ogeephase")  # of the second generation; cflib expects them of both
# What readers of these files may not decode in every locale.
PLAIN = str.maketrans({"µ": "u", "°": " deg", "σ": "sigma", "−": "-", "×": "x"})


@dataclass(frozen=True)
class Export:
    """Stations, master first, and their poses in the world, None where there is no valid
    calibration, or none of a station; remarks: lines for whoever reads the file."""

    stations: Sequence[Station]
    poses: Sequence[Pose | None] | None
    remarks: Sequence[str]

    @property
    def placed(self) -> list[tuple[Station, Pose | None]]:
        """Each station with its pose in the frame of the export; None where it has none."""
        if self.poses is None:
            return [(station, None) for station in self.stations]
        return list(zip(self.stations, self.poses, strict=True))

    @property
    def generation(self) -> int:
        return max(station.generation for station in self.stations)

    @property
    def lines(self) -> list[str]:
        """Remarks in ASCII, one line each."""
        plain = (" ".join(line.translate(PLAIN).split()) for line in self.remarks)
        return [line.encode("ascii", "replace").decode("ascii") for line in plain]


def number(value: float) -> str:
    """A number with a point and without an exponent: 0.00001."""
    rounded = round(float(value), DECIMALS) + 0.0  # no -0.0
    return str(np.format_float_positional(rounded, trim="0"))


def crazyflie_yaml(export: Export) -> str:
    """System configuration of a Crazyflie. Without poses it has no `geos`; stations without factory
    values or id are not among `calibs`, and the Crazyflie receives these by itself."""
    lines = [*(f"# {line}" for line in [*export.lines, STATION])]
    lines += [
        f"type: {CRAZYFLIE_TYPE}",
        f"version: '{CRAZYFLIE_VERSIONS[0]}'",
        f"systemType: {export.generation}",
    ]
    placed = {  # by channel, or in the first generation by place
        place if station.channel is None else station.channel: (station, pose)
        for place, (station, pose) in enumerate(export.placed)
    }
    geos, calibs = list[str](), list[str]()
    for k, (station, pose) in sorted(placed.items()):
        calibs += _calib(k, station)
        if pose is not None:
            R, t = pose
            geos += [f"  {k}:", f"    origin: [{_listed(t)}]", "    rotation:"]
            geos += [f"    - [{_listed(row)}]" for row in R]
    for name, entries in (("geos", geos), ("calibs", calibs)):
        lines += [f"{name}:", *entries] if entries else [f"{name}: {{}}"]
    return "\n".join(lines) + "\n"


def _calib(index: int, station: Station) -> Iterator[str]:
    if station.factory is None or station.id is None:
        return
    yield f"  {index}:"
    yield f"    uid: {station.id}"
    yield "    sweeps:"
    for axis in (0, 1):
        values = {name: getattr(station.factory, name)[axis] for name in FACTORY_KEYS}
        entries = values | {name: getattr(station.factory, name)[axis] for name in OGEE}
        yield "    - {" + ", ".join(f"{k}: {number(v)}" for k, v in entries.items()) + "}"


def _listed(values: np.ndarray) -> str:
    return ", ".join(map(number, values))


def libsurvive_json(export: Export) -> str:
    """Configuration of libsurvive: the entries of an object without its braces, as libsurvive
    writes and expects them. Stations without an id are left out; without factory values (OOTXSet 0)
    or poses (PositionSet 0) libsurvive determines these itself."""
    frame = " ".join(export.lines).translate(str.maketrans('"\\', "'/"))
    entries = [f'"mocap-metrology":"{frame}"', f'"lighthouse-gen":"{export.generation}"']
    every = export.placed
    if export.generation == 1:
        every = every[::-1]  # counted from the last flash
    known = [(k, *of) for k, of in enumerate(every) if of[0].id is not None]
    entries.append(f'"lighthousecount":"{len(known)}"')
    return ",\n".join([*entries, *(_lighthouse(*of) for of in known)]) + "\n"


def _lighthouse(index: int, station: Station, pose: Pose | None) -> str:
    entries: dict[str, object] = {"index": index, "id": station.id}
    if station.channel is not None:
        entries["mode"] = station.channel
    elif station.mode is not None:
        entries["mode"] = MODES.index(station.mode)
    if pose is not None:
        R, t = pose
        entries["pose"] = [*t, *np.roll(quaternions(R @ FROM_LIBSURVIVE), 1)]
    if station.factory is not None:
        for name, key in (FACTORY_KEYS if station.generation == 1 else FACTORY2_KEYS).items():
            entries[key] = getattr(station.factory, name)
    entries["OOTXSet"] = int(station.factory is not None)
    entries["PositionSet"] = int(pose is not None)
    lines = [
        f'"{key}":"{value}"'
        if isinstance(value, int)
        else f'"{key}":[' + ",".join(f'"{number(v)}"' for v in np.asarray(value)) + "]"
        for key, value in entries.items()
    ]
    return f'"lighthouse{index}":{{\n' + ",\n".join(lines) + "\n}"


def ros2_launch(export: Export) -> str:
    """Launch file of ROS 2 (Humble or later) with a `static_transform_publisher` of tf2_ros for
    each station, from the frame `lighthouse_world` or that of the argument `frame`."""
    remarks = [line.replace("--", "- -") for line in [*export.lines, STATION]]
    lines = ["<launch>", "  <!--", *(f"    {line}" for line in remarks), "  -->"]
    lines.append(f'  <arg name="frame" default="{ROS_WORLD}"/>')
    for station, pose in export.placed:
        if pose is not None:
            R, t = pose
            label = station.role if station.id is None else f"{station.id:08x}"
            name, values = f"lighthouse_{label}", zip(AXES, [*t, *quaternions(R)], strict=True)
            args = " ".join(f"--{axis} {number(v)}" for axis, v in values)
            args += f" --frame-id $(var frame) --child-frame-id {name}"
            lines += [
                '  <node pkg="tf2_ros" exec="static_transform_publisher"',
                f'    name="{name}"',
                f"    args={quoteattr(args)}/>",
            ]
    return "\n".join([*lines, "</launch>"]) + "\n"
