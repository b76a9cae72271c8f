"""Types of values, and what may stand in for what."""

from __future__ import annotations

import enum


class Type(enum.Enum):
    """Type of a value: a truth, a whole number of 32 bits, a real number, two to four real numbers."""

    BOOL = "bool"
    INT = "int"
    FLOAT = "float"
    VEC2 = "vec2"
    VEC3 = "vec3"
    VEC4 = "vec4"

    @property
    def n_components(self) -> int:
        """Number of numbers in it, 1 for a scalar."""
        return {Type.VEC2: 2, Type.VEC3: 3, Type.VEC4: 4}.get(self, 1)

    @property
    def is_vector(self) -> bool:
        """Whether it has components."""
        return self.n_components > 1

    @property
    def is_number(self) -> bool:
        """Whether arithmetic takes it as a scalar."""
        return self in (Type.INT, Type.FLOAT)


VECTORS = {2: Type.VEC2, 3: Type.VEC3, 4: Type.VEC4}


def fits(given: Type, wanted: Type) -> bool:
    """Whether a value of one type may stand where another is wanted: the same, or a whole number as a real one."""
    return given is wanted or (given is Type.INT and wanted is Type.FLOAT)


def joined(left: Type, right: Type) -> Type | None:
    """Return the type that both values can take without loss, None where there is none."""
    if fits(left, right):
        return right
    return left if fits(right, left) else None


def of_arithmetic(left: Type, right: Type) -> Type | None:
    """Return the type of left + right, - or * or /; None where GLSL has no such operation."""
    if Type.BOOL in (left, right):
        return None
    if left.is_vector and right.is_vector:
        return left if left is right else None
    if left.is_vector:
        return left
    return right if right.is_vector else joined(left, right)
