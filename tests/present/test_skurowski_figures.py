"""Figures of S: what is drawn is what was given, a shock where it was put; and odd input."""

from dataclasses import replace

import numpy as np
import pytest
from figure_data import ODD_TEXT, check, check_saved, every_text
from mocap_workflow.recording_twins import twin_from_mapping
from noise_data import RATE, TAU0, allan_arrays, estimate

from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw, Sinusoid
from mocap_metrology.noise.series import all_series, allan_columns
from mocap_metrology.noise.twins.published import published_gaussian, published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.papers import power_laws as laws
from mocap_metrology.papers import subsets
from mocap_metrology.papers.shock import CUT, RECORDED, ShockRecording, find_shock
from mocap_metrology.present.plot.figure import Texts
from mocap_metrology.present.skurowski import gaussian_figures as gaussians
from mocap_metrology.present.skurowski import theory_figures as theory
from mocap_metrology.present.skurowski.allan_figures import (
    FINAL,
    ORDINARY,
    START,
    crump_figure,
    periodic_figure,
    regression_figure,
)

pytestmark = pytest.mark.filterwarnings("error")
TEXTS = Texts("t", "s", "c")


def sheet(numbers=(10, 5, 2), kinds=("T40", "Bonita")) -> dict:
    return {
        f"{kind}-{n}": {"recording": f"{kind}-{n}", "camera_type": kind, "n_cameras": n}
        for kind in kinds
        for n in numbers
    }


def gaussian(rows: dict) -> dict:
    """As the law has it, 0.1 mm for one camera of the first type."""
    found = {}
    for name, row in rows.items():
        sigma = 0.1 * row["n_cameras"] ** -0.5 * (3 if row["camera_type"] == "Bonita" else 1)
        found[name] = {
            **{"sigma_1_mm": sigma, "sigma_2_mm": 2 * sigma, "sigma_L_mm": 3 * sigma},
            **{"sigma_12_mm2": -(sigma**2), "mu_L_mm": 160.5 + sigma, "axis": "x"},
        }
    return found


def points(axes, marker: str) -> np.ndarray:
    """Where markers of a kind stand, without the empty ones."""
    found = np.concatenate([x.get_xydata() for x in axes.lines if x.get_marker() == marker])
    return found[np.isfinite(found).all(axis=1)]


def twin(name: str, row: dict):
    published = {"camera_type": row["camera_type"], "n_cameras": row["n_cameras"]}
    return twin_from_mapping({"published": published, "seed": 1, "duration_s": 600}, name)


def test_figure_1_shows_the_densities_of_table_4() -> None:
    row, (_, *panels) = published_gaussian("T40"), theory.model_figure().body.axes
    for panel, names in zip(panels, (["2"], ["1"], ["C", "B", "A1", "A2"]), strict=True):
        for line, name in zip(panel.lines, names, strict=True):
            x, y = line.get_data()
            assert np.trapezoid(y, x) == pytest.approx(1, abs=5e-3)
            width = np.sqrt(np.trapezoid(y * x**2, x))
            assert width == pytest.approx(1000 * row[f"sigma_{name}_mm"], rel=0.02)


def test_slopes_written_in_figure_3_are_those_of_the_curves() -> None:
    texts = [t.get_text() for axes in theory.slopes_figure().body.axes for t in axes.texts]
    assert [t for t in texts if t[:1] in ("+", "−", "0")] == [
        *("−1", "−½", "0", "+½"),
        *("−½", "+1", "−1", "+½", "−½", "+½"),
    ]
    assert laws.slope_at(laws.deviation([PowerLaw(0, 3.0)]), 1.0) == pytest.approx(-0.5)
    bump = laws.deviation([GaussMarkov(1.0, 10.0)])
    assert laws.TAU[bump.argmax()] == pytest.approx(18.9, rel=0.01)  # 1.893 T_c
    assert theory.slope_text(0.37) == "+0.37"
    line, tau = Sinusoid(1.0, 3.0), laws.TAU
    exact, reach = laws.deviation([line]), laws.envelope(line)
    # ADEV of a sinusoid: A sin^2(pi f tau) / (pi f tau)
    x = np.pi * 3.0 * tau
    early = 3.0 * tau <= 6
    assert np.allclose(exact[early], (np.sin(x) ** 2 / x)[early])
    assert np.allclose(exact[~early], (np.sqrt(3 / 8) / x)[~early])
    assert np.all(exact <= reach * (1 + 1e-12))


