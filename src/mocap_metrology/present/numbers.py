"""Numbers and names of coefficients as people read them."""

from __future__ import annotations

import math
import re

from mocap_metrology.noise.fit.estimates import unit_key, unit_of
from mocap_metrology.present.text.sentence import duration_words

# What stands behind a coefficient that is not simply right, and what it means
MARKS = {"at_bound": "§", "not_converged": "¶", "misfit": "#"}
STATUS_SIGNS = (
    f"{MARKS['at_bound']} at the end of the range searched; {MARKS['not_converged']} not "
    f"converged; {MARKS['misfit']} of a model that does not describe the spectrum"
)
NINE_HOURS_S = 32400.0  # length of the recordings of S
DIGITS = 5  # significant ones of a number in a table to read
SMALL, LARGE = 1e-4, 1e6  # beyond these a number is written with a power of ten
LEAST_P = 1e-6  # a probability below this is as good as none
NOTHING = 1e-9  # a percentage, or a number published as 0, below this is an error of rounding
# What S Table 4 prints with four decimals
FOUR_DECIMALS = re.compile(r"(mu|sigma)_(1|2|L|e|A1|A2|B|C)_mm|rho_12")
PROBABILITY = re.compile(r"(.+_)?p")
SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
THIN_SPACE = "\N{NARROW NO-BREAK SPACE}"
SUBSCRIPT = str.maketrans("0123456789-", "₀₁₂₃₄₅₆₇₈₉₋")


def three_digits(value: float | None) -> str:
    """`0.225`, `5.86`, `2000`; `9.26e-07` beyond 0.001 ... 9999; empty for nothing."""
    if value is None or math.isnan(value):
        return ""
    value = float(f"{value:.2e}")
    if value == 0 or 1e-3 <= abs(value) < 1e4:
        decimals = 0 if value == 0 else max(2 - math.floor(math.log10(abs(value))), 0)
        return f"{value:.{decimals}f}"
    return f"{value:.2e}"


def readable(value: float, name: str = "", published: float | None = None) -> str:
    """A number of the column, or of the quantity, of that name, for a table to read.

    Five significant digits, three below 1e-3, with a power of ten below 1e-4 and from 1e6 on; four
    decimals, zeros included, of what S Table 4 prints so; three digits of a percentage;
    probabilities below 1e-6 as `< 1e-6`. published: the number it stands beside, as many decimals
    of which it has at least.
    """
    if math.isnan(value):
        return ""
    if math.isinf(value):
        return str(value)
    if PROBABILITY.fullmatch(name):
        return f"< {LEAST_P:.0e}".replace("e-0", "e-") if value < LEAST_P else f"{value:.3g}"
    least = name.endswith("_percent") or published == 0
    if value == 0 or (least and abs(value) < NOTHING):
        return "0"
    if name.endswith("_percent"):
        return f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"
    if FOUR_DECIMALS.fullmatch(name) and abs(value) >= 1e-3:
        return f"{value:.4f}"
    if not SMALL <= abs(value) < LARGE:
        return f"{value:.2e}" if value % 1 or abs(value) >= 1e15 else f"{value:.0f}"
    text = f"{value:.{DIGITS if abs(value) >= 1e-3 else 3}g}"
    decimals = len(as_printed(published or 0.0, name).partition(".")[2])
    more = decimals > len(text.partition(".")[2]) and abs(published or 0.0) >= SMALL
    return f"{value:.{decimals}f}" if more else text


def as_printed(value: float, name: str = "") -> str:
    """A published number with all its digits: three of a small coefficient, four decimals of what
    S Table 4 prints so."""
    if FOUR_DECIMALS.fullmatch(name):
        return f"{value:.4f}"
    short = f"{value:.2e}"
    return short if 0 < abs(value) < SMALL and float(short) == value else f"{value:.7g}"


def duration_text(seconds: float) -> str:
    """`nine hours`, `10 min`, `20 s`."""
    return "nine hours" if round(seconds) == NINE_HOURS_S else duration_words(seconds)


def typeset(value: float) -> str:
    """`three_digits` with a power of ten set as one: 9.26×10⁻⁷."""
    mantissa, e, exponent = three_digits(value).partition("e")
    return f"{mantissa}×{power_of_ten(int(exponent))}" if e else mantissa


def power_of_ten(exponent: int) -> str:
    """10⁻⁷ of -7."""
    return "10" + str(exponent).translate(SUPERSCRIPT)


def tick_text(value: float) -> str:
    """As short as it can be, with a minus sign and not a hyphen."""
    return f"{value + 0.0:.10g}".replace("-", "−")


def number(value: float, digits: int = 0, sign: bool = False) -> str:
    """13 195 or −5.20: thousands set apart, a real minus sign."""
    text = f"{value:{'+' if sign else ''},.{digits}f}"
    return text.replace(",", THIN_SPACE).replace("-", "−")


def symbol(parameter: str) -> str:
    """h₋₂ of `h_-2`; q_c, T_c, A_s, f₀."""
    if parameter.startswith("h_"):
        return "h" + parameter[2:].translate(SUBSCRIPT)
    return "f₀" if parameter == "f_0" else unit_key(parameter)


def unit(parameter: str) -> str:
    """mm²/Hz² of `h_1`."""
    text = unit_of(parameter).replace("/s^0.5", "/√s")
    return text.replace("^2", "²").replace("^3", "³")


def with_interval(value: float | None, lower: float | None, upper: float | None) -> str:
    """`9.26 (9.25…9.27)e-07`: value and interval over one power of ten; what is unknown is left
    out. Three digits of the value, or as many as the interval's first."""
    if value is None or math.isnan(value):
        return ""
    ends = [float(end) for end in (lower, upper) if end is not None and end == end]
    if len(ends) < 2 or value == 0:
        return three_digits(value)
    _, e, exponent = three_digits(value).partition("e")
    scale = 10.0 ** int(exponent) if e else 1.0
    wide = max(ends[1] - ends[0], 0.0) / 2
    digit = math.floor(math.log10(max(wide / scale, 1e-9)))
    decimals = min(max(len(three_digits(value / scale).partition(".")[2]), -digit), 9)
    shown, low, high = (
        f"{v / scale:.{decimals}f}" if abs(v / scale) < 1e4 else f"{v / scale:.2e}"
        for v in (value, *ends)
    )
    return f"{shown} ({low}…{high}){e}{exponent}"
