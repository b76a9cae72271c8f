"""Settings of a small year of skies."""

from __future__ import annotations

from typing import Any

from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.year import SCHEMA

YEAR_OPTIONS: dict[str, Any] = {
    "schema": SCHEMA,
    "stream": STREAM_VERSION,
    "seed": 5,
    "iterations": 1000,
    "bins": [4, 8],
    "limits": "radiance",
    "air_mass": "kasten-young-1989",
    "with_beam": False,
    "site": [50.0, 8.0, 1.0],
}
