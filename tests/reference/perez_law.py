"""The continuous Perez sky, without patches: adaptive quadrature, written from eq. (1) alone.

Nothing here knows the package. A sky is five coefficients a to e and the sun's zenith angle; the law of a photon
through a horizontal surface has the density max(f, 0) cos(zenith) per solid angle, which is max(f, 0) itself on the
rectangle of u = sin^2(zenith angle) and azimuth. Angles are in radians, azimuths count from the sun's.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

ORDER = 8
DEEPEST = 48


@dataclass(frozen=True, kw_only=True, slots=True)
class PerezLaw:
    """One sky: coefficients (a, b, c, d, e) with b <= 0, and the sun's zenith angle. [rad, 0 to pi/2)

    `clipped` False leaves negative values, for integrals of eq. (1) as it stands; photons never see them. A sky with
    negative values clipped has kinks, where a quadrature of `tolerance` 1e-10 of the whole takes a minute.
    """

    coefficients: tuple[float, float, float, float, float]
    sun_zenith_rad: float
    clipped: bool = True
    tolerance: float = 1e-10

    def __post_init__(self):
        if not self.coefficients[1] <= 0 or not 0 <= self.sun_zenith_rad < np.pi / 2:
            raise ValueError("the oracle wants b <= 0 and the sun above the horizon")

    def luminance(self, mu, gamma):
        """Eq. (1); `mu` = cos(zenith angle), `gamma` = angle from the sun."""
        a, b, c, d, e = self.coefficients
        lit = mu > 0
        inner = np.where(lit, np.exp(b / np.where(lit, mu, 1.0)), 1.0 if b == 0 else 0.0)
        value = (1 + a * inner) * (1 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)
        return np.maximum(value, 0.0) if self.clipped else value

    def over_patch(self, zenith, azimuth):
        """Flux density per d(zenith angle) d(azimuth): smooth up to the zenith, where sqrt(u) is not."""
        mu, sine = np.cos(zenith), np.sin(zenith)
        return self.luminance(mu, self.angle_from_sun(mu, sine, azimuth)) * mu * sine

    def angle_from_sun(self, mu, sine, azimuth):
        """Angle between a direction and the sun by half the chord: sharp beside the sun."""
        s, c = np.sin(self.sun_zenith_rad), np.cos(self.sun_zenith_rad)
        chord2 = (sine - s) ** 2 + 4 * sine * s * np.sin(azimuth / 2) ** 2 + (mu - c) ** 2
        return 2 * np.arcsin(np.minimum(np.sqrt(chord2) / 2, 1.0))

    def mu_from_sun(self, gamma, psi):
        """cos(zenith angle) at the angle gamma from the sun; psi = 0 points away from the zenith."""
        s, c = np.sin(self.sun_zenith_rad), np.cos(self.sun_zenith_rad)
        return np.cos(gamma) * c - np.sin(gamma) * s * np.cos(psi)

    def around_sun(self, gamma, psi):
        """Flux density per d(gamma) d(psi), 0 below the horizon."""
        mu = self.mu_from_sun(gamma, psi)
        return self.luminance(mu, gamma) * np.maximum(mu, 0.0) * np.sin(gamma)


def integrate_boxes(function, boxes, tolerance):
    """Integrals over rectangles (n, 4) of x0, x1, y0, y1, and a bound of the sum of their errors.

    Each is split in four until its Gauss sum and that of its quarters agree: the disagreements add up to the
    tolerance, relative to the sum of the integrals, at most.
    """
    owner, coarse = np.arange(len(boxes)), _gauss(function, boxes)
    total, error, scale = np.zeros(len(boxes)), 0.0, np.abs(coarse).sum()
    for _ in range(DEEPEST):
        quarters = _quarters(boxes)
        parts = _gauss(function, quarters).reshape(-1, 4)
        off = np.abs(parts.sum(axis=1) - coarse)
        done = off <= tolerance * scale / (8 * max(len(total), len(boxes)))
        np.add.at(total, owner[done], parts[done].sum(axis=1))
        error += off[done].sum()
        if done.all():
            return total, float(error)
        owner, boxes, coarse = (
            np.repeat(owner[~done], 4),
            quarters.reshape(-1, 4, 4)[~done].reshape(-1, 4),
            parts[~done].ravel(),
        )
    raise AssertionError(f"{len(boxes)} boxes do not converge after {DEEPEST} halvings")


def _quarters(boxes):
    x0, x1, y0, y1 = boxes.T
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    split = [(x0, x, y0, y), (x, x1, y0, y), (x0, x, y, y1), (x, x1, y, y1)]
    return np.stack([np.stack(part, axis=1) for part in split], axis=1).reshape(-1, 4)


def _gauss(function, boxes):
    node, weight = np.polynomial.legendre.leggauss(ORDER)
    x0, x1, y0, y1 = (edge[:, None] for edge in boxes.T)
    x = ((x0 + x1) / 2 + (x1 - x0) / 2 * node)[:, :, None]
    y = ((y0 + y1) / 2 + (y1 - y0) / 2 * node)[:, None, :]
    value = function(*np.broadcast_arrays(x, y))
    return np.einsum("nij,i,j->n", value, weight, weight) * ((x1 - x0) * (y1 - y0) / 4)[:, 0]


def _product_boxes(x_edges, y_edges):
    x0, y0 = np.meshgrid(x_edges[:-1], y_edges[:-1], indexing="ij")
    x1, y1 = np.meshgrid(x_edges[1:], y_edges[1:], indexing="ij")
    return np.stack([x0, x1, y0, y1], axis=-1).reshape(-1, 4)


def flux_over_sky(law, quantity):
    """Integral of max(f, 0) cos(zenith) times a quantity over the hemisphere, in coordinates around the sun.

    Around the sun nothing is cut up to gamma = pi/2 - Z; beyond, gamma = pi/2 - Z cos(t) and psi from where the
    horizon cuts, so that the integrand is smooth on both rectangles and the sun is an edge. The quantity is a function
    of the direction (ux, uy, uz) towards the sky, x towards the sun's azimuth, even in uy. The relative error is below
    ten tolerances, which is checked.
    """
    z = law.sun_zenith_rad
    s, c = np.sin(z), np.cos(z)

    def at(gamma, psi):
        x = np.cos(gamma) * s + np.sin(gamma) * np.cos(psi) * c
        y = np.sin(gamma) * np.sin(psi)
        return law.around_sun(gamma, psi) * quantity(x, y, law.mu_from_sun(gamma, psi))

    def beyond(t, place):
        gamma = np.pi / 2 - z * np.cos(t)
        first = np.arccos(np.clip(c / s * np.cos(gamma) / np.sin(gamma), -1.0, 1.0))
        return at(gamma, first + (np.pi - first) * place) * (np.pi - first) * z * np.sin(t)

    near, error = integrate_boxes(
        at, _product_boxes(np.linspace(0, np.pi / 2 - z, 5), np.linspace(0, np.pi, 5)), law.tolerance
    )
    total = near.sum()
    if z > 0:
        far, more = integrate_boxes(
            beyond, _product_boxes(np.linspace(0, np.pi, 5), np.linspace(0, 1, 5)), law.tolerance
        )
        total, error = total + far.sum(), error + more
    if not error <= 10 * law.tolerance * max(abs(total), abs(near).sum()):
        raise AssertionError(f"the quadrature is off by {error:g} of {total:g}")
    return 2 * float(total)


def mean(law, quantity):
    """Mean of a quantity over photons: see `flux_over_sky`. Relative error below 2e-9 for positive quantities."""
    return flux_over_sky(law, quantity) / flux_over_sky(law, lambda x, y, mu: np.ones_like(mu))


def patch_flux(law, zenith_edges_deg, azimuth_edges_deg):
    """Integral of max(f, 0) cos(zenith) over each cell of zenith angle and azimuth from the sun.

    Shape (n_zenith, n_azimuth). Error below ten tolerances of the whole.
    """
    boxes = _product_boxes(np.deg2rad(zenith_edges_deg), np.deg2rad(azimuth_edges_deg))
    flux, _ = integrate_boxes(law.over_patch, boxes, law.tolerance)
    return flux.reshape(len(zenith_edges_deg) - 1, len(azimuth_edges_deg) - 1)


def patch_shares(law, zenith_edges_deg, azimuth_edges_deg):
    """Share of the photons in each cell of a hemisphere: `patch_flux` over its sum."""
    flux = patch_flux(law, zenith_edges_deg, azimuth_edges_deg)
    return flux / flux.sum()


def cone_shares(law, gamma_edges_rad, n_sectors):
    """Share of all photons in rings around the sun, each in equal sectors of psi, shape (n_ring, n_sectors).

    The rings must lie above the horizon: edges up to pi/2 - Z. Error below ten tolerances of the whole.
    """
    if gamma_edges_rad[-1] > np.pi / 2 - law.sun_zenith_rad:
        raise ValueError("the cone must lie above the horizon")
    boxes = _product_boxes(gamma_edges_rad, np.linspace(0, 2 * np.pi, n_sectors + 1))
    flux, _ = integrate_boxes(law.around_sun, boxes, law.tolerance)
    whole = flux_over_sky(law, lambda x, y, mu: np.ones_like(mu))
    return (flux / whole).reshape(-1, n_sectors)


def cone_places(law, gamma, radius_rad):
    """Distribution function of the angle from the sun among the photons within a cone: uniform on [0, 1].

    Error below 1e-8: cubic Hermite between 129 sums by quadrature, with the exact slope.
    """
    edges = np.linspace(0.0, radius_rad, 129)
    flux = np.append(0.0, np.cumsum(cone_shares(law, edges, 1)[:, 0]))
    node, weight = np.polynomial.legendre.leggauss(64)
    slope = law.around_sun(edges[:, None], np.pi * (1 + node)) @ weight * np.pi
    slope /= flux_over_sky(law, lambda x, y, mu: np.ones_like(mu))
    return CubicHermiteSpline(edges, flux / flux[-1], slope / flux[-1])(gamma)


def around_the_sun(law, mu, u, azimuth):
    """Angle from the sun and psi [0 to 2 pi) of directions."""
    sine = np.sqrt(u)
    s, c = np.sin(law.sun_zenith_rad), np.cos(law.sun_zenith_rad)
    across = c * sine * np.cos(azimuth) - s * mu
    psi = np.mod(np.arctan2(sine * np.sin(azimuth), across), 2 * np.pi)
    return law.angle_from_sun(mu, sine, azimuth), psi
