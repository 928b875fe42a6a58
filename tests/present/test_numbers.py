"""How numbers, durations, sizes and shares are written."""

from __future__ import annotations

import math

import pytest

from mocap_metrology.present.text import numbers
from mocap_metrology.present.text.numbers import with_interval, with_uncertainty, with_unit

THIN = numbers.THIN_SPACE


@pytest.mark.parametrize(
    ("write", "texts"),
    [
        (numbers.significant, {None: "", math.nan: "", 0.2246: "0.225", 2000: "2000", 0.0: "0"}),
        (numbers.significant, {9994.0: "9990", 9999.5: "10000", 9.9951e-4: "0.00100"}),
        (numbers.significant, {9.256e-7: "9.26×10⁻⁷", -5e-5: "−5.00×10⁻⁵", 999_999: "1.00×10⁶"}),
        (numbers.power_of_ten, {-12: "10⁻¹²"}),
        (numbers.number, {13195.2: f"13{THIN}195", -5: "−5"}),
        (numbers.duration_words, {3600: "an hour", 7200: "2 h", 600: "10 min", 5.2: "5.2 s"}),
        (numbers.duration_words, {32400: "nine hours", 90: "90 s", 1080: "18 min", 9000: "2.5 h"}),
        (numbers.duration_words, {100: "100 s", 1 / 120: "8.33 ms"}),
        (numbers.moment, {98.5: "98.5 s", 298.5: "4 min 58.5 s", 16198.5: "4 h 29 min 58.5 s"}),
        (numbers.mm, {2.0512: "2.05 mm", 1500: "1.5 m", 0.0512: "51.2 µm", math.nan: "unknown"}),
        (
            numbers.mm,
            {99.96: "100 mm", 0.09996: "0.1 mm", 999.9: "1 m", 6.1e-5: "61 nm", 0: "0 mm"},
        ),
        (numbers.percent, {0.0312: "3.12 %", 1e-6: "less than 0.001 %", 1.0: "100 %"}),
    ],
)
def test_a_number_is_written(write, texts):
    assert {value: write(value) for value in texts} == texts


def test_units_have_prefixes_and_no_powers_of_ten():
    assert with_unit(0.0369, "Hz") == "0.0369 Hz"
    assert with_unit(2500.0, "Hz") == "2.5 kHz"
    assert with_unit(100.0, "s") == "100 s"
    assert with_unit(0.25, "°") == "0.25°"
    assert with_unit(360, "mm/h", sign=True) == "+360 mm/h"
    assert with_unit(-928_000, "mm/h", sign=True) == "−928 m/h"
    assert numbers.percent(-0.021, 2, sign=True) == "−2.1 %"
    assert numbers.percent(0.021, 2, sign=True) == "+2.1 %"


@pytest.mark.parametrize("unit, text", [("mm", "0 mm"), ("mm/h", "0 mm/h"), ("°", "0°")])
def test_errors_of_arithmetic_are_nothing(unit: str, text: str) -> None:
    assert with_unit(8.4e-12, unit) == with_unit(-8.4e-12, unit) == text


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (14.4, 7.1e-7, "14.40000000 ± 0.00000071 Hz"),  # one unit, not nHz beside Hz
        (0.0369, 0.00012, "0.03690 ± 0.00012 Hz"),
        (1234.5, 56.0, "1.234 ± 0.056 kHz"),
        (3.0, 50.0, "3 ± 50 Hz"),
        (3.0, 0.096, "3.000 ± 0.096 Hz"),
        (3.0, 0.0996, "3.00 ± 0.10 Hz"),
        (0.0369, math.nan, "0.0369 Hz"),
    ],
)
def test_two_digits_of_an_uncertainty_and_the_value_to_the_same_place(value, sigma, text):
    """The rule of GUM 7.2.6, for frequencies."""
    assert with_uncertainty(value, sigma, "Hz") == text


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ((9.256e-7, 9.246e-7, 9.266e-7), "9.256 (9.246…9.266)×10⁻⁷"),
        ((0.026, 0.0255, 0.02641, "mm"), "26.00 (25.50…26.41) µm"),
        ((0.0443, 0.021, 0.092), "0.044 (0.021…0.092)"),
        ((2020.0, 1990.0, 2050.0), "2020 (1990…2050)"),
        ((0.0, -0.5, 0.5), "0.00 (−0.50…0.50)"),
        ((2.0, 2.0, 2.0), "2.00"),
        ((2.0, None, 3.0), "2.00"),
        ((2.0, -math.inf, math.inf, "mm"), "2 mm"),
        ((None, 1.0, 2.0), ""),
    ],
)
def test_a_value_and_its_interval_end_at_the_same_place(given, text):
    assert with_interval(*given) == text


def test_a_power_of_ten_stands_once_beside_an_uncertainty():
    assert with_uncertainty(9.256e-7, 1.0e-9) == "(9.256 ± 0.010)×10⁻⁷"


def test_ends_of_a_span_that_read_alike_are_said_once():
    assert numbers.span([0.05, 0.03], numbers.percent) == "3 % to 5 %"
    assert numbers.span([0.03, 0.0300001], numbers.percent) == "3 %"
