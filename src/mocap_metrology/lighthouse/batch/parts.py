"""A joint estimate held against itself: parts of its recording, and where residuals arise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint, Recording, recording, rough
from mocap_metrology.lighthouse.batch.solve import Noise, linearised, reduced
from mocap_metrology.lighthouse.records import AXES, ROLES, Halves

SPLITS = (1 / 3, 1 / 2, 2 / 3)  # of the duration; a bump is near one of them
FEWEST_SWEEPS = 40  # of a part


@dataclass(frozen=True)
class _Part:
    """Step from the estimate of all, and with what: `gain` M^-1 L of the priors, noise part."""

    step: np.ndarray
    gain: np.ndarray
    noise: np.ndarray


def _part(found: Joint, one: Recording, own: np.ndarray) -> _Part | None:
    """One Gauss-Newton step of all unknowns from some of the hits."""
    part = recording(one.sweeps.hits.take(own), one.trajectory, found.state)
    if part.sweeps.first.size - 1 < FEWEST_SWEEPS:
        return None
    coarse = rough(part)  # of a station that was moved the residuals are larger
    part.noise = Noise(max(coarse.hit, one.noise.hit), max(one.noise.sweep, 0.0))
    weight = part.weights().hit
    sums = linearised(part.seen, one.trajectory, found.state, part.residual, weight, found.of)
    without = reduced(sums, one.trajectory, part.noise)
    known = 1 / found.working**2
    M = np.linalg.inv(without.S + np.diag(known))
    step = -M @ (without.h + known * found.state.values)
    return _Part(step, M * known, M @ without.S @ M)


def halves(found: Joint, station: int = 1) -> Halves | None:
    """Pose of a station from the hits before and after each of `SPLITS` of the duration: the two
    that are farthest apart by m2.

    Errors of board and optics are the same in both and nearly cancel: with gain K_i = M_i^-1 L (see
    `covariance_of`), the difference has the covariance of both parts' noise and
    (K_1 - K_2) diag(believed^2) (K_1 - K_2)'.
    """
    one = found.recordings[0]
    time = one.sweeps.hits.time_s
    believed = np.where(np.isfinite(found.believed), found.believed, 0.0)
    rows, apart = found.pose(station), []
    for split in SPLITS:
        early = time < time.min() + split * np.ptp(time)
        a, b = _part(found, one, early), _part(found, one, ~early)
        if a is None or b is None:
            continue
        gain = (a.gain - b.gain) * believed
        covariance = (a.noise + b.noise + gain @ gain.T)[np.ix_(rows, rows)]
        d = (a.step - b.step)[rows]
        m2 = float(d @ np.linalg.solve(covariance, d))
        mm, deg = 1e3 * np.linalg.norm(d[:3]), np.degrees(np.linalg.norm(d[3:]))
        apart.append(Halves(float(mm), float(deg), m2))
    return max(apart, key=lambda pair: pair.m2, default=None)


def residual_ratios(one: Recording) -> dict[str, dict[str, float]]:
    """Rms residual beyond the sweep's offset over the noise of a hit: by station, axis, diode."""
    hits, z2 = one.sweeps.hits, (one.alone / one.noise.hit) ** 2
    found: dict[str, dict[str, float]] = {}
    for name, key, labels in (
        ("station", hits.station, ROLES),
        ("axis", hits.axis, AXES),
        ("diode", hits.diode, None),
    ):
        rms = rms_by(key, z2)
        seen = np.flatnonzero(np.isfinite(rms))
        found[name] = {
            labels[k] if labels and k < len(labels) else str(k): float(rms[k]) for k in seen
        }
    return found


def rms_by(key: np.ndarray, squares: np.ndarray, fewest: int = 1) -> Floats:
    """Root of the mean of squares for each value of a key from 0; NaN of fewer than `fewest`."""
    count = np.bincount(key)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(key, squares) / count
    return np.sqrt(np.where(count >= fewest, mean, np.nan))
