"""The unit of length of a recording: as its file names it, assumed, or given by the user."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal, UnknownUnit

Unit = Literal["mm", "m"]  # what a user may give
Source = Literal["file", "assumed", "given", "unknown"]

_SPELLED = {"millimet": 1.0, "centimet": 10.0, "met": 1000.0, "micromet": 1e-3}
_ENDINGS = ("", "e", "er", "ers", "re", "res")  # "mete": cut to 4 characters by its writer
MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 1e-3, "\u00b5m": 1e-3, "\u03bcm": 1e-3}
MM |= dict.fromkeys(("in", "inch", "inches"), 25.4) | dict.fromkeys(("ft", "foot", "feet"), 304.8)
MM |= {stem + ending: mm for stem, mm in _SPELLED.items() for ending in _ENDINGS}
KNOWN = "mm, cm, m, um, in, ft, or their names"
NEAR_MM = 20.0  # no volume is so small, and none measures 20 m to each side of its origin
NOWHERE_MM = 1e10  # 10 000 km
FAR_MM = 1e5  # no volume is so large; in mm it is a few cm from the origin


@dataclass(frozen=True)
class LengthUnit:
    """`name` of the unit and `mm` in it; `source`: the `file` or its format, `assumed` where the
    file names none, `given` by the user, `unknown` until it is. `written`: text of the file.
    `remark`: what to say of it; of an unknown unit, why it is refused."""

    name: str
    mm: float
    source: Source = "file"
    written: str = ""
    remark: str = ""

    def stated(self, unit: Unit | None, file: str) -> LengthUnit:
        """This unit, or the one that the user gives in its place; refused where it stays
        unknown."""
        if unit not in ("mm", "m", None):
            raise UnknownUnit(f"{file}: unit is {unit!r}, expected mm or m")
        if unit is None and self.source == "unknown":
            raise UnknownUnit(f"{file}: {self.remark}")
        if unit is None:
            return self
        remark = ""
        if self.source != "file" or MM[unit] != self.mm:
            said = f"says {self.written[:40]!r}" if self.written else "names none"
            remark = f"its unit is {unit}, as given; the file {said}"
        return replace(self, name=unit, mm=MM[unit], source="given", remark=remark)

    def check_size(self, position_mm: npt.NDArray[np.floating], file: str) -> None:
        """Refuse coordinates that are in m where the unit is mm, or the other way round, unless the
        user gave it, and what is no position in any unit. `position_mm` of any shape, NaN where
        invalid."""
        largest = largest_of(position_mm)
        if largest > NOWHERE_MM:
            raise Refusal(
                f"{file}: a coordinate is {largest:.3g} mm: the file is damaged, or its numbers are"
                " no positions"
            )
        if self.source == "given" or self.mm not in (MM["mm"], MM["m"]):
            return
        how = "assumed, as the file names none" if self.source == "assumed" else "the file's unit"
        if self.mm == MM["mm"] and largest <= NEAR_MM:
            raise UnknownUnit(
                f"{file}: no coordinate exceeds {largest:.3g} mm (mm: {how}), so they may be in"
                " metres: state the unit, m or mm"
            )
        if self.mm == MM["m"] and largest > FAR_MM:
            raise UnknownUnit(
                f"{file}: coordinates reach {largest / MM['m']:.4g} m (m: {how}), so they may be in"
                " mm: state the unit, mm or m"
            )


MILLIMETRE = LengthUnit("mm", MM["mm"], written="mm")
METRE = LengthUnit("m", MM["m"], written="m")


def largest_of(position: npt.NDArray[np.floating]) -> float:
    """The largest coordinate to either side of the origin; NaN where all are."""
    high, low = (f.reduce(position, axis=None, initial=np.nan) for f in (np.fmax, np.fmin))
    return max(high, -low)


def read_unit(texts: Sequence[str], name: str, file: str, of_points: bool = False) -> LengthUnit:
    """The unit of a file, of which the field `name` says `texts`, once or once per point
    (`of_points`); mm is assumed where it says nothing."""
    stated = list(dict.fromkeys(text.strip() for text in texts if text.strip()))
    if not stated:
        return LengthUnit("mm", MM["mm"], "assumed", "", f"no unit in {name}: mm is assumed")
    sizes = [MM.get(text.strip("[()] ").lower()) for text in stated]
    for text, mm in zip(stated, sizes, strict=True):
        if mm is None:
            return unknown(f"{name} is {text[:40]!r}, expected one of {KNOWN}", text)
    if len(set(sizes)) > 1:
        differ = (
            f"between points ({', '.join(sorted(stated))})"
            if of_points
            else f"({', '.join(stated)})"
        )
        raise Refusal(f"{file}: {name} differ {differ}, expected one unit")
    return LengthUnit(stated[0], sizes[0] or math.nan, written=stated[0])


def unknown(why: str, written: str = "") -> LengthUnit:
    """The unit of a file that names none, or one that is not known, where none can be assumed:
    refused, unless it is given."""
    return LengthUnit("", math.nan, "unknown", written, why)
