"""Keys of streams: golden words for ever, and no two alike."""

import numpy as np
import pytest

from aomc_sky.errors import UsageError
from aomc_sky.plan.options import Method
from aomc_sky.plan.sampling import streams


def test_keys_differ_by_seed_method_and_name():
    names = (streams.ALLOCATION, streams.ORDER, streams.SHIFT, streams.PLACEMENT, streams.POSITION)
    methods = (None, *(method.value for method in Method))
    seeds = (*range(200), 2**64 - 1)
    keys = {streams.stream_key(seed, name, method) for seed in seeds for method in methods for name in names}
    assert len(keys) == len(seeds) * len(methods) * len(names)


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, True, None, "1"])
def test_what_is_no_seed(seed):
    with pytest.raises((UsageError, TypeError, ValueError)):
        streams.checked_seed(seed)


def test_integers_of_any_type_are_the_same_seed():
    keys = {streams.checked_seed(seed) for seed in (7, np.int64(7), np.uint8(7), np.array(7))}
    assert len(keys) == 1


def test_a_float_is_no_seed():
    """2^53 + 1 as a float is another seed already."""
    with pytest.raises(UsageError, match=r"seed must be a whole number from 0 to 2\^64 - 1, got 7\.0"):
        streams.checked_seed(7.0)
