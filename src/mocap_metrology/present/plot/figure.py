"""One look for every figure of the project, and figures whose bytes repeat.

A figure function takes `Texts` and returns a `Picture`: matplotlib's figure in constrained layout,
and the caption, which pages show below it. Colours differ in lightness as much as in hue (CIE L*
about 20, 35 and 50), so that they differ in grey and for colour-blind readers; line style and
marker differ as well.
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from mocap_metrology.common.files import whole
from mocap_metrology.present.text.captions import Texts as Texts
from mocap_metrology.present.text.numbers import power_of_ten

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes  # which all modules of figures name
    from matplotlib.figure import Figure as Figure
    from matplotlib.figure import SubFigure as SubFigure
    from mpl_toolkits.mplot3d.axes3d import Axes3D as Axes3D

STYLE = Path(__file__).with_name("mocap.mplstyle")
WIDTH_MM = 170.0  # of a text column
MM = 1 / 25.4  # inch
DPI = 200  # of the PNG: twice what a screen shows at 100 %
PNG_LEVEL = 3  # of compression: files as small as by the usual 6, in two thirds of the time
IMAGE_DPI = 150  # of dense parts in an SVG, drawn as images; less on pages longer than this,
IMAGE_PAGE_MM = 190.0  # so that no SVG exceeds 1 MB
LINE, LINE_MM = 100, 4.0  # characters in a line of a title or a foot, and its height
LONGEST_WORD, LONGEST_NAME = 55, 28  # characters: of a line, of an entry of a legend
SMALL_PT = 7.5
ENTRY_MM, LETTER_MM = 12.0, 1.5  # of a legend: sample and space, and a letter of the text
MOST_MINOR = 2.5  # decades of an axis with ticks between them,
LABELLED = {"x": 1.2, "y": 2.2}  # and with labels at 2 and 5 too
LEAST_DECADES, MOST_DECADES = 0.8, 6  # of a logarithmic axis with ticks at 1, 2 and 5; labelled
NEAR_ONE = 5e-4, 5e3  # limits of an axis whose numbers are written out

INK, GREY, FAINT = "#222222", "#6b6b6b", "#d4d4d4"
UNIT = re.compile(r"(\d) (mm|µm|nm|%|s|min|h|Hz)(?!\w)")  # a number and its unit

Keywords = dict[str, Any]  # arguments of matplotlib by name, of as many types as it takes
BAND: Keywords = {"alpha": 0.18, "lw": 0}  # of an interval, in the colour of its curve
VERDICT_WORDS = {  # of a verdict: colour of text, colour behind it (contrast at least 4.5)
    "good": ("#14532d", "#dcfce7"),
    "precise": ("#1e3a8a", "#dbeafe"),
    "usable": ("#713f12", "#fef3c7"),
    "doubtful": ("#7c2d12", "#ffedd5"),
    "bad": ("#7f1d1d", "#fee2e2"),
    "failed": ("#7f1d1d", "#fee2e2"),
    "refused": ("#ffffff", "#991b1b"),
}
UNKNOWN_WORD = ("#1f2937", "#e5e7eb")  # a word that is none of these
UNITS = (("s", 1.0, 180.0), ("min", 60.0, 3 * 3600.0), ("h", 3600.0, np.inf))
MICROMETRES_BELOW_MM = 2.0  # median range of the axes


@dataclass(frozen=True)
class Look:
    """How one kind of series is drawn everywhere."""

    colour: str
    dashes: str | tuple[float, tuple[float, ...]] = "-"
    marker: str = ""

    def line(self, **more: Any) -> Keywords:
        """The arguments of `plot` that draw it, open markers."""
        style = {"color": self.colour, "ls": self.dashes, "marker": self.marker}
        return {**style, "markerfacecolor": "white", **more}


LOOKS = {
    "x": Look("#0d2a6b", "-", "o"),
    "y": Look("#962c10", (0, (5, 1.6)), "s"),
    "z": Look("#1a809d", (0, (6, 1.4, 1.4, 1.4)), "^"),
}
OTHER_LOOKS = (
    Look("#111111", "-", "D"),
    Look("#757575", (0, (5, 1.6)), "v"),
    Look("#4d4d4d", (0, (1.2, 1.2)), "P"),
    Look("#5f5f5f", (0, (6, 1.4, 1.4, 1.4)), "X"),
)


class Picture(NamedTuple):
    """A figure and the caption below it."""

    body: SubFigure
    caption: str

    @property
    def figure(self) -> Figure:
        """The whole, with title and foot."""
        return self.body.get_figure(root=True)


def import_matplotlib() -> None:
    """What drawing and saving import when they begin."""
    from matplotlib import figure, style  # noqa: F401
    from matplotlib.backends import backend_agg, backend_svg  # noqa: F401


@contextmanager
def styled() -> Iterator[None]:
    """The style, independent of the reader's matplotlibrc; also a decorator."""
    import matplotlib
    from matplotlib import style

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        style.use(STYLE)
        yield


