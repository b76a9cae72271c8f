"""Descriptions from file to radiance against the reference tables: reader, code blocks, norms and solvers together."""

import numpy as np
import pytest

import aomc_sky
from tests.skies.atmosphere.language.test_values import MOLECULES, OZONE, PEAKED, RAYLEIGH
from tests.skies.atmosphere.reference_tables import column, grouped, needs_tables
from tests.support.atmospheres import OZONE_M2

pytestmark = needs_tables
AIR = grouped("spherical_radiance.csv", "case", "wavelength_nm", "albedo", "sza_deg")


SECTION = """Scatterer "{name}":
{{
number density:
```
{density}
```
phase function:
```
{phase}
```
cross section at 1 um: {section}
angstrom exponent: {angstrom}
}}
"""


def reference_air(case, wavelength_nm, albedo):
    """Case `rayleigh`, `mol_ozone` or `full` of the tables, at one wavelength, under a sun of 1 W m-2 nm-1."""
    text = (
        "version: 6\natmosphere height: 120 km\nEarth radius: 6371 km\nEarth-Sun distance: 1 AU\n"
        f"scattering orders: 1000\nwavelengths: min={wavelength_nm}nm,max={wavelength_nm + 3}nm,count=4\n"
        f"solar irradiance at TOA: 1, 1, 1, 1\nground albedo: {', '.join([repr(albedo)] * 4)}\n"
    )
    text += SECTION.format(name="air", density=MOLECULES, phase=RAYLEIGH, section="0.04022 fm^2", angstrom=4)
    if case == "full":
        density = "return 1.03333e8*exp(-altitude/(1.2*km));"
        text += SECTION.format(name="aerosol", density=density, phase=PEAKED, section="0.042968 um^2", angstrom=0)
    if case != "rayleigh":
        section = ", ".join([repr(OZONE_M2[wavelength_nm])] * 4)
        text += f'Absorber "ozone":\n{{\nnumber density:\n```\n{OZONE}\n```\ncross section: {section}\n}}\n'
    return text


@pytest.mark.parametrize(
    "air",
    [pytest.param(case, marks=() if k % 11 == 0 else pytest.mark.slow) for k, case in enumerate(AIR)],
    ids="-".join,
)
def test_spherical_air(air, tmp_path):
    (case, wavelength, albedo, sun), rows = air, AIR[air]
    zenith, azimuth = np.unique(column(rows, "vza_deg")), np.unique(column(rows, "phi_deg"))
    method = "auto" if float(sun) <= 80 else "order1"
    path = tmp_path / "air.atmo"
    path.write_text(reference_air(case, int(wavelength), float(albedo)))
    found = aomc_sky.solve_atmosphere(
        path,
        wavelength_nm=float(wavelength),
        sun_zenith_deg=float(sun),
        sky_zenith_deg=zenith,
        azimuth_from_sun_deg=azimuth,
        orders=40 if method == "auto" else 1,
    )
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
