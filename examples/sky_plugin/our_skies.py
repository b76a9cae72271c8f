# our_skies/our_skies.py
"""Skies of ours."""

import numpy as np


def make(*, sun_zenith_rad, sun_azimuth_rad, brightening=2.0):
    """A cloudy sky: the zenith is 1 + brightening times as bright as the horizon, wherever the sun is."""
    if not brightening >= 0:
        raise ValueError(f"brightening must be 0 or more, got {brightening}")
    return BrightZenith(brightening)


class BrightZenith:
    """Radiance 1 + brightening x cos z."""

    def __init__(self, brightening):
        self.brightening = brightening

    def radiance(self, sky_zenith_rad, sky_azimuth_rad, wavelength_nm):
        """Relative radiance, the same at all wavelengths."""
        return 1 + self.brightening * np.cos(sky_zenith_rad)
