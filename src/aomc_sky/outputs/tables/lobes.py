"""Lobes of background skies over patches: as skydist.inp and as a dataset with CF conventions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.extras import optional_module
from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, write_skydist
from aomc_sky.formats.sky_toml.rules import moment_text
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import CONVENTIONS
from aomc_sky.outputs.tables.netcdf import EXTRA, grid_bounds, grid_coordinates, netcdf_bytes
from aomc_sky.skies.lobes.patches import patch_mass
from aomc_sky.source.backgrounds.scene import LobeScene

_IRRADIANCE = "W m-2 nm-1"


def patch_radiance(scene: LobeScene, grid: PatchGrid) -> np.ndarray:
    """Mean radiance of patches (n_wl, n_zenith, n_azimuth), weighted with the cosine of the zenith angle.

    Irradiance of each lobe times its projected mass in the patch over the projected solid angle of the
    patch, which must have an extent. [W m-2 sr-1 nm-1] Accuracy and cost are those of `aomc_sky.lobes.patch_mass`,
    about a second for each lobe of its own shape.
    """
    light = scene.irradiance()
    known: dict[tuple[object, ...], np.ndarray] = {}
    total = np.zeros((scene.wavelength_nm.size, grid.n_patches))
    for (_, lobe), row in zip(scene.lobes, light, strict=True):
        key = (lobe.kind, lobe.param0, lobe.param1, *lobe.quaternion.tolist())
        if key not in known:
            shape = lobe.param0, lobe.param1, lobe.quaternion
            known[key] = patch_mass(lobe.kind, *shape, grid, weighting="projected")
        total += row[:, None] * known[key]
    radiance: np.ndarray = total / grid.projected_solid_angle_sr
    return radiance.reshape(-1, grid.n_zenith, grid.n_azimuth)


def write_lobe_skydist(scene: LobeScene, radiance: np.ndarray, path: str | Path) -> None:
    """Write radiances of equal bins, as `patch_radiance` gives them, as skydist.inp.

    Read back it gives the masses of the lobes again, for mass = radiance x projected solid angle.
    """
    table = SkyTable(wavelength_nm=scene.wavelength_nm, radiance=radiance, path=str(path))
    write_skydist(table, path, bins=Bins.EQUAL, values=Values.RADIANCE)


def lobe_dataset(scene: LobeScene, radiance: np.ndarray, grid: PatchGrid) -> Any:  # xarray.Dataset
    """Lobes as an xarray.Dataset, with the radiance of `patch_radiance`.

    `radiance` over (wavelength, zenith, azimuth); `sphere_irradiance` and `irradiance`, on a horizontal plane,
    over (lobe, wavelength); `horizon_loss` over (wavelength).
    """
    xr = optional_module("xarray", extra=EXTRA)
    by_lobe = ("lobe", "wavelength")
    variables = {
        "radiance": (
            ("wavelength", "zenith", "azimuth"),
            radiance,
            {
                "long_name": "radiance, mean over the patch weighted with the cosine of the zenith angle",
                "units": "W m-2 sr-1 nm-1",
            },
        ),
        "sphere_irradiance": (
            by_lobe,
            scene.irradiance(),
            {"long_name": "irradiance of the lobe integrated over the sphere", "units": _IRRADIANCE},
        ),
        "irradiance": (
            by_lobe,
            scene.irradiance(above="projected"),
            {"long_name": "irradiance of the lobe on a horizontal plane", "units": _IRRADIANCE},
        ),
        "horizon_loss": (
            "wavelength",
            scene.horizon_loss,
            {"long_name": "share of the light of the lobes from below the horizon", "units": "1"},
        ),
        **grid_bounds(grid, ""),
    }
    coordinates = grid_coordinates(grid, "") | {
        "wavelength": (
            "wavelength",
            scene.wavelength_nm,
            {"long_name": "wavelength", "standard_name": "radiation_wavelength", "units": "nm"},
        ),
        "lobe": ("lobe", [name for name, _ in scene.lobes], {"long_name": "name of a lobe"}),
    }
    return xr.Dataset(variables, coordinates, _attributes(scene))


def _attributes(scene: LobeScene) -> dict[str, Any]:
    return {
        "Conventions": "CF-1.11",
        "title": "Background sky at one time",
        "source": f"aomc-sky {aomc_sky.__version__}",
        "files": " ".join(Path(section.file).name for section in scene.sections),
        "time": moment_text(scene.sections[0].time),
        "azimuth_convention": CONVENTIONS["azimuth"],
        "directions": "zenith and azimuth point from the water to where the light comes from",
    }


def write_lobe_netcdf(scene: LobeScene, radiance: np.ndarray, grid: PatchGrid, path: str | Path) -> None:
    """Write the dataset of `lobe_dataset` as a netCDF-4 file, whole or not at all."""
    target = Path(path)
    RunFolder(target.parent).write(target.name, netcdf_bytes(lobe_dataset(scene, radiance, grid)))
