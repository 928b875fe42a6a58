"""A twin that is a subset of a simulated take, read from the configuration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.entries import (
    check_keys,
    drifts,
    number,
    section,
    two_labels,
    whole,
)
from mocap_metrology.noise.twins.take import Failing, Take, TakeTwin
from mocap_metrology.noise.twins.triangulation import FOCAL_PX

COMMON = ("duration_s", "frame_rate_hz", "labels")  # what it takes from the defaults of recordings
KEYS = ("take", "camera_ids", "seed", *COMMON)
TAKE_KEYS = ("camera_type", "cameras", "layout_seed", "centroid_px")
TAKE_MAY = ("spread", "failing", "h_-2", "drift_mm_per_h")
MOST = 1000  # cameras


def is_take(entry: Mapping[str, Any]) -> bool:
    """Whether an entry of the configuration is a twin of this kind."""
    return "take" in entry


def with_defaults(entry: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """The entry with what it takes from the defaults of all recordings."""
    return {key: value for key, value in defaults.items() if key in COMMON} | dict(entry)


def take_twin_from_mapping(mapping: Mapping[str, Any], name: str = "twin") -> TakeTwin:
    """A twin of its configuration entry: `take` with the fields of `Take` (`h_-2` is `h_m2`),
    `camera_ids`, `seed`, and as for other twins `duration_s`, `frame_rate_hz`, `labels`.
    Raises `Refusal` naming the twin and the key."""
    where = f"twin {name}"
    given = {k: v for k, v in section(mapping, where).items() if v is not None}
    check_keys(given, KEYS, where)
    _check_there(given, ("take", "camera_ids", "seed"), where)
    labels = two_labels(given.get("labels", list(TakeTwin.labels)), f"{where}: labels")
    take = _take(section(given["take"], f"{where}: take"), labels, f"{where}: take")
    plain = {
        key: number(given[key], f"{where}: {key}", positive=True)
        for key in ("duration_s", "frame_rate_hz")
        if key in given
    }
    ids = _camera_ids(given["camera_ids"], take.cameras, f"{where}: camera_ids")
    seed = whole(given["seed"], f"{where}: seed")
    return TakeTwin(name, take, ids, seed, labels=labels, **plain)


def _take(given: Mapping[str, Any], labels: tuple[str, str], where: str) -> Take:
    check_keys(given, (*TAKE_KEYS, *TAKE_MAY), where)
    _check_there(given, TAKE_KEYS, where)
    kind = given["camera_type"]
    if kind not in FOCAL_PX:
        known = ", ".join(FOCAL_PX)
        raise Refusal(f"{where}.camera_type: {kind!r}, expected one of {known}")
    cameras = whole(given["cameras"], f"{where}.cameras", 2)
    if cameras > MOST:
        raise Refusal(f"{where}.cameras: {cameras}, expected {MOST} at most")
    return Take(
        camera_type=kind,
        cameras=cameras,
        layout_seed=whole(given["layout_seed"], f"{where}.layout_seed"),
        centroid_px=number(given["centroid_px"], f"{where}.centroid_px", positive=True),
        spread=number(given.get("spread", 0), f"{where}.spread", 0.0, 1.0),
        failing=_failing(given["failing"], cameras, f"{where}.failing")
        if given.get("failing") is not None
        else None,
        h_m2=number(given.get("h_-2", 0), f"{where}.h_-2"),
        drift_mm_per_h=drifts(given.get("drift_mm_per_h", {}), labels, f"{where}.drift_mm_per_h"),
    )


def _failing(value: Any, cameras: int, where: str) -> Failing:
    given = section(value, where)
    check_keys(given, ("camera", "times"), where)
    _check_there(given, ("camera", "times"), where)
    camera = whole(given["camera"], f"{where}.camera", 1)
    if camera > cameras:
        raise Refusal(f"{where}.camera: {camera}, expected one from 1 to {cameras}")
    return Failing(camera, number(given["times"], f"{where}.times", positive=True))


def _camera_ids(value: Any, cameras: int, where: str) -> tuple[int, ...]:
    expected = f"expected two or more different whole numbers from 1 to {cameras}"
    right = isinstance(value, list) and all(type(v) is int and 1 <= v <= cameras for v in value)
    if not right or len(value) < 2 or len(set(value)) < len(value):
        raise Refusal(f"{where}: {value!r}, {expected}")
    return tuple(value)


def _check_there(given: Mapping[str, Any], names: tuple[str, ...], where: str) -> None:
    missing = [name for name in names if given.get(name) is None]
    if missing:
        raise Refusal(f"{where}: {', '.join(missing)} missing")
