"""Spectra reduced to bins that a figure can show, including the extremes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd


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
