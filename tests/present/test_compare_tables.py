"""Rows, sentences and figures of recordings beside each other."""

import numpy as np
import pytest
from figure_data import check, every_text
from said import numbers_in

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.changes import rows as changes
from mocap_metrology.noise.series import allan_columns
from mocap_metrology.present.changes import (
    OUTCOMES,
    Comparison,
    compare_figure,
    compare_markdown,
    outcomes,
    sentences,
    trend_figure,
)
from mocap_metrology.present.plot.figure import Texts

SETTINGS = {"margin": 0.05, "alpha": 0.01, "confidence": 0.95}
SERIES = (*(f"{axis}{k}" for k in (1, 2) for axis in "xyz"), "L")
TEXTS = Texts("title", "Source: one.", "More.")
NAMES, DATES = "abcde", [f"2026-{month:02}-01" for month in range(1, 6)]


def columns(factor: float, last_s: float = 400.0, series: tuple[str, ...] = ("x1", "L")) -> dict:
    """Allan deviations factor 0.01 mm sqrt(1 s / tau), white noise's."""
    tau, n = np.geomspace(0.01, last_s, 60), len(series)
    return {
        "series": np.repeat(np.array(series, dtype=object), tau.size),
        "estimator": np.full(tau.size * n, "oadev", dtype=object),
        "tau_s": np.tile(tau, n),
        "adev_mm": factor * np.tile(0.01 / np.sqrt(tau), n),
        "edf": np.tile(3 * last_s / tau, n),
    }


def trend(growth: float, coarse: dict | None = None, series=("x1", "L")) -> tuple[dict, list[dict]]:
    allan = {n: columns(growth**k, series=series) for k, n in enumerate(NAMES)}
    return allan, changes.trend_rows(NAMES, DATES, allan, 0.01, 0.95, coarse)


def test_rows_hold_ratio_interval_and_word() -> None:
    """A ratio of 1.3 is resolved but at 100 s, where there are 12 degrees of freedom."""
    rows = changes.compare_rows("new", "old", columns(1.3), columns(1.0, 900), **SETTINGS)
    assert [row["series"] for row in rows] == ["x1"] * 5 + ["L"] * 5
    assert [row["tau_s"] for row in rows[:5]] == [0.01, 0.1, 1.0, 10.0, 100.0]
    assert all(row["ratio"] == pytest.approx(1.3, rel=1e-6) for row in rows)
    assert [row["word"] for row in rows[5:]] == ["worse"] * 4 + ["same"]
    assert all(row["overall"] == "worse" and row["lower"] < 1.3 < row["upper"] for row in rows)
    said = "new compared with old: worse in x1, L over 0.01 to 10 s; largest change: 1.30 (1."
    text = compare_markdown(rows, "title", "caption")
    assert text.startswith(f"# title\n\ncaption `+` worse, `−` better.\n\n* {said}")
    assert "| x1     | worse | 1.3 (1.29 to 1.31) + | " in text
    with pytest.raises(Refusal, match="new and old: no series"):
        changes.compare_rows("new", "old", columns(1), columns(1, series=("y1",)), **SETTINGS)


def test_places_are_compared_with_their_mean() -> None:
    """Factors of 1, 2 and 4: 1/2, 1 and 2 of their geometric mean."""
    allan = {f"p{k}": columns(2.0**k, series=("L",)) for k in range(3)}
    recordings = [{"recording": name, "place": name.upper()} for name in allan]
    rows = changes.places_rows(recordings, allan, {name: {"x1_mm": 0.0} for name in allan})
    assert [row["factor_1_frame"] for row in rows] == pytest.approx([0.5, 1, 2])
    assert [row["factor_1_s"] for row in rows] == pytest.approx([0.5, 1, 2], rel=1e-3)
    assert [row["adev_1_frame_mm"] for row in rows] == pytest.approx([0.1, 0.2, 0.4])
    assert [row["quietest"] for row in rows] == [True, False, False]
    assert all(r["factor_1_s_lower"] < r["factor_1_s"] < r["factor_1_s_upper"] for r in rows)
    allan["p1"] = columns(1.0, series=("x1",))
    with pytest.raises(Refusal, match="a series that all places have"):
        changes.places_rows(recordings, allan, {name: {} for name in allan})


