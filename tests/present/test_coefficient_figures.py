"""Figures of coefficients: every number stands where its recording and series are."""

import numpy as np
import pandas as pd
import pytest
from figure_data import check, every_text
from noise_data import group, noise_rows
from noise_data import row as sheet_row

from mocap_metrology.noise.model.components import ALPHAS, NoiseModel
from mocap_metrology.noise.twins.published import SERIES, published_row
from mocap_metrology.papers.coefficient_tables import TABLES, table_a
from mocap_metrology.present.groups import slots
from mocap_metrology.present.groups.figures import coefficients_figure, family_of
from mocap_metrology.present.groups.figures import correlated_figure as group_correlated
from mocap_metrology.present.plot.figure import Texts
from mocap_metrology.present.skurowski.coefficients import (
    TYPES,
    colour_figure,
    correlated_figure,
)

pytestmark = pytest.mark.filterwarnings("error")
NUMBERS = (10, 5, 2)
UPPER = "likelihood_upper_95"


def table_rows(keys=None):
    given = group(keys)
    kinds = TABLES if keys is None else dict.fromkeys(kind for kind, _ in keys)
    return [
        row for kind in kinds
        for row in table_a(kind, *given)
        if keys is None or (kind, row["n_cameras"]) in keys
    ]  # fmt: skip


@pytest.fixture(scope="module")
def rows():
    return table_rows()


def drawn(axes, *styles: str, marker=None) -> np.ndarray:
    """(k, 2) points of a panel drawn in a style, or with a marker, sorted."""
    markers = [marker] if marker is not None else [slots.STYLES[s]["marker"] for s in styles]
    sizes = {slots.STYLES[s]["ms"] for s in styles} or {3.4}
    found = [
        line.get_xydata()
        for line in axes.lines
        if line.get_marker() in markers
        and line.get_markersize() in sizes
        and line.get_ls() == "None"
    ]
    points = np.concatenate(found) if found else np.zeros((0, 2))
    return points[np.lexsort(points.T)]


def places(own: pd.DataFrame, column: str, groups) -> np.ndarray:
    """Where the numbers of a panel should stand, from the rows of a table alone."""
    x = own["n_cameras"].map(list(groups).index) + (own["series"].map(SERIES.index) - 3) / 8.6
    points = np.column_stack([x, own[column].astype(float)])
    points = points[np.isfinite(points[:, 1])]
    return points[np.lexsort(points.T)]


@pytest.mark.parametrize("logarithmic", [True, False])
def test_colours_of_noise_show_every_number(rows, logarithmic) -> None:
    made = colour_figure(rows, "s", "n", logarithmic=logarithmic)
    grid = np.array(made.body.axes).reshape(5, 3)
    table = pd.DataFrame(rows)
    for (j, k), axes in np.ndenumerate(grid):
        own = table[(table["parameter"] == f"h_{ALPHAS[j]}") & (table["camera_type"] == TYPES[k])]
        assert len(own) == 49 + 7 * (TYPES[k] == "Vantage")
        groups, top = sorted(own["n_cameras"].unique()), axes.get_ylim()[1]
        ticks = [t.get_text() for t in grid[4, k].get_xticklabels()]
        assert ticks == [str(n) for n in groups]
        above = 0
        for column, styles in (
            ("published", (slots.PUBLISHED, slots.PALE)),
            ("regenerated", (slots.S_VALUE,)),
            ("likelihood", (slots.VALUE,)),
        ):
            expected = places(own, column, groups)
            if logarithmic:
                expected[expected[:, 1] < slots.FLOOR, 1] = slots.in_band(slots.FLOOR)
                expected = expected[np.lexsort(expected.T)]
            above += (expected[:, 1] > top).sum()
            shown = expected[expected[:, 1] <= top]
            assert np.allclose(drawn(axes, *styles), shown, rtol=1e-12, atol=0), (j, k, column)
        arrows = drawn(axes, marker=slots.UP)
        assert np.all(arrows[:, 1] == top) and len(arrows) >= above
        assert (above > 0) == (not logarithmic)
        limits = own.loc[own["likelihood_status"] == "not_detected", UPPER]
        assert np.allclose(drawn(axes, slots.LIMIT)[:, 1], np.sort(limits[limits <= top]))
    check(made, apart=True)


