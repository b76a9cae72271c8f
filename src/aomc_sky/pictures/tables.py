"""Results as domes: a skydist.inp, an atmosphere, and the netCDF files that the package writes."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.tables.netcdf import EXTRA
from aomc_sky.pictures.content import PHOTONS, RADIANCE, Dome, Mark, Picture, Symbol, spread
from aomc_sky.pictures.source import source_picture, sun_mark
from aomc_sky.skies.atmosphere import AtmosphereSky
from aomc_sky.skies.tabulated import TabulatedSky
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands

_ADVICE = "pictures are drawn of what `aomc-sky export --to netcdf`, `lobes --netcdf` and `atmosphere` write"


def table_picture(sky: TabulatedSky, *, bands: Sequence[int] | None = None, title: str = "") -> Picture:
    """The sets of a sky file, each as if a waveband took it: radiance over irradiance, all or 12 spread over them."""
    chosen = spread(range(sky.wavelength_nm.size)) if bands is None else list(bands)
    wavelengths = sky.wavelength_nm
    rows = TabulatedSky(
        wavelength_nm=np.arange(float(wavelengths.size)), values=sky.values, grid=sky.grid, weighting=sky.weighting
    ).lower(np.arange(float(wavelengths.size)))
    scene = Scene(wavebands=Wavebands(wavelength_nm=wavelengths), n_photons=np.zeros(wavelengths.size), components=rows)
    return source_picture(scene.source(0), bands=chosen, title=title)


def netcdf_picture(path: str | Path, *, panels: Sequence[int] | None = None, title: str = "") -> tuple[Picture, int]:
    """Domes of a netCDF file that this package wrote, and how many it holds or were chosen.

    Counts of a run become photons per steradian; radiances of lobes or of an atmosphere stay. By default all domes are
    drawn, or 12 spread over them. Without xarray and h5netcdf a MissingExtraError names the extra.
    """
    xr = optional_module("xarray", extra=EXTRA)
    optional_module("h5netcdf", extra=EXTRA)
    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            return _picture(dataset.load(), panels, title)
    except FileNotFoundError:
        raise refuse(path, "there is no such file", advice=_ADVICE) from None
    except (OSError, KeyError, ValueError) as error:
        raise refuse(path, f"this is not a table of patches ({error})", advice=_ADVICE) from error


def _picture(dataset: Any, panels: Sequence[int] | None, title: str) -> tuple[Picture, int]:
    name = "radiance" if "radiance" in dataset else "counts"
    table = dataset[name]
    if table.dims[-2:] != ("zenith", "azimuth"):
        raise KeyError(f"{name} over zenith and azimuth")
    grid = PatchGrid(
        zenith_bounds_deg=dataset["zenith_bounds"].values, azimuth_bounds_deg=dataset["azimuth_bounds"].values
    )
    indices = list(itertools.product(*(range(n) for n in table.shape[:-2])))
    chosen = spread(range(len(indices))) if panels is None else list(panels)
    for panel in chosen:
        if not 0 <= panel < len(indices):
            raise UsageError(f"there is no dome {panel + 1} in this file; it holds {len(indices)}")
    domes = tuple(_dome(dataset, table, grid, indices[panel]) for panel in chosen)
    quantity = RADIANCE if name == "radiance" else PHOTONS
    n_panels = len(indices) if panels is None else len(chosen)
    return Picture(domes=domes, quantity=quantity, title=title), n_panels


def _dome(dataset: Any, table: Any, grid: PatchGrid, index: tuple[int, ...]) -> Dome:
    values = np.asarray(table.values[index], dtype=np.float64).ravel()
    if table.name == "counts":
        values = np.divide(values, grid.solid_angle_sr, out=np.zeros_like(values), where=grid.solid_angle_sr > 0)
    at = dict(zip(table.dims[:-2], index, strict=True))
    words = [_WORDS[name](dataset, index) for name, index in at.items() if name in _WORDS]
    return Dome(grid=grid, values=values, title=", ".join(words), marks=_sun(dataset, at))


_WORDS: dict[str, Callable[[Any, int], str]] = {
    "waveband": lambda dataset, k: f"waveband {k + 1}, {float(dataset['wavelength'][k]):g} nm",
    "wavelength": lambda dataset, k: f"{float(dataset['wavelength'][k]):.6g} nm",
    "sun_zenith": lambda dataset, k: f"sun at {float(dataset['sun_zenith'][k]):g}°",
}
"""What an index along a dimension is called above a dome."""


def _sun(dataset: Any, at: dict[str, int]) -> tuple[Mark, ...]:
    if "sun_zenith" not in at:
        return ()
    return (sun_mark(float(dataset["sun_zenith"][at["sun_zenith"]]), float(dataset.attrs["sun_azimuth_deg"])),)


def atmosphere_picture(sky: AtmosphereSky, *, title: str = "") -> Picture:
    """Radiance of the patches at up to 12 wavelengths, W m-2 sr-1 nm-1, and the direct beam as a mark."""
    sun = sky.sun_zenith_deg, sky.sun_azimuth_deg
    domes = []
    wavelengths, direct = sky.medium.wavelength_nm.tolist(), sky.direct_irradiance.tolist()
    diffuse = sky.diffuse_irradiance.tolist()
    for k, wavelength in enumerate(wavelengths):
        name, mark = f"{wavelength:g} nm", sun_mark(*sun)
        if direct[k] > 0:
            name += f"\nbeam {100 * direct[k] / (direct[k] + diffuse[k]):.3g} % of the light"
            mark = Mark(zenith_deg=sun[0], azimuth_deg=sun[1], symbol=Symbol.BEAM)
        radiance = sky.patch_mean[k].sum(axis=0)
        domes.append(Dome(grid=sky.grid, values=radiance, title=name, marks=(mark,)))
    return Picture(domes=tuple(domes), quantity=RADIANCE, title=title)
