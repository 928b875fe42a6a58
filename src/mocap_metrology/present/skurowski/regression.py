"""S Figure 6: starts of the weighted fit, and the fit without weights, on one Allan deviation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.model.components import Form, NoiseModel
from mocap_metrology.present.drawing.axes import decade_axis, linear_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    INK,
    LOOKS,
    MARGIN_MM,
    WIDTH_MM,
    Keywords,
    blank_sheet,
    head,
    label_axes,
    say,
    styled,
)
from mocap_metrology.present.fits.parts import drawn_m, model_avar

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT_MM, RIGHT_MM, TITLE_MM, GAP_MM, LABELS_MM = 16.5, 3.0, 5.5, 3.0, 11.5
PANEL_MM = WIDTH_MM - LEFT_MM - RIGHT_MM, 72.0
RESIDUAL_MM = 34.0
DATA: Keywords = {"color": INK, "marker": "o", "markersize": 2.6, "markerfacecolor": "white"}
START: Keywords = {"color": "#9a9a9a", "lw": 0.7, "ls": "-"}
FINAL: Keywords = {"color": LOOKS["x"].colour, "lw": 1.5, "ls": "-"}
ORDINARY: Keywords = {"color": LOOKS["y"].colour, "lw": 1.3, "ls": (0, (5, 1.6))}
QUANTILE, PERCENT = 0.9, (5.0, 10.0, 20.0, 50.0, 100.0)  # axis of the residuals: one of these


@styled()
def regression_figure(
    tau_s: np.ndarray,
    adev_mm: np.ndarray,
    starts: Sequence[NoiseModel],
    ordinary: NoiseModel,
    final: NoiseModel,
    frame_rate_hz: float,
    title: str,
    note: str = "",
    *,
    form: Form = "continuous",
) -> Figure:
    """S Figure 6: the Allan deviation, every start of annealing, the result after the ant colony
    (relative residuals, S Eq. 13) and ordinary least squares (Levenberg-Marquardt, no weights).

    tau_s, adev_mm: (k,); starts: annealing's results; form: of the Allan
    variances that were fitted. Below: residuals in per cent of the model.
    """
    tau0 = 1 / frame_rate_hz
    entries = _entries(len(starts))
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = TITLE_MM + PANEL_MM[1] + GAP_MM + RESIDUAL_MM + LABELS_MM
    sheet = blank_sheet(key_top + strip_height(entries, width) + 1.5, title, note)
    axes = sheet.axes(LEFT_MM, TITLE_MM, *PANEL_MM)
    below = sheet.axes(LEFT_MM, TITLE_MM + PANEL_MM[1] + GAP_MM, PANEL_MM[0], RESIDUAL_MM)
    tau, adev = np.asarray(tau_s, dtype=np.float64), np.asarray(adev_mm, dtype=np.float64)
    keep = np.isfinite(adev) & (adev > 0)
    tau, adev = tau[keep], adev[keep]
    x_limits, y_limits = log_limits([tau]), log_limits([adev], 1.0)
    y_limits = y_limits[0] / 1.2, y_limits[1] * 1.2
    decade_axis(axes, "x", x_limits, PANEL_MM[0])
    decade_axis(axes, "y", y_limits, PANEL_MM[1])
    decade_axis(below, "x", x_limits, PANEL_MM[0])
    axes.tick_params(labelbottom=False)
    m = (tau / tau0).round().astype(np.int64)
    models = [(s, START) for s in starts] + [(ordinary, ORDINARY), (final, FINAL)]
    grid = drawn_m(int(m.max(initial=2)))
    for model, how in models:
        axes.plot(grid * tau0, _within(_adev(model, grid, frame_rate_hz, form), y_limits), **how)
    axes.plot(tau, adev, ls="", **DATA)
    _residuals(below, (tau, adev), [(_adev(x, m, frame_rate_hz, form), how) for x, how in models])
    head(axes, "Allan deviation", f"model: {form}")
    label_axes(axes, y="Allan deviation (mm)", y_mm=13.0)
    label_axes(below, x="Averaging time τ (s)", y="Data/model − 1 (%)", y_mm=13.0)
    if not tau.size:
        say(axes, "no valid samples")
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _entries(n_starts: int) -> list[Entry]:
    return [
        Entry("data", dot=DATA),
        Entry(f"{n_starts} start{'' if n_starts == 1 else 's'} of annealing", line=START),
        Entry("weighted least squares: the best start after the ant colony", line=FINAL),
        Entry("ordinary least squares (Levenberg-Marquardt)", line=ORDINARY),
    ]


def _adev(model: NoiseModel, m: np.ndarray, frame_rate_hz: float, form: Form) -> np.ndarray:
    adev: np.ndarray = np.sqrt(model_avar(model, m, frame_rate_hz, form))
    return adev


def _within(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    return np.where((values > limits[0] / 3) & (values < limits[1] * 3), values, np.nan)


def _residuals(
    axes: Axes,
    data: tuple[np.ndarray, np.ndarray],
    curves: Sequence[tuple[np.ndarray, Keywords]],
) -> None:
    """In per cent; the axis holds 90 % of each curve, of the final one all."""
    tau, adev = data
    with np.errstate(divide="ignore", invalid="ignore"):
        off = [np.where(curve > 0, 100 * (adev / curve - 1), np.nan) for curve, _ in curves]
    sizes = [np.abs(o[np.isfinite(o)]) for o in off]
    reach = max((float(np.quantile(s, QUANTILE)) for s in sizes if s.size), default=1.0)
    if sizes and sizes[-1].size:
        reach = max(reach, float(sizes[-1].max()))
    limit = next((p for p in PERCENT if p >= 1.05 * reach), PERCENT[-1])
    linear_axis(axes, "y", (-limit, limit), 5)
    axes.axhline(0, color=INK, lw=0.6)
    for values, (_, how) in zip(off, curves, strict=True):
        axes.plot(tau, np.where(np.abs(values) < 3 * limit, values, np.nan), **how)
