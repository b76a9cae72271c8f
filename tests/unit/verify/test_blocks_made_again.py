"""Blocks that are made again: chosen by a key, different ones, as many as asked for."""

from __future__ import annotations

import numpy as np
from aomc_sky.verify.stored.photons import chosen_blocks
from hypothesis import given
from hypothesis import strategies as st


def test_words_for_ever() -> None:
    assert chosen_blocks(0, 0, 1000, 0.005).tolist() == [137, 170, 626, 702, 789]


@given(n=st.integers(0, 500), fraction=st.floats(0, 1), band=st.integers(0, 5))
def test_blocks_are_different_and_as_many_as_wanted(n: int, fraction: float, band: int) -> None:
    blocks = chosen_blocks(3, band, n, fraction)
    assert len(set(blocks.tolist())) == blocks.size == min(n, int(np.ceil(fraction * n)))
    assert np.all((blocks >= 0) & (blocks < max(n, 1)))
    assert np.all(np.diff(blocks) > 0)
