"""Light through spherical shells of refracting air, apart from the package: Bouguer's law and quadrature.

Along a ray n r sin z is constant. A ray that arrives under the apparent altitude a has left the sun's direction under
the true altitude, which is less by the integral of -(dn/dr) / n tan z; what it passes is the integral of the extinction
along the bent way.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

RADIUS_M = 6_371_000.0
SCALE_M = 8435.0
"""Of the density of air, as in the descriptions of inputs/."""
REFRACTIVITY = 2.774e-4
"""n - 1 of air at 15 degrees C, 101 325 Pa and 550 nm, from Peck and Reeder (1972)."""
TOP_M = 100_000.0


@dataclass(frozen=True, kw_only=True)
class Beam:
    """The sun at a true altitude: what refraction makes of it.

    The parameter of a ray, n r cos(altitude) at the ground, is its distance from the earth's centre outside the air; so
    the light between two distances falls on the ring of the ground between two true altitudes.
    """

    true_deg: float  #: Altitude without refraction
    apparent_deg: float
    depth_straight: float  #: Slant optical depth of the straight line towards the true altitude
    depth_bent: float
    concentration: float  #: Irradiance of a horizontal plane over that of the straight beam, for the same transmittance

    @property
    def horizontal_ratio(self):
        """Irradiance of a horizontal plane, refracted over straight."""
        return self.concentration * float(np.exp(self.depth_straight - self.depth_bent))

    @property
    def sine_ratio(self):
        """The same for one irradiance on a plane normal to the beam."""
        return float(np.sin(np.radians(self.apparent_deg)) / np.sin(np.radians(self.true_deg)))


def index(height_m):
    return 1.0 + REFRACTIVITY * float(np.exp(-height_m / SCALE_M))


def _over_height(integrand, kinks_m):
    """Integral from the ground to the top, in the root of the height, for level rays begin like a root."""
    cuts = np.sqrt([0.0, *sorted(kinks_m), TOP_M])
    pieces = [
        quad(lambda x: 2 * x * integrand(x * x), a, b, limit=400, epsabs=1e-14, epsrel=1e-11)[0]
        for a, b in pairwise(cuts.tolist())
    ]
    return float(sum(pieces))


def true_altitude_deg(apparent_deg):
    """Altitude that a ray of this apparent altitude had outside the air."""
    constant = index(0.0) * RADIUS_M * np.cos(np.radians(apparent_deg))

    def bending(height):
        slope = REFRACTIVITY / SCALE_M * np.exp(-height / SCALE_M)
        return float(slope / index(height) * constant / _rise(height, apparent_deg))

    return apparent_deg - float(np.degrees(_over_height(bending, ())))


def _rise(height_m, apparent_deg):
    """n r cos z of the ray at a height."""
    ground, here = index(0.0) * RADIUS_M, index(height_m) * (RADIUS_M + height_m)
    return float(np.sqrt((ground * np.sin(np.radians(apparent_deg))) ** 2 + (here - ground) * (here + ground)))


def beam(true_deg, extinction, kinks_m=()):
    """The beam of a sun at a true altitude through air of this extinction. [m-1 by height in m]"""
    apparent = brentq(lambda a: true_altitude_deg(a) - true_deg, true_deg, true_deg + 1.0, xtol=1e-10)

    def bent(height):
        return extinction(height) * index(height) * (RADIUS_M + height) / _rise(height, apparent)

    def straight(height):
        sine = RADIUS_M * np.sin(np.radians(true_deg))
        return extinction(height) * (RADIUS_M + height) / float(np.sqrt(sine**2 + height * (2 * RADIUS_M + height)))

    step = 1e-3
    slope = 2 * step / (true_altitude_deg(apparent + step) - true_altitude_deg(apparent - step))
    seen, is_at = np.radians(apparent), np.radians(true_deg)
    return Beam(
        true_deg=true_deg,
        apparent_deg=apparent,
        depth_straight=_over_height(straight, kinks_m),
        depth_bent=_over_height(bent, kinks_m),
        concentration=float(index(0.0) ** 2 * slope * np.sin(2 * seen) / np.sin(2 * is_at)),
    )
