"""The recordings of a group: how they differ, and which of their series are shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mocap_metrology.common.types import Record
from mocap_metrology.present.plot.curves import facets
from mocap_metrology.present.plot.figure import LOOKS, OTHER_LOOKS, Look

Rows = Mapping[str, Record]

CAMERAS, RECORDING = "Number of cameras", "Recording"
NAMED_LOOKS = (*LOOKS.values(), *OTHER_LOOKS)  # so many recordings can be distinguished by name
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h", "<", ">", "p", "8")
MAP, LIGHTEST, DARKEST = "inferno", 0.55, 0.0  # colours whose lightness falls evenly
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
    counts = {name: row["n_cameras"] for name, row in rows.items()}
    numbers, types = set(counts.values()), {row["camera_type"] for row in rows.values()}
    if None not in numbers and len(numbers) == len(rows) > 1 and len(types) == 1:
        labels = {name: str(counts[name]) for name in sorted(rows, key=lambda n: counts[n])}
        looks = {str(n): look for n, look in count_looks(list(numbers)).items()}
        return Family(CAMERAS, labels, looks if len(looks) <= len(MARKERS) else {})
    few = len(rows) <= len(NAMED_LOOKS)
    looks = dict(zip(rows, NAMED_LOOKS, strict=False)) if few else {}
    return Family(RECORDING, {name: name for name in rows}, looks)


def count_looks(counts: Sequence[int]) -> dict[int, Look]:
    """Looks of numbers of cameras: the more, the darker, in even steps; a marker each."""
    import numpy as np
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    counts = sorted(set(counts))
    shades = np.linspace(LIGHTEST, DARKEST, len(counts)) if len(counts) != 1 else [DARKEST]
    return {
        n: Look(to_hex(colormaps[MAP](shade)), "-", MARKERS[k % len(MARKERS)])
        for k, (n, shade) in enumerate(zip(counts, shades, strict=True))
    }


def shown_series(names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Series with a panel of their own (those of the first three markers, and the first three
    distances), and the others; both in their order."""
    panels = facets(names, len(names))
    markers = [of for title, of in panels.items() if title.startswith("Marker")]
    distances = [of[:MOST_DISTANCES] for title, of in panels.items() if title.startswith("Dist")]
    own = {name for of in [*markers[:MOST_MARKERS], *distances] for name in of}
    names = list(dict.fromkeys(names))
    return [name for name in names if name in own], [name for name in names if name not in own]


def left_out(names: Sequence[str]) -> str:
    """A note on series that a figure does not show."""
    if not names:
        return ""
    text = ", ".join(names) if len(names) <= 6 else f"{len(names)} further series"
    return f"Not shown: {text}."
