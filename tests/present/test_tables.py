"""Tables: what stands for a published row, empty series, and what a reader of Markdown sees."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.papers.gaussian_table import table_4
from mocap_metrology.present import tables
from mocap_metrology.present.groups import group_tables
from mocap_metrology.present.skurowski import camera_tables
from mocap_metrology.present.tables import as_printed, readable
from mocap_metrology.present.text.numbers import duration_words


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
    third = next(r for r in camera_tables.table_3(rows) if r["regenerated"])
    fourth = table_4(rows, {"b": {"mu_1_mm": 1.0}}, {})[0]
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
        "edf": np.array([20.0, 10.0]),
    }
    first, second = group_tables.allan_summary("r", "measured", columns, ["x1", "L"])
    assert list(first) == list(second)
    assert (first["adev_min_mm"], first["tau_min_s"]) == (0.1, 0.1)
    assert second["series"] == "L"
    assert second["adev_min_mm"] is None


def test_markdown_escapes_and_rounds() -> None:
    text = tables.markdown([{"a|b": 1, "value": 1 / 3}, {"a|b": "x|y", "value": None}], "T", "C")
    assert "0.33333 |" in text
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


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ((1 / 120,), "0.0083333"),
        ((160.58,), "160.58"),
        ((1.88359e-5,), "1.88×10⁻⁵"),
        ((600.0,), "600"),
        ((0.0,), "0"),
        ((-math.inf,), "-inf"),
        ((math.nan,), ""),
        ((166.6, "mu_1_mm"), "166.6000"),
        ((0.0005, "sigma_1_mm"), "0.0005"),
        ((0.00012344, "sigma_C_mm"), "0.000123"),  # four decimals are not enough
        ((0.192, "rho_12"), "0.1920"),
        ((5.196016e-28, "chi2_p"), "< 10⁻⁶"),
        ((0.8628132, "p"), "0.863"),
        ((1e-7, "tau_p_s"), "1.00×10⁻⁷"),  # no probability
        ((-1.1e-14, "deviation_percent"), "0"),
        ((-13.0417, "deviation_percent"), "-13"),
        ((278.152, "allowed_percent"), "278"),
        ((2.975985e-18, "regenerated", 0.0), "0"),  # a slope published as 0
        ((6.600157, "regenerated", 2 * math.pi**2 / 3), "6.600157"),
    ],
)
def test_numbers_to_read(given: tuple, text: str) -> None:
    assert readable(*given) == text


def test_table_4_is_shown_as_printed(root) -> None:
    """Every number of S Table 4 with the digits of the file it was typed into, as many beside."""
    lines = (root / "src/mocap_metrology/reference/gaussian_model_table4.csv").read_text("utf-8")
    head, *rows = (line.split(",")[:-1] for line in lines.splitlines())
    for kind, *printed in rows:
        values = published_gaussian(kind)
        shown = [
            {"quantity": name, "published": values[name], "regenerated": 160.6, "residual": 1.5e-5}
            for name in head[1:]
        ]
        text = tables.markdown(shown, "T", "C").splitlines()[6:]
        cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text]
        assert [row[1] for row in cells] == printed
        assert {row[2] for row in cells} == {"160.6000"}
        assert {row[3] for row in cells} == {"1.50×10⁻⁵"}
    assert as_printed(1.4e-6) == "1.40×10⁻⁶"


def test_the_length_of_twins_stands_where_they_are_named() -> None:
    twins = {"a": "twin", "b": "twin"}
    assert tables.source_sentence(twins) == (
        "All recordings are twins: simulated, from published or configured numbers."
    )
    assert "twins of 10 min (S: nine hours): simulated" in tables.source_sentence(twins, 600.0)
    assert "twins of nine hours: simulated" in tables.source_sentence(twins, 32400)
    mixed = tables.source_sentence(twins | {"c": "measured"}, 20.0)
    assert mixed == "Simulated (twins of 20 s (S: nine hours)): a, b; the others are measured."
    assert tables.source_sentence({"c": "measured"}, 20.0) == "All recordings are measured."
    assert [duration_words(s) for s in (32400, 7200, 600)] == ["nine hours", "2 h", "10 min"]
