"""Units of length that C3D files name, in mm."""

from __future__ import annotations

from collections.abc import Sequence

from mocap_metrology.common.errors import Refusal

_SPELLED = {"millimet": 1.0, "centimet": 10.0, "met": 1000.0}
_ENDINGS = ("", "e", "er", "ers", "re", "res")  # "mete": cut to 4 characters by its writer
MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0} | {
    stem + ending: mm for stem, mm in _SPELLED.items() for ending in _ENDINGS
}
KNOWN = "mm, cm, m, millimetre, centimetre, metre"


def read_unit(texts: Sequence[str], file: str) -> tuple[str, float, tuple[str, ...]]:
    """Unit as written, mm in it, and remarks; from POINT:UNITS, given once or once per point."""
    given = [text.strip() for text in texts if text.strip()]
    if not given:
        return "mm", 1.0, ("units_assumed: POINT:UNITS is missing or empty, mm is assumed",)
    factors = {MM.get(text.lower()) for text in given}
    if None in factors:
        unknown = next(text for text in given if text.lower() not in MM)
        raise Refusal(f"{file}: POINT:UNITS is {unknown[:40]!r}, expected one of {KNOWN}")
    if len(factors) > 1:
        differ = ", ".join(sorted(set(given)))
        raise Refusal(f"{file}: POINT:UNITS differ between points ({differ}), expected one unit")
    return given[0], factors.pop(), ()
