"""White noise that S prints, by the number of cameras (S Figure 2)."""

from __future__ import annotations

import numpy as np

from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, published_keys, published_row
from mocap_metrology.papers.subsets import NOT_FITTED, TYPES


def white_level(model: NoiseModel) -> float:
    """h_0 and, in mm^2/Hz too, 2 (q_c T_c)^2 of correlated noise with T_c below a frame: the level
    that its density has at low frequencies."""
    level = 0.0
    for part in model.components:
        if isinstance(part, GaussMarkov) and part.T_c < 1 / FRAME_RATE_HZ:
            level += 2 * (part.q_c * part.T_c) ** 2
        elif isinstance(part, PowerLaw) and part.alpha == 0:
            level += part.h
    return level


def white_roots() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Camera type -> numbers of cameras and root of `white_level`, mm/sqrt(Hz), geometric mean over
    the six coordinates; without Vantage's ten."""
    found = {}
    for kind in TYPES:
        counts = sorted(n for k, n in published_keys() if k == kind and (k, n) != NOT_FITTED)
        levels = [
            [white_level(model) for s, model in published_row(kind, n).items() if s != "L"]
            for n in counts
        ]
        found[kind] = np.array(counts), np.exp(np.mean(np.log(levels), axis=1) / 2)
    return found
