"""Twins of recordings: every key of the file of twins, and what is simulated of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from mocap_metrology.common.entries import (
    AnyNumber,
    Entry,
    NonNegative,
    Number,
    Positive,
    Text,
    Whole,
    list_of,
    one_of,
    read_entry,
    some_of,
)
from mocap_metrology.common.faults import Unfit
from mocap_metrology.noise.model.components import FORMS, NoiseModel, check_form
from mocap_metrology.noise.twins import twin as twins
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.noise.twins.take import FOCAL_PX, Failing, Take, TakeTwin
from mocap_metrology.noise.twins.twin import COORDINATES, Origin, Point, Twin

MOST_CAMERAS = 1000


def _two_names(value: object) -> object:
    names = tuple(value) if isinstance(value, list | tuple) else ()
    if len(names) != 2 or names[0] == names[1] or not all(isinstance(one, str) for one in names):
        raise Unfit("two names [first, second]", value)
    return names


def _whole(value: object) -> object:
    if not isinstance(value, int):
        raise Unfit("a whole number", value)
    return value


def _not_too_many(cameras: int) -> int:
    if cameras > MOST_CAMERAS:
        raise Unfit(f"{MOST_CAMERAS} at most", cameras)
    return cameras


def _split_or_omit(value: object) -> object:
    if value not in ("split", "omit"):
        raise ValueError(f"{value!r}, split or omit")
    return value


def _names(value: object) -> object:
    if not isinstance(value, list | tuple) or not all(isinstance(name, str) for name in value):
        raise Unfit("a list such as [q_c1, h_-2]", value)
    return tuple(value)


def _of_all_coordinates(value: object) -> object:
    return value if isinstance(value, dict) else dict.fromkeys(COORDINATES, value)


def _possible(coefficients: dict[str, float]) -> dict[str, float]:
    NoiseModel.from_coefficients(coefficients)
    return coefficients


Place = Annotated[tuple[AnyNumber, AnyNumber, AnyNumber], list_of(3, "three numbers [x, y, z]")]
Labels = Annotated[tuple[str, str], BeforeValidator(_two_names)]
Coefficients = Annotated[dict[str, NonNegative], AfterValidator(_possible)]


class PublishedRow(Entry):
    """A row of Tables A1-A3 of Skurowski & Pawlyta 2019."""

    MISSING = "{} is missing, as in {{camera_type: T40, n_cameras: 10}}"

    camera_type: Text
    """T40, Bonita or Vantage."""
    n_cameras: Annotated[int, BeforeValidator(_whole)]
    """2, 3, 4, 5, 6, 8 or 10; Vantage also 9."""
    gaussian: Text | None = None
    """Another row of Table 4 for the start positions."""

    def origin(self) -> Origin:
        """What a twin of this row is made of."""
        return twins.of_published(self.camera_type, self.n_cameras, self.gaussian)

    @model_validator(mode="after")
    def _is_printed(self) -> PublishedRow:
        self.origin()
        return self


class Outliers(Entry):
    """Single frames off in one coordinate, either way."""

    BEFORE_KEY = "."

    per_hour: NonNegative
    """Expected number in an hour."""
    amplitude_mm: NonNegative
    """Mean of an exponential distribution, SD of a normal one."""
    distribution: Annotated[
        Literal["exponential", "normal"],
        one_of(("exponential", "normal"), "exponential or normal"),
    ] = "exponential"
    """Distribution of the amplitude."""


class Crump(Entry):
    """A shock: every coordinate swings and calms down, each by 0.5 to 1 times the amplitude, either
    way first."""

    BEFORE_KEY = "."

    amplitude_mm: NonNegative
    """Largest amplitude."""
    decay_s: Positive
    """Time in which the amplitude falls to 1/e."""
    frequency_hz: NonNegative
    """Frequency of the oscillation."""
    time_s: NonNegative | None = None
    """Time at which it begins, from the first frame."""
    time_share: Annotated[float, Number(0, 1)] | None = None
    """The same as a share of the recording: 0.5 is half way through."""

    @model_validator(mode="after")
    def _begins_once(self) -> Crump:
        if (self.time_s is None) == (self.time_share is None):
            raise ValueError("expected either time_s or time_share")
        return self


class Gaps(Entry):
    """A marker is hidden so often, for so long on average."""

    BEFORE_KEY = "."

    per_hour: NonNegative
    """Expected number in an hour, for each marker."""
    mean_s: NonNegative
    """Mean length (exponential distribution); at least one frame."""


class Slow(Entry):
    """Noise below this frequency has one history in all twins of this take, seed, length and rate,
    each with coefficients of its own: subsets of the cameras of one recording."""

    MISSING = "{} missing, as in {{take: T40, below_hz: 0.1}}"

    take: Text
    """Name of the take."""
    below_hz: Positive
    """Highest frequency that is shared."""


class RecordingTwin(Entry):
    """A twin drawn from noise coefficients."""

    MISSING = "{} is missing, expected a whole number >= 0"

    published: PublishedRow | None = None
    """A row of Tables A1-A3 of Skurowski & Pawlyta 2019."""
    coefficients: Annotated[dict[str, Coefficients], some_of((*SERIES, "all"))] | None = None
    """Your own coefficients: series x1 y1 z1 x2 y2 z2, or `all` for the six, and L (distance),
    which sets the correlation of x1 and x2. Names h_-2 ... h_2, q_c1 T_c1, q_c2 T_c2, ..., A_s f_0;
    mm, s and Hz (h_0: mm^2/Hz, one-sided; q_c: mm/s^0.5)."""
    without: Annotated[tuple[str, ...], BeforeValidator(_names)] = ()
    """Components that are excluded from every series."""
    without_T_c_below_s: NonNegative = 0.0
    """Excludes correlated components with a shorter T_c."""
    seed: Annotated[int, Whole()]
    """The same seed gives the same recording."""
    start_mm: Annotated[tuple[Place, Place], list_of(2, "[[x, y, z], [x, y, z]]")] | None = None
    """Positions of the markers in the first frame, to which noise is added (default: Table 4)."""
    labels: Labels = Twin.labels
    """Names of the two markers in the file."""
    duration_s: Positive = Twin.duration_s
    """Length; by default, and at most, that of config.yaml."""
    frame_rate_hz: Positive = Twin.frame_rate_hz
    """Frames per second."""
    form: Text = Field(Twin.form, json_schema_extra={"enum": list(FORMS)})
    """Frames are averages over the frame period (continuous), or points (sampled); by default
    `twin_form` of config.yaml."""
    distance_line: Annotated[str, BeforeValidator(_split_or_omit)] = Field(
        Twin.distance_line, json_schema_extra={"enum": ["split", "omit"]}
    )
    """A periodic distortion of L is added half to x1 and half, with opposite sign, to x2; or it is
    omitted."""
    coherence_factor: Annotated[float, Number(0, 1)] = 1.0
    """Factor of the common part of x1 and x2."""
    yz_coherence: Annotated[float, Number(-1, 1)] = 0.0
    """Common share of y1 and y2, and of z1 and z2."""
    scale: Annotated[
        dict[str, NonNegative], some_of(COORDINATES), BeforeValidator(_of_all_coordinates)
    ] = Field(default_factory=dict)
    """Factor of the noise of a coordinate, or one number for all; the common share of x1 and x2
    remains the same."""
    drift_mm_per_h: dict[str, Place] = Field(default_factory=dict)
    """Velocity of a marker, by its label."""
    outliers: Outliers | None = None
    """Single frames off."""
    crump: Crump | None = None
    """A shock."""
    gaps: Gaps | None = None
    """Occlusions."""
    slow: Slow | None = None
    """What it shares with other twins."""
    resolution_mm: Positive | None = None
    """Step to which coordinates are rounded."""

    def origin(self) -> Origin:
        """What its positions are drawn from."""
        made = self.published.origin() if self.published else _of_coefficients(self.coefficients)
        return twins.leave_out(made, self.without, self.without_T_c_below_s)

    def made(self, name: str) -> Twin:
        """The twin of that name."""
        values = vars(self.origin())
        if self.start_mm:
            values = values | {"start_mm": self.start_mm}
        plain = {
            *("seed", "labels", "duration_s", "frame_rate_hz", "distance_line", "resolution_mm"),
            *("coherence_factor", "yz_coherence", "scale", "drift_mm_per_h"),
        }
        return Twin(
            name=name,
            **values,
            **self.model_dump(include=plain),
            form=check_form(self.form),
            outliers=twins.Outliers(**self.outliers.model_dump()) if self.outliers else None,
            crump=twins.Crump(**self.crump.model_dump()) if self.crump else None,
            gaps=twins.Gaps(**self.gaps.model_dump()) if self.gaps else None,
            slow=twins.Slow(**self.slow.model_dump()) if self.slow else None,
        )

    @model_validator(mode="after")
    def _together(self) -> RecordingTwin:
        if (self.published is None) == (self.coefficients is None):
            raise ValueError("expected either published or coefficients")
        check_form(self.form)
        _check_markers(self.drift_mm_per_h, self.labels, "drift_mm_per_h")
        self.origin()
        return self


def _of_coefficients(table: dict[str, dict[str, float]] | None) -> Origin:
    return twins.of_coefficients(table or {})


def _check_markers(drift: dict[str, Point], labels: tuple[str, str], where: str) -> None:
    for key in drift:
        if key not in labels:
            known = ", ".join(labels)
            raise ValueError(f"{where}: unknown key {key!r}, expected one of {known}")


class FailingCamera(Entry):
    """One camera is noisier than the others."""

    MISSING = "{} missing"
    BEFORE_KEY = "."

    camera: Annotated[int, Whole(1)]
    """Id of the camera."""
    times: Positive
    """Factor of its noise."""


class TakeOfCameras(Entry):
    """Two markers, seen by cameras on a scaffold round a hall of 9 x 5 x 3 m as in the paper."""

    MISSING = "{} missing"
    BEFORE_KEY = "."

    camera_type: Annotated[str, one_of(FOCAL_PX)]
    """T40, Bonita or Vantage: the optics of the cameras."""
    cameras: Annotated[int, Whole(2), AfterValidator(_not_too_many)]
    """Number of cameras; their ids are 1, 2, ..."""
    layout_seed: Annotated[int, Whole()]
    """Seed of the positions of the cameras: another value is another hall."""
    centroid_px: Positive
    """Noise of a centroid in pixels (white, SD in each direction)."""
    spread: Annotated[float, Number(0, 1)] = 0.0
    """Variation of the noise from camera to camera (SD of its logarithm)."""
    failing: FailingCamera | None = None
    """One that is so many times as noisy."""
    h_m2: NonNegative = Field(0.0, alias="h_-2")
    """Random walk of every coordinate of the markers themselves, mm^2 Hz; the same in all
    subsets."""
    drift_mm_per_h: dict[str, Place] = Field(default_factory=dict)
    """Drift of the markers, by label."""

    def made(self) -> Take:
        """The take."""
        plain = self.model_dump(exclude={"failing"})
        failing = Failing(**self.failing.model_dump()) if self.failing else None
        return Take(**plain, failing=failing)

    @field_validator("failing")
    @classmethod
    def _is_there(cls, failing: FailingCamera | None, info: ValidationInfo) -> FailingCamera | None:
        cameras = info.data.get("cameras")
        if failing and cameras and failing.camera > cameras:
            raise Unfit(f"one from 1 to {cameras}", failing.camera, ".camera")
        return failing


class SubsetTwin(Entry):
    """A twin triangulated from some of the cameras of a take by least squares. Twins of one `take`
    and one `seed` are recordings of the same frames, as subsets of a real take are."""

    MISSING = "{} missing"

    take: TakeOfCameras
    """The take."""
    camera_ids: tuple[int, ...]
    """The cameras of this recording, as in its row of the sheet."""
    seed: Annotated[int, Whole()]
    """The same seed gives the same recording."""
    duration_s: Positive = TakeTwin.duration_s
    """Length; by default, and at most, that of config.yaml."""
    frame_rate_hz: Positive = TakeTwin.frame_rate_hz
    """Frames per second."""
    labels: Labels = TakeTwin.labels
    """Names of the two markers in the file."""
    form: ClassVar[str] = "sampled"

    def made(self, name: str) -> TakeTwin:
        """The twin of that name."""
        plain = self.model_dump(exclude={"take"})
        return TakeTwin(name=name, take=self.take.made(), **plain)

    @field_validator("camera_ids", mode="before")
    @classmethod
    def _of_take(cls, value: object, info: ValidationInfo) -> object:
        if "take" not in info.data:
            return ()
        n = info.data["take"].cameras
        ids = tuple(value) if isinstance(value, list | tuple) else ()
        right = all(type(one) is int and 1 <= one <= n for one in ids)
        if not right or len(ids) < 2 or len(set(ids)) < len(ids):
            raise Unfit(f"two or more different whole numbers from 1 to {n}", value)
        return ids

    @model_validator(mode="after")
    def _together(self) -> SubsetTwin:
        _check_markers(self.take.drift_mm_per_h, self.labels, "take.drift_mm_per_h")
        return self


AnyTwin = RecordingTwin | SubsetTwin


def recording_twin(
    entry: Mapping[str, object], name: str, defaults: Mapping[str, object] | None = None
) -> AnyTwin:
    """A twin from its entry in the file of twins; missing keys have their defaults."""
    defaults = defaults or {}
    if "take" not in entry:
        return read_entry(RecordingTwin, {**defaults, **entry}, f"twin {name}")
    common = {key: value for key, value in defaults.items() if key in SubsetTwin.model_fields}
    return read_entry(SubsetTwin, {**common, **entry}, f"twin {name}")


def twin_from_mapping(mapping: Mapping[str, object], name: str = "twin") -> Twin:
    """A twin drawn from noise coefficients, of its entry alone."""
    return read_entry(RecordingTwin, mapping, f"twin {name}").made(name)


def take_twin_from_mapping(mapping: Mapping[str, object], name: str = "twin") -> TakeTwin:
    """A subset of a take, of its entry alone."""
    return read_entry(SubsetTwin, mapping, f"twin {name}").made(name)
