"""Made-up recordings for tests of groups and papers: rows of the sheet, Allan deviations in closed
form, rows of noise.csv and spectra by published models, perturbed."""

import math

import numpy as np

from mocap_metrology.noise.fit.estimates import Coefficient, Estimate, rows
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import SERIES, published_keys, published_row

RATE = 120.0
TAU0 = 1 / RATE
PAPER, DEFAULT = "annealing-ant-colony", "likelihood"


def estimate(model: NoiseModel, estimator: str, spread: float, seed: int) -> Estimate:
    """An estimate of so much relative scatter; power laws below 1e-12 are not detected."""
    rng = np.random.default_rng(seed)
    coefficients = []
    for name, value in model.ordered().coefficients().items():
        if estimator == DEFAULT and name.startswith("h_") and value < 1e-12:
            found = Coefficient(
                name, math.nan, upper_95=1e-11, detected=False, status="not_detected"
            )
        else:
            at = value * math.exp(spread * rng.standard_normal())
            ends = [at * math.exp(k * spread) for k in (-1, 1, -2, 2)]
            found = Coefficient(name, at, at * spread, at * spread, *ends)
        coefficients.append(found)
    form = "sampled" if estimator == DEFAULT else "continuous"
    return Estimate(estimator, form, tuple(coefficients), 0.0)


def noise_rows(models, spread: float = 0.05, seed: int = 1) -> list[dict]:
    """noise.csv of one recording, by the paper's estimator and the default one."""
    made = []
    for k, (series, model) in enumerate(models.items()):
        for j, estimator in enumerate((PAPER, DEFAULT)):
            made += rows(series, estimate(model, estimator, spread, 100 * seed + 10 * k + j))
    return made


def group(keys=None):
    """Sheet, noise and expected (with least standard errors: 10 % of a coefficient, of h_-1 and
    h_2 twenty times) for `table_a`, of all published rows or of some."""
    sheet, noise, expected = {}, {}, {}
    for k, (kind, n) in enumerate(published_keys() if keys is None else keys):
        name, models = f"{kind}-{n}", published_row(kind, n)
        row = {"recording": name, "twin": name, "camera_type": kind, "n_cameras": n}
        sheet[name] = row
        noise[name] = noise_rows(models, seed=k)
        expected[name] = [r for r in noise_rows(models, 0.01, k) if r["estimator"] == PAPER]
        expected[name] += [
            {"series": series, "estimator": "published", "parameter": parameter}
            | {"crlb": value * (20.0 if parameter in ("h_-1", "h_2") else 0.1)}
            for series in SERIES
            for parameter, value in models[series].coefficients().items()
        ]
    return sheet, noise, expected


def allan_arrays(model: NoiseModel, n: int = 101, last: int = 1_296_000, seed: int = 3):
    """Allan deviations of one series scattered about a model as nine hours would."""
    rng = np.random.default_rng(seed)
    m = np.unique(np.geomspace(1, last, n).astype(int))
    edf = np.maximum(2.0 * last / m, 1.5)
    width = np.minimum(np.sqrt(0.5 / edf), 0.45)
    adev = np.sqrt(model.avar(m, RATE)) * (1 + width * np.clip(rng.standard_normal(m.size), -2, 2))
    return {
        "m": m,
        "tau_s": m * TAU0,
        "adev_mm": adev,
        "adev_lower_mm": adev * (1 - width),
        "adev_upper_mm": adev * (1 + width),
        "n_terms": 3 * last - 2 * m + 1,
    }


def periodogram_arrays(model: NoiseModel, per_decade: int = 40, n: int = 3_888_000, seed: int = 4):
    """Binned periodogram of one series about a model, the line in its bin."""
    rng = np.random.default_rng(seed)
    count = n // 2
    edges = np.unique(np.geomspace(1, count, int(np.log10(count) * per_decade)).astype(int))
    first, last = edges[:-1], edges[1:] - 1
    step = 1 / (n * TAU0)
    f, dof = step * (first + last) / 2, 2.0 * (last - first + 1)
    psd = model.psd(f, RATE) * rng.chisquare(dof) / dof
    lower, upper = step * (first - 0.5), step * (last + 0.5)
    for line in model.lines:
        inside = (lower <= line.f_0) & (line.f_0 < upper)
        psd[inside] += line.A_s**2 / 2 / (upper - lower)[inside]
    columns = ("f_hz", "f_lower_hz", "f_upper_hz", "psd_mm2_hz", "dof")
    return dict(zip(columns, (f, lower, upper, psd, dof), strict=True))


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
