"""S Figures 14 to 16: power-law and correlated noises against the number of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.fit.estimates import (
    DEFAULT_ESTIMATOR,
    S_ESTIMATOR,
    correlation_class,
    unit_key,
)
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.present.groups import slots
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    log_axes,
    new_figure,
    say,
    styled,
)
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.coefficients import mathtext, unit
from mocap_metrology.present.text.numbers import power_of_ten

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST_Q_C = 1e-7  # mm/√s; smaller amplitudes are drawn in a band below it
LABEL_AT = -0.045, -0.105  # of y, linear and logarithmic: `align_ylabels` needs a second
HELD = 0.9  # share of the positive numbers within a linear axis
PALE = 0.4  # opacity of published terms below their least standard error
END: Keywords = {"color": INK, "lw": 0.7, "ls": (0, (4, 2)), "zorder": 0.8}
CAMERAS = dict(zip(slots.TYPES, LOOKS.values(), strict=True))
SOURCES = {
    "published": "published",
    "regenerated": S_ESTIMATOR,
    DEFAULT_ESTIMATOR: DEFAULT_ESTIMATOR,
}
Pair = tuple[float, float, str, bool]  # T_c, q_c, camera type, supported


@styled()
def colour_figure(
    rows: Sequence[Row], title: str, source: str, remarks: str = "", *, logarithmic: bool = True
) -> Picture:
    """Coefficients h_-2 ... h_2 of the rows of `table_a` (of any camera types), a block of panels a
    type: S Figure 14 (logarithmic) or 15 (linear, each panel to its own scale).

    source: the line at the foot; remarks: what the caption adds.
    """
    body = new_figure(title, source, 315.0)
    panels = body.subplots(len(slots.TYPES) * len(ALPHAS))
    for letter, kind, block in zip(
        "abc", slots.TYPES, panels.reshape(len(slots.TYPES), -1), strict=True
    ):
        cameras = cameras_of(rows, kind)
        for axes, alpha in zip(block, ALPHAS, strict=True):
            name = f"h_{alpha}"
            of_it = [r for r in rows if r["parameter"].split(" ")[0] == name]
            own = [r for r in of_it if r["camera_type"] == kind]
            slots.group_axis(axes, cameras, SERIES if axes is block[-1] else ())
            axes.tick_params(axis="x", which="both", labelbottom=axes is block[-1])
            axes.tick_params(axis="y", labelsize=SMALL_PT)
            if logarithmic:
                slots.floor_axis(axes, slots.floor_limits(of_it), ticks=3)
                slots.draw(axes, own, cameras, slots.raised)
            else:
                _linear(axes, own, cameras)
            axes.set_ylabel(f"{mathtext(name)}\n({unit(name)})", fontsize=SMALL_PT)
            axes.yaxis.set_label_coords(LABEL_AT[logarithmic], 0.5)
            if not own:
                say(axes, "no numbers")
        block[0].set_title(f"({letter}) {kind}")
        block[-1].set_xlabel("Number of cameras")
    slots.label_sources(panels[0])
    legend_below(body, [panels[0]])
    caption = captions.SKUROWSKI[14 if logarithmic else 15]
    return Picture(body, f"{caption} {remarks}")


def cameras_of(rows: Sequence[Row], kind: str) -> list[int]:
    """Numbers of cameras of one type."""
    return sorted({r["n_cameras"] for r in rows if r["camera_type"] == kind})


def _linear(axes: Axes, rows: Sequence[Row], cameras: Sequence[int]) -> None:
    """From zero up to nine tenths of the positive numbers, in units of a power of ten written
    beside the panel."""
    values = slots.column_values([r for r in rows if not slots.at_end(r)])
    values = values[np.isfinite(values) & (values > 0)]
    greatest = float(np.quantile(values, HELD)) if values.size else 0.0
    exponent = int(np.floor(np.log10(greatest))) if greatest > 0 else 0
    scale = 10.0**exponent
    top = 1.12 * greatest / scale if greatest > 0 else 1.0
    axes.set_ylim(-0.08 * top, top)
    slots.draw(axes, rows, cameras, lambda v: v / scale)
    if greatest > 0:
        how: Keywords = {"transform": axes.transAxes, "va": "top", "color": GREY, "size": SMALL_PT}
        axes.text(1.01, 1.0, f"×{power_of_ten(exponent)}", **how)


@styled()
def correlated_figure(rows: Sequence[Row], title: str, source: str, remarks: str = "") -> Picture:
    """S Figure 16 of the rows of `table_a` (of any camera types): (a) T_c and q_c against the
    number of cameras, (b) q_c against T_c with the classes of S 4.6 shaded, a panel a source.

    source: the line at the foot; remarks: what the caption adds.
    """
    rows = with_classes([row for row in rows if row["parameter"][1:3] == "_c"])
    body = new_figure(title, source, 310.0)
    cells = body.add_gridspec(2 * len(slots.TYPES) + 1, 3, height_ratios=(3, 4) * 3 + (9,))
    wide = [body.add_subplot(cells[k, :]) for k in range(2 * len(slots.TYPES))]
    ends = searched_ends(rows)
    for k, axes in enumerate(wide):
        kind, name = slots.TYPES[k // 2], ("T_c", "q_c")[k % 2]
        cameras = cameras_of(rows, kind)
        of_it = [r for r in rows if unit_key(r["parameter"].split(" ")[0]) == name]
        slots.group_axis(axes, cameras, SERIES if k % 2 else ())
        axes.tick_params(axis="x", which="both", labelbottom=bool(k % 2))
        floor = LEAST_Q_C if name == "q_c" else slots.FLOOR
        slots.floor_axis(axes, slots.floor_limits(of_it, floor), ticks=4, floor=floor)
        for end in ends if name == "T_c" else ():
            axes.axhline(end, **END)
        own = [r for r in of_it if r["camera_type"] == kind]
        slots.draw(axes, own, cameras, partial(slots.raised, floor=floor))
        if not own:
            say(axes, "no numbers")
        axes.set_ylabel(f"{mathtext(name)} ({unit(name)})")
        axes.yaxis.set_label_coords(LABEL_AT[True], 0.5)
        if name == "T_c":
            axes.set_title(f"(a) {kind}")
        else:
            axes.set_xlabel("Number of cameras")
    scatter = [body.add_subplot(cells[-1, k]) for k in range(len(SOURCES))]
    _scatters(scatter, rows, ends)
    slots.label_sources(wide[0], classes=True)
    for kind, look in CAMERAS.items():
        how = look.line(ls="", markersize=3.6, label=f"(b) {kind}")
        scatter[0].plot([], [], **how)
    scatter[0].plot([], [], label="(b) end of the range searched", **END)
    scatter[0].fill([], [], color=FAINT, alpha=0.8, lw=0, label="(b) classes of $T_c$ (S 4.6)")
    legend_below(body, [wide[0], scatter[0]])
    return Picture(body, f"{captions.SKUROWSKI[16]} {remarks}")


def with_classes(rows: Sequence[Row]) -> list[Row]:
    """Rows of T_c and q_c, those of a limit of q_c with the class of T_c that it holds for."""
    times = {
        (r["camera_type"], r["n_cameras"], r["series"], r["parameter"][3:]): r["published"]
        for r in rows
        if r["parameter"].startswith("T_c")
    }
    found = []
    for r in rows:
        key = r["camera_type"], r["n_cameras"], r["series"], r["parameter"][3:]
        limit = r["parameter"].startswith("q_c") and r["likelihood_status"] == "not_detected"
        time = times.get(key) if limit else None
        found.append(r if time is None else r | {"limit_class": correlation_class(time)})
    return found


def searched_ends(rows: Sequence[Row]) -> list[float]:
    """The T_c, in s, at which the search of S's estimator ended: shortest and longest."""
    found = [row["regenerated"] for row in rows if _ended(row, "regenerated")]
    return sorted({min(found), max(found)}) if found else []


