"""An atmosphere description is read, and its sky given as directions with weights."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.atmosphere.sky import weighted_directions as of_medium
from aomc_sky.atmosphere.sky.weighted_directions import WeightedDirections
from aomc_sky.source.atmospheres.night_lights import glow_of_luminance, moon_of_direction
from aomc_sky.source.atmospheres.solve import direction_of_moon, read_for_sun
from aomc_sky.whole_number import as_index

_PER_WAVELENGTH = (
    "wavelength_nm",
    "zenith_rad",
    "azimuth_from_sun_rad",
    "weight",
    "order_one_weight",
    "direct_irradiance",
    "under_sampled",
)


def weighted_directions(
    path: str | os.PathLike[str],
    *,
    wavelength_nm: ArrayLike,
    sun_zenith_deg: float,
    n: int,
    first: int = 0,
    orders: int | None = None,
    seed: int = 0,
    moon: Mapping[str, float] | None = None,
    ground_luminance_cd_m2: float = 0.0,
    allow_paths: Sequence[str | os.PathLike[str]] = (),
) -> WeightedDirections:
    """Directions of the clear sky of an atmosphere description, with weights whose mean is its irradiance.

    No table and no bins: a direction is drawn from what the sky's order 1 looks like, and weighs its own radiance, by
    quadrature for order 1 and by one backward path through spherical shells for the others, over the density that it
    is drawn from. The mean of the weights times any function of the direction estimates, without bias, the integral of
    radiance times cosine times that function over the sky.

    Parameters
    ----------
    path : str or path
        The description, a .atmo file.
    wavelength_nm : array_like, shape (n_wl,)
        Wavelengths; each gets the nearest one of the description, which `result.wavelength_nm` says. [nm]
    sun_zenith_deg : float
        Zenith angle of the sun. [deg, 0 to 108; to 180 over a ground that glows]
    n, first : int
        How many directions, and the number of the first. [1 or more, 0 or more; together at most 2^32 - 1]
    orders : int, optional
        Most interactions of light with air and ground that count; the description's by default. [1 or more]
    seed : int
        Of the random numbers. [0 to 2^64 - 1]
    moon, ground_luminance_cd_m2
        As `solve_atmosphere` has them.
    allow_paths : sequence of str or path
        Folders below which tables of the description may lie, besides its own.

    Returns
    -------
    WeightedDirections
        For the solar irradiance of the description, wavelengths in the order asked. Direction k of a wavelength is the
        same whatever else is asked for, so calls with other `first` add to each other.

    Raises
    ------
    InputFileError
        Everything that is wrong with the description and its files.
    UsageError, SceneError
        A number outside its range; deep night.

    Notes
    -----
    `result.standard_error` is that of the irradiance: 0.1 to 0.6 % for 1e5 directions and suns above 10 degrees. Cost:
    0.5 s and 20 us a direction, 70 us with the sun down, for each wavelength; see docs/models/atmosphere.md.
    """
    n, first, seed = as_index(n, "n"), as_index(first, "first"), as_index(seed, "seed")
    medium, report, rows, sun_zenith_rad = read_for_sun(path, wavelength_nm, sun_zenith_deg, allow_paths)
    found = of_medium.weighted_directions(
        medium, sun_zenith_rad=sun_zenith_rad, n=n, first=first, n_orders=orders, seed=seed,
        moon=moon_of_direction(direction_of_moon(moon), medium, report, float(np.rad2deg(sun_zenith_rad)), 0.0),
        ground_radiance=glow_of_luminance(ground_luminance_cd_m2, report, os.fspath(path)),
    )  # fmt: skip
    return dataclasses.replace(found, **{name: getattr(found, name)[rows] for name in _PER_WAVELENGTH})
