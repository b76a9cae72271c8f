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
    ("text", "dimension", "words"),
    [
        ("1e3 km", LENGTH, "has an exponent"), ("1E3km", LENGTH, "has an exponent"),
        ("1.5e-30 m^2", AREA, "has an exponent"), ("5 kmm", LENGTH, "'kmm' is not a unit; expected a length"),
        ("5 Km", LENGTH, "'Km' is not a unit"), ("5 au", LENGTH, "'au' is not a unit"),
        ("5 km^-1", LENGTH, "'km\\^-1' is not a unit; expected a length"),
        ("5 AU^2", AREA, "'AU\\^2' is not a unit; expected an area"),
        ("5 m", AREA, "'m' is a unit of length; expected an area"), ("5 m^2", LENGTH, "'m\\^2' is a unit of area"),
        ("5", LENGTH, "'5' has no unit"), ("", LENGTH, "the value is missing"), ("km", LENGTH, "is not a length"),
        ("5 k m", LENGTH, "is not a length"), ("1,5 km", LENGTH, "is not a length"),
        ("+5 km", LENGTH, "is not a length"), ("\u0665 km", LENGTH, "is not a length"),
        ("5\u00a0km", LENGTH, "is not a length"), ("1.2.3 km", LENGTH, "'1.2.3' is not a number"),
        (". km", LENGTH, "'.' is not a number"), ("9" * 101 + " km", LENGTH, "101 digits"),
        ("1" * 30_000 + " " * 30_000 + "!", LENGTH, "60001 characters"),
        ("9" * 60_000 + " km", LENGTH, "60003 characters"), ("1/3 km", LENGTH, "is not a length"),
        ("0x10 km", LENGTH, "is not a length"), ("1_000 km", LENGTH, "is not a length"),
    ],
)  # fmt: skip
def test_what_is_refused(text, dimension, words):
    with pytest.raises(BadValueError, match=words) as caught:
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
    with pytest.raises(BadValueError, match="60001 characters"):
        parse_real("1e" + "9" * 59_999)
    with pytest.raises(BadValueError):
        parse_decimal("1" * 10**6)


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_a_float_comes_back(value):
    assert parse_real(repr(value)) == value
