"""Rows, words and the figure of comparisons."""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import ODD_TEXT, check, check_saved, every_text

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.series import allan_columns
from mocap_metrology.present.changes import compare
from mocap_metrology.present.changes.change_figures import Comparison, compare_figure, trend_figure
from mocap_metrology.present.motion import place

SETTINGS = {"margin": 0.05, "alpha": 0.01, "confidence": 0.95}


def columns(factor: float, last_s: float = 400.0, series: tuple[str, ...] = ("x1", "L")) -> dict:
    tau = np.geomspace(0.01, last_s, 60)
    names = np.repeat(np.array(series, dtype=object), tau.size)
    n = len(series)
    return {
        "series": names,
        "estimator": np.full(names.size, "oadev", dtype=object),
        "tau_s": np.tile(tau, n),
        "adev_mm": factor * np.tile(0.01 / np.sqrt(tau), n),
        "edf": np.tile(3 * last_s / tau, n),
    }


def test_rows_hold_ratio_interval_and_word() -> None:
    rows = compare.compare_rows("new", "old", columns(1.3), columns(1.0, 900), **SETTINGS)
    assert {row["series"] for row in rows} == {"x1", "L"}
    assert [row["tau_s"] for row in rows[:5]] == [0.01, 0.1, 1.0, 10.0, 100.0]
    assert all(row["ratio"] == pytest.approx(1.3, rel=1e-6) for row in rows)
    assert [row["word"] for row in rows[:5]] == ["worse", "worse", "worse", "worse", "same"]
    assert all(row["overall"] == "worse" and row["lower"] < 1.3 < row["upper"] for row in rows)
    said = compare.sentences(rows)
    assert said[0].startswith(
        "new compared with old: worse in x1, L over 0.01 to 10 s; largest change: 1.30"
    )
    text = compare.compare_markdown(rows, "title", "caption")
    assert "1.3 (1.2" in text and "| worse" in text
    assert not any(np.isnan(row["ratio"]) for row in rows)


def test_seven_equal_series_are_rarely_called_changed() -> None:
    """600 comparisons of recordings alike, with chi-squared Allan variances: at alpha = 0.1 some
    series is called changed in 6 to 13 % (in half of them if each series had all of alpha)."""
    rng = np.random.default_rng(1)
    series = ("x1", "y1", "z1", "x2", "y2", "z2", "L")
    settings = SETTINGS | {"margin": 0.0, "alpha": 0.1}
    called = 0
    for _ in range(600):
        both = [columns(1.0, 0.02, series) for _ in range(2)]
        for one in both:
            one["edf"][:] = 60.0
            for name in series:
                one["adev_mm"][one["series"] == name] *= np.sqrt(rng.chisquare(60) / 60)
        rows = compare.compare_rows("new", "old", *both, **settings)
        called += any(row["word"] != "same" for row in rows)
    assert 0.06 < called / 600 < 0.13


def test_places_are_held_against_their_mean() -> None:
    """Factors of 1, 2 and 4: 1/2, 1 and 2 of their geometric mean."""
    allan = {f"p{k}": columns(2.0**k, series=("L",)) for k in range(3)}
    recordings = [{"recording": name, "place": name.upper()} for name in allan]
    rows = place.places_rows(recordings, allan, {name: {"x1_mm": 0.0} for name in allan})
    assert [row["factor_1_frame"] for row in rows] == pytest.approx([0.5, 1, 2])
    assert [row["factor_1_s"] for row in rows] == pytest.approx([0.5, 1, 2], rel=1e-3)
    assert [row["quietest"] for row in rows] == [True, False, False]
    assert all(r["factor_1_s_lower"] < r["factor_1_s"] < r["factor_1_s_upper"] for r in rows)


def test_nothing_in_common_is_refused() -> None:
    with pytest.raises(Refusal, match="new and old: no series"):
        compare.compare_rows(
            "new", "old", columns(1, series=("x1",)), columns(1, series=("y1",)), **SETTINGS
        )


