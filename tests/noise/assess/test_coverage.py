"""Expected and measured spread of means: by hand, covariances written out, Monte Carlo."""

import functools
import math

import numpy as np
import pytest
from scipy import stats

from mocap_metrology.common.parallel import in_turn
from mocap_metrology.noise.assess.measured import Measured, measured_spread, measured_within
from mocap_metrology.noise.assess.recording import Inputs, assess_recording
from mocap_metrology.noise.assess.spread import expected_spread, spread
from mocap_metrology.noise.assess.uncertainty import Span, assess_series
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.fit.estimates import rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.model.components import (
    FORMS,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)
from mocap_metrology.noise.model.synthesis import circle_length, draw, increment_spectrum
from mocap_metrology.settings import Verdict as Limits

RATE, TAU0 = 100.0, 0.01
COMPONENTS = (
    *(PowerLaw(-2, 1e-6), PowerLaw(-1, 1e-5), PowerLaw(0, 1e-5), PowerLaw(1, 1e-7)),
    *(PowerLaw(2, 1e-9), GaussMarkov(0.05, 0.02), GaussMarkov(0.05, 3.0), GaussMarkov(0.05, 1e4)),
)
CURVE = {k: np.array([]) for k in ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")}


NYQUIST, FINE = 0.5 / TAU0, 1 << 17
EDGES = np.geomspace(1e-9, 40 * NYQUIST / FINE, 20001)
F_HZ = np.append((EDGES[1:] + EDGES[:-1]) / 2, (np.arange(40, FINE) + 0.5) / FINE * NYQUIST)
DF_HZ = np.append(np.diff(EDGES), np.full(FINE - 40, NYQUIST / FINE))


@functools.cache
def lagged(k: int) -> np.ndarray:
    """1 - cos 2 pi f k tau0"""
    return 2 * np.sin(np.pi * F_HZ * k * TAU0) ** 2


def written_out(component: PowerLaw | GaussMarkov, n: int, N: int, form: Form) -> float:
    """Mean over the N/n stretches of Var(mean of n - mean of N) = -sum w_i w_j D(i - j): weights
    that add up to 0, D(k) = Int S(f) (1 - cos 2 pi f k tau0) df the variogram."""
    power = component.psd(F_HZ, RATE, form=form) * DF_HZ
    variogram = [power @ lagged(k) for k in range(N)]
    D = np.array(variogram)[np.abs(np.subtract.outer(np.arange(N), np.arange(N)))]
    weights = np.repeat(np.eye(N // n), n, axis=1) / n - 1 / N
    return float(np.mean([-(w @ D @ w) for w in weights]))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("component", COMPONENTS, ids=str)
def test_spread_is_that_of_the_covariances(component: PowerLaw, form: Form) -> None:
    """And, over octaves, half the sum of the Allan variances."""
    for n, N, within in ((1, 64, 1e-4), (20, 60, 3e-3)):
        expected = written_out(component, n, N, form)
        assert spread(component, n, N, RATE, form) == pytest.approx(expected, rel=within)
    assert spread(PowerLaw(1, 0.0), 1, 64, RATE, form) == 0
    halves = component.avar(2.0 ** np.arange(3, 10), RATE, form).sum() / 2
    assert spread(component, 8, 1024, RATE, form) == pytest.approx(halves, rel=2e-6)


@pytest.mark.parametrize("confidence", [0.683, 0.95])
def test_interval_of_white_noise(confidence: float) -> None:
    """ln u of n frames: normal, of variance 1 / (2 n)."""
    found = expected_spread(NoiseModel((PowerLaw(0, 1e-5),)), 1, 9, RATE, 20_000, confidence)
    reach = stats.norm.ppf((1 + confidence) / 2) * math.sqrt(0.5 / 20_000)
    assert np.log([found.lower, found.upper]) - math.log(found.value) == pytest.approx(
        [-reach, reach], rel=1e-3
    )
    assert not any(vars(expected_spread(NoiseModel(()), 1, 9, RATE, 99, confidence)).values())
    low, high = Measured(4.0, 7.0).interval(confidence)  # 7 * 4 / truth is chi-squared
    expected = [28 / stats.chi2(7).ppf((1 + s * confidence) / 2) for s in (1, -1)]
    assert [low**2, high**2] == pytest.approx(expected)


@pytest.mark.parametrize("wide", [True, False])
def test_a_wide_line_is_as_uncertain_as_its_row_states(wide: bool) -> None:
    """68 % interval of the scatter of a frame. Of a wide line: as sqrt(sigma^2 + A_s^2 / 2)
    scatters if A_s does by its row; of a sinusoid, whose row is ignored: by sqrt(S / T)
    [Rife & Boorstyn 1974]."""
    rng, A_s, error, sigma = np.random.default_rng(3), 0.02, 0.0012, 0.01
    series = rng.normal(0, sigma, 60_000) + A_s * np.sin(2 * np.pi * 7.3 * TAU0 * np.arange(60_000))
    values = {"h_0": 2 * TAU0 * sigma**2, "A_s": A_s, "f_0": 7.3} | (
        {"width_f": 0.02} if wide else {}
    )
    table = [
        {"parameter": k, "value": v, "std_error": error, "status": "ok", "model": "sampled"}
        for k, v in values.items()
    ]
    found = assess_series(series, table, CURVE, Span(RATE))
    assert found.basis == "model"
    heights = rng.normal(A_s, error if wide else math.sqrt(2 * TAU0 * sigma**2 / 600), 100_000)
    levels = sigma**2 * (1 + rng.normal(0, math.sqrt(2 / 60_000), 100_000))
    expected = np.std(np.log(levels + heights**2 / 2)) / 2
    for end, sign in ((found.sigma_frame_upper_mm, 1), (found.sigma_frame_lower_mm, -1)):
        assert math.log(end / found.sigma_frame_mm) == pytest.approx(sign * expected, rel=0.03)


MIXED = (PowerLaw(-2, 2e-7), PowerLaw(0, 2e-5), GaussMarkov(0.05, 0.3))
# Noise -> relative tolerance of the degrees of freedom of means and of frames within a second
NOISES = {
    "white": ((PowerLaw(0, 2e-5),), 0.3, 0.3),
    "walk": ((PowerLaw(-2, 2e-7),), 0.55, 0.3),  # two or three degrees of freedom
    "correlated": ((GaussMarkov(0.05, 0.3),), 0.55, 0.5),
    "mixed": (MIXED, 0.55, 0.5),
}


@pytest.mark.parametrize("name", NOISES)
def test_measured_is_as_expected_on_average(name: str) -> None:
    """300 recordings of 40 s: mean squares within four standard errors, with gaps within 10 %, and
    degrees of freedom that state how much they scatter."""
    components, *tolerances = NOISES[name]
    n, N, length = 100, 2000, circle_length(4000)
    spectrum = increment_spectrum(NoiseModel(components), length, RATE)
    found: list[list[Measured]] = [[], [], []]
    for seed in range(300):
        rng = np.random.default_rng(seed)
        series = draw(spectrum, 4000, length, RATE, rng)
        found[0].append(measured_spread(series, n, N))
        found[1].append(measured_within(series, n))
        series[rng.random(4000) < 0.2] = math.nan
        found[2].append(measured_spread(series, n, N))
    of_means = sum(spread(c, n, N, RATE) for c in components)
    of_frames = sum(spread(c, 1, n, RATE) for c in components) * n / (n - 1)
    for measured, truth, within in zip(found, (of_means, of_frames), tolerances, strict=False):
        squares = np.array([m.variance for m in measured])
        assert squares.mean() == pytest.approx(truth, abs=4 * squares.std() / math.sqrt(300))
        dof = 2 * squares.mean() ** 2 / squares.var()
        assert np.median([m.edf for m in measured]) == pytest.approx(dof, rel=within)
    with_gaps = np.mean([m.variance for m in found[2]])
    fewer = 1.25 if name == "white" else 1.0  # frames of a mean
    assert with_gaps == pytest.approx(fewer * np.mean([m.variance for m in found[0]]), rel=0.1)


# Noise, duration, recordings; least and greatest share that 68 % intervals hold, least of 95 %
SHIPPED = [
    ("mixed", MIXED, 120.0, 12, (0.45, 1.0, 0.75)),
    ("white", (PowerLaw(0, 1e-5),), 120.0, 200, (0.58, 1.0, 0.9)),
    ("flicker", (PowerLaw(-1, 1e-4),), 120.0, 200, (0.85, 1.0, 0.95)),
    ("weak walk", (PowerLaw(-2, 1e-8), PowerLaw(0, 1e-5)), 120.0, 200, (0.58, 1.0, 0.85)),
    ("mixed, more", MIXED, 120.0, 200, (0.58, 0.9, 0.8)),
    ("slow", (PowerLaw(0, 1e-5), GaussMarkov(2e-6**0.5, 100.0)), 600.0, 60, (0.58, 1.0, 0.85)),
]


@pytest.mark.parametrize(
    ("components", "duration_s", "runs", "limits"),
    [pytest.param(*case[1:], id=case[0], marks=[pytest.mark.study] if k else [])
     for k, case in enumerate(SHIPPED)],
)  # fmt: skip
def test_intervals_as_shipped(components, duration_s: float, runs: int, limits) -> None:
    """Components chosen by BIC, means of a frame, 1, 10 and 60 s about that of the recording: 68 %
    and 95 % intervals hold the truth (three standard errors); of the mixture those of the model
    alone fail for means of a minute, as it often lacks the walk."""
    N = round(duration_s * RATE)
    length = circle_length(N)
    spectrum = increment_spectrum(NoiseModel(components), length, RATE)
    frames = [1, 100, 1000, 6000]
    truth = [math.sqrt(sum(spread(c, n, N, RATE) for c in components)) for n in frames]
    held, alone = np.zeros((2, 4)), 0
    for seed in range(runs):
        series = draw(spectrum, N, length, RATE, np.random.default_rng([seed, N]))
        estimate = likelihood(series, RATE).estimate
        for level, confidence in enumerate((0.683, 0.95)):
            found = assess_series(
                series, rows("x1", estimate), CURVE, Span(RATE, confidence=confidence)
            )
            ends = [(found.frame_lower_mm, found.frame_upper_mm)]
            ends += [(mean.lower_mm, mean.upper_mm) for mean in found.means]
            held[level] += [low <= u <= high for u, (low, high) in zip(truth, ends, strict=True)]
        own = expected_spread(estimate.model, 6000, N, RATE, N, 0.95)
        alone += own.lower <= truth[3] <= own.upper
    low, high, low_95 = np.array(limits) * runs
    assert ((low <= held[0]) & (held[0] <= high)).all() and (held[1] >= low_95).all()
    assert components is not MIXED or alone <= 0.75 * runs


X = np.array([0.0, 4, 0, 4, 0, 4, 1, 3, 1, 3, 1, 3, 90, 0, 0, 0, 0, 90])


def test_two_frames_make_a_variance_and_one_none() -> None:
    assert measured_within(np.array([1.0, 3.0]), 2).variance == 2.0
    assert measured_within(np.array([1.0, 3.0, 1.0, 5.0]), 1).variance == 5.0  # of two at least
    one = np.array([1.0, np.nan, np.nan, 3.0])
    for series in (one[:1], one):
        assert math.isnan(measured_within(series, 2).variance)


def test_spread_of_means_about_their_mean() -> None:
    """Means of 2 of 8 frames: 2, 2, 4, 0: variance 2 with the number of them; half of the frames,
    and half of the means, must be there."""
    x = np.array([0.0, 4, 1, 3, 3, 5, 0, 0])
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([2, 2, 4, 0]))
    assert measured_spread(np.tile(x, 3), 2, 8).variance == pytest.approx(2.0)
    x[1] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([0, 2, 4, 0]))
    x[0] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([2, 4, 0]))
    x[2:4] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([4, 0]))
    x[4:6] = np.nan
    assert math.isnan(measured_spread(x, 2, 8).variance)
    assert math.isnan(measured_spread(X, 10, 19).variance)
    assert measured_spread(np.ones(8), 2, 8) == Measured(0.0, 1.0)


