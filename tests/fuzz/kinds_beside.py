"""Files that stand beside a recording: stations, poses, a mount, a covariate, and the results of
steps before."""

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import CHECKSUM, sha256, verify, write_csv, write_json
from mocap_metrology.io.text.covariate import read_covariate
from mocap_metrology.lighthouse.assess.comparison import compare_with_earlier
from mocap_metrology.lighthouse.assess.pose_file import chosen_pose, read_pose_json
from mocap_metrology.lighthouse.assess.reference import pose_reference, read_mount
from mocap_metrology.lighthouse.decode.factory_file import read_factory
from mocap_metrology.recording.points import read_reference

from . import mutate, strict_beside, strict_text
from .kind import Kind
from .strict_c3d import Unreadable, Values

TURN = [0.0, 0.0, 0.7071067811865476, 0.7071067811865476]


def text(value: object) -> bytes:
    return (json.dumps(value, indent=2) + "\n").encode()


def every(folder: Path) -> Iterator[Kind]:
    """All kinds."""
    yield from of_stations()
    yield from of_poses(folder)
    yield from of_tables()
    yield from of_results(folder)


def of_stations() -> Iterator[Kind]:
    """stations.json, and the YAML of a Crazyflie."""
    values = {
        "phase": [0.05, 0.0241],
        "tilt": [-0.0091, 0.0008],
        "curve": [-0.0038, -0.0015],
        "gibphase": [1.5, 0.25],
        "gibmag": [0.0061, -0.002],
    }
    rest = {"frames_found": 2, "why": "", "firmware": 436, "hardware": 9}
    stations = [
        {"role": "master", "id": 7, "mode": "b", "factory": values, "gravity": [0.0, 0.1, 0.99]},
        {"role": "slave", "id": 4294967290, "mode": "c", "factory": values, "gravity": None},
    ]
    stations = [station | rest for station in stations]

    def read(path: Path) -> Values:
        return {
            f"{station.role} {name}": value
            for station in read_factory(path)
            for name, value in {
                "id": station.id,
                "mode": station.mode,
                **{name: getattr(station.factory, name) for name in values},
            }.items()
        }

    yield Kind("lighthouse stations", "stations.json", text(stations), read,
               strict_beside.stations, mutate.text)  # fmt: skip
    sweeps = [{name: pair[axis] for name, pair in values.items()} for axis in (0, 1)]
    lines = ["type: lighthouse_system_configuration", "version: '1'", "systemType: 1", "calibs:"]
    for key in (0, 1):
        lines += [f"  {key}:", f"    uid: {7 + key}", "    sweeps:"]
        for sweep in sweeps:
            cells = [f"{name}: {value}" for name, value in sweep.items()]
            lines += [f"    - {cells[0]}", *(f"      {cell}" for cell in cells[1:])]
    yield Kind("lighthouse crazyflie", "a.yaml", "\n".join([*lines, ""]).encode(), read,
               strict_beside.crazyflie, mutate.text)  # fmt: skip


def of_poses(folder: Path) -> Iterator[Kind]:
    """An earlier pose.json that a calibration is checked against, and references."""
    covariance = (np.diag([0.04, 0.05, 0.06, 1e-4, 2e-4, 3e-4]) + 1e-5).tolist()
    kinds = (("paper-lm", "final", "factory"), ("batch", "static", "ideal"))
    poses = [
        {
            **dict(zip(("estimator", "stage", "optics"), kind, strict=True)),
            "translation_mm": [2000.0 + k, 500.5, -100.25],
            "quaternion_xyzw": TURN,
            "covariance": covariance,
        }
        for k, kind in enumerate(kinds)
    ]
    stations = {"master": {"id": 7, "mode": "b"}, "slave": {"id": 4294967290, "mode": "c"}}
    sound = {"stations": stations, "chosen": 0, "verdict": {"word": "good"}, "poses": poses}
    (folder / "new.json").write_bytes(text(sound))
    new = read_pose_json(folder / "new.json")

    def earlier(path: Path) -> Values:
        found = read_pose_json(path)
        compared = compare_with_earlier(new, found)
        ids = [found["stations"][role]["id"] for role in ("master", "slave")]
        chosen = chosen_pose(found)
        assert chosen is not None
        return {
            "moved_by": np.r_[compared.difference_mm, compared.difference_deg],
            "chi2": np.array([compared.chi2, compared.p_value]),
            "other": compared.other,
            "ids": [strict_beside.id_of(one) for one in ids],
            "chosen": [chosen[name] for name in ("estimator", "stage", "optics")],
        }

    yield Kind("lighthouse earlier pose", "pose.json", text(sound), earlier,
               partial(strict_beside.earlier, new=sound), mutate.text)  # fmt: skip
    given = {
        "quaternion_xyzw": TURN,
        "translation_mm": [2000.0, 500.0, -100.0],
        "master": "0x7",
        "slave": {"id": 4294967290},
    }

    def reference(path: Path) -> Values:
        found = pose_reference(path)
        return {"R": found.R, "t_m": found.t_m, "ids": list(found.ids)}

    turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    ids = {"stations": {"master": 7, "slave": 4294967290}}
    metres = {"R": turn, "t_m": [2.0, 0.5, -0.1]} | ids
    for name, made in (("reference", metres), ("reference mm", given)):
        yield Kind(f"lighthouse {name}", "a.json", text(made), reference,
                   strict_beside.reference, mutate.text)  # fmt: skip


