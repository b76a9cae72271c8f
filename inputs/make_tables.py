"""Write tables of atmosphere/: `python inputs/make_tables.py sun ozone phase`, with pvlib and miepython 3 from PyPI.

`sun`: the extraterrestrial column of ASTM G173-03, which pvlib carries, as means over bins of 1 nm, 280 to 2500 nm.
`ozone`: cross sections of ozone, 380 to 910 nm: round numbers up to 720 nm, then those of SPCTRL2 (Bird and Riordan
1986), which pvlib carries. Its coefficients are taken from the direct light that it gives without ozone and with it.
`phase`: phase functions of sea salt and of continental aerosol, Mie scattering by lognormal modes of OPAC (Hess,
Koepke and Schult 1998, table 1) at a relative humidity of 80 %. Soluble particles are wet: `GROWTH` times as large as
dry ones, with the refractive index mixed by volume with water's 1.333.
One refractive index of each kind, that of green light, serves all wavelengths.
"""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent / "atmosphere"
WATER = 1.333
WAVELENGTH_NM = (380, 400, 500, 600, 700, 800, 900)
LARGEST_UM = 20.0
_STEPS = ((0.0, 0.1), (2.0, 0.25), (10.0, 0.5), (30.0, 1.0), (180.0, 0.0))
ANGLE_DEG = np.append(
    np.concatenate([np.arange(low, high, step) for (low, step), (high, _) in pairwise(_STEPS)]),
    180.0,
)

ATM_CM_M2 = 2.687e23
"""Molecules per m2 of a gas of 1 cm at 0 degrees and 1013.25 hPa: 1000 Dobson units."""
OZONE_ROUND = (
    "380,5e-29 400,1.1e-27 420,3e-27 440,1.3e-26 450,1.7e-26 460,3.5e-26 480,7e-26 500,1.2e-25 520,1.8e-25 540,2.9e-25 "
    "560,3.9e-25 575,4.8e-25 590,4.5e-25 603,5.2e-25 620,4e-25 640,2.9e-25 660,2.1e-25 680,1.35e-25 700,8.7e-26 "
    "720,6e-26"
)
"""Rows of the table of ozone up to 720 nm: wavelength [nm], cross section [m2]."""
OZONE_TAIL_NM = (780, 800, 820, 840, 860, 880, 910)
"""Wavelengths of the table of ozone where SPCTRL2 has none. The last bin of a description to 900 nm ends at 910 nm."""


@dataclass(frozen=True, kw_only=True)
class Mode:
    """Particles of one kind: number per volume [any unit], dry mode radius [um], width, refractive index, growth."""

    number: float
    radius_um: float
    sigma: float
    index: complex
    growth: float = 1.0

    def wet(self) -> tuple[float, complex]:
        """Radius [um] and refractive index with the water."""
        dry = self.growth**-3
        return self.radius_um * self.growth, dry * self.index + (1.0 - dry) * WATER


SEA_SALT = (
    Mode(number=20.0, radius_um=0.209, sigma=2.03, index=1.50 - 1e-8j, growth=2.0),
    Mode(number=3.2e-3, radius_um=1.75, sigma=2.03, index=1.50 - 1e-8j, growth=2.0),
)
CONTINENTAL = (
    Mode(number=7000.0, radius_um=0.0212, sigma=2.24, index=1.53 - 0.006j, growth=1.44),
    Mode(number=0.4, radius_um=0.471, sigma=2.51, index=1.53 - 0.008j),
    Mode(number=8300.0, radius_um=0.0118, sigma=2.00, index=1.75 - 0.44j),
)


def mie(
    modes: tuple[Mode, ...], nm: float, angle_deg: np.ndarray, n_radius: int = 2000
) -> tuple[np.ndarray, float, float]:
    """Phase function at angles [sr-1], extinction of a mean particle [um2] and single scattering albedo.

    The norm is that of the efficiencies for scattering, so it does not depend on the angles.
    """
    import miepython

    mu = np.cos(np.radians(angle_deg))
    total, scattering, extinction = np.zeros(mu.size), 0.0, 0.0
    for mode in modes:
        middle, index = mode.wet()
        spread = np.log(mode.sigma)
        x = np.linspace(-4.0 * spread, min(8.0 * spread, np.log(LARGEST_UM / middle)), n_radius)
        share = mode.number * np.exp(-0.5 * (x / spread) ** 2) / (spread * np.sqrt(2.0 * np.pi)) * (x[1] - x[0])
        share[[0, -1]] *= 0.5
        for n, radius in zip(share, middle * np.exp(x), strict=True):
            size = 2.0 * np.pi * radius / (nm / 1000.0)
            area = n * np.pi * radius**2
            q_extinction, q_scattering, _, _ = miepython.efficiencies_mx(index, size)
            total += area * miepython.i_unpolarized(index, size, mu, norm="qsca")
            scattering += area * q_scattering
            extinction += area * q_extinction
    return total / scattering, extinction / sum(mode.number for mode in modes), scattering / extinction