def test_a_growth_of_ten_percent_a_month() -> None:
    _, rows = trend(1.1)
    assert [(row["series"], row["n_recordings"]) for row in rows] == [("x1", 5)] * 5 + [
        ("L", 5)
    ] * 5
    assert all(row["percent_per_month"] == pytest.approx(10, rel=0.05) for row in rows)
    assert all(row["lower"] < row["percent_per_month"] < row["upper"] for row in rows)
    assert [row["word"] for row in rows[:5]] == ["worse"] * 3 + [changes.NO_TREND] * 2
    assert trend(1 / 1.1)[1][0]["word"] == "better"
    words = [row["word"] for row in trend(1.1, {"x1": 0.1})[1]]
    assert words[:5] == ["resolution"] * 5 and words[5] == "worse"
    with pytest.raises(Refusal, match="time zone"):
        changes.days_of(["2026-01-01", "2026-01-02T00:00:00+01:00"])
    assert changes.days_of(["2026-01-02T06:00", "2026-01-01T00:00"]) == [1.25, 0]


def test_sentences_name_series_times_and_the_largest_change() -> None:
    """x1 is worse at 0.1 and 1 s, L at 0.1 s alone: not both over 0.1 to 1 s."""
    row = {"recording": "b", "reference": "a", "word": "worse", "lower": 1.1, "upper": 2.0}
    rows = [
        row | {"series": series, "tau_s": tau, "ratio": ratio}
        for series, tau, ratio in (("x1", 0.1, 1.5), ("L", 0.1, 1.3), ("x1", 1.0, 1.2))
    ]
    better = rows[0] | {"word": "better", "series": "y1", "ratio": 0.5}
    limited = row | {"word": "resolution", "step_mm": 0.1}
    same = [
        row | {"word": "same", "recording": "c", "series": "z1", "ratio": ratio} | ends
        for ratio, ends in (
            (0.98, {"tau_s": 0.01, "lower": 0.9, "upper": 1.02}),
            (1.01, {"tau_s": 0.01, "lower": 0.95, "upper": 1.1}),
            (2.0, {"tau_s": 100.0, "lower": 0.5, "upper": 8.0}),
        )
    ]
    others = [*same, limited | {"recording": "d", "series": "L"}]
    said = list(map(numbers_in, sentences([*rows, better, *others])))
    assert said == [
        "x1, L, 0.1 s, x1, 1 s, 1.50, 1.10, 2.00, x1, 0.1 s, y1, 0.1 s, "
        "0.50, 1.10, 2.00, y1, 0.1 s",
        "0.98, 1.01, 0.01 s, 0.90, 1.10, 3, 1, 2.00, 0.50, 8.00, z1, 100 s",
        "L, 0.1 mm",
    ]
    same[-1]["upper"] = 1e5  # tells nothing
    assert numbers_in(sentences(same)[0]).endswith("1.10, 3, 1, 2, z1, 100 s")
    found = outcomes([*rows, better, *others])
    assert list(found.values()) == ["worse and better", OUTCOMES[3], "limited by the resolution"]
    assert set(outcomes(rows, {"b": [{"code": "low_pass"}]}).values()) == {"not comparable"}
    rates = {"code": "rates", "new_hz": 50.0, "old_hz": 200.0, "white": 2.0}
    (words,) = sentences(rows, {"b": [rates]})
    assert numbers_in(words).endswith("x1, 0.1 s, 50, 200 Hz, 2.00")
    alike = [*rows, rows[0] | {"series": "L", "tau_s": 1.0, "ratio": 1.1}]
    assert numbers_in(sentences(alike)[0]).startswith("x1, L, 0.1, 1 s, 1.50")


