"""What ``aomc-sky atmosphere`` prints of a description and its skies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from aomc_sky.cli.table import table


def table_text(report: Mapping[str, Any], files: Mapping[str, str]) -> str:
    """A description, its species, and where they are solved the skies, for a person.

    Parameters
    ----------
    report : mapping
        Of `aomc_sky.engine.atmosphere.files.table_report`.
    files : mapping
        Files that were written, by their role.

    Returns
    -------
    str
    """
    wavelength = report["wavelength_nm"]
    zenith, azimuth = report["bins"]
    lines = [
        f"{report['description']}: {len(wavelength)} wavelengths, {wavelength[0]:g} to {wavelength[-1]:g} nm, "
        f"{_counted(len(report['suns']), 'sun', 'suns')}, {zenith} x {azimuth} patches",
        "",
        _species(report),
    ]
    if report["dropped"]:
        lines += ["", f"too thin to count, left out: {', '.join(report['dropped'])}"]
    if report["sizes"]:
        lines += ["", _sizes(report["sizes"])]
    if "direct_irradiance" not in report["suns"][0]:
        planned = ", ".join(f"{sun['sun_zenith_deg']:g} ({sun['method']})" for sun in report["suns"])
        return "\n".join([*lines, "", f"suns, not solved: {planned}"])
    lines += [
        "",
        _suns(report["suns"]),
        *(
            f"{sun['sun_zenith_deg']:g}: {sun['method']} because {sun['reason']}"
            for sun in report["suns"]
            if sun["reason"]
        ),
        "",
        f"{_counted(len(report['suns']), 'sky', 'skies')} in {report['seconds']:.2f} s",
    ]
    lines += [f"{role}: {path}" for role, path in files.items() if not role.startswith("skydist ")]
    n_skydist = sum(role.startswith("skydist ") for role in files)
    if n_skydist:
        lines.append(f"skydist.inp: {n_skydist} files, one in the folder of each sun")
    return "\n".join(lines)


def _counted(n: int, one: str, several: str) -> str:
    return f"{n} {one if n == 1 else several}"


def _ends(values: Sequence[float], form: str) -> str:
    """A value, or the values of the first and the last wavelength."""
    first, last = format(values[0], form), format(values[-1], form)
    return first if first == last else f"{first} ... {last}"


def _species(report: Mapping[str, Any]) -> str:
    rows = [
        (name, _ends(depth, ".4g"), _ends(report["phase_norm"][name], ".6f") if name in report["phase_norm"] else "-")
        for name, depth in report["optical_depth"].items()
    ]
    return table(rows, ("species", "optical depth", "integral of phase function"))


def _sizes(sizes: Mapping[str, Mapping[str, Any]]) -> str:
    rows = [(key, str(size["value"]), f"{size['use']}: {size['why']}") for key, size in sizes.items()]
    return table(rows, ("size in the description", "value", "here"))


def _suns(suns: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        (
            f"{sun['sun_zenith_deg']:g}",
            f"{sun['method']}, {sun['orders']}",
            _ends(sun["direct_irradiance"], ".4g"),
            _ends(sun["diffuse_irradiance"], ".4g"),
            "-" if sun["truncation"] is None else f"{max(sun['truncation']):.1e}",
            f"{max(sun['largest_relative_error']):.1e}",
            f"{sum(sun['seconds'].values()):.2f}",
        )
        for sun in suns
    ]
    head = ("sun", "method, orders", "direct W m-2 nm-1", "diffuse W m-2 nm-1", "left out", "error", "s")
    return table(rows, head)