def new_figure(texts: Texts, height_mm: float) -> SubFigure:
    """The empty body of a figure in constrained layout; call it within `styled`.

    Draw into the body as into a figure (`subplots`, `subplot_mosaic`, `subfigures`, `legend`): it
    is a part of its own since constrained layout would print a legend over the foot.
    """
    from matplotlib.figure import Figure

    title, source, _ = texts
    height_mm += sum(LINE_MM * (len(text) // LINE) for text in (title, source))
    figure = Figure(figsize=(WIDTH_MM * MM, height_mm * MM), layout="constrained")
    figure.set_label(plain(title))
    figure.suptitle(wrapped(title), x=0.01, ha="left", wrap=True)
    if source:
        how: Keywords = {"ha": "left", "fontsize": SMALL_PT, "color": GREY, "wrap": True}
        figure.supxlabel(wrapped(source), x=0.01, **how)
    return figure.add_subfigure(figure.add_gridspec(1, 1)[0])


def wrapped(text: str) -> str:
    """A text for matplotlib to wrap: words too long for a line are cut, a number and its unit stay
    together."""
    cut = re.sub(rf"(\S{{{LONGEST_WORD}}})(?=\S)", r"\1 ", plain(text))
    return literal(UNIT.sub("\\1\N{NO-BREAK SPACE}\\2", cut))


def plain(text: object) -> str:
    """One line of printable characters: what a label may hold and an SVG must."""
    return " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())


def literal(text: str) -> str:
    """A text in which a dollar sign begins no mathematics, nor an underscore a hidden label: for
    every name that a user gave."""
    return re.sub("^_", " _", text).replace("$", r"\$")


def clipped(name: str, most: int = LONGEST_NAME) -> str:
    """A user's name, cut to at most `most` characters, for which a legend has room."""
    name = plain(name)
    return name if len(name) <= most else f"{name[: most - 1]}…"


def short(name: str, most: int = LONGEST_NAME) -> str:
    """The same, literal."""
    return literal(clipped(name, most))


def panel_title(axes: Axes, title: str, remark: str = "") -> None:
    """A title over the left end of the axes and a short remark over the right end."""
    axes.set_title(title)
    if remark:
        how: Keywords = {"fontsize": SMALL_PT, "fontweight": "normal", "color": GREY}
        axes.set_title(remark, loc="right", **how)


def log_axes(axes: Axes, limits: tuple[tuple[float, float], tuple[float, float]]) -> None:
    """Both axes logarithmic, within the limits of x and of y."""
    log_axis(axes, "x", limits[0])
    log_axis(axes, "y", limits[1])


def log_axis(axes: Axes, which: Literal["x", "y"], limits: tuple[float, float]) -> None:
    """One axis logarithmic, two labels at least: at decades, at 2 and 5 too where there are few of
    them, in even steps within less than one. Numbers are written out where all are near 1."""
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

    axes.set(**{f"{which}scale": "log", f"{which}lim": limits})
    axis = axes.xaxis if which == "x" else axes.yaxis
    written_out = limits[0] > NEAR_ONE[0] and limits[1] < NEAR_ONE[1]
    low, high = np.log10(limits)
    few = math.floor(high) - math.ceil(low) < 1 or high - low <= LABELLED[which]
    decades = LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=MOST_DECADES)
    steps = MaxNLocator(4, steps=[1, 2, 5, 10], min_n_ticks=2)
    axis.set_major_locator(steps if high - low < LEAST_DECADES else decades)
    axis.set_major_formatter(FuncFormatter(lambda value, _: log_label(value, written_out)))
    axis.set_minor_formatter(NullFormatter())
    if not LEAST_DECADES <= high - low <= MOST_MINOR:  # ticks are artists, and slow
        axis.set_minor_locator(NullLocator())


def log_label(value: float, written_out: bool) -> str:
    """0.005, or 5×10⁻³ and 10⁻²."""
    if written_out or value <= 0:
        return f"{value:g}"
    exponent = math.floor(math.log10(value) + 1e-9)
    digits = f"{value / 10.0**exponent:.4g}"
    return power_of_ten(exponent) if digits == "1" else f"{digits}×{power_of_ten(exponent)}"


def room_for(values: Sequence[float], close: float) -> list[float]:
    """Those of ascending values that have room for a label on a logarithmic axis, the largest
    first: no two with a ratio of `close` or more."""
    shown = [values[-1]]
    for value in values[-2::-1]:
        if value < close * shown[-1]:
            shown.append(value)
    return shown


def letters(axes: Iterable[Axes]) -> None:
    """(a), (b), (c) before the titles of the panels, in this order."""
    for letter, one in zip("abcdefghijklmnopqrstuvwxyz", axes, strict=False):
        one.set_title(f"({letter}) {one.get_title(loc='left')}".rstrip())


def write_message(axes: Axes, text: str) -> None:
    """Words in the middle of axes that have nothing to show."""
    how: Keywords = {"ha": "center", "va": "center", "color": GREY, "wrap": True}
    axes.text(0.5, 0.5, text, transform=axes.transAxes, **how)


def legend_below(figure: Figure | SubFigure, axes: Iterable[Axes], columns: int = 6) -> None:
    """One legend of everything labelled in these axes, each text once, below them, in as many
    columns as there is room for, `columns` at most."""
    entries: dict[str, Any] = {}
    for one in axes:
        for handle, text in zip(*one.get_legend_handles_labels(), strict=True):
            entries.setdefault(text, handle)
    if entries:
        widths = [ENTRY_MM + LETTER_MM * len(re.sub(r"[$\\_{}]", "", text)) for text in entries]
        columns = min(columns, len(entries))  # filled one after the other, the first ones longer
        while columns > 1 and sum(map(max, np.array_split(widths, columns))) > WIDTH_MM:
            columns -= 1
        where: Keywords = {"loc": "outside lower left", "ncols": columns}
        figure.legend(list(entries.values()), list(entries), **where)


def finished(body: SubFigure, axes: Iterable[Axes], caption: str, columns: int = 6) -> Picture:
    """The picture of a body with one legend of these axes below it."""
    legend_below(body, axes, columns)
    return Picture(body, caption)


def words_picture(words: str, texts: Texts) -> Picture:
    """A figure that states why there is nothing to draw; call it within `styled`."""
    figure = new_figure(texts, 35.0)
    axes = figure.subplots()
    axes.axis("off")
    axes.text(0, 0.5, wrapped(words), va="center", wrap=True)
    return Picture(figure, words)


def save(picture: Picture, path: str | Path, png: bool = True) -> tuple[Path, Path]:
    """Write `<path>.svg` and `<path>.png`, both whole or neither, or the first alone; return their
    paths. `path` may be that of either.

    The caption goes into both as the description of the image (`caption_of`). No date, host or
    version goes in and SVG identifiers are hashes of the content, so the same figure gives the same
    bytes on one set of packages.
    """
    figure, stem = picture.figure, str(path).removesuffix(".svg").removesuffix(".png")
    svg, second = Path(f"{stem}.svg"), Path(f"{stem}.png")
    with styled(), whole(svg) as svg_part:
        _lay_out(figure)
        longer = max(figure.get_figheight() / MM / IMAGE_PAGE_MM, 1.0)
        how: Keywords = {"dpi": round(IMAGE_DPI / longer**0.5)}
        how["metadata"] = {"Date": None, "Creator": None, **_texts(picture)}
        figure.savefig(svg_part, format="svg", **how)
        if png:
            save_png(picture, second)
    return svg, second


@styled()
def save_png(picture: Picture, path: str | Path) -> None:
    """Write the PNG alone, as `save` does, in half of the time."""
    _lay_out(picture.figure)
    how: Keywords = {"dpi": DPI, "metadata": {"Software": None, **_texts(picture)}}
    with whole(path) as part:
        picture.figure.savefig(part, format="png", pil_kwargs={"compress_level": PNG_LEVEL}, **how)


def _lay_out(figure: Figure) -> None:
    """Once: else every `savefig` would lay it out and draw it twice."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    if engine := figure.get_layout_engine():
        figure.set_dpi(DPI)  # laid out as the PNG is drawn: hinting makes small text wider,
        FigureCanvasAgg(figure)  # by the same renderer, which measures every text once
        for axes in figure.axes:
            for axis, near, far in ((axes.xaxis, "bottom", "top"), (axes.yaxis, "left", "right")):
                if not axis.get_label_text():
                    axis.set_label_coords(0, 0)  # else its place is found at every look
                if axis.get_ticks_position() == near:
                    axes.spines[far].set_in_layout(False)  # which asks for all ticks
        engine.execute(figure)
        figure.set_layout_engine(None)


def _texts(picture: Picture) -> dict[str, str]:
    texts = {"Title": picture.figure.get_label(), "Description": plain(picture.caption)}
    return {key: str(text) for key, text in texts.items() if text}


def caption_of(image: str | Path) -> tuple[str, str]:
    """Title and caption of a saved SVG or PNG, empty where it has none."""
    if Path(image).suffix == ".svg":
        text = Path(image).read_text(encoding="utf-8").partition("</metadata>")[0]
        matches = (re.search(f"<{key}>(.*)</{key}>", text) for key in ("title", "dc:description"))
        title, caption = (html.unescape(one[1]) if one else "" for one in matches)
        return title, caption
    from PIL import Image

    with Image.open(image) as opened:
        texts = opened.info
    return str(texts.get("Title", "")), str(texts.get("Description", ""))


def coordinate_of(name: str) -> tuple[str, int] | None:
    """("x", 1) of "x1"; None of a distance or any other name."""
    match = re.fullmatch(r"([xyz])(\d+)", name)
    return (match[1], int(match[2])) if match else None


class TimeAxis(NamedTuple):
    """`per_frame`: time from frame to frame in the unit of the label."""

    label: str
    per_frame: float
    limits: tuple[float, float]


def time_axis(n_frames: int, frame_rate_hz: float) -> TimeAxis:
    """Seconds up to three minutes, minutes up to three hours, then hours."""
    duration = max(n_frames, 1) / frame_rate_hz
    symbol, seconds = next((u, s) for u, s, up_to in UNITS if duration <= up_to)
    return TimeAxis(f"Time ({symbol})", 1 / frame_rate_hz / seconds, (0.0, duration / seconds))


def length_unit(ranges_mm: Sequence[float]) -> tuple[str, float]:
    """µm where the typical axis spans less than 2 mm, else mm; and how many are a mm."""
    coarse = len(ranges_mm) and np.median(ranges_mm) >= MICROMETRES_BELOW_MM
    return ("mm", 1.0) if coarse else ("µm", 1000.0)


def date_axis(axes: Axes, most_ticks: int) -> None:
    """An x axis of days (matplotlib's numbers), labelled at so many at most."""
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

    locator = AutoDateLocator(minticks=2, maxticks=most_ticks)
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))


def name_axis(
    axes: Axes, names: Sequence[object], which: Literal["x", "y"] = "x", **how: Any
) -> None:
    """An axis of names at 0, 1, 2, ...: no ticks, no grid; y downwards."""
    axis, ends = getattr(axes, f"{which}axis"), (-0.5, max(len(names), 1) - 0.5)
    axes.set(**{f"{which}lim": ends if which == "x" else ends[::-1]})
    axis.set_ticks(range(len(names)), list(map(str, names)), **how)
    axis.set_tick_params(length=0)
    axis.grid(visible=False)
