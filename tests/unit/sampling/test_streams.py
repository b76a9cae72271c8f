"""Keys of streams: golden words for ever, and no two alike."""

import numpy as np
import pytest

from aomc_sky.errors import UsageError
from aomc_sky.sampling import streams
from aomc_sky.source.sampling_options import Method


def test_keys_differ_by_seed_method_and_name():
    names = (streams.ALLOCATION, streams.ORDER, streams.SHIFT, streams.PLACEMENT, streams.POSITION)
    methods = (None, *(method.value for method in Method))
    seeds = (*range(200), 2**64 - 1)
    keys = {streams.stream_key(seed, name, method) for seed in seeds for method in methods for name in names}
    assert len(keys) == 201 * 5 * 4


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, True, None, "1"])
def test_what_is_no_seed(seed):
    with pytest.raises((UsageError, TypeError, ValueError)):
        streams.stream_key(seed, "order")


def test_whole_numbers_of_any_type_are_the_same_seed():
    assert (
        streams.stream_key(np.int64(7), "order") == streams.stream_key(7, "order") == streams.stream_key(7.0, "order")
    )
