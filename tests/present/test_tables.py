"""Numbers, sizes and durations as people read them, and tables of them."""

import math
import random

import numpy as np
import pytest

from mocap_metrology.noise.assess.allan_summary import allan_summary
from mocap_metrology.present import tables
from mocap_metrology.present.text import captions, coefficients, numbers
from mocap_metrology.present.text.numbers import with_interval, with_uncertainty, with_unit

PLAIN = str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")


@pytest.mark.parametrize(
    ("write", "texts"),
    [
        (numbers.significant, {None: "", math.nan: "", 0.2246: "0.225", 2000: "2000", 0.0: "0",
         9994.0: "9990", 9999.5: "10000", 9.9951e-4: "0.00100", 0.0009994: "9.99×10⁻⁴",
         99999.0: "100000", 2.64e-309: "2.64×10⁻³⁰⁹", -0.5: "−0.500", math.inf: "inf",
         9.256e-7: "9.26×10⁻⁷", -5e-5: "−5.00×10⁻⁵", 999_999: "1.00×10⁶", 999_499: "999000"}),
        (numbers.power_of_ten, {-12: "10⁻¹²", 30: "10³⁰"}),
        (numbers.number, {13195.2: f"13{numbers.THIN_SPACE}195", -5: "−5"}),
        (numbers.duration_words, {3600: "an hour", 3617: "an hour", 3619: "60.3 min",
         7200: "2 h", 600: "10 min", 5.2: "5.2 s", 32400: "nine hours", 90: "90 s", 119: "119 s",
         120: "2 min", 1080: "18 min", 5399: "90 min", 9000: "2.5 h", 1 / 120: "8.33 ms"}),
        (numbers.moment, {98.5: "98.5 s", 179.94: "179.9 s", 180: "3 min", 298.5: "4 min 58.5 s",
         3600: "1 h 0 min", 16198.5: "4 h 29 min 58.5 s"}),
        (numbers.mm, {2.0512: "2.05 mm", 1500: "1.5 m", 0.0512: "51.2 µm", math.nan: "unknown",
         99.96: "100 mm", 0.09996: "0.1 mm", 999.9: "1 m", 6.1e-5: "61 nm", 0: "0 mm",
         -8.4e-12: "0 mm"}),
        (numbers.percent, {0.0312: "3.12 %", 9e-6: "less than 0.001 %", 1e-5: "0.001 %", 1: "100 %",
         2e4: f"2{numbers.THIN_SPACE}000{numbers.THIN_SPACE}000 %"}),
        (numbers.at_most, {0.0312: "at most 3.12 %", 1e-6: "less than 0.001 %"}),
        (coefficients.symbol, {"h_-2": "h₋₂", "q_c3": "q_c", "f_0": "f₀"}),
        (coefficients.mathtext, {"h_-2": "$h_{-2}$", "q_c3": "$q_{c}$"}),
        (coefficients.unit, {"h_1": "mm²/Hz²", "q_c2": "mm/√s"}),
    ],
)  # fmt: skip
def test_a_number_is_written(write, texts):
    assert {value: write(value) for value in texts} == texts


