"""Names and units of noise coefficients as people read them."""

from __future__ import annotations

from mocap_metrology.noise.fit.estimates import unit_key, unit_of

SUBSCRIPT = str.maketrans("0123456789-", "₀₁₂₃₄₅₆₇₈₉₋")


def symbol(parameter: str) -> str:
    """h₋₂ of `h_-2`; q_c, T_c, A_s, f₀."""
    if parameter.startswith("h_"):
        return "h" + parameter[2:].translate(SUBSCRIPT)
    return "f₀" if parameter == "f_0" else unit_key(parameter)


def mathtext(parameter: str) -> str:
    """The same for a figure: $h_{-2}$, $q_c$."""
    kind, _, index = unit_key(parameter).partition("_")
    return f"${kind}_{{{index}}}$" if index else kind


def unit(parameter: str) -> str:
    """mm²/Hz² of `h_1`."""
    text = unit_of(parameter).replace("/s^0.5", "/√s")
    return text.replace("^2", "²").replace("^3", "³")
