"""Random code blocks: the same bits as Python's own arithmetic, and never a traceback for any text."""

import math
import operator
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.errors import InputFileError
from tests.support.blocks import FIRST_LINE, GIVEN, at, density_block

MAX_INT = 2**31 - 1


class RefusedError(Exception):
    """Python's side of what GLSL leaves open."""


@dataclass(frozen=True)
class Term:
    """An expression as text and as a function of one altitude."""

    text: str
    law: object


def defined(law):
    """Python's operator in float64, where it gives a number."""

    def law_of(left, right):
        with np.errstate(all="ignore"):
            result = float(law(np.float64(left), np.float64(right)))
        if math.isnan(result):
            raise RefusedError
        return result

    return law_of


def whole(value):
    if abs(value) > MAX_INT:
        raise RefusedError
    return value


def whole_quotient(left, right):
    if right == 0:
        raise RefusedError
    return whole(int(math.copysign(1, left) * math.copysign(1, right)) * (abs(left) // abs(right)))


def root(value):
    if value < 0.0:
        raise RefusedError
    return math.sqrt(value)


INT_LAWS = {
    "+": lambda a, b: whole(a + b),
    "-": lambda a, b: whole(a - b),
    "*": lambda a, b: whole(a * b),
    "/": whole_quotient,
}
FLOAT_LAWS = {
    "+": defined(operator.add),
    "-": defined(operator.sub),
    "*": defined(operator.mul),
    "/": defined(operator.truediv),
}
COMPARED = {
    "<": operator.lt, ">": operator.gt, "<=": operator.le, ">=": operator.ge, "==": operator.eq, "!=": operator.ne
}  # fmt: skip


def joined(laws, sign, left, right):
    return Term(f"({left.text} {sign} {right.text})", lambda h: laws[sign](left.law(h), right.law(h)))


def negated(one):
    return Term(f"(-{one.text})", lambda h: -one.law(h))


def applied(function, *terms):
    name, law = function
    return Term(f"{name}({', '.join(t.text for t in terms)})", lambda h: law(*(t.law(h) for t in terms)))


def chosen(condition, yes, no):
    return Term(f"({condition.text} ? {yes.text} : {no.text})", lambda h: yes.law(h) if condition.law(h) else no.law(h))


def logic(sign, left, right):
    if sign == "&&":
        return Term(f"({left.text} && {right.text})", lambda h: left.law(h) and right.law(h))
    return Term(f"({left.text} || {right.text})", lambda h: left.law(h) or right.law(h))


FOUR = st.sampled_from("+-*/")
DEPTH = 4


def ints_of(depth):
    numbers = st.integers(0, 50).map(lambda k: Term(str(k), lambda h: k))
    plain = numbers | st.just(Term("wlSetIndex", lambda h: 1))
    if not depth:
        return plain
    inner = ints_of(depth - 1)
    return st.one_of(
        plain,
        st.builds(joined, st.just(INT_LAWS), FOUR, inner, inner),
        st.builds(negated, inner),
        st.builds(chosen, bools_of(depth - 1), inner, inner),
    )


def floats_of(depth):
    numbers = st.floats(0, 1e3, allow_nan=False, allow_subnormal=False)
    plain = st.one_of(
        st.just(Term("altitude", lambda h: h)),
        numbers.map(lambda x: Term(repr(x), lambda h: x)),
        st.builds(applied, st.just(("float", float)), ints_of(0)),
    )
    if not depth:
        return plain
    inner, whole_numbers = floats_of(depth - 1), ints_of(depth - 1)
    return st.one_of(
        plain,
        st.builds(joined, st.just(FLOAT_LAWS), FOUR, inner, inner),
        st.builds(joined, st.just(FLOAT_LAWS), FOUR, inner, whole_numbers),
        st.builds(joined, st.just(FLOAT_LAWS), FOUR, whole_numbers, inner),
        st.builds(negated, inner),
        st.builds(applied, st.sampled_from([("sqrt", root), ("abs", abs), ("floor", np.floor)]), inner),
        st.builds(applied, st.sampled_from([("min", min), ("max", max)]), inner, inner),
        st.builds(chosen, bools_of(depth - 1), inner, inner),
    )


def bools_of(depth):
    plain = st.builds(joined, st.just(COMPARED), st.sampled_from(sorted(COMPARED)), floats_of(0), floats_of(0))
    if not depth:
        return plain
    inner, whole_numbers = bools_of(depth - 1), ints_of(depth - 1)
    return st.one_of(
        plain,
        st.builds(joined, st.just(COMPARED), st.sampled_from(sorted(COMPARED)), whole_numbers, whole_numbers),
        st.builds(logic, st.sampled_from(["&&", "||"]), inner, inner),
        inner.map(lambda one: Term(f"(!{one.text})", lambda h: not one.law(h))),
    )


ints, floats, bools = ints_of(DEPTH), floats_of(DEPTH), bools_of(DEPTH)


def agree(text, term, altitudes):
    """One altitude at which a term has no value makes the block refuse."""
    try:
        wanted = [float(term.law(h)) for h in altitudes]
    except RefusedError:
        with pytest.raises(InputFileError):
            at(text, *altitudes)
    else:
        np.testing.assert_array_equal(at(text, *altitudes), wanted, err_msg=text)


LANES = st.lists(st.floats(0, 1e5, allow_nan=False), min_size=1, max_size=5)


@given(floats, LANES)
def test_an_expression_has_the_bits_of_python(term, altitudes):
    agree(f"return {term.text};", term, altitudes)


@given(bools, floats, floats, LANES)
def test_a_branch_has_the_bits_of_python(condition, yes, no, altitudes):
    from_zero = Term("", lambda h: 0.0 + no.law(h))
    text = f"float x = 0; if({condition.text}) x = {yes.text}; else {{ x += {no.text}; }} return x;"
    agree(text, chosen(condition, yes, from_zero), altitudes)
    agree(f"if({condition.text}) return {yes.text}; return {no.text};", chosen(condition, yes, no), altitudes)


_WORDS = """
float int vec4 vec2 bool const CONST if else for while return break continue true altitude km wavelengths x y i exp pow
min mix dot 0 1 2 1.5 3. 1e5 + - * / % < > <= == != ! && || ? : = += *= ++ ( ) { } [ ] ; ; ; , . .x .xyzw [0] # " ` //
/* */ struct double 10km 1e999"""
WORDS = [*_WORDS.split(), "\n", "\0", "\u00e9"]


@given(st.lists(st.sampled_from(WORDS), max_size=60))
def test_any_text_is_a_block_or_an_error_of_its_file(words):
    for text in (" ".join(words), "".join(words), f"float x = 1, y; int i; return {' '.join(words)};"):
        problems = ()
        try:
            assert density_block(text)(np.array([0.0, 1.0, 2e4]), GIVEN).shape == (3,)
        except InputFileError as error:
            problems = error.problems
        assert all(one.code == "E403" and one.line >= FIRST_LINE and one.column >= 1 for one in problems)
