"""Figures 1-3 and 9-11 of S: what is drawn is what was computed, and odd input."""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import ODD_TEXT, check, check_saved, every_text
from mocap_workflow.recording_twins import twin_from_mapping
from noise_data import assert_texts_apart

from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.present.skurowski import gather
from mocap_metrology.present.skurowski import theory_figures as slopes
from mocap_metrology.present.skurowski.densities import Mean, distances_figure, locations_figure
from mocap_metrology.present.skurowski.scaling import (
    COVARIANCE,
    SERIES,
    Subset,
    fits,
    scaling_figure,
)
from mocap_metrology.present.skurowski.theory_figures import model_figure, standard_error_figure

pytestmark = pytest.mark.filterwarnings("error")


def sheet(numbers=(10, 5, 2), kinds=("T40", "Bonita")) -> dict:
    return {
        f"{kind}-{n}": {"recording": f"{kind}-{n}", "camera_type": kind, "n_cameras": n}
        for kind in kinds
        for n in numbers
    }


def gaussian(rows: dict, exponent: float = -0.5) -> dict:
    """As the law has it, 0.1 mm for one camera of the first type."""
    found = {}
    for name, row in rows.items():
        sigma = 0.1 * row["n_cameras"] ** exponent * (3 if row["camera_type"] == "Bonita" else 1)
        found[name] = {
            **{"sigma_1_mm": sigma, "sigma_2_mm": 2 * sigma, "sigma_L_mm": 3 * sigma},
            **{"sigma_12_mm2": -(sigma**2), "mu_L_mm": 160.5 + sigma, "axis": "x"},
        }
    return found


def points(axes, marker: str) -> np.ndarray:
    """Where markers of a kind stand, without the empty ones."""
    found = [line.get_xydata() for line in axes.lines if line.get_marker() == marker]
    found = np.concatenate(found)
    return found[np.isfinite(found).all(axis=1)]


def test_theory_figures_are_readable(tmp_path) -> None:
    for k, figure in enumerate((model_figure(), standard_error_figure(),
                                slopes.slopes_figure())):  # fmt: skip
        check_saved(figure, tmp_path / str(k))
        assert_texts_apart(figure)


def test_figure_1_shows_the_densities_of_table_4() -> None:
    axes = model_figure().body.axes
    row = published_gaussian("T40")
    for panel, sigmas in zip(
        axes[1:4],
        (["sigma_2_mm"], ["sigma_1_mm"], [f"sigma_{k}_mm" for k in ("C", "B", "A1", "A2")]),
        strict=True,
    ):
        for line, name in zip(panel.lines, sigmas, strict=True):
            x, y = line.get_data()
            assert np.trapezoid(y, x) == pytest.approx(1, abs=5e-3)
            width = np.sqrt(np.trapezoid(y * x**2, x))
            assert width == pytest.approx(1000 * row[name], rel=0.02)


def test_slopes_written_in_figure_3_are_those_of_the_curves() -> None:
    figure = slopes.slopes_figure()
    written = [t.get_text() for axes in figure.body.axes for t in axes.texts]
    assert [t for t in written if t[:1] in ("+", "−", "0")] == [
        *("−1", "−½", "0", "+½"),
        *("−½", "+1", "−1", "+½", "−½", "+½"),
    ]
    for axes in figure.body.axes:  # named and labelled in one way
        assert axes.get_ylabel() == "Allan deviation (mm)"
        formatter = axes.yaxis.get_major_formatter()
        assert all("10^" in formatter(tick) for tick in axes.get_yticks())
    white = slopes.deviation([PowerLaw(0, 3.0)])
    assert slopes.slope_at(white, 1.0) == pytest.approx(-0.5, abs=1e-9)
    bump = slopes.deviation([GaussMarkov(1.0, 10.0)])
    peak = slopes.TAU[bump.argmax()]
    assert peak == pytest.approx(18.9, rel=0.01)  # 1.893 T_c
    assert slopes.slope_text(0.37) == "+0.37"
    line = Sinusoid(1.0, 3.0)
    exact, reach = slopes.deviation([line]), slopes.envelope(line)
    assert np.all(exact <= reach * (1 + 1e-12))


