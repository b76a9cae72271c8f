"""The clear sky of an atmosphere as domes, one for each wavelength."""

from __future__ import annotations

from aomc_sky.pictures.content import RADIANCE, Dome, Mark, Picture, Symbol
from aomc_sky.pictures.domes.marks import sun_mark
from aomc_sky.skies.atmosphere import AtmosphereSky


def atmosphere_picture(sky: AtmosphereSky, *, title: str = "") -> Picture:
    """Radiance of the patches at up to 12 wavelengths, W m-2 sr-1 nm-1, and the direct beam as a mark."""
    place = sky.sun_zenith_deg, sky.sun_azimuth_deg
    domes = []
    wavelengths, direct = sky.medium.wavelength_nm.tolist(), sky.direct_irradiance.tolist()
    diffuse = sky.diffuse_irradiance.tolist()
    for k, wavelength in enumerate(wavelengths):
        name, mark = f"{wavelength:g} nm", sun_mark(*place)
        if direct[k] > 0:
            name += f"\nbeam {100 * direct[k] / (direct[k] + diffuse[k]):.3g} % of the light"
            mark = Mark(zenith_deg=place[0], azimuth_deg=place[1], symbol=Symbol.BEAM)
        radiance = sky.patch_mean[k].sum(axis=0)
        domes.append(Dome(grid=sky.grid, values=radiance, title=name, marks=(mark,)))
    return Picture(domes=tuple(domes), quantity=RADIANCE, title=title)
