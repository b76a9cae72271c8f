"""Counts and masses of a run as an xarray dataset, and as a netCDF file with CF conventions."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import aomc_sky
from aomc_sky.component import Component
from aomc_sky.directions import AzimuthConvention
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.radiance import patch_radiance
from aomc_sky.errors import InputFileError, OutputError, require_kind
from aomc_sky.extras import optional_module
from aomc_sky.formats.netcdf import EXTRA, open_netcdf
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.manifest import CONVENTIONS
from aomc_sky.outputs.run_folder import RunFolder
from aomc_sky.plan.laws import beam_deg
from aomc_sky.system import prepare_target

Variable = tuple[str | tuple[str, ...], Any, dict[str, Any]]
"""Dimensions, values and attributes, as xarray takes them."""


class Table(NamedTuple):
    """What a dataset of xarray is made of. A file is written without xarray, whose import takes as long as the rest."""

    variables: dict[str, Any]
    coordinates: dict[str, Any]
    attributes: dict[str, Any]


_LONG_NAMES = {
    "counts": "photons of the {part}",
    "mass": "share of the photons that the {part} is due",
    "expected": "photons that the {part} is due, before they are made whole",
}


def to_xarray(source: PhotonSource) -> Any:  # xarray.Dataset; the package is optional
    """Return counts, masses, expected photons and radiance of all patches and wavebands as a dataset.

    Parameters
    ----------
    source : PhotonSource
        The run.

    Returns
    -------
    xarray.Dataset
        Dimension `waveband` (from 1) with the coordinates `wavelength` and `sky_wavelength` [nm]. For the
        component with patches `counts`, `mass`, `expected` and `radiance` [W m-2 sr-1 nm-1, or sr-1 for an
        irradiance 1 of all light] over (waveband, zenith, azimuth), with `zenith_bounds` and `azimuth_bounds` [degree],
        and where it is polarised `radiance_q` and `radiance_u`, its Stokes parameters Q and U;
        ``data.swap_dims(waveband="wavelength")`` chooses by wavelength. Every other component adds its name:
        `counts_direct` over (waveband) for a beam, `counts_NAME` over (waveband, zenith_NAME, azimuth_NAME) for a
        second set of patches; where absolute units are known, `irradiance` and `irradiance_NAME` over (waveband)
        [W m-2 nm-1]. Attributes state seed, plan, options and conventions.

    Raises
    ------
    MissingExtraError
        xarray is not installed: ``pip install ".[netcdf]"``.

    Examples
    --------
    >>> source = sky.read_scene("inputs/clear_day", iterations=1000).source()
    >>> int(sky.to_xarray(source).counts.sum())
    3000
    """
    require_kind(source, PhotonSource, "to_xarray(scene.source(seed=1))")
    xr = optional_module("xarray", extra=EXTRA)
    return xr.Dataset(*_table(source))


def _table(source: PhotonSource) -> Table:
    variables: dict[str, Any] = {}
    coordinates = _band_coordinates(source)
    first_with_patches = next((k for k, c in enumerate(source.components) if c.grid is not None), None)
    starts = source.plan.component_start
    for k, component in enumerate(source.components):
        ending = "" if k == first_with_patches else f"_{component.name}"
        cells = slice(int(starts[k]), int(starts[k + 1]))
        variables |= _component_variables(source, component, cells, ending)
        variables |= _radiance(source, component, k, cells, ending)
        variables |= _irradiance(source, component.name, ending)
        if component.grid is not None:
            coordinates |= grid_coordinates(component.grid, ending)
            variables |= grid_bounds(component.grid, ending)
    return Table(variables, coordinates, _attributes(source))


def variable(
    dimensions: str | tuple[str, ...],
    values: Any,
    text: str,
    units: str = "",
    *,
    standard_name: str = "",
    **others: Any,
) -> Variable:
    """A variable as xarray takes it: dimensions, values, attributes."""
    named = {"long_name": text, "standard_name": standard_name, "units": units}
    return dimensions, values, {name: value for name, value in named.items() if value} | others


def _band_coordinates(source: PhotonSource) -> dict[str, Variable]:
    numbers, wavelength = np.arange(1, source.n_bands + 1), source.plan.wavelength_nm
    sky = np.array([band.sky_wavelength_nm for band in source.plan.bands])
    sky_text = "wavelength of the sky that serves the waveband, NaN where it has none"
    known = "radiation_wavelength"
    return {
        "waveband": variable("waveband", numbers, "number of the waveband, from 1"),
        "wavelength": variable("waveband", wavelength, "wavelength of the waveband", "nm", standard_name=known),
        "sky_wavelength": variable("waveband", sky, sky_text, "nm"),
    }


def _component_variables(source: PhotonSource, component: Component, cells: slice, ending: str) -> dict[str, Any]:
    """Counts, mass and expected photons of a component."""
    bands = range(source.n_bands)
    values = {
        "counts": source.counts[:, cells],
        "mass": np.stack([source.mass(band)[cells] for band in bands]),
        "expected": np.stack([source.expected(band)[cells] for band in bands]),
    }
    dimensions: tuple[str, ...] = ("waveband",)
    shape: tuple[int, ...] = (source.n_bands,)
    if component.grid is not None:
        dimensions = ("waveband", f"zenith{ending}", f"azimuth{ending}")
        shape = (source.n_bands, component.grid.n_zenith, component.grid.n_azimuth)
    elif component.n_cells > 1:
        dimensions, shape = ("waveband", f"cell{ending}"), (source.n_bands, component.n_cells)
    beam = beam_deg(component)
    about: dict[str, Any] = {"component": component.name, "law": component.law.name}
    if beam is not None:
        about |= {"zenith_deg": beam[0], "azimuth_deg": beam[1]}
    part = f"patch, component {component.name}" if component.grid is not None else f"component {component.name}"
    return {
        f"{name}{ending}": variable(dimensions, array.reshape(shape), _LONG_NAMES[name].format(part=part), "1", **about)
        for name, array in values.items()
    }


def _radiance(source: PhotonSource, component: Component, k: int, cells: slice, ending: str) -> dict[str, Any]:
    """Mean radiance of each patch that has an extent, with its Q and U if it is polarised."""
    grid = component.grid
    if grid is None or not np.any(grid.solid_angle_sr > 0):
        return {}
    bands = range(source.n_bands)
    values = np.stack([patch_radiance(component.law, grid, source.cell_irradiances(band)[k])[1] for band in bands])
    is_absolute = source.irradiance(0) is not None
    text = "mean radiance of the patch" + ("" if is_absolute else ", for an irradiance 1 of all light")
    parts = {"radiance": (text, values)}
    if component.stokes is not None:
        stokes = np.stack([source.stokes(band)[cells] for band in bands])
        for j, one in enumerate("QU"):
            parts[f"radiance_{one.lower()}"] = (f"Stokes parameter {one} of the {text}", values * stokes[..., j])
    return {
        f"{name}{ending}": variable(
            ("waveband", f"zenith{ending}", f"azimuth{ending}"),
            part.reshape(source.n_bands, grid.n_zenith, grid.n_azimuth),
            f"{words}, component {component.name}",
            "W m-2 sr-1 nm-1" if is_absolute else "sr-1",
            component=component.name,
        )
        for name, (words, part) in parts.items()
    }


def _irradiance(source: PhotonSource, name: str, ending: str) -> dict[str, Any]:
    """Irradiance of a component on a horizontal plane, where absolute units are known."""
    bands = [source.irradiance(band) for band in range(source.n_bands)]
    values = [band[name] for band in bands if band is not None]
    if not values:
        return {}
    text = f"irradiance of component {name} on a horizontal plane"
    return {f"irradiance{ending}": variable("waveband", np.array(values), text, "W m-2 nm-1", component=name)}


def grid_coordinates(grid: PatchGrid, ending: str) -> dict[str, Any]:
    """Coordinates of the patches, `zenith` and `azimuth` with an ending, and their indices as in skydist.inp."""
    zenith, azimuth, first = f"zenith{ending}", f"azimuth{ending}", grid.azimuth_first_index
    centre = grid.zenith_bounds_deg.mean(axis=1), grid.azimuth_bounds_deg.mean(axis=1)
    zenith_text, bounds = "zenith angle of the sky element, 0 overhead", f"zenith_bounds{ending}"
    azimuth_text = f"azimuth of the sky element; {CONVENTIONS['azimuth']}"
    numbers = np.arange(1, grid.n_zenith + 1), np.arange(first, first + grid.n_azimuth)
    return {
        zenith: variable(zenith, centre[0], zenith_text, "degree", standard_name="zenith_angle", bounds=bounds),
        azimuth: variable(
            azimuth,
            centre[1],
            azimuth_text,
            "degree",
            bounds=f"azimuth_bounds{ending}",
            azimuth_convention=AzimuthConvention.ENU_FROM_EAST.name.lower(),
        ),
        f"zenith_index{ending}": variable(zenith, numbers[0], "zenith index as in skydist.inp, from 1"),
        f"azimuth_index{ending}": variable(azimuth, numbers[1], "azimuth index as in skydist.inp"),
    }


def grid_bounds(grid: PatchGrid, ending: str) -> dict[str, Any]:
    """Edges of the patches; by the CF conventions they need no attributes of their own."""
    return {
        f"zenith_bounds{ending}": ((f"zenith{ending}", "bounds"), grid.zenith_bounds_deg),
        f"azimuth_bounds{ending}": ((f"azimuth{ending}", "bounds"), grid.azimuth_bounds_deg),
    }


def _attributes(source: PhotonSource) -> dict[str, Any]:
    options = source.plan.options
    shape, size_x, size_y = options["footprint"]
    return {
        "Conventions": "CF-1.11",
        "title": "Photon counts and probability masses of the sky patches of a run",
        "source": f"aomc-sky {aomc_sky.__version__}",
        "plan_sha256": source.plan.sha256,
        "stream": str(options["stream"]),
        "seed": str(options["seed"]),  # up to 2^64 - 1, which netCDF's own integers do not hold
        "allocation": str(options["allocation"]),
        "placement": str(options["placement"]),
        "order": str(options["order"]),
        "replicates": source.replicates,
        "footprint": f"{shape}, {size_x:g} x {size_y:g} m",
        "directions": "zenith and azimuth point from the water to where the light comes from",
    }


def write_netcdf(source: PhotonSource, path: str | Path) -> None:
    """Write the dataset of `to_xarray` as a netCDF-4 file, atomically and compressed."""
    target = Path(path)
    prepare_target(target)
    RunFolder(target.parent).write(target.name, netcdf_bytes(_table(source)))


def netcdf_bytes(table: Table) -> bytes:
    """The bytes of the file; they are made in memory, because the HDF5 library crashes if the disk is full."""
    h5netcdf = optional_module("h5netcdf", extra=EXTRA)
    h5py = optional_module("h5py", extra=EXTRA)  # h5netcdf needs it to write
    every = {
        name: ((one[0],) if isinstance(one[0], str) else tuple(one[0]), np.asarray(one[1]), dict(*one[2:]))
        for name, one in (table.coordinates | table.variables).items()
    }
    is_axis = {name: dimensions == (name,) for name, (dimensions, _, _) in every.items()}
    beside = {name: every[name][0] for name in table.coordinates if not is_axis[name]}
    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        sizes = [pair for axes, values, _ in every.values() for pair in zip(axes, values.shape, strict=True)]
        file.dimensions.update(dict(sizes))
        for name, (dimensions, values, attributes) in every.items():
            is_data, is_text, how = name in table.variables and not is_axis[name], values.dtype.kind == "U", {}
            if is_data and values.dtype.kind == "f":  # coordinates have no gaps
                how["fillvalue"] = values.dtype.type(np.nan)
            if is_data and values.size > 1:
                how |= {"compression": "gzip", "compression_opts": 4, "shuffle": True}
            kind, data = (h5py.string_dtype(), values.astype(object)) if is_text else (values.dtype, values)
            made = file.create_variable(name, dimensions, kind, data=data, **how)
            others = " ".join(other for other, axes in beside.items() if is_data and {*axes} <= {*dimensions})
            made.attrs.update(attributes | ({"coordinates": others} if others else {}))
        file.attrs.update(table.attributes)
    return buffer.getvalue()


def plan_of_netcdf(path: str | Path) -> str | None:
    """SHA-256 of the plan of a netCDF file of ours, or None for any other file."""
    try:
        with open_netcdf(path) as (dataset, _):
            return str(dataset.attrs.get("plan_sha256"))
    except (InputFileError, OutputError):
        return None
