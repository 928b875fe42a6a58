"""allan.parquet of a calibration: noise of the angles of a board at rest, as series over time, one
for each rotor and diode.

A rotor of the first generation sweeps once in four cycles (30 Hz), a plane of the second once in a
turn (50 to 53 Hz), so its sweeps are samples at equal steps, and a missed hit is a gap. With x_kd
the deviation of diode d from its own mean at sweep k, and n_k diodes seen,

    common_k = mean_d x_kd,   independent_kd = sqrt(n_k / (n_k - 1)) (x_kd - common_k),

where the factor restores the variance that subtracting the mean takes from independent noise. The
common part still contains 1 / n_k of the independent variance.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mocap_metrology import settings as of
from mocap_metrology.common.files import Metadata, read_table, versions, write_table
from mocap_metrology.common.types import Columns, Floats, Row
from mocap_metrology.lighthouse.records import AXES, PLANES, ROLES, Hits, hits_of
from mocap_metrology.lighthouse.timing import CYCLE_S
from mocap_metrology.noise.allan.confidence import AllanCurve, allan_curve, interval
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.series import ALLAN, allan_columns, joined

MOVED = "the board moved: its angles show motion, not noise"
UNKNOWN = "no pose of the board: whether it was at rest is not known"
SWEEP_CYCLES = 4  # between sweeps of one axis of one of two stations
FEWEST_SWEEPS = 30
LEAST_SEEN = 0.5  # of the sweeps, by a diode that counts
FEWEST_DIODES = 2  # in a sweep that has a common part


@dataclass(frozen=True)
class StillAngles:
    """Angles of one axis of one station: diodes (n,), deviation (k, n) in rad from the mean of each
    diode, NaN where it was not hit; sweeps follow each other at `rate_hz`; rad_per_s: speed of the
    angle. name: such as `master_azimuth`, or `3_plane0` of channel 3."""

    name: str
    rate_hz: float
    rad_per_s: float
    diodes: np.ndarray
    deviation: Floats

    @property
    def seen(self) -> np.ndarray:
        """Diodes (k,) in each sweep."""
        return np.isfinite(self.deviation).sum(axis=1)

    @property
    def common(self) -> Floats:
        """(k,) mean over the diodes of a sweep, NaN with fewer than two."""
        total = np.nansum(self.deviation, axis=1)
        return np.where(self.seen >= FEWEST_DIODES, total / np.maximum(self.seen, 1), np.nan)

    @property
    def independent(self) -> Floats:
        """(k, n) of each diode, as in the module's formula."""
        seen = self.seen[:, None]
        scale = np.sqrt(seen / np.maximum(seen - 1, 1))
        return scale * (self.deviation - self.common[:, None])


def still_angles(
    hits: Hits, names: Sequence[str] = ROLES, generation: int = 1
) -> Iterator[StillAngles]:
    """Series of every axis of every station with enough sweeps; names: of the stations."""
    for station, name in enumerate(names):
        for axis, title in enumerate(AXES if generation == 1 else PLANES):
            of_rotor = hits.take((hits.station == station) & (hits.axis == axis))
            if len(of_rotor) < FEWEST_SWEEPS:
                continue
            angles = _series(of_rotor, f"{name}_{title}", generation)
            if angles is not None:
                yield angles


def _series(hits: Hits, name: str, generation: int) -> StillAngles | None:
    cycle = hits.cycle.astype(np.int64) - hits.cycle.min()
    if generation == 1:
        step, rate_hz, speed = SWEEP_CYCLES, 1 / (SWEEP_CYCLES * CYCLE_S), np.pi / CYCLE_S
    else:
        last = int(np.argmax(cycle))
        step, rate_hz = 1, float(cycle[last] / (hits.time_s[last] - hits.time_s[np.argmin(cycle)]))
        speed = 2 * np.pi * rate_hz
    row, rest = np.divmod(cycle, step)
    hits, row = hits.take(rest == 0), row[rest == 0]
    table = np.full((int(row.max()) + 1, int(hits.diode.max()) + 1), np.nan)
    table[row, hits.diode] = hits.angle_rad
    counts = np.isfinite(table).sum(axis=0)
    diodes = np.flatnonzero(counts >= max(FEWEST_SWEEPS, LEAST_SEEN * len(table)))
    if not diodes.size:
        return None
    angles = table[:, diodes]
    return StillAngles(name, rate_hz, speed, diodes, angles - np.nanmean(angles, axis=0))


def of_calibration(path: str, sweeps: str, pose: str, settings: of.Allan) -> None:
    """`write_angle_noise` of the sweeps.parquet and the pose.json of a calibration."""
    hits, origin = read_table(sweeps)
    document = json.loads(Path(pose).read_text(encoding="utf-8"))
    still = document["diagnostics"]["still"] if document["poses"] else None
    same = ("recording", "source", "twin", "sha256", "duration_s", "generation")
    resolution_s = origin["resolution_s"]
    origin = {key: origin[key] for key in same if key in origin}
    origin["stations"] = list(document["stations"])
    origin["versions"] = versions("numpy", "scipy", "numba", "pyarrow")
    write_angle_noise(path, hits_of(hits), still, resolution_s, settings, origin)


