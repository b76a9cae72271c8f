"""Seeds and profiles of the suite: the same numbers every time, unless a night asks for more."""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

settings.register_profile(
    "quick", max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("night", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("AOMC_SKY_HYPOTHESIS", "quick"))
