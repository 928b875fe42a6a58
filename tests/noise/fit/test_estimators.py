"""All estimators on one series: what each is given, what is stored, what is refused."""

from __future__ import annotations

import csv
import math
from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_csv
from mocap_metrology.common.hampel import hampel
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
from mocap_metrology.noise.fit.estimates import (
    Components,
    correlation_class,
    model_of,
    refused_rows,
    rows,
)
from mocap_metrology.noise.fit.estimators import (
    NoiseSettings,
    estimate_series,
    expected_estimate,
    panel,
    published_estimate,
    regression,
)
from mocap_metrology.noise.fit.spectral.fisher import crlb
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.deterministic import PARAMETERS
from mocap_metrology.noise.model.synthesis import Cross, draw_pair
from mocap_metrology.noise.series import ALLAN, PERIODOGRAM, allan_columns, periodogram_columns
from mocap_metrology.noise.twins.published import printed_row, published_keys, published_row
from mocap_metrology.settings import Annealing, Noise, Settings

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


def test_the_plain_colony_runs_when_asked_for(series, cleaned, found):
    """In the order asked for, under a name of its own, from the same Allan variances."""
    few = Annealing(starts=2, plain_iterations=20, plain_colony_iterations=100)
    noise = Noise.model_construct(estimators=("annealing-ant-colony-plain", "slopes"))
    settings = NoiseSettings(noise, annealing=few)
    run = estimate_series(series, cleaned, RATE, settings, Components((-2, 0), 1, False))
    plain, _ = run.estimates
    assert plain.estimator == "annealing-ant-colony-plain"
    assert "the colony lowered the cost of the best start" in plain.note
    hybrid = next(e for e in found.estimates if e.estimator == "annealing-ant-colony")
    assert hybrid.cost <= plain.cost < 1.5 * hybrid.cost
    assert plain.values["h_0"] == pytest.approx(hybrid.values["h_0"], rel=0.05)


def test_every_detected_coefficient_has_its_bound(found):
    for estimate in found.estimates:
        for c in estimate.coefficients:
            assert np.isnan(c.crlb) == (not c.detected), (estimate.estimator, c)
    likelihood = next(e for e in found.estimates if e.estimator == "likelihood")
    bounds = crlb(likelihood.model, N, RATE)
    for c in likelihood.coefficients:
        if c.detected and c.parameter not in PARAMETERS:
            assert np.isclose(c.crlb, bounds[c.parameter], rtol=1e-6)


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
    assert tuple(columns) == ALLAN
    assert {len(v) for v in columns.values()} == {run.curve.m.size}
    columns = periodogram_columns("x1", run.periodogram)
    assert tuple(columns) == PERIODOGRAM
    total = columns["dof"].sum()
    assert total == pytest.approx((N - 1) * (1 - np.isnan(masked).mean()))


def test_both_sides_of_figure_6_find_the_truth_of_an_exact_curve():
    """White noise and a random walk without scatter, to 1 %."""
    truth = {"h_0": 1e-6, "h_-2": 4e-9}
    exact = NoiseModel.from_coefficients(truth)
    m = averaging_factors(N, 60, 1, 1 / 3)
    settings = replace(QUICK, noise=Noise(gauss_markov=0, sinusoid=False))
    run, squares = regression(m, exact.avar(m, RATE, "continuous"), RATE, settings, "x1")
    for name, value in truth.items():
        assert run.estimate.values[name] == pytest.approx(value, rel=0.01)
        assert squares.values[name] == pytest.approx(value, rel=0.01)
    assert len(run.starts) == len(run.starts_cost) == QUICK.annealing.starts


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


def test_refused_rows_say_why():
    made = refused_rows("z2", ("likelihood", "slopes"), "12 valid samples")
    assert [(r["estimator"], r["status"], r["note"]) for r in made] == [
        ("likelihood", "refused", "12 valid samples"),
        ("slopes", "refused", "12 valid samples"),
    ]
    assert all(math.isnan(r["value"]) for r in made)
    assert model_of(made).components == ()


def test_panel_is_the_printed_one():
    for kind, n in published_keys():
        for series, printed in printed_row(kind, n).items():
            assert panel(kind, n, series).names == list(printed), (kind, n, series)
    assert panel("T40", 7, "x1") is None
    assert panel("T40", 10, "L_1_3") is None


def test_expected_needs_no_chance_and_published_is_the_truth():
    truth = published_row("Bonita", 8)["y2"]
    m = averaging_factors(N, 60, 1, 1 / 3)
    settings = replace(QUICK, subset=("Bonita", 8), seed=1)
    once, again = (expected_estimate(truth, m, N, RATE, settings, "y2").values for _ in (1, 2))
    assert once == again
    assert {*once} == {*settings.components("y2").names}
    own = published_estimate(truth, N, RATE)
    assert own.values == truth.coefficients()


@pytest.mark.parametrize(
    ("T_c", "name"),
    [(0.004, "short"), (0.99, "short"), (1.0, "medium"), (9.9, "medium"), (10.0, "unclassed"),
     (99.0, "unclassed"), (100.0, "long"), (2000.0, "long")],
)  # fmt: skip
def test_classes(T_c, name):
    assert correlation_class(T_c) == name


def test_settings_come_from_the_configuration(root):
    import yaml

    config = Settings(**yaml.safe_load((root / "config/config.yaml").read_text()))
    found = NoiseSettings.of(config, 120.0, subset=("T40", 10))
    assert found.half_window == 120
    assert (found.noise, found.allan, found.annealing) == (
        config.noise, config.allan, config.annealing,
    )  # fmt: skip
    assert (found.seed, found.subset) == (config.seed, ("T40", 10))
    assert found.components("x1") == panel("T40", 10, "x1")
    assert found.components("L_1_3") == NoiseSettings().components()
