"""Numbers with units: exact factors, nothing but the table, and no way to keep the reader busy."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.formats.report import BadValueError
from aomc_sky.formats.units import AU_M, UNITS, Dimension, parse_decimal, parse_quantity, parse_real

LENGTH, AREA = Dimension

# typed again from the document of the format, with the powers of ten of the prefixes
LENGTHS = {"nm": -9, "um": -6, "mm": -3, "m": 0, "km": 3, "Mm": 6, "Gm": 9}
AREAS = {"am^2": -36, "fm^2": -30, "pm^2": -24, "nm^2": -18, "um^2": -12, "mm^2": -6, "cm^2": -4, "m^2": 0}
AREAS |= {"km^2": 6, "Mm^2": 12, "Gm^2": 18}


def test_the_table_is_that_of_the_document():
    ten = Fraction(10)
    assert UNITS[LENGTH] == {**{unit: ten**power for unit, power in LENGTHS.items()}, "AU": Fraction(149597870700)}
    assert UNITS[AREA] == {unit: ten**power for unit, power in AREAS.items()}
    assert AU_M == 149597870700


@pytest.mark.parametrize(
    ("text", "dimension", "wanted"),
    [
        ("120 km", LENGTH, 120_000.0), ("1.01208AU", LENGTH, 1.01208 * 149597870700),
        ("0.04022 fm^2", AREA, 4.022e-32), ("-5.   m", LENGTH, -5.0),
        ("007 nm", LENGTH, 7e-9), ("550 nm", LENGTH, 5.5e-7),
    ],
)  # fmt: skip
def test_a_quantity_is_rounded_once(text, dimension, wanted):
    assert float(parse_quantity(text, dimension)) == wanted


@given(number=st.decimals(allow_nan=False, allow_infinity=False, min_value=0, max_value=10**9, places=12))
def test_micrometres_and_nanometres_agree(number):
    assert parse_quantity(f"{number:f} um", LENGTH) == 1000 * parse_quantity(f"{number:f} nm", LENGTH)


@pytest.mark.parametrize(
    "text",
    [
        "1e3 km", "1E3km", "5 kmm", "5 Km", "5 au", "5 km^-1", "5 m^2", "5", "", "km", "5 k m", "1,5 km", "+5 km",
        "\u0665 km", "5\u00a0km", "1.2.3 km", ". km", "9" * 101 + " km", "1" * 30_000 + " " * 30_000 + "!",
        "9" * 60_000 + " km", "1/3 km", "0x10 km", "1_000 km",
    ],
)  # fmt: skip
def test_what_is_no_length_is_refused(text):
    check_refused(text, LENGTH)


@pytest.mark.parametrize("text", ["1.5e-30 m^2", "5 AU^2", "5 m"])
def test_what_is_no_area_is_refused(text):
    check_refused(text, AREA)


def check_refused(text, dimension):
    """By a short message, at a place inside the text."""
    with pytest.raises(BadValueError) as caught:
        parse_quantity(text, dimension)
    assert caught.value.code == "E401"
    assert 0 <= caught.value.offset <= len(text)
    assert len(caught.value.message) < 100


@pytest.mark.parametrize(
    "text", ["", ".", "e5", "1e", "nan", "inf", "0x1p3", "1d5", "1 2", "1_0", "\u0663", "--1", "1e5.5"]
)
def test_what_is_no_number(text):
    with pytest.raises(BadValueError):
        parse_real(text)


def test_huge_numbers_are_answered_at_once():
    assert parse_real("1e999999") == float("inf")
    assert parse_real("-1e" + "9" * 90) == -float("inf")
    assert parse_real("1e-999999") == 0.0
    for read, text in ((parse_real, "1e" + "9" * 59_999), (parse_decimal, "1" * 10**6)):
        with pytest.raises(BadValueError):
            read(text)


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_a_float_comes_back(value):
    assert parse_real(repr(value)) == value