def test_trend_rows() -> None:
    names = ["a", "b", "c", "d", "e"]
    dates = [f"2026-{month:02}-01" for month in range(1, 6)]
    allan = {n: columns(1.1**k) for k, n in enumerate(names)}
    rows = compare.trend_rows(names, dates, allan, 0.01, 0.95)
    assert len(rows) == 2 * 5
    assert all(row["percent_per_month"] == pytest.approx(10, rel=0.05) for row in rows)
    assert rows[0]["word"] == "worse" and rows[4]["word"] == compare.NO_TREND
    with pytest.raises(Refusal, match="time zone"):
        compare.days_of(["2026-01-01", "2026-01-02T00:00:00+01:00"])


SERIES = (*(f"{axis}{k}" for k in (1, 2) for axis in "xyz"), "L")


def test_figure_shows_the_last_ratios_with_their_intervals(tmp_path) -> None:
    both = [
        Comparison(
            f"r{k}", f"r{k - 1}", columns(1 + k / 10, series=SERIES), columns(1, series=SERIES)
        )
        for k in range(1, 9)
    ]
    picture = compare_figure(both, 0.05, 0.95, "title", "Source: one.", "More.")
    assert "More. The last 6 of 8 comparisons" in picture.caption
    texts = every_text(picture)
    assert "r8 / r7" in texts and "r2 / r1" not in texts
    assert {"x", "y", "z", "L", "95 % interval", "no change: within 5 %"} <= set(texts)
    rows = np.array(picture.figure.axes).reshape(6, 3)
    for k, (first, second, distances) in enumerate(rows, 3):
        for axes, count in ((first, 3), (second, 3), (distances, 1)):
            curves = [line.get_ydata() for line in axes.lines if len(line.get_ydata()) > 2]
            assert len(curves) == count and all(np.allclose(c, 1 + k / 10) for c in curves)
    check_saved(picture, tmp_path / "f")


@pytest.mark.parametrize("factor", [1.0, 1.02, 40.0, 3e4])
def test_figures_of_odd_recordings(factor) -> None:
    """Equal ones, a ratio of four decades, many markers, long names, values that are missing."""
    many = [f"{axis}{k}" for k in range(1, 10) for axis in "xyz"] + ["L"]
    new, old = columns(factor, series=tuple(many)), columns(1.0, series=tuple(many))
    new["adev_mm"][new["series"] == "x1"] = np.nan
    short = Comparison("new", "old", columns(factor, series=("x1",)), old)
    picture = compare_figure(
        [Comparison(ODD_TEXT, "old_" * 20, new, old), short], 0.05, 0.95, ODD_TEXT, ODD_TEXT
    )
    check(picture)
    assert len(picture.figure.axes) == 8  # a column a coordinate, and the distance
    apart = columns(factor, 0.02, series=("x1",)), columns(1.0, series=("y1",))
    check(compare_figure([Comparison("a", "b", *apart)], 0.05, 0.95, "title", "source"))


def test_trend_figure_has_a_line_where_there_is_a_trend(tmp_path) -> None:
    names = ["a", "b", "c", "d", "e"]
    dates = [f"2026-{month:02}-01" for month in range(1, 6)]
    allan = {n: columns(1.1**k) for k, n in enumerate(names)}
    rows = compare.trend_rows(names, dates, allan, 0.01, 0.95)
    picture = trend_figure(names, dates, allan, rows, "title", "Source: one.", "More.")
    panels = picture.figure.axes
    assert len(panels) == 3 * 2 and picture.caption.endswith("More.")
    clear = [
        [r for r in rows if r["tau_s"] == tau and r["word"] != compare.NO_TREND]
        for tau in (0.01, 1, 100)
    ]
    lines = [line for axes in panels for line in axes.lines if line.get_ls() != "None"]
    trends = [line for line in lines if len(line.get_xdata()) == len(names)]
    assert len(trends) == sum(map(len, clear)) > 0
    for line in trends:
        assert np.log(line.get_ydata()[-1] / line.get_ydata()[0]) == pytest.approx(
            4 * np.log(1.1), rel=0.1
        )
    points = [axes.containers[0].lines[0] for axes in panels]
    assert all(np.allclose(p.get_ydata()[1:] / p.get_ydata()[:-1], 1.1) for p in points)
    ticks = [text.get_text() for text in panels[-1].get_xticklabels()]
    assert "2026" in ticks and len(ticks) >= 2
    check_saved(picture, tmp_path / "f")