@pytest.mark.parametrize(
    ("step", "hidden"), [(0.05, True), (0.1, True), (0.0, False), (0.01, False)]
)
def test_steps_that_hide_the_noise_are_no_change(step: float, hidden: bool) -> None:
    """The same noise put elsewhere within a step; real changes at fine steps are found."""
    rng, m = np.random.default_rng(1), averaging_factors(30_000, 30, 1, 1 / 3)
    for sigmas in 4 * [(0.02, 0.02), (0.4 * step,) * 2] if hidden else [(0.026, 0.02)]:
        both = []
        for sigma in sigmas:
            position = sigma * rng.normal(size=30_000) + rng.uniform(0, step)
            stored = np.round(position / step) * step if step else position
            both.append(allan_columns("x1", allan_curve(stored, 100.0, m)))
        coarse = changes.coarse_steps(both[0], step) | changes.coarse_steps(both[1], step)
        assert coarse == ({"x1": step} if hidden else {})
        rows = changes.compare_rows("new", "old", *both, **SETTINGS, coarse=coarse)
        assert {row["overall"] for row in rows} == {"resolution" if hidden else "worse"}
    assert not changes.coarse_steps(both[0], None) and not changes.coarse_steps(both[0], np.inf)


def test_rounding_of_one_file_alone_is_no_change() -> None:
    """Noise of 0.03 mm in steps of 0.05 mm is 1.11 times that of exact coordinates; where both
    have these steps, there is no change, and three times as much noise is one in either case."""
    rng, m = np.random.default_rng(2), averaging_factors(30_000, 30, 1, 1 / 3)
    step = 0.05

    def recorded(sigma: float, step: float | None) -> dict:
        position = sigma * rng.normal(size=30_000)
        stored = np.round(position / step) * step if step else position
        return allan_columns("x1", allan_curve(stored, 100.0, m))

    for sigma, steps, word in (
        (0.03, (step, 0.0), "resolution"),
        (0.03, (step, step), "same"),
        (0.09, (step, 0.0), "worse"),
    ):
        both = recorded(sigma, steps[0]), recorded(0.03, steps[1])
        coarse = changes.coarse_in_either(*both, steps, SETTINGS["margin"])
        rows = changes.compare_rows("new", "old", *both, **SETTINGS, coarse=coarse)
        assert {row["overall"] for row in rows} == {word}


def test_figure_shows_the_last_ratios_with_their_intervals() -> None:
    both = [
        Comparison(f"r{k}", f"r{k - 1}", *(columns(f, series=SERIES) for f in (1 + k / 10, 1)))
        for k in range(1, 9)
    ]
    picture = compare_figure(both, 0.05, 0.95, TEXTS)
    texts = every_text(picture)
    assert "r8 / r7" in texts and "r2 / r1" not in texts
    for k, row in enumerate(np.array(picture.figure.axes).reshape(6, 3), 3):
        for axes, count in zip(row, (3, 3, 1), strict=True):
            drawn = [line.get_ydata() for line in axes.lines if len(line.get_ydata()) > 2]
            assert len(drawn) == count and all(np.allclose(y, 1 + k / 10) for y in drawn)
    check(picture)


def test_trend_figure_has_a_line_where_there_is_a_trend() -> None:
    allan, rows = trend(1.1)
    picture = trend_figure(NAMES, DATES, allan, rows, TEXTS)
    panels = picture.figure.axes
    assert len(panels) == 3 * 2 and picture.caption.endswith("More.")
    lines = [line for axes in panels for line in axes.lines if line.get_ls() != "None"]
    trends = [line.get_ydata() for line in lines if len(line.get_xdata()) == len(NAMES)]
    clear = [row for row in rows if row["tau_s"] in (0.01, 1, 100) and row["word"] == "worse"]
    assert len(trends) == len(clear) == 4
    assert all(np.log(y[-1] / y[0]) == pytest.approx(4 * np.log(1.1), rel=0.1) for y in trends)
    points = [axes.containers[0].lines[0].get_ydata() for axes in panels]
    assert all(np.allclose(y[1:] / y[:-1], 1.1) for y in points)
    assert points[0][0] == pytest.approx(100)  # µm
    check(picture)
