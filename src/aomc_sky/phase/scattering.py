"""One scattering step: a direction, a scattering angle and an azimuth give the next direction.

Arguments broadcast. float32 arrays give float32, worked out in float64; scalars give numpy scalars.
`aomc_sky.kernels.phase.jitted` has the jitted form, with the same bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.kernels.arithmetic.elementary import sin_cos
from aomc_sky.kernels.phase import scatter as formulas
from aomc_sky.phase.vectorised import checked, evaluate, precision_of

__all__ = ["new_direction"]

_LENGTH_TOLERANCE = 1e-3


def _step(ux: Any, uy: Any, uz: Any, one_minus_mu: Any, sin_theta: Any, share: Any) -> tuple[Any, ...]:
    sine, cosine = sin_cos(4.0 * share)
    return formulas.turned(ux, uy, uz, one_minus_mu, sin_theta, cosine, sine)


def new_direction(
    ux: ArrayLike,
    uy: ArrayLike,
    uz: ArrayLike,
    one_minus_mu: ArrayLike,
    sin_theta: ArrayLike,
    azimuth_share: ArrayLike,
) -> tuple[Any, Any, Any]:
    """Direction after scattering by an angle theta.

    Parameters
    ----------
    ux, uy, uz : array_like
        Direction before, a unit vector in any frame; the poles are directions like others.
    one_minus_mu : array_like
        1 - cos(theta), from `sample_mu_sin`. [0 to 2]
    sin_theta : array_like
        sin(theta). [0 to 1]
    azimuth_share : array_like
        Azimuth around the old direction as a share of the full turn, a uniform number. It counts from the
        first tangent of Duff et al. (2017), eq. 5. [0 to 1]

    Returns
    -------
    ux, uy, uz : ndarray or scalar, float32 or float64
        Direction after.

    Raises
    ------
    UsageError
        An argument is outside its range or NaN, or the direction is longer or shorter than 1 by 0.1 percent.

    Notes
    -----
    Accuracy: the length is 1 within 4 ulp of 1 after any number of steps, since each brings it back; the
    direction is right to 1e-15 (float32: 1e-7) each step.

    Examples
    --------
    >>> mu, one_minus_mu, sin_theta = sky.rayleigh.sample_mu_sin(0.5, 0.0)  # by 90 degrees
    >>> ux, uy, uz = sky.scattering.new_direction(
    ...     0.0, 0.0, -1.0, one_minus_mu, sin_theta, 0.25
    ... )
    >>> print(f"{abs(uz):.1f}")
    0.0
    """
    kind = precision_of(ux, uy, uz, one_minus_mu, sin_theta, azimuth_share)
    limit = 1.0 + _LENGTH_TOLERANCE
    x, y, z = (checked(name, u, kind, -limit, limit) for name, u in (("ux", ux), ("uy", uy), ("uz", uz)))
    length2 = x * x + y * y + z * z - kind.type(1)
    if not np.all(np.abs(length2) <= 2.0 * _LENGTH_TOLERANCE):
        raise UsageError("a direction must be a unit vector; its length is off by more than 0.1 percent")
    after = evaluate(
        _step,
        kind,
        x,
        y,
        z,
        checked("one_minus_mu", one_minus_mu, kind, 0.0, 2.0),
        checked("sin_theta", sin_theta, kind, 0.0, 1.0 + 1e-6),
        checked("azimuth_share", azimuth_share, kind, 0.0, 1.0),
    )
    return after[0], after[1], after[2]
