"""Rows of <group>_cameras and <group>_camera_law: what each addition of cameras did to the noise,
and which of them count."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from mocap_metrology.noise.cameras.diagnosis import (
    CHANCE_OF_ERROR,
    NAMING_S,
    Diagnosis,
    Estimate,
)
from mocap_metrology.noise.cameras.information import Addition
from mocap_metrology.noise.cameras.scaling import law

Row = dict[str, Any]  # of a table: numbers, words, gaps
LARGEST = ("largest_factor", "largest_lower_95", "largest_upper_95")
DIRECTION = ("direction_x", "direction_y", "direction_z")
MEAN = ("mean_factor", "mean_lower_95", "mean_upper_95")
NOISE = ("camera_noise", "camera_noise_lower_95", "camera_noise_upper_95", "camera_noise_p")
COLUMNS = (
    *("camera_type", "from", "to", "n_from", "n_to", "added", "marker", "tau_s", "word"),
    *(*LARGEST, "p_value", *DIRECTION, *MEAN, "law_factor"),
    *("same_frames", *NOISE, "least_camera_noise"),
)
LAW = {"b": "b", "b_std_error": "std_error", "b_p": "p_value", "scatter": "scatter"}
LAW_COLUMNS = ("camera_type", "series", "n_subsets", *LAW, *(f"h_0_{name}" for name in LAW))
# Ratio by which a factor must exceed that of another averaging time to be shown in its place
CLEARLY = 1.2
# Information that an addition brings, over that of a camera on average, below which the recordings
# are not what they are called: of cameras that are added it is 0.3 to 3
LEAST_INFORMATION, NOTHING = 0.2, "no information"


def addition_rows(
    camera_type: str,
    additions: Sequence[Addition],
    camera_ids: Mapping[str, Sequence[int | str]],
    labels: Sequence[str],
    diagnosis: Diagnosis,
    rise: float,
) -> list[Row]:
    """Rows of <group>_cameras of one camera type: the first cameras, then one an addition,
    averaging time and marker.

    `word`: `raises` where the largest factor exceeds 1 + `rise`, and 1 significantly; `falls` where
    the mean factor is below 1 with its whole interval; `same`; NOTHING where the larger subset has
    no more information than the smaller, as of recordings that are exchanged: no camera of the take
    then has a noise.
    """

    def row(smaller: str, larger: str, added: Sequence[int | str], values: Row) -> Row:
        few, many = len(camera_ids.get(smaller, ())), len(camera_ids[larger])
        sizes: Row = {"camera_type": camera_type, "from": smaller, "to": larger}
        sizes |= {"n_from": few or None, "n_to": many, "added": ";".join(map(str, added))}
        sizes |= {"law_factor": math.sqrt(few / many) if few else None}
        return {name: (sizes | values).get(name) for name in COLUMNS}

    nothing = diagnosis.information < LEAST_INFORMATION
    no_noise = dict.fromkeys(NOISE) if nothing.any() else {}  # all rest on the same geometry
    first = {"tau_s": diagnosis.tau_s[0], "same_frames": "yes"}
    rows = [
        row("", name, camera_ids[name], first | _with_interval(NOISE, estimate, ()) | no_noise)
        for name, estimate in diagnosis.firsts.items()
    ]
    least = diagnosis.least_noise()
    for k, addition in enumerate(additions):
        same = {"same_frames": "yes" if diagnosis.together[k] else "no"}
        for (t, tau), (i, label) in product(enumerate(diagnosis.tau_s), enumerate(labels)):
            at = i, t, k
            values: Row = same | {"marker": label, "tau_s": tau}
            values |= _with_interval((*LARGEST, "p_value"), diagnosis.largest, at)
            values |= _with_interval((*MEAN, ""), diagnosis.mean, at)
            values |= _with_interval(NOISE, diagnosis.noise, (t, k)) | no_noise
            unit = diagnosis.direction[at]  # or its opposite: the largest component is positive
            unit = unit * np.sign(unit[np.abs(unit).argmax()])
            values |= dict(zip(DIRECTION, unit.tolist(), strict=True))
            values["word"] = "falls" if values["mean_upper_95"] < 1 else "same"
            if nothing[k]:
                values["word"] = NOTHING
            elif values["largest_factor"] > 1 + rise and values["p_value"] < CHANCE_OF_ERROR:
                values |= {"word": "raises", "least_camera_noise": least[at]}
            rows.append(row(addition.smaller, addition.larger, addition.added, values))
    return rows


def _with_interval(names: Sequence[str], estimate: Estimate, at: tuple[int, ...]) -> Row:
    """Factor, ends of its 95 % interval, p-value by these names; None where it is unknown."""
    values = (estimate.factor, *estimate.interval(), estimate.p_value())
    known = math.isfinite(estimate.factor[at])
    return {n: float(v[at]) if known else None for n, v in zip(names, values, strict=True)}


def law_rows(
    camera_type: str,
    n_cameras: Mapping[str, int],
    sigma_mm: Mapping[str, Mapping[str, float]],
    h_0: Mapping[str, Mapping[str, float]],
) -> list[Row]:
    """Rows of <group>_camera_law: exponents of S Eq. 3, one row a series; sigma_mm and h_0: by
    recording and series."""
    rows, numbers = [], list(n_cameras.values())
    for series in dict.fromkeys(s for values in h_0.values() for s in values):
        frame = law(numbers, [sigma_mm[name].get(series, math.nan) for name in n_cameras])
        white = law(numbers, [h_0[name].get(series, math.nan) ** 0.5 for name in n_cameras])
        if either := frame or white:
            row: Row = {"camera_type": camera_type, "series": series}
            row["n_subsets"] = either.n_subsets
            for prefix, fit in (("", frame), ("h_0_", white)):
                row |= {f"{prefix}{name}": getattr(fit, of, None) for name, of in LAW.items()}
            rows.append(row)
    return rows


def raising_additions(rows: Sequence[Row]) -> list[Row]:
    """Additions that raised the noise up to 1 s, each by its greatest rise, greatest first."""
    rises = [r for r in rows if r["word"] == "raises" and r["tau_s"] <= NAMING_S * 1.01]
    greatest: dict[tuple[str, str], Row] = {}
    for row in sorted(rises, key=lambda r: -r["largest_factor"]):
        greatest.setdefault((row["from"], row["to"]), row)
    return list(greatest.values())


def noisy(rows: Sequence[Row], limit: float) -> list[Row]:
    """Cameras, or sets with one among them, noisier than `limit` times the others, noisiest first.

    Of several averaging times the first counts, unless another is clearly greater, as where the
    noise of a failing camera is correlated. A set that holds the ids of a smaller one is omitted:
    it is noisy because of that.
    """
    worst: dict[str, Row] = {}
    for row in rows:
        value = row["camera_noise"]
        if value is None or value <= limit or not row["camera_noise_p"] < CHANCE_OF_ERROR:
            continue
        if row["tau_s"] <= NAMING_S * 1.01:
            before = worst.setdefault(row["added"], row)
            ahead = 1.0 if row["tau_s"] == before["tau_s"] else CLEARLY
            if value > ahead * before["camera_noise"]:
                worst[row["added"]] = row
    sets = {added: set(added.split(";")) for added in worst}
    smallest = [r for a, r in worst.items() if not any(s < sets[a] for s in sets.values())]
    return sorted(smallest, key=lambda row: -row["camera_noise"])


def exchanged(rows: Sequence[Row]) -> list[Row]:
    """Additions that brought no information, one row of each."""
    first: dict[tuple[str, str], Row] = {}
    for row in rows:
        if row["word"] == NOTHING:
            first.setdefault((row["from"], row["to"]), row)
    return list(first.values())


def not_judged(rows: Sequence[Row]) -> list[Row]:
    """Subsets that no addition divides, of more than two cameras: the noise of one of these is
    unknown. Of two cameras it is that of the noisier."""
    firsts = (row for row in rows if not row["from"])
    return [row for row in firsts if row["n_to"] > 2 or row["camera_noise"] is None]


def cause(rise: Row, noisy_rows: Sequence[Row]) -> str:
    """Which cameras explain a rise: `added`, those added, or `earlier`, one before them.

    Where frames are shared, a camera known not to be noisy can raise the noise only because least
    squares then gives an earlier, noisy one more weight in that direction.
    """
    ids = {i for row in noisy_rows for i in row["added"].split(";")}
    of_added = rise["same_frames"] == "no" or not ids.isdisjoint(rise["added"].split(";"))
    return "added" if of_added else "earlier"


def worst_marker(table: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """One row an addition and averaging time, of the worst marker: `value`, `lower`, `upper`."""
    names = dict(zip(columns, ("value", "lower", "upper"), strict=False))
    steps = table[table[columns[0]].notna()].rename(columns=names)
    steps = steps.astype(dict.fromkeys(names.values(), float))
    steps = steps.sort_values("value", ascending=False, kind="stable")
    return steps.drop_duplicates(["camera_type", "from", "to", "tau_s"]).sort_index()
