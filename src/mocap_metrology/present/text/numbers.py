"""How numbers, durations, lengths, shares and names of coefficients are written."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable

import numpy as np

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
MINUTES_S = 120.0  # times from which minutes are said
MINUTES_FROM_S = 180.0  # moments are in s up to here, as the axis of the whole recording
FAST_MM_H = 10_000.0
SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
THIN_SPACE = "\N{NARROW NO-BREAK SPACE}"


def three_digits(value: float | None) -> str:
    """`0.225`, `5.86`, `2000`; `9.26e-07` beyond 0.001 ... 9999; empty for nothing."""
    if value is None or math.isnan(value):
        return ""
    rounded = float(f"{value:.2e}")
    return three_fixed(value) if rounded == 0 or 1e-3 <= abs(rounded) < 1e4 else f"{value:.2e}"


def three_fixed(value: float) -> str:
    """Three digits, zeros too, so that a value and its interval have as many: 0.0260, 693."""
    rounded = float(f"{value:.3g}")
    if not math.isfinite(rounded) or rounded == 0:
        return f"{value:g}"
    return f"{rounded:.{max(2 - math.floor(math.log10(abs(rounded))), 0)}f}"


def three(value: float, sign: str = "") -> str:
    """Three digits without a power of ten above 0.0001: `0.246`, `2020`; sign: `+` or nothing.

    `%.3g` alone makes 2.02e+03 of 2020.
    """
    rounded = float(f"{value:.3g}")
    return f"{rounded:{sign}.0f}" if abs(rounded) >= 1000 else f"{rounded:{sign}g}"


def two(value: float) -> str:
    """The same with two digits."""
    return three(float(f"{value:.2g}"))


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


def duration_words(seconds: float) -> str:
    """`an hour`, `10 min`, `5.2 s`."""
    if abs(seconds / 3600 - 1) < 0.005:
        return "an hour"
    if seconds >= 5400:
        return f"{seconds / 3600:.3g} h"
    return f"{seconds / 60:.3g} min" if seconds >= 120 else f"{seconds:.3g} s"


def minutes_words(seconds: float) -> str:
    """`90 s`, `18 minutes`, `2.5 h`."""
    if seconds < MINUTES_S:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} minutes" if seconds < 2 * 3600 else f"{three(seconds / 3600)} h"


def time_words(seconds: float) -> str:
    """150.2 s, or 2:30:12.0 beyond ten minutes."""
    seconds = round(seconds, 1)
    if seconds < 600:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(seconds, 60)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours}:{minutes:02d}:{rest:04.1f}"


def moment(seconds: float) -> str:
    """`98.5 s`, `4 min 58.5 s`, `4 h 29 min 58.5 s`."""
    tenths = round(10 * seconds)
    if tenths < 10 * MINUTES_FROM_S:
        return f"{tenths / 10:.1f} s"
    minutes, rest = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    return f"{f'{hours} h ' if hours else ''}{minutes} min {rest / 10:.1f} s"


def length(mm: float) -> str:
    """Three digits, in m from a metre on."""
    return f"{three(mm / 1000)} m" if mm >= 1000 else f"{three(mm)} mm"


def mm(value: float) -> str:
    """Three digits, in µm below 0.1 mm."""
    if value != value:
        return "an unknown length"
    return f"{three(1000 * value)} µm" if abs(value) < 0.1 else f"{three(value)} mm"


def speed(mm_per_h: float) -> str:
    """`+360 mm/h`, and `+928 m/h` from 10 m/h on: of what moves, not of what wanders."""
    if abs(mm_per_h) >= FAST_MM_H:
        return f"{three(mm_per_h / 1000, '+')} m/h"
    return f"{three(mm_per_h, '+')} mm/h"


def percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-5 else "less than 0.001 %"


def signed(share: float) -> str:
    return f"{100 * share:+.2g} %"


def span(values: Iterable[float], shown: Callable[[float], str]) -> str:
    """`3 %` or `3 % to 5 %`."""
    known = np.asarray(list(values), float)
    low, high = shown(float(known.min())), shown(float(known.max()))
    return low if low == high else f"{low} to {high}"


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
