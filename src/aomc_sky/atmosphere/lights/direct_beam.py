"""Light of the sun that reaches the ground unscattered: its irradiance, and the disc it comes from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.medium.optical_depth import optical_depth_to_top


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectBeam:
    """The direct beam at the ground, a component of its own beside the radiance of the sky."""

    sun_zenith_rad: float  #: Zenith angle of the sun's centre. [rad]
    sun_angular_radius_rad: float  #: Of the disc that photons of the beam come from, 0 for a point. [rad]
    optical_depth: np.ndarray  #: (n_wl,) slant depth towards the sun's centre; infinite below the horizon
    #: (n_wl,) on the horizontal ground, cos(sun zenith) F0 exp(-optical_depth), 0 from 90 degrees on. [W m-2 nm-1]
    irradiance: np.ndarray


def direct_beam(medium: Medium, sun_zenith_rad: float) -> DirectBeam:
    """The direct beam at the ground, with all of the sun's light from its centre.

    Accuracy: 1e-10 of the formula. The mean over a disc of 0.27 degrees differs from it by 7e-6 below 60 degrees, 2e-4
    at 80, 2e-3 at 85, 2 % at 88 and 6 % at 89 (450 nm, molecules and aerosol). From there on, where the lower edge of
    the disc reddens and sets, it is another quantity; it ends when the upper edge has set, and the irradiance of this
    beam at 90 degrees.
    """
    depth = optical_depth_to_top(medium, 0.0, sun_zenith_rad)
    return DirectBeam(
        sun_zenith_rad=float(sun_zenith_rad),
        sun_angular_radius_rad=medium.sun_angular_radius_rad,
        optical_depth=depth,
        irradiance=ground_direct_irradiance(medium, np.array([sun_zenith_rad]))[:, 0],
    )


def ground_direct_irradiance(medium: Medium, sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Direct irradiance of the horizontal ground, all of the sun's light from its centre.

    Shape (n_wl, n) of zenith angles (n,): cos(sun zenith) F0 exp(-slant depth), 0 from 90 degrees on. [W m-2 nm-1]

    Accuracy: 1e-10, as the optical depth. Cost: 10 ms, then 3 us a place.
    """
    zenith = np.atleast_1d(np.asarray(sun_zenith_rad, dtype=np.float64))
    depth = optical_depth_to_top(medium, 0.0, zenith)
    cosine = np.where(zenith < np.pi / 2, np.cos(zenith), 0.0)
    return medium.toa_irradiance[:, None] * cosine * np.exp(-depth)
