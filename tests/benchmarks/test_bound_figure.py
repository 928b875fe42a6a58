"""The figure of errors against the bound; its recordings take minutes to calibrate."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.bound_figure import figure
from mocap_metrology.common.files import write_csv


def test_errors_stand_beside_the_bound_of_their_recording(tmp_path: Path) -> None:
    """Errors twice and three times the bound in position, once and half of it in rotation."""
    rows = [
        {"setup": s, "recording": r, "bound_mm": (b := 0.5 + s + 0.1 * r), "batch_mm": 2 * b,
         "paper-lm_mm": 3 * b, "bound_deg": b / 9, "batch_deg": b / 9, "paper-lm_deg": b / 18}
        for s in range(10) for r in range(5)
    ]  # fmt: skip
    write_csv(tmp_path / "bound.csv", rows)
    position, _ = figure(tmp_path / "bound.csv").figure.axes
    lines = {line.get_label().split(":")[0]: line for line in position.lines}
    assert "batch: rms 2.00 times the bound in position, 1.00 in" in lines["batch"].get_label()
    assert "3.00 times the bound in position, 0.50 in" in lines["paper-lm"].get_label()
    (bars,) = position.collections
    ends = np.array([bar[:, 0] for bar in bars.get_segments()])
    x, y = lines["batch"].get_data()
    assert ((ends[:, 0] < x) & (x < ends[:, 1])).all()
    assert y == pytest.approx([2 * bar[0, 1] for bar in bars.get_segments()])
    assert (np.round(x) == np.repeat(np.arange(1, 11), 5)).all() and (
        ends[1:, 0] > ends[:-1, 1]
    ).all()
