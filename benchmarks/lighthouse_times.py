"""CPU time of each step of a Lighthouse calibration, and of scipy's simplex beside the project's.

    python benchmarks/lighthouse_times.py [twin ...]     (default: sim-2-3 and real-1-1)

One thread; each step is run once before it is timed, so that kernels are loaded.
"""

from __future__ import annotations

import argparse
import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import yaml

from mocap_metrology.common.files import write_csv
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate import jansen
from mocap_metrology.lighthouse.calibrate.batch import solved
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.fit import simplex
from mocap_metrology.lighthouse.fit.board_pose import START_M, first_guesses
from mocap_metrology.lighthouse.fit.simplex import BOARD
from mocap_metrology.lighthouse.rotation import from_angles, to_angles
from mocap_metrology.lighthouse.rotor import rotor_parameters
from mocap_metrology.lighthouse.simulate.recording import simulate, write_dump

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "workflow"))
from mocap_workflow.calibration_twins import calibration_twin

ROOT = Path(__file__).resolve().parents[1]


def cpu(work: Callable[[], object], times: int = 3) -> float:
    """Least CPU seconds of some runs, after one that is not counted."""
    work()
    least = np.inf
    for _ in range(times):
        start = time.process_time()
        work()
        least = min(least, time.process_time() - start)
    return float(least)


def steps(name: str, folder: Path) -> list[tuple[str, float]]:
    """Name and CPU seconds of each step for one twin."""
    document = yaml.safe_load((ROOT / "config/twins.yaml").read_text(encoding="utf-8"))
    twin = calibration_twin(document, name)
    made = simulate(twin)
    dump, board = folder / "dump", folder / "board.csv"
    write_dump(dump, made.pulses)
    write_csv(board, [dict(zip(("x_m", "y_m", "z_m"), p, strict=True)) for p in made.truth.board])
    found = decode(dump, "gpio-dump", board)
    factories = [station.factory for station in found.stations]

    def calibrated(*estimators: str) -> Callable[[], object]:
        settings = jansen.CalibrationSettings(estimators=estimators, optics=("ideal",))
        return lambda: jansen.calibrate(found.hits, found.board, factories, settings)

    rows = [
        ("simulate", cpu(lambda: simulate(twin))),
        ("write 64 MB", cpu(lambda: write_dump(dump, made.pulses))),
        ("64 MB dump to cleaned sweeps, OOTX", cpu(lambda: decode(dump, "gpio-dump", board))),
    ]
    scene = Scene(found.hits, found.board, "ideal", factories, None, "libsurvive", Priors())
    rows.append(("cleaned sweeps to pose, batch", cpu(lambda: solved(scene)[0])))
    unknown = jansen.CalibrationSettings(estimators=("batch",), optics=("factory",))
    by_all = cpu(lambda: jansen.calibrate(found.hits, found.board, factories, unknown))
    rows.append(("calibration, batch, variant of the rotor model unknown", by_all))
    lm = cpu(calibrated("paper-lm"))
    rows.append(("calibration, paper-lm", lm))
    others = ("paper", "paper-tight", "pnp", "geometric")
    rows += [(f"calibration, {e}, mirror test beside it", cpu(calibrated(e))) for e in others]
    return rows


def simplex_beside_scipy(n: int = 10) -> tuple[float, float, float]:
    """CPU seconds of n board poses by the project's simplex and by scipy's with numpy's cost of the
    same evaluations; largest difference of the poses."""
    from scipy.optimize import minimize

    from mocap_metrology.lighthouse.board import flat_board
    from mocap_metrology.lighthouse.records import Measurements
    from mocap_metrology.lighthouse.rotor import angles

    rng, board, ideal = np.random.default_rng(1), flat_board(), rotor_parameters()
    poses = [np.r_[4, rng.uniform(-1, 1, 2), rng.normal(0, 0.2, 2), np.pi] for _ in range(n)]
    seen = [angles(board @ from_angles(*x[3:]).T + x[:3], ideal) for x in poses]
    given = Measurements(np.arange(n) / 60, np.array(seen))
    R, t = first_guesses(given, board, START_M)
    starts = [np.r_[b, to_angles(a)] for a, b in zip(R, t, strict=True)]

    def cost(x: np.ndarray, measured: np.ndarray) -> float:
        p = board @ from_angles(*x[3:]).T + x[:3]
        off = np.arctan2(p[:, 1:], p[:, :1]) - measured
        return float((off**2).sum())

    def ours() -> list[np.ndarray]:
        pairs = zip(starts, seen, strict=True)
        return [
            simplex.nelder_mead(x, simplex.seen_at(BOARD, board, m, ideal), simplex.MATLAB)[0]
            for x, m in pairs
        ]

    options = {"xatol": 1e-4, "fatol": 1e-4, "maxfev": 1200, "maxiter": 1200}

    def peers() -> list[np.ndarray]:
        return [
            minimize(cost, x, (m,), method="Nelder-Mead", options=options).x
            for x, m in zip(starts, seen, strict=True)
        ]

    apart = max(np.abs(a - b).max() for a, b in zip(ours(), peers(), strict=True))
    return cpu(ours), cpu(peers, 1), float(apart)


def main(names: list[str]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            print(f"{name}\n")
            print("| step | CPU s |\n|---|---|")
            for step, seconds in steps(name, Path(folder)):
                print(f"| {step} | {seconds:.2f} |")
            print()
    here, peer, apart = simplex_beside_scipy()
    print(f"simplex, ten board poses: {here:.3f} s, scipy's with numpy {peer:.2f} s,", end=" ")
    print(f"ratio {peer / here:.0f}; poses differ by {apart:.1g} at most")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        prog="lighthouse_times.py", description=__doc__.splitlines()[0]
    )
    default = ["sim-2-3", "real-1-1"]
    words = "of config/twins.yaml (default: sim-2-3 and real-1-1)"
    parser.add_argument("twin", nargs="*", default=default, help=words)
    main(parser.parse_args().twin)
