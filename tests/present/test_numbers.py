"""How numbers, durations, lengths and shares are written."""

from __future__ import annotations

import math

import pytest

from mocap_metrology.present.text import numbers


@pytest.mark.parametrize(
    ("write", "texts"),
    [
        (numbers.three_digits, {None: "", 0.2246: "0.225", 2000: "2000", 9.256e-7: "9.26e-07"}),
        (numbers.three_digits, {9994.0: "9990", 9999.5: "1.00e+04", 9.9951e-4: "0.00100"}),
        (numbers.three_fixed, {0.026: "0.0260", 693.2: "693", 26_000: "26000", 0.0: "0"}),
        (numbers.three, {0.2: "0.2", 2020.0: "2020", 1e-5: "1e-05"}),
        (numbers.two, {0.123: "0.12", 1234.0: "1200"}),
        (numbers.typeset, {9.26e-7: "9.26×10⁻⁷", 12.0: "12.0"}),
        (numbers.power_of_ten, {-12: "10⁻¹²"}),
        (numbers.tick_text, {-0.5: "−0.5", 1e6: "1000000"}),
        (numbers.number, {13195.2: "13\N{NARROW NO-BREAK SPACE}195", -5: "−5"}),
        (numbers.duration_words, {3600: "an hour", 7200: "2 h", 600: "10 min", 5.2: "5.2 s"}),
        (numbers.duration_text, {32400: "nine hours"}),
        (numbers.minutes_words, {90: "90 s", 1080: "18 minutes", 9000: "2.5 h"}),
        (numbers.time_words, {150.24: "150.2 s", 9012: "2:30:12.0"}),
        (numbers.moment, {98.5: "98.5 s", 298.5: "4 min 58.5 s", 16198.5: "4 h 29 min 58.5 s"}),
        (numbers.length, {2.0512: "2.05 mm", 1500: "1.5 m"}),
        (numbers.mm, {0.0512: "51.2 µm", 2.0: "2 mm", math.nan: "an unknown length"}),
        (numbers.speed, {360: "+360 mm/h", -928_000: "-928 m/h"}),
        (numbers.percent, {0.0312: "3.12 %", 1e-6: "less than 0.001 %"}),
        (numbers.signed, {-0.021: "-2.1 %"}),
    ],
)
def test_a_number_is_written(write, texts):
    assert {value: write(value) for value in texts} == texts


def test_ends_of_a_span_that_read_alike_are_said_once():
    assert numbers.span([0.05, 0.03], numbers.percent) == "3 % to 5 %"
    assert numbers.span([0.03, 0.0300001], numbers.percent) == "3 %"
