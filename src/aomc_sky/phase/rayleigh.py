"""Rayleigh scattering: p(mu) = 3/8 [(1 + 3 gamma) + (1 - gamma) mu^2] / (1 + 2 gamma) [bucholtz1995].

gamma = 0 is the classical 3/8 (1 + mu^2), gamma = 1 is isotropic. Arguments broadcast. float32 arrays give
float32, worked out in float64; everything else gives float64; scalars give numpy scalars. The jitted forms,
with the same bits, stand in `aomc_sky.kernels.phase.jitted`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aomc_sky.kernels.phase import rayleigh as formulas
from aomc_sky.phase.air import (
    air_depolarisation,
    air_gamma,
    gamma_from_king_factor,
    gamma_from_rho,
    king_factor,
    rho_from_gamma,
)
from aomc_sky.phase.vectorised import checked, evaluate, precision_of, sample

__all__ = [
    "air_depolarisation",
    "air_gamma",
    "cdf_mu",
    "gamma_from_king_factor",
    "gamma_from_rho",
    "king_factor",
    "legendre2",
    "max_polarisation",
    "mean_abs_mu",
    "mean_mu2",
    "mean_mu4",
    "pdf_mu",
    "pdf_sr",
    "rho_from_gamma",
    "sample_mu",
    "sample_mu_sin",
]

_INV_2PI = 0.15915494309189535


def _density_sr(mu: NDArray[np.float64], gamma: NDArray[np.float64]) -> Any:
    return _INV_2PI * formulas.density(mu, gamma)


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
    kind, x, g = _arguments("xi", xi, 0.0, gamma)
    return sample(formulas.cosine, False, 1, kind, x, g)[0]


def sample_mu_sin(xi: ArrayLike, gamma: ArrayLike) -> tuple[Any, Any, Any]:
    """`sample_mu` with 1 - mu and the sine, which keep their digits beside mu = 1 and -1.

    Parameters
    ----------
    xi, gamma : array_like
        As for `sample_mu`.

    Returns
    -------
    mu, one_minus_mu, sin_theta : ndarray or scalar, float32 or float64
        Within 5 ulp each.

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
    kind, x, g = _arguments("xi", xi, 0.0, gamma)
    mu, one_minus_mu, sin_theta = sample(formulas.cosine_and_ends, False, 3, kind, x, g)
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
        Within 4 ulp.

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
    """Density per steradian, `pdf_mu` over 2 pi. [sr-1]; arguments, accuracy and errors as there.

    Examples
    --------
    >>> print(f"{sky.rayleigh.pdf_sr(1.0, 1.0):.6f}")  # gamma = 1 is isotropic: 1 / (4 pi)
    0.079577
    """
    return evaluate(_density_sr, *_arguments("mu", mu, -1.0, gamma))[0]


def cdf_mu(mu: ArrayLike, gamma: ArrayLike) -> Any:
    """Probability of a smaller mu; arguments and errors as for `pdf_mu`.

    Within 4 ulp, also where it is small beside mu = -1.

    Examples
    --------
    >>> print(sky.rayleigh.cdf_mu([-1.0, 0.0, 1.0], 0.0))
    [0.  0.5 1. ]
    """
    return evaluate(formulas.cumulated, *_arguments("mu", mu, -1.0, gamma))[0]


def _moment(gamma: ArrayLike, upper: tuple[float, float], lower: tuple[float, float]) -> Any:
    kind = precision_of(gamma)
    g = checked("gamma", gamma, kind, 0.0, 1.0)
    return evaluate(lambda x: (upper[0] + upper[1] * x) / (lower[0] + lower[1] * x), kind, g)[0]


def mean_mu2(gamma: ArrayLike) -> Any:
    """Mean of mu^2, (2 + 3 gamma) / (5 (1 + 2 gamma)). The mean of mu is 0.

    Examples
    --------
    >>> print(sky.rayleigh.mean_mu2(0.0))
    0.4
    """
    return _moment(gamma, (2.0, 3.0), (5.0, 10.0))


def mean_mu4(gamma: ArrayLike) -> Any:
    """Mean of mu^4, 3 (3 + 4 gamma) / (35 (1 + 2 gamma)).

    Examples
    --------
    >>> print(f"{sky.rayleigh.mean_mu4(0.0):.6f}")
    0.257143
    """
    return _moment(gamma, (9.0, 12.0), (35.0, 70.0))


def mean_abs_mu(gamma: ArrayLike) -> Any:
    """Mean of abs(mu), 3 (3 + 5 gamma) / (16 (1 + 2 gamma)).

    Examples
    --------
    >>> print(sky.rayleigh.mean_abs_mu(0.0))
    0.5625
    """
    return _moment(gamma, (9.0, 15.0), (16.0, 32.0))


def legendre2(gamma: ArrayLike) -> Any:
    """Mean of the second Legendre polynomial, (1 - gamma) / (10 (1 + 2 gamma)); the other moments but the 0th are 0.

    Examples
    --------
    >>> print(sky.rayleigh.legendre2(0.0))
    0.1
    """
    kind = precision_of(gamma)
    g = checked("gamma", gamma, kind, 0.0, 1.0)
    return evaluate(lambda x: (1.0 - x) / (10.0 + 20.0 * x), kind, g)[0]


def max_polarisation(gamma: ArrayLike) -> Any:
    """Degree of polarisation of natural light scattered once by 90 degrees, (1 - gamma) / (1 + 3 gamma).

    Examples
    --------
    >>> print(f"{sky.rayleigh.max_polarisation(0.0142):.4f}")
    0.9455
    """
    kind = precision_of(gamma)
    g = checked("gamma", gamma, kind, 0.0, 1.0)
    return evaluate(lambda x: (1.0 - x) / (1.0 + 3.0 * x), kind, g)[0]
