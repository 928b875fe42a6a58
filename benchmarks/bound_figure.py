"""Figure of docs/lighthouse.md: error of each recording against its Cramer-Rao bound.

    python -m benchmarks.bound_figure docs/calibration_bound.csv docs/calibration_bound

Ten setups of five recordings, the case "real noise" of `joint_calibration.py`, by `batch` and
`paper-lm`. The table is read where it exists, otherwise measured and written.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from benchmarks import arguments
from benchmarks.joint_calibration import CASES, by_batch, recorded
from benchmarks.poses import lengths, off
from mocap_metrology.common.files import write_csv
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.curves import log_limits

SETUPS, RECORDINGS = 10, 5
CASE = CASES["real noise"]
SETTINGS = CalibrationSettings(estimators=["paper-lm"], optics=["factory"], variant="crazyflie")
LOOK = {"batch": plot.LOOKS["x"], "paper-lm": plot.LOOKS["y"]}
PARTS = {"mm": "Position", "deg": "Rotation"}
WIDTH = 0.17  # of a recording, in setups
HEIGHT_MM = 150.0

Rows = list[dict[str, float]]


def measured(setup: int, recording: int) -> dict[str, float]:
    """Lengths of the error vectors by both estimators, and roots of the traces of the bound."""
    made, given = recorded(CASE, setup, recording)
    error, _, least, _ = by_batch(CASE, made, given)
    factories = [station.factory for station in given.stations]
    others = calibrate(given.hits, given.board, factories, SETTINGS).estimates
    final = next(pose for pose in others if pose.stage == "final")
    traces = np.add.reduceat(np.diag(least), [0, 3])
    row: dict[str, float] = {"setup": setup, "recording": recording}
    for k, unit in enumerate(PARTS):
        row[f"bound_{unit}"] = round(float(np.sqrt(traces[k])), 5)
        row[f"batch_{unit}"] = round(lengths(error)[k], 5)
        row[f"paper-lm_{unit}"] = round(lengths(off(made, final))[k], 5)
    return row


def column(rows: Rows, name: str) -> np.ndarray:
    return np.array([row[name] for row in rows])


def draw(axes: Axes, rows: Rows, unit: str) -> None:
    """Errors and bound of each recording, side by side within its setup."""
    plot.panel_title(axes, PARTS[unit])
    at = 1 + column(rows, "setup") + WIDTH * (column(rows, "recording") - (RECORDINGS - 1) / 2)
    shown = [least := column(rows, f"bound_{unit}")]
    for k, (name, look) in enumerate(LOOK.items()):
        ratios = [
            np.sqrt(
                np.sum(column(rows, f"{name}_{u}") ** 2) / np.sum(column(rows, f"bound_{u}") ** 2)
            )
            for u in PARTS
        ]
        text = (
            f"{name}: rms {ratios[0]:.2f} times the bound in position, {ratios[1]:.2f} in rotation"
        )
        shown.append(column(rows, f"{name}_{unit}"))
        how = {"ms": 3.6, "mew": 0.9, "zorder": 4 - k, "label": text}
        axes.plot(at, shown[-1], **look.line(ls="", **how))
    half = 0.45 * WIDTH
    axes.hlines(least, at - half, at + half, color=plot.INK, lw=1.6, label="Cramer-Rao bound (rms)")
    plot.log_axis(axes, "y", log_limits(shown, 1.3))
    axes.set(xticks=range(1, SETUPS + 1), xlim=(0.4, SETUPS + 0.6), xlabel="Setup")
    axes.set_ylabel(f"Error ({'mm' if unit == 'mm' else '°'})")
    axes.grid(visible=False, axis="x")


@plot.styled()
def figure(path: Path) -> plot.Picture:
    """Position and rotation."""
    with path.open(encoding="utf-8") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    source = f"Simulated: {len(rows)} recordings with real noise (benchmarks/bound_figure.py)."
    texts = plot.Texts("Error of the slave's pose and its Cramer-Rao bound", source)
    body = plot.new_figure(texts, HEIGHT_MM)
    panels = body.subplots(2, 1, sharex=True)
    for axes, unit in zip(panels, PARTS, strict=True):
        draw(axes, rows, unit)
    panels[0].set_xlabel("")
    plot.letters(panels)
    plot.legend_below(body, panels, 1)
    return plot.Picture(body, "Lengths of the error vectors; roots of the traces of the bounds.")


def main(table: str, stem: str) -> None:
    path = Path(table)
    if not path.exists():
        pairs = [(s, r) for s in range(SETUPS) for r in range(RECORDINGS)]
        write_csv(path, [measured(*pair) for pair in pairs])
    plot.save(figure(path), Path(stem))


if __name__ == "__main__":
    main(**arguments(__doc__, table="docs/calibration_bound.csv", stem="docs/calibration_bound"))
