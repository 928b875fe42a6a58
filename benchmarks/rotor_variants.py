"""Which variant of the rotor model recordings choose, where none is given.

    python -m benchmarks.rotor_variants [recordings of each kind]

Boards by hand and decks in flight whose rotors obey libsurvive's or the Crazyflie's formula in turn
(`lighthouse_recordings.py`), and the 40 twins `real-*` of config/twins.yaml, which obey the
Crazyflie's and whose lasers are displaced by up to 15 mm. The choice is by `batch`, or by
`paper-lm` where that is the only estimator.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks import arguments, head, line
from benchmarks.lighthouse_recordings import flight, hand, listed
from benchmarks.poses import calibrated, lengths, off
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps

SIGNS = ("libsurvive", "crazyflie")
KINDS = ("board by hand", "deck in flight", "twins real-*")
ESTIMATORS = ("batch", "paper-lm")
FIRST_SEED = 1000


def recording(kind: str, k: int) -> tuple[SimulatedSweeps, str]:
    """A recording, and the variant that it obeys."""
    if kind == "twins real-*":
        return listed(f"real-{1 + k // 5}-{1 + k % 5}"), "crazyflie"
    sign = SIGNS[k % 2]
    return (hand if kind == "board by hand" else flight)(FIRST_SEED + k, sign), sign


def judged(
    kind: str, k: int, estimators: tuple[str, ...] = ESTIMATORS
) -> list[tuple[bool, bool, float, float, int]]:
    """By each estimator: whether the true variant is excluded, whether the other sign is; error in
    mm and deg; how many of six 95 % intervals hold."""
    made, true = recording(kind, k)
    rows = []
    for name in estimators:
        found = calibrated(made, estimators=(name,))
        standing = {way.variant: way.standing for way in found.variants}
        other = SIGNS[1 - SIGNS.index(true)]
        pose = found.estimates[-1]
        errors = off(made, pose)
        inside = int((np.abs(errors) < 1.96 * np.sqrt(np.diag(pose.covariance))).sum())
        excluded = standing.get(true, "worse") == "worse", standing.get(other) == "worse"
        rows.append((*excluded, *lengths(errors), inside))
    return rows


def main(n: int = 40) -> None:
    """Print the table as it grows."""
    head(
        *("recordings", "by", "true variant excluded", "other sign excluded"),
        *("median error mm, deg", "95 % intervals hold"),
    )
    with ProcessPoolExecutor(2) as pool:
        for kind in KINDS:
            count = 40 if kind == KINDS[2] else n
            found = list(pool.map(judged, [kind] * count, range(count)))
            for name, rows in zip(ESTIMATORS, zip(*found, strict=True), strict=True):
                out, other, mm, deg, inside = (np.array(c) for c in zip(*rows, strict=True))
                counts = f"{out.sum()} of {count}", f"{other.sum()} of {count}"
                error = f"{np.median(mm):.2f}, {np.median(deg):.3f}"
                line(kind, f"`{name}`", *counts, error, f"{100 * inside.mean() / 6:.0f} %")


if __name__ == "__main__":
    main(**arguments(__doc__, n=40))
