"""Figures of a calibration, out of the tables of its steps."""

from __future__ import annotations

from pathlib import Path

from mocap_metrology.calibration.tables import TABLES
from mocap_metrology.common.files import read_table
from mocap_metrology.lighthouse.assess.calibration_files import read_calibration
from mocap_metrology.present.calibration.calibration_figure import calibration_figure
from mocap_metrology.present.calibration.track_figure import track_figure
from mocap_metrology.present.plot.figure import save


def draw(folder: Path, name: str, twin: str | None) -> None:
    """calibration: stations, paths, residuals and pose; track: the tracked board, beside the noise
    of the angles where it is known."""
    files = {key: str(folder / file) for key, file in TABLES.items()}
    save(calibration_figure(read_calibration(files, name, twin)), folder / "calibration")
    angles = folder / TABLES["allan"]
    noise = read_table(angles) if angles.exists() else ({}, {"rotors": []})
    save(track_figure(name, twin, *read_table(folder / TABLES["track"]), *noise), folder / "track")
