"""Figure of docs/scale.md: processor time and memory as recordings grow longer, or more.

    python benchmarks/scale_figure.py docs/scale.csv docs/scale

The table has a row a rule and size (`scale.py hours 1 3 9 --csv docs/scale.csv`).
"""

from __future__ import annotations

import csv
import sys
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes

from mocap_metrology.present.plot.figure import (
    LOOKS,
    OTHER_LOOKS,
    Picture,
    legend_below,
    letters,
    log_axes,
    new_figure,
    panel_title,
    save,
    styled,
)

KINDS = {
    "hours": ("Two markers at 120 Hz", "Duration (h)"),
    "markers": ("Ten minutes at 120 Hz", "Markers"),
    "recordings": ("Two markers, ten minutes each", "Recordings"),
}
RULES = ("noise", "series_statistics", "verdict")  # the most expensive ones
TOTAL = {"cpu_s": "all jobs", "gb": "largest job"}
LABELS = {"cpu_s": "Processor time (s)", "gb": "Resident memory (GB)"}
LOOK = {
    **dict(zip(RULES, LOOKS.values(), strict=True)),
    **dict.fromkeys(TOTAL.values(), OTHER_LOOKS[0]),
}
Point = dict[str, float]  # rule -> value
HEIGHT_MM = 125.0


def measured(path: Path) -> dict[str, dict[float, dict[str, Point]]]:
    """Kind -> size -> quantity -> rule -> value, and the sum or largest of all rules."""
    found: dict[str, dict[float, dict[str, Point]]] = defaultdict(dict)
    with path.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            own = found[row["kind"]].setdefault(float(row["size"]), {"cpu_s": {}, "gb": {}})
            for quantity in own:
                own[quantity][row["rule"]] = float(row[quantity])
    for sizes in found.values():
        for own in sizes.values():
            own["cpu_s"][TOTAL["cpu_s"]] = sum(own["cpu_s"].values())
            own["gb"][TOTAL["gb"]] = max(own["gb"].values())
    return found


@styled()
def figure(path: Path) -> Picture:
    """Above the seconds, below the gigabytes; a column a kind."""
    found = measured(path)
    kinds = [kind for kind in KINDS if kind in found]
    body = new_figure("Cost of a run", "Measured by benchmarks/scale.py.", HEIGHT_MM)
    panels = body.subplots(len(LABELS), len(kinds), squeeze=False, sharey="row")
    for row, quantity in zip(panels, LABELS, strict=True):
        values = [v for k in kinds for own in found[k].values() for v in own[quantity].values()]
        limits = min(v for v in values if v > 0) / 1.5, max(values) * 1.5
        for axes, kind in zip(row, kinds, strict=True):
            _panel(axes, found[kind], quantity, limits)
            if row is panels[0]:
                panel_title(axes, KINDS[kind][0])
            else:
                axes.set_xlabel(KINDS[kind][1])
        row[0].set_ylabel(LABELS[quantity])
    letters(panels.ravel())
    legend_below(body, panels.ravel())
    return Picture(body.figure, "Processor time and memory of the jobs of a run.")


def _panel(
    axes: Axes,
    sizes: dict[float, dict[str, Point]],
    quantity: str,
    limits: tuple[float, float],
) -> None:
    for rule in (TOTAL[quantity], *RULES):
        points = sorted(
            (s, own[quantity][rule]) for s, own in sizes.items() if rule in own[quantity]
        )
        axes.plot(*zip(*points, strict=True), label=rule, **LOOK[rule].line())
    log_axes(axes, ((min(sizes) / 1.5, max(sizes) * 1.5), limits))


def main(given: Sequence[str]) -> None:
    save(figure(Path(given[0])), given[1])


if __name__ == "__main__":
    main(sys.argv[1:])
