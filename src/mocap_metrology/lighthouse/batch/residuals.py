"""Residuals of a joint estimate by angle, time and diode, of each station and axis.

A residual is estimated minus measured. Noise leaves means near 0. A rotor that differs from its
model leaves a curve against the angle, a station that moved one against time, a displaced or slow
diode a large rms of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.parts import rms_by
from mocap_metrology.lighthouse.batch.recording import BatchInput, Recording, recording
from mocap_metrology.lighthouse.records import AXES, Hits

BINS = 12  # of angle and of time
FEWEST_HITS = 6  # of a bin
DIGITS = 2  # of urad and deg

Rows = list[dict[str, object]]


def residual_rows(found: Joint, hits: Hits, names: Sequence[str]) -> dict[str, Rows]:
    """Binned residuals of the first recording; hits: of the recording, also of excluded diodes;
    names: of the stations.

    `against`, for each station and axis and for `angle_deg` (as estimated) and `time_s`: middles of
    bins of equal width `at`, means `mean_urad` of the residuals, offsets of sweeps included, and
    `sd_urad`, the standard deviation of the mean by noise; `by_diode`, for each station: `diode`,
    `rms_urad` of the residuals without the offsets of sweeps, `n`, and those `excluded`.
    """
    one = found.recordings[0]
    return {
        "against": _against(one, names),
        "by_diode": _by_diode(one, _all_hits(found, hits), names),
    }


def _against(one: Recording, names: Sequence[str]) -> Rows:
    rows: Rows = []
    hits, weight = one.sweeps.hits, one.plain().hit
    # Bins of the measured angle would sort the hits of a board at rest by their residuals.
    estimated = hits.angle_rad + one.residual
    for name, values in (("angle_deg", np.degrees(estimated)), ("time_s", hits.time_s)):
        for station, role in enumerate(names):
            for axis, label in enumerate(AXES):
                own = np.flatnonzero((hits.station == station) & (hits.axis == axis))
                if not own.size:
                    continue
                at, mean, sd = binned_means(
                    values[own],
                    one.residual[own],
                    weight[own],
                    one.sweeps.sweep[own],
                    (one.noise.hit, one.noise.sweep),
                )
                rows.append(
                    {
                        "against": name,
                        "station": role,
                        "axis": label,
                        "at": np.round(at, 3).tolist(),
                        "mean_urad": np.round(1e6 * mean, DIGITS).tolist(),
                        "sd_urad": np.round(1e6 * sd, DIGITS).tolist(),
                    }
                )
    return rows


def binned_means(
    x: np.ndarray,
    residual: np.ndarray,
    weight: np.ndarray,
    sweep: np.ndarray,
    noise: tuple[float, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middles of `BINS` bins of equal width, means and their standard deviations, of the bins with
    `FEWEST_HITS` or more.

    x, residual, weight, sweep (n,) of hits; noise: standard deviations s of a hit and c of what the
    hits of a sweep share. With W = sum w, the mean is sum w r / W and its variance
    (s^2 sum w^2 + c^2 sum_sweeps (sum w)^2) / W^2.
    """
    edges = np.linspace(x.min(), x.max(), BINS + 1)
    in_bin = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, BINS - 1)
    total, square, sums = (
        np.bincount(in_bin, values, BINS) for values in (weight, weight**2, weight * residual)
    )
    n_sweeps = int(sweep.max()) + 1
    of_sweep = np.bincount(n_sweeps * in_bin + sweep, weight, n_sweeps * BINS)
    shared = np.sum(of_sweep.reshape(BINS, n_sweeps) ** 2, axis=1)
    many = np.bincount(in_bin, minlength=BINS) >= FEWEST_HITS
    hit, common = noise
    sd = np.sqrt(hit**2 * square[many] + common**2 * shared[many]) / total[many]
    return ((edges[:-1] + edges[1:]) / 2)[many], sums[many] / total[many], sd


def _all_hits(found: Joint, hits: Hits) -> Recording:
    """The recording with the hits of excluded diodes, along the same trajectory."""
    one = found.recordings[0]
    known = hits.take(one.trajectory.known(hits.time_s))
    if len(known) == one.residual.size:
        return one
    return replace(recording(BatchInput(known, one.trajectory), found.state), noise=one.noise)


def _by_diode(one: Recording, every: Recording, names: Sequence[str]) -> Rows:
    rows: Rows = []
    hits, square = every.sweeps.hits, every.alone**2
    for station, role in enumerate(names):
        own = hits.station == station
        rms = rms_by(hits.diode[own], square[own])
        count = np.bincount(hits.diode[own], minlength=rms.size)
        of_one = one.sweeps.hits.station == station
        used = np.bincount(one.sweeps.hits.diode[of_one], minlength=rms.size)
        seen = np.flatnonzero(count)
        rows.append(
            {
                "station": role,
                "diode": seen.tolist(),
                "rms_urad": np.round(1e6 * rms[seen], DIGITS).tolist(),
                "n": count[seen].tolist(),
                "excluded": seen[used[seen] == 0].tolist(),
            }
        )
    return rows
