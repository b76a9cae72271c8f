"""What ``aomc-sky info`` tells of a description of an atmosphere: its numbers, species, spectra, optical depths."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from aomc_sky.errors import SourceText
    from aomc_sky.formats.atmo.data import AbsorberDescription, AtmosphereDescription, ScattererDescription
    from aomc_sky.source.atmospheres.medium import MediumReport

MAX_ROWS = 100


def report_atmo(path: Path, *, as_json: bool, allow_paths: Sequence[str]) -> int:
    """Print what a description holds and what its code blocks give."""
    from aomc_sky.formats.atmo.reader import read_atmo
    from aomc_sky.source.atmospheres.medium import read_medium

    description = read_atmo(path, allow_paths=allow_paths)
    _, found = read_medium(description)
    if as_json:
        print(json.dumps(_summary(description, found), allow_nan=False))
    else:
        print("\n".join(_lines(description, found)))
    return 0


def _summary(d: AtmosphereDescription, found: MediumReport) -> dict[str, Any]:
    return {
        "format": "atmosphere description",
        "path": d.path,
        "atmosphere_height_m": d.atmosphere_height_m,
        "earth_radius_m": d.earth_radius_m,
        "earth_sun_distance_m": d.earth_sun_distance_m,
        "earth_moon_distance_m": d.earth_moon_distance_m,
        "scattering_orders": d.scattering_orders,
        "wavelength_nm": d.wavelength_nm.tolist(),
        "solar_irradiance": d.solar_irradiance.tolist(),
        "ground_albedo": d.ground_albedo.tolist(),
        "ground_glow": None if d.ground_glow is None else d.ground_glow.tolist(),
        "glow_luminance_cd_m2": d.glow_luminance_cd_m2,
        "scatterers": [_scatterer(part) for part in d.scatterers],
        "absorbers": [_absorber(part) for part in d.absorbers],
        "optical_depth": {name: depth.tolist() for name, depth in found.optical_depth.items()},
        "phase_norm": {name: norm.tolist() for name, norm in found.phase_norm.items()},
        "negligible_species": list(found.dropped),
        "sizes": dict(d.sizes),
        "textures_are_radiances": d.textures_are_radiances,
        "has_eclipsed_double_scattering_textures": d.has_eclipsed_double_scattering_textures,
    }


def _scatterer(part: ScattererDescription) -> dict[str, Any]:
    return {
        "name": part.name,
        "line": part.line,
        "cross_section_1um_m2": part.cross_section_1um_m2,
        "angstrom_exponent": part.angstrom_exponent,
        "single_scattering_albedo": part.single_scattering_albedo.tolist(),
        "phase_function_type": part.phase_function_type.value,
        "needs_interpolation_guides": part.needs_interpolation_guides,
        "number_density": part.number_density.text,
        "phase_function": part.phase_function.text,
    }


def _absorber(part: AbsorberDescription) -> dict[str, Any]:
    return {
        "name": part.name,
        "line": part.line,
        "cross_section_m2": part.cross_section_m2.tolist(),
        "number_density": part.number_density.text,
    }


def _lines(d: AtmosphereDescription, found: MediumReport) -> Iterator[str]:
    from aomc_sky.cli.table import table
    from aomc_sky.formats.units import AU_M

    yield f"atmosphere description {d.path}, {_counted(d)}"
    yield f"ground at {d.earth_radius_m / 1e3:g} km, top {d.atmosphere_height_m / 1e3:g} km above it"
    moon = "" if d.earth_moon_distance_m is None else f", moon at {d.earth_moon_distance_m / 1e3:g} km"
    yield f"sun at {d.earth_sun_distance_m / AU_M:g} AU{moon}"
    yield f"orders of scattering: {d.scattering_orders}"
    if d.glow_luminance_cd_m2 is not None:
        yield f"glow of the ground: scaled to 1 cd/m2 from {d.glow_luminance_cd_m2:.6g} cd/m2"
    for part in d.scatterers:
        yield (
            f"scatterer {part.name}: {part.cross_section_1um_m2:g} m2 at 1 um, Angstrom exponent "
            f"{part.angstrom_exponent:g}, density {_place(part.number_density)}, "
            f"{part.phase_function_type.value} phase function {_place(part.phase_function)}, {_norm(part.name, found)}"
        )
    for gas in d.absorbers:
        yield f"absorber {gas.name}: density {_place(gas.number_density)}"
    if found.dropped:
        yield f"negligible, and left out of every solution: {', '.join(found.dropped)}"
    columns = _columns(d, found)
    rows = [tuple(f"{values[k]:.6g}" for values in columns.values()) for k in range(len(d.wavelength_nm))]
    yield f"\n{table(rows[:MAX_ROWS], tuple(columns))}"
    if len(rows) > MAX_ROWS:
        yield f"... and {len(rows) - MAX_ROWS} more wavelengths"
    if d.sizes:
        yield "\nnumbers of points and texels:"
        yield from (f"  {key}: {value}" for key, value in d.sizes.items())


def _counted(d: AtmosphereDescription) -> str:
    n_scatterers, n_absorbers, n = len(d.scatterers), len(d.absorbers), len(d.wavelength_nm)
    return (
        f"{n_scatterers} scatterer{'s' * (n_scatterers != 1)}, {n_absorbers} absorber{'s' * (n_absorbers != 1)}, "
        f"{n} wavelength{'s' * (n != 1)}"
    )


def _norm(name: str, found: MediumReport) -> str:
    norm = found.phase_norm[name]
    least, greatest = f"{norm.min():.6f}", f"{norm.max():.6f}"
    return f"integral {least}" if least == greatest else f"integral {least} to {greatest}"


def _place(code: SourceText) -> str:
    last = code.line + code.text.count("\n")
    return f"in line {code.line}" if last == code.line else f"in lines {code.line} to {last}"


def _columns(d: AtmosphereDescription, found: MediumReport) -> dict[str, np.ndarray]:
    """Spectra under their heads; albedos of 1 throughout are left out."""
    columns = {"nm": d.wavelength_nm, "sun W m-2 nm-1": d.solar_irradiance, "albedo": d.ground_albedo}
    if d.ground_glow is not None:
        columns["glow W m-2 sr-1 nm-1"] = d.ground_glow
    for part in d.scatterers:
        if (part.single_scattering_albedo != 1.0).any():
            columns[f"albedo of {part.name}"] = part.single_scattering_albedo
    for gas in d.absorbers:
        columns[f"{gas.name} m2"] = gas.cross_section_m2
    for name, depth in found.optical_depth.items():
        columns[f"tau of {name}"] = depth
    return columns
