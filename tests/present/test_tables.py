"""Tables: what stands for a published row, empty series, and what a reader of Markdown sees."""

from __future__ import annotations

import numpy as np
import pandas as pd

from mocap_metrology.present import tables
from mocap_metrology.present.groups import tables as group_tables
from mocap_metrology.present.skurowski import subset_tables


def recording(name: str, twin: str | None, n_cameras: int = 10) -> dict:
    ids = list(range(n_cameras))
    return {
        "recording": name,
        "twin": twin,
        "camera_type": "T40",
        "n_cameras": n_cameras,
        "camera_ids": ids,
        "comment": "",
    }


def test_a_measured_recording_stands_before_a_twin_in_both_tables() -> None:
    rows = {"a": recording("a", "T40-10"), "b": recording("b", None), "c": recording("c", None)}
    third = next(r for r in subset_tables.table_3(rows) if r["regenerated"])
    fourth = subset_tables.table_4(rows, {"b": {"mu_1_mm": 1.0}})[0]
    assert (third["recording"], third["source"]) == ("b", "measured")
    assert (fourth["recording"], fourth["source"], fourth["regenerated"]) == ("b", "measured", 1.0)


def test_a_series_without_a_value_has_an_empty_row() -> None:
    columns = {
        "series": np.array(["x1", "x1"], dtype=object),
        "estimator": np.array(["oadev", "oadev"], dtype=object),
        **{
            name: np.array([0.1, 0.2])
            for name in ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
        },
    }
    first, second = group_tables.allan_summary("r", "measured", columns, ["x1", "L"])
    assert list(first) == list(second)
    assert (first["adev_min_mm"], first["tau_min_s"]) == (0.1, 0.1)
    assert second["series"] == "L"
    assert second["adev_min_mm"] is None


def test_markdown_escapes_and_rounds() -> None:
    text = tables.markdown([{"a|b": 1, "value": 1 / 3}, {"a|b": "x|y", "value": None}], "T", "C")
    assert "0.3333333 |" in text
    assert "x\\|y" in text
    assert text.startswith("# T\n\nC\n\n| a\\|b")


def test_rows_with_a_note_only_stand_beside_whole_ones(tmp_path) -> None:
    """Of what was refused a table holds the reason, in a row of its own, wherever it comes."""
    rows = [{"recording": "a", "note": "too short"}, {"recording": "b", "value_mm": 0.5}]
    for k, order in enumerate((rows, rows[::-1])):
        tables.write(tmp_path / str(k), order, "Title", "Caption.")
        found = pd.read_csv(tmp_path / f"{k}.csv", index_col="recording")
        assert found.loc["a", "note"] == "too short"
        assert np.isnan(found.loc["a", "value_mm"])
        assert found.loc["b", "value_mm"] == 0.5
        assert "None" not in (tmp_path / f"{k}.md").read_text(encoding="utf-8")
