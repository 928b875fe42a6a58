"""Made-up recordings for the tests of figures, and what every figure must satisfy."""

import xml.etree.ElementTree as ElementTree
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from mocap_metrology.present.plot.figure import save, styled

RATE = 120.0
ODD_TEXT = "a$b$_c^{2} -- <&> \\frac \x00\n\t é µ " + "unbroken" * 40


def recording(n: int, n_markers: int = 2, pairs: bool = True, seed: int = 1):
    """Raw, clean, outliers of white noise with spikes, in mm."""
    rng = np.random.default_rng(seed)
    names = [f"{axis}{k}" for k in range(1, n_markers + 1) for axis in "xyz"]
    names += ["L"] if pairs else []
    clean = {name: 100.0 + 0.02 * rng.standard_normal(n) for name in names}
    raw = {name: values.copy() for name, values in clean.items()}
    outliers = {name: rng.random(n) < 0.01 for name in names}
    for name in names:
        raw[name][outliers[name]] += 0.5
    return raw, clean, outliers


def every_text(picture) -> list[str]:
    """All text that the figure shows, as the user wrote it; and the caption of a `Picture`."""
    found = [
        text.get_text().replace("\\$", "$").replace("\xa0", " ").strip()
        for text in shown_texts(picture.figure)
    ]
    return [text for text in [*found, getattr(picture, "caption", "")] if text]


def shown_texts(figure) -> list[Text]:
    """Visible texts of visible axes: titles, labels, annotations, legends."""
    hidden = {text for axes in figure.axes if not axes.get_visible() for text in axes.findobj(Text)}
    return [text for text in figure.findobj(Text) if text.get_visible() and text not in hidden]


def check(picture, apart: bool = False) -> None:
    """Draw at a low resolution: no text leaves the page, labels of an axis do not touch; apart: no
    other text lies on another one either."""
    figure = picture.figure
    if figure.get_layout_engine():
        figure.set_dpi(80)
    canvas = FigureCanvasAgg(figure)
    with styled():
        figure.draw_without_rendering()
        extent = partial(Text.get_window_extent, renderer=canvas.get_renderer())
        page, slack = figure.bbox, 0.01 * figure.bbox.width  # hinting widens small text
        every_axis = [axis for axes in figure.axes for axis in axes._axis_map.values()]
        ticks = {
            text
            for axis in every_axis
            for text in [axis.offsetText, *axis.get_ticklabels(which="both")]
        }
        for text in [text for text in shown_texts(figure) if text not in ticks]:
            box = extent(text)
            if not text.get_text():
                continue
            assert page.x0 <= box.x0 and box.x1 <= page.x1 + slack, text.get_text()
            assert page.y0 <= box.y0 and box.y1 <= page.y1 + slack, text.get_text()
        groups = []
        for axis in every_axis:
            if not axis.get_visible() or not axis.axes.axison:
                continue
            labels = [
                axis.label,
                *(t.label1 for t in axis.get_major_ticks() if t.label1.get_visible()),
            ]
            groups.append([text for text in labels if text.get_text()])
        if apart:
            free = [text for owner in (figure, *figure.axes) for text in owner.texts]
            groups.append([text for text in free if text.get_text()])
        for texts in groups:
            # Squeezed by half a point, for the box holds room for descenders
            for one, other in combinations([extent(text).padded(-1) for text in texts], 2):
                assert not one.overlaps(other), [text.get_text() for text in texts]


def check_saved(figure, folder: Path) -> Path:
    """Save: both files are there, the SVG well-formed and small. Return the PNG."""
    folder.mkdir(exist_ok=True)
    svg, png = save(figure, folder / "figure")
    check(figure)
    assert sorted(path.name for path in folder.iterdir()) == ["figure.png", "figure.svg"]
    ElementTree.parse(svg)
    assert svg.stat().st_size < 1_000_000
    return png
