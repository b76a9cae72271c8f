"""The water: what its surface, its body and its bottom do to light."""

from __future__ import annotations

from typing import NamedTuple

from aomc_sky import UsageError


class Water(NamedTuple):
    """A homogeneous layer under a flat surface, over a Lambertian bottom.

    A named tuple, because numba compiles it.
    """

    refractive_index: float
    """Of the water against air; 1 takes the surface away."""
    optical_depth: float
    """Of the whole layer: (absorption + scattering) x depth."""
    albedo: float
    """Single scattering albedo, scattering / (absorption + scattering). [0 to 1]"""
    rayleigh_share: float
    """Share of the scattering that is Rayleigh's; the rest is Henyey and Greenstein's. [0 to 1]"""
    asymmetry: float
    """Mean cosine of the Henyey-Greenstein part. (-1 to 1)"""
    bottom_reflectance: float
    """Lambertian reflectance of the bottom, 0 is black. [0 to 1]"""


def water_layer(
    *,
    depth_m: float,
    absorption_per_m: float,
    scattering_per_m: float,
    refractive_index: float = 1.34,
    rayleigh_share: float = 0.0,
    asymmetry: float = 0.924,
    bottom_reflectance: float = 0.0,
) -> Water:
    """Return the water of a layer, its numbers checked.

    Parameters
    ----------
    depth_m : float
        Depth of the bottom. [m, above 0]
    absorption_per_m, scattering_per_m : float
        Absorption and scattering coefficients. [1/m, at least 0]
    refractive_index : float
        Of the water against air. [1 to 2]
    rayleigh_share, asymmetry, bottom_reflectance : float
        As in `Water`; 0.924 is the mean cosine of Petzold's average particles (Mobley 1994).

    Raises
    ------
    UsageError
        A number out of range.
    """
    _check("depth", depth_m, 0.0 < depth_m < 1e6, "above 0 m")
    _check("absorption", absorption_per_m, 0.0 <= absorption_per_m < 1e6, "at least 0 per metre")
    _check("scattering", scattering_per_m, 0.0 <= scattering_per_m < 1e6, "at least 0 per metre")
    _check("refractive index", refractive_index, 1.0 <= refractive_index <= 2.0, "from 1 to 2")
    _check("Rayleigh share", rayleigh_share, 0.0 <= rayleigh_share <= 1.0, "from 0 to 1")
    _check("asymmetry", asymmetry, -1.0 < asymmetry < 1.0, "between -1 and 1")
    _check("bottom reflectance", bottom_reflectance, 0.0 <= bottom_reflectance <= 1.0, "from 0 to 1")
    attenuation = absorption_per_m + scattering_per_m
    albedo = scattering_per_m / attenuation if attenuation > 0 else 0.0
    return Water(
        float(refractive_index),
        float(attenuation * depth_m),
        float(albedo),
        float(rayleigh_share),
        float(asymmetry),
        float(bottom_reflectance),
    )


def _check(name: str, value: float, is_allowed: bool, allowed: str) -> None:
    if not is_allowed:
        raise UsageError(f"the {name} must be {allowed}, got {value:g}")
