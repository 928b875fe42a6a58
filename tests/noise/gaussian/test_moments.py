"""Moments of finite recordings: closed forms against spectra, draws against full simulation."""

import math
from itertools import pairwise

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping
from scipy.integrate import quad

from mocap_metrology.common.hampel import hampel, white_level_kept
from mocap_metrology.noise.gaussian.moments import (
    QUANTITIES,
    Cleaning,
    direction,
    expected_moments,
    expected_variance,
    mean_variance,
    pair_moments,
)
from mocap_metrology.noise.gaussian.two_markers import gaussian_model
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import Cross, draw_pair
from mocap_metrology.noise.twins.twin import Twin
from tests.noise.model.textbook import density

RATE = 120.0
TAU0 = 1 / RATE
SIGMAS = ("sigma_1", "sigma_2", "sigma_L", "sigma_12")


def twin(kind: str = "Vantage", n_cameras: int = 9, **more) -> Twin:
    published = {"camera_type": kind, "n_cameras": n_cameras}
    return twin_from_mapping({"published": published, "seed": 1, **more}, "t")


def by_spectrum(density, T: float, f_h: float) -> tuple[float, float]:
    """Sample variance and mean square of mean less first point as integrals over a spectrum."""

    def window(f: float) -> tuple[float, float]:
        low = np.sinc(f * T)
        return 1 - low**2, abs(1 - np.exp(1j * math.pi * f * T) * low) ** 2

    edges = np.concatenate([[0], np.arange(1, 200) / T, np.geomspace(200 / T, f_h, 60)])

    def part(k: int) -> float:
        return sum(
            quad(lambda f: density(f) * window(f)[k], a, b, limit=400)[0]
            for a, b in pairwise(edges)
        )

    return part(0), part(1)


@pytest.mark.parametrize(
    "part",
    [*(PowerLaw(alpha, 1e-6) for alpha in (-2, -1, 0, 1, 2)), GaussMarkov(2e-3, 5.0),
     GaussMarkov(2e-3, 400.0)],
    ids=str,
)  # fmt: skip
def test_closed_forms_are_integrals_over_the_spectrum(part) -> None:
    T, f_h = 60.0, 60.0

    found = by_spectrum(lambda f: float(density(part, f)) if f > 0 else 0.0, T, f_h)
    model = NoiseModel((part,))
    assert expected_variance(model, T, 2 * f_h) == pytest.approx(found[0], rel=2e-3)
    assert mean_variance(model, T, 2 * f_h) == pytest.approx(found[1], rel=2e-3)