@pytest.mark.parametrize(
    ("write", "texts"),
    [
        (with_unit, {(0.0369, "Hz"): "0.0369 Hz", (2500.0, "Hz"): "2.5 kHz", (0.25, "°"): "0.25°",
         (8.4e-12, "°"): "0°", (360, "mm/h", 3, True): "+360 mm/h",
         (-928_000, "mm/h", 3, True): "−928 m/h", (8.4e-12, "mm/h", 3, True): "0 mm/h"}),
        # GUM 7.2.6: two digits of the uncertainty; one unit, not nHz beside Hz
        (with_uncertainty, {(14.4, 7.1e-7, "Hz"): "14.40000000 ± 0.00000071 Hz",
         (0.0369, 0.00012, "Hz"): "0.03690 ± 0.00012 Hz", (3.0, 50.0, "Hz"): "3 ± 50 Hz",
         (1234.5, 56.0, "Hz"): "1.234 ± 0.056 kHz", (3.0, 0.0996, "Hz"): "3.00 ± 0.10 Hz",
         (0.0369, math.nan, "Hz"): "0.0369 Hz", (0.0369, 0.0): "0.0369",
         (9.256e-7, 1.0e-9): "(9.256 ± 0.010)×10⁻⁷"}),
        (with_interval, {(9.256e-7, 9.246e-7, 9.266e-7): "9.256 (9.246…9.266)×10⁻⁷",
         (9.26e-7, 9.259e-7, 9.261e-7): "9.2600 (9.2590…9.2610)×10⁻⁷",
         (0.026, 0.0255, 0.02641, "mm"): "26.00 (25.50…26.41) µm",
         (0.0443, 0.021, 0.092): "0.044 (0.021…0.092)", (2.0, 2.0, 2.0): "2.00",
         (1e-9, 0.0, 4e-5): "1.0 (0.0…40000)×10⁻⁹", (0.0, -0.5, 0.5): "0.00 (−0.50…0.50)",
         (2020.0, 1990.0, 2050.0): "2020 (1990…2050)", (2.0, None, 3.0): "2.00",
         (0.225, math.nan, 0.5): "0.225", (2.0, -math.inf, math.inf, "mm"): "2 mm",
         (None, 1.0, 2.0): "", (math.nan, 1.0, 2.0): ""}),
        # Four decimals may be too few; `tau_p_s` is no probability; a slope published as 0
        (tables.readable, {(1 / 120,): "0.0083333", (160.58,): "160.58", (123456.7,): "123460",
         (0.00012344,): "0.000123", (1.88359e-5,): "1.88×10⁻⁵", (2e6,): "2000000", (0.0,): "0",
         (-math.inf,): "-inf", (math.nan,): "", (166.6, "mu_1_mm"): "166.6000",
         (0.0005, "sigma_1_mm"): "0.0005", (0.00012344, "sigma_C_mm"): "0.000123",
         (0.192, "rho_12"): "0.1920", (5.196016e-28, "chi2_p"): "< 10⁻⁶", (0.8628132, "p"): "0.863",
         (1e-7, "tau_p_s"): "1.00×10⁻⁷", (-1.1e-14, "deviation_percent"): "0",
         (-13.0417, "deviation_percent"): "-13", (278.152, "allowed_percent"): "278",
         (2.975985e-18, "regenerated", 0.0): "0",
         (6.600157, "regenerated", 2 * math.pi**2 / 3): "6.600157"}),
    ],
)  # fmt: skip
def test_a_number_is_written_with_its_unit_error_or_column(write, texts) -> None:
    assert {given: write(*given) for given in texts} == texts


def test_what_is_written_reads_back() -> None:
    """Within half of the last digit, over twenty decades; an interval to digits of its width."""
    pick = random.Random(4)
    for _ in range(2000):
        value = pick.choice((-1, 1)) * 10 ** pick.uniform(-12, 8)
        text = numbers.significant(value).translate(PLAIN).replace("×10", "e")
        assert float(text) == pytest.approx(value, rel=5.01e-3)
        half = abs(value) * 10 ** pick.uniform(-4, 0)
        text = with_interval(value, value - half, value + half).translate(PLAIN)
        body, _, power = text.partition("×10")
        parts = [float(p) for p in body.replace(" (", "…").rstrip(")").split("…")]
        scale = 10.0 ** int(power or 0)
        for part, known in zip(parts, (value, value - half, value + half), strict=True):
            assert abs(part * scale - known) <= 0.051 * half or abs(part) >= 1e4


def test_a_series_without_a_value_has_an_empty_row() -> None:
    names = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
    columns = {name: np.array([0.1, 0.2]) for name in names} | {"edf": np.array([20.0, 10.0])}
    columns |= {k: np.array([v, v], object) for k, v in (("series", "x1"), ("estimator", "oadev"))}
    first, second = allan_summary("r", "measured", columns, ["x1", "L"])
    assert list(first) == list(second)
    assert (first["adev_min_mm"], first["tau_min_s"]) == (0.1, 0.1)
    assert second["series"] == "L" and second["adev_min_mm"] is None


@pytest.mark.parametrize(
    ("sources", "duration_s", "text"),
    [
        ("t", 600.0, "All recordings are twins of 10 min (S: nine hours): simulated, from published"
         " or configured numbers."),
        ("tm", 20, "Simulated (twins of 20 s (S: nine hours)): a; the others are measured."),
        ("m", 20.0, "All recordings are measured."),
    ],
)  # fmt: skip
def test_the_length_of_twins_stands_where_they_are_named(sources, duration_s, text) -> None:
    kinds = {"t": "twin", "m": "measured"}
    named = {name: kinds[kind] for name, kind in zip("ab", sources, strict=False)}
    assert tables.source_sentence(named, duration_s) == text


def test_captions_of_several_figures_follow_one_another() -> None:
    """Each with its number, a number also as text."""
    both = captions.of_figures("skurowski", 1, "A1")
    assert both == captions.of_figures("skurowski", "1", "A1")
    assert both.startswith("Figure 1: Computed from the numbers")
    assert " Figure A1: Overlapping Allan deviation of z1" in both
    of_one = captions.of_figure("jansen", 5)
    assert captions.of_figures("jansen", 5) == f"Figure 5: {of_one.caption}"
    with pytest.raises(AttributeError, match="NO_SUCH"):
        _ = captions.NO_SUCH
