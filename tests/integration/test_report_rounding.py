"""Numbers as reports print them, against fractions and by the definitions: the nearest multiple, ties to even."""

import math
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import example, given, strategies as st

from tumble.report.source import exact, plain, product, rounded, significant, to_match, to_places

pytestmark = pytest.mark.python

finite = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e300, max_value=1e300)
positive = st.floats(min_value=1e-300, max_value=1e300)


def read(shown):
    """What is printed as a fraction, and the size of a unit of its last digit."""
    digits = Fraction(shown.digits) * Fraction(10) ** shown.power
    places = len(shown.digits.partition(".")[2])
    return digits, Fraction(10) ** (shown.power - places)


def require_nearest(shown, value):
    """By the definition of rounding half to even, in fractions."""
    found, unit = read(shown)
    off = abs(found - value)
    assert off <= unit / 2
    if off == unit / 2:
        assert found / unit % 2 == 0


def digits_of(shown):
    """Significant ones that are printed."""
    return len(shown.digits.lstrip("-").replace(".", "").lstrip("0"))


@given(finite)
@example(5e-324)
@example(0.1)
@example(-0.0)
def test_a_number_is_the_decimal_of_its_json(number):
    """To the digit: the fraction of its shortest decimal, which reads back as itself."""
    assert float(exact(number)) == number and Fraction(exact(number)) == Fraction(Decimal(repr(number)))


@given(finite, finite)
def test_products_are_exact(one, other):
    assert Fraction(product(exact(one), exact(other))) == Fraction(repr(one)) * Fraction(repr(other))


@given(positive, st.integers(1, 17))
@example(9.96, 2)
@example(99.5, 2)
@example(0.0995, 2)
@example(2.5, 1)
@example(3.5, 1)
def test_significant_digits(number, digits):
    value = exact(number)
    shown = rounded(value, digits)
    require_nearest(shown, Fraction(value))
    assert digits_of(shown) == digits
    assert Fraction(significant(value, digits)) == read(shown)[0]


@given(finite, positive)
@example(2.0086380016176704, 8.492286311046465e-05)
@example(0.0, 1.0)
@example(-0.00004, 0.0013)  # rounds to 0: without a sign
@example(261376.0, 1234.0)
@example(1.0, 9.96e-6)
@example(0.99996, 0.00012)
def test_a_value_ends_where_its_uncertainty_ends(value, uncertainty):
    shown, spread = to_match(exact(value), exact(uncertainty))
    assert digits_of(spread) == 2 and shown.power == spread.power
    require_nearest(spread, Fraction(exact(uncertainty)))
    unit = read(spread)[1]
    if abs(value) < unit * 10**16:  # else a value would need more digits than a double has
        assert read(shown)[1] == unit
    require_nearest(shown, Fraction(exact(value)))
    if float(Fraction(shown.digits)) == 0.0:
        assert not shown.digits.startswith("-")


@given(positive)
def test_two_digits_never_make_an_uncertainty_5_percent_smaller(uncertainty):
    """So EA-4/02 lets it be rounded to the nearest."""
    _, spread = to_match(Decimal(1), exact(uncertainty))
    assert read(spread)[0] > Fraction(95, 100) * Fraction(exact(uncertainty))


def test_ties_go_to_even():
    shown = [to_match(Decimal(value), Decimal("0.10"))[0].digits for value in ("1.005", "1.015", "-1.005", "-1.015")]
    assert shown == ["1.00", "1.02", "-1.00", "-1.02"]
    assert [to_match(Decimal(1), Decimal(u))[1].digits for u in ("0.125", "0.135", "0.995")] == ["0.12", "0.14", "1.0"]


def test_written_by_hand():
    """As a person writes them."""
    pairs = {
        ("2.0086380016", "0.00016644"): ("2.00864", "0.00017"),
        ("-0.0237444948", "0.0000969957"): ("-0.023744", "0.000097"),
        ("261376.4", "1234"): ("2.614e5", "0.012e5"),
        ("1.23456789e-12", "4.5e-14"): ("1.235e-12", "0.045e-12"),
        ("3", "12.345"): ("3", "12"),
        ("0", "0.0123"): ("0.000", "0.012"),
        ("0.12345678901234567", "0"): ("0.12345678901234567", "0"),
    }
    for (value, uncertainty), expected in pairs.items():
        assert tuple(one.text for one in to_match(Decimal(value), Decimal(uncertainty))) == expected


@given(finite)
def test_plain_numbers_lose_nothing(number):
    shown = plain(exact(number))
    assert read(shown)[0] == Fraction(exact(number)) and float(shown.text) == number
    assert not shown.digits.startswith("0.0000")
    assert math.copysign(1.0, float(shown.text)) > 0.0 or number < 0.0  # no -0


@given(finite, st.integers(0, 6))
def test_places(number, places):
    shown = to_places(exact(number), places)
    require_nearest(shown, Fraction(exact(number)))
    assert shown.power == 0 and len(shown.digits.partition(".")[2]) == places
