"""The skies of the benchmark: what shines, the same as a table for samplers that know patches alone, and the truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez.sky import PerezSky
from aomc_sky.skies.tabulated import TabulatedSky, Weighting
from aomc_sky.skies.uniform import UniformSky
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands
from bench.quantities import WAVELENGTH_NM, Truth, truth_of_perez, truth_of_table

N_ZENITH, N_AZIMUTH = 90, 360
PEER_SKY = "clear-uniform"
"""The sky whose table other people's samplers get."""


@dataclass(frozen=True, kw_only=True)
class BenchSky:
    """A sky that is sampled for its error."""

    #: name, title: Name in files; and for a person.
    name: str
    title: str
    #: Patches of the table.
    grid: PatchGrid
    #: Mass of each patch, any scale. [shape (n_patch,)]
    mass: np.ndarray
    #: The model, where photons follow its own law; None: the table is the sky, uniform inside the patches.
    model: PerezSky | UniformSky | None = None

    @property
    def is_table(self) -> bool:
        """Whether a sampler that knows patches alone can sample this sky without error."""
        return not isinstance(self.model, PerezSky)

    @cached_property
    def truth(self) -> Truth:
        """Exact values of the quantities, and how exact they are."""
        if isinstance(self.model, PerezSky):
            return truth_of_perez(self.model)
        return truth_of_table(self.grid, self.mass)

    def scene(self, n_photons: int, *, as_table: bool = False) -> Scene:
        """One waveband of this sky, or of its table of patches."""
        parts = self._table if self.model is None or as_table else self._parts
        bands = Wavebands(wavelength_nm=np.array([WAVELENGTH_NM]))
        return Scene(wavebands=bands, n_photons=np.array([n_photons]), components=parts)

    @cached_property
    def _parts(self) -> tuple[Component, ...]:
        assert self.model is not None
        return self.model.lower([WAVELENGTH_NM])

    @cached_property
    def _table(self) -> tuple[Component, ...]:
        table = TabulatedSky(
            wavelength_nm=np.array([WAVELENGTH_NM]),
            values=self.mass[None],
            grid=self.grid,
            weighting=Weighting.LISTED,
        )
        return table.lower([WAVELENGTH_NM])


def _grid() -> PatchGrid:
    return PatchGrid.regular(N_ZENITH, N_AZIMUTH)


def _uniform() -> BenchSky:
    grid = _grid()
    return BenchSky(name="uniform", title="uniform", grid=grid, mass=grid.projected_solid_angle_sr, model=UniformSky())


def _perez(name: str, title: str, *, within: str, inputs: dict[str, Any]) -> BenchSky:
    grid = _grid()
    model = PerezSky(**inputs, grid=grid, within=within)
    return BenchSky(
        name=name, title=title, grid=grid, mass=model.patch_mass(grid), model=model if within == "exact" else None
    )


_CLEAR = {"sun_zenith_rad": 0.7, "epsilon": 6.3, "delta": 0.12}
_OVERCAST = {"sun_zenith_rad": 0.8, "epsilon": 1.0, "delta": 0.1}


def _sparse() -> BenchSky:
    """Forty lit patches of 10 x 36, as a person lists them; their values span two decades."""
    grid = PatchGrid.regular(10, 36)
    generator = np.random.default_rng(4)
    mass = np.zeros(grid.n_patches)
    mass[generator.choice(grid.n_patches, 40, replace=False)] = np.geomspace(1.0, 100.0, 40)
    return BenchSky(name="sparse", title="sparse table, 40 of 10 x 36 patches", grid=grid, mass=mass)


def _spike() -> BenchSky:
    """Half of the light in one patch of a square degree at the cone's rim, the other half uniform."""
    grid = _grid()
    mass = grid.projected_solid_angle_sr / grid.projected_solid_angle_sr.sum()
    patch = int(grid.patch_of(np.array([38.2]), np.array([217.2]))[0])
    mass[patch] += 1.0
    return BenchSky(name="spike", title="one-patch spike on a uniform sky", grid=grid, mass=mass)


_MAKERS: dict[str, Callable[[], BenchSky]] = {
    "uniform": _uniform,
    "clear": partial(_perez, "clear", "Perez clear, narrow aureole", within="exact", inputs=_CLEAR),
    "clear-uniform": partial(
        _perez, "clear-uniform", "Perez clear, uniform within patches", within="uniform", inputs=_CLEAR
    ),
    "overcast": partial(_perez, "overcast", "Perez overcast", within="exact", inputs=_OVERCAST),
    "sparse": _sparse,
    "spike": _spike,
}
SKIES = tuple(_MAKERS)


def bench_sky(name: str) -> BenchSky:
    """Make a sky of the benchmark."""
    return _MAKERS[name]()
