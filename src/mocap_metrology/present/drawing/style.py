"""One look for every figure of the project, and figures whose bytes repeat.

Figures are drawn through the object-oriented interface, in millimetres: `blank_sheet` gives a page
as wide as a text column, with its title above and its note below. Colours differ in lightness as
much as in hue (CIE L* about 22, 50 and 67), so that a grey print and a colour-blind reader can tell
them apart; line style and marker say it once more.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mocap_metrology.common.files import whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType

WIDTH_MM = 170.0
MARGIN_MM = 2.0
MM = 1 / 25.4  # inch
POINT_MM = 25.4 / 72
DPI = 200  # of the PNG: twice what a screen shows at 100 %
IMAGE_DPI = 150  # of dense parts in an SVG, drawn as images; less on pages longer than this,
IMAGE_PAGE_MM = 190.0  # so that no SVG exceeds 1 MB
TITLE_PT, BODY_PT, SMALL_PT = 10.0, 8.5, 7.5
LINE_SPACING = 1.35
UNIT = re.compile(r"(\d) (mm|µm|%|s|min|h|Hz)(?!\w)")  # a number and its unit, kept in one line

INK = "#222222"
FAINT = "#d4d4d4"
GREY = "#6b6b6b"

Keywords = dict[str, Any]  # arguments of matplotlib by name, of as many types as it takes
VERDICT_WORDS = {  # of a verdict: colour of text, colour behind it (contrast at least 4.5)
    "good": ("#14532d", "#dcfce7"),
    "usable": ("#713f12", "#fef3c7"),
    "doubtful": ("#7c2d12", "#ffedd5"),
    "bad": ("#7f1d1d", "#fee2e2"),
    "failed": ("#7f1d1d", "#fee2e2"),
    "refused": ("#ffffff", "#991b1b"),
}
UNKNOWN_WORD = ("#1f2937", "#e5e7eb")  # a word that is none of these

FONT = ["DejaVu Sans"]  # comes with matplotlib, so every machine has the same
STYLE: dict[RcKeyType, Any] = {
    "font.family": FONT,
    "font.size": BODY_PT,
    "text.color": INK,
    "text.parse_math": False,  # a `$` or `_` in a label is only that
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.labelsize": BODY_PT,
    "axes.linewidth": 0.6,
    "axes.titlesize": BODY_PT,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.5,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "lines.markeredgewidth": 0.6,
    "svg.fonttype": "path",  # looks the same wherever it is opened
    "svg.hashsalt": "mocap-metrology",
}


@dataclass(frozen=True)
class Look:
    """How one kind of series is drawn everywhere."""

    colour: str
    dashes: str | tuple[float, tuple[float, ...]]
    marker: str


LOOKS = {
    "x": Look("#10307a", "-", "o"),
    "y": Look("#cf4a2c", (0, (5, 1.6)), "s"),
    "z": Look("#44b0cb", (0, (6, 1.4, 1.4, 1.4)), "^"),
}
OTHER_LOOKS = (
    Look("#111111", "-", "D"),
    Look("#7a7a7a", (0, (5, 1.6)), "v"),
    Look("#4d4d4d", (0, (1.2, 1.2)), "P"),
    Look("#a3a3a3", (0, (6, 1.4, 1.4, 1.4)), "X"),
)


@contextmanager
def styled() -> Iterator[None]:
    """The style, whatever the reader's own matplotlibrc says; also a decorator."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


def save_figure(figure: Figure, path: str | Path) -> tuple[Path, Path]:
    """Write `<path>.svg` and `<path>.png`, both whole or neither; return their paths. `path` may be
    that of either.

    No date, host or version goes in and SVG identifiers are hashes of the content, so the same
    figure gives the same bytes on one set of packages.
    """
    stem = str(path).removesuffix(".svg").removesuffix(".png")
    svg, png = Path(f"{stem}.svg"), Path(f"{stem}.png")
    title = {"Title": figure.get_label()} if figure.get_label() else {}
    longer = figure.get_figheight() / MM / IMAGE_PAGE_MM
    image_dpi = round(IMAGE_DPI / max(longer, 1.0) ** 0.5)
    with styled(), whole(svg) as svg_part, whole(png) as png_part:
        figure.savefig(
            svg_part,
            format="svg",
            dpi=image_dpi,
            metadata={"Date": None, "Creator": None, **title},
        )
        figure.savefig(png_part, format="png", dpi=DPI, metadata={"Software": None, **title})
    return svg, png


@dataclass(frozen=True)
class Sheet:
    """A figure measured in millimetres from the upper left corner of its body."""

    figure: Figure
    height_mm: float
    top_mm: float

    def axes(self, left: float, top: float, width: float, height: float) -> Axes:
        """Axes with that corner and size, in mm."""
        bottom = self.height_mm - self.top_mm - top - height
        box = (
            left / WIDTH_MM,
            bottom / self.height_mm,
            width / WIDTH_MM,
            height / self.height_mm,
        )
        return self.figure.add_axes(box)

    def canvas(self, left: float, top: float, width: float, height: float) -> Axes:
        """Empty axes whose data coordinates are mm from their lower left corner."""
        axes = self.axes(left, top, width, height)
        axes.set(xlim=(0, width), ylim=(0, height))
        axes.axis("off")
        return axes