def of_tables() -> Iterator[Kind]:
    """A mount, reference points, and a covariate of either delimiter."""
    rng = np.random.default_rng(5)
    places = rng.normal(0, 0.1, (5, 3))
    lines = [f"M{k},{x:.4f},{y:.4f},{z:.4f}" for k, (x, y, z) in enumerate(places, start=1)]
    mount = "\n".join(["label,x_m,y_m,z_m", *lines, ""]).encode()

    def read(path: Path) -> Values:
        found = read_mount(path)
        return {"labels": list(found), "places": np.array(list(found.values()))}

    strict = partial(strict_beside.places, name="label", unit="m", least=3)
    yield Kind("lighthouse mount", "mount.csv", mount, read, strict, mutate.text)

    def points(path: Path) -> Values:
        found = read_reference(path)
        return {"labels": list(found), "places": np.array([place for place, _ in found.values()])}

    head = b"point,x_mm,y_mm,z_mm"
    strict = partial(strict_beside.places, name="point", unit="mm", least=0)
    yield Kind("points", "a.csv", mount.replace(b"label,x_m,y_m,z_m", head), points, strict,
               mutate.text)  # fmt: skip
    values = rng.normal(21, 0.5, 60)

    def covariate(path: Path) -> Values:
        name, time_s, found = read_covariate(path)
        return {"name": name, "time_s": time_s, "values": found}

    for between, point in ((",", "."), (";", ",")):
        lines = [
            f"{60 * k + 0.5:.1f};{value:.3f}".replace(".", point).replace(";", between)
            for k, value in enumerate(values)
        ]
        made = "\n".join([f"time_s{between}temperature_C", *lines, ""]).encode()
        name = "comma" if between == "," else "semicolon"
        yield Kind(f"text covariate {name}", "a.csv", made, covariate,
                   partial(strict_beside.covariate, between=between), mutate.text)  # fmt: skip


def of_results(folder: Path) -> Iterator[Kind]:
    """JSON and CSV that one step writes and the next reads, with their checksum: no damage at all
    may pass."""
    findings = [
        {"code": "events", "series": "x1", "value": 0.5 * k, "unit": "mm"} for k in range(9)
    ]
    rows = [
        {"series": f"x{k}", "parameter": "h_0", "value": 1e-7 * k, "note": ""} for k in range(9)
    ]
    write_json(folder / "a.json", {"findings": findings, "ok": True})
    write_csv(folder / "a.csv", rows)
    for suffix in ("json", "csv"):
        path = folder / f"a.{suffix}"
        base, written = path.read_bytes(), sha256(path).encode()

        def read(path: Path, written: bytes = written) -> Values:
            with suppress(OSError):  # a file system without attributes
                os.setxattr(path, CHECKSUM, written)
                verify(path)
                return {"raw": path.read_bytes()}
            raise Unreadable

        yield Kind(f"workflow {suffix} result", path.name, base, read,
                   partial(_as_written, base=base), mutate.text)  # fmt: skip


def _as_written(raw: bytes, base: bytes) -> Values:
    strict_text.need(raw == base)
    return {"raw": base}
