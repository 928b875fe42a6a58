"""S Figures 14 to 16: power-law and correlated noises against the number of cameras."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, S_ESTIMATOR, correlation_class
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.papers.coefficient_tables import searched_ends
from mocap_metrology.papers.subsets import TYPES
from mocap_metrology.present.groups import slots
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import FAINT, GREY, INK, SMALL_PT, Keywords, Picture
from mocap_metrology.present.skurowski.gaussian_figures import SETS
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.coefficients import mathtext, unit

LEAST_Q_C = 1e-7  # mm/√s; smaller amplitudes are drawn in a band below it
NUMBERS = (slots.PUBLISHED, slots.PALE, slots.S_VALUE, slots.VALUE)  # styles of no limits
HELD = 0.9  # share of the positive numbers within a linear axis
PALE = 0.4  # opacity of published terms below their least standard error
ROW_MM = 40.0
END: Keywords = {"color": INK, "lw": 0.7, "ls": (0, (4, 2)), "zorder": 0.8}
SOURCES = {"published": "published", S_ESTIMATOR: "regenerated", DEFAULT_ESTIMATOR: "likelihood"}


def marks_of(rows: Sequence[Row]) -> pd.DataFrame:
    """Marks of rows of `table_a`, with `camera_type` and `source` (a key of `SOURCES`). A limit of
    q_c is for the class of the published T_c of its term."""

    def term(row: Row) -> tuple[object, ...]:
        return row["camera_type"], row["n_cameras"], row["series"], row["parameter"][3:]

    times = {term(r): r["published"] for r in rows if r["parameter"].startswith("T_c")}
    marks = []
    for r in rows:
        T_c = times.get(term(r)) if r["parameter"].startswith("q_c") else None
        kind = correlation_class(T_c) if T_c else None
        published = slots.PALE if r["supported"] is False else slots.PUBLISHED
        ended = r["regenerated_status"] == "at_bound"
        numbers = [r[f"likelihood{end}"] for end in ("", "_lower_95", "_upper_95")]
        if r["likelihood"] is None and r["likelihood_status"] != "not_detected":
            numbers = [None, None, None]
        both = (
            slots.mark(r, published, r["published"]),
            slots.mark(r, slots.S_END if ended else slots.S_VALUE, r["regenerated"]),
            slots.estimate_mark(r, numbers, kind),
        )
        of_row = {"camera_type": r["camera_type"], "group": r["n_cameras"]}
        marks += [mark | of_row | {"source": k} for mark, k in zip(both, SOURCES, strict=True)]
    return slots.frame_of(marks)


@fig.styled()
def colour_figure(
    rows: Sequence[Row], source: str, remarks: str = "", *, logarithmic: bool = True
) -> Picture:
    """Coefficients h_-2 ... h_2 of the rows of `table_a`, a row of panels each, and a column a
    camera type: S Figure 14 (logarithmic) or 15 (linear, each panel to its own scale)."""
    marks = marks_of(rows)
    texts = captions.of_figure("skurowski", 14 if logarithmic else 15, source, remarks)
    body = fig.new_figure(texts, 42.0 + ROW_MM * len(ALPHAS))
    share: Keywords = {"sharex": "col", "sharey": "row" if logarithmic else False}
    grid = body.subplots(len(ALPHAS), len(TYPES), **share)
    _coefficients(grid, marks, [f"h_{alpha}" for alpha in ALPHAS], slots.FLOOR, logarithmic)
    slots.label_marks(grid[0, 0], marks[marks["coefficient"].str.startswith("h_")])
    return fig.finished(body, [grid[0, 0]], texts.caption, columns=3)


def _coefficients(
    grid: np.ndarray, marks: pd.DataFrame, names: Sequence[str], floor: float, logarithmic: bool
) -> None:
    """A row of panels a coefficient, a column a camera type, with their titles and labels."""
    for name, row in zip(names, grid, strict=True):
        of_it = marks[marks["coefficient"] == name]
        for kind, axes in zip(TYPES, row, strict=True):
            groups = sorted(marks.loc[marks["camera_type"] == kind, "group"].unique())
            of_kind = of_it[of_it["camera_type"] == kind]
            slots.group_axis(axes, groups)
            axes.tick_params(axis="both", labelsize=SMALL_PT)
            if logarithmic:
                slots.floor_axis(axes, of_it, floor)
            else:
                # From zero up to nine tenths of the positive numbers, in units of a power of ten
                numbers = of_kind.loc[of_kind["style"].isin(NUMBERS), "value"]
                greatest = numbers[numbers > 0].quantile(HELD) * 1.12
                top = float(greatest) if greatest > 0 else 1.0
                axes.set_ylim(-0.08 * top, top)
                axes.ticklabel_format(axis="y", style="sci", scilimits=(0, 0), useMathText=True)
                axes.yaxis.get_offset_text().set(fontsize=SMALL_PT - 0.5, color=GREY)
                axes.locator_params(axis="y", nbins=4)
            slots.draw(axes, of_kind, groups, SERIES, floor if logarithmic else -np.inf)
            if of_kind.empty:
                fig.write_message(axes, "no numbers")
        row[0].set_ylabel(f"{mathtext(name)} ({unit(name)})")
    for letter, kind, top, bottom in zip("abc", TYPES, grid[0], grid[-1], strict=True):
        top.set_title(f"({letter}) {kind}", pad=3.5 if logarithmic else 12.0)
        bottom.set_xlabel("Number of cameras")


@fig.styled()
def correlated_figure(rows: Sequence[Row], source: str, remarks: str = "") -> Picture:
    """S Figure 16 of the rows of `table_a`."""
    marks = marks_of(rows)
    marks = marks[marks["coefficient"].isin(["T_c", "q_c"])]
    texts = captions.of_figure("skurowski", 16, source, remarks)
    body = fig.new_figure(texts, 255.0)
    grid = body.subplots(3, len(TYPES), sharey="row", height_ratios=(3, 3, 4))
    _coefficients(grid[:2], marks, ("T_c", "q_c"), LEAST_Q_C, True)
    ends = searched_ends(rows)
    for axes in grid[0]:
        axes.tick_params(labelbottom=False)
        for end in ends:
            axes.axhline(end, **END)
    terms = slots.terms_of(marks)
    across, (low, high) = (log_limits([terms[name]]) for name in ("T_c", "q_c"))
    for letter, (name, axes) in zip("def", zip(SOURCES, grid[2], strict=True), strict=True):
        fig.log_axes(axes, (across, (low / 30, high * 30)))  # room for the words
        axes.tick_params(labelsize=SMALL_PT)
        slots.shade_classes(axes, across)
        of_source = terms[terms["source"] == name]
        _scatter(axes, of_source, hollow=name == "published")
        at_end = int((of_source["T_c_style"] == slots.S_END).sum())
        for end in ends if at_end else ():
            axes.axvline(end, 0.07, 0.91, **END)
        how: Keywords = {"transform": axes.transAxes, "ha": "right", "va": "top", "size": SMALL_PT}
        text = f"{len(of_source)} terms" + (f", {at_end} at an end" if at_end else "")
        axes.text(0.98, 0.98, text, color=GREY, **how)
        axes.set(title=f"({letter}) {name}", xlabel="$T_c$ (s)")
    grid[2, 0].set_ylabel(f"$q_c$ ({unit('q_c')})")
    slots.label_marks(grid[0, 0], marks)
    grid[2, 0].plot([], [], label="end of the range searched", **END)
    for kind in TYPES:
        grid[2, 0].plot([], [], **SETS[kind].line(ls="", markersize=3.6, label=f"(d)-(f) {kind}"))
    grid[2, 0].fill([], [], color=FAINT, alpha=0.8, lw=0, label="classes of $T_c$ (S 4.6)")
    return fig.finished(body, [grid[0, 0], grid[2, 0]], texts.caption, columns=3)


def _scatter(axes: fig.Axes, terms: pd.DataFrame, *, hollow: bool) -> None:
    """q_c against T_c: open where they are published, pale where one of both is below its least
    standard error."""
    pale = (terms["T_c_style"] == slots.PALE) | (terms["q_c_style"] == slots.PALE)
    for (kind, faint), of_kind in terms.groupby(["camera_type", pale], sort=False):
        look = SETS[str(kind)]
        how: Keywords = {"mfc": "none", "mew": 0.7, "ms": 3.6} if hollow else {"mew": 0, "ms": 3.0}
        how |= {"alpha": PALE if faint else 1.0, "color": look.colour, "marker": look.marker}
        axes.plot(of_kind["T_c"], of_kind["q_c"], ls="", **how)
