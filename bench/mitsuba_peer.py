"""Mitsuba 3 on Dr.Jit's LLVM backend as a photon source: `DiscreteDistribution` and jitter, float32, one thread."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from aomc_sky.errors import MissingExtraError
from aomc_sky.extras import optional_module
from aomc_sky.grid import PatchGrid

_BATCH = 262_144
"""Photons per launch: with fewer the launches cost more, with more the caches."""


class MitsubaPeer:
    """Mitsuba set up for a table; called with a number of photons it makes them, in Dr.Jit's own reused memory.

    Parameters
    ----------
    grid : PatchGrid
        The patches.
    p : ndarray, float64, shape (n_patch,)
        Probability of each patch.

    Raises
    ------
    MissingExtraError
        Mitsuba is not installed, or it finds no LLVM library.
    """

    def __init__(self, grid: PatchGrid, p: np.ndarray) -> None:
        mi, dr = self._mi, self._dr = _mitsuba()
        near, far = grid.ring_mu()
        start, end = (np.deg2rad(edge).astype(np.float32) for edge in grid.azimuth_bounds_deg.T)
        columns = (near**2 - far**2, far**2, end - start, start)
        self._growth, self._far_mu2, self._width, self._azimuth = (mi.Float(c.astype(np.float32)) for c in columns)
        self._table = mi.DiscreteDistribution(mi.Float(p.astype(np.float32)))
        self._n_azimuth = grid.n_azimuth
        self._generators: dict[int, Any] = {}
        dr.sync_thread()

    def __call__(self, n_photons: int) -> Any:
        """Make photons batch by batch; returns the last batch."""
        vector = None
        for begin in range(0, n_photons, _BATCH):
            vector = self._launch(min(_BATCH, n_photons - begin))
        return vector

    def _launch(self, n: int) -> Any:
        dr, generator = self._dr, self._generators.setdefault(n, self._mi.PCG32(size=n))
        patch = self._table.sample(generator.next_float32())
        ring = patch // self._n_azimuth
        mu2 = self._place(self._growth, self._far_mu2, ring, generator)
        sine, cosine = dr.sincos(self._place(self._width, self._azimuth, patch - ring * self._n_azimuth, generator))
        across = dr.sqrt(1 - mu2)
        vector = self._mi.Vector3f(-across * cosine, -across * sine, -dr.sqrt(mu2))
        dr.eval(vector, generator)
        dr.sync_thread()
        return vector

    def _place(self, width: Any, start: Any, index: Any, generator: Any) -> Any:
        """A uniform place between the two bounds of a ring or column."""
        dr, kind = self._dr, self._mi.Float
        return dr.fma(dr.gather(kind, width, index), generator.next_float32(), dr.gather(kind, start, index))


def _mitsuba() -> tuple[Any, Any]:
    """Mitsuba and Dr.Jit, set to one thread, after a sum that shows that the backend works."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mi, dr = optional_module("mitsuba", extra="bench"), optional_module("drjit", extra="bench")
        try:
            mi.set_variant("llvm_ad_mono")
            dr.set_thread_count(0)  # no helpers: the calling thread works alone
            dr.eval(mi.Float(1.0, 2.0) + 1.0)
        except (ImportError, RuntimeError) as error:
            reason = str(error).strip().splitlines()[0]
            raise MissingExtraError(
                f"its LLVM backend does not start ({reason}); install LLVM's shared library, for example libllvm15"
            ) from error
    return mi, dr
