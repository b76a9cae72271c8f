"""A flat surface between air and water: Snell's law and Fresnel's reflectance of unpolarised light."""

from __future__ import annotations

import math

import numba


@numba.njit(nogil=True)
def refracted_mu(mu: float, index: float) -> float:
    """Return the cosine of the angle behind the surface.

    Parameters
    ----------
    mu : float
        Cosine between the photon's path and the normal, in front of the surface. [0 to 1]
    index : float
        Refractive index behind the surface over the one in front: n from air into water, 1/n back.

    Returns
    -------
    float
        Cosine behind the surface; 0 where all light is reflected. [0 to 1]
    """
    square = (index - 1.0) * (index + 1.0) + mu * mu
    return math.sqrt(square) / index if square > 0.0 else 0.0


@numba.njit(nogil=True)
def reflectance(mu: float, behind: float, index: float) -> float:
    """Return the share of unpolarised light that the surface reflects.

    Parameters
    ----------
    mu, behind : float
        Cosines in front of the surface and behind it, from `refracted_mu`. [0 to 1]
    index : float
        Refractive index behind the surface over the one in front.

    Returns
    -------
    float
        Mean of the reflectances across and along the plane of incidence; 1 beyond the critical angle. [0 to 1]
    """
    if behind == 0.0:
        return 1.0
    across = (mu - index * behind) / (mu + index * behind)
    along = (index * mu - behind) / (index * mu + behind)
    return 0.5 * (across * across + along * along)
