"""The figures of J that a calibration can draw again, by their numbers in the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.calibration.calibration_files import CalibrationFiles
from mocap_metrology.present.jansen.angles import angles_figure, clearest_point
from mocap_metrology.present.jansen.paths import (
    Superposed,
    paths_figure,
    slave_figure,
    superposition_figure,
)
from mocap_metrology.present.jansen.signal import signal_figure, signal_of

if TYPE_CHECKING:
    from mocap_metrology.present.plot.figure import Picture

NUMBERS = (3, 5, 6, 7, 8)
PAPER = "Jansen et al. 2019"
TITLES = {
    number: f"{PAPER}, Figure {number}: {shown}"
    for number, shown in {
        3: "signal of a photodiode over a measurement cycle",
        5: "azimuth and elevation of a photodiode",
        6: "board poses from both stations, both at the origin",
        7: "the slave's path superposed on the master's",
        8: "pose of the slave by T and R",
    }.items()
}


def jansen_figures(
    given: CalibrationFiles,
    pulses: Mapping[str, np.ndarray],
    estimator: str = "paper",
    optics: str = "ideal",
) -> dict[int, Picture]:
    """Figures 3, 5, 6, 7 and 8 of J from one calibration, by number.

    pulses: columns of pulses.parquet. Figures 6 to 8 show the Kabsch stage of this estimator and
    optics, as J's do; of the chosen pose where the calibration has it not.
    """
    kind = f"simulated stand-in (twin) {given.twin}" if given.twin else "measured"
    source = f"Source: calibration {given.name}, {kind}."
    shown = Superposed.of(given, estimator, optics)
    point = clearest_point(shown.paths, given.board)
    return {
        3: signal_figure(signal_of(pulses, given.sweeps), TITLES[3], source),
        5: angles_figure(point, TITLES[5], source),
        6: paths_figure(shown, TITLES[6], source),
        7: superposition_figure(shown, TITLES[7], source),
        8: slave_figure(shown, TITLES[8], source),
    }
