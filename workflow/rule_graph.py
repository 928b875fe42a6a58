"""Keep the rule graph in docs current: `python workflow/rule_graph.py`, or with --check.

Snakemake draws it (`--rulegraph mermaid-js`) of the default sheets, without what a user has added
to them, in a folder of its own; here rules get their names for ids and edges an order. The gate and
the provenance, to which everything leads, are left out, and so is every edge that a longer way says
too.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from mocap_workflow import sheets
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.recordings import RecordingRow
from scipy.sparse import csgraph

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/rule_graph.md"
BLOCK = re.compile(r"```mermaid\n.*?```", re.S)
LAST = {"default", "gate", "all", "provenance"}
GROUPS = {  # of the default sheets
    "recordings": {
        *("skurowski2019", "skurowski2019-crump", "skurowski2019-repaired"),
        "example-failing-camera",
    },
    "calibrations": {"jansen2019"},
}


def shipped(sheet: str) -> list[dict[str, str]]:
    """Rows of `recordings` or `calibrations` that the project came with: the twins of its groups.
    Cells by column, of every column there is."""
    kind = RecordingRow if sheet == "recordings" else CalibrationRow
    rows = sheets.read(ROOT / f"config/{sheet}.tsv", list(kind.columns()), kind.required())
    return [
        row.cells
        for row in rows
        if row.cells["group"] in GROUPS[sheet] and row.cells["path"].startswith("simulate:")
    ]


def write_shipped(folder: Path) -> list[str]:
    """Write sheets of these rows; what `--config` has to say to use them."""
    settings = []
    for sheet in GROUPS:
        rows, path = shipped(sheet), folder / f"{sheet}.tsv"
        lines = ["\t".join(rows[0])] + ["\t".join(row.values()) for row in rows]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        settings.append(f"{sheet}={path}")
    return settings


def shortest(edges: set[tuple[str, str]]) -> list[tuple[str, str]]:
    """The edges, in order, without those whose ends a way through other rules joins, too."""
    names = sorted({name for edge in edges for name in edge})
    direct = np.array([[(a, b) in edges for b in names] for a in names])
    away = csgraph.shortest_path(direct, unweighted=True)
    longer = direct @ (np.isfinite(away) & (away > 0))
    return [(names[a], names[b]) for a, b in np.argwhere(direct & ~longer)]


def graph(mermaid: str) -> str:
    """A block of Markdown: an edge a line, from the rule that makes to the rule that reads."""
    names = dict(re.findall(r"^\s*(id\d+)\[(\w+)\]", mermaid, re.M))
    edges = {(names[a], names[b]) for a, b in re.findall(r"(id\d+) --> (id\d+)", mermaid)}
    edges = {edge for edge in edges if not LAST & set(edge)}
    kept = shortest(edges)
    alone = sorted(set(names.values()) - LAST - {name for edge in kept for name in edge})
    lines = ["```mermaid", "flowchart LR"]
    lines += [f"    {a} --> {b}" for a, b in kept] + [f"    {name}" for name in alone]
    return "\n".join([*lines, "```"])


def drawn() -> str:
    """What Snakemake draws now."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "profiles").symlink_to(ROOT / "profiles")
        how = ["--workflow-profile", "profiles/ci", "--rulegraph", "mermaid-js"]
        command = [sys.executable, "-m", "snakemake", "-s", str(ROOT / "Snakefile"), *how]
        command += ["--config", *write_shipped(folder)]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr.strip().splitlines()[-1])
    return graph(done.stdout)


def main() -> int:
    parser = argparse.ArgumentParser(prog="rule_graph.py", description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only tell whether it is current")
    only_check = parser.parse_args().check
    text = PAGE.read_text(encoding="utf-8")
    new = BLOCK.sub(lambda _old: drawn(), text, count=1)
    if only_check:
        if new != text:
            print(f"{PAGE.name}: the rule graph is not current; run make graph", file=sys.stderr)
        return int(new != text)
    PAGE.write_text(new, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
