"""Directions through an MCPL file: the stated errors, for any unit vector and both precisions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from aomc_sky.emission.kernels.batches import plain
from tests.support.mcpl import unpacked

UNIT = {np.float32: 3e-7, np.float64: 6e-16}
"""How far from 1 the length of a photon's vector may be."""
ERROR = {np.float32: 6e-7, np.float64: 1.4e-15}
"""How far a component may move; as docs/formats/mcpl.md says."""

components = st.floats(-1, 1, allow_subnormal=True)


def packed(directions: np.ndarray) -> np.ndarray:
    n, dtype = len(directions), directions.dtype
    out = np.empty((n, 3), dtype)
    flags = np.empty(n, np.uint32)
    columns = [np.ascontiguousarray(c) for c in directions.T]
    plain.pack(*columns, np.zeros(n, np.int32), dtype.type(2.5e-6), np.uint32(0), 1, *out.T, flags)
    return out


def unit_vectors(rows: list[tuple[float, float, float]], dtype: type) -> np.ndarray:
    vectors = np.array(rows, np.float64)
    scale = np.abs(vectors).max(axis=1, keepdims=True)
    vectors = np.where(scale == 0, [0.0, 0.0, -1.0], vectors / np.where(scale == 0, 1, scale))
    return (vectors / np.sqrt((vectors**2).sum(axis=1, keepdims=True))).astype(dtype)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@settings(max_examples=100, deadline=None)
@given(rows=st.lists(st.tuples(components, components, components), min_size=1, max_size=20), stretch=components)
@example(
    stretch=1.0, rows=[(1.0, 1.0, 1.0), (1.0, 1.0, 0.0), (0.0, -1.0, 5e-324), (-1.0, 0.0, -0.0), (1e-20, 1.0, -1e-20)]
)
def test_directions_come_back_within_the_stated_error(dtype, rows, stretch):
    room = UNIT[dtype] - 2 * np.finfo(dtype).eps  # the rest is for rounding
    directions = (unit_vectors(rows, np.float64) * (1 + stretch * room)).astype(dtype)
    wide = directions.astype(np.float64)
    assert (np.abs(np.sqrt((wide**2).sum(axis=1)) - 1) <= UNIT[dtype]).all()
    energy, back = unpacked(packed(directions))
    assert (energy == dtype(2.5e-6)).all()
    assert (np.abs(back - wide) <= ERROR[dtype]).all()
    assert (np.abs((back**2).sum(axis=1) - 1) < 1e-15).all()
    # what is not the largest component is stored as it is, or as its inverse
    kept = np.sort(np.abs(wide), axis=1)[:, :2]
    tolerance = kept * (2**-23 if dtype is np.float32 else 2**-51) + np.finfo(dtype).tiny
    assert (
        np.abs(np.sort(np.abs(back), axis=1)[:, :2] - kept) <= tolerance + ERROR[dtype] * _ties(wide)[:, None]
    ).all()


def _ties(vectors: np.ndarray) -> np.ndarray:
    """Where two components are so near the largest that rounding may turn their order."""
    ordered = np.sort(np.abs(vectors), axis=1)
    return ordered[:, 2] - ordered[:, 1] < 1e-6


def test_the_bound_of_the_page_is_not_loose():
    generator = np.random.default_rng(3)
    for dtype in UNIT:
        vectors = unit_vectors(generator.normal(size=(50_000, 3)).tolist(), np.float64)
        vectors = (vectors * (1 + 0.9 * UNIT[dtype])).astype(dtype)
        error = np.abs(unpacked(packed(vectors))[1] - vectors.astype(np.float64)).max()
        assert 0.7 * ERROR[dtype] < error < ERROR[dtype]
