"""Rayleigh scattering: p(mu) = 3/8 [(1 + 3 gamma) + (1 - gamma) mu^2] / (1 + 2 gamma) [bucholtz1995].

gamma = 0 is the classical 3/8 (1 + mu^2), gamma = 1 is isotropic. Arguments broadcast. float32 arrays give float32,
worked out in float64; everything else gives float64; scalars give numpy scalars. `aomc_sky.kernels.phase.jitted` has
the jitted forms, with the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.kernels.phase import rayleigh as formulas
from aomc_sky.phase.vectorised import checked, evaluate, precision_of

__all__ = [
    "air_depolarisation",
    "air_gamma",
    "cdf_mu",
    "gamma_from_king_factor",
    "gamma_from_rho",
    "king_factor",
    "mean_mu2",
    "pdf_mu",
    "pdf_sr",
    "rho_from_gamma",
    "sample_mu",
    "sample_mu_sin",
]

_INV_2PI = 0.15915494309189535


def _arguments(name: str, value: ArrayLike, low: float, gamma: ArrayLike) -> tuple[np.dtype[Any], Any, Any]:
    kind = precision_of(value, gamma)
    return kind, checked(name, value, kind, low, 1.0), checked("gamma", gamma, kind, 0.0, 1.0)


def sample_mu(xi: ArrayLike, gamma: ArrayLike) -> Any:
    """Cosine of the scattering angle whose cumulated probability is xi.

    Parameters
    ----------
    xi : array_like
        Probability of a smaller mu; uniform numbers give Rayleigh's law. [0 to 1]
    gamma : array_like
        Molecular anisotropy. [0 to 1]

    Returns
    -------
    ndarray or scalar, float32 or float64
        mu. [-1 to 1, both ends exact]

    Raises
    ------
    UsageError
        An argument is outside its range or NaN.

    Notes
    -----
    Accuracy: within 4 ulp everywhere, also beside xi = 1/2, where mu is small, and for gamma up to 1. With
    float32, rounded from float64. Cost: two divisions for each number, no root and no branch.

    Examples
    --------
    >>> print(sky.rayleigh.sample_mu([0.0, 0.5, 1.0], 0.0142))
    [-1.  0.  1.]
    """
    return evaluate(formulas.cosine, *_arguments("xi", xi, 0.0, gamma))[0]


def sample_mu_sin(xi: ArrayLike, gamma: ArrayLike) -> tuple[Any, Any, Any]:
    """`sample_mu` with 1 - mu and the sine, which keep their digits beside mu = 1 and -1.

    Parameters
    ----------
    xi, gamma : array_like
        As for `sample_mu`.

    Returns
    -------
    mu, one_minus_mu, sin_theta : ndarray or scalar, float32 or float64
        mu within 4 ulp, the others within 6 ulp.

    Raises
    ------
    UsageError
        An argument is outside its range or NaN.

    Examples
    --------
    >>> mu, one_minus_mu, sin_theta = sky.rayleigh.sample_mu_sin(0.5, 0.0142)
    >>> print(mu, one_minus_mu, sin_theta)
    0.0 1.0 1.0
    """
    mu, one_minus_mu, sin_theta = evaluate(formulas.cosine_and_ends, *_arguments("xi", xi, 0.0, gamma))
    return mu, one_minus_mu, sin_theta


def pdf_mu(mu: ArrayLike, gamma: ArrayLike) -> Any:
    """Density over mu, normalised to 1 on [-1, 1]; twice it has mean 1 over the sphere.

    Parameters
    ----------
    mu : array_like
        Cosine of the scattering angle. [-1 to 1]
    gamma : array_like
        Molecular anisotropy. [0 to 1]

    Returns
    -------
    ndarray or scalar, float32 or float64
        Within 5 ulp.

    Raises
    ------
    UsageError
        An argument is outside its range or NaN.

    Examples
    --------
    >>> print(sky.rayleigh.pdf_mu([0.0, 1.0], 0.0))
    [0.375 0.75 ]
    """
    return evaluate(formulas.density, *_arguments("mu", mu, -1.0, gamma))[0]


def pdf_sr(mu: ArrayLike, gamma: ArrayLike) -> Any:
    """Density per steradian, `pdf_mu` over 2 pi. [sr-1]; arguments and errors as there. Within 6 ulp.

    Examples
    --------
    >>> print(f"{sky.rayleigh.pdf_sr(1.0, 1.0):.6f}")  # gamma = 1 is isotropic: 1 / (4 pi)
    0.079577
    """
    return evaluate(lambda *given: _INV_2PI * formulas.density(*given), *_arguments("mu", mu, -1.0, gamma))[0]


def cdf_mu(mu: ArrayLike, gamma: ArrayLike) -> Any:
    """Probability of a smaller mu; arguments and errors as for `pdf_mu`.

    Within 6 ulp, also where it is small beside mu = -1.

    Examples
    --------
    >>> print(sky.rayleigh.cdf_mu([-1.0, 0.0, 1.0], 0.0))
    [0.  0.5 1. ]
    """
    return evaluate(formulas.cumulated, *_arguments("mu", mu, -1.0, gamma))[0]


def _mapped(law: Callable[[Any], Any], name: str, value: ArrayLike, low: float, high: float) -> Any:
    kind = precision_of(value)
    return evaluate(law, kind, checked(name, value, kind, low, high))[0]


def mean_mu2(gamma: ArrayLike) -> Any:
    """Mean of mu^2, (2 + 3 gamma) / (5 (1 + 2 gamma)). The mean of mu is 0.

    Examples
    --------
    >>> print(sky.rayleigh.mean_mu2(0.0))
    0.4
    """
    return _mapped(lambda x: (2.0 + 3.0 * x) / (5.0 + 10.0 * x), "gamma", gamma, 0.0, 1.0)


# Anisotropy of a molecule: gamma = rho / (2 - rho), rho = 2 gamma / (1 + gamma).
# F = (6 + 3 rho) / (6 - 7 rho) = 3 (1 + 2 gamma) / (3 - 4 gamma).


def gamma_from_rho(rho: ArrayLike) -> Any:
    """Anisotropy gamma of the phase function from the depolarisation factor rho for natural light. [both 0 to 1]

    Raises
    ------
    UsageError
        rho is outside 0 to 1 or NaN.

    Examples
    --------
    >>> print(f"{sky.rayleigh.gamma_from_rho(0.0279):.5f}")
    0.01415
    """
    return _mapped(lambda x: x / (2.0 - x), "rho", rho, 0.0, 1.0)


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
    return _mapped(lambda x: (x + x) / (1.0 + x), "gamma", gamma, 0.0, 1.0)


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
        raise UsageError("the King factor has a pole at gamma = 3/4", "give a smaller gamma")
    return evaluate(lambda x: (3.0 + 6.0 * x) / (3.0 - 4.0 * x), kind, g)[0]


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
    most = float(np.finfo(precision_of(king)).max)
    return _mapped(lambda x: 0.75 * ((x - 1.0) / (x + 1.5)), "the King factor", king, 1.0, most)


# Depolarisation of dry air as Bucholtz prints it [bucholtz1995] after Bates (1984), to three decimals of a percent
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
    """Depolarisation factor rho of dry air for natural light, linear between the wavelengths of the table.

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
    low, high = float(WAVELENGTH_NM[0]), float(WAVELENGTH_NM[-1])
    return _mapped(
        lambda x: np.interp(x, WAVELENGTH_NM, RHO_MILLI_PERCENT) / 1e5, "wavelength_nm", wavelength_nm, low, high
    )


def air_gamma(wavelength_nm: ArrayLike) -> Any:
    """Anisotropy gamma of dry air by wavelength; argument, accuracy and errors as for `air_depolarisation`.

    Examples
    --------
    >>> print(f"{sky.rayleigh.air_gamma(550.0):.5f}")
    0.01441
    """
    return gamma_from_rho(air_depolarisation(wavelength_nm))
