"""What the signs in a figure mean: samples with a word each, outside of the axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mocap_metrology.present.drawing.style import SMALL_PT, Keywords, Look, Sheet, lines_mm, text_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SAMPLE_MM = 8.0
TEXT_MM = SAMPLE_MM + 1.5  # where the text begins
BETWEEN_MM = 4.5
ROW_MM = lines_mm(1, SMALL_PT) + 0.6


@dataclass(frozen=True)
class Entry:
    """A text and its sample: a `patch` or a `line` or a `dot`, by the arguments it is drawn with,
    or a `look`."""

    text: str
    patch: Keywords | None = None
    line: Keywords | None = None
    dot: Keywords | None = None
    look: Look | None = None

    @property
    def width_mm(self) -> float:
        return TEXT_MM + text_mm(self.text, SMALL_PT)

    def draw(self, canvas: Axes, left: float, middle: float) -> None:
        """Onto a canvas in mm, from `left`, about the height `middle`."""
        from matplotlib.patches import Rectangle

        ends, centre = [left, left + SAMPLE_MM], left + SAMPLE_MM / 2
        if self.patch is not None:
            corner = (left, middle - ROW_MM * 0.3)
            canvas.add_patch(Rectangle(corner, SAMPLE_MM, ROW_MM * 0.6, **self.patch))
        if self.line is not None:
            canvas.plot(ends, [middle] * 2, **self.line)
        if self.dot is not None:
            canvas.plot([centre], [middle], ls="", **self.dot)
        if self.look is not None:
            canvas.plot(ends, [middle] * 2, color=self.look.colour, ls=self.look.dashes)
            canvas.plot(
                centre, middle, self.look.marker, color=self.look.colour, markerfacecolor="white"
            )
        canvas.text(left + TEXT_MM, middle, self.text, size=SMALL_PT, va="center_baseline")


def flow(entries: Sequence[Entry], width_mm: float) -> list[list[Entry]]:
    """Rows of entries, each row at most so wide."""
    rows: list[list[Entry]] = []
    used = width_mm
    for entry in entries:
        if not rows or used + entry.width_mm > width_mm:
            rows.append([])
            used = 0.0
        rows[-1].append(entry)
        used += entry.width_mm + BETWEEN_MM
    return rows


def strip_height(entries: Sequence[Entry], width_mm: float) -> float:
    """Height of a `strip`, in mm."""
    return len(flow(entries, width_mm)) * ROW_MM


def strip(sheet: Sheet, left: float, top: float, width: float, entries: Sequence[Entry]) -> None:
    """Draw entries side by side, in as many rows as they need."""
    rows = flow(entries, width)
    if not rows:
        return
    canvas = sheet.canvas(left, top, width, len(rows) * ROW_MM)
    for k, row in enumerate(rows):
        at = 0.0
        for entry in row:
            entry.draw(canvas, at, (len(rows) - k - 0.5) * ROW_MM)
            at += entry.width_mm + BETWEEN_MM


def columns_of(canvas: Axes, box: tuple[float, float], entries: Sequence[Entry]) -> float:
    """Draw entries one below the other from the canvas's upper left corner, in two columns if a box
    of that width and height holds them, else in one; return the height they take."""
    width, height = box
    n_rows = -(-len(entries) // 2)
    columns = [entries[:n_rows], entries[n_rows:]]
    widest = [max((entry.width_mm for entry in column), default=0.0) for column in columns]
    if sum(widest) + BETWEEN_MM > width:
        n_rows, columns = len(entries), [entries]
    left = 0.0
    for column, column_mm in zip(columns, widest, strict=False):
        for row, entry in enumerate(column):
            entry.draw(canvas, left, height - (row + 0.5) * ROW_MM)
        left += column_mm + BETWEEN_MM
    return n_rows * ROW_MM
