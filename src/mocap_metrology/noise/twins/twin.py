"""Twins: what is simulated in place of a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.model.components import Form, NoiseModel
from mocap_metrology.noise.twins.published import (
    SERIES,
    published_gaussian,
    published_notes,
    published_row,
)

COORDINATES = SERIES[:6]
Point = tuple[float, float, float]


@dataclass(frozen=True)
class Outliers:
    """Single frames in which one random coordinate of one marker is off, either way.

    `per_hour`: expected number an hour (Poisson). `amplitude_mm`: mean of an exponential, or SD
    of a normal distribution.
    """

    per_hour: float
    amplitude_mm: float
    distribution: str = "exponential"


@dataclass(frozen=True)
class Crump:
    """A shock: every coordinate swings as w A exp(-t/decay) sin(2 pi f t), w random for each, 0.5
    to 1 with either sign, so the distance moves too (S section 3.5, Figure 7). It begins `time_s`
    after the first frame, or after the share `time_share` (0 to 1) of the recording."""

    amplitude_mm: float
    decay_s: float
    frequency_hz: float
    time_s: float | None = None
    time_share: float | None = None

    def start_s(self, duration_s: float) -> float:
        """When it begins in a recording of that length, in s."""
        return (self.time_s or 0.0) if self.time_share is None else self.time_share * duration_s


@dataclass(frozen=True)
class Gaps:
    """Occlusions: each marker is lost `per_hour` times an hour (Poisson), for an exponentially
    distributed time of mean `mean_s`, one frame at least."""

    per_hour: float
    mean_s: float


@dataclass(frozen=True)
class Slow:
    """Noise below `below_hz` is driven by the random numbers of `take`, the same in every twin of
    that take, seed, length and rate, each with its own coefficients: coherence 1 below, 0 above.
    Subsets of the cameras of one recording are such twins."""

    take: str
    below_hz: float


@dataclass(frozen=True)
class Twin:
    """Everything a simulated recording of two markers is made of; mm and s.

    `models`: noise of x1, y1, z1, x2, y2, z2 and, optionally, of the distance L, which sets how
    x1 and x2 go together. `coherence_factor` multiplies their coherence; `yz_coherence` is that
    of y1 with y2 and of z1 with z2. `scale` multiplies the noise of a coordinate and leaves the
    coherence. `distance_line`: L's sinusoid is put half into x1 and half, with the opposite sign,
    into x2 (`split`), or left out (`omit`). `form`: frames are points (`sampled`), as a camera's
    whose exposure is short, or averages over the frame period (`continuous`), whose Allan variance
    is that of the textbook formulas, in which S gives its coefficients. Positions start at
    `start_mm`; noise moves them.
    """

    name: str
    seed: int
    models: Mapping[str, NoiseModel]
    source: str = "coefficients of the configuration"
    start_mm: tuple[Point, Point] = ((160.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    labels: tuple[str, str] = ("Wand1", "Wand2")
    duration_s: float = 32400.0
    frame_rate_hz: float = 120.0
    form: Form = "sampled"
    distance_line: str = "split"
    coherence_factor: float = 1.0
    yz_coherence: float = 0.0
    scale: Mapping[str, float] = field(default_factory=dict)
    drift_mm_per_h: Mapping[str, Point] = field(default_factory=dict)
    outliers: Outliers | None = None
    crump: Crump | None = None
    gaps: Gaps | None = None
    slow: Slow | None = None
    resolution_mm: float | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Origin:
    """What the positions of a twin are drawn from."""

    models: Mapping[str, NoiseModel]
    source: str = Twin.source
    start_mm: tuple[Point, Point] = Twin.start_mm
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
    return Origin({name: NoiseModel.from_coefficients(own) for name, own in values.items()})


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