@pytest.mark.parametrize(("each", "measured"), [(8, True), (11, False)])
def test_a_thousand_frames_of_a_long_stretch_are_enough(each: int, measured: bool) -> None:
    x = np.full(10_000, np.nan)
    x[::each] = np.random.default_rng(4).normal(size=x[::each].size)
    variance = measured_spread(x, 1, x.size).variance
    assert variance == pytest.approx(np.nanvar(x)) if measured else math.isnan(variance)


@pytest.mark.parametrize("n", [1, 5, 40])
def test_spread_of_a_sinusoid(n: int) -> None:
    """A^2/2 times the squared means of n and of N points of exp(2 pi i f t)."""
    rate, N = 50.0, 200

    def gain(count: int, f: float) -> float:
        return abs(np.exp(2j * math.pi * f * np.arange(count) / rate).mean()) ** 2

    for f, size in ((3.3, 2), (25.0, 1), (50.0, 2)):
        line = 0.04 / size * (gain(n, f) - gain(N, f))
        assert spread(Sinusoid(0.2, f), n, N, rate) == pytest.approx(line, abs=1e-12)


def test_a_walk_is_not_named_where_the_wander_is_of_another_kind() -> None:
    """Of two series alike the one with a cycle among its findings has slow wander, the other a
    random walk; its mean over all time is no number."""
    rng, rate = np.random.default_rng(3), 20.0
    rows, series = [], {}
    for name in ("x1", "y1", "z1"):
        values = 0.02 * rng.standard_normal(4000) + 4e-3 * np.cumsum(rng.standard_normal(4000))
        series[name] = values
        walk = 16e-6 * rate / (2 * math.pi**2)
        for parameter, value in (("h_0", 8e-4 / rate), ("h_-2", walk)):
            rows.append({"series": name, "estimator": "likelihood", "parameter": parameter,
                         "value": value, "status": "ok"})  # fmt: skip
    keys = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")
    allan = {k: np.array([1.0]) for k in keys}
    allan |= {"series": np.array(["x1"]), "estimator": np.array(["oadev"])}
    inputs = Inputs(series.items(), ["A"], rows, allan, [], [Finding("cycle", "x1", 30.0)])
    found = assess_recording(inputs, Span(rate, horizon_s=200.0), Limits(), in_turn).series
    kinds = {name: {one.kind for one in of.kinds} for name, of in found.items()}
    assert "slow wander" in kinds["x1"] and "random walk" not in kinds["x1"]
    for name in ("y1", "z1"):
        assert "random walk" in kinds[name] and "slow wander" not in kinds[name]
