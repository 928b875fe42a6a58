"""Rows of config/recordings.tsv."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import date, datetime
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, field_validator

from mocap_metrology.common.faults import Unfit, unfit, unknown
from mocap_metrology.common.sheets import parts_of
from mocap_metrology.io.header import FASTEST_HZ, SLOWEST_HZ
from mocap_workflow.rows import (
    MEASURED,
    NAME,
    NUMBER,
    SIMULATE,
    BarPose,
    Cell,
    FileOrNothing,
    Info,
    Length,
    LengthError,
    Name,
    OwnName,
    SheetRow,
    Unit,
    each_once,
    existing,
    with_point,
)

ID = "(0+|0*[1-9][0-9]{0,8})"  # of a camera; what can match in one way only fails at once


def _count(text: str | None, info: Info) -> str | int | None:
    """The number of cameras that are named, where it is not given."""
    return text or len(parts_of(info.context.cells["camera_ids"])) or None


def _pairs(texts: Iterable[str], info: Info) -> list[tuple[str, str]]:
    """`A-B` as the pair of A and B, where each is a marker; without any, the first two markers.
    A label may itself hold a `-`."""
    markers = info.data.get("markers", ())
    if not texts or "markers" not in info.data:
        return [markers[:2]] if len(markers) > 1 else []
    pairs: list[tuple[str, str]] = []
    wrong = []
    for text in texts:
        longest = 2 * max(map(len, markers), default=0) + len(" - ")
        cuts = [index for index, letter in enumerate(text[:longest]) if letter == "-"]
        splits = [(text[:cut].strip(), text[cut + 1 :].strip()) for cut in cuts]
        splits = [pair for pair in splits if set(pair) <= set(markers)]
        if not splits:
            named = ", ".join(markers) or "none: column markers is empty"
            wrong.append(Unfit(f'two of the chosen markers ({named}) joined by "-"', text))
        elif len(splits) > 1:
            ways = " or ".join(" and ".join(pair) for pair in splits)
            wrong.append(Unfit(f"a single interpretation, not several ({ways})", text))
        elif splits[0][0] == splits[0][1]:
            wrong.append(Unfit("two different markers", text))
        elif splits[0] in pairs or splits[0][::-1] in pairs:
            wrong.append(Unfit("each pair once", text))
        else:
            pairs += splits
    if wrong:
        raise unfit(wrong)
    return pairs


class RecordingRow(SheetRow):
    """One row for each recording of markers at rest."""

    KIND = "recording"

    recording: OwnName
    """Name, unique. Results are in `<results>/recordings/<recording>/`."""
    paths: Annotated[
        tuple[str, ...],
        Cell(
            ".+",
            "a C3D file, N3D or text (.trc, .csv, .tsv, .txt), several segments "
            'separated by ";", or simulate:<twin>',
        ),
        each_once('files separated by ";"'),
    ] = Field(alias="path")
    """A file of one of the formats below; several segments of one recording in order, separated by
    `;`; or `simulate:<twin>` with a twin of `config/twins.yaml`. `s3://bucket/key` is a file in S3
    (`make s3` first), here and wherever a sheet names a file."""
    markers: Annotated[tuple[str, ...], each_once('labels of the markers, separated by ";"')] = ()
    """Labels of the markers to analyse, separated by `;`. At least one; may be empty for a twin,
    or with column `bar`."""
    group: Name
    """Recordings of one group share tables and, if they are two or more, figures. Rows of one group
    that differ in `n_cameras` are subsets of one take. `skurowski2019` feeds the paper's tables and
    figures, `skurowski2019-crump` its Figure 7, `skurowski2019-repaired` its Figure A1.
    `example-failing-camera` shows how one noisy camera is found from subsets that share their
    frames."""
    camera_type: str = ""
    """Free text, for tables."""
    n_cameras: Annotated[
        int | None,
        Cell("0*[1-9][0-9]{0,3}", "a whole number from 1 to 9999, or nothing"),
        BeforeValidator(_count),
    ] = None
    """Number of cameras that saw the markers. If empty, the number of `camera_ids`."""
    camera_ids: Annotated[
        tuple[int, ...],
        Cell(
            rf"{ID}(\s*;\s*{ID})*",
            'whole numbers separated by ";", each of at most 9 digits, or nothing',
        ),
    ] = ()
    """Their numbers, separated by `;`; as many as `n_cameras`. For a twin made of single cameras,
    those of the twin."""
    pairs: Annotated[tuple[tuple[str, str], ...], BeforeValidator(_pairs)] = ()
    """Pairs of these markers whose distance is analysed: `A-B;C-D`. If empty, the first two
    markers. A label may contain `-` as long as there is only one way to read the pair."""
    frame_rate_hz: Annotated[
        float | None,
        Cell(f"(?![1-9][0-9]*,000$){NUMBER}", "a number of Hz > 0 (1000, not 1,000), or nothing"),
        BeforeValidator(with_point),
    ] = None
    """Frame rate where the file has none, or more exactly than in the file (within 0.1 %)."""
    unit: Unit = None
    """Unit of the coordinates, `mm` or `m`, where the file names none or a wrong one. A file whose
    coordinates all lie within 20 mm of the origin, or beyond 100 m, is refused until it is stated.
    """
    column_names: Annotated[
        str | None, Cell(".*[xX].*", "names of columns such as t x y z, or nothing")
    ] = None
    """Names of the columns of a table (`.csv`, `.tsv`, `.txt`, `.tum`) that has none or wrong ones,
    in their order: `t x y z qx qy qz qw` for TUM, `A_x A_y A_z B_x B_y B_z` for markers."""
    accept_truncated: Annotated[
        bool, Cell("accept", "accept or nothing"), BeforeValidator(bool)
    ] = Field(default=False, alias="truncated")
    """`accept` uses the frames that are there of a file that was cut off; otherwise the file is
    refused."""
    sha256: Annotated[
        tuple[str, ...],
        MEASURED,
        Cell(
            r"[0-9A-Fa-f]{64}(\s*;\s*[0-9A-Fa-f]{64})*",
            '64 hexadecimal digits for each file, separated by ";", or nothing',
        ),
    ] = ()
    """Checksum of the file; for several files one each, separated by `;`. Not for twins."""
    date: Annotated[
        str | None,  # no zone: all recordings of a laboratory are dated by the same clock
        Cell(
            "[0-9]{4}-[0-9]{2}-[0-9]{2}([T ][0-9]{2}:[0-9]{2}(:[0-9]{2})?)?",
            "a date such as 2019-03-25, with or without a time such as 2019-03-25T21:30, "
            "or nothing",
        ),
    ] = None
    """Date of the recording: `2019-03-25` or `2019-03-25T21:30`, by the laboratory's clock. Rows of
    one group with the same `camera_type`, `n_cameras`, `camera_ids` and `markers` are compared with
    the one before; three days or more make a trend."""
    compare_with: str | None = None
    """Name of another recording of the sheet with which this one is compared, for example after a
    repair. It may be in another group."""
    covariate: FileOrNothing = None
    """CSV file `time_s,<name>` of a quantity that was recorded at the same time, such as a
    temperature; time in s from the first frame."""
    cluster: Annotated[tuple[str, ...], each_once('labels of markers, separated by ";"')] = ()
    """Three or more of `markers` on one rigid body, separated by `;`: the noise of its orientation
    is analysed as well."""
    place: Annotated[
        str | None,
        Cell("[A-Za-z0-9_. -]*", 'a name of letters, digits, spaces, "_", "." and "-", or nothing'),
    ] = None
    """Name of the place in the volume. Two places or more in a group make a table of noise by
    place."""
    bar: Annotated[
        str | None, Cell("auto|.+-.+", 'two markers joined by "-", auto, or nothing')
    ] = None
    """Two markers or bodies on one stiff object that is moved through the volume, `A-B`: the
    verdict is then of the errors of their distance, in `bar.json`. `auto` finds rigid clusters of
    markers and uses the longest pair of the one seen most. Rows of one group are passes: three or
    more give intervals, in `<group>_bar`."""
    length_mm: Length = None
    """Certified distance of these two. Without it only precision is stated, not accuracy."""
    length_u_mm: LengthError = None
    """Standard uncertainty of `length_mm`, mounting included."""
    bar_pose: BarPose = None
    """Rotation of body B in A, as JSON: `{"quaternion_xyzw": [0, 0, 0, 1], "u_deg": 0.1}`, `u_deg`
    its standard uncertainty. If empty, angles are about their mean."""
    point: str | None = None
    """Name of the reference point at which the first of `markers` (or the body) was recorded. Five
    points or more of a group (six of a body that is turned) are compared with `reference`, in
    `<group>_points`. Column `date` is their order, else their names."""
    reference: FileOrNothing = None
    """CSV file `point,x_mm,y_mm,z_mm` and, where it is known, `u_mm`, the standard uncertainty:
    where a better system measured these points. The same for all rows of a group."""
    monitor: Annotated[str | None, NAME] = None
    """Name of a facility whose takes are charted over time, `<results>/monitors/<monitor>/`: a
    minute a day or week of the same object in the same place. Its rows have dates and stand in
    their order; markers, pairs and cameras are the same from one `restart` to the next."""
    baseline: Annotated[
        Literal["yes", "restart"] | None, Cell("yes|restart", "yes, restart or nothing")
    ] = None
    """`yes`: the take belongs to the baseline with which later ones are compared; where no row has
    it, the first ten takes do that are within the tolerance. `restart`: the baseline begins anew
    with this take, as after a calibration."""
    comment: str = ""
    """Free text."""

    @property
    def about(self) -> str:
        """What is judged: a `bar` that is moved, or `noise` at rest."""
        return "bar" if self.bar else "noise"

    @field_validator("cluster", "covariate", "compare_with", "point", "monitor")
    @classmethod
    def _at_rest(cls, value: object, info: Info) -> object:
        if value and info.context.cells.get("bar"):
            raise Unfit("nothing in a row with a bar in column bar, which is moved")
        return value

    @field_validator("reference")
    @classmethod
    def _of_a_point(cls, reference: str | None, info: Info) -> str | None:
        if bool(reference) != bool(info.data.get("point")):
            raise Unfit("a file where there is a name in column point, else nothing")
        return reference

    @field_validator("paths")
    @classmethod
    def _files(cls, paths: tuple[str, ...], info: Info) -> tuple[str, ...]:
        if info.context.is_simulated:
            return ()
        if any(path.startswith(SIMULATE) for path in paths):
            raise Unfit(f"files, or {SIMULATE}<twin> by itself")
        checked, wrong = [], []
        for path in paths:
            try:  # a folder is one refused recording; the others are computed all the same
                checked.append(existing(path, info, any_kind=True))
            except Unfit as one:
                wrong.append(one)
        if wrong:
            raise unfit(wrong)
        return tuple(checked)

    @field_validator("markers")
    @classmethod
    def _some_markers(cls, markers: tuple[str, ...], info: Info) -> tuple[str, ...]:
        if not (markers or info.context.is_simulated or info.context.cells.get("bar")):
            raise Unfit('the labels of one or more markers of the file, separated by ";"')
        return markers

    @field_validator("camera_ids")
    @classmethod
    def _each_camera(cls, ids: tuple[int, ...], info: Info) -> tuple[int, ...]:
        n_cameras = info.data.get("n_cameras")
        if len(set(ids)) < len(ids):
            raise Unfit("each camera once")
        if ids and n_cameras is not None and len(ids) != n_cameras:
            raise Unfit(f"as many as in column n_cameras ({n_cameras})")
        return ids

    @field_validator("frame_rate_hz")
    @classmethod
    def _possible_rate(cls, rate: float | None) -> float | None:
        if rate is not None and not SLOWEST_HZ <= rate <= FASTEST_HZ:
            raise Unfit(f"a number of Hz > 0, from {SLOWEST_HZ:g} to {FASTEST_HZ:g}, or nothing")
        return rate

    @field_validator("sha256")
    @classmethod
    def _one_a_file(cls, sums: tuple[str, ...], info: Info) -> tuple[str, ...]:
        if not sums or not {"twin", "paths"} <= info.data.keys():
            return ()
        if len(sums) != len(info.data["paths"]):
            raise Unfit(f"one for each file of column path ({len(info.data['paths'])})")
        return tuple(one.lower() for one in sums)

    @field_validator("date")
    @classmethod
    def _iso_date(cls, text: str | None) -> str | None:
        """A date, or date and time, in the form of ISO 8601."""
        if text is None:
            return None
        try:
            kind = datetime if len(text) > 10 else date
            return kind.fromisoformat(text.replace(" ", "T")).isoformat()
        except ValueError as error:
            raise Unfit(f"a day and time that exist ({error})") from None

    @field_validator("compare_with")
    @classmethod
    def _another(cls, other: str | None, info: Info) -> str | None:
        place = info.context
        if other and other == place.cells["recording"]:
            raise Unfit("another recording than this one")
        if other and other not in place.names:
            raise Unfit(f"a recording of the sheet ({unknown(other, place.names)})")
        return other

    @field_validator("cluster")
    @classmethod
    def _of_one_body(cls, cluster: tuple[str, ...], info: Info) -> tuple[str, ...]:
        markers = info.data.get("markers")
        if not cluster or markers is None:
            return cluster
        if len(cluster) < 3 or not set(cluster) <= set(markers):
            named = ", ".join(markers) or "none: column markers is empty"
            raise Unfit(f'three or more of the chosen markers ({named}), separated by ";"')
        return cluster
