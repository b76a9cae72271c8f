"""Seed policy and profiles of the suite.

Tests make their generators from numbers written in the test, never from the clock, so a failure comes back when the
test runs again; only their order is random (pytest-randomly prints its seed). Hypothesis draws the same examples every
time in the profiles `quick` (the default) and `ci` (where CI is set); `AOMC_SKY_HYPOTHESIS=nightly` looks for new ones.
Nothing may reach for the network.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from typing import Any, NoReturn

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "quick", max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("ci", settings.get_profile("quick"), max_examples=100)
settings.register_profile("nightly", settings.get_profile("quick"), max_examples=2000, derandomize=False)
settings.load_profile(os.environ.get("AOMC_SKY_HYPOTHESIS", "ci" if os.environ.get("CI") else "quick"))


@pytest.fixture(autouse=True, scope="session")
def _no_network() -> Iterator[None]:
    connect = socket.socket.connect

    def guarded(self: socket.socket, address: Any) -> None:
        if self.family in (socket.AF_INET, socket.AF_INET6):
            _refuse(address)
        connect(self, address)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket.socket, "connect", guarded)
        yield


def _refuse(address: object) -> NoReturn:
    raise RuntimeError(f"a test reached for the network: {address}")
