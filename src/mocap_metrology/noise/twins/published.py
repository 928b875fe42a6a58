"""Published numbers of Skurowski & Pawlyta 2019 (S), read from the package's `reference/` folder.

`printed_row` gives Tables A1-A3 as printed; `published_row` the same as noise models, with what
cannot be used corrected or omitted; `published_notes` lists the changes. mm and s.
"""

from __future__ import annotations

import csv
from functools import lru_cache
from importlib.resources import files

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.model.components import ALPHAS, NoiseModel

SERIES = ("x1", "y1", "z1", "x2", "y2", "z2", "L")
FRAME_RATE_HZ = 120.0
COEFFICIENTS = (
    *(f"h_{alpha}" for alpha in ALPHAS),
    *(f"{name}{k}" for k in (1, 2, 3, 4) for name in ("q_c", "T_c")),
    *("A_s", "f_0"),
)
# (camera type, cameras, series, coefficient): value used instead of the printed one, and why
CORRECTED = {
    ("Bonita", 2, "y1", "q_c2"): (
        3.84e-02,
        "printed 3084e-02, read as 3.84e-02: the row above has 3.97e-02, and 30.84 mm/s^0.5 "
        "would be a component of 25 mm rms",
    )
}


@lru_cache(maxsize=8)
def _table(name: str) -> tuple[dict[str, str], ...]:
    text = (files("mocap_metrology") / "reference" / name).read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))


@lru_cache(maxsize=1)
def _coefficients() -> dict[tuple[str, int], dict[str, dict[str, float]]]:
    rows: dict[tuple[str, int], dict[str, dict[str, float]]] = {}
    for line in _table("noise_coefficients_wide.csv"):
        values = {name: float(line[name]) for name in COEFFICIENTS if line[name]}
        key = line["camera_type"], int(line["n_cameras"])
        rows.setdefault(key, {})[line["series"]] = values
    return rows


def published_keys() -> list[tuple[str, int]]:
    """(camera type, number of cameras) of the 22 rows of Tables A1-A3; 10 is the printed `All`."""
    return list(_coefficients())


def printed_row(camera_type: str, n_cameras: int) -> dict[str, dict[str, float]]:
    """Coefficients of every series exactly as printed, misprints included."""
    row = _coefficients().get((camera_type, n_cameras))
    if row is None:
        known = sorted(n for kind, n in _coefficients() if kind == camera_type)
        expected = f"{camera_type} with {known} cameras" if known else "T40, Bonita or Vantage"
        raise Refusal(
            f"no published noise coefficients for {camera_type} with {n_cameras} cameras, "
            f"expected {expected}"
        )
    return {series: dict(row[series]) for series in SERIES}


def published_row(camera_type: str, n_cameras: int) -> dict[str, NoiseModel]:
    """Noise model of every series (S Tables A1-A3), changed as `published_notes` lists."""
    row = printed_row(camera_type, n_cameras)
    for (*printed, series, name), (value, _) in CORRECTED.items():
        if printed == [camera_type, n_cameras]:
            row[series][name] = value
    for values in row.values():
        if _beyond_nyquist(values):
            del values["A_s"], values["f_0"]
    return {series: NoiseModel.from_coefficients(values) for series, values in row.items()}


def published_notes(camera_type: str, n_cameras: int) -> list[str]:
    """What `published_row` changed, and what to beware of: one line each."""
    notes = []
    for series, values in printed_row(camera_type, n_cameras).items():
        for (*row, name), (_, reason) in CORRECTED.items():
            if row == [camera_type, n_cameras, series]:
                notes.append(f"{series} {name}: {reason}")
        if _beyond_nyquist(values):
            notes.append(
                f"{series} A_s, f_0: omitted; f_0 = {values['f_0']:.3g} Hz is above half of the "
                f"frame rate ({FRAME_RATE_HZ / 2:g} Hz), so the pair is not a tone in the "
                "recording"
            )
        notes += [
            f"{series} {name}: {T_c:.3g} s is shorter than a frame; retained, but such a "
            "component of a sampled recording is white noise"
            for name, T_c in values.items()
            if name.startswith("T_c") and T_c < 1 / FRAME_RATE_HZ
        ]
    if (camera_type, n_cameras) == ("Vantage", 10):
        notes.append("all series: the row includes the camera that was failing (S section 3.5)")
    return notes


def _beyond_nyquist(values: dict[str, float]) -> bool:
    return values.get("f_0", 0.0) > FRAME_RATE_HZ / 2


def published_gaussian(camera_type: str) -> dict[str, float]:
    """S Table 4: `mu_1_mm`, `sigma_1_mm`, ..., `rho_12`, ... of T40, Bonita, Vantage or All."""
    for line in _table("gaussian_model_table4.csv"):
        if line["camera_type"] == camera_type:
            return {k: float(v) for k, v in line.items() if k not in ("camera_type", "note")}
    raise Refusal(f"no row {camera_type!r} in Table 4, expected T40, Bonita, Vantage or All")


def published_subsets() -> dict[tuple[str, int], tuple[int, ...]]:
    """S Table 3: camera ids of every (camera type, number of cameras), in order of addition.

    Vantage 10 is deduced, not printed: id 6 is in no list, so it is assumed to be the failing
    camera."""
    return {
        (line["camera_type"], int(line["n_cameras"])): tuple(
            map(int, line["camera_ids"].split(";"))
        )
        for line in _table("camera_subsets_table3.csv")
    }


def published_power_laws() -> list[dict[str, str]]:
    """S Table 1: `noise_name`, `alpha`, `mu`, `formula`, `scale_name` (A ... E), `scale_formula`
    (signs and brackets restored), `printed_line`, `note`."""
    return [dict(line) for line in _table("powerlaw_table1.csv")]


def published_cameras() -> list[dict[str, str]]:
    """S Table 2: `spec`, `unit`, the values of `T40`, `Bonita` and `Vantage`, how sure their
    reading is (`ambiguity`: none, resolved, open), `printed_line`, `note`."""
    return [dict(line) for line in _table("camera_specs_table2.csv")]
