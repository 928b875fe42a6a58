"""Fitted coefficients beside published ones: which terms belong together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

LIMIT = 10.0  # correlation times that differ by a greater factor are of different components


def by_estimator(
    rows: Iterable[Mapping[str, Any]], series: str
) -> dict[str, dict[str, Mapping[str, Any]]]:
    """Rows of one series of noise.csv: estimator -> parameter -> row, in their order."""
    found: dict[str, dict[str, Mapping[str, Any]]] = {}
    for row in rows:
        if row["series"] == series:
            found.setdefault(row["estimator"], {})[row["parameter"]] = row
    return found


def correlation_times(values: Mapping[str, float]) -> dict[int, float]:
    """Number -> T_c of the Gauss-Markov terms that have one; the rest is passed over."""
    return {
        int(name[3:]): float(value)
        for name, value in values.items()
        if name.startswith("T_c") and value is not None and 0 < float(value) < math.inf
    }


def pair(published: Mapping[int, float], fitted: Mapping[int, float]) -> dict[int, int]:
    """Published number -> fitted number of the Gauss-Markov terms that belong together.

    Least sum of |ln(T_c / T_c')| over all assignments (Kuhn 1955), in which a term without a
    partner costs as much as a pair that differs by the factor `LIMIT`; so no pair differs by more,
    and a good pair is not split into two poor ones.
    """
    from scipy.optimize import linear_sum_assignment

    if not published or not fitted:
        return {}
    rows, columns = list(published), list(fitted)
    ours, theirs = np.log(list(published.values())), np.log(list(fitted.values()))
    distance = np.abs(ours[:, None] - theirs[None, :])
    far = math.log(LIMIT) * (1 + 1e-12)
    chosen = linear_sum_assignment(np.minimum(distance, far))
    return {
        rows[i]: columns[j]
        for i, j in zip(*(k.tolist() for k in chosen), strict=True)
        if distance[i, j] <= far
    }


def partners(published: Mapping[str, float], fitted: Mapping[str, float]) -> dict[str, str]:
    """Published parameter -> fitted parameter: Gauss-Markov terms by `pair`, others by name."""
    terms = pair(correlation_times(published), correlation_times(fitted))
    found = {name: name for name in published if name[1:3] != "_c" and name in fitted}
    for number, other in terms.items():
        for name in ("q_c", "T_c"):
            if f"{name}{number}" in published and f"{name}{other}" in fitted:
                found[f"{name}{number}"] = f"{name}{other}"
    return found
