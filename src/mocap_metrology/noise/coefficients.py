"""Coefficients of the noise of one series of values."""

from __future__ import annotations

import numpy as np
import pandas as pd

from mocap_metrology.common.hampel import hampel
from mocap_metrology.noise.fit.estimates import rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood

MASK_SIGMA = 6.0  # gross outliers, which no noise model describes


def coefficients(values: np.ndarray, rate_hz: float) -> pd.DataFrame:
    """Coefficients of the noise of a series by maximum likelihood, in the columns of noise.csv:
    `parameter`, `value`, `unit`, `std_error`, `lower_95`, `upper_95`, `status`, ...

    values: (frames,), mm, NaN where there is none; gross outliers are left out first.
    """
    half_window = max(round(rate_hz), 1)
    masked = hampel(np.asarray(values, float), half_window, MASK_SIGMA, "mask").values
    return pd.DataFrame(rows("", likelihood(masked, rate_hz).estimate)).drop(columns="series")
