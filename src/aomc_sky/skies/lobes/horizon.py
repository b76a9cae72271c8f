"""How much of a lobe stands above the horizon, plainly and weighted with the cosine of the zenith angle."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import require_one_of
from aomc_sky.phase import henyey_greenstein
from aomc_sky.phase.vectorised import shape_of
from aomc_sky.skies.lobes.lobe import KindWord, checked, vertical_in_local

LobeWeightingWord = Literal["plain", "projected"]
WEIGHTINGS = get_args(LobeWeightingWord)
_LEVEL = 1e-300  #: Cosine of an axis that is level: half of the lobe is above the horizon.
_DOWN = 1e-120  #: k / -n_z of a lobe that points down; its projected mass, with the cube of this, is below 1e-308.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


def mass_above_horizon(
    kind: KindWord,
    param0: ArrayLike,
    param1: ArrayLike,
    quaternion: ArrayLike,
    *,
    weighting: LobeWeightingWord = "plain",
) -> np.ndarray:
    """Integral of a lobe over the upper hemisphere of the world. [0 to 1]

    n is the world vertical in the local frame, k = hypot(alpha_x n_x, alpha_y n_y) and N = hypot(n_z, k). GGX: (1 + n_z
    / N) / 2, from k^2 / (2 N (N - n_z)) for n_z < 0. Beckmann: erfc(-n_z / k) / 2. The others are integrals on nodes
    that are dense in the logarithm of the distance to sharp features. Relative accuracy: 1e-14 plain and 1e-13 for
    "hg", 1e-10 for projected "ggx" and "beckmann". With the axis below the horizon the condition of n_z comes on top,
    up to 2 (n_z / k)^2 2e-16 for Beckmann.

    Parameters
    ----------
    kind, param0, param1 : str, array_like, array_like
        As for `pdf`.
    quaternion : array_like, shape (..., 4)
        Rotation (w, x, y, z) from local to world; the leading axes broadcast with the parameters.
    weighting : {"plain", "projected"}
        Integral of the density, or of the density times the cosine of the zenith angle: the share of the lobe's light
        that a horizontal plane receives.

    Examples
    --------
    >>> print(
    ...     sky.lobes.mass_above_horizon("ggx", 0.3, 0.3, [1.0, 0.0, 0.0, 0.0])
    ... )  # all of a lobe that points up
    1.0
    """
    require_one_of(WEIGHTINGS, weighting, "weighting")
    first, second = checked(kind, param0, param1)
    n = vertical_in_local(quaternion)
    shape_of((first, second, n[..., 2]))
    if kind == "hg":
        law = _hg_plain if weighting == "plain" else lambda g, cosine: _hg_projected(g, cosine)[0]
        return np.vectorize(law, otypes=[np.float64])(first, n[..., 2])
    k = np.hypot(first * n[..., 0], second * n[..., 1])
    if weighting == "plain":
        return _ggx_plain(n[..., 2], k) if kind == "ggx" else _beckmann_plain(n[..., 2], k)
    law = np.vectorize(lambda *shape: _vndf_projected(kind, *shape)[0], otypes=[np.float64])
    return law(first, second, n[..., 0], n[..., 1], n[..., 2])


def masses_of_lobe(kind: str, first: float, second: float, vertical: np.ndarray) -> tuple[float, float, float]:
    """Integrals of one lobe's density over the upper hemisphere: plain, times the cosine of the zenith angle, squared.

    `vertical` is that of the world in the local frame.
    """
    nx, ny, nz = vertical.tolist()
    if kind == "hg":
        return _hg_plain(first, nz), *_hg_projected(first, nz)
    k, law = np.hypot(first * nx, second * ny), _ggx_plain if kind == "ggx" else _beckmann_plain
    return float(law(vertical[2], k)), *_vndf_projected(kind, first, second, nx, ny, nz)


def _ggx_plain(nz: np.ndarray, k: np.ndarray) -> np.ndarray:
    length = np.hypot(nz, k)
    with np.errstate(invalid="ignore", divide="ignore"):
        below = (k / length) * (k / (2.0 * (length - nz)))
    return np.where(nz < 0.0, below, 0.5 * (1.0 + nz / length))


def _beckmann_plain(nz: np.ndarray, k: np.ndarray) -> np.ndarray:
    from scipy.special import erfc

    with np.errstate(divide="ignore", under="ignore"):
        return 0.5 * erfc(-nz / k)


def _panels(low: float, high: float, length: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes and weights on panels of a length at most."""
    edges = np.linspace(low, high, int(np.ceil((high - low) / length)) + 1)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + _NODES)).ravel(), (half * _WEIGHTS).ravel()


def _hg_plain(g: float, cosine: float) -> float:
    """Mean over the azimuth about the lobe's axis of the share that is nearer than the horizon.

    The horizon stands at cot(theta) = -w with w = tan(axis elevation)^-1 sin(phi); phi = c sinh(y) gives every
    scale, from the elevation c itself to 1, its nodes.
    """
    c = abs(cosine)
    if c < _LEVEL:
        return 0.5
    s = np.sqrt((1.0 - c) * (1.0 + c))
    y, weight = _panels(-np.arcsinh(np.pi / 2 / c), np.arcsinh(np.pi / 2 / c))
    phi = c * np.sinh(y)
    near, far = c, s * np.sin(phi)  # the horizon: c cos(theta) + s sin(phi) sin(theta) = 0
    length = np.hypot(near, far)
    small = (near / length) ** 2 / (1.0 + np.abs(far) / length)  # 1 - |mu| of the horizon
    omm = np.where(far < 0.0, small, 2.0 - small)
    share = henyey_greenstein.survival(omm, g) if cosine > 0.0 else henyey_greenstein.cdf(omm, g)
    return float(np.sum(weight * c * np.cosh(y) * share) / np.pi)


