"""Three numbers for the anisotropy of a molecule, and the depolarisation of dry air by wavelength.

gamma = rho / (2 - rho), rho = 2 gamma / (1 + gamma), F = (6 + 3 rho) / (6 - 7 rho) = 3 (1 + 2 gamma) / (3 - 4 gamma),
with gamma the anisotropy of the phase function, rho the depolarisation factor for natural light and F the King factor.
The table of air is as Bucholtz prints it [bucholtz1995] after Bates (1984): rho to three decimals of a percent. Between
its wavelengths rho is linear.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.phase.vectorised import checked, evaluate, precision_of


def gamma_from_rho(rho: ArrayLike) -> Any:
    """Anisotropy gamma of the phase function from the depolarisation factor rho. [both 0 to 1]

    Raises
    ------
    UsageError
        rho is outside 0 to 1 or NaN.

    Examples
    --------
    >>> print(f"{sky.rayleigh.gamma_from_rho(0.0279):.5f}")
    0.01415
    """
    kind = precision_of(rho)
    return evaluate(lambda x: (x / (2.0 - x),), kind, checked("rho", rho, kind, 0.0, 1.0))[0]


def rho_from_gamma(gamma: ArrayLike) -> Any:
    """Depolarisation factor rho for natural light from gamma. [both 0 to 1]

    Raises
    ------
    UsageError
        gamma is outside 0 to 1 or NaN.

    Examples
    --------
    >>> print(f"{sky.rayleigh.rho_from_gamma(0.0142):.4f}")
    0.0280
    """
    kind = precision_of(gamma)
    return evaluate(lambda x: ((x + x) / (1.0 + x),), kind, checked("gamma", gamma, kind, 0.0, 1.0))[0]


def king_factor(gamma: ArrayLike) -> Any:
    """King factor F of the scattering cross section. [1 at gamma 0, without bound towards gamma 3/4]

    Raises
    ------
    UsageError
        gamma is not in [0, 3/4): a symmetric polarisability has no larger one.

    Examples
    --------
    >>> print(f"{sky.rayleigh.king_factor(0.0142):.4f}")
    1.0482
    """
    kind = precision_of(gamma)
    g = checked("gamma", gamma, kind, 0.0, 0.75)
    if np.any(g == 0.75):
        raise UsageError("the King factor has a pole at gamma = 3/4; give a smaller gamma")
    return evaluate(lambda x: ((3.0 + 6.0 * x) / (3.0 - 4.0 * x),), kind, g)[0]


def gamma_from_king_factor(king: ArrayLike) -> Any:
    """Anisotropy gamma from the King factor, 3 (F - 1) / (4 F + 6). [F at least 1]

    Raises
    ------
    UsageError
        F is below 1, infinite or NaN.

    Examples
    --------
    >>> print(f"{sky.rayleigh.gamma_from_king_factor(1.049):.5f}")
    0.01442
    """
    kind = precision_of(king)
    F = checked("the King factor", king, kind, 1.0, float(np.finfo(kind).max))
    return evaluate(lambda x: (0.75 * ((x - 1.0) / (x + 1.5)),), kind, F)[0]


WAVELENGTH_NM = (
    200, 205, 210, 215, 220, 225, 230, 240, 250, 260, 270, 280,
    290, 300, 310, 320, 330, 340, 350, 360, 370, 380, 390, 400,
    450, 500, 550, 600, 650, 700, 750, 800, 850, 900, 950, 1000,
)  # fmt: skip
RHO_MILLI_PERCENT = (
    4545, 4384, 4221, 4113, 4004, 3895, 3785, 3675, 3565, 3455, 3400, 3289,
    3233, 3178, 3178, 3122, 3066, 3066, 3010, 3010, 3010, 2955, 2955, 2955,
    2899, 2842, 2842, 2786, 2786, 2786, 2786, 2730, 2730, 2730, 2730, 2730,
)  # fmt: skip
"""Depolarisation factor for natural light at these wavelengths. [1e-5]"""


def air_depolarisation(wavelength_nm: ArrayLike) -> Any:
    """Depolarisation factor rho of dry air for natural light.

    Parameters
    ----------
    wavelength_nm : array_like
        Wavelength in vacuum. [nm, 200 to 1000]

    Returns
    -------
    ndarray or scalar, float32 or float64
        rho. [0.0273 to 0.0455]

    Raises
    ------
    UsageError
        A wavelength is outside the table or NaN.

    Notes
    -----
    Accuracy: the table itself at its 36 wavelengths. Left out one by one, its inner rows come back within
    1.1 percent. The gas formulas of Bates, as Bodhaine et al. (1999) give them, differ by up to 2.6 percent.

    Examples
    --------
    >>> print(f"{sky.rayleigh.air_depolarisation(550.0):.5f}")
    0.02842
    """
    kind = precision_of(wavelength_nm)
    wavelength = checked("wavelength_nm", wavelength_nm, kind, float(WAVELENGTH_NM[0]), float(WAVELENGTH_NM[-1]))
    return evaluate(lambda x: (np.interp(x, WAVELENGTH_NM, RHO_MILLI_PERCENT) / 1e5,), kind, wavelength)[0]


def air_gamma(wavelength_nm: ArrayLike) -> Any:
    """Anisotropy gamma of dry air by wavelength; argument, accuracy and errors as for `air_depolarisation`.

    Examples
    --------
    >>> print(f"{sky.rayleigh.air_gamma(550.0):.5f}")
    0.01441
    """
    return gamma_from_rho(air_depolarisation(wavelength_nm))
