"""The whole sky by backward paths: beside successive orders under a high sun, and what it says of itself."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.atmosphere.path_orders import path_orders
from aomc_sky.atmosphere.solve_sky import later_orders
from aomc_sky.errors import ModelLimitWarning
from tests.support.atmospheres import molecules_only

ZENITH = np.radians([10.0, 40.0, 65.0])


def test_modes_are_those_of_successive_orders() -> None:
    medium, sun = molecules_only(450.0, 0.2), np.radians(40.0)
    paths = path_orders(medium, sun, ZENITH, 6, n_listed=6)
    exact = later_orders(medium, sun, ZENITH, 6, n_listed=6)
    assert paths.modes.shape[:2] == exact.modes.shape[:2] == (1, 5)
    np.testing.assert_allclose(paths.modes[:, :3, 0], exact.modes[:, :3, 0], rtol=0.05)
    assert 0.0 < paths.resolution_error < 0.03
    assert paths.truncation == pytest.approx(exact.truncation, rel=0.5)


def test_deep_twilight_is_told() -> None:
    with pytest.warns(ModelLimitWarning):
        path_orders(molecules_only(400.0), np.radians(97.0), ZENITH[2:], 4, n_listed=4, n_paths=64)
