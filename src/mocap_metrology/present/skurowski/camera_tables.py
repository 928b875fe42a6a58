"""S Tables 1 to 4 to read: power laws, types of cameras (cited: nothing there can be regenerated),
subsets of cameras, and the Gaussian model, published beside regenerated."""

from __future__ import annotations

import math

from mocap_metrology.noise.twins.published import (
    published_gaussian,
    published_row,
)
from mocap_metrology.papers.gaussian_table import REPEATS, related
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text.numbers import significant

TABLE_1_SHOWN = (
    *("noise", "alpha", "scale", "formula", "quantity", "tau_s", "f_h_hz", "published"),
    *("regenerated", "standard_error", "expected", "deviation_percent", "errors_off", "method"),
    *("source", "note"),
)
CHANCE = (
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
TABLE_4_CAPTION = (
    f"{CHANCE} "
    "Along x, in mm (sigma_12 in mm\u00b2). Vantage is the subset of nine, without the failing "
    "camera. The moments of a twin vary by chance because random walk dominates them, and more "
    "so the longer it is. rho_12 results from the spectra of x1, x2 and L, except in row All: no "
    "coefficients were printed for all thirty cameras, and its twin is T40-10 scaled to this "
    "row, rho_12 included."
)
TABLE_4_SHOWN = (
    *("camera_type", "quantity", "published", "regenerated", "source", "standard_error"),
    *("lower_5", "median", "upper_95", "inside", "nine_hours_lower_5", "nine_hours_upper_95"),
    *("published_inside", "check", "residual", "published_residual", "note"),
)
BY_CHANCE = "regenerated outside: by chance, as for one number in ten of a twin"
OTHER_VALUE = "the printed coefficients give a different value"
WALK = "h_-2 of L is printed as {L}, of x1 and x2 together as {both}, which {word}correlates them"
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
SCALED = "no coefficients of all thirty cameras were printed: T40-10 scaled to this row"
NOTES: dict[str | tuple[str, str], str] = {  # by quantity, or by camera type and quantity
    "sigma_12_mm2": "printed with four decimals: sigma_C from it would be {from_covariance:.4f}, "
    "from rho_12 {from_rho:.4f}",
    "sigma_B_mm": "S prints the formula with sigma_1 twice",
    "mu_L_mm": "printed {across:.4f} above mu_e: the markers are not quite along x",
    **dict.fromkeys([("All", name) for name in ("sigma_1_mm", "sigma_2_mm", "rho_12")], SCALED),
    ("Vantage", "sigma_1_mm"): "the printed row agrees with nine cameras, not ten",
}


def note_of_table_4(row: Row) -> str:
    """Why a number of `papers.gaussian_table.table_4` cannot agree, or is less than it seems."""
    kind, quantity = row["camera_type"], row["quantity"]
    published = published_gaussian(kind)
    s_1, s_2 = published["sigma_1_mm"], published["sigma_2_mm"]
    numbers = {
        "from_covariance": math.sqrt(s_1**2 + s_2**2 - 2 * published["sigma_12_mm2"]),
        "from_rho": related("sigma_C_mm", published),
        "across": published["mu_L_mm"] - published["mu_e_mm"],
    }
    notes = [BY_CHANCE] if row["inside"] is False else []
    if row["published_inside"] is False:
        notes.append(f"published outside: {_reason(kind, quantity)}")
    notes += [NOTES[key].format(**numbers) for key in (quantity, (kind, quantity)) if key in NOTES]
    return "; ".join(notes)


def _reason(kind: str, quantity: str) -> str:
    """Why a printed number lies outside of what the printed coefficients allow."""
    if kind == "T40" and quantity in OF_T40:
        return OF_T40[quantity] + OF_T40_X1
    if quantity not in ("sigma_12_mm2", "rho_12"):
        return OTHER_VALUE
    models = published_row(kind, 9 if kind == "Vantage" else 10)
    walk = {s: models[s].coefficients().get("h_-2", 0.0) for s in ("x1", "x2", "L")}
    both = walk["x1"] + walk["x2"]
    word = "de" if walk["L"] > both else ""
    return WALK.format(L=significant(walk["L"]), both=significant(both), word=word)
