"""What ``aomc-sky perez`` prints and writes of one sky: numbers, a table of radiances, photon counts, a picture."""

from __future__ import annotations

import argparse
import math
from typing import Any

import numpy as np

from aomc_sky.cli.commands.perez.sky import FoundSky
from aomc_sky.errors import UsageError
from aomc_sky.grid import PatchGrid

_LETTERS = "abcde"


def as_json(found: FoundSky) -> dict[str, Any]:
    """One sky as JSON values; None where the inputs do not tell."""
    from aomc_sky.skies.perez.functions import epsilon_bin, limited

    sky, dni, dhi = found.sky, found.dni, found.dhi
    clearness, brightness = sky.clearness, sky.brightness
    used: tuple[float, float] | None = None
    if clearness is not None and brightness is not None:
        used = tuple(float(value) for value in limited(clearness, brightness, limits=sky.limits))  # type: ignore[assignment]
    integral = float(sky.relative_integral)
    beam = None if dni is None else dni * math.cos(sky.sun_zenith_rad)
    return {
        "source": found.source,
        "sun_zenith_deg": found.sun_zenith_deg,
        "sun_azimuth_deg": found.sun_azimuth_deg,
        "epsilon": None if clearness is None else float(clearness),
        "delta": None if brightness is None else float(brightness),
        "epsilon_used": None if used is None else used[0],
        "delta_used": None if used is None else used[1],
        "bin": None if used is None else int(epsilon_bin(used[0])) + 1,
        "limits": sky.limits,
        "coefficients": dict(zip(_LETTERS, np.asarray(sky.model_coefficients).tolist(), strict=True)),
        "horizontal_integral": integral,
        "radiance_per_unit": None if dhi is None else dhi / integral,
        "dni": dni,
        "dhi": dhi,
        "direct_horizontal": beam,
        "ghi": None if beam is None or dhi is None else beam + dhi,
        "extraterrestrial_normal": found.extraterrestrial_normal,
        "air_mass": sky.air_mass,
        "warnings": list(found.warnings),
    }


def as_text(found: FoundSky) -> str:
    """One sky for a person."""
    values = as_json(found)
    rows = [*_source_rows(values["source"]), ("sun", _sun_text(values))]
    if values["dhi"] is not None:
        texts = [f"{name.upper()} {values[name]:g}" for name in ("dni", "dhi", "ghi")]
        texts.append(f"direct horizontal {values['direct_horizontal']:g} W m-2")
        rows.append(("irradiances", ", ".join(texts)))
    if values["epsilon"] is not None:
        rows.append(("epsilon", f"{values['epsilon']:.6g}, bin {values['bin']} of 8" + _used(values, "epsilon")))
        how = f" (extraterrestrial {values['extraterrestrial_normal']:g} W m-2, air mass {values['air_mass']})"
        rows.append(("Delta", f"{values['delta']:.6g}" + _used(values, "delta") + (how if values["dhi"] else "")))
    rows.append(("coefficients", "  ".join(f"{k} {v:.6g}" for k, v in values["coefficients"].items())))
    rows.append(("integral", f"{values['horizontal_integral']:.10g} (of f cos over the hemisphere, eq. 3)"))
    if values["radiance_per_unit"] is not None:
        rows.append(("radiance", f"{values['radiance_per_unit']:.6g} W m-2 sr-1 times f"))
    limits = {"radiance": "published practice (radiance)", "paper": "none (paper)"}[values["limits"]]
    rows.append(("limits", limits))
    rows += [("limited", text.partition(": ")[2] or text) for text in values["warnings"]]
    return "\n".join(f"{name:13s} {text}" for name, text in rows)


def _source_rows(source: dict[str, Any]) -> list[tuple[str, str]]:
    def place() -> str:
        return f"latitude {source['latitude_deg']:g}, longitude {source['longitude_deg']:g}"

    if "weather" in source:
        start, end = source["hour"]
        name = "".join(c if c.isprintable() else "?" for c in source["place"])
        return [
            ("weather", f"{source['weather']}:{source['line']}, row {source['row']}, {name}, {place()}"),
            ("hour", f"{start} to {end}, sun at {source['sun_at']}"),
        ]
    return [("time", f"{source['time']}, {place()}")] if "time" in source else []


def _sun_text(values: dict[str, Any]) -> str:
    zenith, azimuth = values["sun_zenith_deg"], values["sun_azimuth_deg"]
    true = values["source"].get("true_zenith_deg")
    seen = "" if true is None else f" (as seen; {true:.4f} without refraction)"
    return f"zenith {zenith:.4f} deg{seen}, azimuth {azimuth:.4f} deg from +x (east) towards +y (north)"


def _used(values: dict[str, Any], name: str) -> str:
    """What the coefficients were taken at, where that is another value."""
    return "" if values[name] == values[f"{name}_used"] else f", limited to {values[f'{name}_used']:g}"


def write_table(found: FoundSky, arguments: argparse.Namespace, path: str) -> None:
    """Write skydist.inp: the mean radiance of each patch, weighted as its photons are.

    Read back, the table gives the masses of the model again, for mass = radiance x projected solid angle.
    """
    from aomc_sky.formats.skydist import Bins, SkyTable, Values, write_skydist

    if not arguments.wavelength > 0:
        raise UsageError(f"--wavelength must be positive, got {arguments.wavelength:g}")
    grid = PatchGrid.regular(*arguments.bins)
    scale = float(found.sky.relative_integral) if found.dhi is None else found.dhi
    radiance = (found.mass * scale / grid.projected_solid_angle_sr).reshape(1, grid.n_zenith, grid.n_azimuth)
    table = SkyTable(
        wavelength_nm=np.array([arguments.wavelength]),
        radiance=radiance,
        path=path,
    )
    write_skydist(table, path, bins=Bins.EQUAL, values=Values.RADIANCE)


def write_counts(found: FoundSky, arguments: argparse.Namespace, path: str) -> None:
    """Write the photons of every patch with mass, in the columns of a run's counts.csv."""
    from aomc_sky.formats.text_file import write_atomically
    from aomc_sky.outputs.counts import COLUMNS
    from aomc_sky.sampling.allocation import allocate
    from aomc_sky.sampling.mass import normalise

    grid = PatchGrid.regular(*arguments.bins)
    counts = allocate(found.mass, arguments.iterations, seed=arguments.seed)
    mass = normalise(found.mass)
    zenith = [f"{lo!r},{hi!r}" for lo, hi in grid.zenith_bounds_deg.tolist()]
    azimuth = [f"{lo!r},{hi!r}" for lo, hi in grid.azimuth_bounds_deg.tolist()]
    cells = np.flatnonzero(mass)
    rings, columns = np.divmod(cells, grid.n_azimuth)
    rows = zip(rings.tolist(), columns.tolist(), mass[cells].tolist(), counts[cells].tolist(), strict=True)
    lines = [
        f"1,,,perez,{z + 1},{a},{zenith[z]},{azimuth[a]},{m!r},{m * arguments.iterations!r},{n}" for z, a, m, n in rows
    ]
    write_atomically(path, "\n".join([COLUMNS, *lines, ""]))


def write_picture(found: FoundSky, arguments: argparse.Namespace, path: str) -> None:
    """Draw the sky dome."""
    from aomc_sky.pictures.plot import plot

    clearness, brightness = found.sky.clearness, found.sky.brightness
    what = "" if clearness is None else f", ε = {clearness:.4g}, Δ = {brightness:.3g}"
    source = found.source
    when = source.get("sun_at") or source.get("time")
    plot(found.sky, path, title="Perez sky" + what + (f"\n{when}" if when else ""))
