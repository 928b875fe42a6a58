"""Tables A1-A3: every printed number once, partners, leftovers, what their length supports."""

import csv
import math
from collections import Counter

import pytest
from noise_data import DEFAULT, PAPER, estimate, group

from mocap_metrology.noise.fit.estimates import rows as noise_csv
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import printed_row, published_keys, published_row
from mocap_metrology.papers import coefficient_tables as appendix
from mocap_metrology.present.skurowski.appendix import (
    CAPTION,
    table_a_markdown,
    white_level_sentence,
)
from mocap_metrology.present.text.numbers import significant

KEY = ("camera_type", "n_cameras", "series", "parameter")


@pytest.fixture(scope="module")
def given():
    return group()


@pytest.fixture(scope="module")
def everything(given):
    return {kind: appendix.table_a(kind, *given) for kind in appendix.TABLES}


def test_every_printed_number_occurs_exactly_once(everything, reference) -> None:
    with (reference / "noise_coefficients.csv").open(encoding="utf-8") as stream:
        printed = Counter(
            (r["camera_type"], int(r["n_cameras"]), r["series"], r["parameter"], float(r["value"]))
            for r in csv.DictReader(stream)
        )
    made = Counter(
        (*(row[k] for k in KEY), row["published"])
        for rows in everything.values()
        for row in rows
        if row["published"] is not None
    )
    assert made == printed and made.total() == 1862
    assert {k: len(v) for k, v in everything.items()} == {"T40": 679, "Bonita": 567, "Vantage": 616}


def test_numbers_beside_the_published_one_are_those_of_noise_csv(given, everything) -> None:
    _, noise, expected = given
    published = {key: published_row(*key) for key in published_keys()}
    for kind, rows in everything.items():
        for row in rows:
            name, series, parameter = row["recording"], row["series"], row["parameter"]
            own = published[kind, row["n_cameras"]][series]
            if parameter not in own.coefficients():
                assert row["regenerated"] is row["likelihood"] is row["supported"] is None
                assert "above half of the frame rate" in row["note"]
                continue
            value = own.coefficients()[parameter]
            # Two terms of nearly one T_c may be swapped by their scatter, and with them q_c
            near = math.inf if parameter.startswith("q_c") else 0.3
            assert row["regenerated"] == pytest.approx(value, rel=near)
            of_series = [r for r in noise[name] if r["series"] == series]
            assert row["regenerated"] in {r["value"] for r in of_series if r["estimator"] == PAPER}
            assert row["expected"] in {r.get("value") for r in expected[name]}
            if row["likelihood_status"] == "not_detected":
                assert (row["likelihood"], row["likelihood_upper_95"]) == (None, 1e-11)
            else:
                assert row["likelihood"] == pytest.approx(value, rel=near)
                assert row["likelihood_lower_95"] < row["likelihood"] < row["likelihood_upper_95"]
            weak = parameter in ("h_-1", "h_2")
            assert row["crlb_relative"] == pytest.approx(20.0 if weak else 0.1)
            assert row["published_crlb"] == pytest.approx(row["crlb_relative"] * value)
            assert row["supported"] is (parameter not in ("h_-1", "h_2"))


@pytest.fixture
def table(monkeypatch):
    """Function of a published model, fitted ones by estimator, and bounds: the rows of T40, ten
    cameras, x1, with this model as the published one, by parameter."""

    def rows_of(published: NoiseModel, fitted: dict, more=(), **crlb) -> dict:
        sheet = {"T40-10": {"twin": "T", "camera_type": "T40", "n_cameras": 10}}
        names = appendix.published
        monkeypatch.setattr(names, "published_keys", lambda: [("T40", 10)])
        monkeypatch.setattr(names, "printed_row", lambda *_: {"x1": published.coefficients()})
        monkeypatch.setattr(names, "published_row", lambda *_: {"x1": published})
        noise = [
            row
            for name, model in fitted.items()
            for row in noise_csv("x1", estimate(model, name, 0.0, 1))
        ]
        of_x1 = {"series": "x1", "estimator": "published"}
        bounds = [of_x1 | {"parameter": name, "crlb": value} for name, value in crlb.items()]
        noise += [noise[0] | row for row in more]
        rows = appendix.table_a("T40", sheet, {"T40-10": noise}, {"T40-10": bounds})
        return {row["parameter"]: row for row in rows}

    return rows_of


