"""All estimators on one series: what each is given, what is stored, what is refused."""

import csv
import math

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_csv
from mocap_metrology.common.hampel import hampel
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
from mocap_metrology.noise.fit.estimates import (
    Components,
    correlation_class,
    limit_class,
    model_of,
    rows,
)
from mocap_metrology.noise.fit.estimators import NoiseSettings, estimate_series
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import Cross, draw_pair
from mocap_metrology.noise.series import (
    ALLAN_MASKED,
    PERIODOGRAM,
    allan_columns,
    periodogram_columns,
)
from mocap_metrology.settings import Annealing, Noise

RATE, N = 120.0, 1 << 17
TRUTH = NoiseModel((PowerLaw(-2, 4e-9), PowerLaw(0, 1e-6), GaussMarkov(0.02, 0.3)))
QUICK = NoiseSettings(annealing=Annealing(starts=2, colony_iterations=5))


@pytest.fixture(scope="module")
def series() -> np.ndarray:
    rng = np.random.default_rng(1)
    return draw_pair(TRUTH, TRUTH, Cross(constant=0.0), N, RATE, rng)[0]


@pytest.fixture(scope="module")
def cleaned(series):
    m = averaging_factors(N, 60, 1, 1 / 3)
    return m, allan_variance(hampel(series, 120, 3.0, "replace").values, m).variance


@pytest.fixture(scope="module")
def found(series, cleaned):
    return estimate_series(series, cleaned, RATE, QUICK, Components((-2, 0), 1, False))


def test_every_estimator_gives_the_white_level(found):
    assert [e.estimator for e in found.estimates] == list(Noise().estimators)
    assert found.refused == {}
    near = {"likelihood": 0.01, "annealing-ant-colony": 0.1}
    for estimate in found.estimates:
        value = estimate.values.get("h_0")
        if estimate.estimator in near:
            assert abs(value / 1e-6 - 1) < near[estimate.estimator], estimate.estimator
    forms = {e.estimator: e.form for e in found.estimates}
    assert forms["likelihood"] == "sampled"
    assert forms["annealing-ant-colony"] == forms["levenberg-marquardt"] == "continuous"


def test_rows_go_through_the_file_and_come_back_as_the_model(found, tmp_path):
    table = [row for estimate in found.estimates for row in rows("x1", estimate)]
    write_csv(tmp_path / "noise.csv", table)
    with (tmp_path / "noise.csv").open() as stream:
        back = list(csv.DictReader(stream))
    for estimate in found.estimates:
        own = [row for row in back if row["estimator"] == estimate.estimator]
        assert model_of(own).coefficients() == estimate.model.coefficients()
    columns = "series estimator model parameter value unit std_error crlb lower_68 upper_68"
    assert list(back[0])[:10] == columns.split()
    terms = [row for row in back if row["parameter"] == "T_c1"]
    assert {row["class"] for row in terms} <= {"short", "medium", "long", "unclassed", ""}
    assert terms[0]["unit"] == "s"
    limits = [row for row in back if limit_class(row)]
    assert {row["parameter"][:3] for row in limits} == {"q_c"} and {
        row["status"] for row in limits
    } == {"not_detected"}
    for row in limits:  # "class medium: limit for every T_c from 1 to 10 s"
        low, high = (float(word) for word in row["note"].split() if word[0].isdigit())
        assert correlation_class(math.sqrt(low * high)) == limit_class(row)


def test_stored_curve_is_of_the_series_with_gross_outliers_masked(series, cleaned):
    spiked = series.copy()
    spiked[[1000, 5000, 70_000]] += 1.0
    settings = NoiseSettings(Noise(estimators=("likelihood",)))
    run = estimate_series(spiked, cleaned, RATE, settings)
    masked = hampel(spiked, 120, 6.0, "mask").values
    assert np.isnan(masked).sum() >= 3
    expected = allan_variance(masked, run.curve.m).variance
    assert np.allclose(run.curve.variance, expected, rtol=1e-12)
    columns = allan_columns("x1", run.curve)
    assert tuple(columns) == ALLAN_MASKED
    assert {len(v) for v in columns.values()} == {run.curve.m.size}
    columns = periodogram_columns("x1", run.periodogram)
    assert tuple(columns) == PERIODOGRAM
    total = columns["dof"].sum()
    assert total == pytest.approx((N - 1) * (1 - np.isnan(masked).mean()))


@pytest.mark.parametrize(("step", "hidden"), [(0.04, False), (0.4, True)])
def test_steps_that_hide_the_noise_are_noted_at_the_white_level(cleaned, step, hidden):
    """Noise of 0.1 mm, to which rounding adds step^2 / 12; steps of 0.4 mm are those of a slow
    movement."""
    rng, slow = np.random.default_rng(2), np.linspace(0, 5, 2000)
    rounded = np.round((slow + 0.1 * rng.standard_normal(slow.size)) / step) * step
    simple = Noise(estimators=("likelihood",), max_gauss_markov=0, sinusoid=False)
    settings = NoiseSettings(simple)
    (estimate,) = estimate_series(rounded, cleaned, RATE, settings, resolution=step).estimates
    noted = {c.parameter for c in estimate.coefficients if "hides the noise" in c.note}
    assert noted == ({"h_0"} if hidden else set())
    assert ("hides the noise" in estimate.note) is hidden


def test_one_estimator_may_fail_without_the_others(series):
    few = np.array([1, 2, 4, 8]), np.array([4.0, 2.0, 1.0, 0.5])
    run = estimate_series(series, few, RATE, QUICK)
    assert set(run.refused) >= {"annealing-ant-colony", "levenberg-marquardt"}
    assert "likelihood" in [e.estimator for e in run.estimates]


def test_series_without_noise_is_refused(cleaned):
    mostly_spikes = np.zeros(5000)
    mostly_spikes[::500] = 1.0
    for constant in (np.full(5000, 1.0), mostly_spikes):
        with pytest.raises(Refusal, match="all samples are equal"):
            estimate_series(constant, cleaned, RATE, QUICK)
