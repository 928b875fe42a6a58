"""The project beside its peers, in one run: CPU seconds on one thread, peak memory, ratios.

    make benchmark

Nine hours of two markers at 120 Hz: 3,888,000 frames, seven series. Every measurement runs in a
process of its own that is otherwise idle: CPU seconds of the work alone, imports and compilation
before it; the row of the workflow is its own jobs, imports and Parquet included. GSL is compiled
here where its headers are installed (Debian: libgsl-dev), else its row is left out. The table is
that of docs/speed.md.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from benchmarks import head, line
from benchmarks.scale import costs, run

ENVIRONMENT = os.environ | {"NUMBA_NUM_THREADS": "1"}  # the other pools: benchmarks/__init__.py
PEERS = ("hampel", "allantools", "allan-variance", "ezc3d", "cflib")

PRELUDE = """
import json, resource, sys, time
import numpy as np
n = 3_888_000
rng = np.random.default_rng(1)
series = 166.6 + 0.007 * rng.normal(size=n) + 1e-5 * np.cumsum(rng.normal(size=n))
series[rng.integers(0, n, 400)] += 20
def timed(work):
    start = time.process_time()
    found = work()
    return time.process_time() - start, found
def report(cpu, **more):
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(json.dumps({"cpu_s": cpu, "peak_gb": peak, **more}))
"""

HAMPEL = """
from mocap_metrology.common.hampel import hampel
hampel(series[:1000], 120)
cpu, found = timed(lambda: hampel(series, 120))
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
report(10 * timed(lambda: hampel(part, window_size=241, n_sigma=3.0))[0])
"""
ALLAN = """
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
m = averaging_factors(n)
missing = float(sys.argv[1])
series[rng.random(n) < missing] = np.nan
allan_variance(series[:1000], m[:5])
cpu, found = timed(lambda: allan_variance(series, m))
np.save(sys.argv[2], found.variance)
report(cpu, taus=len(m))
"""
ALLAN_PEER = """
import allantools
from mocap_metrology.noise.allan.variance import averaging_factors
how = {"rate": 1.0, "data_type": "freq", "taus": averaging_factors(n).astype(float)}
cpu, (_, deviation, _, _) = timed(lambda: allantools.oadev(series, **how))
report(cpu, difference=float(np.abs(np.load(sys.argv[1]) / deviation**2 - 1).max()))
"""
C3D = """
from mocap_metrology.io.read import read_recording
report(timed(lambda: read_recording([sys.argv[1]], ["Wand1", "Wand2"]))[0])
"""
C3D_PEER = """
import ezc3d
report(timed(lambda: ezc3d.c3d(sys.argv[1])["data"]["points"])[0])
"""
GSL_PEER = r"""
#include <gsl/gsl_filter.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int argc, char **argv) {
    size_t n = strtoul(argv[2], NULL, 10), replaced;
    gsl_vector *x = gsl_vector_alloc(n), *y = gsl_vector_alloc(n);
    gsl_vector *median = gsl_vector_alloc(n), *sigma = gsl_vector_alloc(n);
    gsl_vector_int *outlier = gsl_vector_int_alloc(n);
    gsl_filter_impulse_workspace *space = gsl_filter_impulse_alloc(241);
    FILE *file = fopen(argv[1], "rb");
    if (!file || fread(x->data, sizeof(double), n, file) != n) return 1;
    clock_t start = clock();
    gsl_filter_impulse(GSL_FILTER_END_TRUNCATE, GSL_FILTER_SCALE_MAD, 3.0, x, y, median, sigma,
                       &replaced, outlier, space);
    printf("%.3f %zu\n", (double)(clock() - start) / CLOCKS_PER_SEC, replaced);
    return 0;
}
"""
FIT = """
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.estimates import Components
series = 0.007 * rng.normal(size=n) + 1e-5 * np.cumsum(rng.normal(size=n))
truth = {"h_0": 2 * 0.007**2 / 120, "h_-2": 2 * 1e-5**2 * 120 / (2 * np.pi) ** 2}
curve = allan_curve(series, 120.0, averaging_factors(n, 100, 1, 0.1))
np.save(sys.argv[1], [curve.tau_s, curve.variance])
given = series, 120.0, Components(gauss_markov=0)
likelihood(*given)
cpu, found = timed(lambda: likelihood(*given))
values = {c.parameter: c.value for c in found.estimate.coefficients}
report(cpu, off={name: values[name] / truth[name] - 1 for name in truth})
"""
FIT_PEER = """
from allan_variance import estimate_parameters
tau, avar = np.load(sys.argv[1])
cpu, (found, _) = timed(lambda: estimate_parameters(tau, avar))
white, walk = 0.007 / np.sqrt(120), 1e-5 * np.sqrt(120)  # unit * s^(1/2) and unit / s^(1/2)
report(cpu, off={"h_0": (found["white"] / white) ** 2 - 1, "h_-2": (found["walk"] / walk) ** 2 - 1})
"""
STATIONS = """
from scipy.spatial.transform import Rotation
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
board, ideal = flat_board(), rotor_parameters()
R_s, t_s = Rotation.from_euler("z", 75, degrees=True).as_matrix(), np.array([2.0, -2.0, 0.1])
turns = Rotation.from_rotvec(rng.normal(0, 0.3, (60, 3))).as_matrix() @ np.diag([-1.0, -1, 1])
places = np.array([2.5, 0, 0]) + rng.normal(0, 0.4, (60, 3))
seen = np.einsum("nij,dj->ndi", turns, board) + places[:, None]
stations = [seen, (seen - t_s) @ R_s]  # in the frame of either station
measured = [
    np.array([angles(p, ideal) for p in own]) + rng.normal(0, 60e-6, (60, len(board), 2))
    for own in stations
]
def off(R, t):
    turn = np.linalg.norm(Rotation.from_matrix(R @ R_s.T).as_rotvec(degrees=True))
    return {"mm": 1e3 * float(np.linalg.norm(t - t_s)), "deg": float(turn)}
