"""Redraw the rule graph in docs: `python workflow/rule_graph.py`. Needs Graphviz.

Snakemake lists the edges (`--rulegraph`). Left out are the rules that read from almost all others,
and every edge that a longer path implies (`tred`).
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs/rule_graph.svg"
LAST = {"default", "gate", "all", "provenance", "pages"}
STYLE = """rankdir=LR; bgcolor=white; ranksep=0.4; nodesep=0.15
node [shape=box, style="rounded,filled", fontname="sans-serif", color="#4338ca",
fillcolor="#eef2ff"]
edge [color="#4b5563"]"""


def output_of(command: list[str], text: str = "") -> str:
    """What a program writes when it reads `text`; a program that fails ends this one."""
    try:
        done = subprocess.run(command, cwd=ROOT, input=text, capture_output=True, text=True)
    except FileNotFoundError:
        sys.exit(f"{command[0]} is not installed; expected Graphviz (apt-get install graphviz)")
    if done.returncode:
        sys.exit(done.stderr.strip().splitlines()[-1])
    return done.stdout


def lines_of(graph: str) -> list[str]:
    """Rules of a graph of Snakemake's, and edges from the rule that makes a file to the one that
    reads it; rules that a loop has made are one."""
    names = dict(re.findall(r'^\s*(\d+)\[label = "(\w+?)(?:_\d+)?"', graph, re.M))
    links = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", graph)}
    edges = {f"{a} -> {b}" for a, b in links if not LAST & {a, b}}
    return sorted(set(names.values()) - LAST) + sorted(edges)


def main() -> None:
    argparse.ArgumentParser(prog="rule_graph.py", description=__doc__.splitlines()[0]).parse_args()
    how = ["--workflow-profile", "profiles/ci", "--rulegraph", "dot"]
    lines = [STYLE, *lines_of(output_of([sys.executable, "-m", "snakemake", *how]))]
    graph = output_of(["tred"], "digraph rules {\n" + "\n".join(lines) + "\n}\n")
    PICTURE.write_text(output_of(["dot", "-Tsvg"], graph), encoding="utf-8")


if __name__ == "__main__":
    main()
