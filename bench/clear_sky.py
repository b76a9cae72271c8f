"""The light of a cloudless sky: SPCTRL2 (`--spectrum spectrl2`) beside multiple scattering by PythonicDISORT.

    python bench/clear_sky.py [--irradiance]

Two plane layers: molecules above 2 km; below it molecules with all aerosol. The molecules have the optical depth of
Bodhaine et al. (1999) and depolarisation 0.029. The aerosol is that of SPCTRL2: optical depths 0, 0.1 and 0.3 at 500
nm, exponent 1.14, single scattering albedo 0.945 at 400 nm, g = 0.65 (here by Henyey and Greenstein). Water 1.4 cm,
ozone 0.3 cm, albedo of the ground 0.06. The sun's spectrum and what gases absorb are those of SPCTRL2, so that
scattering alone is compared.

Printed is SPCTRL2 over DISORT less 1 in per cent: direct / diffuse / both, on a horizontal plane. The path of the beam
is 1 / cos Z in plane layers and the air mass of Kasten and Young in SPCTRL2: at 80° the round earth is in the
difference of the direct light. 32 streams change 0.01 %, 48 layers 0.5 %. Light is not polarised. `--irradiance` prints
both in W m-2 nm-1 for 12 suns, at the mean distance of the sun.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
import pvlib  # type: ignore[import-untyped]
from PythonicDISORT.pydisort import pydisort  # type: ignore[import-untyped]

NM = np.array([412.0, 443.0, 490.0, 555.0, 670.0])
TURBIDITIES, SUNS_DEG = (0.0, 0.1, 0.3), (0.0, 30.0, 50.0, 70.0, 80.0)  #: Optical depths of the aerosol at 500 nm.
CLASSES = {"0° to 50°": (0.0, 30.0, 50.0), "70°": (70.0,), "80°": (80.0,)}
ALBEDO, ASYMMETRY, N_STREAMS = 0.06, 0.65, 16
BELOW = 0.22  #: Share of the molecules below 2 km.
SECOND_MOMENT = 0.0957  #: Of the molecules' phase function: (1 - y) / (10 (1 + 2 y)), y = 0.029 / (2 - 0.029).
MEAN_DISTANCE_DAY = 93


def molecules(um: np.ndarray) -> np.ndarray:
    """Optical depth by Bodhaine et al. (1999), eq. (30): sea level, 45 degrees of latitude."""
    above, below = 1.0455996 - 341.29061 / um**2 - 0.90230850 * um**2, 1.0 + 0.0027059889 / um**2 - 85.968563 * um**2
    return 0.0021520 * above / below


def aerosol(um: np.ndarray, turbidity: float) -> np.ndarray:
    return turbidity * (um / 0.5) ** -1.14


def by_spctrl2(turbidity: float, sun_zenith_deg: float) -> np.ndarray:
    """Direct and diffuse horizontal irradiance, and the sun's times the transmittance of all gases."""
    zenith, air_mass = np.array([sun_zenith_deg]), float(pvlib.atmosphere.get_relative_airmass(sun_zenith_deg))
    found = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith, aoi=zenith, surface_tilt=0.0, ground_albedo=ALBEDO, surface_pressure=101_325.0,
        relative_airmass=air_mass, precipitable_water=1.4, ozone=0.3, aerosol_turbidity_500nm=turbidity,
        dayofyear=MEAN_DISTANCE_DAY,
    )  # fmt: skip
    nm, outside, beam = np.ravel(found["wavelength"]), found["dni_extra"][:, 0], found["dni"][:, 0]
    um = nm / 1000.0
    its_molecules = 1.01325 / 1.013 / (um**4 * (115.6406 - 1.3366 / um**2))
    gases = beam * np.exp(air_mass * (its_molecules + aerosol(um, turbidity)))
    light = np.array([beam * math.cos(math.radians(sun_zenith_deg)), found["dhi"][:, 0], gases])
    return np.interp(NM, nm, outside) * np.array([np.interp(NM, nm, one) for one in light / outside])


def by_disort(turbidity: float, sun_zenith_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Direct and diffuse horizontal irradiance for a beam of 1."""
    um, orders = NM / 1000.0, np.arange(N_STREAMS + 1)
    rayleigh = np.where(orders == 0, 1.0, np.where(orders == 2, SECOND_MOMENT, 0.0))
    scattered = 0.945 * np.exp(-0.095 * np.log(um / 0.4) ** 2)
    light = []
    for molecule_depth, aerosol_depth, single in zip(molecules(um), aerosol(um, turbidity), scattered, strict=True):
        layers = molecule_depth * np.array([1 - BELOW, BELOW]) + np.array([0.0, aerosol_depth])
        scattering = layers - np.array([0.0, (1 - single) * aerosol_depth])
        share = np.array([0.0, single * aerosol_depth / scattering[1]])[:, None]
        legendre = share * ASYMMETRY**orders + (1 - share) * rayleigh
        total = np.cumsum(layers)
        _, _, flux_down, *_ = pydisort(
            total, np.minimum(scattering / layers, 1 - 1e-6), N_STREAMS, legendre,
            math.cos(math.radians(sun_zenith_deg)), 1.0, 0.0, only_flux=True, f_arr=legendre[:, -1],
            BDRF_Fourier_modes=[ALBEDO],  # not over pi: only so does the ground send ALBEDO of its light up
        )  # fmt: skip
        light.append(flux_down(total[-1]))
    diffuse, direct = np.array(light).T
    return direct, diffuse


def both(turbidity: float, sun_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Direct, diffuse and global irradiance at all wavelengths: by SPCTRL2, by DISORT."""
    direct, diffuse, gases = by_spctrl2(turbidity, sun_deg)
    exact = np.array(by_disort(turbidity, sun_deg)) * gases
    ours = np.array([direct, diffuse])
    return np.vstack([ours, ours.sum(axis=0)]), np.vstack([exact, exact.sum(axis=0)])


def print_differences() -> None:
    print("| aerosol | sun | 412 | 443 | 490 | 555 | 670 |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    largest = {name: np.zeros(3) for name in CLASSES}
    for turbidity in TURBIDITIES:
        for name, suns_deg in CLASSES.items():
            for sun_deg in suns_deg:
                ours, exact = both(turbidity, sun_deg)
                off = 100 * (ours / exact - 1)
                cells = (" / ".join(f"{one:+.1f}" for one in band) for band in off.T)
                print(f"| {turbidity:g} | {sun_deg:g}° | {' | '.join(cells)} |")
                pair = np.column_stack([largest[name], off])
                largest[name] = pair[np.arange(3), np.abs(pair).argmax(axis=1)]
    found = (f"{name}: {' / '.join(f'{one:+.1f}' for one in off)}" for name, off in largest.items())
    print(f"Largest differences, direct / diffuse / both. {'; '.join(found)} %.")


def print_irradiance(turbidity: float = 0.1) -> None:
    print("| sun | 443, SPCTRL2 | DISORT | 555, SPCTRL2 | DISORT |")
    print("| --- | --- | --- | --- | --- |")
    for sun_deg in np.linspace(0.0, 82.5, 12).tolist():
        ours, exact = (one[2] for one in both(turbidity, sun_deg))
        print(f"| {sun_deg:g}° | {ours[1]:.4f} | {exact[1]:.4f} | {ours[3]:.4f} | {exact[3]:.4f} |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="SPCTRL2 beside PythonicDISORT")
    parser.add_argument("--irradiance", action="store_true", help="irradiances for 12 suns instead of differences")
    print_irradiance() if parser.parse_args().irradiance else print_differences()