"""
SOLVER = (
    STATIONS
    + """
from mocap_metrology.lighthouse.calibrate.superpose import kabsch
from mocap_metrology.lighthouse.calibrate.weighted_station import by_gauss_newton, evidence
from mocap_metrology.lighthouse.fit.board_pose import by_levenberg_marquardt
from mocap_metrology.lighthouse.records import Measurements
def solve():
    given = [Measurements(np.arange(60.0), a) for a in measured]
    paths = [by_levenberg_marquardt(one, board, ideal) for one in given]
    diodes = [(p.R @ board.T + p.t_m[:, :, None]).transpose(0, 2, 1).reshape(-1, 3) for p in paths]
    known = evidence(paths[0], given[1], given[0], board, (ideal, ideal))
    return by_gauss_newton(*kabsch(*diodes[::-1]), known)
solve()
cpu, (R, t, *_) = timed(solve)
report(cpu, off=off(R, t))
"""
)
SOLVER_PEER = (
    STATIONS
    + """
from cflib.localization.lighthouse_bs_vector import LighthouseBsVector, LighthouseBsVectors
from cflib.localization.lighthouse_cf_pose_sample import LhCfPoseSample, LhCfPoseSampleWrapper
from cflib.localization.lighthouse_geometry_solution import LighthouseGeometrySolution
from cflib.localization.lighthouse_geometry_solver import LighthouseGeometrySolver
from cflib.localization.lighthouse_types import Pose
samples, near = [], Rotation.from_rotvec(rng.normal(0, 0.03, (62, 3))).as_matrix()
for k in range(60):
    rays = [LighthouseBsVectors([LighthouseBsVector(*a) for a in own[k]]) for own in measured]
    rays = dict(enumerate(rays))
    samples.append(LhCfPoseSampleWrapper(LhCfPoseSample(rays)))
    R, t = turns[0].T @ turns[k], turns[0].T @ (places[k] - places[0])
    samples[-1].pose = Pose(near[k] @ R, t + rng.normal(0, 0.03, 3))
solution = LighthouseGeometrySolution(samples)
for s, (R, t) in enumerate([(np.eye(3), np.zeros(3)), (R_s, t_s)]):
    R, t = turns[0].T @ R, turns[0].T @ (t - places[0])
    solution.bs_poses[s] = Pose(near[60 + s] @ R, t + rng.normal(0, 0.03, 3))
cpu, _ = timed(lambda: LighthouseGeometrySolver.solve(samples, board, solution))
one, two = (solution.bs_poses[s] for s in (0, 1))
R = one.rot_matrix.T
report(cpu, off=off(R @ two.rot_matrix, R @ (two.translation - one.translation)))
"""
)
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
    command = [sys.executable, "-c", prelude + code, *map(str, arguments)]
    done = subprocess.check_output(command, env=ENVIRONMENT, text=True)
    return json.loads(done.splitlines()[-1])


def workflow(folder: Path, c3d: Path) -> dict:
    """CPU seconds and peak memory of the workflow's jobs from C3D to allan.parquet."""
    target = str(folder / "results/recordings/nine/allan.parquet")
    run(folder, [("nine", str(c3d), "Wand1;Wand2")], target=target)
    cpu, peak = zip(*costs(folder / "results").values(), strict=True)
    return {"cpu_s": sum(cpu), "peak_gb": max(peak)}


