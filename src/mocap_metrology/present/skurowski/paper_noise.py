"""What Figures 6 and 14-17 of S show: titles, and which recordings and series stand in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mocap_metrology.present.skurowski.subset_tables import TABLE_4, standing_for

PAPER = "Skurowski & Pawlyta 2019"
TITLES = {
    6: f"{PAPER}, Figure 6: weighted and ordinary least squares",
    14: f"{PAPER}, Figure 14: colour noise coefficients, logarithmic",
    15: f"{PAPER}, Figure 15: colour noise coefficients, linear",
    16: f"{PAPER}, Figure 16: correlated noise",
    17: f"{PAPER}, Figure 17: a periodic disturbance, in spectra of z1",
}
LINE_HZ = 14.4  # S's "15 Hz": eight rows of Tables A1-A3 have 13.7 to 14.4 Hz
NOTE_17 = (
    "z1 by the largest set of each camera type, its number of cameras in brackets. S reports the "
    "line for T40 and Vantage, negligibly small for Vantage; Tables A1-A3 print its amplitude for "
    "T40 alone, so a twin of Vantage or Bonita has none."
)
SERIES = "z1"  # of Figures 6 and 17; S names none for 6, this one has a line and three bumps


def largest(recordings: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Label (camera type, cameras) and recording of the largest sound subset of each type."""
    found = {}
    for kind in ("T40", "Bonita", "Vantage"):
        name = standing_for(recordings, kind, TABLE_4[kind])
        if name is not None:
            found[f"{kind} ({TABLE_4[kind]})"] = name
    return found


def of_regression(recordings: Mapping[str, Mapping[str, Any]]) -> str:
    """The recording of Figure 6: all T40 cameras, or else the first there is."""
    return standing_for(recordings, "T40", 10) or next(iter(recordings))
