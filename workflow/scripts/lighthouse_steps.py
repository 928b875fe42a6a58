"""What the scripts of calibrations share: settings out of the configuration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mocap_metrology.lighthouse.assess.reference import Reference
    from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings
    from mocap_metrology.lighthouse.decode.chain import Decoded

Row = Mapping[str, Any]  # of the sheet, or a section of the configuration


def decoded(files: Mapping[str, str], row: Row, config: Row) -> Decoded:
    """The recording of a row, decoded; `files` are named dump, board and factory."""
    from mocap_metrology.lighthouse.decode.chain import Cleaning, decode

    return decode(
        files["dump"],
        row["format"],
        row["board"] if row["format"] == "libsurvive-rec" else files["board"],
        files.get("factory"),
        sample_rate_hz=config["sample_rate_hz"],
        active_level=config["active_level"],
        cleaning=Cleaning(
            gate_rad=1e-3 * config["gate_mrad"],
            gate_mad=config["gate_mad"],
            half_window=config["still_half_window"],
            n_sigma=config["still_n_sigma"],
        ),
    )


def calibration_settings(config: Row) -> CalibrationSettings:
    """`CalibrationSettings` of the section lighthouse."""
    import numpy as np

    from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings

    lasers = config["lasers_mm"]
    return CalibrationSettings(
        estimators=config["estimators"],
        optics=config["optics"],
        simplex_optics=config["simplex_optics"],
        reconstruction=config["reconstruction"],
        lm_interpolation=config["lm_interpolation"],
        lm_weights=config["lm_weights"],
        start_distance_m=config["start_distance_m"],
        lasers_m=None if lasers is None else 1e-3 * np.reshape(lasers, (2, 2, 3)),
        variant=config["variant"],
        pnp_method=config["pnp_method"],
    )


def reference_of(row: Row, path: str | None, mount: str | None) -> Reference | None:
    """The reference of a row: a pose file, or markers on both housings in a C3D file."""
    from mocap_metrology.lighthouse.assess import reference

    if path is None:
        return None
    if not path.lower().endswith(".c3d"):
        return reference.pose_reference(path)
    from pathlib import Path

    from mocap_metrology.io.read import read_recording

    labels = [row["reference_labels_master"], row["reference_labels_slave"]]
    known = reference.read_mount(mount)
    if not any(labels):  # a twin's: M1 ... on the master, S1 ... on the slave
        labels = [[label for label in known if label.startswith(first)] for first in "MS"]
    recording = read_recording([path], [*labels[0], *labels[1]], None)
    return reference.reference_from_markers(
        recording.position_mm, recording.labels, *labels, known, f"markers in {Path(path).name}"
    )


def truths_of(path: str | None) -> dict[str, Reference] | None:
    """What a twin was made with: between its housings, and between the origins of its optics."""
    if path is None:
        return None
    import json
    from pathlib import Path

    import numpy as np

    from mocap_metrology.lighthouse.assess.reference import optical, pose_reference

    lasers = json.loads(Path(path).read_text(encoding="utf-8"))["lasers_m"]
    housing = pose_reference(path)
    return {"housing": housing, "optical": optical(housing, np.array(lasers))}
