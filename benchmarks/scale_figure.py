"""Figure of docs/scale.md: processor time and memory as recordings grow longer, or more.

    python -m benchmarks.scale_figure docs/scale.csv docs/scale

The table has a row a rule and size (`scale.py hours 1 3 9 --csv docs/scale.csv`).
"""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

from matplotlib.axes import Axes

from benchmarks import arguments
from mocap_metrology.present.plot import figure as plot

KINDS = {
    "hours": ("Two markers at 120 Hz", "Duration (h)"),
    "markers": ("Ten minutes at 120 Hz", "Markers"),
}
RULES = ("clean", "noise", "verdict")  # the most expensive ones
TOTAL = "all jobs"
LABELS = {"cpu_s": "Processor time (s)", "gb": "Resident memory (GB)"}
LOOK = {**dict(zip(RULES, plot.LOOKS.values(), strict=True)), TOTAL: plot.OTHER_LOOKS[0]}
Point = dict[str, float]  # rule -> value
HEIGHT_MM = 125.0


def measured(path: Path) -> dict[str, dict[float, dict[str, Point]]]:
    """Kind -> size -> quantity -> rule -> value, and the sum of the seconds of all rules."""
    found: dict[str, dict[float, dict[str, Point]]] = defaultdict(dict)
    with path.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            own = found[row["kind"]].setdefault(float(row["size"]), {"cpu_s": {}, "gb": {}})
            for quantity in own:
                own[quantity][row["rule"]] = float(row[quantity])
    for sizes in found.values():
        for own in sizes.values():
            own["cpu_s"][TOTAL] = sum(own["cpu_s"].values())
    return found


@plot.styled()
def figure(path: Path) -> plot.Picture:
    """Above the seconds, below the gigabytes of the largest job of a rule; a column a kind."""
    found = measured(path)
    kinds = [kind for kind in KINDS if kind in found]
    body = plot.new_figure(
        plot.Texts("Cost of a run", "Measured by benchmarks/scale.py."), HEIGHT_MM
    )
    panels = body.subplots(len(LABELS), len(kinds), squeeze=False, sharey="row")
    for row, quantity in zip(panels, LABELS, strict=True):
        row[0].set_ylabel(LABELS[quantity])
        drawn = [
            own[quantity].get(rule, 0.0)
            for k in kinds
            for own in found[k].values()
            for rule in LOOK
        ]
        limits = min(value for value in drawn if value > 0) / 1.5, max(drawn) * 1.5
        for axes, kind in zip(row, kinds, strict=True):
            _panel(axes, found[kind], quantity, limits)
    for top, bottom, kind in zip(panels[0], panels[-1], kinds, strict=True):
        plot.panel_title(top, KINDS[kind][0])
        bottom.set_xlabel(KINDS[kind][1])
    plot.letters(panels.ravel())
    plot.legend_below(body, panels.ravel())
    return plot.Picture(body.figure, "Processor time and memory of the jobs of a run.")


def _panel(
    axes: Axes, sizes: dict[float, dict[str, Point]], quantity: str, limits: tuple[float, float]
) -> None:
    for rule, look in LOOK.items():
        points = sorted(
            (k, own[quantity][rule]) for k, own in sizes.items() if rule in own[quantity]
        )
        if points:
            axes.plot(*zip(*points, strict=True), label=rule, **look.line())
    plot.log_axes(axes, ((min(sizes) / 1.5, max(sizes) * 1.5), limits))


if __name__ == "__main__":
    asked = arguments(__doc__, table="docs/scale.csv", stem="docs/scale")
    plot.save(figure(Path(asked["table"])), asked["stem"])
