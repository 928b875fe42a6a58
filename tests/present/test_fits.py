"""Figure of a fit: what is drawn is data, model, components and residuals."""

import math

import numpy as np
import pytest
from figure_data import check, every_text
from noise_data import RATE, TAU0, allan_arrays, estimate, periodogram_arrays

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.fit.estimates import Coefficient, Estimate
from mocap_metrology.noise.fit.estimates import rows as noise_csv
from mocap_metrology.noise.model import curves
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.present.fits import fit_figure
from mocap_metrology.present.plot.figure import INK, LOOKS, Texts

pytestmark = pytest.mark.filterwarnings("error")
MODEL_Z1 = published_row("T40", 10)["z1"].ordered()
MODEL_4 = NoiseModel(
    (PowerLaw(-2, 3e-9), PowerLaw(0, 1.3e-6), GaussMarkov(0.0187, 0.1), GaussMarkov(0.0017, 7.7),
     Sinusoid(0.0036, 14.4))
)  # fmt: skip
WHITE = NoiseModel((PowerLaw(0, 5e-5),))
MAIN, OTHERS = "likelihood", ("annealing-ant-colony", "levenberg-marquardt")


def figure(model=MODEL_Z1, others=OTHERS, title="t", **changed):
    estimates = {
        name: noise_csv("z1", estimate(model, name, 0.01, k))
        for k, name in enumerate((MAIN, *others))
    }
    data = {"allan": allan_arrays(model), "periodogram": periodogram_arrays(model)}
    data |= {"estimates": estimates} | changed
    return fit_figure(Texts(title, title), *data.values(), RATE, 0.683), data


def panels(made, letters):
    """Axes by their letters: (a) and (b) curves, (c) and (d) residuals, (e) and (f) others."""
    named = {axes.get_title(loc="left")[1]: axes for axes in made.figure.axes}
    return [named[letter] for letter in letters]


def lines(axes, **how):
    """(x, y) of the lines with these properties."""
    wanted = [
        line for line in axes.lines if all(getattr(line, f"get_{k}")() == v for k, v in how.items())
    ]
    return [np.array(line.get_data()) for line in wanted]


def test_curves_and_residuals_are_those_of_the_model() -> None:
    """Data; the model, whose closed forms `tests/noise/model` checks, and each component in the
    colour of its kind; residuals in per cent and in standard deviations; the sinusoid as a stem as
    high as its share of the bin."""
    made, data = figure(MODEL_4)
    allan, psd, below, residual = panels(made, "abcd")
    values = {row["parameter"]: row["value"] for row in data["estimates"][MAIN]}
    model, m = NoiseModel.from_coefficients(values), data["allan"]["m"]
    (points,) = lines(allan, marker="o")
    assert np.array_equal(points, [data["allan"]["tau_s"], data["allan"]["adev_mm"]])
    ((tau, adev),) = lines(allan, linewidth=1.5)
    drawn_m = np.round(tau / TAU0).astype(int)
    assert (drawn_m[0], drawn_m[-1]) == (1, m[-1]) and np.allclose(drawn_m * TAU0, tau)
    assert np.allclose(adev, np.sqrt(model.avar(drawn_m, RATE)), rtol=1e-7)
    ((_, off),) = lines(below, marker="o")
    expected = np.sqrt(model.avar(m, RATE))
    assert np.allclose(off, 100 * (data["allan"]["adev_mm"] / expected - 1))
    drawn = [xy for axis in "xyz" for xy in lines(allan, color=LOOKS[axis].colour)]
    for (_, adev), component in zip(drawn, model.components, strict=True):
        exact = np.sqrt(component.avar(drawn_m[:40], RATE))
        assert np.allclose(adev[:40], exact), component
    ((f, density),) = lines(psd, linewidth=1.5)
    assert np.allclose(density, model.psd(f, RATE), rtol=1e-9)
    spectrum = data["periodogram"]
    assert np.array_equal(lines(psd, marker="o")[0][1], spectrum["psd_mm2_hz"])
    sigma = spectrum["psd_mm2_hz"] / model.psd(spectrum["f_hz"], RATE) - 1
    sigma *= np.sqrt(spectrum["dof"] / 2)
    ((f, shown),) = lines(residual, marker="o")
    assert np.array_equal(f, spectrum["f_hz"][np.abs(sigma) <= 6])
    assert np.allclose(shown, sigma[np.abs(sigma) <= 6], rtol=1e-6)
    (line,), low, high = model.lines, spectrum["f_lower_hz"], spectrum["f_upper_hz"]
    (width,) = (high - low)[(low <= line.f_0) & (line.f_0 < high)]
    (((at,), (top,)),) = lines(psd, marker="D")
    assert at == line.f_0
    assert top == pytest.approx(model.psd(at, RATE) + line.A_s**2 / 2 / width)


