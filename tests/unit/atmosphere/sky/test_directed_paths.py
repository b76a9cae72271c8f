"""Method "mc" in directions asked for: its own paths there, with an error of each direction's own."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from aomc_sky.atmosphere.backward.monte_carlo import solve_paths
from aomc_sky.atmosphere.sky import solve as solve_module
from aomc_sky.atmosphere.sky.solve import AtmosphereResult, solve, solve_sky
from aomc_sky.atmosphere.sky.solved import SolvedSky
from tests.support.atmospheres import molecules_only

SUN = np.radians(91.0)
ZENITH, AZIMUTH = np.radians([0.0, 60.0, 85.0, 89.0]), np.radians([-150.0, 0.0, 150.0])
MEDIUM = molecules_only(550.0, 0.3)


def sky_of(sun_rad: float) -> SolvedSky:
    """What `directed_paths` reads of a sky, which is not solved for it."""
    sky = solve_sky(MEDIUM, sun_zenith_rad=1.0, method="order1")
    return dataclasses.replace(sky, sun_zenith_rad=sun_rad, method="mc", n_orders=4)


@pytest.mark.filterwarnings("ignore:in .* hardly any path reaches")
def test_errors_are_those_of_each_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solve_module, "MOST_PATHS", 10_000)
    theta, phi = (angle.ravel() for angle in np.meshgrid(ZENITH, AZIMUTH[1:], indexing="ij"))
    found = solve_module.directed_paths(sky_of(SUN), theta, phi)
    other = solve_paths(
        MEDIUM, sun_zenith_rad=SUN, sky_zenith_rad=theta, azimuth_from_sun_rad=phi, n_paths=20_000, n_orders=4, seed=99
    )
    pull = (found.radiance - other.radiance) / np.hypot(found.standard_error, other.standard_error)
    assert 1e-4 < chi2.cdf(np.sum(pull**2), pull.size) < 1 - 1e-4
    share = found.standard_error / found.radiance
    assert share.max() > 3.0 * share.min()  # the dark side of the horizon is known far worse than the glow


def test_two_suns_have_numbers_of_their_own() -> None:
    zenith, azimuth = np.radians([60.0]), np.zeros(1)
    one, two = (solve_module.directed_paths(sky_of(sun), zenith, azimuth) for sun in (1.2, np.nextafter(1.2, 2.0)))
    later = [found.radiance_by_order[0, 1:, 0].sum() for found in (one, two)]
    assert 1e-5 < abs(later[0] / later[1] - 1.0) < 0.05


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:in .* hardly any path reaches")
def test_solve_takes_them() -> None:
    def look(zenith: np.ndarray, azimuth: np.ndarray) -> AtmosphereResult:
        return solve(
            MEDIUM, sun_zenith_rad=SUN, sky_zenith_rad=zenith, azimuth_from_sun_rad=azimuth, method="mc", n_orders=4
        )

    found = look(ZENITH, AZIMUTH)
    assert np.array_equal(found.radiance_by_order[..., 0], found.radiance_by_order[..., 2])
    assert np.array_equal(found.standard_error[..., 0], found.standard_error[..., 2])
    share = found.standard_error / found.radiance
    assert share.max() > 3.0 * share.min()
    assert found.under_sampled is not None
    assert found.under_sampled.shape == found.radiance.shape
    alone = look(ZENITH[2:3], AZIMUTH[2:])
    assert np.array_equal(alone.radiance[..., 0], found.radiance[:, 2:3, 2])


def test_many_directions_have_fewer_paths(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def follow(*arguments: object, **options: object) -> object:
        asked.append(options["n_paths"])
        raise InterruptedError

    monkeypatch.setattr(solve_module, "solve_paths", follow)
    sky: Any = type("Sky", (), {"medium": MEDIUM, "sun_zenith_rad": SUN, "n_orders": 4, "moon": None})()
    for n in (1, 512, 1024, 100_000):
        with pytest.raises(InterruptedError):
            solve_module.directed_paths(sky, np.zeros(n), np.zeros(n))
    assert asked == [65536, 65536, 32768, 4096]


def test_series_methods_have_no_flags() -> None:
    quick = solve(MEDIUM, sun_zenith_rad=1.0, sky_zenith_rad=[0.5], azimuth_from_sun_rad=[0.0], method="order1")
    assert quick.under_sampled is None
