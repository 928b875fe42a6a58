"""Recordings for the tests of families: rows of the sheet, and Allan deviations in closed form."""

import numpy as np
from noise_data import RATE, TAU0

from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import SERIES, published_row

M = np.unique(np.geomspace(1, 1_000_000, 60).astype(int))


def row(name: str, camera_type: str = "T40", n_cameras: int | None = 10, **more) -> dict:
    made = {"recording": name, "camera_type": camera_type, "n_cameras": n_cameras}
    return made | {"twin": None, "compare_with": None, "comment": ""} | more


def allan(models: dict[str, NoiseModel], estimators: tuple[str, ...] = ("oadev",)) -> dict:
    """Columns of allan.parquet: the deviations of models, exactly; 20 % wide intervals."""
    parts = [
        (series, estimator, np.sqrt(model.avar(M, RATE)) * (1 + 0.1 * k))
        for series, model in models.items()
        for k, estimator in enumerate(estimators)
    ]
    adev = np.concatenate([values for *_, values in parts])
    return {
        "series": np.repeat([series for series, *_ in parts], M.size),
        "estimator": np.repeat([estimator for _, estimator, _ in parts], M.size),
        "m": np.tile(M, len(parts)),
        "tau_s": np.tile(M * TAU0, len(parts)),
        "adev_mm": adev,
        "adev_lower_mm": 0.8 * adev,
        "adev_upper_mm": 1.2 * adev,
    }


def published(camera_type: str, n_cameras: int) -> dict:
    """The same of a row of Tables A1-A3."""
    return allan({s: published_row(camera_type, n_cameras)[s] for s in SERIES})


def drawn(axes, width: float = 1.2) -> list[np.ndarray]:
    """Values of the curves of a panel, in the order of drawing."""
    return [
        line.get_ydata()
        for line in axes.lines
        if line.get_linewidth() == width and line.get_ls() != "None" and len(line.get_xdata()) > 2
    ]
