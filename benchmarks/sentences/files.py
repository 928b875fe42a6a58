"""Lighthouse recordings that are not what they seem: a bumped station, wrong hits on few diodes,
old pulses from a device's memory, dim diodes.

Recordings of two simulated stations with factory values drawn with the spread of real ones, 53 urad
common and 30 urad independent jitter, a flat board of 24 x 16 cm moved by hand for 8 s, ten scenes
with baselines of 1.5 to 3.2 m; decoded and calibrated as files are. "Bumped": the slave is moved by
5 mm in a random direction at a random time between 2 and 6 s.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.decode.flashes import find_flashes
from mocap_metrology.lighthouse.decode.ootx import decode_station
from mocap_metrology.lighthouse.decode.sweeps import find_hits
from mocap_metrology.lighthouse.records import Hits, Pulses
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, twin_from_mapping

SAMPLE_S = 0.5e-6
BUMP_M = 5e-3
PRIOR = {
    "phase": (0.028, 0.025),
    "tilt": (-0.0024, 0.0043),
    "curve": (-0.002, 0.0043),
    "gibphase": (1.0, 1.2),
    "gibmag": (0.0, 0.009),
}


def scene(seed: int) -> LighthouseTwin:
    """One of ten places of the stations, by seed; factory values and path by seed."""
    place, rng = np.random.default_rng(900 + seed % 10), np.random.default_rng([seed, 77])

    def factory() -> dict:
        return {k: rng.normal(m, s, 2).tolist() for k, (m, s) in PRIOR.items()}

    half = place.uniform(0.75, 1.6)
    centre = np.array([place.uniform(2.0, 3.2), 0.0, place.uniform(-0.3, 0.1)])
    slave = np.array([place.uniform(-0.3, 0.3), 2 * half, place.uniform(-0.3, 0.3)])
    yaw = np.degrees(np.arctan2(centre[1] - slave[1], centre[0] - slave[0]))
    middle = centre + np.array([0, half, 0])
    return twin_from_mapping(
        {
            "seed": seed,
            "master": {"id": 11, "mode": "b", "factory": factory()},
            "slave": {
                "id": 12,
                "mode": "c",
                "position_m": slave.tolist(),
                "rotation_deg": [*place.normal(0, 5, 2).tolist(), float(yaw + 25)],
                "factory": factory(),
            },
            "motion": {"pattern": "hand", "centre_m": middle.tolist()},
            "common_urad": 53.0,
            "independent_urad": 30.0,
        }
    )


def sampled(pulses: Pulses, rise_s: float, seed: int) -> Pulses:
    """Edges at 2 MHz; each diode's flashes rise late by up to `rise_s`, its own."""
    rng = np.random.default_rng([seed, 5])
    late = np.where(pulses.length_s > 45e-6, rng.uniform(0, rise_s, 33)[pulses.diode], 0)
    first = np.ceil((pulses.start_s + late) / SAMPLE_S)
    end = np.ceil((pulses.start_s + pulses.length_s) / SAMPLE_S)
    kept = (end > first) & (first > 0)
    order = np.flatnonzero(kept)[np.argsort(first[kept], kind="stable")]
    return Pulses(
        first[order] * SAMPLE_S,
        (end - first)[order] * SAMPLE_S,
        pulses.diode[order],
        pulses.n_diodes,
        pulses.duration_s,
        SAMPLE_S,
    )


def recording(seed: int, bump_m: float = 0.0) -> tuple[Hits, list, np.ndarray]:
    """Clean hits, stations and board of a scene."""
    twin = scene(seed)
    made = simulate(twin)
    pulses = made.pulses
    if bump_m:
        rng = np.random.default_rng([seed, 6])
        way = rng.normal(size=3)
        there = np.add(twin.slave.position_m, bump_m * way / np.linalg.norm(way))
        moved = simulate(replace(twin, slave=replace(twin.slave, position_m=tuple(there)))).pulses
        at = rng.uniform(2.0, 6.0)
        early, late = pulses.start_s < at, moved.start_s >= at
        pulses = Pulses(
            *(
                np.concatenate([getattr(pulses, n)[early], getattr(moved, n)[late]])
                for n in ("start_s", "length_s", "diode")
            ),
            pulses.n_diodes,
            pulses.duration_s,
            0.0,
        )
    seen = sampled(pulses, 0.6e-6, seed)
    flashes = find_flashes(seen)
    stations = [
        replace(decode_station(f), role=role)
        for f, role in zip(flashes, ("master", "slave"), strict=True)
    ]
    hits, _ = find_hits(seen, flashes)
    hits, _ = clean_hits(hits, flat_board(), resolution_rad=np.pi * SAMPLE_S * 120)
    return hits, stations, flat_board()


def judged(seed: int, bump_m: float = 0.0) -> dict:
    """pose.json of a scene, by `paper-lm`."""
    hits, stations, board = recording(seed, bump_m)
    settings = CalibrationSettings(estimators=("paper-lm",), optics=("factory",))
    factories = [station.factory for station in stations]
    found = calibrate(hits, board, factories, settings)
    return summary(found, stations, duration_s=8.0, resolution_s=SAMPLE_S)
