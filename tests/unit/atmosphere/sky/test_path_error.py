"""Errors of a whole sky by backward paths: each direction has that of the node beside it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from aomc_sky.atmosphere.backward import orders
from aomc_sky.atmosphere.lights import Moon
from aomc_sky.atmosphere.sky.solve import solve_sky
from aomc_sky.atmosphere.sky_field import azimuth_nodes, zenith_nodes
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.atmosphere import AtmosphereSky
from tests.support.atmospheres import molecules_only

MEDIUM = molecules_only(550.0, 0.3)


def test_the_nearest_node_counts() -> None:
    sky = solve_sky(MEDIUM, sun_zenith_rad=1.0, method="order1")
    sky = dataclasses.replace(sky, node_error=np.arange(24.0).reshape(1, 6, 4))
    zenith, azimuth = np.meshgrid(zenith_nodes(6), azimuth_nodes(4, is_mirrored=True), indexing="ij")
    for turned in (azimuth, -azimuth, azimuth + 2 * np.pi):
        assert np.array_equal(sky.path_error(zenith.ravel() + 1e-9, turned.ravel())[0], np.arange(24.0))


def test_left_and_right_differ_beside_a_moon() -> None:
    sky = solve_sky(MEDIUM, sun_zenith_rad=1.0, method="order1")
    moon = Moon(zenith_rad=1.0, azimuth_from_sun_rad=0.01, distance_m=4e8)
    sky = dataclasses.replace(sky, moon=moon, node_error=np.arange(30.0).reshape(1, 6, 5))
    zenith, azimuth = np.meshgrid(zenith_nodes(6), azimuth_nodes(5, is_mirrored=False), indexing="ij")
    for turned in (azimuth, azimuth - 2 * np.pi):
        assert np.array_equal(sky.path_error(zenith.ravel(), turned.ravel())[0], np.arange(30.0))


@pytest.mark.filterwarnings("ignore:the paths know orders 2 and up")
@pytest.mark.filterwarnings("ignore:in .* hardly any path reaches")
def test_patches_have_errors_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    followed = orders.solve_paths
    monkeypatch.setattr(
        orders, "solve_paths", lambda *given, **options: followed(*given, **(options | {"n_paths": 256}))
    )
    sky = AtmosphereSky(
        medium=MEDIUM, sun_zenith_deg=89.0, sun_azimuth_deg=70.0, method="mc", n_orders=3,
        grid=PatchGrid.regular(9, 12),
    )  # fmt: skip
    share = sky.patch_error[0] / sky.patch_mean[0, 1:].sum(axis=0)
    assert share.max() > 1.5 * share.min()
    assert np.all(share > 0)
