"""Write night_sky/night.h5, starlight, airglow and a city in absolute units: `python inputs/make_night.py [FOLDER]`.

Sources of the numbers:

- Natural sky at the zenith, V band, moonless, sunspot minimum, high galactic and ecliptic latitude: airglow 145 S10,
  zodiacal light 60 S10, scattered starlight 15 S10, together 21.9 mag arcsec-2 (Benn and Ellison, "La Palma night-sky
  brightness", La Palma Technical Note 115, 1998). 1 S10 is 27.78 mag arcsec-2; a star of V = 0 gives
  3.63e-11 W m-2 nm-1 at 550 nm (Bessell, PASP 91, 589, 1979). So 1 S10 is 1.19e-11 W m-2 sr-1 nm-1.
- Airglow towards the horizon: a layer at 90 km is 1.9 times as bright 60 degrees from the zenith as at the zenith (van
  Rhijn, Publ. Astr. Lab. Groningen 31, 1921); a GGX lobe of roughness 1.7 is 1.93 times as bright there.
- City: brighter by the factor 0.01 P d^-2.5 than the natural sky, 45 degrees from the zenith towards a city of P
  inhabitants at d kilometres (Walker, PASP 89, 405, 1977); here P = 200 000 and d = 30 km. Lamps: high pressure
  sodium, the shape of its spectrum drawn by hand.

Spectra are shapes of 10 nm, good for scenes, not for photometry.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import aomc_sky as sky

WAVELENGTH_NM = np.arange(380.0, 721.0, 10.0)
S10 = 3.63e-11 * 10 ** (-0.4 * 27.78) * (180 * 3600 / np.pi) ** 2
"""Radiance of one S10 at 550 nm. [W m-2 sr-1 nm-1]"""

AIRGLOW_WIDTH = 1.7
CITY = {"kind": "ggx", "width": 0.35, "width_y": 0.8, "zenith_deg": 84.0, "azimuth_deg": 205.0}
INHABITANTS, DISTANCE_KM = 200_000, 30.0


def line(centre_nm: float) -> np.ndarray:
    """A spectral line as wide as the grid, integral 1. [nm-1]"""
    return np.maximum(0.0, 1.0 - np.abs(WAVELENGTH_NM - centre_nm) / 10.0) / 10.0


def planck(kelvin: float) -> np.ndarray:
    """A black body, 1 at 550 nm."""

    def law(wavelength_nm: np.ndarray | float) -> np.ndarray:
        return 1.0 / (np.asarray(wavelength_nm) ** 5 * np.expm1(1.4387769e7 / (np.asarray(wavelength_nm) * kelvin)))

    return law(WAVELENGTH_NM) / law(550.0)


def at_550(shape: np.ndarray) -> np.ndarray:
    """A spectrum with the V band (500 to 600 nm) mean 1."""
    band = (WAVELENGTH_NM >= 500) & (WAVELENGTH_NM <= 600)
    return shape / shape[band].mean()


def rounded(spectrum: np.ndarray) -> list[float]:
    """Six digits, so that the last bit of an exponential cannot change the file."""
    return [float(f"{value:.5e}") for value in spectrum]


def starlight() -> sky.lobes.SkyLobe:
    """Stars and zodiacal light, equal from everywhere, the colour of the sun: 75 S10 on the whole sphere."""
    return sky.lobes.SkyLobe(kind="hg", width=0.0, spectrum=rounded(4 * np.pi * 75 * S10 * at_550(planck(5800.0))))


def airglow() -> sky.lobes.SkyLobe:
    """A glowing layer overhead: continuum and the lines of oxygen and sodium, 145 S10 at the zenith."""
    lines = 18.0 * line(557.7) + 4.0 * line(589.3) + 12.0 * line(630.0) + 4.0 * line(636.4)
    shape = at_550(0.6 * (WAVELENGTH_NM / 550.0) + lines)
    # the density of a GGX lobe in its axis is 1 / (pi alpha^2)
    return sky.lobes.SkyLobe(
        kind="ggx", width=AIRGLOW_WIDTH, spectrum=rounded(145 * S10 * np.pi * AIRGLOW_WIDTH**2 * shape)
    )


def city() -> list[sky.lobes.SkyLobe]:
    """The dome of a city at the horizon, dimmed to 0.6 between 22:00 and 23:30 local time."""
    lamps = at_550(0.15 + 12.0 * line(498.0) + 25.0 * line(569.0) + 45.0 * line(589.0) + 25.0 * line(616.0))
    natural = 220 * S10
    there = 0.01 * INHABITANTS * DISTANCE_KM**-2.5 * natural
    unit = sky.lobes.SkyLobe(**CITY, spectrum=np.ones_like(WAVELENGTH_NM))
    spectrum = rounded(there / density_at(unit, zenith_deg=45.0) * lamps)
    keys = ((0.0, 0.6), (16.5, 0.6), (17.0, 1.0), (22.0, 1.0), (23.5, 0.6))
    return [sky.lobes.SkyLobe(**CITY, spectrum=spectrum, time_days=hour / 24, factor=factor) for hour, factor in keys]


def density_at(lobe: sky.lobes.SkyLobe, *, zenith_deg: float) -> float:
    """Density of a lobe above its own azimuth. [sr-1]"""
    from aomc_sky.skies.lobes.file.data import axis_quaternion
    from aomc_sky.skies.lobes.lobe import to_local

    zenith, azimuth = np.deg2rad(zenith_deg), np.deg2rad(lobe.azimuth_deg)
    world = [np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)]
    local = to_local(axis_quaternion(lobe.zenith_deg, lobe.azimuth_deg), np.array(world))
    return float(sky.lobes.pdf(lobe.kind, lobe.width, lobe.width_y, local))


def main(folder: Path) -> None:
    """Write the file below a folder."""
    target = folder / "night_sky"
    target.mkdir(parents=True, exist_ok=True)
    file = sky.lobes.background_of_lobes(
        {"starlight": starlight(), "airglow": airglow(), "city": city()},
        WAVELENGTH_NM,
        name="a moonless night at the coast",
        author="inputs/make_night.py",
        description="Starlight with zodiacal light, airglow, and the glow of a city of 200 000 at 30 km",
    )
    sky.lobes.write_background(target / "night.h5", file)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
