"""Series as recorded but for their gross outliers: what verdicts and noise models are of."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from mocap_metrology.common.hampel import hampel, mask_half_window
from mocap_metrology.recording.table import Series, Table
from mocap_metrology.settings import Settings


def masked(raw: Table, clean: Table, settings: Settings) -> Iterator[Series]:
    """Every series as recorded, its gross outliers NaN: what verdicts and noise models are of."""
    rate, step = raw.origin["frame_rate_hz"], raw.origin["resolution_mm"]
    half_window = mask_half_window(settings.hampel.half_window_s, rate)
    outliers = known_outliers(clean, settings)
    for name, values in raw.with_distances():
        among = outliers(name, values)
        found = hampel(values, half_window, settings.noise.mask_sigma, "mask", step, among)
        yield name, found.values


def known_outliers(
    clean: Table, settings: Settings
) -> Callable[[str, np.ndarray], np.ndarray | None]:
    """Name and values as recorded -> (n,) the samples that the filter of S changed, among which the
    grosser outliers are; None where it was another window, or a higher threshold."""
    given, rate = settings.hampel, clean.origin["frame_rate_hz"]
    same = round(given.half_window_s * rate) == mask_half_window(given.half_window_s, rate)
    same &= given.action != "off" and given.n_sigma <= settings.noise.mask_sigma
    return lambda name, values: (clean.coordinates[name] != values) if same else None
