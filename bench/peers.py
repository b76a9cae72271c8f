"""Other people's samplers for the same job: photons of a table of patches, each uniform in its patch.

Every peer chooses patches by its library's own means, then places each photon uniformly in mu^2 and azimuth and turns
it into a unit vector, with that library's functions. Patches and places are drawn independently, so the error of a
peer's photons is that of the method `iid`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bench.mitsuba_peer import MitsubaPeer
from aomc_sky.errors import MissingExtraError
from aomc_sky.grid import PatchGrid

Directions = tuple[np.ndarray, np.ndarray, np.ndarray]


Peer = Callable[[int], Any]
"""A sampler that is set up once for a table, then makes any number of photons."""


class NumpyPlaces:
    """Photons uniform in their patches, as one writes it with numpy.

    Parameters
    ----------
    grid : PatchGrid
        The patches.
    mass : ndarray, float64, shape (n_patch,)
        Probability of each patch, sum 1.
    dtype : {numpy.float64, numpy.float32}
        Of random numbers and functions: numpy's own, or tuned to the precision that is delivered.
    """

    def __init__(self, grid: PatchGrid, mass: np.ndarray, dtype: type) -> None:
        self.rng = np.random.default_rng(1)
        self.mass, self.dtype, self.n_azimuth = mass, np.dtype(dtype), grid.n_azimuth
        near, far = grid.ring_mu()
        self._mu2: np.ndarray = (far**2).astype(dtype)
        self._growth: np.ndarray = (near**2 - far**2).astype(dtype)
        start, end = np.deg2rad(grid.azimuth_bounds_deg).T
        self._azimuth, self._width = start.astype(dtype), (end - start).astype(dtype)

    def place(self, patch: np.ndarray) -> Directions:
        """Travel directions, float32, one per entry of `patch`."""
        ring, column = np.divmod(patch, self.n_azimuth)
        # numpy's stub knows the two precisions as literals alone
        draw: Callable[..., np.ndarray] = self.rng.random
        mu2 = self._mu2[ring] + self._growth[ring] * draw(patch.size, dtype=self.dtype)
        azimuth = self._azimuth[column] + self._width[column] * draw(patch.size, dtype=self.dtype)
        sine = np.sqrt(1 - mu2)
        vector = -sine * np.cos(azimuth), -sine * np.sin(azimuth), -np.sqrt(mu2)
        x, y, z = (component.astype(np.float32, copy=False) for component in vector)
        return x, y, z

    def choice(self, n_photons: int) -> Directions:
        """Patches drawn one by one."""
        return self.place(self.rng.choice(self.mass.size, size=n_photons, p=self.mass))

    def multinomial(self, n_photons: int) -> Directions:
        """Photons sorted by patch."""
        return self.place(np.repeat(np.arange(self.mass.size), self.rng.multinomial(n_photons, self.mass)))


def _scipy_peers(places: NumpyPlaces) -> dict[str, Peer]:
    from scipy.stats import sampling

    generator = np.random.default_rng(2)
    alias = sampling.DiscreteAliasUrn(places.mass, random_state=generator)
    guide = sampling.DiscreteGuideTable(places.mass, random_state=generator)
    return {
        "scipy DiscreteAliasUrn": lambda n: places.place(alias.rvs(n)),
        "scipy DiscreteGuideTable": lambda n: places.place(guide.rvs(n)),
    }


def peers_of_table(grid: PatchGrid, mass: np.ndarray) -> tuple[dict[str, Peer], list[str]]:
    """Set the peers up for a table.

    Parameters
    ----------
    grid : PatchGrid
        The patches.
    mass : ndarray, float64, shape (n_patch,)
        Mass of each patch, any scale.

    Returns
    -------
    peers : dict of str to Peer
        By name, in the order of the tables.
    left_out : list of str
        A line for each that is not installed or does not work on this machine.
    """
    p = mass / mass.sum()
    places, tuned = NumpyPlaces(grid, p, np.float64), NumpyPlaces(grid, p, np.float32)
    peers: dict[str, Peer] = {
        "numpy choice": places.choice,
        "numpy multinomial + repeat": places.multinomial,
        "numpy choice, float32": tuned.choice,
        "numpy multinomial + repeat, float32": tuned.multinomial,
        **_scipy_peers(places),
    }
    try:
        peers["Mitsuba 3 DiscreteDistribution"] = MitsubaPeer(grid, p)
    except MissingExtraError as error:
        return peers, [f"Mitsuba 3 is left out: {error}"]
    return peers, []


class StoreLimit:
    """Plain stores into reused buffers of a batch: nothing that writes its photons can be faster.

    Parameters
    ----------
    batch : int
        Photons per batch.
    bytes_per_photon : {12, 24}
        Three components in float32 or in float64.
    """

    def __init__(self, batch: int, bytes_per_photon: int) -> None:
        self._arrays = [np.zeros(batch, f"f{bytes_per_photon // 3}") for _ in range(3)]
        self._batch = batch

    def __call__(self, n_photons: int) -> None:
        """Store this many photons."""
        for _ in range(0, n_photons, self._batch):
            for array in self._arrays:
                array.fill(0.5)
