"""CPU time of each step of a Lighthouse calibration, and of scipy's simplex beside the project's.

    python -m benchmarks.lighthouse_times [twin ...]     (default: sim-2-3 and real-1-1)

One thread; the least of some runs, so that kernels are loaded.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import yaml
from mocap_workflow.calibration_twins import calibration_twin
from scipy.optimize import minimize

from benchmarks import ROOT, cpu_s, head, line
from benchmarks.poses import decoded
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate import jansen
from mocap_metrology.lighthouse.calibrate.batch import solved
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.fit import simplex
from mocap_metrology.lighthouse.fit.board_pose import START_M, first_guesses
from mocap_metrology.lighthouse.records import Measurements
from mocap_metrology.lighthouse.rotation import from_angles, to_angles
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
from mocap_metrology.lighthouse.simulate.recording import simulate, write_dump

SIMPLEX = {"xatol": 1e-4, "fatol": 1e-4, "maxfev": 1200, "maxiter": 1200}


def steps(name: str, folder: Path) -> Iterator[tuple[str, Callable[[], object]]]:
    """Name and work of each step for one twin."""
    document = yaml.safe_load((ROOT / "config/twins.yaml").read_text(encoding="utf-8"))
    twin = calibration_twin(document, name)
    made = simulate(twin)
    found = decoded(made, made.truth.board, folder)
    dump, board = folder / "dump", folder / "board.csv"
    factories = [station.factory for station in found.stations]

    def calibrated(estimator: str, optics: str = "ideal") -> Callable[[], object]:
        settings = jansen.CalibrationSettings(estimators=(estimator,), optics=(optics,))
        return lambda: jansen.calibrate(found.hits, found.board, factories, settings)

    yield "simulate", lambda: simulate(twin)
    yield "write 64 MB", lambda: write_dump(dump, made.pulses)
    yield "64 MB dump to cleaned sweeps, OOTX", lambda: decode(dump, "gpio-dump", board)
    scene = Scene(found.hits, found.board, "ideal", factories, None, "libsurvive", Priors())
    yield "cleaned sweeps to pose, batch", lambda: solved(scene)[0]
    unknown = "calibration, batch, variant of the rotor model unknown"
    yield unknown, calibrated("batch", "factory")
    yield "calibration, paper-lm", calibrated("paper-lm")
    for estimator in ("paper", "paper-tight", "pnp", "geometric"):
        yield f"calibration, {estimator}, mirror test beside it", calibrated(estimator)


def simplex_beside_scipy(n: int = 10) -> tuple[float, float, float]:
    """CPU seconds of n board poses by the project's simplex and by scipy's with numpy's cost of the
    same evaluations; largest difference of the poses."""
    rng, board, ideal = np.random.default_rng(1), flat_board(), rotor_parameters()
    poses = [np.r_[4, rng.uniform(-1, 1, 2), rng.normal(0, 0.2, 2), np.pi] for _ in range(n)]
    seen = [angles(board @ from_angles(*x[3:]).T + x[:3], ideal) for x in poses]
    R, t = first_guesses(Measurements(np.arange(n) / 60, np.array(seen)), board, START_M)
    pairs = [(np.r_[b, to_angles(a)], m) for a, b, m in zip(R, t, seen, strict=True)]

    def cost(x: np.ndarray, measured: np.ndarray) -> float:
        p = board @ from_angles(*x[3:]).T + x[:3]
        off = np.arctan2(p[:, 1:], p[:, :1]) - measured
        return float((off**2).sum())

    def ours() -> list[np.ndarray]:
        costs = ((x, simplex.seen_at(simplex.BOARD, board, m, ideal)) for x, m in pairs)
        return [simplex.nelder_mead(x, of, simplex.MATLAB)[0] for x, of in costs]

    def peers() -> list[np.ndarray]:
        return [minimize(cost, x, (m,), method="Nelder-Mead", options=SIMPLEX).x for x, m in pairs]

    apart = max(np.abs(a - b).max() for a, b in zip(ours(), peers(), strict=True))
    return cpu_s(ours), cpu_s(peers, 1), float(apart)


def main(names: list[str]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            print(f"{name}\n")
            head("step", "CPU s")
            for step, work in steps(name, Path(folder)):
                line(step, f"{cpu_s(work, 4):.2f}")
            print()
    here, peer, apart = simplex_beside_scipy()
    print(f"simplex, ten board poses: {here:.3f} s, scipy's with numpy {peer:.2f} s,", end=" ")
    print(f"ratio {peer / here:.0f}; poses differ by {apart:.1g} at most")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default, words = ["sim-2-3", "real-1-1"], "of config/twins.yaml (sim-2-3 and real-1-1)"
    parser.add_argument("twin", nargs="*", default=default, help=words)
    main(parser.parse_args().twin)
