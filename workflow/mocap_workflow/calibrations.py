"""Rows of config/calibrations.tsv."""

from __future__ import annotations

from pathlib import PurePath
from typing import Annotated

from pydantic import field_validator

from mocap_metrology.common.faults import Unfit, unknown
from mocap_metrology.lighthouse import RECORDING_FORMATS
from mocap_metrology.lighthouse.known_length import DIODES, EXPECTED, FORM, STATIONS
from mocap_workflow.rows import (
    MEASURED,
    OF_BAR,
    BarPose,
    Cell,
    FileOrNothing,
    Info,
    Labels,
    Length,
    LengthError,
    Name,
    Needs,
    OwnName,
    SheetRow,
    Unit,
    existing,
    file_or_none,
)

POSE_FILE = ".json"
OF_RECEIVER = Needs("receiver", "a file")


def _other_end(bar: str, board: str, kind: str) -> str | None:
    """`other` of `T20-other:T21`, None of `T20-T21`."""
    name = board if kind == "libsurvive-rec" else PurePath(board).stem
    return bar.removeprefix(f"{name}-").rpartition(":")[0] if ":" in bar else None


class CalibrationRow(SheetRow):
    """One row a recording of a board of photodiodes moved before two base stations."""

    KIND = "calibration"

    calibration: OwnName
    """Name, unique. Results are in `<results>/calibrations/<calibration>/`."""
    setup: Name
    """Calibrations of one setup repeat the same poses of the stations. In group `jansen2019`,
    setups `1` to `8` feed Tables I and II, `sim-*` and `noise-*` Table III."""
    group: Name
    """Calibrations of one group share a table. `jansen2019` feeds the paper's tables."""
    path: Annotated[str | None, Cell(".+", "a file or simulate:<twin>")]
    """The recording, or `simulate:<twin>` with a Lighthouse twin of `config/twins.yaml`."""
    format: Annotated[
        str, Cell("|".join(RECORDING_FORMATS), f"one of {', '.join(RECORDING_FORMATS)}")
    ]
    """Of the recording, see below: `gpio-dump`, `libsurvive-rec`, `crazyflie-uart`,
    `crazyflie-log`, `angles-csv` or `lfsr-counts`."""
    board: str | None = None
    """CSV file `x_m,y_m,z_m` in diode order, metres; for `libsurvive-rec` the name of the tracked
    object in the recording, or its serial number. May be empty for a twin."""
    factory: FileOrNothing = None
    """Optional file of factory values for stations whose own values cannot be read from the
    recording: a `stations.json` of this workflow, the `.json` that libsurvive writes beside a
    recording, or the system configuration (`.yaml`) of a Crazyflie, whose station 0 flashes first
    and is the master. Stations of the second generation are matched by id, or by channel where the
    recording has no id."""
    reference: FileOrNothing = None
    """Optional pose to compare with: JSON (`R` or `quaternion_xyzw`, `t_m` or `translation_mm`,
    `stations: {master: id, slave: id}`), the system configuration of a Crazyflie, the configuration
    of libsurvive, or a C3D file with markers on both housings. Of V2 stations a file with the poses
    of all, in one frame of any kind: a `pose.json` of this project, one of these configurations, or
    JSON `{"stations": {"3": {"id": ..., "R": ..., "t_m": ...}, ...}}` by channel."""
    reference_labels_master: Labels = ()
    """Labels of the markers on the housing of the master, separated by `;`; required for a C3D
    reference, not allowed otherwise."""
    reference_labels_slave: Labels = ()
    """The same for the slave."""
    reference_unit: Unit = None
    """Unit of a C3D reference, `mm` or `m`, where the file names none or a wrong one."""
    mount: FileOrNothing = None
    """CSV file `label,x_m,y_m,z_m`: these markers in the frame of the housing. Needed for a C3D
    reference."""
    check_against: FileOrNothing = None
    """Optional earlier `pose.json`, to check whether a station has moved since."""
    tracked_with: str | None = None
    """Optional: stations to track the board with, in place of this recording's own calibration: the
    name of another calibration of the sheet that has none itself, or a `pose.json`."""
    world_points: FileOrNothing = None
    """Optional CSV file `label,x_m,y_m,z_m`: places that were measured in the room, three or more
    and not on one line. Its frame is then that of the exported poses. A label is `master` or
    `slave` (the origin of this station), `diode 3` (where this diode of the board was at the start
    of the recording) or `diode 3 at 12.5 s`; hold the board still there for 0.2 s."""
    known_length: Annotated[str | None, Cell(FORM, EXPECTED)] = None
    """Optional length in the room, which shows the scale that angles do not: `stations 4.330
    0.005`, the distance of the stations' origins and its standard deviation in m (V2: `stations
    3-11 4.330 0.005`, by channel); `diode 0 at 2.0 s - diode 0 at 7.0 s 2.000 0.002`, that of two
    places of a diode at these moments; or `points`, the size of the figure of `world_points` (5 mm
    a coordinate; `points 0.002`: 2 mm)."""
    bar: Annotated[str | None, MEASURED, Cell(".+-.+", 'two objects joined by "-", or nothing')] = (
        None
    )
    """Optional: two objects on one stiff bar (second generation), by their names in the recording
    or, as names can be exchanged from one recording to the next, by their serial numbers:
    `T20-T21`, of which one is the board; or `T20-other:T21`, the board of another row `other` of
    the setup. Each is tracked alone; the errors of the distance of their heads are in `bar.json`
    and `bar.csv`. The bar only checks."""
    length_mm: Length = None
    """Certified distance of their heads (where a recording describes none: of the origins of their
    diodes' places). Without it only precision is stated, not accuracy. Not the `known_length`."""
    length_u_mm: Annotated[LengthError, OF_BAR] = None
    """Standard uncertainty of `length_mm`, mounting included."""
    bar_pose: BarPose = None
    """Rotation of head B in A, as JSON: `{"quaternion_xyzw": [0, 0, 0, 1], "u_deg": 0.1}`, `u_deg`
    its standard uncertainty. If empty, angles are about their mean."""
    receiver: Annotated[FileOrNothing, MEASURED] = None
    """Optional motion capture (C3D or any other format of a recording) of markers on the board
    while it was recorded: the tracked path and the places of the stations against it, in
    `receiver.json`. Both clocks and frames may differ. It only checks."""
    receiver_labels: Annotated[Labels, MEASURED, OF_RECEIVER] = ()
    """Labels of these markers, separated by `;`. If empty, all of the file. Three or more that are
    on no line also show the attitude."""
    receiver_unit: Annotated[Unit, MEASURED, OF_RECEIVER] = None
    """Unit of `receiver`, `mm` or `m`, where the file names none or a wrong one."""
    sha256: Annotated[
        str | None, MEASURED, Cell("[0-9A-Fa-f]{64}", "64 hexadecimal digits or nothing")
    ] = None
    """Optional checksum of the recording. Not for twins."""
    comment: str = ""
    """Free text."""

    @property
    def tracked_with_file(self) -> str | None:
        """`tracked_with` if it is a file."""
        name = self.tracked_with
        return name if name and name.endswith(POSE_FILE) else None

    @property
    def tracked_with_row(self) -> str | None:
        """`tracked_with` if it is another row of the sheet."""
        return None if self.tracked_with_file else self.tracked_with

    @property
    def bar_row(self) -> str | None:
        """The other row of the sheet whose board is an end of `bar`."""
        return None if self.bar is None else _other_end(self.bar, str(self.board), self.format)

    @field_validator("path")
    @classmethod
    def _one_file(cls, path: str, info: Info) -> str | None:
        return None if info.context.is_simulated else existing(path, info)

    @field_validator("board")
    @classmethod
    def _of_format(cls, board: str | None, info: Info) -> str | None:
        """A CSV of diodes, or for a libsurvive recording the name of the tracked object in it."""
        named = info.context.cells["format"] == "libsurvive-rec"
        if not board and not info.context.is_simulated:
            name = "the name of the tracked object in the recording"
            raise Unfit(name if named else "a CSV file x_m,y_m,z_m in diode order")
        return board if named else file_or_none(board, info)

    @field_validator("reference_labels_master", "reference_labels_slave", "reference_unit")
    @classmethod
    def _of_c3d(cls, value: object, info: Info) -> object:
        """A C3D reference needs the labels of both housings, no other has a use for them."""
        is_c3d = PurePath(info.context.cells["reference"]).suffix.lower() == ".c3d"
        if value and not is_c3d:
            raise Unfit("nothing, as the reference is no C3D file")
        if is_c3d and value == ():
            raise Unfit('labels separated by ";", as the reference is a C3D file')
        return value

    @field_validator("known_length")
    @classmethod
    def _of_points(cls, length: str | None, info: Info) -> str | None:
        """The size of points needs their file."""
        if length and length.startswith("points") and not info.context.cells["world_points"]:
            raise Unfit("a length, as the row names no world_points")
        return length

    @field_validator("bar")
    @classmethod
    def _of_objects(cls, bar: str | None, info: Info) -> str | None:
        cells = info.context.cells
        other = _other_end(bar, cells["board"], cells["format"]) if bar else None
        if other is not None and other not in info.context.names:
            why = unknown(other, info.context.names)
            raise Unfit(f"the board, -, a calibration of the sheet ({why}), : and its board")
        return bar

    @field_validator("length_mm")
    @classmethod
    def _not_used(cls, length: float | None, info: Info) -> float | None:
        used = info.context.cells["known_length"]
        known = STATIONS.fullmatch(used) or DIODES.fullmatch(used)
        if (
            length
            and known
            and abs(1e3 * float(known["length"]) - length) <= 1e3 * float(known["sd"])
        ):
            raise Unfit("another length than known_length: what a calibration uses checks none")
        return length

    @field_validator("tracked_with")
    @classmethod
    def _other_stations(cls, other: str | None, info: Info) -> str | None:
        """Another row, or a file."""
        place = info.context
        if not other or other.endswith(POSE_FILE):
            return file_or_none(other, info)
        if other == place.cells["calibration"]:
            raise Unfit("another calibration, or nothing for its own")
        if other not in place.names:
            why = unknown(other, place.names)
            raise Unfit(f"a calibration of the sheet ({why}), or a file {POSE_FILE}")
        return other

    @field_validator("sha256")
    @classmethod
    def _of_file(cls, digits: str | None) -> str | None:
        return digits.lower() if digits else None
