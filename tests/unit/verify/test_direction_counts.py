"""Keyed choices: the same for any split, different for other keys."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.verify.sky.direction_counts import is_kept, thinning_key
from aomc_sky.verify.stored.photons import chosen_blocks


@given(start=st.integers(0, 2**40), n=st.integers(0, 2000), cut=st.integers(0, 2000))
def test_coins_do_not_know_how_a_file_is_split(start: int, n: int, cut: int) -> None:
    cut = min(cut, n)
    whole = is_kept(7, start, n)
    assert np.array_equal(whole, np.concatenate([is_kept(7, start, cut), is_kept(7, start + cut, n - cut)]))


def test_coins_of_other_seeds_are_others() -> None:
    first, second = (is_kept(thinning_key(seed), 0, 10_000) for seed in (0, 1))
    assert 0.45 < np.mean(first == second) < 0.55


def test_words_for_ever() -> None:
    assert np.packbits(is_kept(thinning_key(0), 0, 64)).tobytes().hex() == "03d78386918d7d62"
    assert chosen_blocks(0, 0, 1000, 0.005).tolist() == [137, 170, 626, 702, 789]


@given(n=st.integers(0, 500), fraction=st.floats(0, 1), band=st.integers(0, 5))
def test_blocks_are_different_and_as_many_as_wanted(n: int, fraction: float, band: int) -> None:
    blocks = chosen_blocks(3, band, n, fraction)
    assert len(set(blocks.tolist())) == blocks.size == min(n, int(np.ceil(fraction * n)))
    assert np.all((blocks >= 0) & (blocks < max(n, 1)))
    assert np.all(np.diff(blocks) > 0)