@pytest.mark.parametrize(
    "dates",
    [
        ("2026-01-01T08:00:00+01:00", "2026-01-01T20:00:00+01:00", "2026-01-02T03:30:00+01:00"),
        ("2016-01-01", "2021-07-01", "2026-07-01"),
        ("2026-01-01", "2026-01-02", "2026-12-02"),
    ],
)
def test_trend_over_hours_and_years(dates) -> None:
    names = ["a", "b", "c"]
    allan = {n: columns(1.0, series=SERIES) for n in names}
    rows = compare.trend_rows(names, dates, allan, 0.01, 0.95)
    picture = trend_figure(names, dates, allan, rows, ODD_TEXT, ODD_TEXT)
    check(picture)
    assert "Averaged over 100 s" in every_text(picture)


def test_a_sentence_says_no_more_than_its_rows() -> None:
    """x1 is worse at 0.1 and 1 s, L at 0.1 s alone: not both over 0.1 to 1 s."""
    row = {"recording": "b", "reference": "a", "word": "worse", "lower": 1.1, "upper": 2.0}
    rows = [
        row | {"series": series, "tau_s": tau, "ratio": ratio}
        for series, tau, ratio in (("x1", 0.1, 1.5), ("L", 0.1, 1.3), ("x1", 1.0, 1.2))
    ]
    rows.append(rows[0] | {"series": "L", "tau_s": 1.0, "word": "same"})
    assert compare.sentences(rows) == [
        "b compared with a: worse in x1, L at 0.1 s and in x1 at 1 s; largest change: 1.50 (1.10 "
        "to 2.00) times in x1 at 0.1 s."
    ]
    alike = [r | {"word": "worse"} for r in rows]
    assert "worse in x1, L over 0.1 to 1 s; largest" in compare.sentences(alike)[0]


def made(position: np.ndarray, step: float) -> dict:
    """Columns of x1 as an export with that step has them, 100 Hz."""
    stored = np.round(position / step) * step if step else position
    m = averaging_factors(stored.size, 30, 1, 1 / 3)
    return allan_columns("x1", allan_curve(stored, 100.0, m))


@pytest.mark.parametrize("step", [0.05, 0.1])
def test_steps_that_hide_the_noise_are_no_change(step: float) -> None:
    """The same noise put elsewhere within a step; real changes at fine steps are found."""
    rng, changed, said = np.random.default_rng(1), 0, 0
    for sigma in (0.02, 0.4 * step):
        for _ in range(4):
            both = [sigma * rng.normal(size=30_000) + rng.uniform(0, step) for _ in range(2)]
            new, old = (made(position, step) for position in both)
            coarse = compare.coarse_steps(new, step) | compare.coarse_steps(old, step)
            rows = compare.compare_rows("new", "old", new, old, **SETTINGS, coarse=coarse)
            changed += any(row["word"] in ("better", "worse") for row in rows)
            said += (
                "the resolution of the export limits the result in x1" in compare.sentences(rows)[0]
            )
    assert (changed, said) == (0, 8)
    for fine in (0.0, 0.01):
        new, old = (made(s * rng.normal(size=30_000), fine) for s in (0.026, 0.02))
        coarse = compare.coarse_steps(new, fine) | compare.coarse_steps(old, fine)
        rows = compare.compare_rows("new", "old", new, old, **SETTINGS, coarse=coarse)
        assert {row["overall"] for row in rows} == {"worse"}


def test_no_trend_is_told_of_what_the_steps_decide() -> None:
    names, dates = ["a", "b", "c", "d"], [f"2024-0{k}-01" for k in (1, 2, 3, 4)]
    allan = {name: columns(1.2**k) for k, name in enumerate(names)}
    rows = compare.trend_rows(names, dates, allan, 0.01, 0.95)
    assert "worse" in {row["word"] for row in rows if row["series"] == "x1"}
    rows = compare.trend_rows(names, dates, allan, 0.01, 0.95, {"x1": 0.1})
    assert {row["word"] for row in rows if row["series"] == "x1"} == {"resolution"}
