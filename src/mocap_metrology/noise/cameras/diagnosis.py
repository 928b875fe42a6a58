"""Which addition of cameras raised the noise, by how much, and how sure: jackknife over a take.

The recording is cut into equal blocks; every number comes from all of them, and its standard error
from leaving out one at a time [Tukey 1958; Efron 1982, chapter 3], which needs no model of the
noise and keeps what subsets have in common by sharing their frames.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.cameras.covariance import block_sums, factors
from mocap_metrology.noise.cameras.information import (
    SAME_FRAMES,
    Addition,
    Chain,
    camera_noise,
    coherence,
    least_camera_noise,
    position_factors,
)

N_BLOCKS = 20
CHANCE_OF_ERROR = 1e-3  # probability of being wrong below which a finding counts
NAMING_S = 1.0  # longest tau at which a camera is named: beyond, too few terms are left
Read = Callable[[str, int], np.ndarray]  # recording, marker from 1 -> (3, n) coordinates in mm


def additions(camera_ids: Mapping[str, Sequence[int | str]]) -> list[Addition]:
    """Every pair of recordings of which one has all cameras of the other and more, with none in
    between; camera_ids: ids by recording."""
    sets = {name: frozenset(ids) for name, ids in camera_ids.items()}
    pairs = []
    for smaller, few in sets.items():
        for larger, many in sets.items():
            if few and few < many and not any(few < s < many for s in sets.values()):
                added = tuple(i for i in camera_ids[larger] if i not in few)
                pairs.append(Addition(smaller, larger, added))
    pairs.sort(key=lambda a: (len(sets[a.smaller]), len(sets[a.larger])))
    return pairs


@dataclass(frozen=True)
class Moments:
    """Sums over the terms of each block: sums (markers, taus, additions, blocks, 6, 6) of positions
    from the smaller subset, then from the larger, and counts (markers, taus, additions, blocks).
    markers: their numbers, from 0."""

    tau_s: tuple[float, ...]
    sums: np.ndarray
    counts: np.ndarray
    markers: tuple[int, ...] = ()

    def covariances(self, without: int | None = None) -> np.ndarray:
        """(markers, taus, additions, 6, 6), of all blocks or of all but one."""
        sums, counts = self.sums.sum(axis=3), self.counts.sum(axis=3)
        if without is not None:
            sums = sums - self.sums[:, :, :, without]
            counts = counts - self.counts[:, :, :, without]
        return sums / counts[..., None, None]


@dataclass(frozen=True)
class Estimate:
    """Estimates of factors with their standard errors; arrays of one shape. `ln` is the logarithm
    of the factor, `se` its jackknife standard error."""

    ln: Floats
    se: np.ndarray

    @property
    def factor(self) -> Floats:
        return np.exp(self.ln)

    def interval(self, share: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Confidence interval of the factor, by Student's t over the blocks."""
        from scipy.stats import t

        reach = t.ppf((1 + share) / 2, N_BLOCKS - 1) * self.se
        return np.exp(self.ln - reach), np.exp(self.ln + reach)

    def with_error(self, error: np.ndarray) -> Estimate:
        """The estimate with another error of its logarithm."""
        return Estimate(self.ln, np.hypot(self.se, error))

    def p_value(self) -> np.ndarray:
        """Probability of so large a factor were the true one 1."""
        from scipy.stats import t

        with np.errstate(invalid="ignore", divide="ignore"):
            return t.sf(self.ln / self.se, N_BLOCKS - 1)


@dataclass(frozen=True)
class Diagnosis:
    """largest, mean: (markers, taus, additions), factors of position noise; direction: the same and
    3, unit vectors; noise: (taus, additions) noise of the noisiest added camera relative to the
    others, NaN where frames are not the same; firsts: subset -> that of its noisiest camera at the
    shortest tau; together: (additions,) bool, same frames; information: (additions,) that was
    added, over what cameras add on average, NaN where frames are not the same."""

    tau_s: tuple[float, ...]
    largest: Estimate
    mean: Estimate
    direction: np.ndarray
    noise: Estimate
    firsts: Mapping[str, Estimate]
    together: np.ndarray
    information: np.ndarray

    def least_noise(self) -> np.ndarray:
        """What a single camera's noise must be at least to explain `largest`, (markers, taus,
        additions); 1.41 (any) where nothing rose."""
        return least_camera_noise(self.largest.factor)


