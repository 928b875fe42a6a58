"""Figures 6, 14, 15, 16 and 17 of S: numbers drawn are numbers given, and odd input."""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import ODD_TEXT, check, check_saved, every_text
from noise_data import (
    PAPER,
    RATE,
    TAU0,
    allan_arrays,
    assert_texts_apart,
    bounds,
    estimate,
    group,
)

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, correlation_class
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.noise.twins.published import SERIES, published_row
from mocap_metrology.present.groups import slots
from mocap_metrology.present.skurowski.appendix import TABLES, table_a
from mocap_metrology.present.skurowski.coefficients import (
    cameras_of,
    colour_figure,
    correlated_figure,
    searched_ends,
    term_pairs,
)
from mocap_metrology.present.skurowski.series_figures import (
    FINAL,
    ORDINARY,
    START,
    periodic_figure,
    regression_figure,
    smooth_adev,
)

pytestmark = pytest.mark.filterwarnings("error")


def table_rows(keys=None):
    sheet, noise, expected, crlb = group(keys)
    kinds = TABLES if keys is None else dict.fromkeys(kind for kind, _ in keys)
    return [
        row for kind in kinds
        for row in table_a(kind, sheet, noise, expected, bounds(crlb, kind))
        if keys is None or (kind, row["n_cameras"]) in keys
    ]  # fmt: skip


@pytest.fixture(scope="module")
def rows():
    return table_rows()


def marks(axes, size: float) -> list[tuple[float, float]]:
    """Points drawn with markers of that size (ticks have numbers for markers)."""
    found = [
        x.get_xydata()
        for x in axes.lines
        if x.get_markersize() == size and isinstance(x.get_marker(), str) and x.get_ls() == "None"
    ]
    return [tuple(point) for points in found for point in points]


def places(own, column, cameras):
    """Where the numbers of a panel should stand, from the rows alone."""
    return sorted(
        (cameras.index(row["n_cameras"]) + slots.offsets(SERIES)[row["series"]], value)
        for row in own
        if (value := row[column]) is not None
    )


def marks_of(axes, marker) -> list[tuple[float, float]]:
    found = [x.get_xydata() for x in axes.lines if x.get_marker() is marker]
    return [tuple(point) for points in found for point in points]


SHAPES = {
    "published": slots.PUBLISHED,
    "regenerated": slots.REGENERATED,
    DEFAULT_ESTIMATOR: slots.LIKELIHOOD,
}


@pytest.mark.parametrize("logarithmic", [True, False])
def test_ends_of_the_search_are_no_points(rows, logarithmic) -> None:
    """What S's estimator gives for a component that is absent to it: a cross, and no dot."""
    changed = [dict(row) for row in rows if row["camera_type"] == "T40"]
    ended = [r for r in changed if r["parameter"] == "h_0" and r["series"] in ("x1", "L")]
    for row in ended:
        row["regenerated_status"] = "at_bound"
    axes = colour_figure(changed, "t", "s", logarithmic=logarithmic).body.axes[2]  # h_0 of T40
    crosses = [len(x.get_xdata()) for x in axes.lines if x.get_marker() == "x"]
    top = axes.get_ylim()[1]
    scale = 1.0 if logarithmic else 10.0 ** (-6)
    assert sum(crosses) == len(ended) == 14 or top * scale < max(r["regenerated"] for r in ended)
    dots = marks(axes, slots.REGENERATED["markersize"])
    shown = {round(y, 12) for _, y in dots}
    assert not shown & {round(row["regenerated"], 12) for row in ended}


