"""The recordings of a group: how they differ, and their curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.present.plot.curves import Curve
from mocap_metrology.present.plot.figure import LOOKS, OTHER_LOOKS, Look, coordinate_of
from mocap_metrology.present.tables import Record

Rows = Mapping[str, Record]

CAMERAS, RECORDING = "Number of cameras", "Recording"
NAMED_LOOKS = (*LOOKS.values(), *OTHER_LOOKS)  # so many recordings can be distinguished by name
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h", "<", ">", "p", "8")
MAP, LIGHTEST, DARKEST = "inferno", 0.55, 0.0  # colours whose lightness falls evenly
MOST_BANDS = 3  # curves in a panel up to which their intervals are drawn
MOST_MARKERS, MOST_DISTANCES = 3, 3  # with panels of their own


@dataclass(frozen=True)
class Family:
    """Recordings that are shown together, in the order of the key.

    by: `CAMERAS` or `RECORDING`. labels: of each recording; looks: by label, none where
    there are too many to distinguish.
    """

    by: str
    labels: Mapping[str, str]
    looks: Mapping[str, Look]

    def said(self, label: str) -> str:
        """A label that is understood by itself."""
        return f"{label} cameras" if self.by == CAMERAS else label


def family_of(rows: Rows) -> Family:
    """Recordings by their number of cameras where they are subsets of one camera type, no two with
    as many; else by name. rows: of the sheet, by recording."""
    counts = [row["n_cameras"] for row in rows.values()]
    types = {row["camera_type"] for row in rows.values()}
    if None not in counts and len(set(counts)) == len(counts) > 1 and len(types) == 1:
        labels = {
            name: str(row["n_cameras"])
            for name, row in sorted(rows.items(), key=lambda item: item[1]["n_cameras"])
        }
        looks = {str(n): look for n, look in count_looks(counts).items()}
        return Family(CAMERAS, labels, looks if len(looks) <= len(MARKERS) else {})
    few = len(rows) <= len(NAMED_LOOKS)
    looks = dict(zip(rows, NAMED_LOOKS, strict=False)) if few else {}
    return Family(RECORDING, {name: name for name in rows}, looks)


def count_looks(counts: Sequence[int]) -> dict[int, Look]:
    """Looks of numbers of cameras: the more, the darker, in even steps; a marker each."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    counts = sorted(set(counts))
    looks = {}
    for k, n in enumerate(counts):
        share = k / (len(counts) - 1) if len(counts) > 1 else 1.0
        colour = to_hex(colormaps[MAP](LIGHTEST + share * (DARKEST - LIGHTEST)))
        looks[n] = Look(colour, "-", MARKERS[k % len(MARKERS)])
    return looks


def curve_of(allan: Mapping[str, np.ndarray], series: str, label: str, band: bool) -> Curve:
    """The overlapping Allan deviation of one series of allan_masked.parquet, with its interval."""
    own = (allan["series"] == series) & (allan["estimator"] == "oadev")
    ends = allan["adev_lower_mm"][own], allan["adev_upper_mm"][own]
    return Curve(label, allan["tau_s"][own], allan["adev_mm"][own], ends if band else None)


def shown_series(names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Series with a panel of their own (those of the first three markers, and the first three
    distances), and the others; both in their order."""
    found = {name: coordinate_of(name) for name in dict.fromkeys(names)}
    markers = sorted({place[1] for place in found.values() if place})[:MOST_MARKERS]
    distances = [name for name, place in found.items() if not place][:MOST_DISTANCES]
    shown = [
        name
        for name, place in found.items()
        if (place[1] in markers if place else name in distances)
    ]
    return shown, [name for name in found if name not in shown]


def left_out(names: Sequence[str]) -> str:
    """A note on series that a figure does not show."""
    if not names:
        return ""
    text = ", ".join(names) if len(names) <= 6 else f"{len(names)} further series"
    return f"Not shown: {text}."