def full_rate(of: Twin, repeats: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The same quantities from every frame of simulated recordings."""
    n, (u_x, u_y, u_z) = round(of.duration_s * of.frame_rate_hz), direction(of)
    assert u_z == 0
    cross = Cross(of.models["L"], of.coherence_factor)
    (line,) = of.models["L"].lines
    found = []
    for _ in range(repeats):
        x1, x2 = draw_pair(of.models["x1"], of.models["x2"], cross, n, RATE, rng)
        wave = np.sin(2 * np.pi * (line.f_0 * np.arange(n) * TAU0 + rng.uniform()))
        wave *= line.A_s / 2
        x1, x2 = x1 + wave - wave[0], x2 - wave + wave[0]
        x1, x2 = x1 * of.scale.get("x1", 1.0), x2 * of.scale.get("x2", 1.0)
        y1, y2 = draw_pair(
            of.models["y1"], of.models["y2"], Cross(constant=of.yz_coherence), n, RATE, rng
        )
        model = gaussian_model(x1, x2, u_x * (x1 - x2) + u_y * (of.scale["y1"] * y1 - y2))
        found.append([getattr(model, name) for name in QUANTITIES])
    columns = dict(zip(QUANTITIES, np.array(found).T, strict=True))
    return columns | {"mu_e": columns["mu_1"] - columns["mu_2"]}


def kurtosis(values: np.ndarray) -> float:
    """Of a sample; (kurtosis - 1) / 4n is the relative variance of its standard deviation."""
    return float(np.mean((values - values.mean()) ** 4) / values.var() ** 2)


def test_slow_parts_alone_have_the_distribution_of_all_frames() -> None:
    """Means, spreads and quartiles over realisations, every 35th frame drawn against every one."""
    of = twin(
        *("T40", 10),
        **{"scale": {"x1": 1.06, "y1": 0.8}, "coherence_factor": 0.74, "yz_coherence": 0.4},
        **{"start_mm": [[100, 30, 0], [0, 0, 0]], "duration_s": 150},
    )
    slow = pair_moments(of, 400, np.random.default_rng(1), slow_samples=512)
    full = full_rate(of, 250, np.random.default_rng(3))
    for name in QUANTITIES:
        a, b = slow[name], full[name]
        error = math.sqrt(a.var() / a.size + b.var() / b.size)
        assert abs(a.mean() - b.mean()) < 4 * error, name
        error = math.sqrt(sum((kurtosis(v) - 1) / (4 * v.size) for v in (a, b)))
        assert abs(a.std() / b.std() - 1) < 4 * error < 0.45, name
        quartiles = np.quantile(a, [0.25, 0.75]) - np.quantile(b, [0.25, 0.75])
        assert np.abs(quartiles).max() < 0.42 * b.std(), name  # 3.8 errors


def test_a_filter_takes_what_it_is_said_to() -> None:
    """The Hampel filter on full recordings without outliers against `Cleaning`."""
    of = twin("T40", 10, duration_s=400, start_mm=[[160, 0, 0], [0, 0, 0]])
    _, kept = white_level_kept(3.0, 120)
    n, rng = 48_000, np.random.default_rng(7)
    lost = []
    for _ in range(8):
        x1, x2 = draw_pair(of.models["x1"], of.models["x2"], Cross(of.models["L"]), n, RATE, rng)
        raw = gaussian_model(x1, x2, x1 - x2)
        c1, c2, c_L = (hampel(x, 120).values for x in (x1, x2, x1 - x2))
        clean = gaussian_model(c1, c2, c_L)
        lost.append([raw.sigma_1**2 - clean.sigma_1**2, raw.sigma_2**2 - clean.sigma_2**2,
                     raw.sigma_L**2 - clean.sigma_L**2, raw.sigma_12 - clean.sigma_12])  # fmt: skip
    same = [np.random.default_rng(3) for _ in range(2)]
    raw = pair_moments(of, 3, same[0])
    clean = pair_moments(of, 3, same[1], Cleaning(kept, 0.5))
    said = [np.mean(raw[k] ** 2 - clean[k] ** 2) for k in SIGMAS[:3]]
    said.append(np.mean(raw["sigma_12"] - clean["sigma_12"]))
    assert np.mean(lost, axis=0) == pytest.approx(said, rel=0.2)
    assert said[2] > 4e-6


@pytest.mark.parametrize("scale", [{}, {"x1": 1.3, "x2": 0.8}])
def test_moments_of_a_twin_are_those_of_its_models(scale: dict[str, float]) -> None:
    """The distance has the variance of its own model, and V(L) = V(x1) + V(x2) - 2 C(x1, x2)."""
    made = twin(duration_s=3600, scale=scale)
    found = expected_moments(made)
    a, b = scale.get("x1", 1.0), scale.get("x2", 1.0)

    def of(series: str) -> float:
        return expected_variance(made.models[series], made.duration_s, made.frame_rate_hz)

    v_1, v_2, v_L = of("x1"), of("x2"), of("L")
    assert found["sigma_1"] == pytest.approx(a * math.sqrt(v_1))
    assert found["sigma_2"] == pytest.approx(b * math.sqrt(v_2))
    common = a * b * (v_1 + v_2 - v_L) / 2 * made.coherence_factor
    assert found["sigma_12"] == pytest.approx(common)
    assert found["sigma_L"] ** 2 == pytest.approx(a * a * v_1 + b * b * v_2 - 2 * common)
    of_mean = mean_variance(made.models["x1"], made.duration_s, made.frame_rate_hz)
    assert found["mu_1"] == pytest.approx(a * math.sqrt(of_mean))
