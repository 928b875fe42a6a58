"""Subsets of cameras of S: which recording stands for one, what the coefficients of a twin lead to
on average, and Tables 2 (types of cameras, of which nothing can be regenerated) and 3."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from mocap_metrology.noise.gaussian.moments import expected_moments
from mocap_metrology.noise.twins.published import (
    published_cameras,
    published_gaussian,
    published_subsets,
)
from mocap_metrology.noise.twins.twin import Twin

# The recording for each row of S Table 4. Its Vantage row agrees with nine cameras;
# the tenth was the failing one, which S 3.5 excludes.
TABLE_4 = {"T40": 10, "Bonita": 10, "Vantage": 9, "All": 30}
TYPES = ("T40", "Bonita", "Vantage")
NOT_FITTED = ("Vantage", 10)  # with the failing camera (S 3.5)
SPREADS = ("sigma_1_mm", "sigma_2_mm", "sigma_L_mm", "sigma_12_mm2")
SLICE_S = 10.0  # averaging time of the panel of S Figure 12 against the number of cameras
Gaussians = Mapping[str, Mapping[str, float]]  # a row of gaussian.csv by recording
Sheet = Mapping[str, Mapping[str, Any]]  # rows of the sheet by recording


def standing_for(recordings: Sheet, camera_type: str, n_cameras: int) -> str | None:
    """Name of the recording of that subset: a measured one before a twin, then the first."""
    names = [
        name
        for name, row in recordings.items()
        if (row["camera_type"], row["n_cameras"]) == (camera_type, n_cameras)
    ]
    return min(names, key=lambda name: recordings[name]["twin"] is not None, default=None)


def source_of(recording: Mapping[str, Any] | None) -> str:
    """`twin`, `measured`, or `cited` where the published row has no recording."""
    return "cited" if recording is None else "twin" if recording["twin"] else "measured"


def means_of_distance(sheet: Sheet, gaussian: Gaussians, twins: Mapping[str, Twin]) -> pd.DataFrame:
    """Mean of L, mm, of every recording that has one: `camera_type`, `n_cameras`, `value`, its
    standard error `error` (NaN: not known), and `published` of the type (NaN: none)."""
    rows = [
        {
            "camera_type": row["camera_type"],
            "n_cameras": row["n_cameras"],
            "value": gaussian[name].get("mu_L_mm"),
            "error": expected_moments(twins[name])["mu_L"] if name in twins else None,
            "published": published_gaussian(row["camera_type"])["mu_L_mm"]
            if row["camera_type"] in TABLE_4
            else None,
        }
        for name, row in sheet.items()
    ]
    table = pd.DataFrame(rows, columns=["camera_type", "n_cameras", "value", "error", "published"])
    table = table.astype(dict.fromkeys(("value", "error", "published"), float))
    return table[table["value"].notna()]


def spreads(
    sheet: Sheet, gaussian: Gaussians, twins: Mapping[str, Twin] | None = None
) -> pd.DataFrame:
    """Spread of recordings over the number of cameras, of camera types with two different numbers
    at least, a row a number: `camera_type`, `n`, `fitted` (whether the law holds for it), `kind`
    (`row`: of gaussian.csv; `expected`: what the coefficients of a twin lead to on average;
    `published`: Table 4), `quantity`, `value`.

    twins: of the recordings of S; None for any other group, which has gaussian.csv alone.
    """
    rows = []
    for name, row in sheet.items():
        kind, n = row["camera_type"] or "", row["n_cameras"]
        numbers = {"row": gaussian[name]} if n and gaussian[name] else {}
        fitted = twins is None or (kind, n) != NOT_FITTED
        if twins is not None and name in twins:
            moments = expected_moments(twins[name])
            numbers["expected"] = {key: moments[key.rpartition("_")[0]] for key in SPREADS}
        if twins is not None and TABLE_4.get(kind) == n:
            numbers["published"] = published_gaussian(kind)
        rows += [
            (kind, n, fitted, origin, key, float(values.get(key, np.nan)))
            for origin, values in numbers.items()
            for key in SPREADS
        ]
    names = ["camera_type", "n", "fitted", "kind", "quantity", "value"]
    table = pd.DataFrame(rows, columns=names)
    several = table.groupby("camera_type")["n"].transform("nunique") > 1
    return table[several].sort_values("n", kind="stable").dropna()


def at_tau(tau_s: np.ndarray, adev: np.ndarray, wanted_s: float) -> float:
    """Deviation at an averaging time, between two computed ones along a line in logarithms; NaN
    beyond them."""
    known = np.isfinite(adev) & (adev > 0)
    if not known.any():
        return np.nan
    x, y = np.log(tau_s[known]), np.log(adev[known])
    return float(np.exp(np.interp(np.log(wanted_s), x, y, left=np.nan, right=np.nan)))


def largest_sets(recordings: Sheet) -> dict[str, str]:
    """Recording of the largest sound set of each type, and of all types, by type (S Figure 13)."""
    names = {kind: standing_for(recordings, kind, n) for kind, n in TABLE_4.items()}
    return {kind: name for kind, name in names.items() if name is not None}


def sound_subsets(recordings: Sheet) -> dict[str, dict[int, str]]:
    """Recordings of S Figure 12 by camera type and number of cameras, without the failing one."""
    numbers = {kind: {r["n_cameras"] for r in recordings.values() if r["camera_type"] == kind}
               for kind in TYPES}  # fmt: skip
    return {
        kind: {
            n: name
            for n in sorted(counts)
            if n <= TABLE_4[kind] and (name := standing_for(recordings, kind, n)) is not None
        }
        for kind, counts in numbers.items()
    }


# ---- Tables 2 and 3


def table_2() -> list[dict[str, Any]]:
    """One row a number: the value as printed, its unit, and how sure its reading is."""
    return [
        {"camera_type": kind, "quantity": line["spec"], "unit": line["unit"]}
        | {"published": line[kind], "regenerated": None, "source": "cited"}
        | {name: line[name] for name in ("ambiguity", "note", "printed_line")}
        for line in published_cameras()
        for kind in TYPES
    ]


def side_by_side() -> list[dict[str, Any]]:
    """Table 2 to read: one row a quantity, what is printed of each type in a column."""
    return [
        {"quantity": line["spec"], "unit": line["unit"]}
        | {kind: line[kind] for kind in TYPES}
        | {"source": "cited", "ambiguity": line["ambiguity"], "note": line["note"]}
        for line in published_cameras()
    ]


def table_3(recordings: Sheet) -> list[dict[str, Any]]:
    """S Table 3: the cameras of every subset, as published and as in the sheet."""
    rows = []
    for (camera_type, n_cameras), ids in published_subsets().items():
        row = recordings.get(standing_for(recordings, camera_type, n_cameras) or "")
        subset = {"camera_type": camera_type, "n_cameras": n_cameras}
        regenerated = ";".join(map(str, row["camera_ids"])) if row else None
        cells = {"published": ";".join(map(str, ids)), "regenerated": regenerated}
        recording = row["recording"] if row else None
        rows.append(subset | cells | {"source": source_of(row), "recording": recording})
    return rows
