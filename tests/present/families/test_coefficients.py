"""Coefficients of a group: every number stands where its recording and series are."""

from __future__ import annotations

import numpy as np
import pytest
from family_data import row
from figure_data import ODD_TEXT, check, check_saved, every_text
from noise_data import assert_texts_apart, noise_rows

from mocap_metrology.noise.fit.estimates import refused_rows
from mocap_metrology.noise.model.components import ALPHAS, NoiseModel
from mocap_metrology.noise.twins.published import SERIES, published_row
from mocap_metrology.present.groups import slots
from mocap_metrology.present.groups.coefficients import coefficients_figure, correlated_figure
from mocap_metrology.present.groups.members import family_of

pytestmark = pytest.mark.filterwarnings("error")
NUMBERS = (10, 5, 2)
POINT, LIMIT = slots.COLOURED["markersize"], slots.LIMIT["markersize"]


def group(kind: str = "Bonita", numbers=NUMBERS, series=SERIES):
    rows = {f"{kind}-{n}": row(f"{kind}-{n}", kind, n) for n in numbers}
    noise = {
        name: noise_rows({s: published_row(kind, r["n_cameras"])[s] for s in series}, seed=k)
        for k, (name, r) in enumerate(rows.items())
    }
    return family_of(rows), noise


def marks(axes, size: float) -> list[tuple[float, float]]:
    found = [x for x in axes.lines if x.get_markersize() == size and x.get_marker() in "os^Dv"]
    return sorted(tuple(point) for line in found for point in line.get_xydata())


def expected(noise, names, column: str) -> list[tuple[float, float]]:
    """Places from the rows alone: the smallest number of cameras left, slots as printed by S."""
    found = []
    for name, rows in noise.items():
        place = sorted(NUMBERS).index(int(name.split("-")[1]))
        for r in rows:
            if r["estimator"] == "likelihood" and r["parameter"] in names:
                value = r[column]
                missing = column == "upper_95" and r["status"] != "not_detected"
                if not np.isnan(value) and not missing:
                    slot = (SERIES.index(r["series"]) - 3) / 8.6
                    found.append((place + slot, value))
    return sorted(found)


def test_every_coefficient_is_shown(tmp_path) -> None:
    family, noise = group()
    picture = coefficients_figure(family, noise, "g: power-law noise", "Source: n.", "More.")
    figure = picture.figure
    assert "x1, y1, z1, x2, y2, z2, L." in picture.caption and picture.caption.endswith("More.")
    for axes, alpha in zip(figure.axes[:5], ALPHAS, strict=True):
        for size, column in ((POINT, "value"), (LIMIT, "upper_95")):
            given = expected(noise, [f"h_{alpha}"], column)
            assert np.allclose(marks(axes, size), given, rtol=1e-12), (alpha, column)
        bars = sum(len(lines.get_segments()) for lines in axes.collections)
        assert bars == len(expected(noise, [f"h_{alpha}"], "value"))
    check_saved(picture, tmp_path / "f")
    bottom = figure.axes[4]
    shown = [tick.label1.get_text() for tick in bottom.xaxis.get_major_ticks()]
    assert shown == ["2", "5", "10"] and bottom.get_xlabel() == "Number of cameras"
    assert_texts_apart(figure)


def test_every_correlated_term_is_shown_twice(tmp_path) -> None:
    family, noise = group("T40")
    picture = correlated_figure(family, noise, "g: correlated noise", "n")
    times, amplitudes, scatter = (figure := picture.figure).axes
    assert [axes.get_title(loc="left")[:3] for axes in figure.axes] == ["(a)", "(b)", "(c)"]
    for axes, letter in ((times, "T_c"), (amplitudes, "q_c")):
        given = expected(noise, [f"{letter}{k}" for k in range(1, 9)], "value")
        assert np.allclose(marks(axes, POINT), given, rtol=1e-12)
    terms = []
    for rows in noise.values():
        own = {(r["series"], r["parameter"]): r["value"] for r in rows
               if r["estimator"] == "likelihood"}  # fmt: skip
        terms += [(v, own[s, f"q_c{p[3:]}"]) for (s, p), v in own.items() if p.startswith("T_c")]
    assert np.allclose(marks(scatter, 3.4), sorted(terms), rtol=1e-12)
    assert f"{len(terms)} terms" in every_text(picture)
    assert {"short", "medium", "long"} <= set(every_text(picture))
    check_saved(picture, tmp_path / "f")
    assert_texts_apart(figure)


def test_limits_of_amplitudes_show_their_class() -> None:
    """A recording without correlated noise: the letter of a class stands at its limit."""
    family, _ = group("T40", (10,))
    limits = {"short": 0.04, "medium": 0.002, "long": 0.0005}
    row_of = {"series": "x1", "estimator": "likelihood", "status": "not_detected"}
    noise = [
        row_of
        | {"parameter": f"q_c{k}", "value": np.nan, "lower_95": np.nan, "upper_95": limit}
        | {"note": f"class {kind}: limit for every T_c"}
        for k, (kind, limit) in enumerate(limits.items(), 1)
    ]
    picture = correlated_figure(family, {"T40-10": noise}, "g: correlated noise", "n")
    (axes,) = picture.figure.axes
    found = {
        str(line.get_marker()): line.get_ydata() for line in axes.lines if line.get_xdata().size
    }
    assert found == {slots.LETTERS[kind]: [limit] for kind, limit in limits.items()}
    assert picture.caption.startswith("Correlated noise was not detected in any recording.")
    check(picture)


@pytest.mark.parametrize("draw", [coefficients_figure, correlated_figure])
@pytest.mark.parametrize("case", ["nothing", "refused", "one", "white", "many"])
def test_odd_groups(draw, case) -> None:
    family, noise = group("T40", (10,) if case == "one" else NUMBERS)
    if case == "nothing":
        noise = dict.fromkeys(noise, ())
    elif case == "refused":
        noise = dict.fromkeys(noise, refused_rows("x1", ["likelihood"], "no valid samples"))
    elif case == "white":
        white = NoiseModel.from_coefficients({"h_0": 1e-6})
        noise = dict.fromkeys(noise, noise_rows(dict.fromkeys(("x1", "L"), white)))
    elif case == "many":
        rows = {f"{k}_{'long-name.' * 5}": row("") for k in range(60)}
        family, noise = family_of(rows), dict.fromkeys(rows, noise["T40-10"])
    picture = draw(family, noise, ODD_TEXT, ODD_TEXT, ODD_TEXT)
    check(picture)
    texts = " ".join(" ".join(every_text(picture)).split())
    assert ("No recording has noise coefficients" in texts) == (case in ("nothing", "refused"))
    assert ("not detected in any recording" in texts) == (case == "white")
    assert ("left to right: L." in texts) == (case == "many")
