"""The public names of the package, for a notebook: `import mocap_metrology as mm`.

Lengths are in mm, times in s, frequencies in Hz; positions are (markers, 3, frames), NaN where a
marker was not seen. A file that cannot be used raises `Refusal`, whose text is one line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import hampel
from mocap_metrology.io.read import labels_of, read_recording
from mocap_metrology.io.recording import Recording
from mocap_metrology.io.units import Unit
from mocap_metrology.lighthouse.calibrate import jansen
from mocap_metrology.lighthouse.calibrate.scene import Sensors
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.records import PoseEstimate
from mocap_metrology.noise.allan.confidence import AllanCurve, allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.changes.compare import Curve, adev_ratio
from mocap_metrology.noise.coefficients import coefficients as noise
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.series import all_series
from mocap_metrology.noise.twins import simulate as twins
from mocap_metrology.noise.twins.twin import COORDINATES, Twin
from mocap_metrology.settings import Settings

__all__ = ["Recording", "Refusal", "Settings", "allan", "calibrate", "check", "clean", "compare"]
__all__ += ["labels", "noise", "read", "series", "simulate"]
PathLike = str | Path


def labels(path: PathLike) -> tuple[str, ...]:
    """Labels of the markers in a file, in its order."""
    return labels_of(path)


def read(
    path: PathLike | Sequence[PathLike],
    markers: Sequence[str] = (),
    *,
    rate_hz: float | None = None,
    unit: Unit | None = None,
) -> Recording:
    """Positions of these markers (default: of all that are seen) in a file, or in the segments of
    one take. rate_hz, unit: where the file states none."""
    paths = [path] if isinstance(path, str | Path) else list(path)
    return read_recording(paths, markers, rate_hz, unit=unit)


def series(recording: Recording) -> dict[str, np.ndarray]:
    """`x1`, `y1`, `z1`, `x2`, ... and the distance `L` of the first two markers, (frames,), mm."""
    names = [f"{axis}{k}" for k in range(1, len(recording.labels) + 1) for axis in "xyz"]
    values = recording.position_mm.reshape(len(names), -1).astype(float)
    pairs = [(1, 2)] if len(recording.labels) > 1 else []
    return dict(all_series(dict(zip(names, values, strict=True)), pairs))


def clean(values: np.ndarray, rate_hz: float, n_sigma: float = 3.0) -> np.ndarray:
    """A series whose outliers are replaced by the local median (Hampel filter over one second to
    each side, S 3.2)."""
    return hampel(np.asarray(values, float), max(round(rate_hz), 1), n_sigma).values


def allan(values: np.ndarray, rate_hz: float) -> pd.DataFrame:
    """Overlapping Allan deviations of a series: `tau_s`, `adev_mm`, with 68.3 % intervals
    `adev_lower_mm` and `adev_upper_mm`, and equivalent degrees of freedom `edf`."""
    curve = _scattered(values, rate_hz)
    columns = {"tau_s": curve.tau_s, "adev_mm": curve.deviation, "edf": curve.edf}
    return pd.DataFrame(columns | {"adev_lower_mm": curve.lower, "adev_upper_mm": curve.upper})


def _scattered(values: np.ndarray, rate_hz: float) -> AllanCurve:
    samples = np.asarray(values, float)
    return allan_curve(samples, rate_hz, averaging_factors(len(values))).as_scattered(samples)


def compare(new: np.ndarray, old: np.ndarray, rate_hz: float) -> pd.DataFrame:
    """Allan deviations of two series at the averaging times of both: `tau_s`, `ratio` of new to
    old, its 95 % interval (`adev_ratio`), `lower_95`, `upper_95`, and `p` of no change."""
    curves = (_scattered(one, rate_hz) for one in (new, old))
    first, second = (Curve(c.tau_s, c.deviation, c.edf, c.stretches) for c in curves)
    ratio = adev_ratio(first, second, np.intersect1d(first.tau_s, second.tau_s))
    ends = {"lower_95": ratio.lower, "upper_95": ratio.upper, "p": ratio.p}
    return pd.DataFrame({"tau_s": ratio.tau_s, "ratio": ratio.value} | ends).dropna()


def check(
    path: PathLike, markers: Sequence[str], folder: PathLike, settings: Settings | None = None
) -> Mapping[str, Any]:
    """Verdict, diagnosis and figures of a recording into a folder, as the command `check` makes
    them; returns the contents of verdict.json (`word`, `reason`, `series`, `findings`, ...)."""
    from mocap_metrology.recording import analyse, clean, progress

    Path(folder).mkdir(parents=True, exist_ok=True)
    entry, name = clean.Entry([str(path)], list(markers)), Path(path).stem
    of, quiet = settings or Settings(), progress.Progress()
    return analyse.analyse(entry, name, Path(folder), of, lambda *_: None, quiet)


def simulate(
    coefficients: Mapping[str, float], duration_s: float, rate_hz: float = 120.0, seed: int = 0
) -> twins.SimulatedRecording:
    """A recording of two still markers whose six coordinates have the noise of these coefficients
    (`h_-2` ... `h_2`, `q_c1`, `T_c1`, ..., `A_s`, `f_0`): `position_mm`, `frame_rate_hz`."""
    models = dict.fromkeys(COORDINATES, NoiseModel.from_coefficients(coefficients))
    twin = Twin("simulated", seed, models, duration_s=duration_s, frame_rate_hz=rate_hz)
    return twins.simulate(twin)


def calibrate(dump: PathLike, board: PathLike, kind: str = "gpio-dump") -> PoseEstimate:
    """Pose of the slave in the frame of the master (p_master = R p_slave + t_m) of a recording of a
    board of photodiodes before two V1 base stations. kind: of a sheet's column `format`."""
    decoded = decode(dump, kind, board)
    factory = [station.factory for station in decoded.stations]
    seen = decoded.hits, decoded.board, factory
    estimates = jansen.calibrate(*seen, sensors=Sensors(normals=decoded.normals)).estimates
    index = jansen.chosen(estimates)
    if index is None:
        raise Refusal(f"{Path(dump).name}: no estimator gives a pose of the slave")
    return estimates[index]
