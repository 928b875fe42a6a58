"""The uncertainty of a length that is measured in one frame, on another day and at any place of the
volume that a bar was carried through, after the mean error of the bar is subtracted.

    u_c^2 = u_frame^2 / n + u_rest^2 + u_pass^2 (1 + 1/k) + u_place^2 + u_class^2
            + u_ref^2 + (u_s L)^2 + step^2 / 12 + u_drift^2

Within a pass: frame to frame (white, less in a mean of n frames), a slower rest and place are mean
squares over passes about each pass's own mean, so that with the scatter of the k means, which takes
the place of u_pass and of what a mean of few correlation times hides, they add up to the variance
of a frame of a new pass. With three dates or more that scatter is of their means, D of them, and of
the passes of a date, s_p^2 (1 - 1/m): together the variance of a pass of a new date (balanced
one-way analysis of variance). Class: of the directions that were covered, all of them, about their
mean. Type B: certificate, scale where it is known otherwise, step of the file (rectangular), and
the scatter of a monitor from take to take; the last only where no dates show it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mocap_metrology.accuracy.bar import Bar, OfClass
from mocap_metrology.accuracy.parts import frame_variance
from mocap_metrology.accuracy.statistics import FEWEST
from mocap_metrology.common.gum import Budget, Component, effective_dof

ANY = "any"
BETWEEN = ("date", "pass")  # the first of them is of the means that the correction is of


@dataclass(frozen=True)
class Statement:
    """The uncertainty of a length in one direction, or in any. correction_mm: to be added to a
    measured length; n_dates: number of dates whose scatter is in the budget, 0 if that of passes
    is."""

    direction: str
    passes: int
    n_dates: int
    correction_mm: float
    budget: Budget


def statements(
    bar: Bar, known: Sequence[Component] = (), averaged: float = 1
) -> tuple[Statement, ...]:
    """Statements for any direction, then for each class of FEWEST passes or more; none without such
    a class. known: components from elsewhere, `drift` by a monitor and `scale`, relative; averaged:
    frames of one place and pass of which a mean is stated."""
    classes = [one for one in bar.classes if len(one.passes) >= FEWEST]
    of_passes = [_of_passes(one, averaged) for one in classes]
    if not of_passes:
        return ()
    common = _common_components(bar, known, dated=all(one.n_dates for one in of_passes))
    if len(of_passes) > 1:
        of_passes = [_statement_for_any(of_passes), *of_passes]
    return tuple(
        Statement(one.direction, one.passes, one.n_dates, one.correction_mm,
                  Budget((*one.budget.components, *common)))
        for one in of_passes
    )  # fmt: skip


def _of_passes(one: OfClass, averaged: float) -> Statement:
    """What the passes of a class show."""
    means = np.array([float(np.nanmean(e)) for e in one.errors])
    rest = np.array([np.nanvar(r) for r in one.parts.rest])
    frame = np.array([frame_variance(e) for e in one.errors])
    frame = np.minimum(frame, rest)
    place = np.array([np.nanvar(e) for e in one.errors]) - rest
    n_eff = one.parts.n_eff
    components = [
        _mean_square("frame", frame, one.n_frames, averaged),
        _mean_square("rest", rest - frame, n_eff),
        _mean_square("place", place, n_eff),
    ]
    dates = [means[np.array(one.dates) == date] for date in dict.fromkeys(one.dates) if date]
    dated = len(dates) >= FEWEST and all(one.dates)
    units = np.array([day.mean() for day in dates]) if dated else means
    k = units.size
    scatter = float(units.std(ddof=1)) * math.sqrt(1 + 1 / k)
    between = [Component("date" if dated else "pass", "A", scatter, k - 1)]
    if dated and (inner := means.size - k):
        within = sum(float(((day - day.mean()) ** 2).sum()) for day in dates) / inner
        between.append(Component("pass", "A", math.sqrt(within * (1 - k / means.size)), inner))
    budget = Budget((*components, *between))
    return Statement(one.name, means.size, k * dated, -float(units.mean()), budget)


def _mean_square(name: str, squares: np.ndarray, most: float, averaged: float = 1) -> Component:
    """Type A by the mean of squares (k,) of passes: degrees of freedom by their scatter, 2 u^4 /
    var(u^2) (G.3 of the GUM), from k - 1 to those of independent values."""
    k, mean = squares.size, max(float(squares.mean()), 0.0)
    variance = float(squares.var(ddof=1)) / k
    dof = 2 * mean**2 / variance if variance > 0 else math.inf
    return Component(name, "A", math.sqrt(mean / averaged), max(min(dof, most), k - 1.0))


def _statement_for_any(several: Sequence[Statement]) -> Statement:
    """The statement for any class, each as likely as another: mean variances, and the variance of
    the means."""
    by_name: dict[str, list[Component]] = {}
    for one in several:
        for component in one.budget.components:
            by_name.setdefault(component.name, []).append(component)
    components = []
    for name, parts in by_name.items():
        u, dof = [part.u for part in parts], [part.dof for part in parts]
        size = math.sqrt(sum(x**2 for x in u) / len(several))
        components.append(Component(name, "A", size, effective_dof(u, dof)))
    corrections = np.array([one.correction_mm for one in several])
    between = (next(c for c in one.budget.components if c.name in BETWEEN) for one in several)
    worth = sum(component.dof for component in between)
    components.append(Component("class", "A", float(corrections.std()), worth))
    passes = sum(one.passes for one in several)
    dates = min(one.n_dates for one in several)
    return Statement(ANY, passes, dates, float(corrections.mean()), Budget(tuple(components)))


def _common_components(bar: Bar, known: Sequence[Component], dated: bool) -> list[Component]:
    components = []
    if bar.certificate:
        components.append(Component("reference", "B", bar.certificate.u_mm))
    components += [replace(one, u=one.u * bar.reference_mm) for one in known if one.name == "scale"]
    step = max(take.step_mm for take in bar.takes)
    components.append(Component("resolution", "B", step / math.sqrt(12)))
    return components + [one for one in known if one.name == "drift" and not dated]


def known_of(
    pair: Sequence[str],
    monitors: Sequence[Mapping[str, Any]] = (),
    points: Mapping[str, Any] | None = None,
) -> list[Component]:
    """Out of contents of monitor.json, the largest scatter of the length of this pair, and of
    <group>_points.json the standard error of the scale, unless their frame changed or points are
    wrong: those have no scale."""
    names = {f"length {'-'.join(order)}" for order in (pair, pair[::-1])}
    series = [s for one in monitors for n, s in one.get("series", {}).items() if n in names]
    scatter = [(one["scatter"], one["dof"]) for one in series if "scatter" in one]
    known = [Component("drift", "A", *max(scatter))] if scatter else []
    wrong = ("cuts", "drift_mm", "wrong_point", "exchanged", "mispaired")
    if points and points.get("scale_se_ppm") and not any(map(points.get, wrong)):
        dof = points["n_places"] - 1
        known.append(Component("scale", "A", 1e-6 * points["scale_se_ppm"], dof))
    return known


def statement_numbers(
    bar: Bar, pair: Sequence[str], known: Sequence[Component]
) -> tuple[dict[str, Any], list[str]]:
    """Numbers of <group>_statement.json, and what the statements do not cover, by code."""
    stated = statements(bar, known)
    means = statements(bar, known, averaged=math.inf)
    middle = np.concatenate([take.middle_mm[:, take.known] for take in bar.takes], axis=1) / 1000
    ends = zip("xyz", middle.min(axis=1).tolist(), middle.max(axis=1).tolist(), strict=True)
    dated = bool(stated) and bool(stated[0].n_dates)
    document: dict[str, Any] = {
        "pair": list(pair),
        "certificate": None if bar.certificate is None else vars(bar.certificate),
        "reference_mm": float(f"{bar.reference_mm:.6g}"),
        "where_m": {axis: [low, high] for axis, low, high in ends},
        "passes": [take.name for take in bar.takes],
        "dates": sorted({take.date for take in bar.takes if take.date}),
        "undated": sum(not take.date for take in bar.takes),
        "has_drift": any(one.name == "drift" for one in known) and not dated,
        "statements": [_row(*both) for both in zip(stated, means, strict=True)],
    }
    covered = dated or document["has_drift"]
    open_ends = ["latency", "volume", "other_lengths"]
    open_ends += ["directions"] * bool(stated) + ["other_days"] * (not covered)
    open_ends += ["absolute"] * (bar.certificate is None)
    open_ends += ["exact"] * (bar.certificate is not None and not bar.certificate.u_mm)
    return document, open_ends


def _row(one: Statement, mean: Statement) -> dict[str, Any]:
    budget = one.budget
    parts = [
        {"name": c.name, "type": c.kind, "u_mm": c.u,
         "dof": None if math.isinf(c.dof) else c.dof, "share": budget.share(c)}
        for c in budget.components
    ]  # fmt: skip
    return {
        "direction": one.direction,
        "passes": one.passes,
        "dates": one.n_dates,
        "correction_mm": round(one.correction_mm, 9),  # mm: what is smaller is arithmetic
        "u_mm": budget.u,
        "dof": None if math.isinf(budget.dof) else budget.dof,
        "k": budget.k,
        "U_mm": budget.expanded,
        "U_of_mean_mm": mean.budget.expanded,
        "budget": parts,
    }
