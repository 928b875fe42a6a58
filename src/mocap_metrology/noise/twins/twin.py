"""Twins: what is simulated in place of a recording, and how one is read from the configuration."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.entries import (
    Point,
    check_keys,
    drifts,
    number,
    point,
    section,
    two_labels,
    whole,
)
from mocap_metrology.noise.model.components import Form, NoiseModel, check_form
from mocap_metrology.noise.twins.published import (
    SERIES,
    published_gaussian,
    published_notes,
    published_row,
)

COORDINATES = SERIES[:6]


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
        return self.time_s if self.time_share is None else self.time_share * duration_s


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


def twins_from_document(document: Mapping[str, Any]) -> dict[str, Twin]:
    """The recording twins of `{defaults: {recording: {...}}, twins: {name: {...}}}`: the entries
    that have `published` or `coefficients`. A twin's keys win over the defaults."""
    where = "twins"
    defaults = section(document.get("defaults") or {}, f"{where}: defaults")
    common = section(defaults.get("recording") or {}, f"{where}: defaults.recording")
    twins = section(document.get("twins") or {}, f"{where}: twins")
    return {
        str(name): twin_from_mapping({**common, **entry}, str(name))
        for name, entry in twins.items()
        if {"published", "coefficients"} & set(section(entry, f"twin {name}"))
    }


def twin_from_mapping(mapping: Mapping[str, Any], name: str = "twin") -> Twin:
    """A twin of its configuration entry; the entry's keys are those of `Twin` and

    `published: {camera_type, n_cameras, gaussian}` (Tables A1-A3; `gaussian` names the row of
    Table 4 for the positions, default the camera type), or `coefficients: {series: {h_0: ...}}`
    (series x1 ... z2, L, or `all` six coordinates); `without: [q_c1, ...]` (components to leave
    out of every series); `without_T_c_below_s` (leave out faster Gauss-Markov components).
    Raises `Refusal` naming the twin and the key.
    """
    where = f"twin {name}"
    given = {k: v for k, v in section(mapping, where).items() if v is not None}
    own = ("published", "coefficients", "without", "without_T_c_below_s")
    names = [f.name for f in fields(Twin) if f.name not in ("name", "models", "source", "notes")]
    check_keys(given, (*own, *names), where)
    if ("published" in given) == ("coefficients" in given):
        raise Refusal(f"{where}: expected either published or coefficients")
    build = _published if "published" in given else _from_coefficients
    values = build(given, where)
    models, left_out = _left_out(values["models"], given, where)
    values |= {"models": models, "notes": (*values["notes"], *left_out)}
    if "seed" not in given:
        raise Refusal(f"{where}: seed is missing, expected a whole number >= 0")
    values["seed"] = whole(given["seed"], f"{where}: seed")
    values |= _settings(given, where)
    values |= _effects(given, where)
    return Twin(name=name, **values)


def _published(given: Mapping[str, Any], where: str) -> dict[str, Any]:
    where = f"{where}: published"
    row = section(given["published"], where)
    check_keys(row, ("camera_type", "n_cameras", "gaussian"), where)
    for key in ("camera_type", "n_cameras"):
        if key not in row:
            raise Refusal(f"{where}: {key} is missing, as in {{camera_type: T40, n_cameras: 10}}")
    kind, count = str(row["camera_type"]), row["n_cameras"]
    if not isinstance(count, int):
        raise Refusal(f"{where}: n_cameras: {count!r}, expected a whole number")
    try:
        table4 = published_gaussian(str(row.get("gaussian", kind)))
        models, notes = published_row(kind, count), published_notes(kind, count)
    except Refusal as error:
        raise Refusal(f"{where}: {error}") from None
    return {
        "models": models,
        "source": f"published coefficients of {kind} with {count} cameras, "
        f"positions of Table 4 row {row.get('gaussian', kind)}",
        "start_mm": wand(table4["mu_1_mm"], table4["mu_2_mm"], table4["mu_L_mm"]),
        "notes": tuple(notes),
    }


def wand(x1: float, x2: float, distance: float) -> tuple[Point, Point]:
    """Two markers at x1 and x2 whose distance is the given one: what x lacks is put into y and z,
    in equal parts."""
    across = math.sqrt(max(0.0, distance**2 - (x1 - x2) ** 2) / 2)
    return (x1, across, across), (x2, 0.0, 0.0)


def _from_coefficients(given: Mapping[str, Any], where: str) -> dict[str, Any]:
    where = f"{where}: coefficients"
    table = section(given["coefficients"], where)
    check_keys(table, (*SERIES, "all"), where)
    models = {}
    for series in SERIES:
        entry = table.get(series, table.get("all", {}) if series != "L" else None)
        if entry is None:
            continue
        found = section(entry, f"{where}.{series}")
        numbers = {k: number(v, f"{where}.{series}.{k}") for k, v in found.items()}
        try:
            models[series] = NoiseModel.from_coefficients(numbers)
        except Refusal as error:
            raise Refusal(f"{where}.{series}: {error}") from None
    return {"models": models, "notes": ()}


