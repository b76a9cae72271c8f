"""Sums of four orders at the nodes of the tool that the descriptions come from, suns above 10 degrees."""

from __future__ import annotations

import csv
from collections import defaultdict

import numpy as np
import pytest

from aomc_sky.atmosphere.sky.solve import solve
from tests.support import atmospheres
from tests.support.shared import SHARED

ATMOSPHERE = SHARED / "atmosphere"
MEDIA = {"calcmysky_rayleigh.csv": atmospheres.molecules_only, "calcmysky_sample.csv": atmospheres.sample}
Row = dict[str, str]
pytestmark = pytest.mark.skipif(not ATMOSPHERE.is_dir(), reason="the reference data are not beside the repository")


def suns(name: str) -> list[list[Row]]:
    """Rows of each wavelength and sun above 10 degrees that does not stand overhead."""
    found: dict[tuple[str, str], list[Row]] = defaultdict(list)
    with (ATMOSPHERE / name).open() as file:
        for row in csv.DictReader(file):
            if 0.174 < float(row["mu0"]) < 0.999:
                found[row["wavelength_nm"], row["mu0"]].append(row)
    return list(found.values())


def column(rows: list[Row], key: str) -> np.ndarray:
    return np.array([float(row[key]) for row in rows])


@pytest.mark.parametrize("step", [5, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", MEDIA)
def test_four_orders_agree_with_the_tool(name: str, step: int) -> None:
    cases = suns(name)[::step]
    assert cases
    for rows in cases:
        medium = MEDIA[name](float(rows[0]["wavelength_nm"]), float(rows[0]["albedo"]))
        mu0, mu, cosine = float(rows[0]["mu0"]), column(rows, "mu_view"), column(rows, "cos_view_sun")
        across = np.sqrt(np.maximum((1 - mu**2) * (1 - mu0**2), 0.0))
        turn = np.divide(cosine - mu * mu0, across, out=np.ones_like(mu), where=across > 1e-6)
        sky_zenith, azimuth = np.arccos(np.clip(mu, 0, 1)), np.arccos(np.clip(turn, -1, 1))
        found = solve(
            medium, sun_zenith_rad=np.arccos(mu0), sky_zenith_rad=sky_zenith, azimuth_from_sun_rad=azimuth, n_orders=4
        )
        each = np.arange(mu.size)
        by_order = found.radiance_by_order[0][:, each, each]
        expected = np.stack([column(rows, f"L_order{order}") for order in (1, 2, 3, 4)])
        np.testing.assert_allclose(by_order[0], expected[0], rtol=5e-3, atol=1e-7)
        np.testing.assert_allclose(by_order.sum(axis=0), expected.sum(axis=0), rtol=1e-2)
