"""Radiance of a solved sky in given directions by backward paths: as many in each as the number of them allows."""

from __future__ import annotations

import dataclasses
import os
import warnings

import numpy as np

from aomc_sky.atmosphere.backward.monte_carlo import solve_paths
from aomc_sky.atmosphere.backward.result import PathsResult
from aomc_sky.atmosphere.sky.solved import SolvedSky
from aomc_sky.errors import ModelLimitWarning

MOST_PATHS, FEWEST_PATHS = 65536, 4096
"""Paths of each direction and wavelength: the first, unless all directions together had more than `ALL_PATHS`."""

ALL_PATHS = 512 * MOST_PATHS

_MODEL_ERROR = 2e-4
"""Of tables and shells, as a share of the light that paths bring."""


def directed_paths(
    sky: SolvedSky, sky_zenith_rad: np.ndarray, azimuth_from_sun_rad: np.ndarray, n_paths: int | None = None
) -> PathsResult:
    """Follow paths in single directions.

    Parameters
    ----------
    sky : SolvedSky
        What is looked at.
    sky_zenith_rad, azimuth_from_sun_rad : ndarray, float64, shape (n,)
        Directions looked into. [rad, 0 to pi/2; any]
    n_paths : int or None
        Paths of each direction and wavelength; None is as many as the number of directions allows.

    Returns
    -------
    PathsResult
        Of the sun's light. Its `standard_error` has 2e-4 of orders 2 and up besides the scatter of the paths.

    Warns
    -----
    ModelLimitWarning
        Directions whose error is not to be trusted.

    Notes
    -----
    The random numbers are those of the sun: two suns have errors of their own, and the whole sky others again.
    """
    found = solve_paths(
        sky.medium, sun_zenith_rad=sky.sun_zenith_rad, sky_zenith_rad=sky_zenith_rad,
        azimuth_from_sun_rad=azimuth_from_sun_rad, n_orders=sky.n_orders, visible=sky.moon, seed=_seed(sky),
        n_paths=n_paths or int(np.clip(ALL_PATHS // max(sky_zenith_rad.size, 1), FEWEST_PATHS, MOST_PATHS)),
        threads=os.cpu_count() or 1,
    )  # fmt: skip
    if found.under_sampled.any():
        warnings.warn(
            f"in {found.under_sampled.sum()} of {found.under_sampled.size} directions and wavelengths looked into "
            "hardly any path reaches the air that the sun lights; errors there may be larger than stated",
            ModelLimitWarning,
            stacklevel=5,
        )
    later = found.radiance_by_order[:, 1:].sum(axis=1)
    return dataclasses.replace(found, standard_error=np.hypot(found.standard_error, _MODEL_ERROR * later))


def _seed(sky: SolvedSky) -> int:
    return int(np.float64(sky.sun_zenith_rad + 0.0).view(np.uint64))
