"""The project beside its peers, in one run: CPU seconds on one thread, peak memory, ratios.

    make benchmark

Nine hours of two markers at 120 Hz: 3,888,000 frames, seven series. Every measurement runs in a
process of its own that is otherwise idle: CPU seconds of the work alone, imports and compilation
before it; the last row is the workflow's own jobs, imports and Parquet included.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ENVIRONMENT = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
ENVIRONMENT |= {f"{pool}_NUM_THREADS": "1" for pool in ("OMP", "OPENBLAS", "MKL", "NUMBA")}

PRELUDE = """
import json, resource, sys, time
import numpy as np
n = 3_888_000
rng = np.random.default_rng(1)
series = 166.6 + 0.007 * rng.normal(size=n) + 1e-5 * np.cumsum(rng.normal(size=n))
series[rng.integers(0, n, 400)] += 20
def report(cpu, **more):
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(json.dumps({"cpu_s": cpu, "peak_gb": peak, **more}))
"""

HAMPEL = """
from mocap_metrology.common.hampel import hampel
hampel(series[:1000], 120)
start = time.process_time(); found = hampel(series, 120); cpu = time.process_time() - start
wrong = 0
for i in [*range(130), *range(n - 130, n), *rng.integers(0, n, 1000)]:
    window = series[max(0, i - 120) : i + 121]
    median = np.median(window)
    out = abs(series[i] - median) > 3 * 1.4826 * np.median(np.abs(window - median))
    wrong += bool(found.outlier[i] != out or found.values[i] != (median if out else series[i]))
