"""One series and what was fitted to it: Allan deviation and spectrum, components, residuals, and
other estimators in panels of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow, correlation_class
from mocap_metrology.noise.model.components import GaussMarkov
from mocap_metrology.present.fits.allan_panels import (
    allan_panel,
    allan_residual_panel,
    other_residuals_panel,
)
from mocap_metrology.present.fits.parts import (
    Spectrum,
    fit_of,
    recorded_s,
)
from mocap_metrology.present.fits.shown import Shown
from mocap_metrology.present.fits.spectrum_panels import (
    other_spectra_panel,
    psd_panel,
    psd_residual_panel,
)
from mocap_metrology.present.plot.figure import (
    Picture,
    legend_below,
    letters,
    new_figure,
    styled,
)
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROWS_MM = (58.0, 25.0, 38.0)  # curves, residuals, other estimators
LABEL_AT = -0.15  # of the width of a panel; matplotlib would measure every tick label for it


@styled()
def fit_figure(
    title: str,
    allan: Mapping[str, np.ndarray],
    periodogram: Mapping[str, np.ndarray],
    estimates: Mapping[str, Sequence[NoiseRow]],
    frame_rate_hz: float,
    source: str = "",
    remarks: str = "",
    *,
    main: str = DEFAULT_ESTIMATOR,
    confidence: float = 0.683,
    lines_subtracted: bool = True,
) -> Picture:
    """Figure of one series: data, fitted model and its components, residuals below; then what other
    estimators found.

    allan: arrays `m`, `tau_s`, `adev_mm`, `adev_lower_mm`, `adev_upper_mm`, `n_terms`; periodogram:
    arrays `f_hz`, `f_lower_hz`, `f_upper_hz`, `psd_mm2_hz`, `dof`; estimates: rows of noise.csv of
    this series by estimator. Components are those of `main`; models are
    drawn in the form of Allan variances they were fitted in, spectra in that of `main`. confidence:
    of the intervals of `allan`; lines_subtracted: whether the sinusoid is gone from `periodogram`.
    `source`: the line at the foot; `remarks`: what the caption adds.
    """
    duration = recorded_s(allan, frame_rate_hz)
    fits = {name: fit_of(name, rows, duration) for name, rows in estimates.items() if rows}
    chosen = fits.pop(main, None) or fit_of(main, [])
    shown = Shown(
        _positive(allan),
        Spectrum.of(periodogram, lines=not lines_subtracted),
        chosen,
        [fit for fit in fits.values() if fit.parts],
        frame_rate_hz,
        confidence,
    )
    rows = ["ab", "cd", "ef"] if shown.others else ["ab", "cd"]
    heights = ROWS_MM[: len(rows)]
    n_entries = 3 + len(chosen.parts) + len(shown.others)
    body = new_figure(title, source, 28.0 + sum(heights) + 1.9 * n_entries)
    panels = body.subplot_mosaic("\n".join(rows), height_ratios=heights)
    _share(panels)
    allan_panel(panels["a"], shown)
    psd_panel(panels["b"], shown)
    allan_residual_panel(panels["c"], shown)
    psd_residual_panel(panels["d"], shown)
    if shown.others:
        other_residuals_panel(panels["e"], shown)
        other_spectra_panel(panels["f"], shown)
    letters(panels.values())
    legend_below(body, panels.values(), columns=3)
    caption = _caption(shown, bool(estimates.get(main)), lines_subtracted)
    return Picture(body, f"{caption} {remarks}".strip())


def _positive(allan: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Where there is a deviation that a logarithmic axis can show."""
    names = ("m", "tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
    columns = {name: np.asarray(allan[name], dtype=np.float64) for name in names}
    keep = np.isfinite(columns["adev_mm"]) & (columns["adev_mm"] > 0)
    return {name: values[keep] for name, values in columns.items()}


def _share(panels: Mapping[str, Axes]) -> None:
    """One x axis a column, its label below the last panel; labels of y in line."""
    for column, label in (("ace", "Averaging time τ (s)"), ("bdf", "Frequency (Hz)")):
        own = [panels[name] for name in column if name in panels]
        own[-1].set_xlabel(label)
        for axes in own[1:]:
            axes.sharex(own[0])
        for axes in own[:-1]:
            axes.tick_params(labelbottom=False)
    for axes in panels.values():
        axes.yaxis.set_label_coords(LABEL_AT, 0.5)


def _caption(shown: Shown, estimated: bool, lines_subtracted: bool) -> str:
    """What the panels show, what was not detected, and what the signs mean."""
    fit = shown.fit
    told = [captions.FIT, captions.OTHER_FITS if shown.others else ""]
    told.append("" if estimated else f"No estimate by {fit.estimator}.")
    if fit.absent:
        told.append(f"Not detected (95 % limits): {', '.join(fit.absent)}.")
    if fit.under:
        told.append(
            f"Under the noise: {fit.under}; subtracted from the spectrum; part of the Allan "
            "deviation of the data and of the model."
        )
    classes = [
        f"{part.name.split()[-1]} {correlation_class(part.component.T_c)}"
        for part in fit.parts
        if isinstance(part.component, GaussMarkov)
    ]
    if classes:
        told.append(f"{captions.GAUSS_MARKOV} {', '.join(classes)}.")
    if fit.model.lines:
        gone = ", which it was subtracted from" if lines_subtracted else ""
        told.append(f"The stem at f_0 is as high as the sinusoid would raise its bin{gone}.")
    return " ".join(filter(None, told))