def write_phase(name: str, title: str, modes: tuple[Mode, ...]) -> None:
    """Write a table of one kind of aerosol."""
    import miepython  # fast where the environment has MIEPYTHON_USE_JIT=1

    found = [mie(modes, nm, ANGLE_DEG) for nm in WAVELENGTH_NM]
    lines = [f"# Phase function of {title} [sr-1]: Mie scattering by miepython {miepython.__version__},"]
    lines += ["# modes in inputs/make_tables.py, which wrote this file; integral 1 over the sphere"]
    for nm, (_, extinction, albedo) in zip(WAVELENGTH_NM, found, strict=True):
        lines += [f"# {nm} nm: extinction {extinction:.5g} um^2 a particle, single scattering albedo {albedo:.4f}"]
    lines += [f"angle [deg], {', '.join(str(nm) for nm in WAVELENGTH_NM)}"]
    for k, angle in enumerate(ANGLE_DEG):
        lines += [f"{angle:g}, " + ", ".join(f"{column[k]:.5g}" for column, _, _ in found)]
    path = FOLDER / "phase" / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(path, hashlib.sha256(path.read_bytes()).hexdigest())


def write_sun() -> None:
    """Write the measured spectrum of the sun."""
    import pvlib

    source = Path(pvlib.__file__).parent / "data" / "ASTMG173.csv"
    table = pvlib.spectrum.get_reference_spectra()["extraterrestrial"]
    x, y = table.index.to_numpy(float), table.to_numpy(float)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(x))])

    def upto(w: np.ndarray) -> np.ndarray:
        k = np.clip(np.searchsorted(x, w, "right") - 1, 0, x.size - 2)
        return area[k] + 0.5 * (w - x[k]) * (y[k] + np.interp(w, x, y))

    w = np.arange(280.0, 2501.0)
    low, high = np.maximum(w - 0.5, x[0]), w + 0.5
    mean = (upto(high) - upto(low)) / (high - low)
    head = [
        "# Irradiance of the sun outside the atmosphere at 1 AU: wavelength [nm], W m-2 nm-1, means over bins of 1 nm.",
        "# Source: extraterrestrial column of ASTM G173-03, joined of measurements by Gueymard (2004);",
        f"# file data/ASTMG173.csv of pvlib {pvlib.__version__}, SHA-256",
        f"# {hashlib.sha256(source.read_bytes()).hexdigest()}",
    ]
    path = FOLDER / "spectra" / "sun_astm_g173.csv"
    path.write_text("\n".join(head + [f"{a:g},{b:.5g}" for a, b in zip(w, mean, strict=True)]) + "\n", encoding="utf-8")
    print(path, hashlib.sha256(path.read_bytes()).hexdigest())


def spctrl2_ozone() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths [nm] and absorption coefficients [atm-cm-1, base e] of ozone in SPCTRL2."""
    import pvlib

    # With the sun in the zenith the way through the ozone is the column to 1e-5.
    air = {
        "apparent_zenith": 0.0, "aoi": 0.0, "surface_tilt": 0.0, "ground_albedo": 0.0, "surface_pressure": 101300.0,
        "relative_airmass": 1.0, "precipitable_water": 0.0, "aerosol_turbidity_500nm": 0.0, "dayofyear": 1,
    }  # fmt: skip
    without, with_ozone = (pvlib.spectrum.spectrl2(ozone=column, **air) for column in (0.0, 1.0))
    return without["wavelength"], np.log(without["dni"] / with_ozone["dni"]).ravel()


def write_ozone() -> None:
    """Write the cross sections of ozone."""
    import pvlib

    w, coefficient = spctrl2_ozone()
    known = (w > 720.0) & (coefficient > 1e-6)
    rows = [f"{a:g},{b:.2g}" for a, b in zip(w[known], coefficient[known] / ATM_CM_M2, strict=True)]
    # A zero would make the values between two wavelengths linear instead of logarithmic, at all wavelengths.
    tail = np.array(OZONE_TAIL_NM)
    first, last = coefficient[known][-1], 0.0005
    share = (tail - w[known][-1]) / (tail[-1] - w[known][-1])
    rows += [f"{a},{b:.2g}" for a, b in zip(tail, first * (last / first) ** share / ATM_CM_M2, strict=True)]
    head = [
        "# Ozone near 230 K: absorption cross section by wavelength. An example, not for retrievals.",
        "# Written by inputs/make_tables.py. All values are rounded to two digits or less (680 nm: three).",
        "# Up to 720 nm: after the course of laboratory spectra (Gorshelev et al. 2014).",
        "# 724.4 to 767.5 nm: absorption coefficients of SPCTRL2 (Bird and Riordan 1986),",
        f"# as pvlib {pvlib.__version__} has them.",
        "# From 780 nm on SPCTRL2 has 0. Here the values fall geometrically, to half of its last digit at 910 nm.",
        "# Laboratory spectra have up to 1.1e-26 m2 more at 780 to 830 nm: an optical depth of 0.001.",
        "# Wavelength [nm], m2.",
    ]
    path = FOLDER / "spectra" / "ozone.csv"
    path.write_text("\n".join(head + OZONE_ROUND.split() + rows) + "\n", encoding="utf-8")
    print(path, hashlib.sha256(path.read_bytes()).hexdigest())


def main(words: list[str]) -> None:
    """Write what the words name."""
    if "sun" in words:
        write_sun()
    if "ozone" in words:
        write_ozone()
    if "phase" in words:
        (FOLDER / "phase").mkdir(exist_ok=True)
        write_phase("sea_salt.csv", "sea salt at a relative humidity of 80 %", SEA_SALT)
        write_phase("continental.csv", "continental average aerosol at a relative humidity of 80 %", CONTINENTAL)


if __name__ == "__main__":
    main(sys.argv[1:])