def _hg_projected(g: float, cosine: float) -> tuple[float, float]:
    """Integrals over zenith angle of the ring's mass (a complete elliptic integral) times the cosine, and squared."""
    from scipy.special import ellipe

    cosine = min(max(cosine, -1.0), 1.0)
    axis, elevation = float(np.arccos(cosine)), float(np.arcsin(cosine))  # each with its own last digits
    d = 1.0 - g
    width = max(d, 1e-300)
    y, weight = _panels(np.arcsinh(-axis / width), np.arcsinh(elevation / width))
    offset = width * np.sinh(y)
    near = d * d + 4.0 * g * np.sin(offset / 2) ** 2
    far = d * d + 4.0 * g * np.sin(axis + offset / 2) ** 2
    zenith = np.maximum(axis + offset, 0.0)
    ring = d * (1.0 + g) * ellipe(np.maximum(1.0 - near / far, 0.0)) / (near * np.sqrt(far)) / np.pi
    cosines, weight = np.sin(np.maximum(elevation - offset, 0.0)), weight * width * np.cosh(y)
    once, twice = (float(np.sum(weight * (np.sin(zenith) * cosines**power * ring))) for power in (1, 2))
    return once, twice


def _graded(scale: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on 0 to `length`, dense at 0 down to `scale`: scale sinh(y), Gauss panels in y."""
    top = np.arcsinh(length / scale)
    y, weight = _panels(0.0, float(np.max(top)), 1.5)
    step = top / np.max(top)
    y = y * step[..., None]
    scale = scale[..., None]
    return scale * np.sinh(y), weight * step[..., None] * scale * np.cosh(y)


def _vndf_projected(kind: str, alpha_x: float, alpha_y: float, nx: float, ny: float, nz: float) -> tuple[float, float]:
    """Integrals over stretched slopes (u, v), u along the way to the horizon, of density ((n_z + k u) / secant)^power.

    The powers are 1 and 2. The secant is the root of a quadratic form q in (u, v). For fixed u it is sharp in v at one
    point, the density at v = 0. As functions of u both are sharp at u = 0 or at the horizon.
    """
    k = float(np.hypot(alpha_x * nx, alpha_y * ny))
    if nz < 0.0 and k <= -_DOWN * nz:
        return 0.0, 0.0
    cos, sin = (alpha_x * nx / k, alpha_y * ny / k) if k > 0.0 else (1.0, 0.0)
    form = (
        (alpha_y - alpha_x) * (alpha_y + alpha_x) * sin * cos,
        (alpha_x * sin) ** 2 + (alpha_y * cos) ** 2,
        alpha_x * alpha_y,
    )
    narrow = min(1.0, 1.0 / max(alpha_x, alpha_y))
    with np.errstate(under="ignore", over="ignore", divide="ignore"):
        reach, start = 30.0 if kind == "beckmann" else 1e12, -nz / k if k > 0.0 else -np.inf
        # u, n_z + k u without cancellation, weight
        if start >= 0.0:
            x, weight = _graded(np.array(min(narrow, 1.0 / max(start, 1.0))), np.array(reach * max(start, 1.0)))
            pieces = [(start + x, k * x, weight)]
        else:
            x, weight = _graded(np.array(narrow), np.array(reach))
            low, low_weight = _graded(np.array(narrow), np.array(min(reach, -start)))
            pieces = [(x, nz + k * x, weight), (-low, np.maximum(nz - k * low, 0.0), low_weight)]
        inner = [_over_v(kind, u, form) for u, _, _ in pieces]
        once, twice = (
            sum(
                float(np.sum(weight * above**power * integral[power - 1]))
                for (_, above, weight), integral in zip(pieces, inner, strict=True)
            )
            for power in (1, 2)
        )
        return once, twice


def _over_v(kind: str, u: np.ndarray, form: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Integrals over v of the density over the secant, and over its square, for each u."""
    b, c, det = form
    centre = -b / c * u
    rest = 1.0 + (det * det / c) * u * u  # q = c (v - centre)^2 + rest
    wide = np.sqrt(1.0 + u * u) if kind == "ggx" else np.ones_like(u)
    reach = (1e5 if kind == "ggx" else 30.0) * wide
    sharp = np.minimum(np.sqrt(rest / c), wide)
    half = np.abs(centre) / 2
    once, twice = np.zeros_like(u), np.zeros_like(u)
    for scale, length, origin, way in (
        (sharp, reach, "density", -1.0),
        (sharp, half, "density", 1.0),
        (sharp, half, "secant", -1.0),
        (sharp, reach, "secant", 1.0),
    ):
        if not np.any(length):
            continue
        x, weight = _graded(scale, length)
        shift = np.abs(centre)[:, None]  # where the secant is sharp, v counted towards it
        v = way * x if origin == "density" else shift + way * x
        from_centre = v - shift if origin == "density" else way * x
        square = u[:, None] ** 2 + v * v
        density = np.exp(-square) if kind == "beckmann" else (1.0 + square) ** -2
        square = c * from_centre**2 + rest[:, None]
        density *= weight
        once += np.sum(density / np.sqrt(square), axis=1)
        twice += np.sum(density / square, axis=1)
    return once / np.pi, twice / np.pi
