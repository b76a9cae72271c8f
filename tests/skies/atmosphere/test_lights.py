"""The direct beam: the formula, the sun's disc beside it, sunrise."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from aomc_sky.skies.atmosphere.lights import ground_beam
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.optical_depth import optical_depth_to_top
from tests.support.atmospheres import exponential, full, mol_ozone, molecules_only
from tests.support.shared import SHARED, needs_shared

_N_RING = 48  # Gauss nodes of rings of equal zenith angle


def disc_irradiance(medium: Medium, sun_zenith_rad: float) -> np.ndarray:
    """Mean over the whole disc of cos(zenith) F0 exp(-slant depth), 0 below the horizon, shape (n_wl,), within 1e-7."""
    zenith, share = _rings(sun_zenith_rad, medium.sun_angular_radius_rad)
    return ground_beam(medium, zenith).irradiance @ share


def _rings(centre: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Zenith angles, and shares of the disc's solid angle, of what is above the horizon; its limits as roots of t."""
    node, weight = np.polynomial.legendre.leggauss(_N_RING)
    lowest, highest = abs(centre - radius), centre + radius
    middle, half = 0.5 * (highest + lowest), 0.5 * (highest - lowest)
    last = np.arccos(np.clip((middle - np.pi / 2) / half, -1.0, 1.0)) if half > 0.0 else 0.0
    t = 0.5 * last * (1.0 + node)
    zenith = middle - half * np.cos(t)
    sine = np.maximum(np.sin(zenith) * np.sin(centre), 1e-300)
    across = np.sin(0.5 * (radius + zenith - centre)) * np.sin(0.5 * (radius - zenith + centre))
    turn = 4.0 * np.arcsin(np.sqrt(np.clip(across / sine, 0.0, 1.0)))
    share = 0.5 * last * weight * half * np.sin(t) * turn * np.sin(zenith)
    inside = max(radius - centre, 0.0)  # rings around the zenith that lie in the disc as a whole
    inner = 0.5 * inside * (1.0 + node)
    whole = 0.5 * inside * weight * 2.0 * np.pi * np.sin(inner)
    solid_angle = 4.0 * np.pi * np.sin(0.5 * radius) ** 2
    return np.concatenate([zenith, inner]), np.concatenate([share, whole]) / solid_angle


RADIUS_RAD = np.radians(0.2666)


def test_the_formula() -> None:
    medium = replace(full([450.0, 550.0]), toa_irradiance=np.array([2.0, 3.0]), sun_angular_radius_rad=RADIUS_RAD)
    for sun_deg in (0.0, 60.0, 89.0, 89.99):
        sun = np.radians(sun_deg)
        beam = ground_beam(medium, sun)
        np.testing.assert_allclose(beam.optical_depth, optical_depth_to_top(medium, 0.0, sun), rtol=0)
        expected = np.cos(sun) * np.array([2.0, 3.0]) * np.exp(-beam.optical_depth)
        np.testing.assert_allclose(beam.irradiance, expected, rtol=1e-15)


def test_sunrise_of_a_point() -> None:
    zenith = np.radians([89.0, 89.999, 90.0, 90.001, 91.0, 180.0])
    found = ground_beam(exponential(0.1), zenith).irradiance[0]
    assert np.all(np.diff(found[:3]) < 0)
    assert found[2:].tolist() == [0.0] * 4
    assert np.isfinite(ground_beam(exponential(0.1), np.pi / 2).optical_depth[0])
    assert np.isinf(ground_beam(exponential(0.1), np.radians(90.001)).optical_depth[0])


def test_the_disc_and_its_centre() -> None:
    """The figures of the docstring and of docs/models/atmosphere.md."""
    medium = replace(full([450.0]), sun_angular_radius_rad=RADIUS_RAD)
    for sun_deg, low, high in [
        (0, -7e-6, -6e-6),
        (80, 1.4e-4, 1.7e-4),
        (85, 1.7e-3, 2e-3),
        (88, 0.018, 0.021),
        (89, 0.06, 0.07),
    ]:
        sun = np.radians(sun_deg)
        assert low < disc_irradiance(medium, sun)[0] / ground_beam(medium, sun).irradiance[0] - 1 < high


@needs_shared
def test_reference_direct_irradiance() -> None:
    makers = {"rayleigh": molecules_only, "mol_ozone": mol_ozone, "full": full}
    with (SHARED / "atmosphere" / "spherical_flux.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        medium = makers[row["case"]](float(row["wavelength_nm"]))
        found = ground_beam(medium, np.radians(float(row["sza_deg"]))).irradiance[0]
        assert found == pytest.approx(float(row["E_direct"]), rel=1e-8, abs=1e-16)
    assert len(rows) == 45
