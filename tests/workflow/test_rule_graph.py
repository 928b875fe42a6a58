"""The rule graph in the README is what Snakemake draws."""

from __future__ import annotations

import subprocess
import sys

from running import environment


def test_the_readme_shows_the_rules_there_are(root) -> None:
    command = [sys.executable, "workflow/rule_graph.py", "--check"]
    done = subprocess.run(command, cwd=root, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text = (root / "README.md").read_text(encoding="utf-8")
    assert "simulate_recording --> trajectories" in text and "clean --> allan" in text