def diagnose(
    moments: Moments, pairs: Sequence[Addition], camera_ids: Mapping[str, Sequence[int | str]]
) -> Diagnosis:
    """All results from the subsets of one take; `pairs`: the additions in the order of moments."""
    whole = moments.covariances()
    together = coherence(whole[:, 0]).min(axis=0) > SAME_FRAMES
    chains = _chains(pairs, camera_ids, together)
    firsts = [name for _, chain in chains for name in chain.firsts]

    def numbers(covariances: np.ndarray) -> list[np.ndarray]:
        factors = position_factors(covariances)[:2]
        return [np.log(part) for part in (*factors, *_noise(covariances, chains, len(firsts)))]

    largest, mean, noise, first = _jackknife(moments, numbers)
    direction = position_factors(whole)[2]
    return Diagnosis(
        moments.tau_s,
        largest.with_error(_unevenness(moments, direction[..., None, :], together)),
        mean.with_error(_unevenness(moments, np.eye(3), together)),
        direction,
        noise,
        {name: Estimate(first.ln[k], first.se[k]) for k, name in enumerate(firsts)},
        together,
        np.where(together, _information(whole[:, 0], pairs, camera_ids), np.nan),
    )


def _information(
    joint: np.ndarray, pairs: Sequence[Addition], camera_ids: Mapping[str, Sequence[int | str]]
) -> Floats:
    """(additions,) information that was added, mean over the markers: the trace of 1 - F, which is
    3 for all cameras together, over 3 n_added / n. joint: (markers, additions, 6, 6)."""
    transfer = joint[..., 3:, :3] @ np.linalg.inv(joint[..., :3, :3])
    added = 3 - np.trace(transfer, axis1=-2, axis2=-1).mean(axis=0)
    shares = [len(pair.added) / len(camera_ids[pair.larger]) for pair in pairs]
    return np.asarray(added / (3 * np.array(shares)))


