"""Descriptions from file to radiance against the reference tables: reader, code blocks, norms and solvers together."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aomc_sky
from tests.support.atmo_texts import flat_layers, reference_air
from tests.support.atmospheres import Layer
from tests.support.shared import SHARED

ATMOSPHERE = SHARED / "atmosphere"
AZIMUTHS = np.arange(0, 181, 30)
Row = dict[str, str]
pytestmark = pytest.mark.skipif(not ATMOSPHERE.is_dir(), reason="the reference data are not beside the repository")


@cache
def tables(name: str, *keys: str) -> dict[tuple[str, ...], list[Row]]:
    """Rows of a table by the values of some columns."""
    found: dict[tuple[str, ...], list[Row]] = defaultdict(list)
    if (ATMOSPHERE / name).is_file():
        with (ATMOSPHERE / name).open() as file:
            for row in csv.DictReader(file):
                found[tuple(row[key] for key in keys)].append(row)
    return found


def some(name: str, *keys: str, kept: int) -> list:  # type: ignore[type-arg]
    """Every `kept`-th case by default, the others slow."""
    return [
        pytest.param(*case, marks=() if k % kept == 0 else pytest.mark.slow)
        for k, case in enumerate(tables(name, *keys))
    ]


def column(rows: Sequence[Row], key: str) -> np.ndarray:
    return np.array([float(row[key]) for row in rows])


def solved(
    path: Path, text: str, wavelength: float, sun_deg: float, zenith: np.ndarray, azimuth: np.ndarray, **options: Any
) -> aomc_sky.AtmosphereResult:
    path.write_text(text)
    return aomc_sky.solve_atmosphere(
        path,
        wavelength_nm=wavelength,
        sun_zenith_deg=sun_deg,
        sky_zenith_deg=zenith,
        azimuth_from_sun_deg=azimuth,
        **options,
    )


@pytest.mark.parametrize(("tau", "albedo", "mu0"), some("pp_rayleigh_radiance.csv", "tau", "albedo", "mu0", kept=15))
def test_flat_molecules(tau: str, albedo: str, mu0: str, tmp_path: Path) -> None:
    rows = tables("pp_rayleigh_radiance.csv", "tau", "albedo", "mu0")[tau, albedo, mu0]
    text = flat_layers([Layer(tau_rayleigh=float(tau))], float(albedo))
    sun, zenith = np.rad2deg(np.arccos(float(mu0))), np.rad2deg(np.arccos(column(rows, "mu")))
    found = solved(tmp_path / "flat.atmo", text, 1000, sun, zenith, AZIMUTHS, method="sos")
    expected = np.stack([column(rows, f"L_phi{a}") for a in AZIMUTHS], axis=1)
    np.testing.assert_allclose(found.radiance[0], expected, rtol=3e-5)
    (flux,) = tables("pp_rayleigh_flux.csv", "tau", "albedo", "mu0")[tau, albedo, mu0]
    assert found.diffuse_irradiance[0] == pytest.approx(float(flux["E_diffuse"]), rel=2e-5)
    assert found.direct_irradiance[0] == pytest.approx(float(flux["E_direct"]), rel=1e-6)


@pytest.mark.parametrize(("case", "mu0", "albedo"), some("pp_layers_radiance.csv", "case", "mu0", "albedo", kept=7))
def test_flat_layers(case: str, mu0: str, albedo: str, tmp_path: Path) -> None:
    rows = tables("pp_layers_radiance.csv", "case", "mu0", "albedo")[case, mu0, albedo]
    layers = [
        Layer(**{key: float(row[key]) for key in ("tau_rayleigh", "tau_hg", "g", "omega_hg", "tau_absorber")})
        for row in tables("pp_layers_cases.csv", "case")[case,]
    ]
    mu, azimuth = np.unique(column(rows, "mu")), np.unique(column(rows, "phi_deg"))
    sun = np.rad2deg(np.arccos(float(mu0)))
    text = flat_layers(layers, float(albedo))
    found = solved(tmp_path / "flat.atmo", text, 1000, sun, np.rad2deg(np.arccos(mu)), azimuth, method="sos")
    at = np.searchsorted(mu, column(rows, "mu")), np.searchsorted(azimuth, column(rows, "phi_deg"))
    np.testing.assert_allclose(found.radiance[0][at], column(rows, "L_all"), rtol=1e-4)
    for order in (1, 2, 3, 4):
        part = found.radiance_by_order[0, order - 1][at]
        expected = column(rows, f"L_order{order}")
        seen = expected > 1e-3 * column(rows, "L_all")
        np.testing.assert_allclose(part[seen], expected[seen], rtol=2e-4)


@pytest.mark.parametrize(
    ("case", "wavelength", "albedo", "sun"),
    some("spherical_radiance.csv", "case", "wavelength_nm", "albedo", "sza_deg", kept=11),
)
def test_spherical_air(case: str, wavelength: str, albedo: str, sun: str, tmp_path: Path) -> None:
    rows = tables("spherical_radiance.csv", "case", "wavelength_nm", "albedo", "sza_deg")[case, wavelength, albedo, sun]
    zenith, azimuth = np.unique(column(rows, "vza_deg")), np.unique(column(rows, "phi_deg"))
    method = "auto" if float(sun) <= 80 else "order1"
    text = reference_air(case, int(wavelength), float(albedo))
    orders = 40 if method == "auto" else 1
    found = solved(tmp_path / "air.atmo", text, float(wavelength), float(sun), zenith, azimuth, orders=orders)
    at = np.searchsorted(zenith, column(rows, "vza_deg")), np.searchsorted(azimuth, column(rows, "phi_deg"))
    # at 92 degrees the table steps over the edge of the shadow; see test_order_one_tables.py
    claimed = 1e-4 if float(sun) <= 90 else 7e-3
    np.testing.assert_allclose(found.radiance_by_order[0, 0][at], column(rows, "L_order1"), rtol=claimed)
    if method == "order1":
        return
    expected, noise = column(rows, "L_all"), column(rows, "se_all")
    assert np.all(np.abs(found.radiance[0][at] - expected) < 0.01 * expected)
    error = np.hypot(noise, found.standard_error[0][at])
    deviation = (found.radiance[0][at] - expected) / error
    assert np.sqrt(np.mean(deviation**2)) < 2.0
