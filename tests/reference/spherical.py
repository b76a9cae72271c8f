"""Rays through a spherical atmosphere the slow way: vectors, one ray at a time, no tables, no shared variables."""

from itertools import pairwise

import mpmath
import numpy as np

_NODE, _WEIGHT = np.polynomial.legendre.leggauss(24)
_END_NODE, _END_WEIGHT = np.polynomial.legendre.leggauss(16)


def exponential_column(radius_m, top_m, scale_m, altitude_m, zenith):
    """Integral of exp(-h/scale) along a ray from an altitude to the top, to 20 digits; zenith in [0, pi] [m]."""
    with mpmath.workdps(25):
        radius, top, scale, start = (mpmath.mpf(x) for x in (radius_m, top_m, scale_m, altitude_m))
        start += radius
        mu = mpmath.cos(zenith)
        end = -start * mu + mpmath.sqrt((start * mu) ** 2 + (radius + top) ** 2 - start**2)
        lowest = max(-start * mu, mpmath.mpf(0))

        def density(s):
            return mpmath.exp(-(mpmath.sqrt(start**2 + s * s + 2 * start * mu * s) - radius) / scale)

        cuts = [mpmath.mpf(0), lowest]
        for k in range(-6, 1):
            step = (end - lowest) * mpmath.mpf(4) ** k
            cuts += [lowest + step, max(lowest - step, mpmath.mpf(0))]
        return mpmath.quad(density, sorted(set(cuts)))


class SlowRays:
    """Order 1 of a medium at one wavelength, in single directions; quadratures are cut at the altitudes `cut_m`."""

    def __init__(self, medium, cut_m, row=0):
        self.medium = medium
        self.cut_m = (*cut_m, medium.top_m)
        self.row = row
        self.radius = medium.earth_radius_m

    def _crossings(self, point, direction, altitude_m):
        """Distances ahead at which a ray crosses an altitude."""
        along = point @ direction
        rest = (self.radius + altitude_m) ** 2 - point @ point + along**2
        if rest < 0:
            return []
        return [s for s in (-along - np.sqrt(rest), -along + np.sqrt(rest)) if s > 0]

    def _density(self, altitude_m, weights):
        inside = np.clip(altitude_m, 0, self.medium.top_m)
        parts = zip(weights, self.medium.constituents, strict=True)
        return sum((w * part.number_density(inside) for w, part in parts), np.zeros_like(altitude_m))

    def depth(self, point, direction, length=None):
        """Optical depth of a stretch, or to the top; infinite behind the ground."""
        r = np.linalg.norm(point)
        along = point @ direction
        if length is None and along < 0 and r * r - along**2 < (self.radius * (1 - 1e-15)) ** 2:
            return np.inf
        end = max(self._crossings(point, direction, self.medium.top_m), default=0.0) if length is None else length
        cuts = {0.0, end, min(max(-along, 0.0), end)}
        for altitude in self.cut_m:
            cuts |= {s for s in self._crossings(point, direction, altitude) if s < end}
        extinction = [
            float(part.scattering_m2[self.row] + part.absorption_m2[self.row]) for part in self.medium.constituents
        ]
        total = 0.0
        for low, high in pairwise(sorted(cuts)):
            s = 0.5 * (low + high) + 0.5 * (high - low) * _NODE
            q = s * (s + 2 * along)
            altitude = (r - self.radius) + q / (np.sqrt(np.maximum(r * r + q, 0)) + r)
            total += 0.5 * (high - low) * float(self._density(altitude, extinction) @ _WEIGHT)
        return total

    def radiance(self, sun_zenith, zenith, azimuth):
        """Radiance of order 1 for an irradiance of 1 [sr-1]."""
        sun = np.array([np.sin(sun_zenith), 0, np.cos(sun_zenith)])
        view = np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)])
        eye = np.array([0, 0, self.radius])
        cosine = np.array([min(max(sun @ view, -1.0), 1.0)])
        scattering = [
            float(part.scattering_m2[self.row] * part.phase_function(cosine, self.row)[0])
            if part.phase_function
            else 0.0
            for part in self.medium.constituents
        ]
        total = 0.0
        for low, high in pairwise(self._view_cuts(eye, view, sun)):
            t = 0.5 * (1 + _END_NODE)
            for share, weight in zip(t, _END_WEIGHT, strict=True):
                s = low + (high - low) * share**2
                point = eye + s * view
                q = s * (s + 2 * (eye @ view))
                altitude = np.array([q / (np.sqrt(self.radius**2 + q) + self.radius)])
                seen = np.exp(-self.depth(point, sun) - self.depth(eye, view, s))
                total += weight * share * (high - low) * float(self._density(altitude, scattering)[0]) * seen
        return total

    def _view_cuts(self, eye, view, sun):
        """Where the way looked along is cut: altitudes, the shadow's edge, and where the sun's ray touches a kink."""
        end = max(self._crossings(eye, view, self.medium.top_m))

        def lowest(s):
            point = eye + s * view
            along = point @ sun
            return np.inf if along >= 0 else np.sqrt(point @ point - along**2) - self.radius

        dark = self._first(lambda s: lowest(s) >= 0, end)
        cuts = {dark, end}
        for altitude in self.cut_m:
            touched = self._first(lambda s, altitude=altitude: lowest(s) >= altitude, end)
            cuts |= {s for s in [*self._crossings(eye, view, altitude), touched] if dark < s < end}
        return sorted(cuts)

    @staticmethod
    def _first(is_true, end):
        """Where something along the way becomes true, by halving; 0 where it is true from the start."""
        low, high = 0.0, end
        if is_true(1e-9 * end):
            return 0.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_true(middle) else (middle, high)
        return high