def write_angle_noise(
    path: str,
    hits: Hits,
    still: bool | None,
    resolution_s: float | None,
    settings: of.Allan,
    origin: Metadata,
) -> None:
    """Allan deviations in rad of each rotor's (plane's) common and independent part and of its
    diodes; no rows for a board that moves, or where that is not known (still None). resolution_s:
    step of the recording's clock; origin: with the names of the `stations`, and the `generation`
    where that is not the first.

    Metadata: for each rotor the standard deviation of a diode (median) and of its independent
    part, the clock's step, and whether the spread of a diode, or of that part, is below it: then
    it is rounding that is seen; or the reason why there are no rows.
    """
    parts: list[Columns] = []
    rotors: list[Row] = []
    if still:
        seen = origin.get("stations", ROLES), origin.get("generation", 1)
        for angles in still_angles(hits, *seen):
            parts += _curves(angles, settings)
            rotors.append(_rotor(angles, resolution_s))
    more: Metadata = {"allan": settings.model_dump(), "rotors": rotors}
    if not still:
        more["reason"] = UNKNOWN if still is None else MOVED
    elif not parts:
        more["reason"] = "no diode was hit in half of the sweeps"
    columns = {name.replace("_mm", "_rad"): v for name, v in joined(parts, ALLAN).items()}
    write_table(path, columns, origin | more)


def _rotor(angles: StillAngles, resolution_s: float | None) -> Row:
    sd = float(np.median(np.nanstd(angles.deviation, axis=0, ddof=1)))
    step = None if resolution_s is None else resolution_s * angles.rad_per_s
    alone = float(np.sqrt(np.nanmean(angles.independent**2))) if angles.diodes.size > 1 else None
    return {
        "rotor": angles.name,
        "diodes": angles.diodes.tolist(),
        "sweeps": len(angles.deviation),
        "rate_hz": angles.rate_hz,
        "sd_rad": sd,
        "independent_sd_rad": alone,
        "step_rad": step,
        "below_step": None if step is None else sd < step,
        "independent_below_step": None if step is None or alone is None else alone < step,
    }


def _curves(angles: StillAngles, settings: of.Allan) -> list[Columns]:
    """Columns of the common part, the independent part of all diodes together, and every diode."""
    n = len(angles.deviation)
    m = averaging_factors(n, settings.n_taus, settings.min_m, settings.max_fraction)

    def curve(series: np.ndarray, kind: str) -> AllanCurve:
        how = (settings.confidence, settings.min_coverage)
        return allan_curve(np.ascontiguousarray(series), angles.rate_hz, m, kind, *how)

    columns = []
    for kind in settings.estimators:
        if angles.diodes.size > 1:
            each = [curve(series, kind) for series in angles.independent.T]
            independent = _pooled(each, settings.confidence)
            common = curve(angles.common, kind)
            seen = float(np.mean(angles.seen[angles.seen > 1]))
            common = _common_variance(common, independent, seen, settings.confidence)
            columns.append(allan_columns(f"{angles.name}_common", common, kind))
            columns.append(allan_columns(f"{angles.name}_independent", independent, kind))
        for diode, series in zip(angles.diodes, angles.deviation.T, strict=True):
            columns.append(allan_columns(f"{angles.name}_{diode}", curve(series, kind), kind))
    return columns


def _pooled(curves: Sequence[AllanCurve], confidence: float) -> AllanCurve:
    """Mean variance of n curves, where all have one; n - 1 of them are independent."""
    shared = [m for m in curves[0].m if all(m in one.m for one in curves[1:])]
    parts = [_at_factors(one, np.array(shared, dtype=np.int64)) for one in curves]
    variance = np.mean([one.variance for one in parts], axis=0)
    edf = np.mean([one.edf for one in parts], axis=0) * (len(parts) - 1)
    lower, upper = interval(variance, edf, confidence)
    return replace(parts[0], variance=variance, edf=edf, lower=lower, upper=upper)


def _common_variance(
    common: AllanCurve, independent: AllanCurve, seen: float, confidence: float
) -> AllanCurve:
    """The common part without 1 / seen of the independent variance; factors at which nothing is
    left are dropped."""
    shared = np.intersect1d(common.m, independent.m)
    total, other = _at_factors(common, shared), _at_factors(independent, shared)
    less = total.variance - other.variance / seen
    positive = less > 0
    total, less = _at_factors(total, shared[positive]), less[positive]
    edf = np.maximum(total.edf * (less / total.variance) ** 2, 1.0)  # the scatter stays
    lower, upper = interval(less, edf, confidence)
    return replace(total, variance=less, edf=edf, lower=lower, upper=upper)


def _at_factors(curve: AllanCurve, m: np.ndarray) -> AllanCurve:
    """The curve at some of its averaging factors."""
    rows = np.flatnonzero(np.isin(curve.m, m))
    fields = {k: getattr(curve, k) for k in AllanCurve.__dataclass_fields__}
    return AllanCurve(**{k: v[..., rows] for k, v in fields.items() if v is not None})
