"""Calling Snakemake, and reading what it says of its jobs."""

import os
import re
import sys
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from mocap_metrology.common.faults import Faults

UNDRAWN = Path(__file__).with_name("undrawn")


def command(*arguments: str) -> list[str]:
    """Snakemake of this environment, in plain lines."""
    plain = ("--workflow-profile", "profiles/ci")
    return [sys.executable, "-m", "snakemake", *plain, *arguments]


def side_by_side(*calls: Callable[[], Any]) -> list[Any]:
    """What the calls return; they run at once, as most of a dry-run is spent starting Snakemake."""
    with ThreadPoolExecutor(len(calls)) as pool:
        return [future.result() for future in [pool.submit(call) for call in calls]]


def environment(drawn: str = "") -> dict[str, str]:
    """The environment, without what would slow Snakemake down or change its settings; of the
    figures those are drawn that have `drawn` in their path, or all."""
    unwanted = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "SNAKEMAKE_PROFILE")
    kept = {key: value for key, value in os.environ.items() if key not in unwanted}
    return kept | ({"PYTHONPATH": str(UNDRAWN), "DRAWN": drawn} if drawn else {})


def planned(output: str) -> Counter:
    """Jobs of each rule, from the table of a dry-run."""
    table = output.partition("Job stats:")[2].partition("Reasons:")[0]
    counts = {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+)$", table, re.M)}
    counts.pop("total", None)
    return Counter(counts)


def pass_for_computed(run: Callable[..., Any], *arguments: str) -> None:
    """Let everything that a run with these arguments makes pass for computed: Snakemake marks empty
    files as its results, then those that checkpoints ask for."""
    now_s = time.time()
    for _ in range(2):
        for line in run("--summary", *arguments).stdout.splitlines():
            path, *others = line.split("\t")
            if len(others) < 4 or path == "output_file" or Path(path).exists():
                continue
            if not Path(path).suffix:  # a folder
                Path(path).mkdir(parents=True)
            else:
                Path(path).parent.mkdir(parents=True, exist_ok=True)
                Path(path).write_text("{}\n" if path.endswith(".json") else "")
            os.utime(path, (now_s, now_s))
    marked = run("--touch", "--forceall", "--cores", "1", *arguments)
    assert marked.returncode == 0, marked.stdout


def finished(output: str) -> Counter:
    """Jobs of each rule that finished in a run."""
    return Counter(re.findall(r"Finished jobid: \d+ \(Rule: (\w+)\)", output))


def write_sheet(folder: Path, header: list[str], *rows: dict[str, str]) -> str:
    """Write `sheet.tsv` and return its name; columns that a row does not name stay empty."""
    lines = ["\t".join(header)] + ["\t".join(row.get(c, "") for c in header) for row in rows]
    (folder / "sheet.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return "sheet.tsv"


def faults_of(call: Callable[..., Any], *given: Any, **cells: Any) -> list[str]:
    """The lines with which a call is refused."""
    with pytest.raises(Faults) as caught:
        call(*given, **cells)
    return caught.value.lines
