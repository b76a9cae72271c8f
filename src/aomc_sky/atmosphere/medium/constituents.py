"""An atmosphere as its solvers see it: constituents by altitude, cross sections and phase functions by wavelength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import SceneError


@dataclass(frozen=True, kw_only=True, slots=True)
class Constituent:
    """One kind of particle: how many there are at each altitude, and what each does to light.

    Parameters
    ----------
    name : str
        Unique inside an atmosphere.
    number_density : callable
        Altitudes (n,) float64 [m, 0 to the top] to particles per volume (n,) float64. [m-3, >= 0]
    kink_altitude_m : ndarray, float64, shape (n_kink,)
        Rising altitudes between the ground and the top where the density jumps or bends. [m]
    scattering_m2, absorption_m2 : ndarray, float64, shape (n_wl,)
        Cross sections; their sum is the extinction. [m2, >= 0]
    phase_function : callable or None
        Cosines of scattering angles (n,) float64 and a row of the wavelengths (int) to the phase function (n,)
        float64, of integral 1 over the sphere; 1 is straight on. None where nothing is scattered. [sr-1]
    """

    name: str
    number_density: Callable[[np.ndarray], np.ndarray]
    kink_altitude_m: np.ndarray
    scattering_m2: np.ndarray
    absorption_m2: np.ndarray
    phase_function: Callable[[np.ndarray, int], np.ndarray] | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Medium:
    """A spherical atmosphere over a Lambertian ground, lit by the sun.

    Parameters
    ----------
    earth_radius_m : float
        Radius of the ground. [m, > 0]
    top_m : float
        Altitude above which there is nothing. [m, > 0]
    wavelength_nm : ndarray, float64, shape (n_wl,)
        Wavelengths of every row below. [nm]
    constituents : tuple of Constituent
        All of them; order does not matter.
    ground_albedo : ndarray, float64, shape (n_wl,)
        Of the Lambertian ground. [0 to 1]
    toa_irradiance : ndarray, float64, shape (n_wl,)
        Of the sun above the atmosphere, on a plane normal to the beam. [W m-2 nm-1]
    sun_angular_radius_rad : float
        Of the solar disc; 0 for a point. [rad]
    n_orders : int
        Most interactions of a photon with air and ground that count. [1 or more]
    least_line_points, least_angles : int
        Points along a line that order 1 has at least, and directions on the sphere that `sos` has at least;
        accuracy does not need them. [0 or more]
    """

    earth_radius_m: float
    top_m: float
    wavelength_nm: np.ndarray
    constituents: tuple[Constituent, ...]
    ground_albedo: np.ndarray
    toa_irradiance: np.ndarray
    sun_angular_radius_rad: float
    n_orders: int
    least_line_points: int = 0
    least_angles: int = 0

    def __post_init__(self) -> None:
        shape = self.wavelength_nm.shape
        rows = [self.ground_albedo, self.toa_irradiance]
        rows += [row for part in self.constituents for row in (part.scattering_m2, part.absorption_m2)]
        if len(shape) != 1 or any(row.shape != shape for row in rows):
            raise SceneError("an atmosphere has one value of every spectrum for each wavelength")
        if not (0.0 < self.earth_radius_m < np.inf and 0.0 < self.top_m < np.inf) or self.n_orders < 1:
            raise SceneError("an atmosphere has an extent, a ground of positive radius, and one order or more")
        if len({part.name for part in self.constituents}) != len(self.constituents):
            raise SceneError("two constituents of an atmosphere have one name")