@pytest.mark.parametrize("logarithmic", [True, False])
def test_colours_of_noise_show_every_number(rows, logarithmic, tmp_path) -> None:
    made = colour_figure(rows, "t", "s", "n", logarithmic=logarithmic)
    panels = made.body.axes
    assert len(panels) == 15
    for k, axes in enumerate(panels):
        alpha, kind = ALPHAS[k % 5], list(TABLES)[k // 5]
        cameras = cameras_of(rows, kind)
        own = [r for r in rows if r["parameter"] == f"h_{alpha}" and r["camera_type"] == kind]
        assert len(own) == 49 + 7 * (kind == "Vantage")
        scale = 1.0
        if logarithmic:
            own = [dict(row) for row in own]
            for row in own:
                for column in ("published", "regenerated", DEFAULT_ESTIMATOR):
                    if row[column] is not None and row[column] < slots.FLOOR:
                        row[column] = slots.in_band()
        else:
            values = slots.column_values(own)
            held = np.quantile(values[values > 0], 0.9)
            scale = 10.0 ** np.floor(np.log10(held))
        top, above = axes.get_ylim()[1], 0
        for column, how in SHAPES.items():
            expected = [(x, y / scale) for x, y in places(own, column, cameras)]
            above += sum(y > top for _, y in expected)
            expected = [(x, y) for x, y in expected if y <= top]
            found = sorted(marks(axes, how["markersize"]))
            assert np.allclose(found, expected, rtol=1e-9, atol=0), (k, column)
        beyond = [y for x, y in marks_of(axes, slots.UP) if y == top]
        assert len(beyond) >= above and (above > 0) == (not logarithmic)
        limits = [r["likelihood_upper_95"] for r in own if r["likelihood_status"] == "not_detected"]
        arrows = sorted(y * scale for _, y in marks(axes, slots.LIMIT["markersize"]))
        assert np.allclose(arrows, sorted(v for v in limits if v / scale <= top))
        if logarithmic:
            low, high = axes.get_ylim()
            assert low >= slots.FLOOR * 10**-slots.BAND_DECADES and high < 1
    if logarithmic:
        check_saved(made, tmp_path / "f")
    assert_texts_apart(made)
    assert {"(a) T40", "(b) Bonita", "(c) Vantage"} <= set(every_text(made))
    assert any("10^{-20}" in text for text in every_text(made)) == logarithmic


def test_correlated_terms(rows, tmp_path) -> None:
    made = correlated_figure(rows, "t", "s", "n")
    for source, column in (("published", 3.6), ("regenerated", 3.0), (DEFAULT_ESTIMATOR, 3.0)):
        pairs = term_pairs(rows, source)
        assert len(pairs) == 511  # terms in Tables A1-A3
        name = PAPER if source == "regenerated" else source
        axes = next(a for a in made.body.axes if a.get_title(loc="left") == f"(b) {name}")
        assert np.allclose(sorted(marks(axes, column)), sorted(p[:2] for p in pairs), atol=0)
        assert "511 terms" in [t.get_text() for t in axes.texts]
    first = [r for r in rows if r["camera_type"] == "T40" and r["parameter"].startswith("T_c")]
    drawn = np.array(sorted(marks(made.body.axes[0], slots.PUBLISHED["markersize"])))
    cameras = cameras_of(rows, "T40")
    expected = np.array(places(first, "published", cameras))
    assert np.allclose(np.sort(drawn[:, 1]), np.sort(expected[:, 1]), atol=0)
    check_saved(made, tmp_path / "f")
    assert_texts_apart(made)


def test_a_limit_of_an_amplitude_shows_its_class_of_correlation_time() -> None:
    made = [r for r in table_rows([("T40", 10)]) if r["parameter"][1:3] == "_c"]
    for row in made:
        row |= {"likelihood": None, "likelihood_upper_95": 0.01, "likelihood_status": "ok"}
        if row["parameter"].startswith("q_c"):
            row["likelihood_status"] = "not_detected"
    amplitudes = correlated_figure(made, "t", "s").body.axes[1]
    for kind, letter in slots.LETTERS.items():
        drawn = sorted(x for x, _ in marks_of_shape(amplitudes, letter))
        expected = sorted(
            slots.offsets(SERIES)[row["series"]]
            for row in made
            if row["parameter"].startswith("T_c") and correlation_class(row["published"]) == kind
        )
        assert drawn == pytest.approx(expected), kind


def marks_of_shape(axes, marker: str) -> list[tuple[float, float]]:
    found = [x.get_xydata() for x in axes.lines if x.get_marker() == marker]
    return [tuple(point) for points in found for point in points]


def test_terms_at_an_end_of_the_search_are_told() -> None:
    made = table_rows([("T40", 10)])
    assert searched_ends(made) == []
    terms = [row for row in made if row["parameter"].startswith("T_c")]
    for row, end in zip(terms[:3], (1 / 60, 60.0, 60.0), strict=True):
        row |= {"regenerated": end, "regenerated_status": "at_bound"}
    assert searched_ends(made) == [1 / 60, 60.0]
    figure = correlated_figure(made, "t", "s")
    dashed = [line for line in figure.body.axes[0].lines if line.get_linestyle() == "--"]
    assert [line.get_ydata()[0] for line in dashed] == [1 / 60, 60.0]
    assert any(text.endswith("terms, 3 at an end") for text in every_text(figure))


@pytest.mark.parametrize("logarithmic", [True, False])
def test_a_bar_that_is_cut_ends_in_an_arrow(logarithmic) -> None:
    made = [row for row in table_rows([("T40", 10)]) if row["parameter"] == "h_0"]
    for row in made:
        row |= {"likelihood": row["published"], "likelihood_status": "ok"}
        row |= {"likelihood_lower_95": row["published"] / 2}
        row |= {"likelihood_upper_95": row["published"] * 2}
    made[0]["likelihood_lower_95"], made[1]["likelihood_upper_95"] = 0.0, 1.0
    axes = colour_figure(made, "t", "s", logarithmic=logarithmic).body.axes[2]
    low, high = axes.get_ylim()
    if logarithmic:
        ((_, end),) = marks_of(axes, slots.DOWN)
        assert end == pytest.approx(max(made[0]["published"] / slots.LONGEST, low))
    assert (slots.offsets(SERIES)["y1"], high) in marks_of(axes, slots.UP)


def test_leftovers_are_terms_too() -> None:
    made = table_rows([("T40", 10)])
    extra = [
        dict.fromkeys(made[0])
        | {"parameter": f"{p} ({DEFAULT_ESTIMATOR})", DEFAULT_ESTIMATOR: v}
        | {"n_cameras": 10, "camera_type": "T40", "series": "x1"}
        for p, v in (("q_c9", 0.3), ("T_c9", 77.0))
    ]  # fmt: skip
    before, after = (term_pairs(r, DEFAULT_ESTIMATOR) for r in (made, made + extra))
    assert after[len(before) :] == [(77.0, 0.3, "T40", True)]
    assert term_pairs(made + extra, "published") == term_pairs(made, "published")
    check(correlated_figure(made + extra, "t", "s"), draw=False)


@pytest.mark.parametrize("draw", [colour_figure, correlated_figure])
@pytest.mark.parametrize("case", ["none", "cited", "one", "not detected"])
def test_odd_coefficients(draw, case) -> None:
    keys = {"none": [], "one": [("Bonita", 4)]}.get(case, [("T40", 10)])
    made = table_rows(keys)
    if case == "cited":
        made = table_a("T40", {}, {})
    elif case == "not detected":
        for row in made:
            row |= {
                DEFAULT_ESTIMATOR: None,
                "likelihood_status": "not_detected",
                "regenerated": None,
            }
    check(draw(made, ODD_TEXT, ODD_TEXT, ODD_TEXT), draw=case == "not detected")


# ---- Figures 6 and 17


def regression(n_starts: int = 10, n: int = 101):
    model = published_row("T40", 10)["z1"]
    starts = [estimate(model, "a", 0.1, k).model for k in range(n_starts)]
    data = allan_arrays(model, n)
    ordinary = estimate(model, "a", 0.4, 99).model
    figure = regression_figure(
        (data["tau_s"], data["adev_mm"]), starts, ordinary, model, RATE, ("t", "s", "n")
    )
    return figure, data, starts, ordinary, model


@pytest.mark.parametrize("n_starts", [10, 0])
def test_regression(n_starts, tmp_path) -> None:
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
    check_saved(figure, tmp_path / "f")
    assert_texts_apart(figure)
    assert f"{n_starts} starts of annealing" in every_text(figure)


def test_one_start_is_no_plural() -> None:
    assert "1 start of annealing" in every_text(regression(1)[0])


def test_curves_of_sampled_models_pass_through_whole_frames() -> None:
    model = published_row("T40", 10)["z1"]
    m = np.array([1, 2, 3, 5, 17, 100, 1000])
    exact = np.sqrt(model.avar(m, RATE, "sampled"))
    found = smooth_adev(model, m.astype(float), RATE, "sampled")
    assert np.allclose(found, exact, rtol=2e-3)  # 120 points a decade
    assert np.allclose(found[:4], exact[:4], rtol=1e-9)


def test_regression_without_data() -> None:
    model = published_row("T40", 10)["z1"]
    none = np.array([])
    figure = regression_figure(
        (none, none), [model], model, model, RATE, (ODD_TEXT, ODD_TEXT, ODD_TEXT)
    )
    check(figure)
    assert "no valid samples" in every_text(figure)


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


def test_the_line_is_seen(tmp_path) -> None:
    given = spectra(["T40", "Bonita", "Vantage"])
    figure = periodic_figure(given, 14.4, "t", "s", "n")
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
    assert any("× median" in t for t in every_text(figure))
    check_saved(figure, tmp_path / "f")
    assert_texts_apart(figure)


@pytest.mark.parametrize("case", ["one", "none", "zero", "nan", "empty"])
def test_odd_spectra(case) -> None:
    given = spectra(["T40"])
    f, psd = given["T40"]
    if case == "zero":
        given["T40"] = f, np.zeros_like(psd)
    elif case == "nan":
        given["T40"] = f, np.full_like(psd, np.nan)
    elif case == "empty":
        given["T40"] = np.array([]), np.array([])
    figure = periodic_figure({} if case == "none" else given, 14.4, ODD_TEXT, ODD_TEXT, ODD_TEXT)
    check(figure)
    if case in ("none", "nan", "empty"):
        assert "no spectrum" in every_text(figure)
