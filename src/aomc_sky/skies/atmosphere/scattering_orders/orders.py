"""Successive orders of scattering in a plane column, all Fourier modes of the azimuth at once.

The radiance of light that travels down (+) and up (-) is L = sum_m (2 - [m = 0]) L_m cos(m phi), with phi the azimuth
from the sun's. Order n of it, for optical depth tau from the top and mu > 0 the cosine of a zenith angle, follows from

+-mu dL_m^n/dtau = J_m^n - L_m^n,

J_m^n(tau, +-mu) = sum_l (2 l + 1)/2 w_l(tau) V_lm(+-mu) M_lm^(n-1)(tau),

M_lm^n(tau) = sum_(+-) int_0^1 V_lm(+-mu) L_m^n(tau, +-mu) dmu, M_lm^0(tau) = B(tau) V_lm(mu0) / (2 pi).

B is the rest of the direct beam of irradiance 1, and V_lm(mu) = sqrt((l - m)! / (l + m)!) P_lm(mu). The factor w_l is a
sum over the kinds of particles: single-scattering albedo times phase moment x_l = 2 pi int p(c) P_l(c) dc. The ground
of albedo A sends up A / pi times the irradiance of the order before, in mode 0: a reflection counts as one order.

Each hemisphere has Gauss nodes in mu. Orders are summed until the rest is a geometric series to the tolerance. It is
then added in closed form, for each mode with its own ratio.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss

from aomc_sky.errors import SceneError
from aomc_sky.skies.atmosphere.scattering_orders.paths import Paths
from aomc_sky.skies.atmosphere.scattering_orders.slab import Slab

_N_PANEL, _N_GAUSS = 24, 32  # resolve a forward peak of 1 - c = 1e-6, and P_l up to l = 256 with five nodes a wave
_NORM_TOLERANCE = 1e-3


_NODE, _WEIGHT = np.polynomial.legendre.leggauss(_N_GAUSS)
_ROUGH = 1e-10  # of the integral, that halving a panel may change
_MOST_HALVINGS, _MOST_ROUGH = 40, 64

_LOW_PANEL = 0.05
_LOW_NODES = 6


def _panels(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines c and 2 pi dc on panels of v, (n_panel, n): 1 - c = 2 (v (2 - v))^4, crowded at both ends."""
    half = 0.5 * (high - low)[:, None]
    v = 0.5 * (high + low)[:, None] + half * _NODE
    t = v * (2.0 - v)
    return 1.0 - 2.0 * t**4, 32.0 * np.pi * t**3 * (1.0 - v) * _WEIGHT * half


