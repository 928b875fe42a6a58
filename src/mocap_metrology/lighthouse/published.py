"""Published numbers of Jansen et al. 2019 (J), read from the package's `reference/` folder;
and the factory values that are usual of second-generation stations.

Table I: mean absolute error of eight setups of five calibrations each, against motion capture;
Table II: their standard deviations; Table III: both of ten simulated setups. mm and deg.
"""

from __future__ import annotations

import csv
from functools import lru_cache
from importlib.resources import files

import numpy as np

QUANTITIES = ("x_mm", "y_mm", "z_mm", "alpha_deg", "beta_deg", "gamma_deg")
SETUPS = tuple(str(k) for k in range(1, 9))
OVERALL, AVERAGE = "Overall", "Average"  # last rows of Tables I and II
MAE, AVERAGE_SD = "MAE", "Average SD"  # rows of Table III
RECORDINGS = 5  # of a setup
FILES = {1: "jansen_table1_mae.csv", 2: "jansen_table2_sd.csv", 3: "jansen_table3_simulation.csv"}
NOTES = {
    1: "Printed row Overall is the mean of the eight setups but in gamma: printed 1.43, mean 1.485"
    " (1.480 to 1.490 with the rounding of the setups).",
    2: "Printed row Average is the mean of the eight setups; beta is cut, not rounded, or the"
    " setups' rounding hides it: printed 0.47, mean 0.476.",
    3: "Row Average SD equals Table II's printed row Average in x alone (8.9).",
}

# Factory values of 18 stations of the second generation, planes 0 and 1: the public ones of
# libsurvive-extras-data, of Bitcraze's data set and examples, and of a thread of libsurvive. The
# phase of plane 0 is zero by definition. Over stations, ogeemag correlates by 0.86 between planes.
FACTORY2_MEAN = {
    "phase": np.array([0.0, -0.0047]),
    "tilt": np.array([-0.0493, 0.0460]),
    "curve": np.array([0.03, 0.24]),
    "gibphase": np.array([1.83, 1.90]),
    "gibmag": np.array([-0.0032, -0.0027]),
    "ogeephase": np.array([1.57, 1.57]),
    "ogeemag": np.array([-0.11, -0.14]),
}
FACTORY2_SD = {
    "phase": np.array([0.0, 0.0026]),
    "tilt": np.array([0.0022, 0.0021]),
    "curve": np.array([0.16, 0.10]),
    "gibphase": np.array([0.71, 0.72]),
    "gibmag": np.array([0.0045, 0.0040]),
    "ogeephase": np.array([0.86, 0.82]),
    "ogeemag": np.array([0.29, 0.29]),
}
OGEEMAG_CORRELATION = 0.86  # of both planes of a station


@lru_cache(maxsize=3)
def _table(number: int) -> dict[str, dict[str, float]]:
    text = (files("mocap_metrology") / "reference" / FILES[number]).read_text(encoding="utf-8")
    return {
        line["setup"]: {name: float(line[name]) for name in QUANTITIES}
        for line in csv.DictReader(text.splitlines())
    }


def published_table(number: int) -> dict[str, dict[str, float]]:
    """J Table 1, 2 or 3: row as printed -> quantity -> value in mm or deg."""
    return {row: dict(values) for row, values in _table(number).items()}


def published_value(number: int, row: str, quantity: str) -> float | None:
    """One number of a table, None where the table has no such row."""
    return _table(number).get(row, {}).get(quantity)