def gsl(folder: Path) -> dict | None:
    """The Hampel filter of GSL on the same series; None where it cannot be compiled."""
    source, program = folder / "gsl.c", folder / "gsl"
    source.write_text(GSL_PEER)
    build = ["cc", "-O2", source, "-o", program, "-lgsl", "-lgslcblas", "-lm"]
    if subprocess.run(build, stderr=subprocess.DEVNULL, check=False).returncode:
        return None
    measure(f"series.tofile({str(folder / 'series')!r}); report(0.0)")
    ran = [program, folder / "series", "3888000"]
    seconds, replaced = subprocess.check_output(ran, text=True).split()
    return {"cpu_s": float(seconds), "replaced": int(replaced)}


def size(found: dict) -> str:
    """CPU time, and memory where it is known."""
    memory = f", {found['peak_gb']:.2f} GB" if "peak_gb" in found else ""
    return f"{found['cpu_s']:.3g} s{memory}"


def row(work: str, ours: dict, peer: dict, name: str) -> None:
    """Print one row."""
    line(work, size(ours), f"{name}: {size(peer)}", f"{peer['cpu_s'] / ours['cpu_s']:.3g}")


def machine() -> None:
    """Print machine and versions."""
    cpuinfo = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.exists() else None
    print(f"{found[1] if found else platform.processor()}, {os.cpu_count()} processors,", end=" ")
    packages = ("mocap-metrology", "numpy", "scipy", "numba", "pyarrow", *PEERS)
    print(", ".join(f"{name} {version(name)}" for name in packages), end="\n\n")


def errors(found: dict) -> str:
    """How far off the truth its numbers are."""
    units = {"mm": " mm", "deg": " deg"}
    return ", ".join(
        f"{value:.2g}{units[name]}" if name in units else f"{name} {100 * value:+.1f} %"
        for name, value in found["off"].items()
    )


def compared(folder: Path) -> None:
    """Print the table."""
    c3d, variances = folder / "nine.c3d", folder / "avar.npy"
    head("nine hours of two markers, 3,888,000 frames", "here", "peer", "ratio")
    hampel, hampel_peer = measure(HAMPEL), measure(HAMPEL_PEER)
    work = f"Hampel filter of 241 frames, one series; {hampel['wrong']} of 1260 samples differ from"
    row(f"{work} brute force", hampel, hampel_peer, "`hampel` (10 x a tenth)")
    if compiled := gsl(folder):
        work = f"the same; {hampel['replaced']} and {compiled['replaced']} samples are replaced"
        row(work, hampel, compiled, "GSL")
    else:
        print("GSL is left out: its headers or a C compiler are missing", file=sys.stderr)
    allan, allan_peer = measure(ALLAN, 0, variances), measure(ALLAN_PEER, variances)
    agree = f"{allan['taus']} taus, one series; relative difference {allan_peer['difference']:.0e}"
    row(f"overlapping Allan variance, {agree}", allan, allan_peer, "`allantools`")
    for missing in (0.01, 0.05):
        gapped, work = measure(ALLAN, missing, folder / "gapped.npy"), f"with {missing:.0%} missing"
        row(f"the same {work}", gapped, allan_peer, "`allantools` without gaps")
    fit, fit_peer = (measure(code, folder / "fit.npy", series=False) for code in (FIT, FIT_PEER))
    work = "five power laws from 100 Allan variances of white noise and a random walk; errors"
    row(f"{work}: {errors(fit)}; peer: {errors(fit_peer)}", fit, fit_peer, "`allan-variance`")
    measure(MAKE_C3D, c3d, series=False)
    read, read_peer = measure(C3D, c3d, series=False), measure(C3D_PEER, c3d, series=False)
    row("C3D, two points, to arrays, SHA-256 included", read, read_peer, "`ezc3d`")
    peers = {
        "cpu_s": 7 * hampel_peer["cpu_s"] + 7 * allan_peer["cpu_s"] + read_peer["cpu_s"],
        "peak_gb": max(p["peak_gb"] for p in (hampel_peer, allan_peer, read_peer)),
    }
    work = "C3D to `allan.parquet`, seven series, all jobs with imports and Parquet"
    row(work, workflow(folder, c3d), peers, "`hampel`, `allantools`, `ezc3d`")
    solver, solver_peer = (measure(code, series=False) for code in (SOLVER, SOLVER_PEER))
    work = "two base stations from 60 poses of 32 diodes, 60 µrad; error of the pose"
    row(f"{work}: {errors(solver)}; peer: {errors(solver_peer)}", solver, solver_peer, "`cflib`")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    machine()
    with tempfile.TemporaryDirectory(prefix="mocap-metrology-") as name:
        compared(Path(name))
