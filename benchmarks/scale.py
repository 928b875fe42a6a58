"""Time and memory of every rule as recordings grow longer, get more markers, or become more.

    python -m benchmarks.scale hours 0.9 9 90       two markers at 120 Hz; needs 20 GB of disk
    python -m benchmarks.scale markers 2 10 100     ten minutes at 120 Hz
    python -m benchmarks.scale rows 100 1000        dry runs: simulated recordings, and files
    python -m benchmarks.scale hours 1 3 --csv docs/scale.csv    for scale_figure.py

The workflow runs on C3D files of white noise and a random walk. Prints CPU seconds and the largest
resident memory (GB) of each rule, from its benchmark file, and the run time of the whole; one CPU
core, so jobs run one after another. The tables are those of docs/scale.md. With --csv the costs of
a size also replace earlier ones of the same size in a CSV file.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks import ROOT, head, line
from mocap_metrology.io.c3d.write import write_c3d

RATE = 120.0  # Hz
CHUNK = 65_536  # frames
ENVIRONMENT = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
Cost = dict[str, tuple[float, float]]  # rule -> CPU seconds of all its jobs, GB of the largest
# Snakemake measures a job every 0.5 s, and after 15 s every 30 s: what follows would be missing.
SNAKEMAKE = """from snakemake import benchmark, cli
benchmark.BenchmarkTimer._times_called = property(lambda timer: 0, lambda timer, count: None)
cli.main()"""
COLUMNS = ("kind", "size", "rule", "cpu_s", "gb")


def recording(path: Path, seconds: float, n_markers: int, seed: int = 1) -> None:
    """A C3D file: markers 300 mm apart, white noise of 7 µm, a random walk of 0.01 µm a frame."""
    n, draw = round(seconds * RATE), np.random.default_rng(seed)
    start = 300.0 * np.arange(n_markers)[:, None] * np.ones(3)

    def chunks() -> Iterator[np.ndarray]:
        walk = np.zeros((1, n_markers, 3))
        for first in range(0, n, CHUNK):
            shape = (min(CHUNK, n - first), n_markers, 3)
            walk = walk[-1:] + np.cumsum(1e-5 * draw.standard_normal(shape), axis=0)
            yield (start + walk + 0.007 * draw.standard_normal(shape)).astype(np.float32)

    write_c3d(path, labels(n_markers), RATE, chunks(), n)


def labels(n_markers: int) -> list[str]:
    return [f"M{k}" for k in range(1, n_markers + 1)]


def run(
    folder: Path, rows: list[tuple[str, str, str]], *arguments: str, target: str = "all"
) -> float:
    """Run the workflow on rows (name, path, markers) of a sheet; its run time in s."""
    sheet = folder / "sheet.tsv"
    lines = ["recording\tpath\tmarkers\tgroup\tcamera_type\tn_cameras"]
    lines += ["\t".join((*row, "scale", "T40", "10")) for row in rows]
    sheet.write_text("\n".join(lines) + "\n", encoding="utf-8")
    settings = (f"recordings={sheet}", "calibrations=", f"results={folder / 'results'}")
    command = [
        *(sys.executable, "-c", SNAKEMAKE, "--cores", "1", "--quiet", "all"),
        *("--workflow-profile", ROOT / "profiles/ci", "--snakefile", ROOT / "Snakefile"),
        *("--directory", folder, "--config", *settings, *arguments, "--", target),
    ]
    begun = time.perf_counter()
    subprocess.run(command, env=ENVIRONMENT, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begun


def costs(results: Path) -> Cost:
    """Of every rule whose jobs left a benchmark file."""
    found: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for path in sorted((results / "benchmarks").glob("*/*.tsv")):
        with path.open(encoding="utf-8") as file:
            row = next(csv.DictReader(file, delimiter="\t"))
        cells = (row["cpu_time"], row["max_rss"])  # "-" of a job too short to be sampled
        cpu_s, rss_mb = (float(cell) if cell not in ("-", "NA") else 0.0 for cell in cells)
        found[path.parent.name].append((cpu_s, rss_mb / 1e3))
    return {
        rule: (sum(cpu for cpu, _ in jobs), max(gb for _, gb in jobs))
        for rule, jobs in found.items()
    }


def measured(kind: str, size: float) -> tuple[float, Cost]:
    """Run time of the workflow and cost of its rules for one size."""
    with tempfile.TemporaryDirectory(prefix="mocap-metrology-scale-") as name:
        folder = Path(name)
        n_markers, seconds = (2, 3600 * size) if kind == "hours" else (round(size), 600.0)
        recording(folder / "r0.c3d", seconds, n_markers, 0)
        seconds = run(folder, [("r0", "r0.c3d", ";".join(labels(n_markers)))])
        return seconds, costs(folder / "results")


def store(path: Path, kind: str, size: float, cost: Cost) -> None:
    """Replace the rows of this size, one a rule, in a CSV file."""
    rows: list[list[str]] = []
    if path.is_file():
        with path.open(encoding="utf-8", newline="") as file:
            rows = [row for row in list(csv.reader(file))[1:] if row[:2] != [kind, f"{size:g}"]]
    rows += [
        [kind, f"{size:g}", rule, f"{cpu:.1f}", f"{gb:.3f}"] for rule, (cpu, gb) in cost.items()
    ]
    rows.sort(key=lambda row: (row[0], float(row[1]), row[2]))
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])


def table(kind: str, sizes: list[float], path: Path | None) -> None:
    """Print the costs of every rule, a column a size."""
    found = []
    for size in sizes:
        found.append(measured(kind, size))
        if path is not None:
            store(path, kind, size, found[-1][1])
    head("rule", *(f"{size:g} {kind}: CPU s, GB" for size in sizes))
    for rule in dict.fromkeys(rule for _, cost in found for rule in cost):
        cells = (f"{c[rule][0]:.1f}, {c[rule][1]:.2f}" if rule in c else "" for _, c in found)
        line(f"`{rule}`", *cells)
    pairs = [list(zip(*cost.values(), strict=True)) for _, cost in found]
    line("all jobs", *(f"{sum(cpu):.0f}, {max(gb):.2f}" for cpu, gb in pairs))
    line("the whole run, s", *(f"{wall:.0f}" for wall, _ in found))


def dry_runs(sizes: list[float]) -> None:
    """Print how long Snakemake takes to plan, a column a number of rows."""
    head("dry run", *(f"{size:g} rows, s" for size in sizes))
    for kind in ("simulated", "files"):
        seconds = []
        for size in sizes:
            with tempfile.TemporaryDirectory(prefix="mocap-metrology-scale-") as name:
                folder, paths = Path(name), [f"r{k}.c3d" for k in range(round(size))]
                for path in paths if kind == "files" else []:
                    (folder / path).touch()
                rows = [(path[:-4], path, "M1;M2") for path in paths]
                if kind == "simulated":
                    rows = [(path[:-4], "simulate:T40-10", "") for path in paths]
                seconds.append(run(folder, rows, "--dry-run"))
        line(kind, *(f"{s:.1f}" for s in seconds))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=("hours", "markers", "rows"))
    parser.add_argument("size", nargs="+", type=float)
    parser.add_argument("--csv", type=Path, help="file of the costs that scale_figure.py draws")
    asked = parser.parse_args()
    if asked.kind == "rows":
        dry_runs(asked.size)
    else:
        table(asked.kind, asked.size, asked.csv)
