"""Strict readers of the files of `kinds_beside`; they share nothing with the package."""

import json
import math
import re
from typing import Any

import numpy as np
import yaml
from scipy.spatial.transform import Rotation
from scipy.stats import f as distribution

from .strict_c3d import Unreadable, Values, need
from .strict_text import lines_of, number, once, table_of, yaml_of

FACTORY = ("phase", "tilt", "curve", "gibphase", "gibmag")
ROLES = ("master", "slave")
BLOCKS = 20  # of a recording, that its covariance comes from


def parsed(raw: bytes) -> Any:
    """A key stands once."""
    try:
        return json.loads(raw.decode("utf-8-sig"), object_pairs_hook=once)
    except (ValueError, RecursionError):
        raise Unreadable from None


def numbers(value: object, *shape: int) -> np.ndarray:
    try:
        found = np.array(value, float)
    except (TypeError, ValueError):
        raise Unreadable from None
    need(found.shape == shape and np.isfinite(found).all())
    return found


def id_of(given: Any) -> int | None:
    given = given.get("id") if isinstance(given, dict) else given
    if isinstance(given, str):
        need(re.fullmatch(r"[+-]?([0-9]+|0[xX][0-9a-fA-F]+|0[oO][0-7]+|0[bB][01]+)", given.strip()))
        return int(given, 0)
    need(given is None or type(given) is int)
    return given


def stations(raw: bytes) -> Values:
    found: Values = {}
    given = parsed(raw)
    need(isinstance(given, list) and all(isinstance(one, dict) for one in given))
    roles = [one.get("role") for one in given]
    need(set(roles) <= set(ROLES) and len(set(roles)) == len(roles))
    for one in given:
        role, factory = one["role"], one.get("factory")
        need(one.get("mode") in (None, "A", "b", "c"))
        station = one.get("id")
        need(station is None or (type(station) is int and 0 <= station < 2**32))
        if one.get("gravity") is not None:
            numbers(one["gravity"], 3)
        if factory is not None:
            need(isinstance(factory, dict))
            found |= {f"{role} {name}": numbers(factory.get(name), 2) for name in FACTORY}
            found |= {f"{role} id": station, f"{role} mode": one.get("mode")}
    need(found)
    return found


def crazyflie(raw: bytes) -> Values:
    try:
        given = yaml_of(raw)
        need(given["type"] == "lighthouse_system_configuration" and given["systemType"] == 1)
        need(str(given["version"]) in ("1", "2"))
        calibs = given["calibs"]
        found: Values = {}
        for key, one in calibs.items():
            need(key in (0, 1) and len(one["sweeps"]) == 2)
            role = ROLES[key]
            found |= {f"{role} id": one["uid"] or None, f"{role} mode": None}
            for name in FACTORY:
                found[f"{role} {name}"] = numbers([sweep[name] for sweep in one["sweeps"]], 2)
    except (yaml.YAMLError, UnicodeDecodeError, TypeError, KeyError, AttributeError, ValueError):
        raise Unreadable from None
    return found


def pose_of(entry: Any) -> tuple[np.ndarray, np.ndarray]:
    q = numbers(entry["quaternion_xyzw"], 4)
    need(abs(np.linalg.norm(q) - 1) < 0.01)
    return Rotation.from_quat(q).as_matrix(), numbers(entry["translation_mm"], 3)


def earlier(raw: bytes, new: Any) -> Values:
    given = parsed(raw)
    try:
        ids = [id_of(given["stations"][role]["id"]) for role in ROLES]
        poses, chosen = given["poses"], given["chosen"]
        need(isinstance(poses, list) and type(chosen) is int and 0 <= chosen < len(poses))
        kinds = [[one[k] for k in ("estimator", "stage", "optics")] for one in poses]
        every = [pose_of(one) for one in poses]
        covariances = [one.get("covariance") for one in poses]
        for one in covariances:
            matrix = np.eye(6) if one is None else numbers(one, 6, 6)
            need(np.allclose(matrix, matrix.T, rtol=1e-6))
        own = new["poses"][0]
        own_kind = [own[k] for k in ("estimator", "stage", "optics")]
    except (KeyError, TypeError, AttributeError, IndexError):
        raise Unreadable from None
    known = [new["stations"][role]["id"] for role in ROLES]
    need(all(a is None or a == b for a, b in zip(ids, known, strict=True)))
    at = kinds.index(own_kind) if own_kind in kinds else chosen
    (R, t), (R_old, t_old) = pose_of(own), every[at]
    turn = Rotation.from_matrix(R @ R_old.T).as_rotvec(degrees=True)
    difference = np.r_[t - t_old, turn]
    chi2 = p = math.nan
    if covariances[at] is not None:
        total = np.array(own["covariance"]) + np.array(covariances[at], float)
        if np.linalg.eigvalsh(total)[0] > 0:
            chi2 = float(difference @ np.linalg.solve(total, difference))
            nu = 2 * (BLOCKS - 1)
            p = float(distribution.sf(chi2 * (nu - 5) / (6 * nu), 6, nu - 5))
    return {
        "moved_by": difference,
        "chi2": np.array([chi2, p]),
        "other": None if own_kind in kinds else tuple(kinds[at]),
        "ids": ids,
        "chosen": kinds[chosen],
    }


def reference(raw: bytes) -> Values:
    given = parsed(raw)
    try:
        own = given.get("stations", given)
        ids = [id_of(own[role]) for role in ROLES]
        if "R" in given:
            R = numbers(given["R"], 3, 3)
            need(np.allclose(R @ R.T, np.eye(3), atol=1e-3) and np.linalg.det(R) > 0)
            U, _, Vt = np.linalg.svd(R)
            R = U @ Vt
        else:
            q = numbers(given["quaternion_xyzw"], 4)
            need(abs(np.linalg.norm(q) - 1) < 0.01)
            R = Rotation.from_quat(q).as_matrix()
        key = next(k for k in ("t_m", "t", "translation_mm") if k in given)
        t = numbers(given[key], 3) * (1e-3 if key == "translation_mm" else 1.0)
    except (KeyError, TypeError, AttributeError, StopIteration, ValueError):
        raise Unreadable from None
    return {"R": R, "t_m": t, "ids": ids}


def places(raw: bytes, name: str, unit: str, least: int) -> Values:
    """Of a mount, or of reference points, whose columns stand in any order."""
    columns = tuple(f"{axis}_{unit}" for axis in "xyz")
    rows = table_of(raw, (name, *columns), exact=name == "label")
    need(all(row[column].strip() for row in rows for column in columns))
    labels = [row[name].strip() for row in rows]
    need(all(labels) and len(set(labels)) == len(labels) >= least)
    return {"labels": labels, "places": np.array([[number(r[c]) for c in columns] for r in rows])}


def covariate(raw: bytes, between: str) -> Values:
    rows = [line.split(between) for line in lines_of(raw) if line.strip(f" \t{between}")]
    rows = [[cell.strip(' \t"') for cell in row] for row in rows]
    need(rows and all(not any(row[2:]) and len(row) > 1 for row in rows))
    need(rows[0][0] == "time_s" and rows[0][1])
    cells = [[c.replace(",", ".") if between == ";" else c for c in row[:2]] for row in rows[1:]]
    table = np.array([[number(cell) for cell in row] for row in cells])
    need(len(table) > 1 and np.isfinite(table).all() and (np.diff(table[:, 0]) > 0).all())
    return {"name": rows[0][1], "time_s": table[:, 0], "values": table[:, 1]}