def blank_sheet(body_mm: float, title: str, note: str) -> Sheet:
    """A page with `title` above and `note` small below a body `body_mm` high, both wrapped."""
    from matplotlib.figure import Figure

    width = WIDTH_MM - 2 * MARGIN_MM
    titles, notes = wrap(title, TITLE_PT, width, "bold"), wrap(note, SMALL_PT, width)
    top = MARGIN_MM + lines_mm(len(titles), TITLE_PT)
    foot = lines_mm(len(notes), SMALL_PT) + 2 * MARGIN_MM if notes else MARGIN_MM
    height = top + body_mm + foot
    figure = Figure(figsize=(WIDTH_MM * MM, height * MM), facecolor="white")
    figure.set_label(plain(title))
    left = MARGIN_MM / WIDTH_MM
    if titles:
        figure.text(
            left,
            1 - MARGIN_MM / height,
            "\n".join(titles),
            size=TITLE_PT,
            weight="bold",
            va="top",
            linespacing=LINE_SPACING,
        )
    if notes:
        figure.text(
            left,
            (foot - MARGIN_MM) / height,
            "\n".join(notes),
            size=SMALL_PT,
            color=GREY,
            va="top",
            linespacing=LINE_SPACING,
        )
    return Sheet(figure, height, top)


def words_figure(words: str, title: str, note: str) -> Figure:
    """A page that says in words why there is nothing to draw; call it within `styled`."""
    width = WIDTH_MM - 2 * MARGIN_MM
    lines = wrap(words, BODY_PT, width)
    height = lines_mm(len(lines), BODY_PT) + 2.0
    sheet = blank_sheet(height, title, note)
    canvas = sheet.canvas(MARGIN_MM, 1.0, width, height - 1.0)
    how: Keywords = {"size": BODY_PT, "va": "top", "linespacing": LINE_SPACING}
    canvas.text(0, height - 1.0, "\n".join(lines), **how)
    return sheet.figure


def label_axes(axes: Axes, x: str = "", y: str = "", x_mm: float = 7.5, y_mm: float = 11.5) -> None:
    """Axis labels so many mm off the axes (matplotlib would measure every tick label for it)."""
    width, height = size_mm(axes)
    if x:
        axes.set_xlabel(x, va="center")
        axes.xaxis.set_label_coords(0.5, -x_mm / height)
    if y:
        axes.set_ylabel(y, va="center")
        axes.yaxis.set_label_coords(-y_mm / width, 0.5)


def head(axes: Axes, title: str, remark: str = "") -> None:
    """A title over the left end of the axes, and a small remark over the right end."""
    width, height = size_mm(axes)
    above = 1 + 1.2 / height
    axes.text(0, above, title, transform=axes.transAxes, size=BODY_PT, weight="bold")
    room = width - text_mm(title, BODY_PT, "bold") - 3
    axes.text(
        1,
        above,
        shorten(remark, SMALL_PT, room),
        transform=axes.transAxes,
        ha="right",
        size=SMALL_PT,
        color=GREY,
    )


def say(axes: Axes, text: str) -> None:
    """Words in the middle of axes that have nothing to show."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=GREY)


def size_mm(axes: Axes) -> tuple[float, float]:
    """Width and height of axes in mm."""
    box, figure = axes.get_position(), axes.get_figure(root=True)
    if figure is None:
        raise ValueError("axes of no figure")
    return box.width * figure.get_figwidth() / MM, box.height * figure.get_figheight() / MM


def lines_mm(count: int, size_pt: float) -> float:
    """Height of so many lines of text, in mm."""
    return count * size_pt * LINE_SPACING * POINT_MM


def plain(text: object) -> str:
    """One line of printable characters: what a label may hold and an SVG must."""
    return " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())


@lru_cache(maxsize=4096)
def text_mm(text: str, size_pt: float, weight: str = "normal") -> float:
    """Width of a line of text in mm, from the font's own measures (the same for SVG and PNG)."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(family=FONT, size=size_pt, weight=weight)
    return text_to_path.get_text_width_height_descent(text, font, ismath=False)[0] * POINT_MM


def wrap(text: str, size_pt: float, width_mm: float, weight: str = "normal") -> list[str]:
    """Lines of at most `width_mm`; words that are too long by themselves are cut, a number and
    its unit stay together."""
    lines: list[str] = []
    for word in UNIT.sub("\\1\xa0\\2", plain(text)).split(" "):
        while (width := text_mm(word, size_pt, weight)) > width_mm and len(word) > 1:
            fit = max(int(len(word) * 0.95 * width_mm / width), 1)
            lines.append(word[:fit])
            word = word[fit:]
        joined = f"{lines[-1]} {word}" if lines else word
        if lines and text_mm(joined, size_pt, weight) <= width_mm:
            lines[-1] = joined
        else:
            lines.append(word)
    return [line.replace("\xa0", " ") for line in lines if line]


def shorten(text: str, size_pt: float, width_mm: float) -> str:
    """The text, or as much of its beginning as fits, and an ellipsis."""
    text = plain(text)
    if text_mm(text, size_pt) <= width_mm:
        return text
    while text and text_mm(f"{text}…", size_pt) > width_mm:
        text = text[:-1]
    return f"{text}…"


COORDINATE = re.compile(r"([xyz])(\d+)")


def coordinate_of(name: str) -> tuple[str, int] | None:
    """("x", 1) of "x1"; None of a distance or any other name."""
    found = COORDINATE.fullmatch(name)
    return (found[1], int(found[2])) if found else None


def tick_text(value: float) -> str:
    """As short as it can be, with a minus sign and not a hyphen."""
    return f"{value + 0.0:.10g}".replace("-", "−")
