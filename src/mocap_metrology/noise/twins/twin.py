"""Twins: what is simulated in place of a recording. Every field is a key of the file of twins, with
its range, default and meaning, but for those marked `MADE`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass as plain_dataclass
from dataclasses import replace
from datetime import date
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, InstanceOf, model_validator
from pydantic.dataclasses import dataclass

from mocap_metrology.common.entries import (
    ENTRY,
    MADE,
    AnyNumber,
    NonNegative,
    Number,
    Positive,
    Text,
    Whole,
    list_of,
    one_of,
    some_of,
)
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.faults import Unfit
from mocap_metrology.noise.model.components import FORMS, Form, NoiseModel
from mocap_metrology.noise.twins.published import (
    SERIES,
    published_gaussian,
    published_notes,
    published_row,
)

COORDINATES = SERIES[:6]
Point = tuple[float, float, float]
UNSET: Any = None  # of a value that depends on others


def _of_all_coordinates(value: object) -> object:
    return value if isinstance(value, Mapping) else dict.fromkeys(COORDINATES, value)


def _possible(coefficients: dict[str, float]) -> dict[str, float]:
    NoiseModel.from_coefficients(coefficients)
    return coefficients


def _day(value: object) -> object:
    try:
        return date.fromisoformat(str(value)).isoformat()
    except ValueError:
        raise Unfit("a day such as 2026-03-16", value) from None


Place = Annotated[tuple[AnyNumber, AnyNumber, AnyNumber], list_of(3, "three numbers [x, y, z]")]
Labels = Annotated[tuple[str, str], list_of(2, "two names [first, second]", str, distinct=True)]
CHANGES = "a list such as [{since: 2026-03-16, place_mm: [1, 0, 0]}]"
Coefficients = Annotated[dict[str, NonNegative], AfterValidator(_possible)]


@dataclass(frozen=True, config=ENTRY)
class PublishedRow:
    """A row of Tables A1-A3 of Skurowski & Pawlyta 2019."""

    camera_type: Text
    """T40, Bonita or Vantage."""
    n_cameras: Annotated[int, Whole(1)]
    """2, 3, 4, 5, 6, 8 or 10; Vantage also 9."""
    gaussian: Text | None = None
    """Another row of Table 4 for the start positions."""

    @model_validator(mode="after")
    def _is_printed(self) -> PublishedRow:
        of_published(self.camera_type, self.n_cameras, self.gaussian)
        return self


@dataclass(frozen=True, config=ENTRY)
class Outliers:
    """Single frames in which one random coordinate of one marker is off, either way (Poisson)."""

    per_hour: NonNegative
    """Expected number in an hour."""
    amplitude_mm: NonNegative
    """Mean of an exponential distribution, SD of a normal one."""
    distribution: Annotated[
        Literal["exponential", "normal"], one_of(("exponential", "normal"), "exponential or normal")
    ] = "exponential"
    """Distribution of the amplitude."""


@dataclass(frozen=True, config=ENTRY)
class Crump:
    """A shock: every coordinate swings as w A exp(-t/decay) sin(2 pi f t), w random for each, 0.5
    to 1 with either sign, so the distance moves too (S section 3.5, Figure 7)."""

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

    def start_s(self, duration_s: float) -> float:
        """When it begins in a recording of that length, in s."""
        return (self.time_s or 0.0) if self.time_share is None else self.time_share * duration_s

    @model_validator(mode="after")
    def _begins_once(self) -> Crump:
        if (self.time_s is None) == (self.time_share is None):
            raise ValueError("expected either time_s or time_share")
        return self


@dataclass(frozen=True, config=ENTRY)
class Gaps:
    """Occlusions of each marker: at exponentially distributed times, for such times."""

    per_hour: NonNegative
    """Expected number in an hour, for each marker."""
    mean_s: NonNegative
    """Mean length (exponential distribution); at least one frame."""


@dataclass(frozen=True, config=ENTRY)
class Slow:
    """Noise below this frequency has one history in all twins of this take, seed, length and rate,
    each with coefficients of its own (coherence 1 below, 0 above): subsets of the cameras of one
    recording."""

    take: Text
    """Name of the take."""
    below_hz: Positive
    """Highest frequency that is shared."""


@dataclass(frozen=True, config=ENTRY)
class Change:
    """What is otherwise at a facility from a day on."""

    since: Annotated[str, BeforeValidator(_day)]
    """First day, as 2026-03-16."""
    place_mm: Place = (0.0, 0.0, 0.0)
    """Both markers are moved by this."""
    length_mm: AnyNumber = 0.0
    """Their distance is longer by this."""
    length_mm_per_day: AnyNumber = 0.0
    """And by this with every day."""
    jitter: Positive = 1.0
    """Factor of all noise."""


@dataclass(frozen=True, config=ENTRY)
class Days:
    """A facility over dates: standard deviations from day to day, and changes that stay. Rows of a
    sheet with the same twin and other dates are its takes."""

    place_mm: NonNegative = 0.1
    """Of the place of both markers, along each axis."""
    length_mm: NonNegative = 0.05
    """Of their distance."""
    jitter: NonNegative = 0.06
    """Of the natural logarithm of a factor of all noise."""
    changes: Annotated[tuple[Change, ...], list_of(None, CHANGES)] = ()
    """A list of changes."""


@dataclass(frozen=True, config=ENTRY)
class Twin:
    """A simulated recording of two markers, drawn from noise coefficients; mm and s.

    models: noise of x1, y1, z1, x2, y2, z2 and, optionally, of the distance L, which sets how x1
    and x2 go together; those of `published` or `coefficients` where none are stated.
    """

    name: Annotated[str, MADE]
    published: PublishedRow | None = Field(default=None, kw_only=True)
    """A row of Tables A1-A3 of Skurowski & Pawlyta 2019."""
    coefficients: Annotated[dict[str, Coefficients], some_of((*SERIES, "all"))] | None = Field(
        default=None, kw_only=True
    )
    """Your own coefficients: series x1 y1 z1 x2 y2 z2, or `all` for the six, and L (distance),
    which sets the correlation of x1 and x2. Names h_-2 ... h_2, q_c1 T_c1, q_c2 T_c2, ..., A_s f_0;
    mm, s and Hz (h_0: mm^2/Hz, one-sided; q_c: mm/s^0.5)."""
    without: Annotated[tuple[str, ...], list_of(None, "a list such as [q_c1, h_-2]", str)] = Field(
        default=(), kw_only=True
    )
    """Components that are excluded from every series."""
    without_T_c_below_s: NonNegative = Field(default=0.0, kw_only=True)
    """Excludes correlated components with a shorter T_c."""
    seed: Annotated[int, Whole()]
    """The same seed gives the same recording."""
    models: Annotated[Mapping[str, InstanceOf[NoiseModel]], MADE] = Field(default_factory=dict)
    source: Annotated[str, MADE] = "coefficients of the configuration"
    start_mm: Annotated[tuple[Place, Place], list_of(2, "[[x, y, z], [x, y, z]]")] = UNSET
    """Positions of the markers in the first frame, to which noise is added (default: Table 4)."""
    labels: Labels = ("Wand1", "Wand2")
    """Names of the two markers in the file."""
    duration_s: Positive = 32400.0
    """Length; by default, and at most, that of config.yaml."""
    frame_rate_hz: Positive = 120.0
    """Frames per second."""
    form: Annotated[Form, one_of(FORMS, " or ".join(FORMS))] = "sampled"
    """Frames are averages over the frame period (continuous), or points (sampled); by default
    `twin_form` of config.yaml."""
    distance_line: Annotated[
        Literal["split", "omit"], one_of(("split", "omit"), "split or omit")
    ] = "split"
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
    days: Days | None = None
    """What differs from take to take of a facility, by the date of the row."""
    date: Annotated[str, MADE] = ""
    resolution_mm: Positive | None = None
    """Step to which coordinates are rounded."""
    notes: Annotated[tuple[str, ...], MADE] = ()

    @model_validator(mode="after")
    def _with_models(self) -> Twin:
        check_markers(self.drift_mm_per_h, self.labels, "drift_mm_per_h")
        origin = Origin(self.models, self.source, notes=self.notes)
        if not self.models:
            if (self.published is None) == (self.coefficients is None):
                raise ValueError("expected either published or coefficients")
            row = self.published
            if row is not None:
                origin = of_published(row.camera_type, row.n_cameras, row.gaussian)
            else:
                origin = of_coefficients(self.coefficients or {})
            origin = leave_out(origin, self.without, self.without_T_c_below_s)
        start_mm = origin.start_mm if self.start_mm is UNSET else self.start_mm
        for name, value in (vars(origin) | {"start_mm": start_mm}).items():
            object.__setattr__(self, name, value)
        return self


def check_markers(drift: Mapping[str, Point], labels: tuple[str, str], where: str) -> None:
    """Raise ValueError for the drift of a marker that is none of these."""
    for key in drift:
        if key not in labels:
            known = ", ".join(labels)
            raise ValueError(f"{where}: unknown key {key!r}, expected one of {known}")


@plain_dataclass(frozen=True)
class Origin:
    """What the positions of a twin are drawn from."""

    models: Mapping[str, NoiseModel]
    source: str = "coefficients of the configuration"
    start_mm: tuple[Point, Point] = ((160.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    notes: tuple[str, ...] = ()


def of_published(camera_type: str, n_cameras: int, gaussian: str | None = None) -> Origin:
    """A row of Tables A1-A3; `gaussian` names the row of Table 4 for the positions, by default that
    of the camera type. Raises `Refusal` for a row that is not printed."""
    row = camera_type if gaussian is None else gaussian
    table4 = published_gaussian(row)
    return Origin(
        models=published_row(camera_type, n_cameras),
        source=f"published coefficients of {camera_type} with {n_cameras} cameras, "
        f"positions of Table 4 row {row}",
        start_mm=wand(table4["mu_1_mm"], table4["mu_2_mm"], table4["mu_L_mm"]),
        notes=tuple(published_notes(camera_type, n_cameras)),
    )


def wand(x1: float, x2: float, distance: float) -> tuple[Point, Point]:
    """Two markers at x1 and x2 whose distance is the given one: what x lacks is put into y and z,
    in equal parts."""
    across = math.sqrt(max(0.0, distance**2 - (x1 - x2) ** 2) / 2)
    return (x1, across, across), (x2, 0.0, 0.0)


def of_coefficients(table: Mapping[str, Mapping[str, float]]) -> Origin:
    """Coefficients by series; `all`: those of the six coordinates that are not named."""
    values = {name: table.get(name, table.get("all", {})) for name in COORDINATES}
    values |= {"L": table["L"]} if "L" in table else {}
    return Origin(
        {name: NoiseModel.from_coefficients(coefficients) for name, coefficients in values.items()}
    )


def leave_out(origin: Origin, names: Sequence[str], T_c_below_s: float) -> Origin:
    """The same without these components, and without Gauss-Markov terms that are faster; notes say
    so. Raises `Refusal` for a component that no series has."""
    printed = {series: model.coefficients() for series, model in origin.models.items()}
    every = {name for values in printed.values() for name in values}
    known = sorted(name for name in every if name[:3] not in ("f_0", "T_c"))
    for name in names:
        if name not in known:
            raise Refusal(f"without: {name!r}, expected one of {', '.join(known)}")
    models, notes = {}, []
    for series, values in printed.items():
        fast = [k for k, v in values.items() if k.startswith("T_c") and v < T_c_below_s]
        gone = [n for n in names if n in values] + [f"q_c{k[3:]}" for k in fast]
        partners = [{"q_c": f"T_c{n[3:]}", "A_s": "f_0"}.get(n[:3], n) for n in gone]
        left = {k: v for k, v in values.items() if k not in (*gone, *partners)}
        models[series] = NoiseModel.from_coefficients(left)
        if gone:
            notes.append(f"{series}: omitted on request: {', '.join(dict.fromkeys(gone))}")
    return replace(origin, models=models, notes=(*origin.notes, *notes))
