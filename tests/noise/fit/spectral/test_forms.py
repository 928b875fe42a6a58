"""The likelihood of frames that are averages over the frame period: bins, bounds, estimates."""

import numpy as np
import pytest

from mocap_metrology.noise.fit.spectral.fisher import crlb, model_of, spectrum_of
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, bins_of
from mocap_metrology.noise.fit.spectral.whittle import Likelihood
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid

RATE, N = 120.0, 1 << 16
TAU0 = 1 / RATE
PARTS = (PowerLaw(-2, 1e-8), PowerLaw(-1, 1e-7), PowerLaw(0, 1e-6), PowerLaw(2, 1e-12))
TERMS = (GaussMarkov(0.02, 0.006), GaussMarkov(0.01, 0.3))


@pytest.mark.parametrize("form", ["sampled", "continuous"])
def test_expected_periodogram_is_the_models_spectrum(form):
    model = NoiseModel((*PARTS, *TERMS), form)
    bins = bins_of(N, RATE, form=form)
    data = Periodogram(bins, np.ones(bins.n.size), bins.n.astype(float))
    found = Likelihood(data, (TAU0 / 2, N * TAU0)).density(spectrum_of(model))
    fast = bins.centre_hz > 0.1  # slower, the ends count
    assert found[fast] == pytest.approx(model.psd(bins.centre_hz[fast], RATE), rel=2e-3)
    assert model_of(spectrum_of(model), form).psd(1.0, RATE) == pytest.approx(model.psd(1.0, RATE))


def test_the_bound_is_that_of_the_form():
    # By sums over frequencies: T Int (dlnS/dp_i)(dlnS/dp_j) df, derivatives by differences
    step, f = 1e-4, (np.arange(N) + 0.5) / (2 * N * TAU0)
    for form in ("sampled", "continuous"):
        model = NoiseModel((PowerLaw(0, 1e-6), GaussMarkov(0.02, 0.006)), form)
        values = model.coefficients()
        slopes = []
        for name in values:
            ends = [
                NoiseModel.from_coefficients(values | {name: values[name] * (1 + s)}, form)
                for s in (-step, step)
            ]
            low, high = (np.log(end.psd(f, RATE)) for end in ends)
            slopes.append((high - low) / (2 * step))
        information = np.array(slopes) @ np.array(slopes).T / 2
        expected = np.sqrt(np.diag(np.linalg.inv(information))) * list(values.values())
        assert list(crlb(model, N, RATE).values()) == pytest.approx(expected, rel=0.01)


def test_the_bound_of_an_averaged_sinusoid_is_of_its_height_before():
    line, white = Sinusoid(1.0, 48.0), PowerLaw(0, 1e-3)
    plain = crlb(NoiseModel((line, white)), N, RATE)
    averaged = crlb(NoiseModel((line, white), "continuous"), N, RATE)
    assert averaged["A_s"] == pytest.approx(plain["A_s"] / np.sinc(48 / 120))
    assert averaged["f_0"] == pytest.approx(plain["f_0"] / np.sinc(48 / 120))