def test_partners_and_leftovers(table) -> None:
    published = NoiseModel((PowerLaw(0, 1e-6), GaussMarkov(0.5, 10.0), GaussMarkov(0.2, 0.1)))
    short, middle, far = GaussMarkov(0.21, 0.11), GaussMarkov(0.4, 30.0), GaussMarkov(0.9, 2000.0)
    line = Sinusoid(1e-3, 14.4)
    rows = table(
        published,
        {
            PAPER: NoiseModel((PowerLaw(0, 2e-6), short, far)),
            DEFAULT: NoiseModel((PowerLaw(0, 1e-6), short, middle, far, line)),
        },
        h_0=1e-6,
        T_c1=10.001,
        q_c1=math.inf,
    )
    # annealing: 0.11 s belongs to 0.1 s; 2000 s is too far from 10 s
    assert (rows["q_c2"]["regenerated"], rows["T_c2"]["regenerated"]) == (0.21, 0.11)
    assert rows["T_c1"]["regenerated"] is None
    assert rows["T_c1"]["regenerated_status"] == "unpaired"
    assert "annealing-ant-colony: its T_c1" in rows["T_c2"]["note"]
    # likelihood: 30 s belongs to 10 s, 2000 s and the line are left over
    assert rows["T_c1"]["likelihood"] == 30.0 and rows["q_c1"]["likelihood"] == 0.4
    left = [name for name, row in rows.items() if row["published"] is None]
    assert left == [
        *(f"{n} ({PAPER})" for n in ("q_c2", "T_c2")),
        *(f"{n} ({DEFAULT})" for n in ("q_c3", "T_c3", "A_s", "f_0")),
    ]
    assert rows[f"T_c2 ({PAPER})"]["regenerated"] == 2000.0
    assert rows[f"f_0 ({DEFAULT})"]["likelihood"] == 14.4
    assert rows[f"f_0 ({DEFAULT})"]["note"] == "not published"
    assert rows[f"f_0 ({DEFAULT})"]["unit"] == "Hz"
    # supported: up to a relative standard error of one
    assert rows["h_0"]["supported"] is True and rows["h_0"]["crlb_relative"] == 1.0
    assert rows["T_c1"]["supported"] is False and rows["q_c1"]["supported"] is False
    assert rows["T_c2"]["supported"] is None and rows["T_c2"]["crlb_relative"] is None


def test_a_term_without_a_partner_has_the_limit_of_its_class(table) -> None:
    published = NoiseModel((GaussMarkov(0.2, 0.1), GaussMarkov(1e-4, 2000.0)))
    limit = {"value": math.nan, "status": "not_detected"}
    limits = [
        limit | {"parameter": f"q_c{k}", "upper_95": upper, "note": f"class {kind}: limit"}
        for k, kind, upper in ((2, "medium", 5e-4), (3, "long", 7e-4))
    ]
    rows = table(published, {DEFAULT: NoiseModel((GaussMarkov(0.2, 0.1),))}, limits)
    assert rows["q_c2"]["likelihood_status"] == "not_detected"
    assert (rows["q_c2"]["likelihood"], rows["q_c2"]["likelihood_upper_95"]) == (None, 7e-4)
    assert rows["T_c2"]["likelihood_status"] == "unpaired"
    assert list(rows) == ["q_c1", "T_c1", "q_c2", "T_c2"]
    assert "< 7.00×10⁻⁴" in table_a_markdown(list(rows.values()), "T", "C")


def test_white_levels_are_those_of_the_rows_and_counted(everything) -> None:
    levels = appendix.white_levels([row for rows in everything.values() for row in rows])
    found = {(r["camera_type"], r["n_cameras"], r["series"]): r["published"] for r in levels}
    printed = {(*key, s): row["h_0"] for key in published_keys()
               for s, row in printed_row(*key).items()}  # fmt: skip
    assert found == printed and len(levels) == 154
    for row in levels:
        for name, base in (("likelihood", "published"), ("regenerated", "expected")):
            assert row[name] == pytest.approx(row[base] * (1 + row[f"{name}_percent"] / 100))
        assert row["likelihood_allowed_percent"] == pytest.approx(30.0)  # three bounds of 10 %
    far = sum(abs(row["regenerated_percent"]) > 5 for row in levels)
    sentence = white_level_sentence(levels)
    assert sentence.startswith("Of 154 series, expected deviates by more than 5 % in 0, ")
    assert f"from expected by more than 5 % in {far}, and" in sentence
    assert sentence.endswith("5 % and 3 bounds in 0.")
    for odd in (31.0, -31.0, None):
        assert white_level_sentence([levels[0] | {"likelihood_percent": odd}]).endswith(
            "in 1 (T40-10 x1)."
        )
    assert white_level_sentence([levels[0] | {"recording": None}]).startswith("Of 0 series")


def test_markdown_shows_every_printed_number(everything) -> None:
    for rows in everything.values():
        lines = table_a_markdown(rows, "Table", CAPTION).split("\n")
        rows_ = [x.split("|")[3:-1] for x in lines if x.startswith("|") and "| published" in x]
        cells = [cell.strip() for row in rows_ for cell in row if cell.strip()]
        printed = [r["published"] for r in rows if r["published"] is not None]
        assert Counter(cell.rstrip("†‡") for cell in cells) == Counter(map(significant, printed))
        assert sum("†" in cell for cell in cells) == sum(r["supported"] is False for r in rows)
