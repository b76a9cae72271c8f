"""Jumps and bends are found where the branches of a function change, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from aomc_sky.atmosphere.medium import MAX_KINKS, find_kinks
from aomc_sky.errors import SceneError

SAMPLES = np.linspace(0.0, 1e5, 1025)


def pieces(*edges: float) -> Callable[[np.ndarray], np.ndarray]:
    """A trace of pieces that begin at the edges."""
    return lambda x: np.searchsorted(np.array(edges), x, side="right").astype(np.uint64)


@pytest.mark.parametrize("edges", [(8e3, 21.5e3, 39e3), (1.0 / 3.0,), (np.nextafter(0.0, 1e5) * 2**60,), (99_999.99,)])
def test_the_first_number_of_each_piece_is_found(edges: tuple[float, ...]) -> None:
    found = find_kinks(pieces(*edges), SAMPLES)
    assert found.size == len(edges)
    # exact, or as near as 2^-60 of the range beside zero
    np.testing.assert_allclose(found, edges, rtol=0, atol=1e5 * 2.0**-59)


def test_edges_that_a_float_can_tell_are_exact() -> None:
    assert find_kinks(pieces(8e3, 21.5e3, 39e3), SAMPLES).tolist() == [8e3, 21.5e3, 39e3]


def test_a_piece_far_thinner_than_the_samples_is_followed_to_both_ends() -> None:
    assert find_kinks(pieces(50_000.1, 50_000.2), SAMPLES).tolist() == [50_000.1, 50_000.2]
    many = np.sort(50_001.0 + np.random.default_rng(5).random(40))
    assert find_kinks(pieces(*many), SAMPLES).tolist() == many.tolist()


def test_a_function_of_one_piece_has_no_kinks() -> None:
    assert find_kinks(pieces(), SAMPLES).size == 0


def test_too_many_pieces_are_refused() -> None:
    edges = np.linspace(1.0, 9e4, MAX_KINKS + 1)
    assert find_kinks(pieces(*edges[:-1]), SAMPLES).size == MAX_KINKS
    with pytest.raises(SceneError, match="more than 1000 jumps or bends"):
        find_kinks(pieces(*edges), SAMPLES)
