"""What backward paths bring: radiances by order, their errors, and where these are not to be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MOST_LISTED = 24
"""Orders that are listed one by one; where more count, the last row holds all the later ones together."""

CHECKED = 4
"""One path of so many also samples the sun's order 1, which is compared with its quadrature."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PathsResult:
    """Radiance of directions by backward paths.

    Parameters
    ----------
    radiance_by_order : ndarray, float64, shape (n_wl, n_order, n)
        By number of interactions, 1 first: order 1 of the sun by quadrature, all else by paths. Where more than 24
        orders count, row 24 holds all the later ones. [W m-2 sr-1 nm-1]
    standard_error_by_order : ndarray, float64, shape (n_wl, n_order, n)
        Of each; 0 where no path has a part in it.
    standard_error : ndarray, float64, shape (n_wl, n)
        Of the sum of all orders, whose errors are correlated: not the root of the sum of squares.
    under_sampled : ndarray, bool, shape (n_wl, n)
        Where the errors are not to be trusted: see `solve_paths`.
    n_paths : int
        Paths of each direction and wavelength.
    """

    radiance_by_order: np.ndarray
    standard_error_by_order: np.ndarray
    standard_error: np.ndarray
    under_sampled: np.ndarray
    n_paths: int

    @property
    def radiance(self) -> np.ndarray:
        """All orders together, shape (n_wl, n). [W m-2 sr-1 nm-1]"""
        return self.radiance_by_order.sum(axis=1)


def paths_result(once: np.ndarray, rows: np.ndarray, whole: np.ndarray, n_paths: int) -> PathsResult:
    """Means and errors of sums, and where they are not to be trusted.

    `once` (n_wl, n) is the sun's order 1, `rows` (n_wl, n, n_row, 2) sums of light and of its squares by order, and
    `whole` (n_wl, n, 6) the sums that `kernels.atmosphere.backward` fills for each direction.
    """
    mean = rows[..., 0] / n_paths
    radiance = np.ascontiguousarray(mean.swapaxes(1, 2))
    radiance[:, 0] += once
    error = _standard_error(whole[..., 0], whole[..., 1], n_paths)
    return PathsResult(
        radiance_by_order=radiance,
        standard_error_by_order=_standard_error(rows[..., 0], rows[..., 1], n_paths).swapaxes(1, 2),
        standard_error=error,
        under_sampled=_under_sampled(once, whole, n_paths),
        n_paths=n_paths,
    )


def _standard_error(total: np.ndarray, squares: np.ndarray, n: int) -> np.ndarray:
    mean = total / n
    return np.sqrt(np.maximum(squares / n - mean * mean, 0.0) / (n - 1))


def _n_checked(n_paths: int) -> int:
    return -(-n_paths // CHECKED)


def _under_sampled(once: np.ndarray, whole: np.ndarray, n: int) -> np.ndarray:
    """Whether paths fail where the answer is known, or one of them has a good part of the variance."""
    n_checked = _n_checked(n)
    error = _standard_error(whole[..., 3], whole[..., 4], n_checked)
    gap = np.abs(whole[..., 3] / n_checked - once)
    fails = (gap > 4.0 * error + 0.01 * once) | (error > 0.2 * once)
    alone = whole[..., 2] ** 2 > 0.2 * np.maximum(whole[..., 1], 1e-300)
    return (fails & (once > 0)) | alone
