"""Means of mu and of 1/mu over the photons of each patch of a Perez sky."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.perez.nodes import W4, X4
from aomc_sky.kernels.perez.plain_law import first_factor, half_sine2, second_factor, sin_cos


def perez_moments(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the means of mu and of 1/mu over the flux of max(f, 0) from each patch.

    Parameters
    ----------
    zenith, azimuth : ndarray, float64, shape (n_ring, 2) and (n_column, 2)
        Edges of rings and columns. [quarter turns]
    numbers : ndarray, float64, shape (11,)
        The sky, as `aomc_sky.component.Component.shared` lists it, with b <= 0.

    Returns
    -------
    mean_mu, mean_inverse_mu : ndarray, float64, shape (n_ring, n_column)
        0 where a patch is dark.

    Notes
    -----
    4 x 4 Gauss points in zenith angle and azimuth, where the flux over mu is smooth up to the horizon.
    Accuracy of the means over a whole sky: 1e-6 on patches of 2 degrees, 1e-4 on patches of 10.
    """
    x = zenith[:, :1] + (zenith[:, 1:] - zenith[:, :1]) * X4
    y = azimuth[:, :1] + (azimuth[:, 1:] - azimuth[:, :1]) * X4
    sine, mu = sin_cos(x)
    columns = half_sine2(y - numbers[6]).ravel()
    h = half_sine2(x - numbers[5])[:, :, None] + (sine * numbers[7])[:, :, None] * columns
    a, b, c, d, e = numbers[:5]
    value = np.maximum(first_factor(mu, a, b)[:, :, None] * second_factor(h, c, d, e), 0.0)
    lines = value.reshape(*x.shape, azimuth.shape[0], W4.size) @ W4
    weight = W4 * sine
    flux = np.einsum("ri,ric->rc", weight * mu, lines)
    with_mu = np.einsum("ri,ric->rc", weight * mu * mu, lines)
    without_mu = np.einsum("ri,ric->rc", weight, lines)
    lit = flux > 0
    return (
        np.divide(with_mu, flux, out=np.zeros_like(flux), where=lit),
        np.divide(without_mu, flux, out=np.zeros_like(flux), where=lit),
    )