def _is_rough(phase: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether the two halves of a panel bring another integral than the panel: a jump, a bend, a narrow peak."""
    middle = 0.5 * (low + high)
    whole, first, second = (
        np.sum(weight * phase(cosine.ravel()).reshape(cosine.shape), axis=1)
        for cosine, weight in (_panels(low, high), _panels(low, middle), _panels(middle, high))
    )
    return np.asarray(np.abs(first + second - whole) > _ROUGH)


def phase_moments(phase: Callable[[np.ndarray], np.ndarray], n_moments: int) -> np.ndarray:
    """Legendre moments x_l of a phase function, l = 0 to n_moments - 1, at most 256. x_0 is 1: the solver conserves
    energy.

    A SceneError where the norm is off by more than 1e-3. Accuracy: 1e-12 for smooth functions and peaks down to 1 - c =
    1e-5, 1e-9 with jumps and bends, which panels are halved towards.
    """
    edges = np.linspace(0.0, 1.0, _N_PANEL + 1)
    low, high = edges[:-1], edges[1:]
    for _ in range(_MOST_HALVINGS):
        rough = _is_rough(phase, low, high)
        if not 0 < np.count_nonzero(rough) <= _MOST_ROUGH:
            break
        middle = 0.5 * (low + high)[rough]
        low = np.concatenate([low[~rough], low[rough], middle])
        high = np.concatenate([high[~rough], middle, high[rough]])
    cosine, weight = (each.ravel() for each in _panels(low, high))
    table = np.empty((n_moments, cosine.size))  # P_l(c)
    before, here = np.zeros(cosine.size), np.ones(cosine.size)
    for degree in range(n_moments):
        table[degree] = here
        before, here = here, ((2 * degree + 1) * cosine * here - degree * before) / (degree + 1)
    moments = (weight * table) @ phase(cosine)
    if not abs(moments[0] - 1.0) < _NORM_TOLERANCE:
        raise SceneError(f"a phase function has the integral {moments[0]:.6g} over the sphere; expected 1")
    return moments / moments[0]


def legendre_table(mu: np.ndarray, n_modes: int, n_moments: int) -> np.ndarray:
    """Normalised associated Legendre functions (n_modes, n_moments, n): V_lm(mu) at [m, l - m], zeros from l =
    n_moments on.

    V_lm(-mu) = (-1)^(l - m) V_lm(mu), so parity is that of the column. Accuracy: 2e-13 absolute for 60
    moments, 5e-12 for 400.
    """
    order = np.arange(n_modes, dtype=float)[:, None]
    steps = np.arange(1, n_modes, dtype=float)[:, None]
    sine = np.sqrt((1.0 - mu) * (1.0 + mu))
    factors = np.sqrt((2.0 * steps - 1.0) / (2.0 * steps)) * sine
    here = np.vstack([np.ones((1, mu.size)), np.cumprod(factors, axis=0)])
    before = np.zeros_like(here)
    table = np.zeros((n_modes, n_moments, mu.size))
    for offset in range(n_moments):
        table[:, offset] = np.where(order + offset < n_moments, here, 0.0)
        degree = order + offset + 1.0  # the next one
        ahead = (2.0 * degree - 1.0) * mu * here - np.sqrt((degree - 1.0) ** 2 - order**2) * before
        before, here = here, ahead / np.sqrt(degree**2 - order**2)
    return table


@dataclass(frozen=True, kw_only=True, slots=True)
class Angles:
    """Gauss nodes of one hemisphere and the Legendre functions there, split by their parity in mu."""

    #: mu, weight: (n_mu,) nodes and weights of int_0^1 dmu
    mu: np.ndarray
    weight: np.ndarray
    #: even, odd: (n_modes, n_half, n_mu) V_lm for l - m even and odd
    even: np.ndarray
    odd: np.ndarray
    n_moments: int  #: Degrees l < n_moments, 2 n_mu at most


def split_table(mu: np.ndarray, n_modes: int, n_moments: int) -> tuple[np.ndarray, np.ndarray]:
    """Legendre functions with l - m even and odd, each (n_modes, n_half, n); an odd number of degrees gets a row of
    zeros.
    """
    table = legendre_table(mu, n_modes, n_moments)
    if n_moments % 2:
        table = np.concatenate([table, np.zeros((n_modes, 1, mu.size))], axis=1)
    return np.ascontiguousarray(table[:, 0::2]), np.ascontiguousarray(table[:, 1::2])


@lru_cache(maxsize=8)
def gauss_angles(n_mu: int, n_moments: int) -> Angles:
    """Gauss nodes on (0, 1) in two panels, with their Legendre functions, as many modes as degrees.

    Radiance over a thin column bends within a few degrees of the horizon; the panel below mu = 0.05 is for that.
    """
    n_low = min(_LOW_NODES, n_mu // 2)
    panels = ((0.0, _LOW_PANEL, n_low), (_LOW_PANEL, 1.0, n_mu - n_low))
    nodes = [(a + (b - a) * 0.5 * (1.0 + x), (b - a) * 0.5 * w) for a, b, n in panels for x, w in (leggauss(n),)]
    mu, weight = np.concatenate([x for x, _ in nodes]), np.concatenate([w for _, w in nodes])
    even, odd = split_table(mu, n_moments, n_moments)
    for each in (mu, weight, even, odd):  # the cache hands them out again
        each.flags.writeable = False
    return Angles(mu=mu, weight=weight, even=even, odd=odd, n_moments=n_moments)


_LAST_ORDER = 400

_MODE_FLOOR = 1e-8  # a mode ends when what it would still add is this small a share of mode 0's sum
_REST_TOLERANCE = 1e-6
_SLOWEST = 0.95


@dataclass(frozen=True, kw_only=True, slots=True)
class OrderMoments:
    """Moments M of the orders, what a source function in any direction needs, for a beam of irradiance 1."""

    #: (2, up to n_modes, n_half, n_level) orders 1 to n_listed - 1. Their light comes down in orders 2 to n_listed. The
    #: first axis is the parity of l - m. Modes that have died out are cut
    listed: tuple[np.ndarray, ...]
    #: (2, n_modes, n_half, n_level) orders from 1 on that another order follows, with the geometric rest
    total: np.ndarray
    irradiance: np.ndarray  #: (n_listed + 1,) E of orders 0 (the beam) to n_listed on the ground
    irradiance_total: float  #: E of all orders >= 1


def scattering_moments(slab: Slab, kinds: np.ndarray, n_modes: int) -> np.ndarray:
    """(2 l + 1)/2 w_l at the nodes of a slab by parity of l - m, (2, n_modes, n_half, n_level), of x_l (n_kind,
    n_moments).
    """
    n_kind, n_moments = kinds.shape
    n_even = n_moments + n_moments % 2
    padded = np.pad(kinds, ((0, 0), (0, n_even - n_moments + n_modes)))
    padded[:, :n_even] *= np.arange(n_even) + 0.5
    rows = padded[:, np.arange(n_modes)[:, None] + np.arange(n_even)]  # arranged like `legendre_table`
    share = slab.scattering.reshape(n_kind, -1)
    return np.stack([np.tensordot(rows[:, :, parity::2], share, axes=(0, 0)) for parity in (0, 1)])


class _Column:
    """One wavelength's column, ready to turn the moments of an order into those of the next."""

    def __init__(self, paths: Paths, angles: Angles, moments: np.ndarray, albedo: float) -> None:
        self.paths = paths
        self.down, self.up = paths.down.swapaxes(1, 2), paths.up.swapaxes(1, 2)
        self.over = None if paths.over is None else paths.over.swapaxes(1, 2)
        self.scattering = moments
        self.tables = (angles.even, angles.odd)
        self.weighted = (angles.even * angles.weight, angles.odd * angles.weight)
        self.flux_weight = 2.0 * np.pi * angles.weight * angles.mu
        self.albedo = albedo

    def next_order(self, moments: np.ndarray, irradiance: float) -> tuple[np.ndarray, float]:
        """Moments (2, n_modes, n_half, n_level) and irradiance of the order after the given one."""
        n = moments.shape[1]
        even, odd = (np.matmul(self.tables[p][:n].swapaxes(1, 2), self.scattering[p, :n] * moments[p]) for p in (0, 1))
        source_down, source_up = even + odd, even - odd
        down = np.matmul(source_down.swapaxes(0, 1), self.down).swapaxes(0, 1)
        up = np.matmul(source_up.swapaxes(0, 1), self.up).swapaxes(0, 1)
        if self.over is not None:
            up += np.matmul(source_down.swapaxes(0, 1), self.over).swapaxes(0, 1)
        up[0] += self.albedo / np.pi * irradiance * self.paths.from_ground
        at_ground = np.einsum("ik,ik->i", self.paths.at_ground, source_down[0])
        both = np.stack([np.matmul(self.weighted[0][:n], down + up), np.matmul(self.weighted[1][:n], down - up)])
        return both, float(self.flux_weight @ at_ground)


def beam_moments(slab: Slab, mu0: float, n_modes: int, n_moments: int) -> np.ndarray:
    """Moments of the direct beam, order 0, shape (2, n_modes, n_half, n_level)."""
    table = np.stack(split_table(np.array([mu0]), n_modes, n_moments))
    return table * slab.beam.ravel() / (2.0 * np.pi)


def sum_orders(
    slab: Slab,
    paths: Paths,
    scattering: np.ndarray,
    angles: Angles,
    mu0: float,
    albedo: float,
    *,
    last_order: int | None,
    n_listed: int,
) -> OrderMoments:
    """Work out the orders up to `last_order`, or all (None), with the rest as a geometric series."""
    column = _Column(paths, angles, scattering, albedo)
    moments = beam_moments(slab, mu0, scattering.shape[1], angles.n_moments)
    irradiance = max(mu0, 0.0) * slab.beam_at_ground
    listed, fluxes = [], np.zeros(n_listed + 1)
    fluxes[0] = irradiance
    total, flux_total = np.zeros_like(moments), 0.0
    rest = GeometricRest(moments.shape[1])
    for order in range(1, (last_order or _LAST_ORDER) + 1):
        moments, irradiance = column.next_order(moments[:, : rest.n_active], irradiance)
        n = moments.shape[1]
        if order != last_order:
            total[:, :n] += moments
        flux_total += irradiance
        if order <= n_listed:
            fluxes[order] = irradiance
        if order < n_listed:
            listed.append(moments)
        rest.watch(moments, total, is_listed=order <= n_listed)
        if last_order is None and order >= max(3, n_listed) and rest.is_settled:
            break
    left = 0.0
    if last_order is None:
        total[:, :n] += rest.gain[:, None, None] * moments
        left = irradiance * float(rest.gain[0])
    return OrderMoments(listed=tuple(listed), total=total, irradiance=fluxes, irradiance_total=flux_total + left)


def light_from_ground(
    slab: Slab, paths: Paths, scattering: np.ndarray, angles: Angles, mu0: float, albedo: float
) -> np.ndarray:
    """Moments (2, n_modes, n_half, n_level) of the part of order 1 that is the direct beam, reflected by the ground."""
    column = _Column(paths, angles, scattering, albedo)
    dark = np.zeros_like(beam_moments(slab, mu0, scattering.shape[1], angles.n_moments))
    return column.next_order(dark, max(mu0, 0.0) * slab.beam_at_ground)[0]


class GeometricRest:
    """Watches how each mode shrinks from order to order, and says what all later orders would add.

    A mode of size s and ratio r to the order before leaves r / (1 - r) times itself. The change d of the ratio, the
    larger one of the last two steps, continues as a geometric series of ratio q. The error is s d / (1 - q) / (1 -
    r)^2.
    """

    def __init__(self, n_modes: int) -> None:
        self._size = np.full(n_modes, np.nan)
        self._ratio = np.full(n_modes, np.nan)
        self._drift = np.full(n_modes, np.inf)
        self.gain = np.zeros(n_modes)
        self.error = np.inf
        self.n_active = n_modes

    def watch(self, moments: np.ndarray, total: np.ndarray, *, is_listed: bool) -> None:
        """Take in the moments of one more order, and the sum up to it; a listed order keeps what counts in itself."""
        n = moments.shape[1]
        size, scale = _mode_sizes(moments), max(float(_mode_sizes(total[:, :1])[0]), np.finfo(float).tiny)
        ratio = size / np.maximum(self._size[:n], np.finfo(float).tiny)
        short = np.maximum(1.0 - ratio, 1e-3)
        drift = np.abs(ratio - self._ratio[:n])
        self.gain = ratio / short
        worst = np.maximum(drift, self._drift[:n])
        slow = np.divide(drift, self._drift[:n], out=np.zeros(n), where=self._drift[:n] > 0.0)
        ahead = worst / (1.0 - np.minimum(slow, _SLOWEST))
        lit = size > 0.0
        self.error = float(np.max(size[lit] * ahead[lit] / short[lit] ** 2, initial=0.0) / scale)
        self._size, self._ratio, self._drift = size, ratio, np.where(np.isfinite(drift), drift, np.inf)
        floor = _MODE_FLOOR * min(scale, 100.0 * size[0]) if is_listed else _MODE_FLOOR * scale
        dead = size * self.gain <= floor  # false where the ratio is not known yet
        dead[0] = False
        self.n_active = int(np.max(np.nonzero(~dead)[0])) + 1

    @property
    def is_settled(self) -> bool:
        """Whether the rest is a geometric series to the tolerance."""
        return self.error <= _REST_TOLERANCE


def _mode_sizes(moments: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("pmlk,pmlk->m", moments, moments))
