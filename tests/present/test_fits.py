"""Figure of a fit: what is drawn is data, model, components and residuals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from figure_data import ODD_TEXT, check, every_text
from noise_data import RATE, TAU0, allan_arrays, assert_texts_apart, estimate, periodogram_arrays

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.fit.estimates import Coefficient, Estimate
from mocap_metrology.noise.fit.estimates import rows as noise_csv
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.present.fits import model as fit_model
from mocap_metrology.present.fits.fit_figure import MODEL, UNDER, fit_figure, part_styles
from mocap_metrology.present.fits.fit_figure import OTHERS as LOOKS_OF_OTHERS
from mocap_metrology.present.plot.figure import GREY, LOOKS

pytestmark = pytest.mark.filterwarnings("error")
MODEL_Z1 = published_row("T40", 10)["z1"].ordered()
MAIN, OTHERS = "likelihood", ("annealing-ant-colony", "levenberg-marquardt")


def figure(model=MODEL_Z1, others=OTHERS, title="t", note="n", **changed):
    estimates = {
        name: noise_csv("z1", estimate(model, name, 0.01, k))
        for k, name in enumerate((MAIN, *others))
    }
    data = {
        "allan": allan_arrays(model),
        "periodogram": periodogram_arrays(model),
        "estimates": estimates,
    } | changed
    made = fit_figure(
        title,
        data["allan"],
        data["periodogram"],
        data["estimates"],
        RATE,
        note,
        main=MAIN,
        lines_subtracted=False,
    )
    return made, data


def panels(made, letters):
    """Axes by their letters: (a) and (b) curves, (c) and (d) residuals, (e) and (f) others."""
    named = {axes.get_title(loc="left")[1]: axes for axes in made.figure.axes}
    return [named[letter] for letter in letters]


def lines_of(axes, **how):
    return [
        line
        for line in axes.lines
        if all(getattr(line, f"get_{key}")() == value for key, value in how.items())
    ]


def drawn_model(axes):
    return next(
        x for x in axes.lines if (x.get_linewidth(), x.get_color()) == (1.5, MODEL["color"])
    )


def avar_of(values: dict[str, float], m: np.ndarray) -> np.ndarray:
    """Allan variance of point samples in closed form, or summed over the autocovariance."""
    found = np.zeros(m.size)
    if "h_0" in values:
        found += values["h_0"] / (2 * m * TAU0)
    if "h_-2" in values:  # a walk whose steps have the variance 2 pi^2 tau0 h
        found += 2 * np.pi**2 * TAU0 * values["h_-2"] * (2 * m**2 + 1) / (6 * m)
    for name in (k for k in values if k.startswith("q_c")):
        q_c, T_c = values[name], values["T_c" + name[3:]]
        found += [correlated_avar(q_c**2 * T_c / 2, math.exp(-TAU0 / T_c), k) for k in m.tolist()]
    if "A_s" in values:
        x = np.pi * values["f_0"] * TAU0
        found += (values["A_s"] * np.sin(m * x) ** 2 / (m * np.sin(x))) ** 2
    return found


def correlated_avar(variance: float, phi: float, m: int) -> float:
    """Half the variance of the difference of two means of m terms of an AR(1) series: the weights
    +1, -1 with themselves are 2m - 3k at lag k < m, and k - 2m up to 2m."""
    lag = np.arange(2 * m)
    weight = np.where(lag < m, 2.0 * m - 3 * lag, lag - 2.0 * m)
    covariance = variance * phi**lag
    return float(weight[0] * covariance[0] + 2 * weight[1:] @ covariance[1:]) / (2 * m**2)


def psd_of(values: dict[str, float], f: np.ndarray) -> np.ndarray:
    """One-sided spectrum of point samples, without the line: aliases summed in closed form."""
    found = np.full(f.size, values.get("h_0", 0.0))
    if "h_-2" in values:
        found += values["h_-2"] * (np.pi * TAU0 / np.sin(np.pi * f * TAU0)) ** 2
    for name in (k for k in values if k.startswith("q_c")):
        q_c, T_c = values[name], values["T_c" + name[3:]]
        phi = math.exp(-TAU0 / T_c)
        turn = np.abs(1 - phi * np.exp(-2j * np.pi * f * TAU0)) ** 2
        found += 2 * TAU0 * (q_c**2 * T_c / 2) * (1 - phi**2) / turn
    return found


MODEL_4 = NoiseModel(
    (PowerLaw(-2, 3e-9), PowerLaw(0, 1.3e-6), GaussMarkov(0.0187, 0.1), GaussMarkov(0.0017, 7.7),
     Sinusoid(0.0036, 14.4))
)  # fmt: skip


def fitted(data) -> dict[str, float]:
    """Numbers in the rows of the main estimator."""
    return {row["parameter"]: row["value"] for row in data["estimates"][MAIN]}


def test_data_and_models_are_those_given() -> None:
    made, data = figure(MODEL_4)
    allan, psd, below, residual = panels(made, "abcd")
    points = lines_of(allan, marker="o")[0].get_xydata()
    assert np.array_equal(points[:, 0], data["allan"]["tau_s"])
    assert np.array_equal(points[:, 1], data["allan"]["adev_mm"])
    values = fitted(data)
    x, y = drawn_model(allan).get_data()
    m = np.round(x / TAU0).astype(int)
    assert np.allclose(m * TAU0, x) and m[0] == 1 and m[-1] == data["allan"]["m"][-1]
    assert np.isfinite(y).mean() > 0.9
    near = np.isfinite(y) & (m < 20_000)
    assert near.sum() > 100
    assert np.allclose(y[near], np.sqrt(avar_of(values, m[near])), rtol=1e-7)
    f, s = drawn_model(psd).get_data()
    assert np.allclose(s, psd_of(values, f), rtol=1e-9)
    spectrum = data["periodogram"]
    assert np.array_equal(lines_of(psd, marker="o")[0].get_ydata(), spectrum["psd_mm2_hz"])
    # Residuals: in per cent of the model, and in standard deviations
    off = lines_of(below, marker="o")[0].get_ydata()
    near = data["allan"]["m"] < 20_000
    expected = np.sqrt(avar_of(values, data["allan"]["m"][near]))
    assert np.allclose(off[near], 100 * (data["allan"]["adev_mm"][near] / expected - 1))
    sigma = lines_of(residual, marker="o")[0].get_ydata()
    smooth = spectrum["psd_mm2_hz"] / psd_of(values, spectrum["f_hz"]) - 1
    smooth *= np.sqrt(spectrum["dof"] / 2)
    held = np.isfinite(sigma)
    away = held & ~((spectrum["f_lower_hz"] < 15) & (spectrum["f_upper_hz"] > 13))
    assert held.mean() > 0.8 and np.allclose(sigma[away], smooth[away])


def test_every_component_is_drawn() -> None:
    """In the colour of its kind: power laws, Gauss-Markov terms, the sinusoid."""
    made, data = figure(MODEL_4, others=())
    values = fitted(data)
    kinds = {"h_-2": "x", "h_0": "x", "q_c1": "y", "q_c2": "y", "A_s": "z"}
    for name, kind in kinds.items():
        partner = {"q": "T_c" + name[3:], "A": "f_0"}.get(name[0], name)
        own = {k: values[k] for k in (name, partner)}
        drawn = [
            line.get_data()
            for line in panels(made, "a")[0].lines
            if line.get_lw() == 1 and line.get_color() == LOOKS[kind].colour
        ]
        few = 40 if name == "A_s" else 200  # periods too narrow to draw come as their envelope
        same = 0
        for x, y in drawn:
            expected = np.sqrt(avar_of(own, np.round(x[:few] / TAU0).astype(int)))
            shown = np.isfinite(y[:few])
            same += bool(shown.any()) and np.allclose(y[:few][shown], expected[shown], rtol=1e-6)
        assert same == 1, name


def test_every_component_is_named_with_its_value() -> None:
    made, data = figure(others=())
    texts, values = " ".join(every_text(made)).replace("\n", " "), fitted(data)
    for k, decimals in ((1, 4), (2, 5), (3, 5)):
        assert f"GM {k}: $q_c$ {values[f'q_c{k}']:.{decimals}f} mm/√s" in texts
    assert f"GM 4: $q_c$ {values['q_c4'] / 1e-4:.2f}×10⁻⁴ mm/√s" in texts
    assert f"h₋₂ {values['h_-2'] / 1e-9:.2f}×10⁻⁹ mm² Hz" in texts
    assert f"h₀ {values['h_0'] / 1e-6:.2f}×10⁻⁶ mm²/Hz" in texts
    assert f"sinusoid: $A_s$ {values['A_s']:.5f} mm" in texts
    assert "h₁ < 1.00×10⁻¹¹ mm²/Hz²" in texts and "h₂ <" in texts
    assert [texts.count(f"({kind})") for kind in ("short", "medium", "long")] == [2, 1, 1]


@pytest.mark.parametrize(
    ("error", "text"), [(3.1e-8, "f₀ 14.4 Hz"), (0.0104, "f₀ 14.400 ± 0.010 Hz")]
)
def test_the_error_of_a_frequency_is_written_where_it_matters(error, text) -> None:
    values = {"A_s": (0.0036, 1e-5), "f_0": (14.4 + 1e-9, error)}
    found = tuple(Coefficient(name, *numbers) for name, numbers in values.items())
    rows = noise_csv("z1", Estimate(MAIN, "sampled", found, 0.0))
    assert fit_model.fit_of(MAIN, rows).parts[0].text.endswith(text)


def test_other_estimators_are_told_apart() -> None:
    """By colour, and from the components, which have colours of their own."""
    made, data = figure(others=(*OTHERS, "slopes"))
    fit = fit_model.fit_of(MAIN, data["estimates"][MAIN])
    colours = [look["color"] for look in LOOKS_OF_OTHERS]
    assert len(set(colours)) == len(colours) >= 4
    assert not set(colours) & {how["color"] for how in part_styles(fit)}
    for axes in panels(made, "ef"):
        assert set(colours[: len(OTHERS) + 1]) <= {line.get_color() for line in axes.lines}
    for axes in panels(made, "abcd"):
        assert not set(colours) & {line.get_color() for line in axes.lines} - {GREY}
    assert "beyond on a logarithmic one" in " ".join(every_text(made)).replace("\n", " ")


def test_the_line_in_the_spectrum_is_a_stem_as_high_as_its_share() -> None:
    model = NoiseModel((PowerLaw(0, 1e-6), Sinusoid(0.01, 7.0)))
    made, data = figure(model, others=())
    spectrum = fit_model.spectrum_of(data["periodogram"])
    values = fitted(data)
    line = Sinusoid(values["A_s"], values["f_0"])
    low, high = spectrum["f_lower_hz"], spectrum["f_upper_hz"]
    inside = ((low <= line.f_0) & (line.f_0 < high)).to_numpy()
    assert inside.sum() == 1
    width = (high - low)[inside].item()
    (top,) = lines_of(panels(made, "b")[0], marker="D")
    assert top.get_xdata()[0] == line.f_0
    assert top.get_ydata()[0] == pytest.approx(values["h_0"] + line.A_s**2 / 2 / width)
    found = NoiseModel((PowerLaw(0, values["h_0"]), line))
    psd, dof = spectrum["psd_mm2_hz"].to_numpy(), spectrum["dof"].to_numpy()
    for lines, more in ((True, line.A_s**2 / 2 / width), (False, 0.0)):
        expected = values["h_0"] + inside * more
        sigma = (psd / expected - 1) / np.sqrt(2 / dof)
        assert np.allclose(fit_model.residual(spectrum, found, RATE, lines), sigma, rtol=1e-9)


def test_residuals_of_the_true_model_are_standard() -> None:
    model = NoiseModel((PowerLaw(-2, 1e-9), PowerLaw(0, 1e-6), GaussMarkov(0.01, 1.0)))
    spectrum = fit_model.spectrum_of(periodogram_arrays(model, per_decade=100))
    residual = fit_model.residual(spectrum, model, RATE, True)[spectrum["dof"] > 20]
    assert abs(residual.mean()) < 0.2 and residual.std() == pytest.approx(1.0, abs=0.15)
    low, high = fit_model.interval(spectrum, 0.683)
    truth = model.psd(spectrum["f_hz"].to_numpy(), RATE)
    share = np.mean((low < truth) & (truth < high))
    assert share == pytest.approx(0.683, abs=0.07)


def test_model_curves_are_those_of_the_model() -> None:
    m = fit_model.drawn_m(1_000_000)
    assert m[0] == 1 and m[-1] == 1_000_000 and np.all(np.diff(m) > 0)
    for form in ("sampled", "continuous"):
        ours = fit_model.total_avar(MODEL_Z1.components, m, RATE, form)
        assert np.allclose(ours, MODEL_Z1.avar(m, RATE, form), rtol=1e-12)
        line = MODEL_Z1.lines[0]
        drawn = fit_model.drawn_avar(line, m, RATE, form)
        exact = line.avar(m, RATE, form)
        assert np.array_equal(drawn[:40], exact[:40]) and np.all(drawn >= exact * (1 - 1e-12))


ODD = {
    "nothing": {},
    "no main": {"slopes": 1.0},
    "main alone": {MAIN: 1.0},
}


@pytest.mark.parametrize("case", ODD)
def test_missing_estimates(case) -> None:
    estimates = {name: noise_csv("z1", estimate(MODEL_Z1, name, 0.01, 1)) for name in ODD[case]}
    made, _ = figure(estimates=estimates, title=ODD_TEXT, note=ODD_TEXT)
    check(made, draw=case == "nothing")
    assert (f"No estimate by {MAIN}." in " ".join(every_text(made))) == (case != "main alone")


@pytest.mark.parametrize("case", ["empty", "gaps", "nothing detected", "not finite", "half a term"])
def test_odd_data(case) -> None:
    changed: dict = {}
    if case == "empty":
        changed["allan"] = {k: np.array([]) for k in allan_arrays(MODEL_Z1)}
        changed["periodogram"] = {k: np.array([]) for k in periodogram_arrays(MODEL_Z1)}
    elif case == "gaps":
        allan, spectrum = allan_arrays(MODEL_Z1), periodogram_arrays(MODEL_Z1)
        allan["adev_mm"][::3] = np.nan
        allan["adev_upper_mm"][1::3] = np.inf
        spectrum["psd_mm2_hz"][::4] = np.nan
        spectrum["psd_mm2_hz"][1] = 0.0
        changed = {"allan": allan, "periodogram": spectrum}
    else:
        rows = noise_csv("z1", estimate(MODEL_Z1, MAIN, 0.01, 1))
        if case == "nothing detected":
            for row in rows:
                row |= {"value": math.nan, "status": "not_detected", "upper_95": 1.0}
        elif case == "not finite":
            rows[0]["value"], rows[2]["std_error"] = math.nan, math.nan
        else:
            rows = [row for row in rows if row["parameter"] != "q_c2"] + [
                row | {"value": math.nan} for row in rows if row["parameter"] == "q_c2"
            ]
        changed["estimates"] = {MAIN: rows}
    made, _ = figure(**changed)
    check(made)
    if case == "empty":
        assert every_text(made).count("no valid samples") == 2
    if case == "half a term":
        assert not any("GM 2" in text for text in every_text(made))
        assert any("GM 3" in text for text in every_text(made))


def test_a_misfit_is_named_once_and_its_residuals_counted_beside_no_other_text() -> None:
    rows = [row | {"status": "misfit"} for row in noise_csv("z1", estimate(MODEL_Z1, MAIN, 2.0, 3))]
    made, data = figure(estimates={MAIN: rows})
    texts = every_text(made)
    assert texts[:-1].count("misfit") == 1 and not any("±" in text for text in texts[:-1])
    (counted,) = (text for text in texts if text.endswith(" beyond 6 σ"))
    fit = fit_model.fit_of(MAIN, rows)
    spectrum = fit_model.spectrum_of(data["periodogram"])
    sigma = fit_model.residual(spectrum, fit.model, RATE, True)
    assert int(counted.split()[0]) == np.count_nonzero(np.abs(sigma) > 6) > 0
    check(made)
    assert_titles_apart(made)


def assert_titles_apart(made) -> None:
    """The title of a panel does not run into the remark at its right."""
    for axes in made.figure.axes:
        left, right = axes._left_title, axes._right_title
        if left.get_text() and right.get_text():
            assert left.get_window_extent().x1 < right.get_window_extent().x0


@pytest.mark.parametrize(
    ("kind", "n", "series"), [("T40", 10, "z1"), ("T40", 2, "y1"), ("Vantage", 10, "L")]
)
def test_no_text_touches_another(kind, n, series) -> None:
    made, _ = figure(published_row(kind, n)[series], title="T40-2, y1: noise")
    check(made)
    assert_texts_apart(made)


def test_labels_of_a_short_axis_keep_clear_of_its_name() -> None:
    white = NoiseModel((PowerLaw(0, 1e-8),))
    made, _ = figure(white, allan=allan_arrays(white, last=20))
    axes = panels(made, "a")[0]
    made.figure.draw_without_rendering()
    assert any(text.get_text().startswith("5×") for text in axes.get_yticklabels())
    check(made)


SECONDS = 600
T = np.arange(round(SECONDS / TAU0)) * TAU0
WHITE = NoiseModel((PowerLaw(0, 5e-5),))


@pytest.mark.parametrize(
    ("under", "wave", "text"),
    [
        ({"drift": -1.2}, -1.2 * T / 3600, "drift −1.20 mm/h ±3 %"),
        (
            {"A_w": 0.2, "T_w": 60.0},
            0.2 * np.exp(-T / 60),
            "warm-up: $A_w$ 0.200 mm ±3 %, $T_w$ 60.0",
        ),
        (
            {"drift": 3.0, "A_w": 0.2, "T_w": 20.0},
            3.0 * T / 3600 + 0.2 * np.exp(-T / 20),
            "drift 3.00 mm/h ±3 %, $A_w$ 0.200 mm ±3 %, $T_w$ 20.0 s",
        ),
    ],
    ids=lambda value: "" if isinstance(value, np.ndarray) else None,
)
def test_what_lies_under_the_noise_is_in_the_model_of_the_allan_deviation(under, wave, text):
    """Data: white noise's textbook Allan variance and that of the samples of the wave."""
    found = [
        Coefficient(name, v, 0.03 * abs(v)) for name, v in (WHITE.coefficients() | under).items()
    ]
    rows = noise_csv("z1", Estimate(MAIN, "sampled", tuple(found), 0.0))
    last = T.size // 3
    m = fit_model.drawn_m(last)
    own = allan_variance(wave, m)
    adev = np.sqrt(WHITE.components[0].h / (2 * m * TAU0) + own.variance)
    assert adev[-1] > 5 * np.sqrt(WHITE.avar(m, RATE)[-1])
    names = ("m", "tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "n_terms")
    values = (m, m * TAU0, adev, 0.95 * adev, 1.05 * adev, own.n_terms)
    made, _ = figure(
        WHITE,
        allan=dict(zip(names, values, strict=True)),
        periodogram=periodogram_arrays(WHITE, n=T.size),
        estimates={MAIN: rows},
    )
    allan, psd, below, _ = panels(made, "abcd")
    x, y = drawn_model(allan).get_data()
    assert np.allclose(x, m * TAU0) and np.allclose(y, adev, rtol=5e-3)
    assert np.abs(lines_of(below, marker="o")[0].get_ydata()).max() < 0.5  # per cent
    (drawn,) = lines_of(allan, color=UNDER["color"], linewidth=1.0)
    shown = np.isfinite(drawn.get_ydata())
    assert shown[-100:].all()
    assert np.allclose(drawn.get_ydata()[shown], np.sqrt(own.variance)[shown], rtol=5e-3)
    assert not lines_of(psd, color=UNDER["color"], linewidth=1.0)
    assert np.allclose(drawn_model(psd).get_ydata(), WHITE.components[0].h)
    said = every_text(made)
    assert any(one.startswith(text) for one in said)
    assert "of the data and of the model" in " ".join(said).replace("\n", " ")
    check(made)
    assert_texts_apart(made)


def test_a_line_that_wanders_is_named_with_its_width() -> None:
    values = {"h_0": 1e-4, "A_s": 0.015, "f_0": 50.0, "width_f": 0.018}
    rows = [
        {
            "parameter": name,
            "value": value,
            "std_error": value / 10,
            "status": "ok",
            "model": "sampled",
        }
        for name, value in values.items()
    ]
    fit = fit_model.fit_of(MAIN, [row | {"estimator": MAIN} for row in rows])
    (line,) = [part for part in fit.parts if part.name == "sinusoid"]
    assert "$width_f$ 0.0180 Hz" in line.text
    assert "$A_s$ 0.0150 mm" in line.text


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_curve_knows_how_long_its_series_is(share) -> None:
    rng = np.random.default_rng(1)
    series = rng.normal(size=5000)
    series[rng.random(5000) < share] = np.nan
    m = np.array([1, 10, 100, 1000])
    columns = {"m": m, "n_terms": allan_variance(series, m).n_terms}
    assert fit_model.recorded_s(columns, 100.0) == pytest.approx(50)
    assert fit_model.recorded_s({k: v[:0] for k, v in columns.items()}, 100.0) == 0
