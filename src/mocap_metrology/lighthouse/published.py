"""Published numbers of Jansen et al. 2019 (J), read from the package's `reference/` folder.

Table I: mean absolute error of eight setups of five calibrations each, against motion capture;
Table II: their standard deviations; Table III: both of ten simulated setups. mm and deg.
"""

from __future__ import annotations

import csv
from functools import lru_cache
from importlib.resources import files

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
