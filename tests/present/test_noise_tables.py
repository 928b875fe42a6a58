"""Coefficients of a group."""

from noise_data import DEFAULT, group

from mocap_metrology.present.groups.group_tables import COLUMNS, noise_markdown, noise_table
from mocap_metrology.present.tables import write_with
from mocap_metrology.present.text.numbers import with_interval


def test_markdown_has_a_block_a_recording(tmp_path) -> None:
    _, noise, _ = group([("T40", 10), ("Bonita", 2)])
    noise["empty"] = [row for row in noise["T40-10"] if row["estimator"] != DEFAULT][:3]
    rows = noise_table(noise, dict.fromkeys(noise, "twin"))
    text = noise_markdown(rows, "T", "C")
    assert [x for x in text.split("\n") if x.startswith("## ")] == [
        "## T40-10 (twin)",
        "## Bonita-2 (twin)",
        "## empty (twin)",
    ]
    assert f"No coefficients by {DEFAULT}." in text
    block = text.split("## ")[1]
    names = [x.split("|")[1].strip() for x in block.split("\n") if x.startswith("|")][2:]
    assert names[:7] == ["h_-2", "h_-1", "h_0", "h_1", "h_2", "q_c1", "T_c1"]
    assert names[-2:] == ["A_s", "f_0"]
    for row in (r for r in rows if r["recording"] == "T40-10" and r["estimator"] == DEFAULT):
        if row["status"] == "ok":
            shown = with_interval(row["value"], row["lower_95"], row["upper_95"])
            assert shown in block
    assert "< 1.00×10⁻¹¹" in block
    write_with(tmp_path / "n", rows, text, COLUMNS)
    write_with(tmp_path / "none", [], noise_markdown([], "T", "C"), COLUMNS)
    assert (tmp_path / "none.csv").read_text() == ",".join(COLUMNS) + "\n"
    assert "No coefficients." in (tmp_path / "none.md").read_text()
