"""One take of a bar that is carried about: its length, where it is, how it points and moves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.accuracy.clusters import LEAST_FRAMES
from mocap_metrology.common.errors import Refusal

STEP_S = 0.1  # of a speed: long enough that noise of a frame counts little
STRIDE_S = 0.5  # of a way
LEAST_STRIDE_MM = 5.0  # below it the stride is noise
MOVING_MM_S = 20.0  # below it the bar stands
MOST_SPREAD = 0.05  # of the length of one object, (p97.5 - p2.5) / 4
MOST_BIAS = 0.05  # of a certificate that is of this object
SLIP_S, ABRUPT = 0.5, 0.7  # within which a marker slips, and how much of the change comes there
CLIPPED = 3.0  # spreads of the length
AXES = ("x", "y", "z")
OBLIQUE = "oblique"
LONG = 2.0  # times as long as across it: a way with a direction of its own
REVERSED = -0.9  # cosine of the angle between frames


@dataclass(frozen=True)
class Take:
    """A pass of the bar from marker A to B, all NaN where one is not seen: length_mm (n,),
    middle_mm (3, n), direction (3, n) of unit length, angle_deg (n,) of B in A against the stated
    or the mean one (None of markers); angle_bias_deg: of the mean against the stated one; step_mm:
    of the file."""

    name: str
    date: str
    frame_rate_hz: float
    length_mm: np.ndarray
    middle_mm: np.ndarray
    direction: np.ndarray
    step_mm: float
    angle_deg: np.ndarray | None = None
    angle_bias_deg: float = math.nan

    @property
    def known(self) -> np.ndarray:
        """(n,) whether both ends were seen."""
        return np.isfinite(self.length_mm)

    @property
    def _half(self) -> int:
        """Frames to each side of a speed."""
        return max(round(STEP_S * self.frame_rate_hz / 2), 1)

    def _velocity_mm_s(self, half: int) -> np.ndarray:
        """(3, n) of the middle, over `half` frames to both sides; NaN at gaps and ends."""
        velocity = np.full(self.middle_mm.shape, math.nan)
        step = self.middle_mm[:, 2 * half :] - self.middle_mm[:, : -2 * half]
        velocity[:, half:-half] = step * self.frame_rate_hz / (2 * half)
        return velocity

    @property
    def speed_mm_s(self) -> np.ndarray:
        """(n,) of the middle."""
        velocity = self._velocity_mm_s(self._half)
        return np.sqrt(np.einsum("kn,kn->n", velocity, velocity))

    @property
    def along_mm_s(self) -> np.ndarray:
        """(n,) velocity of the bar along itself, from A to B: of the middle and of both ends. By
        Richardson's extrapolation from two steps h, as a mean over time is off by some h^2."""
        half = self._half
        short = max(half // 2, 1)
        velocity = self._velocity_mm_s(short)
        if half > short:
            velocity += (velocity - self._velocity_mm_s(half)) / ((half / short) ** 2 - 1)
        return np.einsum("kn,kn->n", velocity, self.direction)


def take_of(
    name: str, date: str, frame_rate_hz: float, ends_mm: np.ndarray, step_mm: float
) -> Take:
    """From positions (2, 3, n) of both ends."""
    ends = np.asarray(ends_mm, dtype=float)
    both = np.isfinite(ends).all(axis=(0, 1))
    step = np.where(both, ends[1] - ends[0], math.nan)
    length = np.sqrt(np.einsum("kn,kn->n", step, step))
    with np.errstate(invalid="ignore", divide="ignore"):
        direction = step / length
    middle = np.where(both, ends.mean(axis=0), math.nan)
    return Take(name, date, frame_rate_hz, length, middle, direction, step_mm)


def with_angles(take: Take, quaternions: np.ndarray, stated: np.ndarray | None) -> Take:
    """The take with angles |log(R_ref^T R_A^T R_B)| of two bodies, quaternions (2, 4, n), x y z w;
    R_ref: the stated rotation of B in A as a quaternion (4,), or the mean one."""
    from scipy.spatial.transform import Rotation

    known = take.known & np.isfinite(quaternions).all(axis=(0, 1))
    if not known.any():
        return take
    a, b = (Rotation.from_quat(q[:, known].T) for q in quaternions)
    relative = a.inv() * b
    mean = relative.mean()
    reference, bias = mean, math.nan
    if stated is not None:
        reference = Rotation.from_quat(stated)
        bias = math.degrees(float((reference.inv() * mean).magnitude()))
    angle = np.full(take.length_mm.size, math.nan)
    angle[known] = np.degrees((reference.inv() * relative).magnitude())
    return replace(take, angle_deg=angle, angle_bias_deg=bias)


def reversals(take: Take) -> int:
    """How often the bar points the other way from one seen frame to the next: its markers have
    exchanged their labels."""
    direction = take.direction[:, take.known]
    return int(((direction[:, 1:] * direction[:, :-1]).sum(axis=0) < REVERSED).sum())


def way_mm(take: Take) -> float:
    """Length of the way of the middle, in strides of STRIDE_S that exceed the noise."""
    stride = max(round(STRIDE_S * take.frame_rate_hz), 1)
    places = take.middle_mm[:, take.known][:, ::stride]
    strides = np.sqrt((np.diff(places, axis=1) ** 2).sum(axis=0))
    return float(strides[strides > LEAST_STRIDE_MM].sum())


def spread_mm(take: Take) -> float:
    """Spread of the length, (p97.5 - p2.5) / 4."""
    low, high = np.quantile(take.length_mm[take.known], (0.025, 0.975))
    return float(high - low) / 4


def repeated_frames(take: Take) -> float:
    """Share of the frames of a bar that moves, by more than two steps of the file a frame, in which
    both ends are where they were in the frame before."""
    least = max(MOVING_MM_S, 2 * take.step_mm * take.frame_rate_hz)
    moves = take.speed_mm_s[1:] > least
    same = (np.diff(take.middle_mm) == 0).all(axis=0) & (np.diff(take.length_mm) == 0)
    return float(same[moves].mean()) if moves.any() else 0.0


@dataclass(frozen=True)
class Change:
    """Of a length within a take: change in mm; at_s: when, NaN of one that is not at once."""

    change: float
    at_s: float


def change(take: Take) -> Change | None:
    """How the length differs before and after one moment by more than it scatters on both sides
    (the split of least squares leaves less than half of the variance): at that moment, within
    SLIP_S, or slowly, then from the first to the last tenth; None where it does not. Gross errors
    are clipped."""
    known = np.flatnonzero(take.known)
    length = take.length_mm[known]
    middle, width = np.median(length), CLIPPED * spread_mm(take)
    length = np.clip(length - middle, -width, width)
    n, half = length.size, max(round(SLIP_S * take.frame_rate_hz), 3)
    count = np.arange(half, n - half)
    if not count.size or not length.any():
        return None
    total = np.cumsum(length - length.mean())
    between = total[count - 1] ** 2 * (1 / count + 1 / (n - count))
    if not between.max() > n * float(length.var()) / 2:
        return None
    at = int(count[np.argmax(between)])
    whole = float(np.median(length[at:]) - np.median(length[:at]))
    here = float(np.median(length[at : at + half]) - np.median(length[at - half : at]))
    if here * np.sign(whole) >= ABRUPT * abs(whole):
        return Change(whole, float(known[at] / take.frame_rate_hz))
    tenth = max(n // 10, 1)
    return Change(float(np.median(length[-tenth:]) - np.median(length[:tenth])), math.nan)


def check(take: Take, pair: str, certificate_mm: float | None, least_path_mm: float) -> None:
    """Refuse what says nothing of a bar; pair: its name in a message."""
    n, length = int(take.known.sum()), take.length_mm[take.known]
    if n < LEAST_FRAMES:
        what = f"{pair} are seen together in {n} frames; expected at least {LEAST_FRAMES}"
        raise Refusal(f"{take.name}: {what}")
    median, spread = float(np.median(length)), spread_mm(take)
    if not spread <= MOST_SPREAD * median:
        what = f"the distance of {pair} spreads by {spread:.3g} mm about {median:.4g} mm"
        hint = "expected two markers of one stiff object (or labels were exchanged on the way)"
        raise Refusal(f"{take.name}: {what}; {hint}")
    if float(np.median(np.abs(length - median))) <= take.step_mm / 2:
        what = f"the distance of {pair} never changes by more than a step of the file"
        hint = f"it was imposed by a solved body, or {take.step_mm:.2g} mm are too coarse to show "
        hint += "how it changes; expected markers as measured"
        raise Refusal(f"{take.name}: {what}: {hint}")
    way = way_mm(take)
    if way < least_path_mm:
        what = f"{pair} move by {way:.3g} mm; expected at least {least_path_mm:g} mm"
        raise Refusal(f"{take.name}: {what} (bar.least_path_mm): carry the bar through the volume")
    if certificate_mm is not None and abs(median / certificate_mm - 1) > MOST_BIAS:
        what = f"length_mm is {certificate_mm:g}, but {pair} are {median:.5g} mm apart"
        ratios = {10: "is it in cm?", 1000: "is it in m?", 25.4: "is it in inches?"}
        near = (w for r, w in ratios.items() if abs(median / certificate_mm / r - 1) < MOST_BIAS)
        raise Refusal(f"{take.name}: {what}; {next(near, 'expected the length of this pair')}")


def classes(takes: Sequence[Take], within_deg: float) -> list[np.ndarray]:
    """(n,) names of each take, such as `bar x, way y`: the axis of the file that the bar is nearest
    to in a frame, and that of the main motion while it points so; `oblique` beyond `within_deg`;
    empty in gaps. Ways that are hardly longer in one direction than across it (LONG) have the main
    axis of all such ways of that bar, as their own is a matter of chance."""
    bars = [np.where(take.known, _nearest(take.direction, within_deg), "") for take in takes]
    names = [np.full(take.length_mm.size, "", dtype="<U24") for take in takes]
    for axis in np.unique(np.concatenate(bars)):
        if not axis:
            continue
        inside = [bar == axis for bar in bars]
        ways = [_scatter(take.middle_mm[:, at]) for take, at in zip(takes, inside, strict=True)]
        extents = [np.sqrt(np.linalg.eigvalsh(way)[::-1].clip(0)) for way in ways]
        is_long = [size[0] > LONG * size[1] for size in extents]
        common = np.sum([way for way, long in zip(ways, is_long, strict=True) if not long], axis=0)
        for name, at, way, long in zip(names, inside, ways, is_long, strict=True):
            main = np.linalg.svd(way if long else common)[0][:, :1]
            name[at] = f"bar {axis}, way {_nearest(main, within_deg)[0]}"
    return names


def _scatter(places: np.ndarray) -> np.ndarray:
    """(3, 3) sums of products of places (3, n) about their mean; 0 of none."""
    if not places.size:
        return np.zeros((3, 3))
    centred = places - places.mean(axis=1, keepdims=True)
    return np.asarray(centred @ centred.T)


def _nearest(direction: np.ndarray, within_deg: float) -> np.ndarray:
    """(n,) names of the axes nearest to (3, n) directions."""
    size = np.abs(np.nan_to_num(direction))
    near = size.max(axis=0) >= math.cos(math.radians(within_deg)) - 1e-9
    return np.where(near, np.array(AXES)[size.argmax(axis=0)], OBLIQUE)
