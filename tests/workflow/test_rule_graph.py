"""The rule graph of the pages is what Snakemake draws."""

from __future__ import annotations

import subprocess
import sys

from rule_graph import GROUPS, shipped
from running import environment


def test_the_page_shows_the_rules_there_are(root, tmp_path) -> None:
    command = [sys.executable, str(root / "workflow/rule_graph.py"), "--check"]
    done = subprocess.run(command, cwd=tmp_path, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.iterdir())
    text = (root / "docs/rule_graph.md").read_text(encoding="utf-8")
    assert "simulate_recording --> trajectories" in text and "clean --> allan" in text


def test_rows_of_the_user_are_none_of_the_projects() -> None:
    """It came with 33 recordings and 110 calibrations; what a user adds is in neither group."""
    for sheet, least in (("recordings", 33), ("calibrations", 110)):
        rows = shipped(sheet)
        assert len(rows) >= least
        assert {row["group"] for row in rows} == GROUPS[sheet]
        assert all(row["path"].startswith("simulate:") for row in rows)