def test_locations_are_densities_and_odd_input_is_drawn(tmp_path) -> None:
    rng = np.random.default_rng(1)
    row = published_gaussian("T40")
    x = {f"x{k}": row[f"mu_{k}_mm"] + 0.02 * rng.standard_normal(20_000) for k in (1, 2)}
    figure = locations_figure(x, row, "s")
    check_saved(figure, tmp_path)
    filled = figure.body.axes[0].collections[0].get_paths()[0].vertices
    area = 0.5 * np.sum(filled[:-1, 0] * filled[1:, 1] - filled[1:, 0] * filled[:-1, 1])
    assert abs(area) == pytest.approx(1, abs=0.01)
    x["x1"][:100] = np.nan
    x["x2"] = np.full(20_000, 6.0)
    check(locations_figure(x, row, ODD_TEXT, ODD_TEXT, ODD_TEXT))
    x["x2"] = 6.0 + 0.01 * rng.standard_normal(20_000)
    check(locations_figure(x, None, "s"))


def test_means_stand_where_they_are(tmp_path) -> None:
    rng = np.random.default_rng(2)
    rows = sheet()
    twins = {
        name: twin_from_mapping(
            {
                "published": {"camera_type": r["camera_type"], "n_cameras": r["n_cameras"]},
                "seed": 1,
            },
            name,
        )
        for name, r in rows.items()
        if name != "T40-2"
    }
    means = gather.means(rows, gaussian(rows), twins)
    assert [m.error is None for m in means] == [name == "T40-2" for name in rows]
    kinds = {kind: published_gaussian(kind) for kind in ("T40", "Bonita")}
    L = {k: row["mu_L_mm"] + row["sigma_L_mm"] * rng.standard_normal(5000)
         for k, row in kinds.items()}  # fmt: skip
    figure = distances_figure(L, kinds, means, "s")
    check_saved(figure, tmp_path)
    below = figure.body.axes[1]
    drawn = np.concatenate([points(below, "o"), points(below, "s")])
    assert sorted(drawn[:, 1]) == pytest.approx(sorted(m.value for m in means))
    check(distances_figure({"other": L["T40"]}, {}, [Mean("other", 3, 1.0, None, None)], "s"))
    check(distances_figure({}, {}, [], "s"))


def test_one_mean_far_off_does_not_flatten_the_others() -> None:
    """Twenty means within 0.02 mm and one 2 mm off: an arrow and its number, the others spread."""
    rng = np.random.default_rng(4)
    near = [Mean("T40", n, 160.3 + 0.02 * rng.uniform(-1, 1), 0.01, 160.3) for n in range(2, 22)]
    figure = distances_figure({}, {}, [*near, Mean("T40", 22, 162.3, 1.5, 160.3)], "s")
    below = figure.body.axes[1]
    low, high = below.get_ylim()
    assert low < 160.28 and 160.32 < high < 160.4
    assert "162.30" in [text.get_text() for text in below.texts]
    assert len(points(below, "o")) == len(near)
    check(figure)


def test_the_law_is_fitted_to_what_follows_it(tmp_path) -> None:
    rows = sheet((10, 8, 6, 5, 4, 3, 2))
    subsets = gather.subsets(rows, gaussian(rows), {})
    for kind, factor in (("T40", 1), ("Bonita", 3)):
        found = fits([s for s in subsets if s.camera_type == kind])
        assert [fit.one for fit in found.values()] == pytest.approx(
            [0.1 * factor, 0.2 * factor, 0.3 * factor]
        )
        assert all(fit.exponent == pytest.approx(-0.5) for fit in found.values())
    printed = published_gaussian("T40")
    for power, text in ((1, "distance  −0.50 ± 0.00"), (2, "distance  −1.00 ± 0.00")):
        figure = scaling_figure(subsets, ("t", "s", "c"), variances=power == 2)
        check_saved(figure, tmp_path / str(power))
        axes = figure.body.axes[0]
        assert axes.get_ylabel().startswith(("Standard deviation", "Variance")[power - 1])
        drawn = points(axes, SERIES["distance"]["marker"])
        assert drawn[:, 1] == pytest.approx((0.3 * drawn[:, 0] ** -0.5) ** power)
        assert sorted(points(axes, "*")[:, 1]) == pytest.approx(
            sorted(printed[f"sigma_{k}_mm"] ** power for k in ("1", "2", "L"))
        )
        assert text in [t.get_text() for t in axes.get_legend().get_texts()]