report(cpu, wrong=wrong, replaced=int(found.outlier.sum()))
"""
HAMPEL_PEER = """
from hampel import hampel
part = series[: n // 10].astype(np.float32)
start = time.process_time()
hampel(part, window_size=241, n_sigma=3.0)
report(10 * (time.process_time() - start))
"""
ALLAN = """
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
m = averaging_factors(n)
missing = float(sys.argv[1])
series[rng.random(n) < missing] = np.nan
allan_variance(series[:1000], m[:5])
start = time.process_time(); found = allan_variance(series, m); cpu = time.process_time() - start
np.save(sys.argv[2], found.variance)
report(cpu, taus=len(m))
"""
ALLAN_PEER = """
import allantools
from mocap_metrology.noise.allan.variance import averaging_factors
m = averaging_factors(n)
start = time.process_time()
_, deviation, _, _ = allantools.oadev(series, rate=1.0, data_type="freq", taus=m.astype(float))
cpu = time.process_time() - start
report(cpu, difference=float(np.abs(np.load(sys.argv[1]) / deviation**2 - 1).max()))
"""
C3D = """
from mocap_metrology.io.read import read_recording
start = time.process_time()
recording = read_recording([sys.argv[1]], ["Wand1", "Wand2"])
report(time.process_time() - start, frames=recording.position_mm.shape[2])
"""
C3D_PEER = """
import ezc3d
start = time.process_time()
points = ezc3d.c3d(sys.argv[1])["data"]["points"]
report(time.process_time() - start, frames=points.shape[2])
"""
MAKE_C3D = """
from mocap_metrology.io.c3d.write import write_c3d
def chunks():
    for _ in range(60):
        chunk = np.empty((n // 60, 2, 3), np.float32)
        chunk[:] = 100 + 0.007 * rng.normal(size=chunk.shape)
        yield chunk
write_c3d(sys.argv[1], ["Wand1", "Wand2"], 120.0, chunks(), n)
report(0.0)
"""


def measure(code: str, *arguments: object, series: bool = True) -> dict:
    """Run the code in a fresh Python; what it reports."""
    prelude = PRELUDE if series else PRELUDE.split("series =")[0] + PRELUDE[PRELUDE.index("def ") :]
    done = subprocess.run(
        [sys.executable, "-c", prelude + code, *map(str, arguments)],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return json.loads(done.stdout.splitlines()[-1])


def workflow(folder: Path, c3d: Path) -> dict:
    """CPU seconds and peak memory of the workflow's jobs from C3D to allan.parquet."""
    sheet = folder / "sheet.tsv"
    sheet.write_text(f"recording\tpath\tmarkers\tgroup\nnine\t{c3d}\tWand1;Wand2\tbenchmark\n")
    target = folder / "results/recordings/nine/allan.parquet"
    subprocess.run(
        [
            *(Path(sys.executable).with_name("snakemake"), "--cores", "1", "--quiet", "all"),
            *("--workflow-profile", ROOT / "profiles/ci", "--snakefile", ROOT / "Snakefile"),
            *("--directory", folder, target),
            *("--config", f"recordings={sheet}", "calibrations=", f"results={folder / 'results'}"),
        ],
        env=ENVIRONMENT,
        check=True,
    )
    rows = {}
    for rule in ("check_recording", "trajectories", "clean", "allan"):
        lines = (folder / f"results/benchmarks/{rule}/nine.tsv").read_text().splitlines()
        rows[rule] = dict(zip(lines[0].split("\t"), lines[1].split("\t"), strict=True))
    return {
        "cpu_s": sum(float(row["cpu_time"]) for row in rows.values()),
        "peak_gb": max(float(row["max_rss"]) for row in rows.values()) / 1e3,
        "parts": {rule: float(row["cpu_time"]) for rule, row in rows.items()},
    }


def line(work: str, ours: dict, peer: dict | None, name: str, more: str = "") -> float:
    """Print one row; return the ratio."""
    ratio = peer["cpu_s"] / ours["cpu_s"] if peer else float("nan")
    text = f"{work:34} {ours['cpu_s']:8.2f} s {ours['peak_gb']:5.2f} GB"
    if peer:
        text += f" | {name:14} {peer['cpu_s']:8.2f} s {peer['peak_gb']:5.2f} GB | {ratio:7.1f} x"
    print(f"{text}  {more}", flush=True)
    return ratio


def main() -> None:
    folder = Path(tempfile.mkdtemp(prefix="mocap-metrology-"))
    try:
        run(folder)
    finally:
        shutil.rmtree(folder)


def run(folder: Path) -> None:
    c3d, variances = folder / "nine.c3d", folder / "avar.npy"
    hampel, hampel_peer = measure(HAMPEL), measure(HAMPEL_PEER)
    checked = f"{hampel['wrong']} of 1260 samples differ from brute force (10 x a tenth timed)"
    line("Hampel, 241 frames, one series", hampel, hampel_peer, "hampel", checked)
    allan = measure(ALLAN, 0, variances)
    allan_peer = measure(ALLAN_PEER, variances)
    agree = f"{allan['taus']} taus, relative difference {allan_peer['difference']:.1e}"
    line("overlapping AVAR, one series", allan, allan_peer, "allantools", agree)
    for missing in (0.01, 0.05):
        gapped = measure(ALLAN, missing, folder / "gapped.npy")
        line(
            f"  with {missing:.0%} missing", gapped, allan_peer, "allantools", "(peer without gaps)"
        )
    measure(MAKE_C3D, c3d, series=False)
    read, read_peer = measure(C3D, c3d, series=False), measure(C3D_PEER, c3d, series=False)
    line("C3D, two points, to arrays", read, read_peer, "ezc3d", f"{read['frames']} frames")
    whole = workflow(folder, c3d)
    peers = {
        "cpu_s": 7 * hampel_peer["cpu_s"] + 7 * allan_peer["cpu_s"] + read_peer["cpu_s"],
        "peak_gb": max(p["peak_gb"] for p in (hampel_peer, allan_peer, read_peer)),
    }
    parts = ", ".join(f"{rule} {cpu:.1f}" for rule, cpu in whole["parts"].items())
    line("C3D to allan.parquet, 7 series", whole, peers, "all three", parts)


if __name__ == "__main__":
    argparse.ArgumentParser(prog="peers.py", description=__doc__.splitlines()[0]).parse_args()
    main()
