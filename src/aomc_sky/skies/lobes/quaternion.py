"""Rotations between the local frame of a lobe and the world, from quaternions of any length."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError
from aomc_sky.phase.vectorised import real, shape_of
from aomc_sky.skies.lobes.error_free import dot


def normalised(quaternion: ArrayLike) -> np.ndarray:
    """The quaternion (w, x, y, z), of any length but 0, with length 1 within 4e-16."""
    q = _scaled(quaternion)
    return q / np.sqrt(np.sum(q * q, axis=-1, keepdims=True))


def _scaled(quaternion: ArrayLike) -> np.ndarray:
    """The quaternion times a power of two, largest component in [0.5, 1): exact, and no square overflows."""
    q = real(quaternion)
    if q.ndim == 0 or q.shape[-1] != 4:
        raise SceneError(f"a quaternion has four components (w, x, y, z), found the shape {q.shape}")
    largest = np.abs(q).max(axis=-1, keepdims=True, initial=0.0)
    if not np.all(np.isfinite(q)) or np.any(largest == 0.0):
        raise SceneError("a quaternion must be finite and not zero: write (1, 0, 0, 0) for no rotation")
    return np.ldexp(q, -np.frexp(largest)[1])


def rotation_matrix(quaternion: ArrayLike) -> np.ndarray:
    """Rotation from local to world: its columns are the local axes, its last row the vertical in the local frame.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        (w, x, y, z), normalised here.

    Returns
    -------
    ndarray, float64, shape (..., 3, 3)
        R with world = R local; each element within 4 ulp of itself for the components as given: they are
        divided by the squared length once, not normalised first.
    """
    w, x, y, z = np.moveaxis(_scaled(quaternion), -1, 0)
    rows = (
        (dot((w, w), (x, x), (-y, y), (-z, z)), 2 * dot((x, y), (-w, z)), 2 * dot((x, z), (w, y))),
        (2 * dot((x, y), (w, z)), dot((w, w), (y, y), (-x, x), (-z, z)), 2 * dot((y, z), (-w, x))),
        (2 * dot((x, z), (-w, y)), 2 * dot((y, z), (w, x)), dot((w, w), (z, z), (-x, x), (-y, y))),
    )
    length2 = dot((w, w), (x, x), (y, y), (z, z))
    return np.stack([np.stack([element / length2 for element in row], axis=-1) for row in rows], axis=-2)


def quaternion_of(matrix: np.ndarray) -> np.ndarray:
    """Quaternion of a rotation from local to world: `rotation_matrix` backwards, largest component positive.

    The four squares 4 w^2, 4 x^2, 4 y^2, 4 z^2 are 1 with the signed sums of the diagonal, and the products stand off
    the diagonal; the largest component is divided by, so nothing cancels [shepperd1978].
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix.tolist()
    w2, x2, y2, z2 = 1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz
    rows = (
        (w2, zy - yz, xz - zx, yx - xy),
        (zy - yz, x2, yx + xy, xz + zx),
        (xz - zx, yx + xy, y2, zy + yz),
        (yx - xy, xz + zx, zy + yz, z2),
    )
    return normalised(rows[int(np.argmax((w2, x2, y2, z2)))])


def vertical_in_local(quaternion: ArrayLike) -> np.ndarray:
    """The world vertical in the local frame, shape (..., 3); its last component is the cosine of the axis zenith."""
    return rotation_matrix(quaternion)[..., 2, :]


def to_world(quaternion: ArrayLike, local: ArrayLike) -> np.ndarray:
    """Turn local directions into the world frame (x east, y north, z up).

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        As for `rotation_matrix`.
    local : array_like, shape (..., 3)
        Vectors; the leading axes broadcast with those of the quaternion.

    Returns
    -------
    ndarray, float64, shape (..., 3)
        Vectors of the same lengths.
    """
    return _turned(rotation_matrix(quaternion), local)


def to_local(quaternion: ArrayLike, world: ArrayLike) -> np.ndarray:
    """Turn world directions into the local frame of a lobe: `to_world` backwards, same shapes.

    Parameters
    ----------
    quaternion, world : array_like
        The rotation and the vectors.

    Returns
    -------
    ndarray, float64, shape (..., 3)
        Local vectors.
    """
    return _turned(np.swapaxes(rotation_matrix(quaternion), -1, -2), world)


def _turned(rotation: np.ndarray, vector: ArrayLike) -> np.ndarray:
    v = real(vector)
    if v.ndim == 0 or v.shape[-1] != 3:
        raise SceneError(f"directions have three components, found the shape {v.shape}")
    shape_of((rotation[..., 0], v))
    turned: np.ndarray = np.einsum("...ij,...j->...i", rotation, v)
    return turned


def slerp(start: ArrayLike, end: ArrayLike, share: float) -> np.ndarray:
    """Rotation between two, at a constant rate the short way [shoemake1985]; at share 0 and 1 the ends as given.

    With theta the angle between the quaternions, both of length 1 and the end's sign chosen so that theta <= pi/2::

        q = sin((1 - t) theta) / sin(theta) start + sin(t theta) / sin(theta) end

    theta = 2 atan2(|start - end|, |start + end|) has all its digits at 0, where an arc cosine has half of them.
    """
    a, b = normalised(start), normalised(end)
    if share in (0.0, 1.0):
        return np.array(end if share else start, dtype=np.float64)
    if a @ b < 0.0:
        b = -b
    theta = 2.0 * np.arctan2(np.linalg.norm(a - b), np.linalg.norm(a + b))
    if theta == 0.0:
        return a
    turned: np.ndarray = (np.sin((1.0 - share) * theta) * a + np.sin(share * theta) * b) / np.sin(theta)
    return turned
