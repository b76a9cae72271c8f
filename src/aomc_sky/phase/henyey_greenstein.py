"""Henyey-Greenstein: p(mu) = (1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2)) per steradian, mean mu = g.

g lies in (-1, 1); a negative g is the mirror image. Positions beside the peak are given by 1 - mu, since mu has no
digits left there. Arguments broadcast. Arrays of float32 give float32, worked out in float64. Everything
else gives float64, and scalars give numpy scalars. The jitted forms, with the same bits, are
in `aomc_sky.kernels.phase.jitted`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.kernels.phase import henyey_greenstein as formulas
from aomc_sky.phase.vectorised import checked, evaluate, precision_of

__all__ = ["cdf", "pdf_sr", "sample_mu", "sample_mu_sin", "survival"]


def _arguments(name: str, value: ArrayLike, high: float, g: ArrayLike) -> tuple[np.dtype[Any], Any, Any]:
    kind = precision_of(value, g)
    return kind, checked(name, value, kind, 0.0, high), checked("g", g, kind, -1.0, 1.0, open_ends=True)


def sample_mu(xi: ArrayLike, g: ArrayLike) -> Any:
    """Cosine of the scattering angle whose cumulated probability is xi.

    Parameters
    ----------
    xi : array_like
        Probability of a smaller mu: 0 is backwards, 1 is forwards. [0 to 1]
    g : array_like
        Mean cosine. [-1 to 1, both excluded]

    Returns
    -------
    ndarray or scalar, float32 or float64
        mu. [-1 to 1]

    Raises
    ------
    UsageError
        An argument is outside its range or NaN.

    Notes
    -----
    Accuracy: 2.5e-16 absolute for abs(mu) < 1/4 and 8 ulp beyond, for every g, g = 0 and 1e-8 included; float32
    rounded from float64. Take `sample_mu_sin` beside the peak of a narrow
    lobe. Cost: one division for each number.

    Examples
    --------
    >>> print(sky.henyey_greenstein.sample_mu([0.0, 0.5, 1.0], 0.5))
    [-1.      0.6875  1.    ]
    """
    return evaluate(formulas.cosine, *_arguments("xi", xi, 1.0, g))[0]


def sample_mu_sin(xi: ArrayLike, g: ArrayLike) -> tuple[Any, Any, Any]:
    """`sample_mu` with 1 - mu and the sine, both within 7 ulp beside mu = 1 and -1; arguments and errors as there.

    The bound holds for every g up to the last float64 below 1, and for xi of 0 or above 1e-270.

    Examples
    --------
    >>> mu, one_minus_mu, sin_theta = sky.henyey_greenstein.sample_mu_sin(0.999, 0.95)
    >>> print(f"{one_minus_mu:.3e}")
    2.568e-06
    """
    kind, share, asymmetry = _arguments("xi", xi, 1.0, g)
    ends = evaluate(formulas.beside_the_ends, kind, share, asymmetry)
    return evaluate(formulas.cosine, kind, share, asymmetry)[0], ends[0], ends[1]


def pdf_sr(one_minus_mu: ArrayLike, g: ArrayLike) -> Any:
    """Density per steradian. [sr-1]

    Parameters
    ----------
    one_minus_mu : array_like
        1 less the cosine of the scattering angle. [0 to 2]
    g : array_like
        Mean cosine. [-1 to 1, both excluded]

    Returns
    -------
    ndarray or scalar, float32 or float64
        Within 9 ulp. Times 2 pi it is the density over mu.

    Raises
    ------
    UsageError
        An argument is outside its range or NaN.

    Examples
    --------
    >>> print(f"{sky.henyey_greenstein.pdf_sr(0.0, 0.5):.6f}")  # straight on: 6 / (4 pi)
    0.477465
    """
    return evaluate(formulas.density, *_arguments("one_minus_mu", one_minus_mu, 2.0, g))[0]


def cdf(one_minus_mu: ArrayLike, g: ArrayLike) -> Any:
    """Probability of a smaller mu; arguments and errors as for `pdf_sr`. Within 7 ulp.

    Its small values, on the far side of the lobe, keep their digits; so do those of `survival` beside mu = 1.

    Examples
    --------
    >>> print(f"{sky.henyey_greenstein.cdf(1.0, 0.5):.6f}")
    0.170820
    """
    return evaluate(formulas.tails, *_arguments("one_minus_mu", one_minus_mu, 2.0, g))[0]


def survival(one_minus_mu: ArrayLike, g: ArrayLike) -> Any:
    """Probability of a larger mu, 1 - `cdf` with its own last digits; arguments, accuracy and errors as for `cdf`.

    Examples
    --------
    >>> print(f"{sky.henyey_greenstein.survival(1.0, 0.5):.6f}")
    0.829180
    """
    return evaluate(formulas.tails, *_arguments("one_minus_mu", one_minus_mu, 2.0, g))[1]
