"""Mitsuba 3 on Dr.Jit's LLVM backend as a photon source: `DiscreteDistribution` and jitter, float32, one thread."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from aomc_sky.errors import MissingExtraError
from aomc_sky.extras import optional_module
from aomc_sky.grid import PatchGrid

_BATCH = 262_144
"""Photons per launch: with fewer the launches cost more, with more the caches."""


def mitsuba_peer(grid: PatchGrid, p: np.ndarray) -> Callable[[int], Any]:
    """Set Mitsuba up for a table.

    Parameters
    ----------
    grid : PatchGrid
        The patches.
    p : ndarray, float64, shape (n_patch,)
        Probability of each patch.

    Returns
    -------
    callable
        Takes a number of photons and makes them, batch by batch into Dr.Jit's own reused memory; returns the
        last batch.

    Raises
    ------
    MissingExtraError
        Mitsuba is not installed, or it finds no LLVM library.
    """
    mi, dr = _mitsuba()
    near, far = grid.ring_mu()
    far_mu2, growth = (mi.Float(column.astype(np.float32)) for column in (far**2, near**2 - far**2))
    start, end = (np.deg2rad(edge).astype(np.float32) for edge in grid.azimuth_bounds_deg.T)
    azimuth, width = mi.Float(start), mi.Float(end - start)
    table = mi.DiscreteDistribution(mi.Float(p.astype(np.float32)))
    generators: dict[int, Any] = {}

    def launch(n: int) -> Any:
        generator = generators.setdefault(n, mi.PCG32(size=n))
        patch = table.sample(generator.next_float32())
        ring = patch // grid.n_azimuth
        column = patch - ring * grid.n_azimuth
        mu2 = dr.fma(dr.gather(mi.Float, growth, ring), generator.next_float32(), dr.gather(mi.Float, far_mu2, ring))
        turn = dr.fma(
            dr.gather(mi.Float, width, column), generator.next_float32(), dr.gather(mi.Float, azimuth, column)
        )
        sine, cosine = dr.sincos(turn)
        across = dr.sqrt(1 - mu2)
        vector = mi.Vector3f(-across * cosine, -across * sine, -dr.sqrt(mu2))
        dr.eval(vector, generator)
        dr.sync_thread()
        return vector

    def sample(n_photons: int) -> Any:
        vector = None
        for begin in range(0, n_photons, _BATCH):
            vector = launch(min(_BATCH, n_photons - begin))
        return vector

    return sample


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
