"""Write measured/sky.csv, a Perez sky in 150 directions, and measured/almucantar.alm, one as AERONET lays it out."""

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


#: The same for the almucantar; the sun sinks from scan to scan.
ALM_BANDS = ((440, 3.0, 260.0), (675, 4.0, 110.0), (870, 4.5, 60.0), (1020, 5.0, 40.0))
ALM_AZIMUTHS = [3, 3.5, *range(4, 8), *range(8, 20, 2), *range(20, 50, 5), *range(50, 100, 10), *range(100, 181, 20)]
ALM_HEAD = """\
AERONET Version 3
Invented_Site
Version 3: Raw Almucantar Level 1.5
The following data are invented: inputs/make_measured.py writes them from Perez skies
Contact: PI=nobody; PI Email=nobody
All points, UNITS: uW/cm^2/sr/nm
"""


def almucantar() -> str:
    """Four scans through the sun's zenith angle, one for each wavelength; -999 where a cloud hid the sky."""
    azimuth = np.array([-a for a in reversed(ALM_AZIMUTHS)] + ALM_AZIMUTHS)
    names = "AERONET_Site,Date(dd:mm:yyyy),Time(hh:mm:ss),Nominal_Wavelength(nm),Solar_Zenith_Angle(Degrees),"
    lines = [names + ",".join(f"{a:.6f}" for a in azimuth)]
    for k, (wavelength_nm, epsilon, irradiance) in enumerate(ALM_BANDS):
        zenith = 55.0 + 0.1 * k
        perez = sky.PerezSky(sun_zenith_deg=zenith, sun_azimuth_deg=0, epsilon=epsilon, delta=0.15)
        total = sky.FunctionSky(perez.radiance).irradiance(wavelength_nm)[0]
        light = perez.radiance(np.deg2rad(zenith), np.deg2rad(-azimuth), wavelength_nm) * irradiance / total / 10
        light[5] = -999  # mW m-2 over 10 is uW cm-2
        row = ["Invented_Site", "21:06:2026", f"15:0{k}:30", f"{wavelength_nm}", f"{zenith:.6f}"]
        lines.append(",".join([*row, *(f"{value:.6f}" for value in light)]))
    return ALM_HEAD + "\n".join(lines) + "\n"


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
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent) / "measured"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "sky.csv").write_bytes(measured().encode("ascii"))
    (folder / "almucantar.alm").write_bytes(almucantar().encode("ascii"))
