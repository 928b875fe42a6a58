"""How often a moved station is found, and how often one that kept its place is called moved.

Each setup draws what recordings of the same hardware share, from the priors of `batch`: errors of
the phases, depth of the lasers, diodes and scale of the board, and how late each diode sees a
flash. An earlier recording is then compared with three others: nothing moved, the slave shifted by
3 mm, the slave turned by 0.1 deg, each in a random direction.

    python -m benchmarks.moved_stations [setups] [seconds of a recording] [first setup]
"""

from __future__ import annotations

import csv
import json
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import cast

import numpy as np

from benchmarks import arguments
from benchmarks.lighthouse_recordings import hand
from benchmarks.poses import decoded
from mocap_metrology.lighthouse.assess.comparison import Comparison, compare_with_earlier
from mocap_metrology.lighthouse.assess.pose_file import PoseFile
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.records import Station
from mocap_metrology.lighthouse.rotation import exp, to_angles
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.twin import FactoryValues, LighthouseTwin, StationTwin

RISE_US = 0.6
SHIFT_MM, TURN_DEG = 3.0, 0.1
CASES = ("unchanged", "shifted", "turned")
SETTINGS = CalibrationSettings(estimators=("batch",), optics=("factory",))


def _with_errors(station: StationTwin, phase: np.ndarray, depth: float) -> StationTwin:
    """With phases and a depth between its lasers that its flashes do not state."""
    told = station.optics
    values = {name: tuple(getattr(told, name)) for name in FactoryValues.model_fields}
    factory = FactoryValues(**values | {"phase": tuple(told.phase + phase)})
    lasers_m = (depth / 2, 0.0, 0.0), (-depth / 2, 0.0, 0.0)
    return station.model_copy(update={"factory": factory, "lasers_m": lasers_m})


class Setup:
    """Hardware of a setup: the twin as it is, and what its board file and flashes say."""

    def __init__(self, seed: int, seconds: float):
        rng, priors = np.random.default_rng([seed, 6]), Priors()
        twin = hand(seed).twin.model_copy(update={"duration_s": seconds})
        true_board = twin.board.positions()
        self.told = [station.optics for station in twin.stations]
        off = 1e-3 * priors.phase_mrad * rng.normal(size=(2, 2))
        depths = 1e-3 * priors.laser_depth_mm * rng.normal(size=2)
        drawn = zip(twin.stations, off, depths, strict=True)
        master, slave = (_with_errors(*one) for one in drawn)
        update = {"master": master, "slave": slave, "flash_rise_us": RISE_US}
        self.twin = twin.model_copy(update=update)
        places = 1e-3 * priors.board_position_mm * rng.normal(size=true_board.shape)
        self.board = (true_board + places) * (1 + priors.board_scale * rng.normal())
        self.way = rng.normal(size=(2, 3))
        self.way /= np.linalg.norm(self.way, axis=1)[:, None]

    def moved(self, case: str) -> LighthouseTwin:
        """The twin with its slave moved."""
        slave = self.twin.slave
        assert slave is not None
        t, R = slave.t, slave.R
        if case == "shifted":
            t = t + 1e-3 * SHIFT_MM * self.way[0]
        if case == "turned":
            R = exp(np.radians(TURN_DEG) * self.way[1]) @ R
        alpha, beta, gamma = np.degrees(to_angles(R)).tolist()
        x, y, z = t.tolist()
        pose = {"position_m": (x, y, z), "rotation_deg": (alpha, beta, gamma)}
        return self.twin.model_copy(update={"slave": slave.model_copy(update=pose)})

    def calibrated(self, case: str, seed: int, folder: str) -> PoseFile:
        """pose.json of a recording: a dump, as any."""
        made = simulate(self.moved(case), seed)
        found = decoded(made, self.board, folder)
        poses = calibrate(found.hits, found.board, self.told, SETTINGS)
        document = summary(poses, self.stations()).document
        return cast(PoseFile, json.loads(json.dumps(document, default=str)))

    def stations(self, **fields: int) -> list[Station]:
        """As their flashes state them."""
        each = zip(("master", "slave"), self.twin.stations, self.told, strict=True)
        return [Station(role, own.id, own.mode, told, **fields) for role, own, told in each]


def compared(seed: int, seconds: float) -> list[Comparison]:
    """Three later recordings of a setup against the earlier one."""
    setup = Setup(seed, seconds)
    with tempfile.TemporaryDirectory() as folder:
        earlier = setup.calibrated("unchanged", 4 * seed, folder)
        return [
            compare_with_earlier(setup.calibrated(case, 4 * seed + 1 + k, folder), earlier)
            for k, case in enumerate(CASES)
        ]


def rows(setups: range, seconds: float) -> Iterator[dict[str, object]]:
    """One row a comparison."""
    with ProcessPoolExecutor(2) as pool:
        results = pool.map(partial(compared, seconds=seconds), setups)
        for seed, found in zip(setups, results, strict=True):
            for case, one in zip(CASES, found, strict=True):
                true = (SHIFT_MM * (case == "shifted"), TURN_DEG * (case == "turned"))
                low, high = one.lower_95, one.upper_95
                inside = [low[k] <= true[k] <= high[k] for k in (0, 1)]
                yield {
                    **{"setup": seed, "case": case, "valid": one.valid, "moved": one.moved},
                    **{"shift_mm": round(one.shift[0], 3), "shift_deg": round(one.shift[1], 4)},
                    **{"upper_mm": round(high[0], 3), "upper_deg": round(high[1], 4)},
                    **{"true_in_interval_mm": inside[0], "true_in_interval_deg": inside[1]},
                    **{"chi2": round(one.chi2, 2), "basis": one.basis},
                }


def main(setups: int = 100, seconds: float = 8.0, first: int = 0) -> None:
    """Write one row a comparison to standard output, and the counts to standard error."""
    made: list[dict[str, object]] = []
    out = csv.writer(sys.stdout, lineterminator="\n")
    for row in rows(range(first, first + setups), seconds):
        if not made:
            out.writerow(row)
        out.writerow(row.values())
        sys.stdout.flush()
        made.append(row)
    for case in CASES:
        own = [row for row in made if row["case"] == case]
        found = sum(not row["valid"] for row in own)
        print(f"{case}: {found} of {len(own)} no longer valid", file=sys.stderr)


if __name__ == "__main__":
    main(**arguments(__doc__, setups=100, seconds=8.0, first=0))
