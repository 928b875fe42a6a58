"""Which variant of the rotor model recordings choose, where none is given.

    python benchmarks/rotor_variants.py [recordings of each kind]

Boards by hand and decks in flight whose rotors obey libsurvive's or the Crazyflie's formula in turn
(`lighthouse_recordings.py`), and the 40 twins `real-*` of config/twins.yaml, which obey the
Crazyflie's and whose lasers are displaced by up to 15 mm. The choice is by `batch`, or by
`paper-lm` where that is the only estimator.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from benchmarks.lighthouse_recordings import flight, hand, listed
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps

SIGNS = ("libsurvive", "crazyflie")
KINDS = ("board by hand", "deck in flight", "twins real-*")
FIRST_SEED = 1000


def recording(kind: str, k: int) -> tuple[SimulatedSweeps, str]:
    """A recording, and the variant that it obeys."""
    if kind == "twins real-*":
        return listed(f"real-{1 + k // 5}-{1 + k % 5}"), "crazyflie"
    sign = SIGNS[k % 2]
    return (hand if kind == "board by hand" else flight)(FIRST_SEED + k, sign), sign


def judged(kind: str, k: int) -> list[tuple[bool, bool, float, float, int]]:
    """By batch, by paper-lm: whether the true variant is excluded, whether the other sign is; error
    in mm and deg; how many of six 95 % intervals hold."""
    made, true = recording(kind, k)
    hits, _ = clean_hits(made.hits, made.truth.board)
    factories = [station.factory for station in made.truth.stations]
    rows = []
    for name in ("batch", "paper-lm"):
        settings = CalibrationSettings(estimators=(name,), optics=("factory",))
        found = calibrate(hits, made.truth.board, factories, settings)
        standing = {way.variant: way.standing for way in found.variants}
        other = SIGNS[1 - SIGNS.index(true)]
        pose = found.estimates[-1]
        off = np.r_[
            1e3 * (pose.t_m - made.truth.t_optical_m),
            np.degrees(rotation.error(pose.R, made.truth.R)),
        ]
        assert pose.covariance is not None
        inside = int((np.abs(off) < 1.96 * np.sqrt(np.diag(pose.covariance))).sum())
        mm, deg = np.linalg.norm(off[:3]), np.linalg.norm(off[3:])
        rows.append((standing[true] == "worse", standing[other] == "worse", mm, deg, inside))
    return rows


def lines(n: int) -> Iterator[str]:
    """A table of Markdown."""
    yield (
        "| recordings | by | true variant excluded | other sign excluded | median error mm, deg |"
        " 95 % intervals hold |"
    )
    yield "|---" * 6 + "|"
    with ProcessPoolExecutor(2) as pool:
        for kind in KINDS:
            count = 40 if kind == KINDS[2] else n
            found = list(pool.map(judged, [kind] * count, range(count)))
            for name, rows in zip(("batch", "paper-lm"), zip(*found, strict=True), strict=True):
                out, other, mm, deg, inside = (np.array(c) for c in zip(*rows, strict=True))
                share = 100 * inside.mean() / 6
                yield (
                    f"| {kind} | `{name}` | {out.sum()} of {count} | {other.sum()} of {count} |"
                    f" {np.median(mm):.2f}, {np.median(deg):.3f} | {share:.0f} % |"
                )


def main(n: int = 40) -> None:
    """Print the table as it grows."""
    for line in lines(n):
        print(line, flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
