"""Millions of samples reduced to those that a figure can show, including the extremes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd


def columns(values: np.ndarray, n_columns: int) -> pd.DataFrame:
    """A series (n,) cut into `n_columns` consecutive columns of equal length (or of one sample, if
    there are fewer), a row each.

    `first`, `stop`: samples of the column; `low`, `high`, `mean`: of its valid samples, NaN without
    one; `n_valid`: how many there are. NaN and infinite samples are gaps. A single sample that
    stands out is the `low` or the `high` of its column, whatever n.
    """
    values = np.asarray(values, dtype=np.float64)
    n_columns = max(min(n_columns, values.size), 0)
    edges = np.arange(n_columns + 1) * values.size // max(n_columns, 1)
    first, stop = edges[:-1], edges[1:]
    if not n_columns:
        return pd.DataFrame(
            columns=["first", "stop", "low", "high", "mean", "n_valid"], dtype=float
        )
    valid = np.isfinite(values)
    known = values if valid.all() else np.where(valid, values, np.nan)
    n_valid = np.add.reduceat(valid, first, dtype=np.int64)
    low, high = np.fmin.reduceat(known, first), np.fmax.reduceat(known, first)
    centre = (np.nanmin(low) + np.nanmax(high)) / 2 if n_valid.any() else 0.0
    about = known - centre  # sums about it keep their digits
    total = np.add.reduceat(about if known is values else np.nan_to_num(about), first)
    mean = np.where(n_valid > 0, centre + total / np.maximum(n_valid, 1), np.nan)
    rows = {"first": first, "stop": stop, "low": low, "high": high, "mean": mean}
    return pd.DataFrame(rows | {"n_valid": n_valid})


def runs(flags: np.ndarray) -> np.ndarray:
    """(k, 2) first and past-the-end index of every stretch of True."""
    edges = np.diff(np.concatenate([[0], np.asarray(flags).astype(np.int8), [0]]))
    return np.column_stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)])


@dataclass(frozen=True)
class Bins:
    """Values over logarithmic bins: centre, median and greatest, each (k,); empty bins left out."""

    centre: np.ndarray
    median: np.ndarray
    high: np.ndarray


def log_bins(x: np.ndarray, y: np.ndarray, per_decade: int) -> Bins:
    """Median and maximum of `y` (n,) over bins of `x` (n,) of equal width in log x.

    x is ascending. Points with x <= 0 or y not finite are left out. Where the bins are narrower
    than the spacing of x, every point is its own bin and nothing is changed; elsewhere a narrow
    line remains in `high`. The centre is the geometric mean of the x in the bin.
    """
    keep = (x > 0) & np.isfinite(y)
    frame = pd.DataFrame({"x": x[keep], "y": y[keep]}, dtype=np.float64)
    frame["log"] = np.log10(frame["x"])
    bins = frame.groupby(np.floor(frame["log"] * per_decade + 1e-9))
    centre = np.where(bins.size() == 1, bins["x"].first(), 10 ** bins["log"].mean())
    return Bins(centre, bins["y"].median().to_numpy(), bins["y"].max().to_numpy())