def test_locations_are_densities_and_odd_input_is_drawn(tmp_path) -> None:
    rng = np.random.default_rng(1)
    row = published_gaussian("T40")
    x = {f"x{k}": row[f"mu_{k}_mm"] + 0.02 * rng.standard_normal(20_000) for k in (1, 2)}
    figure = gaussians.locations_figure(x, row, "s")
    check_saved(figure, tmp_path)
    filled = figure.body.axes[0].collections[0].get_paths()[0].vertices
    area = 0.5 * np.sum(filled[:-1, 0] * filled[1:, 1] - filled[1:, 0] * filled[:-1, 1])
    assert abs(area) == pytest.approx(1, abs=0.01)
    widths = [1 / np.sqrt(2 * np.pi) / line.get_ydata().max() for line in figure.body.axes[0].lines]
    assert widths == pytest.approx([20.0, 1000 * row["sigma_1_mm"]], rel=0.02)
    x["x1"][:100] = np.nan
    x["x2"] = np.full(20_000, 6.0)
    check(gaussians.locations_figure(x, row, ODD_TEXT, ODD_TEXT))
    check(gaussians.locations_figure(x | {"x2": x["x1"]}, None, "s"))


def test_means_stand_where_they_are() -> None:
    """One mean 5 mm off is an arrow with its number; the others are spread."""
    rng, rows = np.random.default_rng(2), sheet((10, 8, 6, 5, 4, 3, 2))
    numbers = gaussian(rows)
    numbers["Bonita-2"]["mu_L_mm"], numbers["T40-3"]["mu_L_mm"] = 165.25, np.nan
    twins = {name: twin(name, row) for name, row in rows.items() if name != "T40-2"}
    means = subsets.means_of_distance(rows, numbers, twins)
    assert means["error"].isna().sum() == 1 and len(means) == len(rows) - 1
    kinds = {kind: published_gaussian(kind) for kind in ("T40", "Bonita")}
    assert set(means["published"]) == {row["mu_L_mm"] for row in kinds.values()}
    L = {
        k: row["mu_L_mm"] + row["sigma_L_mm"] * rng.standard_normal(5000)
        for k, row in kinds.items()
    }
    figure = gaussians.distances_figure(L, kinds, means, "s")
    check(figure)
    below = figure.body.axes[1]
    drawn = np.concatenate([points(below, "o"), points(below, "s")])
    near = means["value"][means["value"] < 165]
    assert sorted(drawn[:, 1]) == pytest.approx(sorted(near))
    assert "165.25" in [text.get_text() for text in below.texts]
    assert below.get_ylim()[1] < 161.5
    check(gaussians.distances_figure({"other": L["T40"]}, {}, means[:1], "s"))
    check(gaussians.distances_figure({}, {}, means[:0], "s"))


@pytest.mark.parametrize("power", [1, 2])
def test_the_law_is_fitted_to_what_follows_it(power: int) -> None:
    rows = sheet((10, 8, 6, 5, 4, 3, 2))
    spreads = subsets.spreads(rows, gaussian(rows), {"T40-5": twin("T40-5", rows["T40-5"])})
    for kind, factor in (("T40", 0.1), ("Bonita", 0.3)):
        laws = gaussians.fits(spreads[spreads["camera_type"] == kind])
        expected = [factor, 2 * factor, 3 * factor]
        assert [law.one for law in laws.values()] == pytest.approx(expected)
        assert all(law.exponent == pytest.approx(-0.5) for law in laws.values())
    figure = gaussians.scaling_figure(spreads, TEXTS, variances=power == 2)
    check(figure)
    axes, printed = figure.body.axes[0], published_gaussian("T40")
    assert axes.get_ylabel().startswith(("Standard deviation", "Variance")[power - 1])
    drawn = points(axes, "D")
    assert drawn[:, 1] == pytest.approx((0.3 * drawn[:, 0] ** -0.5) ** power)
    stars = sorted(printed[name] ** power for name in gaussians.SERIES)
    assert sorted(points(axes, "*")[:, 1]) == pytest.approx(stars)
    assert len(points(axes, "_")) == 3  # of the only twin
    assert f"distance  −{power / 2:.2f} ± 0.00" in every_text(figure)


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
    check(figure, apart=True)


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
    check(figure, apart=True)


