"""How numbers, sizes with units, uncertainties and times are written, one way for each.

Of what has an uncertainty: two digits of it and the value to the same place. Of anything else:
three digits, or the number requested. Units have prefixes, value and uncertainty the same one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np

# Marks behind coefficients that are not plain estimates, and their meaning
MARKS = {"at_bound": "§", "not_converged": "¶", "misfit": "#"}
STATUS_SIGNS = (
    f"{MARKS['at_bound']} at the end of the range searched; {MARKS['not_converged']} not "
    f"converged; {MARKS['misfit']} of a model that does not describe the spectrum"
)
NINE_HOURS_S = 32400.0  # length of the recordings of S
MINUTES_FROM_S = 180.0  # moments are in s up to here, as the axis of the whole recording
SMALL, LARGE = -3, 6  # powers of ten from which on a number is written with its power
PLACES = 12  # decimals at most
ARITHMETIC = {"mm": 1e-9, "mm/h": 1e-9, "°": 1e-9}  # sizes below this are errors of arithmetic
RESOLUTION_MM, RESOLUTION_DEG = 1e-3, 1e-5  # of poses; what differs by less is the same
FAR = 1e4  # an end of an interval beyond this, in the unit of the value, has no decimals
SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
THIN_SPACE, MINUS = "\N{NARROW NO-BREAK SPACE}", "\N{MINUS SIGN}"
# From which absolute value on, in the unit itself, a unit is written with which prefix
PREFIXED: dict[str, tuple[tuple[float, float, str], ...]] = {
    "mm": ((1e3, 1e-3, "m"), (0.1, 1, "mm"), (1e-4, 1e3, "µm"), (0, 1e6, "nm")),
    "mm/h": ((1e3, 1e-3, "m/h"), (0.1, 1, "mm/h"), (0, 1e3, "µm/h")),
    "Hz": ((1e3, 1e-3, "kHz"), (1e-3, 1, "Hz"), (0, 1e6, "µHz")),
    "s": ((0.1, 1, "s"), (1e-4, 1e3, "ms"), (0, 1e6, "µs")),
}


def significant(value: float | None, digits: int = 3, least: float = 1e-3) -> str:
    """So many digits, zeros too: 0.0260, 693, nothing for none; with a power of ten below `least`
    and from a million on: 9.26×10⁻⁷."""
    if value is None or math.isnan(value):
        return ""
    if value == 0 or math.isinf(value):
        return f"{value:g}".replace("-", MINUS)
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if math.log10(least) <= power < LARGE:
        text = f"{float(f'{mantissa}e{exponent}'):.{max(digits - 1 - power, 0)}f}"
        return text.replace("-", MINUS)
    return f"{mantissa.replace('-', MINUS)}×{power_of_ten(power)}"


def _without_zeros(value: float, digits: int = 3) -> str:
    text = significant(value, digits, least=1e-6)
    return text.rstrip("0").rstrip(".") if "." in text and "×" not in text else text


def with_unit(value: float, unit: str, digits: int = 3, sign: bool = False) -> str:
    """A size in a sentence, without zeros at its end: 51.2 µm, 2 mm, 1.5 m, 0.0369 Hz, −928 m/h.
    unit: that of the value; those of `PREFIXED` get a prefix. sign: + is written too."""
    if math.isnan(value):
        return "unknown"
    value = value if abs(value) >= ARITHMETIC.get(unit, 0.0) else 0.0
    rounded = float(f"{value:.{digits - 1}e}")
    factor, shown = _prefix(rounded, unit)
    text = ("+" if sign and value > 0 else "") + _without_zeros(rounded * factor, digits)
    return text + shown if shown == "°" else f"{text} {shown}"


def mm(value: float, digits: int = 3) -> str:
    """A length given in mm: 51.2 µm, 2 mm, 1.5 m."""
    return with_unit(value, "mm", digits)


def apart(mm: float, deg: float, digits: int = 3) -> str:
    """How far poses are apart, `2.15 mm and 0.05°`, with two digits of an angle. Below the
    resolution the arithmetic decides: `less than 0.001 mm and 0.00001°`."""
    if is_same(mm, deg):
        return f"less than {RESOLUTION_MM:g} mm and {RESOLUTION_DEG:.5f}°"
    shown = 0 if mm < RESOLUTION_MM else mm, 0 if deg < RESOLUTION_DEG else deg
    return f"{shown[0]:.{digits}g} mm and {shown[1]:.2g}°"


def is_same(mm: float, deg: float) -> bool:
    """Whether poses differ by less than the resolution of their numbers."""
    return mm < RESOLUTION_MM and deg < RESOLUTION_DEG


def with_uncertainty(value: float, sigma: float, unit: str = "") -> str:
    """Two digits of a standard uncertainty and the value to the same place: 0.03690 ± 0.00012 Hz.
    Both in the unit of the value, with its prefix; only the value where sigma is unknown."""
    if not (math.isfinite(sigma) and sigma > 0):
        return with_unit(value, unit) if unit else significant(value)
    shown, error, behind = _to_one_place(unit, sigma, value)
    return f"({shown} ± {error}){behind}" if "×" in behind else f"{shown} ± {error}{behind}"


def with_interval(
    value: float | None, lower: float | None, upper: float | None, unit: str = ""
) -> str:
    """`9.256 (9.246…9.266)×10⁻⁷`, `0.02600 (0.02550…0.02641) mm`: two digits of half the width of
    the interval, value and ends to the same place and over one power of ten. What is unknown is
    left out."""
    if value is None or math.isnan(value):
        return ""
    half = math.nan if lower is None or upper is None else (upper - lower) / 2
    if lower is None or upper is None or not (math.isfinite(half) and half > 0):
        return with_unit(value, unit) if unit else significant(value)
    shown, low, high, _, behind = _to_one_place(unit, half, value, lower, upper)
    return f"{shown} ({low}…{high}){behind}"


def _to_one_place(unit: str, sigma: float, value: float, *ends: float) -> list[str]:
    """Value, ends and sigma in one unit or over one power of ten, to one place; what follows."""
    factor, prefixed = _prefix(max(abs(value), sigma) if ends else value, unit)
    power = 0 if unit or not value else int(f"{value:e}".partition("e")[2])
    power = 0 if SMALL <= power < LARGE else power
    scale = factor / 10.0**power
    decimals = _decimals(sigma * scale)
    if ends:
        decimals = max(decimals, min(_decimals(value * scale), decimals + 1))
    values = [v * scale for v in (value, *ends)]
    texts = [f"{v:.{decimals if abs(v) < FAR else 0}f}".replace("-", MINUS) for v in values]
    behind = f"×{power_of_ten(power)}" if power else f" {prefixed}".rstrip()
    return [*texts, f"{sigma * scale:.{decimals}f}", behind]


def _decimals(value: float) -> int:
    """Decimals that show two digits of a value."""
    if value == 0:
        return 0
    return min(max(1 - int(f"{abs(value):.1e}".partition("e")[2]), 0), PLACES)


def _prefix(value: float, unit: str) -> tuple[float, str]:
    """The factor for a value in `unit`, and the unit with its prefix."""
    rows = PREFIXED.get(unit, ()) if value else ()
    return next((row[1:] for row in rows if abs(value) >= row[0]), (1.0, unit))


def number(value: float, decimals: int = 0, sign: bool = False) -> str:
    """13 195 or −5.20: thousands set apart, a real minus sign."""
    text = f"{value:{'+' if sign else ''},.{decimals}f}"
    return text.replace(",", THIN_SPACE).replace("-", MINUS)


def percent(share: float, digits: int = 3, sign: bool = False) -> str:
    """`3.12 %` of 0.0312, `−2.1 %`, or `less than 0.001 %`."""
    if not sign and share < 1e-5:
        return "less than 0.001 %"
    if abs(share) >= 1e4:
        return f"{number(100 * share, sign=sign)} %"
    return f"{'+' if sign and share > 0 else ''}{_without_zeros(100 * share, digits)} %"


def at_most(share: float) -> str:
    """`at most 3.12 %`, or `less than 0.001 %`."""
    text = percent(share)
    return text if text.startswith("less") else f"at most {text}"


def two_digits(value: float) -> str:
    """`5.9`, `20`."""
    return f"{value:.2g}"


def span(values: Iterable[float], shown: Callable[[float], str]) -> str:
    """`3 %` or `3 % to 5 %`."""
    known = np.array(list(values), float)
    return " to ".join(dict.fromkeys((shown(float(known.min())), shown(float(known.max())))))


def duration_words(seconds: float) -> str:
    """`nine hours` as those of S, `an hour`, `2.5 h`, `10 min`, `100 s`, `20 ms`."""
    if round(seconds) == NINE_HOURS_S:
        return "nine hours"
    if abs(seconds / 3600 - 1) < 0.005:
        return "an hour"
    if seconds >= 5400:
        return f"{_without_zeros(seconds / 3600)} h"
    return f"{_without_zeros(seconds / 60)} min" if seconds >= 120 else with_unit(seconds, "s")


def moment(seconds: float) -> str:
    """`98.5 s`, `4 min 58.5 s`, `4 h 29 min 58.5 s`, `4 h 30 min`."""
    tenths = round(10 * seconds)
    if tenths < 10 * MINUTES_FROM_S:
        return f"{tenths / 10:.1f} s"
    minutes, rest = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    parts = f"{hours} h" * bool(hours), f"{minutes} min", f"{rest / 10:.1f} s" * bool(rest)
    return " ".join(filter(None, parts))


def power_of_ten(exponent: int) -> str:
    """10⁻⁷ of -7."""
    return "10" + str(exponent).translate(SUPERSCRIPT)
