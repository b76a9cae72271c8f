"""Write measured/sky.csv, a Perez sky in 150 directions, and two of its scans as AERONET lays them out."""

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


#: The same for the scans of AERONET; the sun sinks from scan to scan.
SCAN_BANDS = ((440, 3.0, 260.0), (675, 4.0, 110.0), (870, 4.5, 60.0), (1020, 5.0, 40.0))
_AWAY = [3, 3.5, *range(4, 7), 6, 7, *range(8, 20, 2), *range(20, 50, 5), *range(50, 100, 10), *range(100, 181, 20)]
AZIMUTHS = np.array([0, *(-angle for angle in reversed(_AWAY)), *_AWAY], float)
"""From the sun; the sun itself is a gap, and 6 comes twice, as in public files. [deg]"""
IN_PLANE = np.array([-6, -5, -4, -3.5, -3, 0, *_AWAY[:-3]], float)
"""From the sun through the zenith. [deg]"""
HEAD_OF_SCANS = """\
AERONET Version 3
Invented_Site
Version 3: Raw {0} Level 1.5
The following data are invented: inputs/make_measured.py writes them from Perez skies
Contact: PI=nobody; PI Email=nobody
All points, UNITS: uW/cm^2/sr/nm
"""
_FIRST = "AERONET_Site,Date(dd:mm:yyyy),Time(hh:mm:ss),Instrument_Number,Nominal_Wavelength(nm),Exact_Wavelength(um)"
NAMES = f"{_FIRST},Solar_Zenith_Angle(Degrees),Sky_Scan_Type".split(",")
PLACE = {"Latitude(Degrees)": "0.000000", "Longitude(Degrees)": "0.000000", "Elevation(m)": "0.000000"}
BLOCKS = ("Radiance_for_Azimuth_Angle_in_Degrees(uW/cm^2/sr/nm)", "Scattering_Angle_for_Nominal_Azimuth_Angle(Degrees)")


def scan(kind: str, minute: int, angles: np.ndarray, gap: int) -> list[tuple[list[str], np.ndarray, np.ndarray]]:
    """First cells, radiances and scattering angles, a row for each wavelength; -999 where a cloud hid the sky."""
    rows = []
    for k, (wavelength_nm, epsilon, irradiance) in enumerate(SCAN_BANDS):
        sun = 55.0 + 0.1 * (k + minute)
        perez = sky.PerezSky(sun_zenith_deg=sun, sun_azimuth_deg=0, epsilon=epsilon, delta=0.15)
        total = sky.FunctionSky(perez.radiance).irradiance(wavelength_nm)[0]
        zenith, azimuth = (np.full_like(angles, sun), angles) if kind == "Almucantar" else (sun - angles, 0 * angles)
        direction = np.deg2rad(np.abs(zenith)), np.deg2rad(np.where(zenith < 0, 180, -azimuth))
        light = perez.radiance(*direction, wavelength_nm) * irradiance / total / 10  # mW m-2 over 10 is uW cm-2
        light[[gap, *np.flatnonzero(angles == 0)]] = -999
        z, a, s = np.deg2rad(np.abs(zenith)), direction[1], np.deg2rad(sun)
        apart = np.rad2deg(np.arccos(np.clip(np.cos(z) * np.cos(s) + np.sin(z) * np.sin(s) * np.cos(a), -1, 1)))
        time = f"15:{k + minute:02}:30"
        first = ["Invented_Site", "21:06:2026", time, "1", f"{wavelength_nm}", f"{wavelength_nm / 1e3:.6f}"]
        rows.append(([*first, f"{sun:.6f}", kind], light, apart))
    return rows


def _text(rows: list[list[str]]) -> str:
    return "".join(",".join(row) + "\n" for row in rows)


def _numbers(numbers: np.ndarray) -> list[str]:
    return [f"{number:.6f}" for number in numbers]


def almucantar() -> str:
    """In the layout of today's files: a row of blocks, a place, and scattering angles behind the radiances."""
    nominal = _numbers(AZIMUTHS)
    above = [""] * (len(NAMES) + len(PLACE)) + [name for name in BLOCKS for _ in nominal]
    rows = [above, [*NAMES, *PLACE, *nominal, *nominal]]
    for first, light, apart in scan("Almucantar", 0, AZIMUTHS, 6):
        rows.append([*first, *PLACE.values(), *_numbers(light), *_numbers(apart)])
    return HEAD_OF_SCANS.format("Almucantar") + _text(rows)


def principal_plane() -> str:
    """In the layout of files of 2019: radiances alone, below one row of names that ends in a comma."""
    rows = [[*NAMES, *_numbers(IN_PLANE), ""]]
    rows += [[*first, *_numbers(light)] for first, light, _ in scan("Principal Plane", 4, IN_PLANE, 9)]
    return HEAD_OF_SCANS.format("Principal Plane") + _text(rows)


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
    (folder / "principal_plane.ppl").write_bytes(principal_plane().encode("ascii"))
