"""Filters against closed forms, against scipy, and against what they do to simulated noise."""

import math

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping
from scipy.signal import butter, filtfilt, sosfreqz

from mocap_metrology.noise.diagnosis.filtering import (
    averaging,
    filtered_avar,
    filters,
    predicted,
    tried,
)
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import simulate

RATE = 120.0
AMONG = filters(RATE, (6.0, 10.0), (14.4,), 1.0)


def white(f):
    return np.full_like(np.asarray(f, float), 2 / RATE)


@pytest.mark.parametrize("one", AMONG, ids=lambda one: one.name)
def test_the_gain_is_scipys(one):
    if one.sos is None:
        pytest.skip("no filter")
    f, h = sosfreqz(one.sos, 500, fs=RATE)
    assert one.gain(f, RATE) == pytest.approx(np.abs(h) ** 2, rel=1e-9, abs=1e-15)
    cutoff = float(one.name.split()[1])
    assert one.gain(np.array([cutoff]), RATE)[0] == pytest.approx(
        0.0 if "notch" in one.name else 0.5, abs=1e-9
    )


@pytest.mark.parametrize("cutoff", [1.0, 2.0])
def test_white_noise_through_a_butterworth_of_fourth_order(cutoff):
    """Int_0^inf dx / (1 + x^4)^2 = 3 pi / (8 sqrt 2): share 2 f_c / rate times that, far below
    Nyquist, where the bilinear transform does not bend frequencies."""
    one = filters(RATE, (cutoff,), (), 1.0)[1]
    share = predicted(white, [], one, averaging(100_000, RATE), RATE).sigma ** 2
    # Ten-second means hold what is slower than 0.05 Hz: 1 / (10 s x rate) of the white variance
    expected = 2 * cutoff / RATE * 3 * math.pi / (8 * math.sqrt(2)) - 1 / (10 * RATE)
    assert share == pytest.approx(expected, rel=0.005)


def test_filtering_is_filtfilt():
    series = np.random.default_rng(3).normal(size=3000) + 1000.0
    one = AMONG[1]
    b, a = butter(2, 6.0, fs=RATE)
    assert one.applied(series, RATE)[300:-300] == pytest.approx(
        filtfilt(b, a, series)[300:-300], abs=1e-7
    )


@pytest.mark.parametrize(
    "part",
    [PowerLaw(-2, 1e-8), PowerLaw(-1, 1e-6), PowerLaw(0, 1e-6), PowerLaw(2, 1e-9),
     GaussMarkov(0.01, 0.3)],
    ids=str,
)  # fmt: skip
def test_without_a_filter_the_allan_variance_is_the_models(part):
    m = averaging(1 << 20, RATE)
    model = NoiseModel((part,))
    found = filtered_avar(lambda f: model.psd(f, RATE), AMONG[0], m, RATE)
    assert found == pytest.approx(model.avar(m, RATE), rel=1e-3)


def test_published_noise_and_its_line_behind_filters():
    """z1 of T40-10: every predicted number is the measured one, and the notch takes the line."""
    twin = twin_from_mapping(
        {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 5}, "T40-10"
    )
    model = published_row("T40", 10)["z1"]
    series = simulate(twin, 1200.0).position_mm[0, 2]
    left = tried("z1", series, RATE, AMONG, lambda f: model.psd(f, RATE), model.lines)
    for one in left:
        assert one.measured.sigma == pytest.approx(one.predicted.sigma, rel=0.03)
        assert one.measured.adev[:3] == pytest.approx(one.predicted.adev[:3], rel=0.05)
    none, notch = left[0].predicted, left[3].predicted
    line = Sinusoid(model.lines[0].A_s, 14.4)
    taken = none.sigma**2 - notch.sigma**2
    assert taken == pytest.approx(line.A_s**2 / 2, rel=0.5)
    assert taken > line.A_s**2 / 2  # and some noise
