"""A tracked board against motion capture of markers on it.

Both systems have a clock and a frame of their own. With the tracked pose R, p of the board at time
t, and marker j at l_j on the board, motion capture should see at its time

    m_j = s A (p + R l_j) + b,   time = offset + t + rate (t - middle of t),

A, b being the reference station's frame in that of motion capture. All of this is estimated by
least squares, weighed by the residuals (Huber 1964) and by what the track states of its own noise;
the scale s is estimated once more beside, and not applied. The offset is searched where the speeds
of both paths are alike (`offsets`). Errors of neighbouring moments are alike, so that standard
deviations are those of a jackknife over `BLOCKS` of the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.linear import nearest_rotation
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.calibrate.superpose import jackknife, kabsch
from mocap_metrology.lighthouse.rotation import exp, log
from mocap_metrology.lighthouse.track.markers import Alignment, Markers, Tracked

BLOCKS = 10
LEAST_MM = 30.0  # rms of the second direction of the path: along a line no frame is determined
LARGEST_SCALE = 0.05  # beyond it, and if nothing else fits: another unit
WORST_FIT = 0.2  # rms of the residuals over that of the path: another motion
CLEAR_FIT = 0.03  # below: the same motion
WORST_HELD_OUT = 0.35  # likewise, of a third of the time, by a fit to the rest
LEVER_SD_M, RATE_SD = 0.3, 5e-5  # known of these beforehand
CORRELATED_S = 0.3  # residuals within are alike
FLOOR_M = 5e-4  # of the noise of a moment
HUBER = 2.0  # times the median
MEDIAN_3D = 1.538  # of the length of a vector, over the standard deviation of a coordinate
AMBIGUOUS = 1.5  # rms at another offset over the best: both fit
NARROWEST_M = 5e-3  # of markers that show an attitude
MIRROR = np.array([1.0, 1.0, -1.0])[:, None]
ROUNDS = 30
SMALL = 1e-4  # of its noise: a step that ends the search
CANDIDATES = 6  # offsets that are tried
LEAST_S = 3.0  # of common time
APART_S = 0.25  # between two offsets that are tried
SMOOTHED = 5  # moments of a speed
LEVERS_M = 0.12 * np.vstack([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


@dataclass(frozen=True)
class Match:
    """An alignment with scale 1, and what it leaves.

    free: the alignment whose scale is free, which determines clock and lever also of a track of
    another size; sd: of its `values`. time_s (n,): moments that both know; place_m (n, markers, 3):
    of motion capture less of the track, in axes of motion capture; turn_rad (n, 3): likewise of the
    attitude, None of fewer than three markers that span a surface; slip_s, slip_share: as `_slips`.
    """

    alignment: Alignment
    free: Alignment
    sd: Floats
    time_s: Floats
    place_m: Floats
    turn_rad: Floats | None = None
    slip_s: float = 0.0
    slip_share: float = 0.0


def match(track: Tracked, seen: Markers) -> Match:
    """Raises `Refusal` where the recordings are not of one motion, or of too little."""
    if (known_s := seen.known_s) < LEAST_S:
        raise Refusal(
            f"receiver: frames with {', '.join(seen.labels)} follow one another for {known_s:.3g} s"
            f" in all; expected {LEAST_S:g} s"
        )
    known = np.asarray(np.isfinite(track.t_m).all(axis=1))
    fits = _fits(track, seen, known)
    if not fits:
        raise Refusal(
            f"receiver: the track and motion capture have no {LEAST_S:g} s in common; expected one"
            " motion, recorded by both"
        )
    fit, free = fits[0], _Fit(track, seen, known, fits[0].alignment, free_scale=True)
    _check(fits)
    others = []
    for block in np.array_split(np.flatnonzero(fit.kept), BLOCKS):
        rest = fit.kept.copy()
        rest[block] = False
        others.append(_Fit(track, seen, rest, free.alignment, free_scale=True).alignment.values())
    sd = np.sqrt(np.diag(jackknife(np.array(others))))
    used = fit.kept
    off = track.time_s[used], fit.residual[used], _turns(fit), *_slips(fit)
    return Match(fit.alignment, free.alignment, sd, *off)


def _fits(track: Tracked, seen: Markers, known: np.ndarray) -> list[_Fit]:
    """From every offset that is likely, the best first."""
    fits = [_Fit(track, seen, known, near) for near in offsets(track, seen, known)]
    return sorted((fit for fit in fits if fit.common_s >= LEAST_S), key=lambda fit: -fit.score)


def _check(fits: Sequence[_Fit]) -> None:
    """Refuse what determines no alignment, or a wrong one; the best of the fits is the first."""
    fit = fits[0]
    size, whole = 1e3 * np.sqrt(fit.spread), float(np.sqrt(fit.spread.sum()))
    if size[1] < LEAST_MM:
        raise Refusal(
            f"receiver: it moves by {size[0]:.0f} mm rms in one direction and {size[1]:.0f} mm"
            f" across; expected {LEAST_MM:g} mm or more in two"
        )
    if fit.rms > WORST_FIT * whole:
        free = [_scaled_start(one) for one in fits]
        best = min(free, key=lambda one: one.rms / max(one.alignment.scale, 1e-9))
        scale = best.alignment.scale
        if abs(scale - 1) > LARGEST_SCALE and _of_one_motion(best, scale * whole):
            raise Refusal(
                f"receiver: the path by motion capture is {scale:.3g} times as large as that of the"
                " board; expected the same size (is the unit of the file right?)"
            )
        mirrored = replace(fit.seen, place_m=fit.seen.place_m * MIRROR)
        if any(_of_one_motion(one, whole) for one in _fits(fit.track, mirrored, fit.known)):
            raise Refusal(
                "receiver: the path by motion capture is the mirror image of that of the board;"
                " expected right-handed axes (is a sign or the order of the columns wrong?)"
            )
    if not _of_one_motion(fit, whole):
        raise Refusal(
            f"receiver: both paths, {1e3 * whole:.0f} mm rms large, differ by {1e3 * fit.rms:.0f}"
            " mm rms at the best offset of the clocks, or more where they were not fitted; expected"
            " one motion, recorded by both"
        )
    for other in fits:
        apart = abs(other.alignment.offset_s - fit.alignment.offset_s)
        long = other.common_s > fit.common_s / 2
        if long and apart > APART_S and other.rms < AMBIGUOUS * fit.rms:
            raise Refusal(
                f"receiver: the offset of the clocks is not determined, as {apart:.2f} s more or"
                " less fit as well; expected a motion that does not repeat itself"
            )


def _of_one_motion(fit: _Fit, whole: float) -> bool:
    """Whether what is left is small for a path of this rms, and where it is not very small, also in
    each third of the time by a fit to the others: to another motion levers and clock are fitted."""
    if not CLEAR_FIT * whole < fit.rms < WORST_FIT * whole:
        return bool(fit.rms < WORST_FIT * whole)
    squares = []
    for third in np.array_split(np.flatnonzero(fit.kept), 3):
        others = fit.kept.copy()
        others[third] = False
        residual = _Fit(fit.track, fit.seen, others, fit.alignment, fit.free_scale).residual[third]
        squares.append(np.sum(residual**2, axis=2))
    return bool(np.nanmean(np.concatenate(squares)) < (WORST_HELD_OUT * whole) ** 2)


def _scaled_start(fit: _Fit) -> _Fit:
    """From where a fit began, with the size that motion capture has of the path."""
    places, _ = fit.seen.at(fit.near.time(fit.track.time_s))
    both = fit.known & np.isfinite(places).all(axis=(1, 2))
    ratio = places[both].mean(axis=1).var(axis=0).sum() / fit.track.t_m[both].var(axis=0).sum()
    near = replace(fit.near, scale=float(np.sqrt(ratio)))
    return _Fit(fit.track, fit.seen, fit.known, near, free_scale=True)


class _Fit:
    def __init__(
        self,
        track: Tracked,
        seen: Markers,
        known: np.ndarray,
        near: Alignment,
        free_scale: bool = False,
    ):
        self.track, self.seen, self.known, self.free_scale = track, seen, known, free_scale
        self.alignment = self.near = near
        for _ in range(ROUNDS):
            if self._step() < SMALL:
                break
        self._renew()

    def _renew(self) -> None:
        """Residuals (n, markers, 3) at the present values, and which moments count."""
        alignment = self.alignment
        places, self.velocity = self.seen.at(alignment.time(self.track.time_s))
        arm = np.einsum("nij,mj->nmi", self.track.R, alignment.lever_m)
        self.tracked_m = (self.track.t_m[:, None] + arm) @ alignment.A.T
        self.residual = places - alignment.scale * self.tracked_m - alignment.b_m
        self.kept = self.known & np.isfinite(self.residual).all(axis=(1, 2))
        off = np.linalg.norm(self.residual[self.kept], axis=2)
        noise = np.hypot(self.track.noise_m[self.kept], FLOOR_M)
        size = off / noise[:, None]
        self.sigma = max(float(np.median(size)) / MEDIAN_3D, 1e-9) if size.size else np.inf
        outlying = size / (HUBER * MEDIAN_3D * self.sigma)
        self.weight = 1 / np.maximum(outlying, 1.0) / noise[:, None] ** 2

    def _step(self) -> float:
        """One step of Gauss and Newton; its size over the noise of the unknowns."""
        self._renew()
        alignment, n = self.alignment, len(self.seen.labels)
        k = self.kept
        if not k.any():
            return 0.0
        t = self.track.time_s[k] - alignment.middle_s
        J = np.zeros((k.sum(), n, 3, 8 + 3 * n + self.free_scale))
        J[..., :3] = alignment.scale * np.cross(self.tracked_m[k][..., None, :], -np.eye(3))
        J[..., 3:6] = -np.eye(3)
        J[..., 6] = self.velocity[k]
        J[..., 7] = self.velocity[k] * t[:, None, None]
        for m in range(n):
            J[:, m, :, 8 + 3 * m : 11 + 3 * m] = -alignment.scale * alignment.A @ self.track.R[k]
        if self.free_scale:
            J[..., -1] = -self.tracked_m[k]
        w = np.broadcast_to(self.weight[..., None], J.shape[:3]).ravel()
        flat, r = J.reshape(w.size, -1), self.residual[k].ravel()
        known = np.zeros(flat.shape[1])
        known[7], known[8 : 8 + 3 * n] = RATE_SD**-2, LEVER_SD_M**-2
        at = np.r_[np.zeros(7), alignment.rate, alignment.lever_m.ravel(), [0.0] * self.free_scale]
        step_s = float(np.median(np.diff(self.track.time_s)))
        variance = self.sigma**2 * max(1.0, CORRELATED_S / step_s)
        M = (flat * w[:, None]).T @ flat / variance + np.diag(known)
        step = -np.linalg.solve(M, flat.T @ (w * r) / variance + known * at)
        A, b_m = exp(step[:3]) @ alignment.A, alignment.b_m + step[3:6]
        clock = alignment.offset_s + float(step[6]), alignment.rate + float(step[7])
        lever_m = alignment.lever_m + step[8 : 8 + 3 * n].reshape(n, 3)
        scale = alignment.scale + (float(step[-1]) if self.free_scale else 0.0)
        self.alignment = Alignment(A, b_m, *clock, lever_m, alignment.middle_s, scale)
        return float(np.sqrt(step @ M @ step / step.size))

    @property
    def common_s(self) -> float:
        """How long both know the motion."""
        return float(self.kept.sum() * np.median(np.diff(self.track.time_s)))

    @property
    def rms(self) -> float:
        """Root mean square of the distances between places, m."""
        return float(np.sqrt(np.mean(np.sum(self.residual[self.kept] ** 2, axis=2))))

    @property
    def spread(self) -> Floats:
        """Variances of the path along its main directions in m^2, the largest first."""
        place = self.tracked_m[self.kept].mean(axis=1)
        return np.linalg.svd(place - place.mean(axis=0), compute_uv=False) ** 2 / len(place)

    @property
    def score(self) -> float:
        """How much of the path it explains: by how many moments, and how well."""
        if not self.kept.any():
            return -np.inf
        ratio = self.spread.sum() / max(self.rms**2, 1e-12)
        return float(self.kept.sum() * np.log(max(ratio, 1e-12)))


def _slips(fit: _Fit) -> tuple[float, float]:
    """By how much the times of motion capture differ from piece to piece in s, and which share of
    the squared errors e of the path this explains: sum e v / sum v v of each, v the velocity."""
    e, v = (x[fit.kept].mean(axis=1) for x in (fit.residual, fit.velocity))
    pieces = np.array_split(np.arange(len(e)), BLOCKS)
    late = [float(np.sum(e[k] * v[k]) / max(np.sum(v[k] ** 2), 1e-12)) for k in pieces]
    left = sum(np.sum((e[k] - s * v[k]) ** 2) for k, s in zip(pieces, late, strict=True))
    return float(np.ptp(late)), float(1 - left / max(np.sum(e**2), 1e-30))


def _turns(fit: _Fit) -> Floats | None:
    """Rotation vectors (n, 3) from the tracked attitude to that by the markers, in axes of motion
    capture; None of fewer than three markers, or of markers on a line."""
    lever = fit.alignment.lever_m
    if len(lever) < 3:
        return None
    if np.linalg.svd(lever - lever.mean(axis=0), compute_uv=False)[1] < NARROWEST_M:
        return None
    ours, seen = fit.tracked_m[fit.kept], (fit.residual + fit.tracked_m)[fit.kept]
    ours, seen = (x - x.mean(axis=1, keepdims=True) for x in (ours, seen))
    return log(nearest_rotation(np.einsum("nmi,nmj->nij", seen, ours)))


def offsets(track: Tracked, seen: Markers, known: np.ndarray) -> list[Alignment]:
    """Rough alignments, the best first: time offsets at which the speeds of both are most alike, by
    their normalised correlation over what is known of both at each lag (Padfield 2012); the speed
    of the board, and of places some way from it, as the markers may be."""
    step = float(np.median(np.diff(track.time_s)))
    grid = step * np.arange(int(seen.duration_s / step) + 1, dtype=np.float64)
    places, _ = seen.at(grid)
    its, n = speed(places.mean(axis=1), step), track.time_s.size
    paths = [track.t_m + track.R @ lever for lever in LEVERS_M]
    likely = []
    for place in paths:
        r, count = _correlation(speed(place, step), its)
        z = np.arctanh(np.clip(r, -0.999, 0.999)) * np.sqrt(count)
        likely.append(np.where(count * step >= LEAST_S, z, -np.inf))
    lever, score = np.argmax(likely, axis=0), np.max(likely, axis=0)
    alignments: list[Alignment] = []
    middle = float(np.median(track.time_s))
    for _ in range(CANDIDATES):
        best = int(np.argmax(score))
        if not np.isfinite(score[best]):
            break
        lag, which = best - (n - 1), int(lever[best])
        near = round(APART_S / step)
        score[max(best - near, 0) : best + near + 1] = -np.inf
        offset = lag * step - float(track.time_s[0])
        places, _ = seen.at(track.time_s + offset)
        both = known & np.isfinite(places).all(axis=(1, 2))
        if both.sum() * step < LEAST_S:
            continue
        A, b = kabsch(paths[which][both], places[both].mean(axis=1))
        levers = np.tile(LEVERS_M[which], (len(seen.labels), 1))
        alignments.append(Alignment(A, b, offset, 0.0, levers, middle))
    return alignments


def speed(place: Floats, step_s: float) -> Floats:
    """Speed (n,), the mean of some moments of which most are known; NaN at gaps."""
    speed = np.linalg.norm(np.gradient(place, step_s, axis=0), axis=1)
    known, around = np.isfinite(speed), np.ones(SMOOTHED)
    count = np.convolve(known, around, mode="same")
    total = np.convolve(np.where(known, speed, 0.0), around, mode="same")
    return np.where(count > SMOOTHED / 2, total / np.maximum(count, 1), np.nan)


def _correlation(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Normalised correlation of b, later by each lag from 1 - len(a) on, with a, over the pairs
    that are known of both; and how many these are."""
    from scipy.signal import correlate

    ok = [np.isfinite(x) for x in (a, b)]
    x, y = (np.where(k, v - np.nanmean(v), 0.0) for k, v in zip(ok, (a, b), strict=True))

    def at_lags(first: Floats, second: Floats) -> Floats:
        return np.asarray(correlate(second, first, mode="full", method="fft"))

    w, v = (k.astype(float) for k in ok)
    n = np.round(at_lags(w, v))
    few = n < SMOOTHED
    n_ = np.where(few, 1.0, n)
    sx, sy = at_lags(x, v), at_lags(w, y)
    vx, vy = at_lags(x**2, v) - sx**2 / n_, at_lags(w, y**2) - sy**2 / n_
    floor = 1e-9 * max(float(x @ x), float(y @ y), 1e-30)
    r = (at_lags(x, y) - sx * sy / n_) / np.sqrt(np.maximum(vx, floor) * np.maximum(vy, floor))
    return np.where(few, -1.0, r), n
