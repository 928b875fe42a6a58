"""What software did to the frames before the export, beside the filters of `export`.

Smoothed. A system that measures every frame by itself has white noise: S(f) of its fastest octaves
is a / W(f) + b, W(f) = 4 sin^2(pi f tau0), with b above the rounding of the file. Behind a Kalman
or a one-euro filter, which weigh each frame with the one before, b is gone. (Noise that is all
correlated, without a filter, has the same spectrum.)

Resampled. Interpolated frames scatter less the farther they are from a measured one, so that the
variance of the second differences is periodic in time, with the old frame rate against the new.
White noise that is louder at times has that, too: the squares of its values then vary by as much,
and those of its second differences by |4 + 2 cos w| / 6 of it, w = 2 pi f tau0 of the cycle.

Running median. Successive medians are often the same sample: one coordinate repeats its value
where the others do not, far more often than the steps of the file let it, and other samples next to
each other are alike. (Values that are held, or compressed by wavelets, are not: `repeated`.)

Repeated. All three coordinates of a measured marker stay the same from one frame to the next only
where the steps of the file hide its noise, and then it also leaves such a place by a step or two.
Where it leaves by many steps of the file, a coordinate had the same value by chance with a
probability of about step / change, and three of them with far less.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.linear import non_negative
from mocap_metrology.common.parallel import MapFunction, in_turn
from mocap_metrology.noise.diagnosis.export import Bands
from mocap_metrology.noise.diagnosis.fills import Rule
from mocap_metrology.noise.diagnosis.filtering import middle
from mocap_metrology.noise.series import distance, pair_name, position

OCTAVES = 8  # bands of the spectrum below its end, two octaves
MISFIT = 0.4  # of S in a band, that a / W + b is off by, at most
NO_WHITE = 0.15  # of S at the end of the spectrum is b
LONGEST = 1 << 17  # frames that are looked at
LEAST = 2000  # frames, to tell anything of
CLIPPED = 9.0  # times their median square, so that events and spikes make no line
CHANCE = 1e-4  # that any series of a sound recording is called resampled
LINE = 30.0  # times the median power beside it, of a line
DEEP = 0.15  # of the variance, that its cycle is at least
DEEPER = 1.5  # times what noise that is louder at times has; interpolated frames 1.8 to 12
SLOWEST = 0.02  # of the frame rate
REPEATED = 0.1  # of the values, from which a median ran; of five white samples it is 0.43
HELD = -0.4  # correlation of changes in turn: -1/3 behind a median of white noise, -1/2 if held
HIDDEN = 0.5  # chance of a repeat by the steps of the file, of the repeats, at most
LEAST_CHANGES = 16  # of frames, to know what a marker does from one to the next
SMALL = 0.005  # quantile of the changes: files may have coarser steps than declared
BEYOND = 4.0  # times the share that chance makes of one coordinate
SOLVED = 0.01  # of the variance; of markers that are measured apart it is about 1
LIKELIEST = 1 / 8  # chance of a repeat, from which nothing is reported
MANY = 1e-3  # share of the frames that is reported


@dataclass(frozen=True)
class Processed:
    """code: `smoothed` (value: white share of the density at the end of the spectrum), `resampled`
    (value: Hz, at which the variance of the frames varies), `running_median` and `repeated` (value:
    share of the values that repeat the one before)."""

    code: str
    series: str
    value: float


def processed(
    series: Mapping[str, np.ndarray],
    spectra: Mapping[str, Bands | None],
    rate_hz: float,
    step_mm: float,
    over: MapFunction = in_turn,
) -> list[Processed]:
    """What software did to the frames of still coordinates (n,) in mm, NaN in gaps, where most of
    them agree."""
    coordinates = {name: None for name in series if not name.startswith("L")}
    chance = CHANCE / max(len(coordinates), 1)

    def looked_at(name: str) -> tuple[float, float]:
        spectrum = spectra[name]
        white = math.nan if spectrum is None else white_share(spectrum, rate_hz, step_mm)
        return white, variance_cycle(np.asarray(series[name], float), rate_hz, chance)

    looked = dict(zip(coordinates, over(looked_at, coordinates), strict=True))
    smooth = {k: white for k, (white, _) in looked.items() if white < NO_WHITE}
    cyclic = {k: f for k, (_, f) in looked.items() if f > 0}
    return [
        Processed(code, *one)
        for code, of in (("smoothed", smooth), ("resampled", cyclic))
        if 2 * len(of) >= len(coordinates)
        for one in of.items()
    ]


def white_share(spectrum: Bands, rate_hz: float, step_mm: float) -> float:
    """b over a / W + b at the end of the spectrum, less the rounding of the file; by non-negative
    least squares of relative errors."""
    if spectrum.f_hz.size < OCTAVES or not spectrum.psd.min() > 0:
        return math.nan
    f, psd = spectrum.f_hz[-OCTAVES:], spectrum.psd[-OCTAVES:]
    steps = 4 * np.sin(np.pi * f / rate_hz) ** 2
    terms = np.stack([1 / steps, np.ones_like(f)], axis=1) / psd[:, None]
    a, b = non_negative(terms, np.ones(f.size))
    rounding = 2 * step_mm**2 / 12 / rate_hz * math.log(2)
    if rounding > NO_WHITE * psd[-1]:
        return math.nan  # of what the steps hide nothing is known
    if np.abs(terms @ [a, b] - 1).max() > MISFIT:
        return math.nan  # of another filter
    total = a / steps[-1] + b
    return float(max(b - rounding, 0.0) / total)


def variance_cycle(values: np.ndarray, rate_hz: float, chance: float) -> float:
    """Frequency in Hz at which the variance of second differences is periodic beyond chance and by
    a share of DEEP; 0 where it is not. Lines of the values, whose squares have others, are taken
    out first."""
    second = np.diff(values, 2)
    start = max((second.size - LONGEST) // 2, 0)
    second = second[start : start + LONGEST]
    known = np.isfinite(second)
    if np.count_nonzero(known) < max(second.size / 2, LEAST):
        return 0.0
    n = second.size
    spectrum = np.fft.rfft(np.where(known, second, 0.0))
    for part in np.array_split(spectrum, max(n // 500, 1)):  # which share memory
        power = np.abs(part) ** 2
        part[power > LINE * np.median(power)] = 0.0
    place = np.arange(spectrum.size)
    among = (place > SLOWEST * n) & (place < n / 2 - 2)
    mean, power = _squares(spectrum, known)
    level = float(np.median(power[among])) / math.log(2)
    at = int(np.argmax(np.where(among, power, 0.0)))
    depth = 2 * math.sqrt(power[at]) / np.count_nonzero(known) / mean if mean > 0 else 0.0
    if not (level > 0 and power[at] >= 2 * level * math.log(n / chance) and depth >= DEEP):
        return 0.0
    differences = np.maximum(4 * np.sin(np.pi * place / n) ** 2, 1e-300)
    mean_0, power_0 = _squares(np.where(place > SLOWEST * n, spectrum / differences, 0.0), known)
    depth_0 = 2 * math.sqrt(power_0[at]) / np.count_nonzero(known) / mean_0
    louder = depth_0 * (4 + 2 * math.cos(2 * math.pi * at / n)) / 6
    return at * rate_hz / n if depth >= DEEPER * louder else 0.0


def _squares(spectrum: np.ndarray, known: np.ndarray) -> tuple[float, np.ndarray]:
    """Mean and power spectrum of the clipped squares of values (n,) with this spectrum."""
    square = np.fft.irfft(spectrum, known.size) ** 2
    square = np.minimum(square, CLIPPED * np.median(square[known]))
    mean = float(square[known].mean())
    return mean, np.abs(np.fft.rfft(np.where(known, square - mean, 0.0))) ** 2


def running_median(
    axes: Mapping[str, npt.NDArray[np.floating]], step_mm: float
) -> Sequence[Processed]:
    """Signs of a running median in x, y, z (n,) of one marker."""
    axes = {name: axis[:LONGEST] for name, axis in axes.items()}
    same = {name: axis[1:] == axis[:-1] for name, axis in axes.items()}
    together = np.logical_and.reduce(list(same.values()))
    told = []
    for name, axis in axes.items():
        share = float(np.count_nonzero(same[name] & ~together)) / max(together.size, 1)
        if share < REPEATED:
            return []
        change = np.diff(axis.astype(np.float64))
        change = change[np.abs(change) > 0]
        if change.size < LEAST:
            return []
        step = max(step_mm, float(np.quantile(np.abs(change), SMALL)))
        in_turn = np.mean(change[1:] * change[:-1]) / np.mean(change**2)
        if step > HIDDEN * share * np.median(np.abs(change)):
            return []
        told.append(Processed("repeated" if in_turn < HELD else "running_median", name, share))
    return told


@dataclass(frozen=True)
class Repeats:
    """Repeated positions of one marker: share of the frames that repeat the one before; the longest
    such stretch, in frames; change_mm: what the marker does when it leaves one (median)."""

    label: str
    share: float
    longest: int
    change_mm: float


def repeats(
    label: str, position_mm: Sequence[npt.NDArray[np.floating]], step_mm: float
) -> Repeats | None:
    """Frames that repeat the one before, in x, y, z (n,) in mm, NaN in gaps; `step_mm`: resolution
    of the file, 0 where it is not known.

    None where there are no more repeats than chance and the steps of the file make.
    """
    same = np.logical_and.reduce([axis[1:] == axis[:-1] for axis in position_mm])
    count = int(same.sum())
    if not count:
        return None
    moved = ~same
    for axis in position_mm:
        moved &= np.isfinite(_changes(axis))
    if np.count_nonzero(moved) < LEAST_CHANGES:
        return None
    runs = np.flatnonzero(np.diff(np.concatenate([[0], same.view(np.int8), [0]]))).reshape(-1, 2)
    change, chance = _leaving(position_mm, runs, moved, step_mm)
    longest, share = int(np.ptp(runs, axis=1).max()), count / (same.size + 1)
    if chance > LIKELIEST:
        return None
    if share <= max(MANY, BEYOND * chance) and longest < Rule.run(chance):
        return None
    return Repeats(label, share, longest, change)


def _changes(axis: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
    """(n - 1,) sizes, one axis at a time: of 90 hours all three would be a gigabyte."""
    steps = np.diff(axis.astype(np.float64))
    return np.abs(steps, out=steps)


def _leaving(
    position_mm: Sequence[npt.NDArray[np.floating]],
    runs: npt.NDArray[np.intp],
    moved: npt.NDArray[np.bool_],
    step_mm: float,
) -> tuple[float, float]:
    """What the coordinate that does most does after the `runs` (median, in mm), and the chance that
    all repeat their values, the product of theirs, by what each does before or after, the smaller
    of both. moved (n - 1,): which changes are of no run."""
    best, chance = (0.0, 1.0), 1.0
    for axis in position_mm:
        changes = _changes(axis)
        before = np.where(runs[:, 0] > 0, changes[runs[:, 0] - 1], np.nan)
        after = np.where(runs[:, 1] < changes.size, changes[runs[:, 1] % changes.size], np.nan)
        nearest = np.fmin(before, after)
        known, steps = nearest[np.isfinite(nearest)], changes[moved & (changes > 0)]
        change = float(np.median(known)) if known.size else 0.0
        if change > 0 and steps.size:
            step = max(step_mm, float(np.quantile(steps, SMALL)))
            jump = float(np.nanmedian(after)) if np.isfinite(after).any() else change
            best = min(best, (jump, min(step / change, 1.0)), key=lambda one: one[1])
            chance *= min(step / change, 1.0)
    return best[0], chance


def solved_pairs(
    coordinates: Mapping[str, np.ndarray], pairs: Sequence[tuple[int, int]]
) -> dict[str, float]:
    """Distances between markers of a rigid body that the software solved: name -> variance of the
    steps of the distance from frame to frame over that of the steps of both ends along it.

    Ends that are measured by themselves have independent noise, so the ratio is 1. Markers at rest
    only: a body that moves keeps its distances, however they are measured.
    """
    ratios = {}
    near = {name: middle(v) for name, v in coordinates.items() if not name.startswith("L")}
    for first, second in pairs:
        a, b = position(near, first), position(near, second)
        with np.errstate(invalid="ignore"):
            along = np.nanmean(b - a, axis=1) if np.isfinite(a + b).any() else np.zeros(3)
        size = float(np.linalg.norm(along))
        steps = np.diff(distance(a, b))
        if not size > 0 or np.isfinite(steps).sum() < LEAST_CHANGES:
            continue
        ends = sum(float(np.nanvar(np.diff(along @ one / size))) for one in (a, b))
        ratio = float(np.nanvar(steps)) / ends if ends > 0 else 1.0
        if ratio < SOLVED:
            ratios[pair_name((first, second), pairs)] = ratio
    return ratios
