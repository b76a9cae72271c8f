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
from tests.support.atmo_texts import reference_air
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
