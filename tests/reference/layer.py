"""Multiple scattering in a layer without any random number: transfer matrices, doubling, Fresnel surfaces.

Independent of the transport example in method and in code: radiance averaged over azimuth on Gauss nodes, the
phase function as a sum of Legendre polynomials, one thin layer by a matrix exponential, thick ones by doubling
(Plass, Kattawar and Catchings 1973, Applied Optics 12, 314). Vectors hold radiance at the nodes `mu`.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.special import eval_legendre, roots_legendre


@dataclass(frozen=True, kw_only=True)
class Nodes:
    """Cosines and weights of an integral over (0, 1); those above `critical` have a place in the air."""

    mu: np.ndarray
    weight: np.ndarray
    index: float

    @property
    def air_mu(self):
        """Cosine in the air, NaN beyond the critical angle."""
        square = 1 - self.index**2 * (1 - self.mu**2)
        return np.sqrt(np.where(square > 0, square, np.nan))


def nodes(n, index=1.0):
    """Nodes in a panel on each side of the critical angle, where Fresnel's curve has a kink; 1 without weight last."""
    critical = np.sqrt(1 - 1 / index**2)
    x, w = roots_legendre(n)
    parts = []
    for low, high in ((0.0, critical), (critical, 1.0)):
        if high > low:  # squared towards the critical angle, where Fresnel's curve is as steep as a root
            t, s = (x + 1) / 2, w / 2
            power = 2 if low > 0 else 1
            parts.append((low + (high - low) * t**power, (high - low) * s * power * t ** (power - 1)))
    mu, weight = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Nodes(mu=np.append(mu, 1.0), weight=np.append(weight, 0.0), index=index)


def fresnel(air_mu, index):
    """Unpolarised reflectance from angles, by Fresnel's sine and tangent formulas; 1 where air_mu is NaN."""
    air = np.arccos(air_mu)
    water = np.arcsin(np.sin(air) / index)
    with np.errstate(invalid="ignore"):
        across = np.sin(air - water) / np.sin(air + water)
        along = np.tan(air - water) / np.tan(air + water)
    both = np.where(air_mu == 1, ((index - 1) / (index + 1)) ** 2, (across**2 + along**2) / 2)
    return np.where(np.isnan(air_mu), 1.0, both)


def scattering_kernel(at, moments):
    """Phase function averaged over azimuth, forward and backward, normalised to 2 over (-1, 1)."""
    order = np.arange(moments.size)
    polynomials = np.array([eval_legendre(k, at.mu) for k in order])
    scaled = (2 * order + 1) * moments
    forward = polynomials.T * scaled @ polynomials
    backward = polynomials.T * (scaled * (-1.0) ** order) @ polynomials
    return forward, backward


def layer(at, optical_depth, albedo, moments):
    """Reflection and transmission matrices of a layer, radiance to radiance, direct light included."""
    forward, backward = scattering_kernel(at, moments)
    doublings = max(0, int(np.ceil(np.log2(optical_depth / at.mu.min()))) + 1)
    step = optical_depth / 2.0**doublings
    loss = (np.eye(at.mu.size) - albedo / 2 * forward * at.weight) / at.mu[:, None]
    gain = (albedo / 2 * backward * at.weight) / at.mu[:, None]
    n = at.mu.size
    transfer = expm(step * np.block([[-loss, gain], [-gain, loss]]))  # (down, up) at the top to those at the base
    inverse = np.linalg.inv(transfer[n:, n:])
    reflection = -inverse @ transfer[n:, :n]
    transmission = transfer[:n, :n] + transfer[:n, n:] @ reflection
    for _ in range(doublings):
        between = np.linalg.inv(np.eye(n) - reflection @ reflection)
        reflection = reflection + transmission @ between @ reflection @ transmission
        transmission = transmission @ between @ transmission
    return reflection, transmission


def at_normal_incidence(at, optical_depth, albedo, moments):
    """Reflected and transmitted shares of a vertical beam; by reciprocity the radiance there under a sky of 1."""
    reflection, transmission = layer(at, optical_depth, albedo, moments)
    return float(reflection[-1].sum()), float(transmission[-1].sum())


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Shares of the irradiance above the surface."""

    reflected: float
    leaving: float
    to_bottom: float


def under_uniform_sky(at, optical_depth, albedo, moments, bottom_reflectance=0.0):
    """A layer under a flat surface and a uniform sky, over a Lambertian bottom."""
    reflection, transmission = layer(at, optical_depth, albedo, moments)
    surface = fresnel(at.air_mu, at.index)
    flux = 2 * at.mu * at.weight  # of radiance 1: irradiance 1, pi left out
    bottom = bottom_reflectance * np.tile(flux, (at.mu.size, 1))
    back = np.linalg.inv(np.eye(at.mu.size) - reflection @ bottom) @ transmission
    upward = reflection + transmission @ bottom @ back
    sky = (1 - surface) * at.index**2
    down = np.linalg.solve(np.eye(at.mu.size) - surface[:, None] * upward, sky)
    up = upward @ down
    leaving = float(flux @ ((1 - surface) * up))
    to_bottom = float(flux @ (back @ down))
    return Balance(reflected=1 - float(flux @ sky), leaving=leaving, to_bottom=to_bottom)
