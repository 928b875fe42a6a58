"""What a run left in its results, read for tests."""

import csv
import json
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import yaml

from mocap_metrology.common.files import read_table


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def origin(path: Path) -> dict:
    return json.loads(pq.read_schema(path).metadata[b"mocap_metrology"])


def said(output: str, start: str) -> list[str]:
    return [line for line in output.splitlines() if line.startswith(start)]


def pose(results: Path, name: str) -> dict:
    return json.loads((results / f"calibrations/{name}/pose.json").read_text())


def chosen(results: Path, name: str) -> dict:
    told = pose(results, name)
    return told["poses"][told["chosen"]]


def off(entry: dict) -> tuple[float, float]:
    """Distance in mm and angle in deg from the reference."""
    mm, deg = (np.linalg.norm(entry[key]) for key in ("errors_mm", "errors_deg"))
    return float(mm), float(deg)


def exported(results: Path, name: str) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """R and t of the stations in the file for a Crazyflie."""
    found = yaml.safe_load((results / f"calibrations/{name}/crazyflie.yaml").read_text())
    return {k: (np.array(g["rotation"]), np.array(g["origin"])) for k, g in found["geos"].items()}


# The file as it was given, and whether ezc3d was asked: the workflow asks before, in its check
APART = ("source", "path", "second_opinion")


def leaves(value: object, key: str = "") -> Iterator[tuple[str, object]]:
    """Every number and word of a JSON document by its place."""
    if isinstance(value, dict):
        for name, item in value.items():
            yield from leaves(item, f"{key}.{name}") if name not in APART else ()
    elif isinstance(value, list):
        for number, item in enumerate(value):
            yield from leaves(item, f"{key}.{number}")
    else:
        yield key, value


def contents(path: Path) -> object:
    """What a file holds, comparable with `==`."""
    if path.suffix == ".parquet":
        columns, made = read_table(path)
        return {k: list(map(repr, v)) for k, v in columns.items()}, dict(leaves(made))
    if path.suffix in (".svg", ".png"):
        return path.read_bytes()
    text = path.read_text(encoding="utf-8")
    return dict(leaves(json.loads(text))) if text.startswith(("{", "[")) else text


def damage(path: Path) -> None:
    """Turn one bit of the values, and leave the times of the file."""
    times = path.stat()
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 3] ^= 4
    path.write_bytes(raw)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