def _ended(row: Row, source: str) -> bool:
    return str(row["parameter"]).startswith("T_c") and bool(row[f"{source}_status"] == "at_bound")


def _at_end(rows: Sequence[Row], source: str) -> int:
    return sum(_ended(row, source) for row in rows)


def term_pairs(rows: Sequence[Row], source: str) -> list[Pair]:
    """(T_c, q_c, camera type, supported) of every Gauss-Markov term that `source`, a column of
    `table_a`, has both numbers of; `supported` is False where one is less than its least standard
    error."""
    found: dict[tuple[str, int, str, str], dict[str, Row]] = {}
    for row in (r for r in rows if r["parameter"][1:3] == "_c"):
        key = row["camera_type"], row["n_cameras"], row["series"], row["parameter"][3:]
        found.setdefault(key, {})[row["parameter"][:3]] = row
    pairs = []
    for (camera_type, *_), term in found.items():
        if len(term) == 2 and all(row[source] is not None for row in term.values()):
            supported = not any(row["supported"] is False for row in term.values())
            fine = supported or source != "published"
            pairs.append((term["T_c"][source], term["q_c"][source], camera_type, fine))
    return pairs


def _scatters(panels: Sequence[Axes], rows: Sequence[Row], ends: Sequence[float]) -> None:
    """q_c against T_c, a panel a source."""
    from matplotlib.ticker import LogLocator

    pairs = {source: term_pairs(rows, source) for source in SOURCES}
    every = [pair for some in pairs.values() for pair in some]
    x_limits, (low, high) = (log_limits([np.array([p[k] for p in every])]) for k in (0, 1))
    for axes, (source, name) in zip(panels, SOURCES.items(), strict=True):
        log_axes(axes, (x_limits, (low / 30, high * 30)))  # room for the words
        axes.xaxis.set_major_locator(LogLocator(numticks=4))  # a third of the page is narrow
        slots.shade_classes(axes, x_limits)
        for kind in CAMERAS:
            for fine in (False, True):
                own = [p[:2] for p in pairs[source] if p[2:] == (kind, fine)]
                if own:
                    _points(axes, np.array(own), (source == "published", fine), kind)
        at_end = _at_end(rows, source) if source == "regenerated" else 0
        for end in ends if at_end else ():
            axes.axvline(end, 0.07, 0.91, **END)
        how: Keywords = {"transform": axes.transAxes, "ha": "right", "va": "top", "size": SMALL_PT}
        text = f"{len(pairs[source])} terms" + (f", {at_end} at an end" if at_end else "")
        axes.text(0.98, 0.98, text, color=GREY, **how)
        axes.set(title=f"(b) {name}", xlabel="$T_c$ (s)")
        axes.tick_params(labelleft=axes is panels[0])
    panels[0].set_ylabel(f"$q_c$ ({unit('q_c')})")


def _points(axes: Axes, own: np.ndarray, of: tuple[bool, bool], kind: str) -> None:
    """Open where they are published, pale where they are below their least standard error."""
    hollow, fine = of
    how: Keywords = {"markerfacecolor": "none", "mew": 0.7} if hollow else {"mew": 0}
    how |= {"markersize": 3.6 if hollow else 3.0, "alpha": 1.0 if fine else PALE}
    look = CAMERAS[kind]
    axes.plot(*own.T, ls="", color=look.colour, marker=look.marker, **how)
