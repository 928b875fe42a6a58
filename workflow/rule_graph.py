"""Update the rule graph in docs: `python workflow/rule_graph.py`, or with --check.

Snakemake lists the edges (`--rulegraph mermaid-js`) of the default sheets, without what a user has
added to them, in a folder of its own. Left out are the rules that read from almost all others, and
every edge that a longer path implies.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.recordings import RecordingRow
from scipy.sparse import csgraph

from mocap_metrology.common import sheets

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs/rule_graph.svg"
LAST = {"default", "gate", "all", "provenance", "pages"}
COLUMN, BOX, ROW, LETTERS, SWEEPS = 162, 128, 46, 17, 12  # sizes in pixels, letters a line
HEAD = """\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="{size}" font-family="sans-serif" font-size="14">
<style>path {{ fill: none; stroke: #4b5563; marker-end: url(#tip) }}
rect {{ fill: #eef2ff; stroke: #4338ca }} text {{ text-anchor: middle; fill: #111827 }}</style>
<marker id="tip" refX="9" refY="4" markerWidth="10" markerHeight="8" orient="auto">
<path d="M0 0L9 4L0 8z" style="fill: #4b5563; stroke: none; marker: none"/></marker>
<rect x="-10" y="-5" width="100%" height="100%" style="fill: #fff; stroke: none"/>
{lines}
</svg>
"""
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
    """Write sheets of these rows; returns the values of `--config` that use them."""
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


def rules_of(mermaid: str) -> tuple[set[str], list[tuple[str, str]]]:
    """The rules to draw of a graph of Snakemake's, and the edges from the rule that makes a file to
    the one that reads it."""
    named = re.findall(r"^\s*(id\d+)\[(\w+)\]", mermaid, re.M)
    names = {node: re.sub(r"_\d+$", "", name) for node, name in named}  # one of a loop of rules
    links = {(names[a], names[b]) for a, b in re.findall(r"(id\d+) --> (id\d+)", mermaid)}
    edges = shortest({edge for edge in links if not LAST & set(edge)})
    return set(names.values()) - LAST, edges


def in_columns(
    rules: Iterable[str], edges: Sequence[tuple[str, str]]
) -> tuple[list[list[str]], list[list[str]]]:
    """Columns of names, a rule right of all that it reads from, and each edge as the names that it
    passes: itself in the columns between its ends, so that it passes the boxes there."""
    column: dict[str, int] = {}

    def place(name: str) -> int:
        if name not in column:
            column[name] = 1 + max((place(a) for a, b in edges if b == name), default=-1)
        return column[name]

    for name in rules:
        place(name)
    ways = []
    for a, b in edges:
        between = range(column[a] + 1, column[b])
        ways.append([a, *(f"{a} {b} {k}" for k in between), b])
        column |= {f"{a} {b} {k}": k for k in between}
    columns = [sorted(n for n in column if column[n] == k) for k in range(max(column.values()) + 1)]
    joined = {step for way in ways for step in pairwise(way)}
    for sweep in range(2 * SWEEPS):  # each column in the order of its neighbours, there and back
        back = sweep % 2
        for one, beside in pairwise(columns[::-1] if back else columns):
            order = {name: k / len(one) for k, name in enumerate(one)}

            def middle(name: str, order: dict[str, float] = order, back: int = back) -> float:
                near = [order[s[back]] for s in joined if s[1 - back] == name]
                return sum(near) / len(near) if near else 0.5

            beside.sort(key=middle)
    return columns, ways


def svg(rules: Iterable[str], edges: Sequence[tuple[str, str]]) -> str:
    """The picture of rules and edges."""
    columns, ways = in_columns(rules, edges)
    height = ROW * max(map(len, columns))
    at = {}
    for k, names in enumerate(columns):
        for row, name in enumerate(names):
            at[name] = COLUMN * k, height * (row + 0.5) / len(names)
    lines = []
    for way in ways:
        x, y = at[way[0]]
        path = f"M{x + BOX:.0f} {y:.0f}"
        for k, step in enumerate(way[1:], 1):
            (left, _), (right, down) = at[way[k - 1]], at[step]
            left, mid = left + BOX, (left + BOX + right) / 2
            path += f"C{mid:.0f} {y:.0f} {mid:.0f} {down:.0f} {right:.0f} {down:.0f}"
            y = down
            path += "" if step == way[-1] else f"h{BOX}"
        lines.append(f'<path d="{path}"/>')
    for name in (name for names in columns for name in names if " " not in name):
        x, y = at[name]
        lines.append(f'<rect x="{x}" y="{y - 19:.0f}" width="{BOX}" height="38" rx="6"/>')
        words = textwrap.wrap(name.replace("_", "_ "), LETTERS)
        for k, text in enumerate(words):
            down = y + 5 + 15 * (k - (len(words) - 1) / 2)
            lines.append(f'<text x="{x + BOX / 2}" y="{down:.0f}">{text.replace("_ ", "_")}</text>')
    size = f"-10 -5 {COLUMN * (len(columns) - 1) + BOX + 20} {height + 10}"
    return HEAD.format(size=size, lines="\n".join(lines))


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
    return svg(*rules_of(done.stdout))


def main() -> int:
    parser = argparse.ArgumentParser(prog="rule_graph.py", description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only check whether it is current")
    only_check = parser.parse_args().check
    new = drawn()
    if only_check:
        same = PICTURE.is_file() and PICTURE.read_text(encoding="utf-8") == new
        if not same:
            print(f"{PICTURE.name}: the rule graph is not current; run make graph", file=sys.stderr)
        return int(not same)
    PICTURE.write_text(new, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
