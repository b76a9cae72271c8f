"""A sum of any number of floats, held exactly in bounded memory."""

from __future__ import annotations

import math

_MOST_TERMS = 4096


class ExactSum:
    """A sum that no order or grouping of its terms changes.

    Terms are kept as they are until they are many. Then they become an expansion: the sum rounded to nearest, what is
    left of it rounded, and so on to zero, at most forty numbers, whose sum is that of the terms without any error.
    A term that is not finite, and a sum beyond the range of floats, make it infinite.
    """

    __slots__ = ("_terms",)

    def __init__(self) -> None:
        self._terms: list[float] = []

    def add(self, term: float) -> None:
        """Add a number."""
        self._terms.append(term)
        if len(self._terms) > _MOST_TERMS:
            self._terms = _expansion(self._terms)

    def add_sum(self, other: ExactSum) -> None:
        """Add another sum."""
        for term in other._terms:
            self.add(term)

    @property
    def value(self) -> float:
        """The sum, correctly rounded."""
        return _rounded(self._terms)


def _rounded(terms: list[float]) -> float:
    try:
        return math.fsum(terms) if all(map(math.isfinite, terms)) else math.inf
    except OverflowError:
        return math.inf


def _expansion(terms: list[float]) -> list[float]:
    parts: list[float] = []
    while part := _rounded(terms):
        parts.append(part)
        if math.isinf(part):
            return [part]
        terms = [*terms, -part]
    return parts
