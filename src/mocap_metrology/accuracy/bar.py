"""A bar of known or unknown length in one take or several: classes, statistics, findings, a word.

In the manner of ASTM E3064-16 (withdrawn in January 2025): the error of the distance of two bodies
that move through the volume, by direction, with its mean, root mean square, quantiles and largest
value. An interval holds only where it knows that frames of one pass are alike: of a mean of one or
two takes by their effective number, of any other statistic from three passes on.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mocap_metrology.accuracy.clusters import LEAST_FRAMES
from mocap_metrology.accuracy.parts import Parts, parts_of
from mocap_metrology.accuracy.statistics import (
    FEWEST,
    Effects,
    Repeated,
    effective_number,
    half_interval,
    random_effects,
    repeated,
)
from mocap_metrology.accuracy.take import Take, classes
from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.settings import Bar as Settings

Statistic = Callable[[np.ndarray], float]


def _quantile(p: float) -> Statistic:
    return lambda e: float(np.quantile(np.abs(e), p))


STATISTICS: dict[str, Statistic] = {
    "mean": lambda e: float(e.mean()),
    "sd": lambda e: float(e.std(ddof=1)),
    "rms": lambda e: math.sqrt(float(np.mean(e**2))),
    "p50": _quantile(0.5),
    "p95": _quantile(0.95),
    "p99": _quantile(0.99),
    "p99.7": _quantile(0.997),
    "max": lambda e: float(np.abs(e).max()),
}
ALL = "all"
PRECISE = "precise"
LEAST_SEEN = 0.5
NORMAL = 1.96  # 95 % of a normal distribution


@dataclass(frozen=True)
class Certificate:
    """Length of the bar in mm and its standard uncertainty, mounting included."""

    length_mm: float
    u_mm: float = 0.0


@dataclass(frozen=True)
class Pose:
    """Quaternion (4,), x, y, z, w, of body B in A, and its standard uncertainty."""

    quaternion: np.ndarray
    u_deg: float


@dataclass(frozen=True)
class BarEntry:
    """Cells of a row: `A-B` or `auto`; certified length and its standard uncertainty; the stated
    rotation of B in A, as JSON."""

    bar: str
    length_mm: float | None = None
    length_u_mm: float | None = None
    bar_pose: str | None = None

    @property
    def certificate(self) -> Certificate | None:
        """The certified length and its standard uncertainty in mm; None without a length."""
        if self.length_mm is None:
            return None
        return Certificate(self.length_mm, self.length_u_mm or 0.0)

    @property
    def pose(self) -> Pose | None:
        """The stated rotation, refused where it is none."""
        if not self.bar_pose:
            return None
        try:
            told = json.loads(self.bar_pose)
            xyzw = np.array([*map(float, told["quaternion_xyzw"])])
            u_deg = float(told.get("u_deg", 0))
            if xyzw.size == 4 and abs(np.linalg.norm(xyzw) - 1) < 1e-3 and u_deg >= 0:
                return Pose(xyzw, u_deg)
        except UNREADABLE:
            pass
        what = 'expected JSON such as {"quaternion_xyzw": [0, 0, 0, 1], "u_deg": 0.1}'
        raise Refusal(f"bar_pose is {self.bar_pose}; {what}")


@dataclass(frozen=True)
class OfClass:
    """One direction of bar and motion. errors: (n,) of each pass, NaN where it is not in the class;
    statistics: by the names of STATISTICS."""

    name: str
    passes: tuple[str, ...]
    errors: tuple[np.ndarray, ...]
    middles: tuple[np.ndarray, ...]
    n_frames: int
    n_eff: float
    statistics: dict[str, Repeated]
    dates: tuple[str, ...]

    @cached_property
    def parts(self) -> Parts:
        """What the errors are made of."""
        return parts_of(self.errors, self.middles, self.dates)


@dataclass(frozen=True)
class Bar:
    """Everything that is known of a bar. reference_mm: what errors are against, the certificate's
    length or the mean; classes: of LEAST_FRAMES frames or more, by name; every: all frames of all
    classes; direction: between the classes, None of one."""

    takes: tuple[Take, ...]
    certificate: Certificate | None
    reference_mm: float
    classes: tuple[OfClass, ...]
    every: OfClass
    direction: Effects | None
    angles: dict[str, Repeated]

    @property
    def worst(self) -> OfClass:
        """The class of the largest 95 % quantile of the error."""
        return max(self.classes, key=lambda one: one.statistics["p95"].value)

    @property
    def size_mm(self) -> float:
        """What the word is of: that quantile, and twice the uncertainty of the certificate."""
        twice = 2 * self.certificate.u_mm if self.certificate else 0.0
        return self.worst.statistics["p95"].value + twice

    @property
    def seen(self) -> float:
        """Smallest share of the frames of a take in which both ends were seen."""
        return min(float(take.known.mean()) for take in self.takes)

    @property
    def rms_mm(self) -> float:
        """Largest rms of a class: beyond the quantile where some errors are gross."""
        return max(one.statistics["rms"].value for one in self.classes)

    def word(self, settings: Settings) -> str:
        """`good`, `usable` or `bad` of the accuracy; `precise` without a certificate. Usable at
        best where a bar was seen in fewer than LEAST_SEEN of the frames, as the errors of the
        others are not known, and where gross errors make the rms larger than what is good."""
        if self.certificate is None:
            return PRECISE
        whole = self.seen >= LEAST_SEEN and self.rms_mm <= settings.good_mm
        if self.size_mm <= settings.good_mm and whole:
            return "good"
        return "usable" if self.size_mm <= settings.usable_mm else "bad"


def evaluate(takes: Sequence[Take], certificate: Certificate | None, settings: Settings) -> Bar:
    """All of some passes of one bar."""
    named = classes(takes, settings.classes_deg)
    means = [np.nanmean(take.length_mm) for take in takes]
    reference = certificate.length_mm if certificate else float(np.mean(means))
    of_classes, used = [], [np.zeros(names.size, bool) for names in named]
    for name in sorted({str(one) for names in named for one in np.unique(names) if one}):
        inside = [names == name for names in named]
        inside = [mask if mask.sum() >= LEAST_FRAMES else mask & False for mask in inside]
        if any(mask.any() for mask in inside):
            of_classes.append(_of_class(name, takes, inside, reference))
            used = [a | b for a, b in zip(used, inside, strict=True)]
    if not of_classes:  # of a take that turns all the time
        used = [take.known for take in takes]
        of_classes = [_of_class(ALL, takes, used, reference)]
    every = of_classes[0] if len(of_classes) == 1 else _of_class(ALL, takes, used, reference)
    angles = [take.angle_deg for take in takes if take.angle_deg is not None]
    turned = statistics(angles) if angles else {}
    effects = _class_effects(of_classes)
    return Bar(tuple(takes), certificate, reference, tuple(of_classes), every, effects, turned)


def _of_class(
    name: str, takes: Sequence[Take], inside: Sequence[np.ndarray], reference_mm: float
) -> OfClass:
    members = [(take, where) for take, where in zip(takes, inside, strict=True) if where.any()]
    errors = tuple(
        np.where(where, take.length_mm - reference_mm, np.nan) for take, where in members
    )
    middles = tuple(np.where(where, take.middle_mm, np.nan) for take, where in members)
    worth = sum(effective_number(e) for e in errors)
    n_frames = sum(int(where.sum()) for _, where in members)
    names = tuple(take.name for take, _ in members)
    dates = tuple(take.date for take, _ in members)
    return OfClass(name, names, errors, middles, n_frames, worth, statistics(errors), dates)


def statistics(errors: Sequence[np.ndarray]) -> dict[str, Repeated]:
    """Each statistic of passes (n,): the mean of the passes' means, any other of all frames
    together; from FEWEST passes on with the interval of a pass's statistic, which holds that of all
    frames, too, and that of the next pass; of fewer the interval of the mean alone, where frames
    are worth enough."""
    passes = [e[np.isfinite(e)] for e in errors]
    every = np.concatenate(passes)
    numbers = {
        name: _with_value(repeated([of(e) for e in passes], positive=True), of(every))
        for name, of in STATISTICS.items()
    }
    numbers["mean"] = repeated([float(e.mean()) for e in passes])
    if len(passes) < FEWEST:
        half = math.hypot(*map(half_interval, errors)) / len(errors)
        mean = numbers["mean"].value
        numbers["mean"] = Repeated(len(passes), mean, mean - half, mean + half)
    return numbers


def _with_value(of: Repeated, value: float) -> Repeated:
    lower, upper = np.minimum(of.lower, value), np.maximum(of.upper, value)  # NaN remains
    return replace(of, value=value, lower=float(lower), upper=float(upper))


def pass_scatter(of_classes: Sequence[OfClass]) -> tuple[float, int]:
    """Variance of the means of passes within classes, pooled, and its degrees of freedom."""
    means = [np.array([float(np.nanmean(e)) for e in one.errors]) for one in of_classes]
    left = np.concatenate([of_class - of_class.mean() for of_class in means])
    dof = left.size - len(of_classes)
    return (float((left**2).sum()) / dof if dof else 0.0), dof


def _class_effects(of_classes: Sequence[OfClass]) -> Effects | None:
    """Random effects of the means of classes; None where nothing shows how passes scatter.

    Where each pass is in all classes, as of a bar that turns, its own offset is in none of their
    differences: their errors are those of frames, or from FEWEST passes on what is left of class
    and pass. Otherwise they are the scatter of the passes within classes, pooled. Classes of fewer
    passes whose mean has no interval are left out: nothing shows how uncertain it is.
    """
    are_shared = len({one.passes for one in of_classes}) == 1
    if few := are_shared and len(of_classes[0].passes) < FEWEST:
        of_classes = [one for one in of_classes if math.isfinite(one.statistics["mean"].upper)]
    if len(of_classes) < 2:
        return None
    means = [np.array([float(np.nanmean(e)) for e in one.errors]) for one in of_classes]
    frames = [_frame_variance(one, few) for one in of_classes]
    if are_shared:
        table = np.array(means)
        left = table - table.mean(axis=0) - table.mean(axis=1, keepdims=True) + table.mean()
        dof = (table.shape[0] - 1) * (table.shape[1] - 1) if table.shape[1] >= FEWEST else 0
        scatter = float((left**2).sum()) / dof if dof else 0.0
    else:
        scatter, dof = pass_scatter(of_classes)
        if dof < FEWEST - 1:
            return None
    variances = [
        max(scatter, v, 1e-12) / of_class.size for v, of_class in zip(frames, means, strict=True)
    ]
    return random_effects([of_class.mean() for of_class in means], variances, dof=dof or math.inf)


def _frame_variance(one: OfClass, few: bool) -> float:
    """Variance of the mean of a pass by its frames; of few passes by the interval of the mean."""
    if few:
        mean = one.statistics["mean"]
        return len(one.errors) * ((mean.upper - mean.lower) / 2 / NORMAL) ** 2
    worth = [np.nanvar(e) / max(effective_number(e), 1.0) for e in one.errors]
    return float(np.mean(worth))
