"""What the figure of a fit shows, and how each part of it is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw
from mocap_metrology.present.fits.parts import Fit, Spectrum, Under
from mocap_metrology.present.plot.curves import Limits
from mocap_metrology.present.plot.figure import GREY, INK, LOOKS, Keywords

BELOW_DATA = 8.0  # an axis extends so many times below the least datum, for components
DASHES = (
    (0, (6, 1.4)),
    (0, (1.2, 1.2)),
    (0, (7, 1.4, 1.4, 1.4)),
    (0, (3, 1.2)),
    (0, (5, 1.2, 1.2, 1.2, 1.2, 1.2)),
)
DATA: Keywords = {"color": INK, "marker": "o", "ms": 2.2, "markerfacecolor": "white", "ls": ""}
DOTS: Keywords = {"color": GREY, "marker": "o", "ms": 1.4, "mew": 0, "ls": ""}
BAND: Keywords = {"color": GREY, "alpha": 0.3, "lw": 0}
MODEL: Keywords = {"color": INK, "lw": 1.5, "ls": "-", "zorder": 2.5}
UNDER: Keywords = {"color": INK, "lw": 1.0, "ls": (0, (2.2, 1.2))}
OTHERS: tuple[Keywords, ...] = tuple(  # other estimators: none of the components' colours
    {"color": colour, "lw": 1.0, "ls": dashes}
    for colour, dashes in (
        *(("#23733d", "-"), ("#8a6500", (0, (4, 1.2)))),
        *(("#a8308e", (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))), ("#6b6b6b", (0, (1.5, 1.5)))),
        ("#7a4f33", (0, (9, 1.2))),
    )
)


def part_styles(fit: Fit) -> list[Keywords]:
    """How each part is drawn: power laws blue, Gauss-Markov terms red, the sinusoid cyan; dashes
    by alpha or number. What is no noise has the colour of the model."""
    styles: list[Keywords] = []
    dashes: str | tuple[int, tuple[float, ...]]
    number = 0
    for part in fit.parts:
        if isinstance(part.component, PowerLaw):
            colour, dashes = LOOKS["x"].colour, DASHES[part.component.alpha + 2]
        elif isinstance(part.component, GaussMarkov):
            colour, dashes = LOOKS["y"].colour, DASHES[number % len(DASHES)]
            number += 1
        elif isinstance(part.component, Under):
            styles.append(UNDER)
            continue
        else:
            colour, dashes = LOOKS["z"].colour, "-"
        styles.append({"color": colour, "ls": dashes, "lw": 1.0})
    return styles


@dataclass(frozen=True)
class Shown:
    """What is drawn. allan: columns of the Allan deviation where there is one, float64."""

    allan: Mapping[str, np.ndarray]
    spectrum: Spectrum
    fit: Fit
    others: Sequence[Fit]
    rate_hz: float
    confidence: float

    @property
    def band(self) -> str:
        return f"{100 * self.confidence:.3g} % interval"


def near(values: np.ndarray, limits: Limits) -> np.ndarray:
    """Values on the axis and a little beyond, so that a file holds no more than is seen."""
    near = (values > limits[0] / 3) & (values < limits[1] * 3)
    return np.where(near, values, np.nan)


def clip(values: np.ndarray, limits: Limits) -> np.ndarray:
    known = np.nan_to_num(values, nan=limits[0])
    clipped: np.ndarray = np.clip(known, limits[0] / 10, limits[1] * 10)
    return clipped
