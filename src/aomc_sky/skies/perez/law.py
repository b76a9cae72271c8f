"""The law PEREZ: the flux of the Perez luminance inside each patch, as `CellLaw` asks for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from aomc_sky.component import CellLaw, Component, Law
from aomc_sky.grid import PatchGrid
from aomc_sky.kernels.arithmetic.constants import TILT_STEP
from aomc_sky.skies.perez.patches import patch_integrals, patch_moments
from aomc_sky.skies.quadrature import quarter_turns

_N_SHARED = 11
_LOW10 = np.uint32(0x3FF)


def _numbers(component: Component) -> np.ndarray:
    assert component.shared is not None  # the rules of a plan say so
    return component.shared


def _moments(component: Component) -> tuple[np.ndarray, np.ndarray]:
    grid = component.grid
    assert grid is not None
    mean, inverse = patch_moments(*quarter_turns(grid), _numbers(component))
    return mean.ravel(), inverse.ravel()


def _radiance(component: Component) -> Callable[[float, np.ndarray, np.ndarray], np.ndarray]:
    numbers = _numbers(component)
    integral = patch_integrals(*quarter_turns(PatchGrid.regular(6, 12)), numbers).sum()
    return partial(_radiance_at, (*numbers.tolist(), float(integral)))


def _radiance_at(numbers: tuple[float, ...], irradiance: float, zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Radiance of max(f, 0); gamma comes from the chord to the sun, right to the last bits beside it."""
    a, b, c, d, e, _, _, _, x, y, z, integral = numbers
    sine, mu = np.sin(zenith), np.cos(zenith)
    chord2 = (sine * np.cos(azimuth) - x) ** 2 + (sine * np.sin(azimuth) - y) ** 2 + (mu - z) ** 2
    gamma = 2.0 * np.arcsin(np.minimum(np.sqrt(chord2) / 2.0, 1.0))
    f = (1.0 + a * np.exp(b / np.maximum(mu, 1e-300))) * (1.0 + c * np.exp(d * gamma) + e * (1.0 - chord2 / 2.0) ** 2)
    return np.asarray(np.maximum(f, 0.0) * (irradiance / integral))


@dataclass(frozen=True, kw_only=True, slots=True)
class PerezBounds:
    """Tables of the exact rejection inside cells, one entry per cell; other laws take every photon."""

    #: uint32: two tilts in steps, 10 bits each, then a limit of 12 bits. A photon is taken without a look at the
    #: luminance if the upper 12 bits of its word are below the limit.
    word: np.ndarray
    #: Upper bound of the luminance, which the tilt has levelled, float64; -inf for other laws.
    bound: np.ndarray
    #: `Component.shared`, float64 (11,).
    sky: np.ndarray

    @classmethod
    def of(cls, components: Sequence[Component]) -> PerezBounds:
        """Build them from the components of a plan, one of which has the law."""
        ends = np.cumsum([component.n_cells for component in components])
        index = [component.law for component in components].index(Law.PEREZ)
        perez = components[index]
        assert perez.bounds is not None
        assert perez.shared is not None
        cells = slice(int(ends[index]) - perez.n_cells, int(ends[index]))
        upper, lower, *tilts = perez.bounds.T
        share = np.divide(lower, upper, out=np.zeros_like(lower), where=upper > 0)
        threshold = np.floor(share * 2.0**12).astype(np.uint32)  # below 2^12, for bounds keep a distance
        tilt_u, tilt_v = ((tilt / TILT_STEP).astype(np.int32).astype(np.uint32) & _LOW10 for tilt in tilts)
        word = np.full(ends[-1], 2**12 - 1, np.uint32)
        word[cells] = (tilt_u << np.uint32(22)) | (tilt_v << np.uint32(12)) | threshold
        bound = np.full(ends[-1], -np.inf)
        bound[cells] = upper
        return cls(word=word, bound=bound, sky=perez.shared)

    def for_slots(self, slots: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same for chosen cells, as the kernel reads them."""
        return self.word[slots], self.bound[slots], self.sky


PEREZ = CellLaw(
    moments=_moments,
    coordinate=lambda zenith_deg: zenith_deg,
    flux=lambda component, zenith, azimuth: patch_integrals(zenith / 90.0, azimuth / 90.0, _numbers(component)),
    radiance=_radiance,
    sun_deg=lambda component: 90.0 * _numbers(component)[5:7],
    needs_patches=True,
    instead="PerezSky(within='uniform'), or FunctionSky(model.radiance, name=...) of another model",
    tables=lambda n_cell, _: ((_N_SHARED,), (n_cell, 4)),
    starts_as=Law.CELL_MU2,
    hook="perez",
    hook_tables=PerezBounds.of,
)
