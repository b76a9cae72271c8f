"""Types of values, and the state of one run over many lanes (altitudes or cosines).

A value is a float64 or bool array. Its last axis is the lane, and a length of 1 means all lanes; the first axis of a
vector is the component. Whole numbers are float64 too. They have 32 bits in GLSL: a result beyond them is refused,
never wrapped. A result that GLSL leaves open is NaN, and refused too.

Each lane follows its own branches, by masks. A statement changes only the lanes that reach it. A division by zero in
another branch is not an error.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.skies.atmosphere.language.lexer import MAX_INT, RefusalError, Span

Array = np.ndarray


class Type(enum.Enum):
    """Type of a value: a truth, a whole number of 32 bits, a real number, two to four real numbers."""

    BOOL = "bool"
    INT = "int"
    FLOAT = "float"
    VEC2 = "vec2"
    VEC3 = "vec3"
    VEC4 = "vec4"

    @property
    def size(self) -> int:
        """Number of numbers in it, 1 for a scalar."""
        return int(self.value[3:]) if self.value.startswith("vec") else 1

    @property
    def is_vector(self) -> bool:
        """Whether it has components."""
        return self.size > 1

    @property
    def named(self) -> str:
        """The type with its article."""
        return f"an {self.value}" if self is Type.INT else f"a {self.value}"

    def joined(self, other: Type) -> Type | None:
        """The type that both can take without loss, or None; a whole number may replace a real one."""
        if self is other:
            return self
        return Type.FLOAT if {self, other} == {Type.INT, Type.FLOAT} else None


@dataclass(frozen=True, slots=True)
class Function:
    """One operation on values of known types."""

    name: str  #: as a user writes it
    law: Callable[..., Any]
    #: numbers that change where the law goes over to another branch: between lanes of equal numbers it is smooth
    decides: Callable[..., Any] | None = None


_HASH = np.uint64(0x9E3779B97F4A7C15)
_STEP = np.uint64(0xD1B54A32D192ED03)
_SHIFT = np.uint64(29)


@dataclass(kw_only=True, slots=True)
class Run:
    """The state of one run."""

    values: list[Array]  #: of the variables
    result: Array  #: of the block, in the lanes that have returned
    where: Callable[[int], str]  #: says in words which altitude or cosine a lane is
    trace: Array | None  #: (n,) uint64 hashes of all decisions of a lane, if they are asked for

    def apply(self, span: Span, kind: Type, function: Function, values: Sequence[Array], mask: Array) -> Array:
        """Apply a function to values, for a result of some type; `mask` are the lanes that count."""
        if self.trace is not None and function.decides is not None:
            self.trace = _noted(self.trace, function.decides(*values), mask)
        result: Array = function.law(*values)
        if kind is Type.INT:
            result = result + 0.0  # whole numbers have no -0
            bad = ~(np.abs(result) <= MAX_INT)
        else:
            bad = np.isnan(result)
        if bad.any() and (lanes := mask & (bad.any(axis=0) if bad.ndim > 1 else bad)).any():
            lane = int(np.argmax(lanes))
            shown = [_shown(value[..., min(lane, value.shape[-1] - 1)]) for value in values]
            is_call = function.name.isalnum() or len(shown) == 1
            text = f"{function.name}({', '.join(shown)})" if is_call else f" {function.name} ".join(shown)
            words = f"is no int up to {MAX_INT}" if kind is Type.INT else "has no defined value"
            raise RefusalError(span, f"{text} {words}, {self.where(lane)}", "take another value there, by if or ?:")
        return result

    def store(self, slot: int, components: tuple[int, ...] | None, value: Array, mask: Array) -> None:
        """Put a value into a variable, or into some of its components."""
        if components is None and mask.all():
            self.values[slot] = value
            return
        # variables may hold one value for all lanes, and share it: copies of full width are written
        old = self.values[slot]
        wide = np.array(np.broadcast_to(old, (*old.shape[:-1], mask.size)))
        part = slice(None) if components is None else list(components)
        wide[part] = np.where(mask, value, wide[part])
        self.values[slot] = wide


def _shown(value: Array) -> str:
    return f"{value:.12g}" if value.ndim == 0 else f"vec{value.size}({', '.join(f'{one:.12g}' for one in value)})"


def _noted(trace: Array, decision: Array, mask: Array) -> Array:
    for row in decision if decision.ndim > 1 else decision[None]:
        # a floor beyond the whole numbers of 64 bits has no branches that anybody could resolve
        whole = np.clip(np.nan_to_num(row.astype(np.float64)), -(2.0**62), 2.0**62).astype(np.int64)
        # the sum before the product: no decision leaves a trace as it is
        mixed = ((trace ^ whole.view(np.uint64)) + _STEP) * _HASH
        trace = np.where(mask, mixed ^ (mixed >> _SHIFT), trace)
    return trace
