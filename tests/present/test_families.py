"""Families of Allan deviations: curves are those given, told apart by number or by name."""

import numpy as np
import pytest
from figure_data import check
from noise_data import RATE, TAU0, M, drawn, published, row

from mocap_metrology.noise.twins.published import SERIES, published_row
from mocap_metrology.papers import subsets
from mocap_metrology.present.groups.figures import family_figure, family_of, ratios, series_curves
from mocap_metrology.present.plot.figure import Texts
from mocap_metrology.present.skurowski import allan_figures as paper

pytestmark = pytest.mark.filterwarnings("error")
T40 = (10, 8, 6, 5, 4, 3, 2)


def adev(camera_type: str, n: int, series: str) -> np.ndarray:
    return np.sqrt(published_row(camera_type, n)[series].avar(M, RATE))


def panels_of(figure, row: int = 0) -> list:
    """The seven panels of Allan deviations, or those of ratios below each of them."""
    return [axes for k in range(3) for axes in figure.body.axes[6 * k + 3 * row :][:3]][:7]


def test_a_family_shows_every_curve_and_its_ratio_to_the_smallest_subset() -> None:
    rows = {f"T40-{n}": row(f"T40-{n}", n_cameras=n) for n in T40}
    given = {name: published("T40", r["n_cameras"]) for name, r in rows.items()}
    expected = dict.fromkeys(rows, SERIES)
    texts = Texts("g: Allan deviation", "s", "n")
    figure = family_figure(family_of(rows), given, expected, texts, 0.683)
    for axes, series in zip(panels_of(figure), SERIES, strict=True):
        curves = drawn(axes)
        assert len(curves) == 7 and not axes.collections
        for curve, n in zip(curves, sorted(T40), strict=True):
            assert np.allclose(curve, adev("T40", n, series), rtol=1e-12)
    check(figure, apart=True)
    smallest = min(T40)
    for axes, series in zip(panels_of(figure, 1), SERIES, strict=True):
        for (x, ratio), n in zip((line.get_data() for line in axes.lines[-7:]), sorted(T40),
                                 strict=True):  # fmt: skip
            assert np.allclose(x, M * TAU0)
            exact = adev("T40", n, series) / adev("T40", smallest, series)
            assert np.allclose(ratio, exact, rtol=1e-12)
    shorter = {k: v[:-3] for k, v in given["T40-2"].items()}  # L lacks its longest times
    of = {"2": shorter, "3": given["T40-3"]}
    found = ratios(series_curves(of, "L", {"2": "2", "3": "3"})).groupby("curve")["ratio"]
    assert len(found.get_group("3")) == M.size - 3 and np.allclose(found.get_group("2"), 1)


# ---- Figures of S


def sheet(kinds=("T40", "Bonita", "Vantage", "All")) -> dict:
    counts = {"T40": T40, "Bonita": T40, "Vantage": (10, 9, 8, 6, 5, 4, 3, 2), "All": (30,)}
    return {
        f"{kind}-{n}": row(f"{kind}-{n}", kind, n, twin=f"{kind}-{n}")
        for kind in kinds
        for n in counts[kind]
    }


def allan_of(rows: dict) -> dict:
    return {
        name: published(r["camera_type"], r["n_cameras"])
        if r["camera_type"] != "All"
        else published("T40", 10)
        for name, r in rows.items()
    }


def test_subsets_show_curves_and_the_drops_of_s() -> None:
    rows = sheet()
    figure = paper.numbers_figure(rows, allan_of(rows), "s", "n")
    numbers = {"T40": sorted(T40), "Bonita": sorted(T40), "Vantage": [2, 3, 4, 5, 6, 8, 9]}
    assert {k: list(v) for k, v in subsets.sound_subsets(rows).items()} == numbers
    for k, (kind, counts) in enumerate(numbers.items()):
        *families, narrow = figure.body.axes[4 * k : 4 * k + 4]
        for axes, series in zip(families, ("x1", "x2", "L"), strict=True):
            for curve, n in zip(drawn(axes), counts, strict=True):
                assert np.allclose(curve, adev(kind, n, series), rtol=1e-12)
        # At 10 s, between two averaging times of the table: 1 % by interpolation
        for curve, series in zip(drawn(narrow), ("x1", "x2", "L"), strict=True):
            exact = [np.sqrt(published_row(kind, n)[series].avar(1200, RATE)) for n in counts]
            assert np.allclose(curve, np.ravel(exact), rtol=0.01)
        shaded = narrow.patches[0].get_extents().transformed(narrow.transData.inverted())
        assert (shaded.x0 + shaded.x1) / 2 == pytest.approx(paper.DROPS[kind])
    check(figure, apart=True)


def test_a_deviation_between_two_averaging_times() -> None:
    tau = np.array([0.1, 1.0, 10.0])
    white = 0.3 * tau**-0.5
    assert subsets.at_tau(tau, white, 3.0) == pytest.approx(0.3 * 3.0**-0.5)
    gap = np.where(tau == 1.0, np.nan, white)
    assert subsets.at_tau(tau, gap, 3.0) == pytest.approx(0.3 * 3.0**-0.5)
    assert subsets.at_tau(tau, white, 0.1) == pytest.approx(white[0])
    assert np.isnan([subsets.at_tau(tau, white, t) for t in (0.09, 11)]).all()
    assert np.isnan(subsets.at_tau(tau, 0 * white, 1.0))


def test_figures_of_s_show_the_recordings_they_are_about() -> None:
    rows = sheet()
    given = allan_of(rows)
    failing = paper.failing_figure(rows, given, "s", "n", 0.683)
    types = paper.types_figure(rows, given, "s", "n", 0.683)
    for j, series in enumerate(("x1", "x2", "L")):
        ten, nine = drawn(failing.body.axes[j])
        assert np.allclose(ten, adev("Vantage", 10, series), rtol=1e-12)
        assert np.allclose(nine, adev("Vantage", 9, series), rtol=1e-12)
        shown = drawn(types.body.axes[j])
        for curve, (kind, n) in zip(
            shown, (("T40", 10), ("Bonita", 10), ("Vantage", 9), ("T40", 10)), strict=True
        ):
            assert np.allclose(curve, adev(kind, n, series), rtol=1e-12)
    check(failing, apart=True)
    check(types, apart=True)
    del rows["Vantage-9"]
    assert paper.failing_figure(rows, given, "s", "n", 0.683) is None
