"""The keys of a plan's random streams: a pure function of its options, so that they can be made again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from aomc_sky.sampling import streams

STREAMS = (streams.ORDER, streams.SHIFT, streams.PLACEMENT, streams.POSITION)
"""Streams whose keys stand in the plan, in this order; allocation has done its work by then."""


def plan_keys(options: Mapping[str, Any]) -> np.ndarray:
    """Member `keys` of a plan with these options, uint64 (4,)."""
    keys = [streams.stream_key(options["seed"], name, options["method"]) for name in STREAMS]
    return np.array(keys, dtype=np.uint64)
