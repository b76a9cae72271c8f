"""The colour of light below a cloud: ours (`--spectrum spectrl2`, dni 0) beside multiple scattering by PythonicDISORT.

    python bench/cloud_spectrum.py

Three plane layers: molecules above the cloud; the cloud with molecules; molecules below it. The cloud does not absorb
and scatters by Henyey and Greenstein with g = 0.86; optical depths 10, 20 and 40, suns at 30, 50 and 70 degrees,
albedo of the sea 0.06. The sun's spectrum, ozone, water and gases are those of SPCTRL2, so that scattering alone is
compared. Printed is the downward irradiance at 412, 443, 490, 555 nm over that at 670 nm; the last line is ours.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
import pvlib
from PythonicDISORT.pydisort import pydisort

import aomc_sky as sky

NM = np.array([412.0, 443.0, 490.0, 555.0, 670.0])
CLOUDS, SUNS_DEG = (10.0, 20.0, 40.0), (30.0, 50.0, 70.0)
ALBEDO, ASYMMETRY, N_STREAMS = 0.06, 0.86, 16
BELOW, INSIDE = 0.15, 0.10  #: Shares of the molecules below the cloud and inside of it.
MOLECULES = 0.00864  #: Optical depth at 1 um; exponent 4.08 from 400 to 700 nm.


def gases(sun_zenith_deg: float, air_mass: float) -> tuple[np.ndarray, np.ndarray]:
    """Extraterrestrial spectrum, and the transmittance of ozone, water and mixed gases of SPCTRL2."""
    zenith = np.array([sun_zenith_deg])
    found = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith, aoi=zenith, surface_tilt=0.0, ground_albedo=ALBEDO, surface_pressure=101_325.0,
        relative_airmass=air_mass, precipitable_water=1.416, ozone=0.344, aerosol_turbidity_500nm=0.0, dayofyear=80,
    )  # fmt: skip
    nm = np.ravel(found["wavelength"])
    um = nm / 1000.0
    molecules = np.exp(-air_mass / (um**4 * (115.6406 - 1.335 / um**2)))
    outside = found["dni_extra"][:, 0]
    return np.interp(NM, nm, outside), np.interp(NM, nm, found["dni"][:, 0] / outside / molecules)


def below_cloud(cloud: float, sun_zenith_deg: float) -> np.ndarray:
    """Downward irradiance at the sea."""
    outside, transmitted = gases(sun_zenith_deg, 1.66)
    orders = np.arange(N_STREAMS + 1)
    rayleigh = np.where(orders == 0, 1.0, np.where(orders == 2, 0.1, 0.0))
    mu = math.cos(math.radians(sun_zenith_deg))
    light = []
    for depth in MOLECULES * (NM / 1000.0) ** -4.08:
        layers = np.array([(1 - BELOW - INSIDE) * depth, INSIDE * depth + cloud, BELOW * depth])
        share = np.array([0.0, cloud / layers[1], 0.0])[:, None]
        legendre = share * ASYMMETRY**orders + (1 - share) * rayleigh
        total = np.cumsum(layers)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            _, _, flux_down, *_ = pydisort(
                total, np.full(3, 1 - 1e-6), N_STREAMS, legendre, mu, 1.0, 0.0, only_flux=True, f_arr=legendre[:, -1],
                BDRF_Fourier_modes=[ALBEDO],
            )  # fmt: skip
        light.append(sum(flux_down(total[-1])))
    return np.array(light) * outside * transmitted


def main() -> None:
    print("| cloud | sun | 412 | 443 | 490 | 555 |")
    print("| --- | --- | --- | --- | --- | --- |")
    for cloud in CLOUDS:
        for sun_deg in SUNS_DEG:
            light = below_cloud(cloud, sun_deg)
            print(f"| {cloud:g} | {sun_deg:g}° | {' | '.join(f'{one:.3f}' for one in light[:-1] / light[-1])} |")
    scene = sky.weather_scene(wavebands=NM, sun_zenith_deg=50.0, ghi=300.0, dhi=300.0, spectrum="spectrl2")
    assert scene.irradiance is not None
    ours = scene.irradiance.of_component.sum(axis=1)
    print(f"| ours | | {' | '.join(f'{one:.3f}' for one in ours[:-1] / ours[-1])} |")


if __name__ == "__main__":
    main()
