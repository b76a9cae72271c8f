"""Rayleigh scattering of dry air as Bodhaine, Wood, Dutton and Slusser (1999) give it, apart from the package.

The refractive index is that of Peck and Reeder (1972), the depolarisation that of Bates (1984), equations as numbered
in the paper (J. Atmos. Oceanic Technol. 16, 1854).
"""

import numpy as np

MOLECULES_M3 = 2.546899e25
"""At 288.15 K and 1013.25 hPa."""

CO2_PER_MILLION = 360.0
"""Of the paper's table 3 and of its fit."""


def refractive_index(wavelength_um, co2_per_million=CO2_PER_MILLION):
    """Of standard air with this share of CO2: Peck and Reeder's at 300 per million and its correction."""
    square = np.asarray(wavelength_um) ** -2.0
    at_300 = (8060.51 + 2480990.0 / (132.274 - square) + 17455.7 / (39.32957 - square)) * 1e-8
    return 1.0 + at_300 * (1.0 + 0.54 * (co2_per_million - 300.0) * 1e-6)


def king_factor(wavelength_um, co2_per_million=CO2_PER_MILLION):
    """Of air from those of its gases, equations 5, 6 and 23."""
    square = np.asarray(wavelength_um) ** -2.0
    nitrogen = 1.034 + 3.17e-4 * square
    oxygen = 1.096 + 1.385e-3 * square + 1.448e-4 * square**2
    co2 = co2_per_million * 1e-4  # percent
    total = 78.084 * nitrogen + 20.946 * oxygen + 0.934 * 1.0 + co2 * 1.15
    return total / (78.084 + 20.946 + 0.934 + co2)


def cross_section_m2(wavelength_um, co2_per_million=CO2_PER_MILLION):
    """Of one molecule, equation 22. [m2]"""
    square_index = refractive_index(wavelength_um, co2_per_million) ** 2
    wavelength_m = np.asarray(wavelength_um) * 1e-6
    lorentz = ((square_index - 1.0) / (square_index + 2.0)) ** 2
    return 24.0 * np.pi**3 * lorentz / (wavelength_m**4 * MOLECULES_M3**2) * king_factor(wavelength_um, co2_per_million)


def _rational(wavelength_um):
    square = np.asarray(wavelength_um) ** 2
    return (1.0455996 - 341.29061 / square - 0.90230850 * square) / (1.0 + 0.0027059889 / square - 85.968563 * square)


def fitted_cross_section_m2(wavelength_um):
    """The paper's own fit to its table of cross sections, equation 29. [m2]"""
    return 1e-32 * _rational(wavelength_um)


def fitted_optical_depth(wavelength_um):
    """The paper's fit to the optical depth of air at sea level, 1013.25 hPa and 45 degrees north, equation 30."""
    return 0.0021520 * _rational(wavelength_um)
