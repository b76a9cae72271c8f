"""Scattering cross section of a gas from its refractive index: what ``cross section at 1 um`` wants."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError

BOLTZMANN_J_K = 1.380649e-23
"""Boltzmann constant. [J K-1, exact in the SI since 2019]"""


def rayleigh_cross_section(
    refractive_index: ArrayLike,
    temperature_k: ArrayLike,
    pressure_pa: ArrayLike,
    *,
    wavelength_nm: ArrayLike = 1000.0,
    king_factor: ArrayLike = 1.0,
) -> Any:
    """Rayleigh scattering cross section of one molecule of an ideal gas.

    sigma = (8 pi^3 / 3) (n^2 - 1)^2 / lambda^4 (k T / p)^2 F, equation (120.4) of [landau1984] with h = sigma N, the
    form in which the description of an atmosphere asks for it; F is the King factor of anisotropic molecules,
    1 by default as there. Arguments broadcast.

    Parameters
    ----------
    refractive_index : array_like
        n of the gas at this wavelength, temperature and pressure. [1 to 2]
    temperature_k, pressure_pa : array_like
        At which n was measured. [K and Pa, > 0]
    wavelength_nm : array_like
        Wavelength in vacuum. [nm, > 0]
    king_factor : array_like
        (6 + 3 rho) / (6 - 7 rho) of the depolarisation factor rho. [1 or more; 1.049 for air at 550 nm]

    Returns
    -------
    ndarray or scalar, float64
        sigma. [m2]

    Raises
    ------
    UsageError
        An argument is outside its range, infinite or NaN.

    Notes
    -----
    Accuracy: 2e-15 relative for the given float64 numbers, also where n - 1 is tiny; n itself is commonly known
    to 1e-8, which is 4e-5 of n - 1 and so 7e-5 of sigma for air.
    """
    n = _checked("the refractive index", refractive_index, 1.0, 2.0)
    temperature = _checked("the temperature", temperature_k, np.nextafter(0.0, 1.0), 1e9)
    pressure = _checked("the pressure", pressure_pa, np.nextafter(0.0, 1.0), 1e15)
    wavelength = _checked("the wavelength", wavelength_nm, np.nextafter(0.0, 1.0), 1e12) * 1e-9
    king = _checked("the King factor", king_factor, 1.0, 1e3)
    # n - 1 is exact in float64 for n below 2, n^2 - 1 would lose half of the digits
    per_density = (n - 1.0) * (n + 1.0) * (BOLTZMANN_J_K * temperature / pressure)
    return 8.0 * np.pi**3 / 3.0 * np.square(per_density / np.square(wavelength)) * king


def _checked(name: str, value: ArrayLike, low: float, high: float) -> Any:
    array = np.asarray(value, np.float64)
    if not np.all((array >= low) & (array <= high)):
        raise UsageError(f"{name} must lie between {low:g} and {high:g}")
    return array[()]
