"""The fifteen standard general skies of ISO 15469:2004 (CIE S 011/E:2003), from overcast to clear, for aomc-sky."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import aomc_sky as sky

TYPES = {
    1: (4.0, -0.70, 0.0, -1.0, 0.00),  # overcast, steep gradation, the same all around
    2: (4.0, -0.70, 2.0, -1.5, 0.15),  # overcast, steep gradation, a little brighter towards the sun
    3: (1.1, -0.80, 0.0, -1.0, 0.00),  # overcast, moderately graded, the same all around
    4: (1.1, -0.80, 2.0, -1.5, 0.15),  # overcast, moderately graded, a little brighter towards the sun
    5: (0.0, -1.00, 0.0, -1.0, 0.00),  # uniform
    6: (0.0, -1.00, 2.0, -1.5, 0.15),  # partly cloudy, no gradation, a little brighter towards the sun
    7: (0.0, -1.00, 5.0, -2.5, 0.30),  # partly cloudy, no gradation, brighter around the sun
    8: (0.0, -1.00, 10.0, -3.0, 0.45),  # partly cloudy, no gradation, a clear corona
    9: (-1.0, -0.55, 2.0, -1.5, 0.15),  # partly cloudy, the sun behind clouds
    10: (-1.0, -0.55, 5.0, -2.5, 0.30),  # partly cloudy, brighter around the sun
    11: (-1.0, -0.55, 10.0, -3.0, 0.45),  # white-blue, a clear corona
    12: (-1.0, -0.32, 10.0, -3.0, 0.45),  # clear, low turbidity
    13: (-1.0, -0.32, 16.0, -3.0, 0.30),  # clear, polluted air
    14: (-1.0, -0.15, 16.0, -3.0, 0.30),  # cloudless, turbid, a broad corona
    15: (-1.0, -0.15, 24.0, -2.8, 0.15),  # white-blue, turbid, a broad corona
}
"""Type -> a, b of the gradation and c, d, e of the indicatrix: table 1 of the standard."""


def make(*, sun_zenith_rad, sun_azimuth_rad, type):
    """One of the skies under a sun; aomc-sky calls this for ``--sky cie --sky-option type=12``."""
    if type not in TYPES or isinstance(type, bool):
        raise ValueError(f"type must be a whole number from 1 to 15, got {type!r}")
    return CieSky(sun_zenith_rad, sun_azimuth_rad, *TYPES[type])


@dataclass(frozen=True)
class CieSky:
    """Luminance relative to that of the zenith, taken as the relative radiance of every wavelength."""

    sun_zenith_rad: float
    sun_azimuth_rad: float
    a: float
    b: float
    c: float
    d: float
    e: float

    def radiance(self, sky_zenith_rad, sky_azimuth_rad, wavelength_nm):
        """f(chi) phi(Z) / (f(Zs) phi(0)), chi being the angle from the sun."""
        zenith, azimuth, _ = np.broadcast_arrays(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
        cosine = np.cos(self.sun_zenith_rad) * np.cos(zenith)
        cosine = cosine + np.sin(self.sun_zenith_rad) * np.sin(zenith) * np.cos(azimuth - self.sun_azimuth_rad)
        from_sun = np.arccos(np.clip(cosine, -1.0, 1.0))
        at_zenith = self.indicatrix(self.sun_zenith_rad) * self.gradation(0.0)
        return self.indicatrix(from_sun) * self.gradation(zenith) / at_zenith

    def gradation(self, zenith_rad):
        """phi(Z) = 1 + a exp(b / cos Z), which is 1 at the horizon."""
        return 1.0 + self.a * np.exp(self.b / np.maximum(np.cos(zenith_rad), 1e-9))

    def indicatrix(self, chi_rad):
        """f(chi) = 1 + c (exp(d chi) - exp(d pi/2)) + e cos^2 chi."""
        return 1.0 + self.c * (np.exp(self.d * chi_rad) - np.exp(self.d * np.pi / 2)) + self.e * np.cos(chi_rad) ** 2

    def lower(self, wavelength_nm):
        """Photons of exactly this law: it is the Perez law, eq. (1) of Perez et al. (1993), times a constant.

        A model may leave `lower` out; aomc-sky then integrates `radiance` over patches, and takes it constant in each.
        """
        constant = 1.0 - self.c * np.exp(self.d * np.pi / 2)
        coefficients = (self.a, self.b, self.c / constant, self.d, self.e / constant)
        exact = sky.PerezSky(
            sun_zenith_rad=self.sun_zenith_rad, sun_azimuth_rad=self.sun_azimuth_rad, coefficients=coefficients
        )
        return exact.lower(wavelength_nm)
