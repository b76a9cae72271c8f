"""One lobe of DIRSIG's background skies: densities and samplers in its local frame, axis +z, and its rotation.

Henyey-Greenstein [henyey1941] and the normal distributions GGX [walter2007] and Beckmann as they are
seen along the axis: n cos(theta) integrates to 1, so the lobes are densities over directions.
"""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, require_one_of
from aomc_sky.kernels.arithmetic.elementary import sin_cos
from aomc_sky.kernels.arithmetic.error_free import two_product, two_sum
from aomc_sky.phase import henyey_greenstein
from aomc_sky.phase.vectorised import precision_of, real, shape_of

KindWord = Literal["hg", "ggx", "beckmann"]
KINDS = get_args(KindWord)


def checked(kind: str, param0: ArrayLike, param1: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Both parameters in float64: g [0 <= g < 1] and nothing, or the roughness along x and y [> 0]."""
    require_one_of(KINDS, kind, "the kind of a lobe")
    first, second = real(param0), real(0.0 if kind == "hg" and param1 is None else param1)
    if kind == "hg":
        if not np.all((first >= 0.0) & (first < 1.0)):
            raise SceneError("the asymmetry g of a Henyey-Greenstein lobe must satisfy 0 <= g < 1")
    elif not np.all((first > 0.0) & (first < np.inf) & (second > 0.0) & (second < np.inf)):
        raise SceneError(f"the roughness of a {kind} lobe must be positive and finite along both axes")
    return first, second


def _scaled(vector: np.ndarray, n: int, has_n: str, is_finite: str) -> np.ndarray:
    """Vectors of n components times a power of two, the largest in [0.5, 1): exact, and no square overflows.

    `has_n` and `is_finite` are what errors say.
    """
    if vector.ndim == 0 or vector.shape[-1] != n:
        raise SceneError(f"{has_n}, got the shape {vector.shape}")
    largest = np.abs(vector).max(axis=-1, keepdims=True, initial=0.0)
    if not np.all(np.isfinite(vector)) or np.any(largest == 0.0):
        raise SceneError(is_finite)
    return np.ldexp(vector, -np.frexp(largest)[1])


def one_minus_mu(m: np.ndarray) -> np.ndarray:
    """1 - cos(angle to +z) of vectors whose squares do not overflow, without cancellation next to the axis."""
    x, y, z = np.moveaxis(m, -1, 0)
    side = x * x + y * y
    length = np.sqrt(side + z * z)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(z > 0.0, side / (length * (length + z)), (length - z) / length)


def pdf(kind: KindWord, param0: ArrayLike, param1: ArrayLike, m: ArrayLike) -> np.ndarray:
    """Density of a lobe over the whole sphere of its local frame; its integral is 1. [sr-1]

    With mu = m_z and A = (m_x/alpha_x)^2 + (m_y/alpha_y)^2 of the unit vector::

        hg        (1 - g)(1 + g) / (4 pi ((1 - g)^2 + 2 g (1 - mu))^(3/2))
        ggx       m_z / (pi alpha_x alpha_y (A + m_z^2)^2),            0 for m_z <= 0
        beckmann  exp(-A / m_z^2) / (pi alpha_x alpha_y m_z^3),        0 for m_z <= 0

    float32 where all arrays are float32, else float64. Accuracy: 18 ulp for "hg", 12 ulp for "ggx", 15 (1 + A/m_z^2)
    ulp for "beckmann". Next to the axis 1 - mu is computed from m_x and m_y, so give those with all their digits.

    Parameters
    ----------
    kind : str
        "hg", "ggx" or "beckmann".
    param0, param1 : array_like
        g of "hg" [0 <= g < 1] and nothing, else the roughness alpha_x and alpha_y. [> 0]
    m : array_like, shape (..., 3)
        Directions of any length but 0; the leading axes broadcast with the parameters.

    Examples
    --------
    >>> print(
    ...     f"{sky.lobes.pdf('hg', 0.0, 0.0, [0.0, 0.0, 1.0]):.6f}"
    ... )  # g = 0 is isotropic: 1 / (4 pi)
    0.079577
    """
    first, second = checked(kind, param0, param1)
    vector = _scaled(real(m), 3, "directions have three components", "directions must be finite and not zero")
    shape_of((first, second, vector[..., 0]))
    with np.errstate(under="ignore", over="ignore"):
        if kind == "hg":
            density = henyey_greenstein.pdf_sr(one_minus_mu(vector), first)
            return np.asarray(density).astype(precision_of(param0, m))
        return _vndf(kind, first, second, vector).astype(precision_of(param0, param1, m))


def _vndf(kind: str, alpha_x: np.ndarray, alpha_y: np.ndarray, m: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(m, -1, 0)
    is_up = z > 0.0
    z = np.where(is_up, z, 1.0)
    length2 = _dot((x, x), (y, y), (z, z))  # rounded once, as is the other square: powers of both follow
    if kind == "ggx":
        square = _dot(*_stretched(x, alpha_x), *_stretched(y, alpha_y), (z, z))
        value = z * length2 * np.sqrt(length2) / (np.pi * alpha_x * square * (alpha_y * square))
        return np.where(is_up, value, 0.0)
    exponent = np.minimum(np.square(x / (alpha_x * z)) + np.square(y / (alpha_y * z)), 1500.0)
    half = np.exp(-0.5 * exponent)  # in two factors, so that a small exp times a large rest keeps its digits
    secant = np.minimum(np.sqrt(length2) / z, 1e100)
    return np.where(is_up, half * (secant * secant * secant / (np.pi * alpha_x * alpha_y)) * half, 0.0)


def _stretched(x: np.ndarray, alpha: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Factors of (x / alpha)^2 for `_dot`; so large a stretch that no density is left counts as 1e150."""
    alpha = np.maximum(alpha, 1e-150 * np.abs(x))
    value = x / alpha
    product, low = two_product(value, alpha)
    return (value, value), (value + value, ((x - product) - low) / alpha)


def sample(kind: KindWord, param0: ArrayLike, param1: ArrayLike, u: ArrayLike, v: ArrayLike) -> np.ndarray:
    """Unit vectors (..., 3) of a lobe from uniform numbers, over the whole sphere of the local frame.

    "hg": D = 1 - g + 2 g u, 1 - mu = 2 (1 - g)^2 (1 - u)(1 + g u) / D^2, and alike for 1 + mu and the sine. In this
    form nothing cancels for g next to 1 and nothing is divided by g. "ggx": (alpha_x sqrt(u) cos, alpha_y sqrt(u) sin,
    sqrt(1 - u)). "beckmann": the stretched slope has the radius sqrt(-log1p(-u)). Accuracy: 10 ulp in each component;
    m_z of "hg" 2.5e-16 absolute where it is small. float32 where all arrays are float32, else float64.

    Parameters
    ----------
    kind, param0, param1 : str, array_like, array_like
        As for `pdf`.
    u, v : array_like
        Uniform numbers: u the probability of a smaller mu ("hg") or of a smaller stretched radius (else), v the azimuth
        as a share of a turn. [0 to 1]

    Examples
    --------
    >>> print(sky.lobes.sample("ggx", 0.3, 0.3, [0.0], [0.0]))  # the axis itself
    [[0. 0. 1.]]
    """
    first, second = checked(kind, param0, param1)
    radial, azimuth = real(u), real(v)
    shape_of((first, second, radial, azimuth))
    if not np.all((radial >= 0.0) & (radial <= 1.0) & (azimuth >= 0.0) & (azimuth <= 1.0)):
        raise SceneError("uniform numbers must be from 0 to 1")
    sine, cosine = (part + 0.0 for part in sin_cos(4.0 * azimuth))  # + 0.0 turns -0 into 0
    if kind == "hg":
        mu, _, side = henyey_greenstein.sample_mu_sin(radial, first)
        parts = np.broadcast_arrays(side * cosine, side * sine, mu)
        return np.stack(parts, axis=-1).astype(precision_of(param0, u, v))
    if kind == "ggx":
        radius, z = np.sqrt(radial), np.sqrt(1.0 - radial)
    else:
        is_edge = radial == 1.0
        radius = np.where(is_edge, 1.0, np.sqrt(-np.log1p(-np.where(is_edge, 0.0, radial))))
        z = np.where(is_edge, 0.0, 1.0)
    parts = np.broadcast_arrays(first * radius * cosine, second * radius * sine, z)
    length = np.sqrt(parts[0] * parts[0] + parts[1] * parts[1] + parts[2] * parts[2])
    return np.stack([part / length for part in parts], axis=-1).astype(precision_of(param0, param1, u, v))


def _scaled_quaternion(quaternion: ArrayLike) -> np.ndarray:
    zero = "a quaternion must be finite and not zero: write (1, 0, 0, 0) for no rotation"
    return _scaled(real(quaternion), 4, "a quaternion has four components (w, x, y, z)", zero)


def rotation_matrix(quaternion: ArrayLike) -> np.ndarray:
    """Rotation R (..., 3, 3) of quaternions (..., 4), world = R local; its last row is the local vertical of the world.

    The quaternion (w, x, y, z) may have any length but 0. Each element is within 4 ulp of itself for the components as
    given, for they are divided by the squared length once.

    Examples
    --------
    >>> print(sky.lobes.rotation_matrix([1.0, 0.0, 0.0, 0.0]))
    [[1. 0. 0.]
     [0. 1. 0.]
     [0. 0. 1.]]
    """
    w, x, y, z = np.moveaxis(_scaled_quaternion(quaternion), -1, 0)
    rows = (
        (_dot((w, w), (x, x), (-y, y), (-z, z)), 2 * _dot((x, y), (-w, z)), 2 * _dot((x, z), (w, y))),
        (2 * _dot((x, y), (w, z)), _dot((w, w), (y, y), (-x, x), (-z, z)), 2 * _dot((y, z), (-w, x))),
        (2 * _dot((x, z), (-w, y)), 2 * _dot((y, z), (w, x)), _dot((w, w), (z, z), (-x, x), (-y, y))),
    )
    length2 = _dot((w, w), (x, x), (y, y), (z, z))
    return np.stack([np.stack([element / length2 for element in row], axis=-1) for row in rows], axis=-2)


def axis_deg(rotation: np.ndarray) -> tuple[float, float]:
    """Zenith angle and azimuth of the axis of a rotation. [deg; azimuth from +x towards +y, 0 to below 360]"""
    x, y, z = rotation[:, 2].tolist()
    return math.degrees(math.atan2(math.hypot(x, y), z)), math.degrees(math.atan2(y, x)) % 360.0


def vertical_in_local(quaternion: ArrayLike) -> np.ndarray:
    """The world vertical in the local frame, shape (..., 3); its last component is the cosine of the axis zenith."""
    return rotation_matrix(quaternion)[..., 2, :]


def to_world(quaternion: ArrayLike, local: ArrayLike) -> np.ndarray:
    """Turn local directions (..., 3) into the world frame (x east, y north, z up).

    Examples
    --------
    >>> quarter_turn_about_z = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    >>> print(sky.lobes.to_world(quarter_turn_about_z, [1.0, 0.0, 0.0]).round(12) + 0.0)
    [0. 1. 0.]
    """
    return _turned(rotation_matrix(quaternion), local)


def to_local(quaternion: ArrayLike, world: ArrayLike) -> np.ndarray:
    """Turn world directions (..., 3) into the local frame of a lobe: the inverse of `to_world`.

    Examples
    --------
    >>> quarter_turn_about_z = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    >>> print(sky.lobes.to_local(quarter_turn_about_z, [0.0, 1.0, 0.0]).round(12) + 0.0)
    [1. 0. 0.]
    """
    return _turned(np.swapaxes(rotation_matrix(quaternion), -1, -2), world)


def _turned(rotation: np.ndarray, vector: ArrayLike) -> np.ndarray:
    v = real(vector)
    if v.ndim == 0 or v.shape[-1] != 3:
        raise SceneError(f"directions have three components, got the shape {v.shape}")
    shape_of((rotation[..., 0], v))
    turned: np.ndarray = np.einsum("...ij,...j->...i", rotation, v)
    return turned


def slerp(start: ArrayLike, end: ArrayLike, share: float) -> np.ndarray:
    """Rotation between two, at a constant rate the short way [shoemake1985]; at share 0 and 1 the ends as given.

    With theta the angle between the quaternions, both of length 1 and the end's sign chosen so that theta <= pi/2::

        q = sin((1 - t) theta) / sin(theta) start + sin(t theta) / sin(theta) end

    theta = 2 atan2(|start - end|, |start + end|) has all its digits at 0, where an arc cosine has half of them.
    """
    a, b = (q / np.sqrt(np.sum(q * q)) for q in (_scaled_quaternion(start), _scaled_quaternion(end)))
    if share in (0.0, 1.0):
        return np.array(end if share else start, dtype=np.float64)
    if a @ b < 0.0:
        b = -b
    theta = 2.0 * np.arctan2(np.linalg.norm(a - b), np.linalg.norm(a + b))
    if theta == 0.0:
        return a
    turned: np.ndarray = (np.sin((1.0 - share) * theta) * a + np.sin(share * theta) * b) / np.sin(theta)
    return turned


def _dot(*pairs: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Sum of products of factors up to 1e150 in size, within 1 ulp unless the terms cancel to 1e-16 of the largest."""
    total = rest = np.zeros(())
    for a, b in pairs:
        product, low = two_product(a, b)
        total, lost = two_sum(total, product)
        rest = rest + (low + lost)
    return total + rest
