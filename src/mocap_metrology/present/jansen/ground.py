"""What a drawing covers of its page, and free places for names on it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

SAMPLE_MM = 0.5
CLEAR_MM = 0.7  # round a name
FAR = 0.35  # a millimetre from the wished place weighs as much as this length of line covered
ON_TEXT = 6.0  # weight of a square millimetre of another name
TURNS_RAD = np.radians(np.arange(0, 360, 22.5))
REACHES_MM = (1.0, 2.0, 3.5, 5.0, 7.0, 9.5, 12.0)


class Ground:
    """Lines, dots and names on a page of this width and height, in mm from its lower left corner,
    kept as points with weights: the length of line that each stands for."""

    def __init__(self, size_mm: tuple[float, float]) -> None:
        self.size_mm = np.array(size_mm)
        self._points = [np.zeros((0, 2))]
        self._weights = [np.zeros(0)]

    def line(self, points: np.ndarray, weight: float = 1.0) -> None:
        """A line through points (n, 2)."""
        for start, end in pairwise(points):
            n = max(int(np.ceil(np.linalg.norm(end - start) / SAMPLE_MM)), 1)
            self.dots(start + (end - start) * np.linspace(0, 1, n + 1)[:, None], weight * SAMPLE_MM)

    def dots(self, points: np.ndarray, weight: float = 1.0) -> None:
        self._points.append(points)
        self._weights.append(np.full(len(points), weight))

    def box(self, centre: np.ndarray, width: float, height: float) -> None:
        """A name about its centre."""
        x, y = (np.linspace(-s / 2, s / 2, int(np.ceil(s)) + 1) for s in (width, height))
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        self.dots(centre + grid, ON_TEXT)

    def free(self, wished: np.ndarray, width: float, height: float) -> np.ndarray:
        """The place (2,) near one of the wished ones (k, 2) where a name of this width and height
        covers the least; on the page where it can be."""
        ring = np.column_stack([np.cos(TURNS_RAD), np.sin(TURNS_RAD)])
        offsets = np.vstack([np.zeros((1, 2)), *(reach * ring for reach in REACHES_MM)])
        places = (wished[:, None] + offsets).reshape(-1, 2)
        away = np.tile(np.linalg.norm(offsets, axis=1), len(wished))
        half = np.array([width, height]) / 2
        points, weights = np.vstack(self._points), np.concatenate(self._weights)
        apart = np.abs(places[:, None] - points[None])
        covered = ((apart < half + CLEAR_MM).all(axis=2) * weights).sum(axis=1)
        beyond = np.maximum(half - places, places + half - self.size_mm).max(axis=1)
        return places[np.argmin(covered + FAR * away + 1e3 * np.maximum(beyond, 0.0))]
