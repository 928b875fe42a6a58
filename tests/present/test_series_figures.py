"""Figures 6 and 17 of S: numbers drawn are numbers given, and odd input."""

import numpy as np
import pytest
from figure_data import check
from noise_data import RATE, TAU0, allan_arrays, assert_texts_apart, estimate

from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.present.skurowski.allan_figures import (
    FINAL,
    ORDINARY,
    START,
    periodic_figure,
    regression_figure,
)

pytestmark = pytest.mark.filterwarnings("error")


def regression(n_starts: int = 10, n: int = 101):
    model = published_row("T40", 10)["z1"]
    starts = [estimate(model, "a", 0.1, k).model for k in range(n_starts)]
    data = allan_arrays(model, n)
    ordinary = estimate(model, "a", 0.4, 99).model
    figure = regression_figure(
        (data["tau_s"], data["adev_mm"]), starts, ordinary, model, RATE, ("s", "n"), "continuous"
    )
    return figure, data, starts, ordinary, model


@pytest.mark.parametrize("n_starts", [10, 1, 0])
def test_regression(n_starts) -> None:
    figure, data, starts, ordinary, model = regression(n_starts)
    above, below = figure.body.axes
    for how, models in ((START, starts), (ORDINARY, [ordinary]), (FINAL, [model])):
        lines = [
            x
            for x in above.lines
            if x.get_color() == how["color"] and x.get_lw() == how["lw"] and x.get_xdata().size
        ]
        assert len(lines) == len(models)
        for line, one in zip(lines, models, strict=True):
            x, y = line.get_data()
            expected = np.sqrt(one.avar(x / TAU0, RATE, "continuous"))
            assert np.allclose(y, expected, rtol=1e-9)
            assert np.diff(np.log10(x)).max() < 0.01  # smooth within a few frames too
    points = next(x for x in above.lines if x.get_marker() == "o").get_xydata()
    assert np.array_equal(points, np.column_stack([data["tau_s"], data["adev_mm"]]))
    final = next(x for x in below.lines if x.get_color() == FINAL["color"]).get_ydata()
    curve = np.sqrt(model.avar(data["m"], RATE, "continuous"))
    assert np.allclose(final, 100 * (data["adev_mm"] / curve - 1))
    assert np.abs(final).max() <= below.get_ylim()[1]
    check(figure)
    assert_texts_apart(figure)


def spectra(names, line_hz: float = 14.4):
    f = np.arange(36_001) / 600
    rng = np.random.default_rng(1)
    made = {}
    for k, name in enumerate(names):
        psd = 10.0 ** (k - 6) * (1 + 0.1 * rng.standard_normal(f.size))
        if k == 0:
            psd[round(line_hz * 600)] = 1e-3
        made[name] = f, psd
    return made


def test_the_line_is_seen() -> None:
    given = spectra(["T40", "Bonita", "Vantage"])
    figure = periodic_figure(given, "s", "n")
    whole, *close = figure.body.axes
    tops = [line.get_ydata() for line in whole.lines if line.get_linewidth() == 0.5]
    assert max(y.max() for y in tops) == 1e-3
    for axes, (name, (f, psd)) in zip(close, given.items(), strict=True):
        x, y = next(line for line in axes.lines if line.get_linewidth() == 0.6).get_data()
        near = np.abs(f - 14.4) <= 2
        assert np.array_equal(x, f[near])
        scale = {"mm²/Hz": 1.0, "µm²/Hz": 1e6, "nm²/Hz": 1e12}[axes.get_ylabel()]
        assert np.allclose(y / scale, psd[near])
        assert any(line.get_xdata()[0] == 14.4 for line in axes.lines)
        assert axes.get_title(loc="left").endswith(name)
    check(figure)
    assert_texts_apart(figure)
