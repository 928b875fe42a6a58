"""S Table 4, with what chance allows: bands of the twins' coefficients, checks, reasons."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.hampel import white_level_kept
from mocap_metrology.noise.gaussian.moments import QUANTITIES, SLOW_SAMPLES, Cleaning, pair_moments
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, published_row
from mocap_metrology.noise.twins.simulate import stream
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text.numbers import NINE_HOURS_S, significant

REPEATS = 200
LEVELS = (0.05, 0.5, 0.95)
MU_ERRORS = 3.0
TOLERANCE_MM = 1e-4
ROUNDING_MM = 1.5e-4  # of three numbers printed to four decimals
MEANS = ("mu_1_mm", "mu_2_mm", "mu_L_mm", "mu_e_mm")
UNITS = {"rho_12": "rho_12", "sigma_12": "sigma_12_mm2"}
RELATIONS = {
    "mu_e_mm": "|mu_2 - mu_1|",
    "sigma_12_mm2": "rho_12 sigma_1 sigma_2",
    "sigma_A1_mm": "sqrt(2) sigma_1",
    "sigma_A2_mm": "sqrt(2) sigma_2",
    "sigma_B_mm": "sqrt(sigma_1^2 + sigma_2^2)",
    "sigma_C_mm": "sqrt(sigma_1^2 + sigma_2^2 - 2 rho_12 sigma_1 sigma_2)",
}
CAPTION = (
    "Random walk and slow correlated noise make the moments of one recording vary by chance. "
    f"Each is compared with {REPEATS} realisations of the twin's coefficients after the outlier "
    "filter (slow parts are simulated, fast ones enter by their stationary variance). lower_5, "
    "median, upper_95: for the length of these recordings; nine_hours_: for that of the paper. "
    "inside: within 5 ... 95 %, where one number in ten lies outside by chance; for a mean, "
    "within three standard errors. The standard error refers to the first frame, where the twin "
    "is at the published mean: a random walk has no other reference. check, residual: a relation "
    "between the numbers of the row, and its residual; printed numbers have up to 0.00015 mm of "
    "rounding."
)
SHOWN = (
    *("camera_type", "quantity", "published", "regenerated", "source", "standard_error"),
    *("lower_5", "median", "upper_95", "inside", "nine_hours_lower_5", "nine_hours_upper_95"),
    *("published_inside", "check", "residual", "published_residual", "note"),
)


@dataclass(frozen=True)
class Chance:
    """Quantiles and root mean square of every quantity over realisations; means are offsets from
    the first frame."""

    levels: dict[str, tuple[float, ...]]
    rms: dict[str, float]


def cleaning_of(hampel: Record) -> Cleaning:
    """What the configured filter (`half_window_s`, `n_sigma`, `action`) leaves at 120 Hz."""
    half_window_s = float(hampel["half_window_s"])
    half_window = round(half_window_s * FRAME_RATE_HZ)
    _, kept = white_level_kept(float(hampel["n_sigma"]), half_window, hampel["action"])
    return Cleaning(kept if math.isfinite(kept) else 1.0, 0.5 / half_window_s)


def realisations(
    twin: Twin, repeats: int, cleaning: Cleaning | None = None, slow_samples: int = SLOW_SAMPLES
) -> dict[str, np.ndarray]:
    """(repeats,) of every quantity of Table 4 under its column's name; the twin's seed, a stream of
    its own, or of its take where twins share their slow noise, so that the k-th realisations of
    such twins belong together."""
    rng = stream(twin.slow.take if twin.slow else twin.name, twin.seed, "moments")
    moments = pair_moments(twin, repeats, rng, cleaning, slow_samples)
    return {UNITS.get(name, f"{name}_mm"): moments[name] for name in QUANTITIES}


def chance(
    twin: Twin, duration_s: float, cleaning: Cleaning | None = None, repeats: int = REPEATS
) -> Chance:
    """What `repeats` recordings of that length show."""
    named = realisations(replace(twin, duration_s=duration_s), repeats, cleaning)
    return Chance(
        {name: tuple(np.quantile(v, LEVELS).tolist()) for name, v in named.items()},
        {name: float(np.sqrt(np.mean(v**2))) for name, v in named.items()},
    )


def with_chance(
    rows: Sequence[Row],
    twins: Mapping[str, Twin],
    cleaning: Cleaning | None = None,
    repeats: int = REPEATS,
) -> list[Row]:
    """The rows of `subset_tables.table_4` with bands, checks and notes; bands only where a twin
    corresponds to the row (`twins`: recording -> twin at the length it was simulated for)."""
    made: list[Row] = []
    for kind in dict.fromkeys(row["camera_type"] for row in rows):
        own = [row for row in rows if row["camera_type"] == kind]
        twin = twins.get(own[0]["recording"])
        bands = None
        if twin is not None:
            here = chance(twin, twin.duration_s, cleaning, repeats)
            same = twin.duration_s == NINE_HOURS_S
            bands = here, here if same else chance(twin, NINE_HOURS_S, cleaning, repeats)
        published = {row["quantity"]: row["published"] for row in own}
        found = {row["quantity"]: row["regenerated"] for row in own}
        for row in own:
            whole = row | _band(row, bands) | _check(row["quantity"], published, found)
            made.append(whole | {"note": _note(whole, published)})
    return made


def _band(row: Row, bands: tuple[Chance, Chance] | None) -> Row:
    """Band columns of one quantity; empty without a twin."""
    names = (
        *("standard_error", "lower_5", "median", "upper_95", "inside"),
        *("nine_hours_lower_5", "nine_hours_median", "nine_hours_upper_95", "published_inside"),
    )
    if bands is None:
        return dict.fromkeys(names)
    quantity, published, found = row["quantity"], row["published"], row["regenerated"]
    mean = quantity in MEANS
    start = published if mean else 0.0
    here, nine = (tuple(start + v for v in c.levels[quantity]) for c in bands)
    error = bands[0].rms[quantity] if mean else None
    if found is None:
        inside = None
    elif error is not None:
        inside = abs(found - published) <= MU_ERRORS * error
    else:
        inside = here[0] <= found <= here[2]
    of_published = None if mean else nine[0] <= published <= nine[2]
    values = (error, *here, inside, *nine, of_published)
    return dict(zip(names, values, strict=True))


def related(quantity: str, row: Mapping[str, float]) -> float:
    """What the other numbers of a row of Table 4 make of one of `RELATIONS` (S 2.2)."""
    s_1, s_2 = row["sigma_1_mm"], row["sigma_2_mm"]
    common = row["rho_12"] * s_1 * s_2
    return {
        "mu_e_mm": abs(row["mu_2_mm"] - row["mu_1_mm"]),
        "sigma_12_mm2": common,
        "sigma_A1_mm": math.sqrt(2) * s_1,
        "sigma_A2_mm": math.sqrt(2) * s_2,
        "sigma_B_mm": math.hypot(s_1, s_2),
        "sigma_C_mm": math.sqrt(max(s_1**2 + s_2**2 - 2 * common, 0.0)),
    }[quantity]


def _check(quantity: str, published: Mapping[str, float], found: Mapping[str, float]) -> Row:
    """Residuals of the relation, of the regenerated and of the printed numbers."""
    row: Row = dict.fromkeys(
        ("check", "residual", "consistent", "published_residual", "published_consistent")
    )
    if quantity not in RELATIONS:
        return row
    row["check"] = RELATIONS[quantity]
    row["published_residual"] = published[quantity] - related(quantity, published)
    row["published_consistent"] = abs(row["published_residual"]) <= ROUNDING_MM
    if all(value is not None for value in found.values()):
        row["residual"] = found[quantity] - related(quantity, found)
        row["consistent"] = abs(row["residual"]) <= TOLERANCE_MM
    return row


COUNTS = {"T40": 10, "Bonita": 10, "Vantage": 9}
ALL = "no coefficients of all thirty cameras were printed: T40-10 scaled to this row"
OF_T40_X1 = (
    "the printed coefficients of x1 are too small for it: h_-2 is 1.55×10⁻¹⁰ for ten cameras "
    "and 2.99×10⁻⁹ for eight, and the latter agrees"
)
OF_T40 = {
    "sigma_1_mm": "",
    "sigma_12_mm2": "contains sigma_1: ",
    "rho_12": "higher for a wider x1 with the same L: ",
    "sigma_A1_mm": "sqrt(2) sigma_1: ",
    "sigma_B_mm": "contains sigma_1: ",
}


def _reason(kind: str, quantity: str) -> str:
    """Why a printed number lies outside of what the printed coefficients allow."""
    if kind == "T40" and quantity in OF_T40:
        return OF_T40[quantity] + OF_T40_X1
    if quantity in ("sigma_12_mm2", "rho_12") and kind in COUNTS:
        models = published_row(kind, COUNTS[kind])
        walk = {s: models[s].coefficients().get("h_-2", 0.0) for s in ("x1", "x2", "L")}
        return (
            f"h_-2 of L is printed as {significant(walk['L'])}, of x1 and x2 together "
            f"as {significant(walk['x1'] + walk['x2'])}, which "
            + ("decorrelates them" if walk["L"] > walk["x1"] + walk["x2"] else "correlates them")
        )
    return "the printed coefficients give a different value"


def _note(row: Row, published: Mapping[str, float]) -> str:
    """Why a number cannot agree, or is less than it seems."""
    kind, quantity = row["camera_type"], row["quantity"]
    notes = []
    if row["inside"] is False:
        notes.append("regenerated outside: by chance, as for one number in ten of a twin")
    if row["published_inside"] is False:
        notes.append(f"published outside: {_reason(kind, quantity)}")
    if quantity == "sigma_12_mm2":
        c = published["sigma_1_mm"] ** 2 + published["sigma_2_mm"] ** 2 - 2 * published[quantity]
        notes.append(
            f"printed with four decimals: sigma_C from it would be {math.sqrt(c):.4f}, from rho_12 "
            f"{related('sigma_C_mm', published):.4f}"
        )
    if quantity == "sigma_B_mm":
        notes.append("S prints the formula with sigma_1 twice")
    if quantity == "mu_L_mm":
        across = published[quantity] - published["mu_e_mm"]
        notes.append(f"printed {across:.4f} above mu_e: the markers are not quite along x")
    if kind == "All" and quantity in ("sigma_1_mm", "sigma_2_mm", "rho_12"):
        notes.append(ALL)
    if kind == "Vantage" and quantity == "sigma_1_mm":
        notes.append("the printed row agrees with nine cameras, not ten")
    return "; ".join(notes)


def summary(rows: Sequence[Row]) -> str:
    """How many numbers are inside of what chance allows, regenerated and published."""
    counts = []
    for column in ("inside", "published_inside", "consistent"):
        known = [row[column] for row in rows if row[column] is not None]
        counts.append(f"{column} {sum(map(bool, known))} of {len(known)}")
    return "; ".join(counts)
