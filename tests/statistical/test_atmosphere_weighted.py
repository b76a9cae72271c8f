"""Tables of the descriptions' skies beside weighted directions, which know neither series, patches nor flat layers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from aomc_sky.atmosphere.sky.method import chosen_lights
from aomc_sky.atmosphere.sky.weighted_directions import order_one_density, weighted_directions
from aomc_sky.formats.atmo.reader import read_atmo
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.atmosphere import AtmosphereSky
from aomc_sky.source.atmospheres.medium import read_medium
from tests.support.chi2 import chi2_p
from tests.support.shared import INPUTS
from tests.support.weighted_cells import GroupSums, group_sums, groups_p, whole_p

GRID = PatchGrid.regular(18, 24)
IRRADIANCE_ERROR = 5e-4
"""Of a table by successive orders, sun above 10 degrees: the mean of its deviations is 0.02 % (docs)."""

SKIES = ("molecules_only", "clear_marine", "hazy", "mars_like")


@dataclass(frozen=True, kw_only=True)
class Compared:
    """A sky at one wavelength: groups of directions, and the table's irradiances of cells (order 1, later, errors)."""

    sums: GroupSums
    once: np.ndarray
    later: np.ndarray
    error: np.ndarray

    def p_values(self, table: np.ndarray) -> tuple[float, float, float]:
        """Of directions drawn, of the groups' irradiances, and of the sky's."""
        of_groups = self.sums.sums_of(table)
        return (
            chi2_p(self.sums.counts, self.sums.expected),
            groups_p(self.sums, of_groups, self.sums.sums_of(self.error)),
            whole_p(self.sums, of_groups, IRRADIANCE_ERROR * float(table.sum())),
        )


def compared(name: str, sun_deg: float, wavelength_nm: list[float], n: int) -> list[Compared]:
    medium, _ = read_medium(read_atmo(INPUTS / "atmosphere" / f"{name}.atmo"), np.array(wavelength_nm))
    sun = float(np.radians(sun_deg))
    found = weighted_directions(medium, sun_zenith_rad=sun, n=n, seed=round(sun_deg))
    sky = AtmosphereSky(medium=medium, sun_zenith_deg=sun_deg, grid=GRID, method="sos")
    lights = chosen_lights(medium, sun, method="mc", n_orders=None, moon=None, ground_radiance=None)
    density, angle = order_one_density(medium, sun, lights), GRID.projected_solid_angle_sr
    assert not found.under_sampled.any()
    return [
        Compared(
            sums=group_sums(found, row, density, GRID),
            once=sky.patch_mean[row, 0] * angle,
            later=sky.patch_mean[row, 1:].sum(axis=0) * angle,
            error=sky.patch_error[row] * angle,
        )
        for row in range(len(wavelength_nm))
    ]


def test_a_table(plan) -> None:
    (sky,) = compared("molecules_only", 40.0, [440.0], 200_000)
    table = sky.once + sky.later
    for p in sky.p_values(table):
        plan.check(p)
    plan.catches(sky.p_values(sky.once + 1.03 * sky.later)[2])
    turned = np.roll(table.reshape(18, 24), 1, axis=1).ravel()
    plan.catches(sky.p_values(turned)[1])
    even = np.full(sky.sums.counts.size, sky.sums.counts.mean())
    plan.catches(chi2_p(sky.sums.counts, even))


@pytest.mark.slow
@pytest.mark.parametrize("sun_deg", [40.0, 75.0])
@pytest.mark.parametrize("name", SKIES)
def test_tables(name: str, sun_deg: float, plan) -> None:
    for sky in compared(name, sun_deg, [440.0, 680.0], 400_000):
        for p in sky.p_values(sky.once + sky.later):
            plan.check(p)
