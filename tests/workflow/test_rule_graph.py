"""The rule graph of the pages is what Snakemake draws."""

import subprocess
import sys
from xml.etree import ElementTree

from rule_graph import GROUPS, in_columns, shipped
from running import environment


def test_the_page_shows_the_rules_there_are(root, tmp_path) -> None:
    command = [sys.executable, str(root / "workflow/rule_graph.py"), "--check"]
    done = subprocess.run(command, cwd=tmp_path, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.iterdir())
    picture = ElementTree.parse(root / "docs/rule_graph.svg").getroot()
    words = {text.text for text in picture.iter("{http://www.w3.org/2000/svg}text")}
    assert {"clean_twin", "noise", "skurowski"} <= words


def test_an_edge_goes_past_the_boxes_between_its_ends() -> None:
    """a to c directly, beside a way of three rules; e is alone."""
    edges = [("a", "b"), ("b", "d"), ("d", "c"), ("a", "c")]
    columns, ways = in_columns("abcde", edges)
    assert [len(names) for names in columns] == [2, 2, 2, 1]
    for way, edge in zip(ways, edges, strict=True):
        assert (way[0], way[-1]) == edge
        first = next(k for k, names in enumerate(columns) if way[0] in names)
        assert all(name in columns[first + k] for k, name in enumerate(way))


def test_rows_of_the_user_are_none_of_the_projects() -> None:
    """It came with 33 recordings and 110 calibrations; what a user adds is in neither group."""
    for sheet, least in (("recordings", 33), ("calibrations", 110)):
        rows = shipped(sheet)
        assert len(rows) >= least
        assert {row["group"] for row in rows} == GROUPS[sheet]
        assert all(row["path"].startswith("simulate:") for row in rows)
