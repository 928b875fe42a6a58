"""Columns of the stored results of a calibration, to and from the records of this package."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mocap_metrology.lighthouse.records import Hits, Path, Pulses

# Few distinct values, or long runs of one.
PULSES_CODED = ("diode", "length_us")
SWEEPS_CODED = ("station", "axis", "diode", "width_us")


def pulses(given: Pulses) -> dict[str, np.ndarray]:
    """pulses.parquet: rising edge, length, diode."""
    return {
        "start_s": given.start_s,
        "length_us": (1e6 * given.length_s).astype(np.float32),
        "diode": given.diode,
    }


def sweeps(hits: Hits) -> dict[str, np.ndarray]:
    """sweeps.parquet: one row a hit that was kept."""
    return {
        "station": hits.station,
        "axis": hits.axis,
        "cycle": hits.cycle,
        "diode": hits.diode,
        "time_s": hits.time_s,
        "angle_rad": hits.angle_rad,
        "width_us": (1e6 * hits.width_s).astype(np.float32),
    }


def hits_of(columns: Mapping[str, np.ndarray]) -> Hits:
    """Hits out of sweeps.parquet."""
    whole = {name: columns[name] for name in ("station", "axis", "cycle", "diode")}
    return Hits(
        **whole,
        time_s=columns["time_s"],
        angle_rad=columns["angle_rad"],
        width_s=1e-6 * columns["width_us"].astype(np.float64),
    )


def poses(paths: Mapping[tuple[str, str], tuple[Path, Path]]) -> dict[str, np.ndarray]:
    """poses.parquet: board poses in the frame of each station, of every estimator and optics."""
    from scipy.spatial.transform import Rotation

    parts: dict[str, list[np.ndarray]] = {}
    for (estimator, optics), both in paths.items():
        for station, path in enumerate(both):
            n = len(path)
            q = Rotation.from_matrix(path.R).as_quat(canonical=True) if n else np.zeros((0, 4))
            own = {
                "estimator": np.full(n, estimator, dtype=object),
                "optics": np.full(n, optics, dtype=object),
                "station": np.full(n, station, dtype=np.int8),
                "time_s": path.time_s,
                **dict(zip(("x_m", "y_m", "z_m"), path.t_m.T, strict=True)),
                **dict(zip(("qx", "qy", "qz", "qw"), q.T, strict=True)),
                "epsilon_rad2": path.epsilon,
                "n_angles": np.asarray(path.n_angles, dtype=np.int32),
                "ambiguity": path.ambiguity,
            }
            for name, values in own.items():
                parts.setdefault(name, []).append(values)
    return {name: np.concatenate(values) for name, values in parts.items()}
