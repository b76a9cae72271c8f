"""The whole sky by backward paths: beside successive orders under a high sun, and what it says of itself."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.atmosphere.backward.orders import path_orders
from aomc_sky.atmosphere.sky.solve import later_orders, solve_sky
from aomc_sky.errors import ModelLimitWarning, UsageError
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


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")
def test_as_many_paths_as_asked_for() -> None:
    """No more of them where the error is large, and half the error for four times as many."""
    medium, sun = molecules_only(450.0, 0.2), np.radians(40.0)
    few, more = (path_orders(medium, sun, ZENITH[:1], 4, n_listed=4, n_paths=n) for n in (64, 4096))
    assert few.n_paths == 64
    assert few.resolution_error > 0.05
    assert few.resolution_error / more.resolution_error == pytest.approx(8.0, rel=0.25)
    sky = solve_sky(medium, sun_zenith_rad=sun, method="mc", n_orders=3, n_paths=8)
    assert sky.n_paths == 8
    with pytest.raises(UsageError, match="whole number from 8 to"):
        solve_sky(medium, sun_zenith_rad=sun, method="mc", n_paths=7)


def test_deep_twilight_is_told() -> None:
    with pytest.warns(ModelLimitWarning):
        path_orders(molecules_only(400.0), np.radians(97.0), ZENITH[2:], 4, n_listed=4, n_paths=64)