SECONDS = 300.0
CRUMP = {"time_share": 0.4, "amplitude_mm": 0.5, "decay_s": 2, "frequency_hz": 3}
NAMES = [f"{axis}{k}" for k in (1, 2) for axis in "xyz"]


def made(crump) -> tuple[dict, float | None]:
    twin = twin_from_mapping(
        {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 5, "crump": CRUMP}, "T"
    )
    told = simulate(twin if crump else replace(twin, crump=None), SECONDS)
    values = dict(zip(NAMES, told.position_mm.reshape(6, -1), strict=True))
    return dict(all_series(values, [(1, 2)])), crump and told.truth["crump"]["time_s"]


@pytest.fixture(scope="module")
def shaken():
    return made(True)


@pytest.fixture(scope="module")
def quiet():
    return made(False)[0]


def coordinates(series: dict) -> dict:
    return {name: series[name] for name in NAMES}


def columns(series: dict) -> dict:
    """allan.parquet as the workflow would write it."""
    curve = allan_curve(series["L"], RATE, averaging_factors(series["L"].size, 60))
    return allan_columns("L", curve)


def test_a_shock_is_found_where_it_was_put(shaken) -> None:
    """Calmed down to less than the short-term noise, 10 um of 0.5 mm, after 8 s."""
    series, time_s = shaken
    found = find_shock(coordinates(series), RATE)
    assert found.onset / RATE == pytest.approx(time_s, abs=0.1)
    assert found.start <= time_s * RATE and time_s + 6 < found.stop / RATE < time_s + 12
    still = {"x1": np.zeros(1000)}
    assert find_shock(still, RATE) is None
    assert find_shock({"x1": np.full(1000, np.nan)}, RATE) is None


def test_cut_out_leaves_the_deviation_without_a_shock(shaken, quiet) -> None:
    """Same noise with and without: 4 % of it is cut, so 2 to 8 % remain between the two."""
    series, _ = shaken
    given = ShockRecording(series, series, columns(series), RATE)
    curves = given.curves(find_shock(coordinates(series), RATE)).groupby("curve")
    recorded, cut = (curves.get_group(name).reset_index() for name in (RECORDED, CUT))
    without = columns(quiet)["adev_mm"]
    short = recorded.x < 3
    assert np.abs(cut.y / without - 1)[short].max() < 0.08
    assert np.abs(cut.y / without - 1)[recorded.x < 0.1].max() < 0.02
    near = np.abs(np.log(recorded.x * 3 * 2)) < 0.3  # half a period of 3 Hz
    assert np.all(recorded.y[near] > 3 * without[near])


@pytest.mark.parametrize("other", [True, False])
def test_the_figure(shaken, quiet, other) -> None:
    series, _ = shaken
    clean = {name: values.astype(np.float32) for name, values in series.items()}
    clean["x1"][int(121 * RATE)] += 1.0
    raw = {name: clean[name].astype(np.float64) for name in series}
    raw["x1"][int(121 * RATE)] -= 1.0
    given = ShockRecording(raw, clean, columns(series), RATE)
    label = ("Q, without a shock", columns(quiet)) if other else None
    figure = crump_figure(given, label, "s", "n")
    texts = every_text(figure)
    assert "from 120.0 s" in figure.caption and " 1 of " in figure.caption
    assert ("(b) Q, without a shock" in texts) == other
    check(figure, apart=True)
