"""Keyed choices: the same for any split, different for other keys."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.verify.sky.direction_counts import is_kept, thinning_key


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