def _unevenness(moments: Moments, directions: np.ndarray, together: np.ndarray) -> Floats:
    """(markers, taus, additions) error of the logarithm of a factor of recordings made one after
    the other: by how much it differs from the mean of the logarithms of the blocks. A shake or a
    burst in one of the two alone decides on the factor, but hardly on that mean. 0 of the same
    frames, which have it in common. directions: (..., d, 3), over which the mean is taken."""

    def logs(sums: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Differences of the logarithms of variances, (..., d)."""
        halves = sums[..., :3, :3], sums[..., 3:, 3:]
        with np.errstate(invalid="ignore", divide="ignore"):
            a, b = (np.log(np.einsum("...di,...ij,...dj->...d", u, half, u)) for half in halves)
            return np.asarray(b - a)

    whole = logs(moments.sums.sum(axis=3), directions)
    u = np.broadcast_to(directions, (*whole.shape, 3))[:, :, :, None]
    blocks = np.where(moments.counts[..., None] > 0, logs(moments.sums, u), np.nan)
    off = whole - np.nanmean(blocks, axis=3)
    return np.where(together, 0.0, off.mean(axis=-1) / 2)


def _noise(
    covariances: np.ndarray, chains: Sequence[tuple[np.ndarray, Chain]], n_firsts: int
) -> tuple[np.ndarray, np.ndarray]:
    """(taus, additions) and (firsts,) noise of cameras, the geometric mean over the markers."""
    markers, taus, n = covariances.shape[:3]
    noise, firsts = np.full((markers, taus, n), np.nan), np.full((markers, n_firsts), np.nan)
    done = 0
    for places, chain in chains:
        for marker in range(markers):
            noise[marker][:, places], first = camera_noise(covariances[marker][:, places], chain)
            firsts[marker, done : done + len(chain.firsts)] = first
        done += len(chain.firsts)
    return np.exp(np.log(noise).mean(axis=0)), np.exp(np.log(firsts).mean(axis=0))


def _jackknife(
    moments: Moments, numbers: Callable[[np.ndarray], list[np.ndarray]]
) -> list[Estimate]:
    """Numbers with their standard errors, each block left out once."""
    n = moments.sums.shape[3]
    each = zip(*(numbers(moments.covariances(block)) for block in range(n)), strict=True)
    with np.errstate(invalid="ignore"):
        errors = [np.sqrt((n - 1) * np.var(values, axis=0)) for values in each]
    return list(map(Estimate, numbers(moments.covariances()), errors))


def _chains(
    pairs: Sequence[Addition], camera_ids: Mapping[str, Sequence[int | str]], together: np.ndarray
) -> list[tuple[np.ndarray, Chain]]:
    """Additions of the same frames, by what hangs together: their places, and as a `Chain`."""
    part = {name: name for name in camera_ids}
    for addition, same in zip(pairs, together, strict=True):
        if same:
            old, new = part[addition.larger], part[addition.smaller]
            part = {name: new if label == old else label for name, label in part.items()}
    chains = []
    for root in dict.fromkeys(part.values()):
        places = [k for k, a in enumerate(pairs) if together[k] and part[a.smaller] == root]
        if not places:
            continue
        members = [pairs[k] for k in places]
        told = {i for a in members for i in a.added}
        larger = {a.larger for a in members}
        firsts = [
            name
            for name in dict.fromkeys(a.smaller for a in members)
            if name not in larger and not set(camera_ids[name]) <= told
        ]
        sizes = {name: len(ids) for name, ids in camera_ids.items()}
        chains.append((np.array(places), Chain(tuple(members), sizes, tuple(firsts))))
    return chains


def moments(
    pairs: Sequence[Addition],
    read: Read,
    n_markers: int,
    frame_rate_hz: float,
    n_frames: int,
    resolution_mm: Mapping[str, float] | None = None,
) -> Moments:
    """Moments at one frame, 0.1, 1 and 10 s as far as `n_frames`, the shortest recording, allows.

    Frames are matched by their number. Rounding to steps of `resolution_mm` (by recording) adds
    step^2 / 12 to the variance of every coordinate, white and on its own in each recording
    [Bennett 1948]; it is taken off. Markers without noise or that half of the time
    lacks are left out; refused if none is left.
    """
    chosen = factors(frame_rate_hz, n_frames, N_BLOCKS)
    if not chosen:
        raise Refusal(f"cameras: recordings of {n_frames} frames; expected {3 * N_BLOCKS} at least")
    sums = np.empty((n_markers, len(chosen), len(pairs), N_BLOCKS, 6, 6))
    counts = np.empty(sums.shape[:4])
    for marker in range(n_markers):
        for k, addition in enumerate(pairs):
            names = addition.smaller, addition.larger
            parts = [read(name, marker + 1) for name in names]
            both = np.concatenate([part[:, :n_frames] for part in parts])
            steps = [(resolution_mm or {}).get(name, 0.0) for name in names]
            rounding = np.diag(np.repeat(np.square(steps) / 12, 3))
            of = block_sums(list(both), chosen, N_BLOCKS)
            for t, (m, (total, count)) in enumerate(of.items()):
                sums[marker, t, k] = total - count[:, None, None] * rounding / m
                counts[marker, t, k] = count
    markers = [k for k in range(n_markers) if _usable(sums[k, 0], counts[k, 0])]
    if not markers:
        raise Refusal(
            "cameras: no marker with noise in every direction and enough frames in all of "
            f"{', '.join(dict.fromkeys(n for a in pairs for n in (a.smaller, a.larger)))}"
        )
    enough = [
        t for t in range(len(chosen)) if all(_usable(sums[k, t], counts[k, t]) for k in markers)
    ]
    cells = np.ix_(markers, enough)
    taus = tuple(chosen[t] / frame_rate_hz for t in enough)
    return Moments(taus, sums[cells], counts[cells], tuple(markers))


def _usable(sums: np.ndarray, counts: np.ndarray) -> bool:
    """Whether half of the blocks have terms, and positions noise, in all additions.

    Not noise of both subsets together: a camera leaves one direction exactly as it was.
    """
    if not ((counts > 0).sum(axis=1) >= N_BLOCKS / 2).all():
        return False
    whole = sums.sum(axis=1)
    values = np.linalg.eigvalsh(np.concatenate([whole[:, :3, :3], whole[:, 3:, 3:]]))
    return bool((values[:, 0] > 1e-12 * values[:, 2]).all())
