"""Where the photons of a chunk come from: angles and squares of their directions, a column each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.directions import Frame, sky_columns_deg

_ZENITH_DEG = 1e-3
"""So near to the zenith an azimuth says nothing, and counts as 0."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonAngles:
    """Sky directions of photons."""

    #: zenith_deg, azimuth_deg: Azimuth 0 within 0.001 degrees of the zenith. [deg, shape (n,)]
    zenith_deg: np.ndarray
    azimuth_deg: np.ndarray
    #: across2, up2, length2: Squares of the horizontal part of a direction, of its vertical part, and of its length.
    #: [shape (n,)]
    across2: np.ndarray
    up2: np.ndarray
    length2: np.ndarray

    @classmethod
    def of(cls, direction: np.ndarray, frame: Frame) -> PhotonAngles:
        """Of travel directions (n, 3), in any precision."""
        x, y, z = np.ascontiguousarray(direction.T, dtype=np.float64)
        across2, up2 = x * x, z * z
        across2 += y * y
        zenith, azimuth = sky_columns_deg(x, y, z, frame)
        azimuth[zenith < _ZENITH_DEG] = 0.0
        return cls(zenith_deg=zenith, azimuth_deg=azimuth, across2=across2, up2=up2, length2=across2 + up2)

    def sin2(self) -> np.ndarray:
        """sin^2 of the zenith angle, (n,)."""
        return self.across2 / self.length2

    def mu(self) -> np.ndarray:
        """Cosine of the zenith angle of photons from above, (n,)."""
        return np.sqrt(self.up2 / self.length2)