def _left_out(
    models: Mapping[str, NoiseModel], given: Mapping[str, Any], where: str
) -> tuple[dict[str, NoiseModel], tuple[str, ...]]:
    """Models without what `without` and `without_T_c_below_s` name, and what was left out."""
    names = given.get("without", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise Refusal(f"{where}: without: {names!r}, expected a list such as [q_c1, h_-2]")
    known = {name for model in models.values() for name in model.coefficients()} - {"f_0"}
    known = {name for name in known if not name.startswith("T_c")}
    for name in names:
        if name not in known:
            raise Refusal(f"{where}: without: {name!r}, expected one of {', '.join(sorted(known))}")
    limit = number(given.get("without_T_c_below_s", 0), f"{where}: without_T_c_below_s")
    kept, notes = {}, []
    for series, model in models.items():
        found = model.coefficients()
        fast = [k for k, v in found.items() if k.startswith("T_c") and v < limit]
        gone = [n for n in names if n in found] + [f"q_c{k[3:]}" for k in fast]
        for name in gone:
            partner = {"q_c": f"T_c{name[3:]}", "A_s": "f_0"}.get(name[:3])
            found.pop(name, None)
            found.pop(partner, None)
        kept[series] = NoiseModel.from_coefficients(found)
        if gone:
            notes.append(f"{series}: left out on request: {', '.join(dict.fromkeys(gone))}")
    return kept, tuple(notes)


def _settings(given: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The plain settings that are given, checked."""
    values: dict[str, Any] = {}
    for key in ("duration_s", "frame_rate_hz", "resolution_mm"):
        if key in given:
            values[key] = number(given[key], f"{where}: {key}", positive=True)
    for key, low in (("coherence_factor", 0.0), ("yz_coherence", -1.0)):
        if key in given:
            values[key] = number(given[key], f"{where}: {key}", low, 1.0)
    labels = given.get("labels", list(Twin.labels))
    values["labels"] = two_labels(labels, f"{where}: labels")
    if "form" in given:
        values["form"] = check_form(given["form"], f"{where}: ")
    if "distance_line" in given:
        if given["distance_line"] not in ("split", "omit"):
            raise Refusal(f"{where}: distance_line: {given['distance_line']!r}, split or omit")
        values["distance_line"] = given["distance_line"]
    if "start_mm" in given:
        points = given["start_mm"]
        if not isinstance(points, list) or len(points) != 2:
            raise Refusal(f"{where}: start_mm: {points!r}, expected [[x, y, z], [x, y, z]]")
        values["start_mm"] = tuple(point(p, f"{where}: start_mm") for p in points)
    if "slow" in given:
        values["slow"] = _slow(section(given["slow"], f"{where}: slow"), f"{where}: slow")
    scale = given.get("scale", {})
    if not isinstance(scale, Mapping):
        scale = dict.fromkeys(COORDINATES, scale)
    check_keys(scale, COORDINATES, f"{where}: scale")
    values["scale"] = {k: number(v, f"{where}: scale.{k}") for k, v in scale.items()}
    drift = given.get("drift_mm_per_h", {})
    values["drift_mm_per_h"] = drifts(drift, values["labels"], f"{where}: drift_mm_per_h")
    return values


def _slow(entry: Mapping[str, Any], where: str) -> Slow:
    check_keys(entry, ("take", "below_hz"), where)
    missing = [key for key in ("take", "below_hz") if entry.get(key) is None]
    if missing:
        raise Refusal(f"{where}: {', '.join(missing)} missing, as in {{take: T40, below_hz: 0.1}}")
    below = number(entry["below_hz"], f"{where}: below_hz", positive=True)
    return Slow(str(entry["take"]), below)


def _effects(given: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Outliers, crump and gaps that are given, checked."""
    values: dict[str, Any] = {}
    for key, kind in (("outliers", Outliers), ("crump", Crump), ("gaps", Gaps)):
        if key not in given:
            continue
        entry = section(given[key], f"{where}: {key}")
        names = [f.name for f in fields(kind)]
        check_keys(entry, names, f"{where}: {key}")
        numbers = {
            k: number(v, f"{where}: {key}.{k}") for k, v in entry.items() if k != "distribution"
        }
        needless = ("distribution", "time_s", "time_share")
        missing = [n for n in names if n not in entry and n not in needless]
        if missing:
            raise Refusal(f"{where}: {key}: {', '.join(missing)} is missing")
        if "distribution" in entry:
            if entry["distribution"] not in ("exponential", "normal"):
                raise Refusal(
                    f"{where}: {key}.distribution: {entry['distribution']!r}, "
                    "expected exponential or normal"
                )
            numbers["distribution"] = entry["distribution"]
        values[key] = kind(**numbers)
    if "crump" in values:
        _check_crump(values["crump"], f"{where}: crump")
    return values


def _check_crump(crump: Crump, where: str) -> None:
    if (crump.time_s is None) == (crump.time_share is None):
        raise Refusal(f"{where}: expected either time_s or time_share")
    if crump.time_share is not None and crump.time_share > 1:
        raise Refusal(f"{where}.time_share: {crump.time_share}, expected a number from 0 to 1")
    if crump.decay_s <= 0:
        raise Refusal(f"{where}.decay_s: {crump.decay_s}, expected a number > 0")
