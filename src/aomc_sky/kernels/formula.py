"""One text of a formula for both backends: numpy calls it with arrays, kernels compile it for one photon.

A file of formulas lists them in one call of `formulas`; kernels compile these texts as they stand. They are written
with + - x / sqrt, whole numbers and the functions below, which have a form in numpy, here, and one for the compiler, in
`jit`. This file does not load numba.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Compile = Callable[[Callable[..., Any], bool], None]

_texts: list[tuple[Callable[..., Any], bool]] = []
_compilers: list[Compile] = []


def formulas(*texts: Callable[..., Any], is_inlined: bool = False) -> None:
    """Let kernels call formulas for arrays, too.

    The compiler decides where to inline them, unless `is_inlined`. That is for straight texts in a loop, which
    vectorises only if they are inlined.
    """
    for text in texts:
        _texts.append((text, is_inlined))
        for take in _compilers:
            take(text, is_inlined)


def listed() -> tuple[Callable[..., Any], ...]:
    """The formulas of the modules that are loaded."""
    return tuple(text for text, _ in _texts)


def compile_formulas(take: Compile) -> None:
    """Hand every formula, and those that will be listed, to a compiler."""
    _compilers.append(take)
    for text, is_inlined in _texts:
        take(text, is_inlined)


def by_width(short: Callable[..., Any], long: Callable[..., Any], of: int = -1) -> Callable[..., Any]:
    """A formula with a text for 32 bits and one for 64: an argument, the last one or number `of`, decides."""

    def chosen(*arguments: Any) -> Any:
        return (short if arguments[of].dtype.itemsize == 4 else long)(*arguments)

    chosen.texts = (short, long, of)  # type: ignore[attr-defined]
    formulas(chosen)
    return chosen


def kind_of(x: Any) -> Any:
    """The type that makes a number of the precision of x."""
    return x.dtype.type


def select(condition: Any, a: Any, b: Any) -> Any:
    """Return a where the condition holds, else b; both have been worked out."""
    return np.where(condition, a, b)[()]


def smaller(a: Any, b: Any) -> Any:
    """The smaller of two numbers."""
    return np.minimum(a, b)


def larger(a: Any, b: Any) -> Any:
    """The larger of two numbers."""
    return np.maximum(a, b)


def nested(coefficients: tuple[float, ...], t: Any) -> Any:
    """A polynomial in t by Horner's rule, the highest power first."""
    value = coefficients[0] * t
    value += coefficients[1]
    for coefficient in coefficients[2:]:
        value *= t
        value += coefficient
    return value


def word_of(x: Any) -> Any:
    """The bits of a float64, as an int64."""
    return x.view(np.int64)


def float_of(word: Any) -> Any:
    """The float64 that has the bits of an int64."""
    return word.view(np.float64)
