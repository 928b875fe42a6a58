"""Noise of the angles of boards at rest: a row a rotor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.present.tables import Record, Row, markdown

CAPTION = (
    "Allan deviation of the angles of boards at rest, 30 sweeps a second and rotor. common: of the"
    " mean over the diodes of a sweep, without what the diodes' own noise adds to it; independent:"
    " of single diodes beyond it. At one sweep, with 68.3 % intervals, and at its minimum over the"
    " averaging time τ. exponent: of the power spectral density at one sweep (0 white, -1 flicker,"
    " -2 random walk); h_0: one-sided density of white noise, where it is white. sd: of one diode."
    " step: of the clock that times the pulses; a spread below it is mostly rounding."
)
PARTS = ("common", "independent")
OF_PART = (
    *("adev_1_urad", "adev_1_lower_urad", "adev_1_upper_urad", "exponent", "adev_min_urad"),
    *("tau_min_s", "h_0_urad2_hz"),
)
HEAD = (
    *("calibration", "setup", "source", "rotor", "n_diodes", "n_sweeps", "sd_urad"),
    *(f"{part}_{name}" for part in PARTS for name in OF_PART),
    *("step_urad", "below_step", "independent_below_step"),
)


def angle_rows(named: Record, allan: Mapping[str, np.ndarray], origin: Record) -> list[Row]:
    """Rows of one calibration, none of a board that moved; named: `calibration`, `setup`, `source`;
    allan, origin: of its allan.parquet."""
    rows = []
    for rotor in origin["rotors"]:
        row: Row = {name: named[name] for name in ("calibration", "setup", "source")}
        row |= {"rotor": rotor["rotor"].replace("_", ", ")}
        row |= {"n_diodes": len(rotor["diodes"]), "n_sweeps": rotor["sweeps"]}
        row["sd_urad"] = 1e6 * rotor["sd_rad"]
        for part in PARTS:
            row |= {f"{part}_{k}": v for k, v in _part(allan, f"{rotor['rotor']}_{part}").items()}
        step = rotor["step_rad"]
        row["step_urad"] = None if step is None else 1e6 * step
        row |= {name: rotor[name] for name in ("below_step", "independent_below_step")}
        rows.append(row)
    return rows


def _part(allan: Mapping[str, np.ndarray], series: str) -> Row:
    own = (allan["series"] == series) & (allan["estimator"] == "oadev")
    if not own.any():
        return dict.fromkeys(OF_PART)
    tau, adev, alpha = (allan[name][own] for name in ("tau_s", "adev_rad", "alpha"))
    best = int(adev.argmin())
    values: Row = dict.fromkeys(OF_PART)
    values |= {"adev_min_urad": 1e6 * float(adev[best]), "tau_min_s": float(tau[best])}
    if allan["m"][own][0] == 1:
        for name in ("adev_1", "adev_1_lower", "adev_1_upper"):
            column = name.replace("_1", "") + "_rad"
            values[f"{name}_urad"] = 1e6 * float(allan[column][own][0])
        values["exponent"] = int(alpha[0])
        if alpha[0] == 0:  # AVAR = h_0 / (2 tau)
            values["h_0_urad2_hz"] = 2e12 * float(tau[0] * adev[0] ** 2)
    return values


def angle_markdown(rows: Sequence[Row], title: str, note: str) -> str:
    """Markdown of some `angle_rows`."""
    if not rows:
        return f"# {title}\n\nNo calibration of a board at rest.\n"
    return markdown(list(rows), title, f"{CAPTION} {note}".strip())
