"""Curves beside data against closed forms and scipy."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.model.curves import (
    density_interval,
    density_residual,
    drawn_m,
    line_density,
    recorded_s,
    sinusoid_avar,
    spectrum_of,
    total_avar,
)
from mocap_metrology.noise.model.deterministic import Deterministic

RATE = 100.0
M = np.array([1, 3, 10, 100, 1000])


def test_duration_of_a_series_by_the_terms_of_its_curve() -> None:
    """n frames have n - 2m + 1 terms; gaps take some at small m."""
    columns = {"m": M[:4], "n_terms": np.array([4000, 4500, 5000 - 19, 5000 - 199])}
    assert recorded_s(columns, RATE) == 50.0
    assert recorded_s({"m": M[:0], "n_terms": M[:0]}, RATE) == 0.0


@pytest.mark.parametrize("last", [1, 2, 50, 4000])
def test_a_model_is_drawn_at_every_small_factor_and_120_a_decade(last: int) -> None:
    m = drawn_m(last)
    assert m[0] == 1 and m[-1] == max(last, 2)
    assert (np.diff(m) >= 1).all()
    assert np.diff(np.log10(m[m > 60])).max(initial=0.0) < 2.1 / 120
    assert m[m <= 50].tolist() == list(range(1, min(max(last, 2), 50) + 1))
    assert m.size < 60 + 120 * math.log10(max(last, 2))


def test_a_curve_is_the_sum_of_its_parts() -> None:
    """White h f_N / m, a walk of 2 pi^2 h m tau0 (2 m^2 + 1) / (6 m^2), a line of the drift."""
    tau = M / RATE
    white, walk, drift = PowerLaw(0, 2e-6), PowerLaw(-2, 3e-6), Deterministic(drift=7.2)
    found = total_avar([white, walk, drift], M, RATE, "sampled", 100.0)
    expected = 1e-6 / tau + 2 * math.pi**2 * 3e-6 * tau * (2 + M**-2.0) / 6 + (2e-3 * tau) ** 2 / 2
    assert found == pytest.approx(expected, rel=1e-6)
    term = GaussMarkov(0.1, 2.0)
    assert total_avar([term], M, RATE, "sampled") == pytest.approx(term.avar(M, RATE, "sampled"))
    warm = Deterministic(A_w=1.0, T_w=3.0)
    assert total_avar([warm], M, RATE, "sampled", 50.0) == pytest.approx(warm.avar(tau, 50.0))


def test_positions_of_a_drift_and_a_warm_up_and_their_means() -> None:
    t = np.array([0.0, 900.0, 3600.0])
    slow = Deterministic(drift=7.2, A_w=1.5, T_w=1000.0)
    assert slow.at(t) == pytest.approx(7.2 * t / 3600 + 1.5 * np.exp(-t / 1000))
    fine = slow.at(t[:, None] + np.linspace(0, 50, 20_001)).mean(axis=1)
    assert slow.means(t, 50.0) == pytest.approx(fine, rel=1e-6)


@pytest.mark.parametrize("form", ["sampled", "continuous"])
def test_beyond_six_periods_a_sinusoid_is_its_envelope(form: str) -> None:
    """Of the Allan variance A^2 sin^4(pi f tau) / (m sin(pi f tau0))^2, or with pi f tau0."""
    line = Sinusoid(0.3, 1.0)
    m = np.array([50, 599, 600, 601, 650, 1234])
    x = math.pi / RATE
    gain = math.sin(x) if form == "sampled" else x
    envelope = 0.09 / (m * gain) ** 2
    found = sinusoid_avar(line, m, RATE, form)
    assert found[3:] == pytest.approx(envelope[3:])
    whole = envelope * np.sin(x * m) ** 4
    assert found[:3] == pytest.approx(whole[:3], rel=1e-6, abs=1e-20)
    folded = Sinusoid(0.3, RATE)  # falls on zero
    assert np.isfinite(sinusoid_avar(folded, m, RATE, "sampled")).all()


COLUMNS = {
    "f_hz": np.array([0.0, 0.4, 2.0, 3.0, 4.0, 5.0]),
    "f_lower_hz": np.array([0.0, 0.3, 1.0, 2.5, 3.5, 4.5]),
    "f_upper_hz": np.array([0.0, 0.5, 2.5, 3.5, 4.5, 5.5]),
    "psd_mm2_hz": np.array([1.0, 2.0, 3.0, np.nan, 0.0, 5.0]),
    "dof": np.array([2.0, 0.5, 8.0, 4.0, 6.0, 0.0]),
}


def test_bins_with_a_density() -> None:
    """Not at zero frequency, without degrees of freedom, or without a density."""
    assert spectrum_of(COLUMNS)["f_hz"].tolist() == [0.4, 2.0, 4.0]


def test_intervals_of_a_density_are_of_chi_squared() -> None:
    rows = spectrum_of(COLUMNS)
    dof, psd = rows["dof"].to_numpy(), rows["psd_mm2_hz"].to_numpy()
    low, high = density_interval(rows, 0.9)
    assert low == pytest.approx(psd * dof / chi2.ppf(0.95, dof))
    assert high == pytest.approx(psd * dof / chi2.ppf(0.05, dof))


def test_a_line_has_its_power_in_its_bin_alone() -> None:
    rows = spectrum_of(COLUMNS)
    for f_0, bins in ((1.0, [0, 1, 0]), (2.49, [0, 1, 0]), (2.5, [0, 0, 0]), (0.3, [1, 0, 0])):
        found = line_density(rows, Sinusoid(0.2, f_0), RATE, "sampled")
        width = (rows["f_upper_hz"] - rows["f_lower_hz"]).to_numpy()
        assert found * width == pytest.approx(0.02 * np.array(bins))
    averaged = line_density(rows, Sinusoid(0.2, 2.0), 8.0, "continuous")
    assert averaged[1] * 1.5 == pytest.approx(0.02 * np.sinc(0.25) ** 2)


def test_residuals_are_in_standard_deviations_of_a_bin() -> None:
    rows = spectrum_of(COLUMNS)
    found = density_residual(rows, NoiseModel((PowerLaw(0, 2.0),)), RATE)
    assert found == pytest.approx([0.0, 0.5 / math.sqrt(2 / 8), -1 / math.sqrt(2 / 6)])
    assert np.isnan(density_residual(rows, NoiseModel(), RATE)).all()
