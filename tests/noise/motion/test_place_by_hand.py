"""Noise of a length by place, of a few frames."""

import numpy as np
import pytest

from mocap_metrology.noise.motion.place import by_place, evenness

LENGTHS = np.array([1.0, 3, 2, 8, 4, 4, 7, np.nan, 5, 6])
X = np.array([5.0, 6, 7, 55, 56, 57, 58, 59, 9, 8])


def test_cells_their_pairs_and_their_means() -> None:
    """Of 50 mm: frames 0 to 2 and 8, 9 in the first, 3 to 6 in the second; pairs within a cell
    alone, none over a gap; deviations from the mean of all nine."""
    middle = np.array([X, 0 * X - 1, 0 * X + 120])
    first, second = by_place(middle, LENGTHS, 50.0, least=3)
    assert [first[f"{axis}_mm"] for axis in "xyz"] == [25.0, -25.0, 125.0]
    assert [second[f"{axis}_mm"] for axis in "xyz"] == [75.0, -25.0, 125.0]
    assert (first["n_frames"], first["n_pairs"]) == (5, 3)
    assert (second["n_frames"], second["n_pairs"]) == (4, 3)
    assert first["sigma_mm"] == pytest.approx(np.sqrt((4 + 1 + 1) / 6))
    assert second["sigma_mm"] == pytest.approx(np.sqrt((16 + 0 + 9) / 6))
    overall = np.nanmean(LENGTHS)
    assert first["deviation_mm"] == pytest.approx(17 / 5 - overall)
    assert second["deviation_mm"] == pytest.approx(23 / 4 - overall)
    bend = evenness([first, second])["bend_mm"]  # of two values, their distance over sqrt(2)
    assert bend == pytest.approx((23 / 4 - 17 / 5) / np.sqrt(2))
    assert by_place(middle, LENGTHS, 50.0, least=4) == []
    assert by_place(middle * np.nan, LENGTHS, 50.0, least=1) == []