def test_correlated_terms(rows) -> None:
    made = correlated_figure(rows, "s", "n")
    table = pd.DataFrame(
        [r for r in rows if r["parameter"][1:3] == "_c" and "(" not in r["parameter"]]
    )
    table["number"], table["name"] = table["parameter"].str[3:], table["parameter"].str[:3]
    keys = ["camera_type", "n_cameras", "series", "number"]
    panels = {axes.get_title(loc="left"): axes for axes in made.body.axes}
    titles = ["(a) T40", "(b) Bonita", "(c) Vantage"]
    sources = {"published": "published", "annealing-ant-colony": "regenerated"}
    for letter, (name, column) in zip(
        "def", (sources | {"likelihood": "likelihood"}).items(), strict=False
    ):
        terms = table.pivot(index=keys, columns="name", values=column).astype(float)
        axes = panels[f"({letter}) {name}"]
        points = np.concatenate(
            [
                x.get_xydata()
                for x in axes.lines
                if x.get_markersize() in (3.0, 3.6) and len(x.get_xdata())
            ]
        )
        assert len(terms) == 511 and "511 terms" in every_text(made)  # of Tables A1-A3
        expected = terms[["T_c", "q_c"]].to_numpy()
        assert np.allclose(points[np.lexsort(points.T)], expected[np.lexsort(expected.T)], atol=0)
    assert titles == list(panels)[:3]
    own = table[(table["camera_type"] == "T40") & (table["name"] == "T_c")]
    expected = places(own, "published", sorted(own["n_cameras"].unique()))
    assert np.allclose(drawn(panels["(a) T40"], slots.PUBLISHED, slots.PALE), expected)
    check(made, apart=True)


# ---- of any group


def family(kind: str = "Bonita", numbers=NUMBERS, series=SERIES):
    rows = {f"{kind}-{n}": sheet_row(f"{kind}-{n}", kind, n) for n in numbers}
    noise = {
        name: noise_rows({s: published_row(kind, r["n_cameras"])[s] for s in series}, seed=k)
        for k, (name, r) in enumerate(rows.items())
    }
    return family_of(rows), noise


def table_of(noise) -> pd.DataFrame:
    parts = [pd.DataFrame(r).assign(n_cameras=int(n.split("-")[1])) for n, r in noise.items()]
    table = pd.concat(parts)
    table["limit"] = table["upper_95"].where(table["status"] == "not_detected")
    return table[table["estimator"] == "likelihood"]


def values_drawn(axes) -> np.ndarray:
    found = [x.get_xydata() for x in axes.lines if x.get_markersize() == 4.2]
    points = np.concatenate(found)
    return points[np.lexsort(points.T)]


def test_every_correlated_term_of_a_group_is_shown_twice() -> None:
    of, noise = family("T40")
    picture = group_correlated(of, noise, Texts("g: correlated noise", "n"))
    *panels, scatter = picture.figure.axes
    table = table_of(noise)
    table = table[table["parameter"].str[1:3] == "_c"]
    table["name"], table["number"] = table["parameter"].str[:3], table["parameter"].str[3:]
    for axes, name in zip(panels, ("T_c", "q_c"), strict=True):
        expected = places(table[table["name"] == name], "value", sorted(NUMBERS))
        assert np.allclose(values_drawn(axes), expected, rtol=1e-12)
    terms = table.pivot(index=["n_cameras", "series", "number"], columns="name", values="value")
    points = np.concatenate([x.get_xydata() for x in scatter.lines if x.get_markersize() == 3.4])
    assert np.allclose(np.sort(points[:, 0]), np.sort(terms["T_c"]), rtol=1e-12)
    assert np.allclose(np.sort(points[:, 1]), np.sort(terms["q_c"]), rtol=1e-12)
    check(picture, apart=True)


def test_many_recordings_show_one_series_the_noisiest_first() -> None:
    rows = {f"R{k}": sheet_row(f"R{k}", n_cameras=None) for k in range(22)}
    levels = {name: 1e-6 * (1 + (7 * k) % 22) for k, name in enumerate(rows)}
    models = {n: NoiseModel.from_coefficients({"h_0": level}) for n, level in levels.items()}
    noise = {n: noise_rows(dict.fromkeys(SERIES, model), 0.001) for n, model in models.items()}
    picture = coefficients_figure(family_of(rows), noise, Texts("t", "s"))
    h_0 = picture.body.axes[2]
    points = values_drawn(h_0)
    points = points[np.argsort(points[:, 0])]
    assert points[:, 0].tolist() == list(range(22)) and np.all(np.diff(points[:, 1]) < 0)
    names = [t.get_text() for t in picture.body.axes[4].get_xticklabels()]
    assert names == sorted(rows, key=lambda name: -levels[name])
