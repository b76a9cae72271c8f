"""Write measured/sky.csv: a Perez sky as an instrument would see it in 150 irregular directions."""

import sys
from pathlib import Path

import numpy as np

import aomc_sky as sky

SUN_ZENITH_DEG, SUN_AZIMUTH_DEG = 40.0, 135.0  # the azimuth from east towards north: the sun stands in the north-west
#: Wavelength [nm], clearness, and diffuse irradiance of the horizontal plane [mW m-2 nm-1]: invented, but like a day's.
BANDS = ((412, 1.8, 310.0), (490, 2.3, 270.0), (555, 2.6, 215.0), (670, 3.0, 130.0))
HEAD = """\
# an invented instrument, 2026-06-21 15:00Z; inputs/make_measured.py writes it from Perez skies
# azimuth: clockwise from north
# radiance unit: mW m-2 nm-1 sr-1
# sun zenith: 40
# sun azimuth: 315 clockwise from north
"""


def measured(n: int = 150, seed: int = 1) -> str:
    """The table, one column for each wavelength; a cloud hid two directions."""
    rng = np.random.default_rng(seed)
    zenith = np.round(np.rad2deg(np.arccos(rng.uniform(np.cos(np.deg2rad(86)), 1, n))), 1)
    azimuth = np.round(rng.uniform(0, 360, n), 1)
    columns = [zenith, azimuth]
    for wavelength_nm, epsilon, irradiance in BANDS:
        perez = sky.PerezSky(sun_zenith_deg=SUN_ZENITH_DEG, sun_azimuth_deg=SUN_AZIMUTH_DEG, epsilon=epsilon, delta=0.2)
        total = sky.FunctionSky(perez.radiance).irradiance(wavelength_nm)[0]
        light = perez.radiance(np.deg2rad(zenith), np.deg2rad(90 - azimuth), wavelength_nm)
        columns.append(light * irradiance / total)
    names = ",".join(["zenith_deg", "azimuth_deg", *(f"L_{band[0]}" for band in BANDS)])
    rows = [[f"{row[0]:.1f}", f"{row[1]:.1f}", *(f"{value:.4g}" for value in row[2:])] for row in np.transpose(columns)]
    rows[17][2:] = rows[92][2:] = [""] * len(BANDS)
    return "\n".join([HEAD + names, *map(",".join, rows)]) + "\n"


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent) / "measured" / "sky.csv"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(measured().encode("ascii"))