def rows_of_main() -> list[dict]:
    return noise_csv("z1", estimate(MODEL_Z1, MAIN, 0.01, 1))


@pytest.mark.parametrize("case", ["empty", "gaps", "nothing detected", "half a term"])
def test_odd_data(case) -> None:
    allan, spectrum, rows = allan_arrays(MODEL_Z1), periodogram_arrays(MODEL_Z1), rows_of_main()
    if case == "empty":
        allan, spectrum = ({k: v[:0] for k, v in of.items()} for of in (allan, spectrum))
    elif case == "gaps":
        allan["adev_mm"][::3] = np.nan
        allan["adev_upper_mm"][1::3] = np.inf
        spectrum["psd_mm2_hz"][::4] = np.nan
        spectrum["psd_mm2_hz"][1] = 0.0
        rows[2]["std_error"] = math.nan
    for row in rows:
        if case == "nothing detected":
            row |= {"value": math.nan, "status": "not_detected", "upper_95": 1.0}
        elif case == "half a term" and row["parameter"] == "q_c2":
            row["value"] = math.nan
    made, _ = figure(allan=allan, periodogram=spectrum, estimates={MAIN: rows})
    check(made)
    texts = every_text(made)
    assert texts.count("no valid samples") == 2 * (case == "empty")
    terms = [k for k in range(1, 5) if any(text.startswith(f"GM {k}:") for text in texts)]
    assert terms == {"nothing detected": [], "half a term": [1, 3, 4]}.get(case, [1, 2, 3, 4])


T = np.arange(round(600 / TAU0)) * TAU0


@pytest.mark.parametrize(
    ("slow", "wave"),
    [
        ({"drift": -1.2}, -1.2 * T / 3600),
        ({"A_w": 0.2, "T_w": 60.0}, 0.2 * np.exp(-T / 60)),
        ({"drift": 3.0, "A_w": 0.2, "T_w": 20.0}, 3.0 * T / 3600 + 0.2 * np.exp(-T / 20)),
    ],
)
def test_what_lies_under_the_noise_is_in_the_model_of_the_allan_deviation(slow, wave):
    """Data: white noise's textbook Allan variance and that of the samples of the wave."""
    found = [Coefficient(n, v, 0.03 * abs(v)) for n, v in (WHITE.coefficients() | slow).items()]
    m = curves.drawn_m(T.size // 3)
    own = allan_variance(wave, m)
    adev = np.sqrt(5e-5 / (2 * m * TAU0) + own.variance)
    assert adev[-1] > 5 * np.sqrt(WHITE.avar(m, RATE)[-1])
    names = ("m", "tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "n_terms")
    values = (m, m * TAU0, adev, 0.95 * adev, 1.05 * adev, own.n_terms)
    made, _ = figure(
        allan=dict(zip(names, values, strict=True)),
        periodogram=periodogram_arrays(WHITE, n=T.size),
        estimates={MAIN: noise_csv("z1", Estimate(MAIN, "sampled", tuple(found), 0.0))},
    )
    allan, psd, below, _ = panels(made, "abcd")
    ((_, model),) = lines(allan, linewidth=1.5)
    assert np.allclose(model, adev, rtol=5e-3)
    assert np.abs(lines(below, marker="o")[0][1]).max() < 0.5  # per cent
    ((_, drawn),) = lines(allan, color=INK, linewidth=1.0)
    assert np.allclose(drawn, np.sqrt(own.variance), rtol=5e-3)
    assert not lines(psd, color=INK, linewidth=1.0)
    assert np.allclose(lines(psd, linewidth=1.5)[0][1], 5e-5)