def test_notes_say_how_long_twins_are() -> None:
    segments = [{"n_frames": 60_000, "gap_before": 0}, {"n_frames": 11_000, "gap_before": 1000}]
    origin = {"frame_rate_hz": 120.0, "segments": segments}
    assert gather.length_s(origin) == 600.0
    rows = {name: {"twin": name} for name in "ab"} | {"c": {"twin": None}}
    line, remarks = gather.sources(rows, {"a": 600.0, "b": 600.0, "c": 7.0})
    assert line.startswith(
        "Source: 1 measured recording and 2 simulated stand-ins (twins) of 10 min."
    )
    assert line.endswith("last nine hours.") and "Simulated: a, b; the others" in remarks
    twins = {name: rows[name] for name in "ab"}
    line, _ = gather.sources(twins, {"a": 600.0, "b": 600.0}, paper=False)
    assert line == "Source: 2 simulated stand-ins (twins) of 10 min."
    line, _ = gather.sources(twins, {"a": 32400.0, "b": 32400.0})
    assert line == "Source: 2 simulated stand-ins (twins) of nine hours."
    line, remarks = gather.sources(twins, {"a": 7200.0, "b": 32400.0})
    assert "of 2 h and nine hours." in line
    assert remarks.endswith("Length of the twins: a: 2 h; b: nine hours.")
    assert gather.sources({"c": rows["c"]}, {"c": 600.0}) == ("Source: 1 measured recording.", "")


def test_the_spread_of_figure_9_is_explained() -> None:
    values = {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 1, "duration_s": 600}
    said = gather.spread_sentence(twin_from_mapping(values, "T40-10"))
    assert "10.6 and 10.3 µm over 10 min, 15.2 and 23.1 µm over nine hours" in said
    assert gather.spread_sentence(None) == ""


def test_covariances_share_a_unit() -> None:
    rows = sheet((10, 5, 2))
    figure = scaling_figure(gather.subsets(rows, gaussian(rows), {}), ("t", "s", "c"))
    below = [axes for axes in figure.body.axes if axes.get_ylabel().startswith("Covariance")]
    assert [axes.get_ylabel() for axes in below] == ["Covariance (µm²)"]
    drawn = points(below[0], COVARIANCE["marker"])
    assert len(drawn) == 3 and drawn[:, 1] == pytest.approx(-1e6 * 0.1**2 / drawn[:, 0])
    assert "exponent of n" in every_text(figure)


def test_one_large_covariance_does_not_flatten_the_others() -> None:
    sizes = dict(zip((2, 4, 6, 8), (3e-2, 2e-4, -3e-5, 1e-4), strict=True))
    subsets = [Subset("t", n, {"sigma_1_mm": 1 / n, "sigma_12_mm2": v}) for n, v in sizes.items()]
    figure = scaling_figure(subsets, ("t", "s", "c"))
    below = figure.body.axes[1]
    height = below.transAxes.inverted().transform(below.transData.transform(
        [(n, 1e6 * v) for n, v in sizes.items()]))[:, 1]  # fmt: skip
    assert height.min() > 0 and height.max() < 1
    assert np.diff(np.sort(height)).min() > 0.03
    check(figure)


def test_the_failing_camera_is_not_fitted() -> None:
    rows = sheet((10, 9, 4, 2), ("Vantage",))
    numbers = gaussian(rows)
    numbers["Vantage-10"] = dict.fromkeys(numbers["Vantage-10"], 9.0)
    found = fits(gather.subsets(rows, numbers, {}))
    assert found["distance"].one == pytest.approx(0.3)


def test_a_users_group_with_many_types_single_markers_and_odd_names() -> None:
    rows = sheet((30, 12, 11, 10, 3), (ODD_TEXT, "", "b", "c"))
    numbers = gaussian(rows)
    for name in list(numbers)[:5]:
        numbers[name] = {"sigma_1_mm": numbers[name]["sigma_1_mm"], "sigma_L_mm": np.nan}
    rows |= {"alone": {"recording": "alone", "camera_type": "d", "n_cameras": 4}}
    rows |= {"unknown": {"recording": "unknown", "camera_type": "b", "n_cameras": None}}
    numbers |= {"alone": numbers["b-3"], "unknown": numbers["b-3"]}
    subsets = gather.subsets_of_group(rows, numbers)
    assert len(subsets) == 20
    check(scaling_figure(subsets, (ODD_TEXT, ODD_TEXT, ODD_TEXT)))
    constant = [Subset("t", n, {"sigma_1_mm": 0.0, "sigma_12_mm2": 0.0}) for n in (2, 4)]
    check(scaling_figure(constant, ("nothing moves", "s", "")))
    check(scaling_figure([], ("no recording", "s", "")))
