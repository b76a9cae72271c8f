"""The contents of a background-sky file: its animations and spectra, and its lobes and irradiances at one time."""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli import values
from aomc_sky.cli.terminal import report_text, shown
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    import numpy as np

    from aomc_sky.formats.sky_toml.sections import BackgroundSection
    from aomc_sky.skies.lobes.file.data import Animation, BackgroundFile
    from aomc_sky.skies.lobes.sky import LobeSky


def report_background(arguments: argparse.Namespace, path: Path) -> int:
    """Print the contents of the file, or with --time the lobes at that time."""
    if arguments.time is not None:
        lobes = _lobes(*lobes_at(arguments, moment_of(arguments)))
        head = "lobes of a background sky; azimuth from +x (east) towards +y (north)"
        cli_options.answer(arguments, lambda: lobes, lambda: report_text(head, lobes))
        return 0
    if arguments.wavelengths is not None or arguments.animation is not None:
        raise UsageError("--wavelength and --animation need --time, the time of the lobes that are shown")
    from aomc_sky.skies.lobes.file.file import read_background_file

    file = read_background_file(path)
    cli_options.answer(arguments, lambda: _contents(path, file), lambda: _text(path, file))
    return 0


def moment_of(arguments: argparse.Namespace) -> float:
    """The time that --time names. [s since 1970-01-01 UTC]"""
    try:
        return values.moment(arguments.time)
    except argparse.ArgumentTypeError as error:
        raise UsageError(f"--time: {error}") from None


def lobes_at(arguments: argparse.Namespace, time_s: float) -> tuple[BackgroundSection, LobeSky, np.ndarray]:
    """The lobes of a file at one time, as the options of `LOBES` choose them, and wavelengths."""
    from aomc_sky.formats.sky_toml.sections import BackgroundSection
    from aomc_sky.skies.lobes.light import read_lobes

    section = BackgroundSection(
        file=arguments.path,
        time=time_s,
        animation=None if arguments.animation is None else tuple(arguments.animation),
        utc_offset=arguments.utc_offset,
        interpolation=arguments.interpolation,
    )
    return section, *read_lobes(section, arguments.wavelengths)


def _contents(path: Path, file: BackgroundFile) -> dict[str, Any]:
    info, width = file.info, file.wavelength_nm[1:] - file.wavelength_nm[:-1]
    return {
        "format": "background sky",
        "path": str(path),
        "info": {name: getattr(info, name) for name in info.__slots__},
        "notes": list(file.texts),
        "animations": {name: _animation(keys) for name, keys in file.animations.items()},
        "wavelength_nm": file.wavelength_nm.tolist(),
        "curves": [
            {
                "least": float(c.min()),
                "greatest": float(c.max()),
                "integral": float((width * (c[1:] + c[:-1])).sum() / 2),
            }
            for c in file.curves
        ],
        "curve_unit": "W m-2 nm-1",
    }


def _animation(keys: Animation) -> dict[str, Any]:
    columns = {
        "relative_time_days": keys.relative_time_days.tolist(),
        "type": keys.kind,
        "param0": keys.param0.tolist(),
        "param1": keys.param1.tolist(),
        "coefficient": keys.coefficient.tolist(),
        "quaternion": keys.quaternion.tolist(),
        "curve": keys.curve_index.tolist(),
    }
    return {
        "reference": keys.reference.name.lower(),
        "time_point_s": keys.time_point_s,
        "keys": [{name: column[k] for name, column in columns.items()} for k in range(len(keys))],
    }


def _text(path: Path, file: BackgroundFile) -> str:
    """The contents as text: a table for each animation, then the curves."""
    from aomc_sky.formats.sky_toml.keys import moment_text

    contents = _contents(path, file)
    animations, low, high = contents["animations"], file.wavelength_nm[0], file.wavelength_nm[-1]
    n_keys = sum(len(animation["keys"]) for animation in animations.values())
    plural = "" if len(animations) == 1 else "s"
    head = f"background-sky file {path}, {len(animations)} animation{plural} with {n_keys} keys"
    for one in animations.values():
        if one["reference"] == "absolute":
            with contextlib.suppress(OverflowError):  # beyond the year 9999 it stays seconds since 1970
                one["time_point_s"] = moment_text(one["time_point_s"])
    parts = [report_text(head, {**contents["info"], "notes": contents["notes"]})]
    parts += [report_text(f"animation {shown(name)}, {len(one['keys'])} keys", one) for name, one in animations.items()]
    curves = f"{len(file.curves)} curves [W m-2 nm-1] at {file.wavelength_nm.size} wavelengths, {low:g} to {high:g} nm"
    return "\n\n".join([*parts, report_text(curves, {"curves": contents["curves"]})])


def _lobes(section: BackgroundSection, sky: LobeSky, wavelength_nm: np.ndarray) -> dict[str, Any]:
    """Lobes and irradiances as JSON values. [W m-2 nm-1, nm, deg]"""
    import numpy as np

    from aomc_sky.formats.sky_toml.keys import moment_text
    from aomc_sky.skies.lobes.lobe import axis_deg, rotation_matrix
    from aomc_sky.skies.lobes.sky import plain_name

    shares = np.array([[lobe.share("plain"), lobe.share("projected")] for lobe in sky.lobes]).reshape(-1, 2)
    axes = [axis_deg(rotation_matrix(lobe.quaternion)) for lobe in sky.lobes]
    sphere = np.array([lobe.irradiance(wavelength_nm) for lobe in sky.lobes]).reshape(-1, wavelength_nm.size)
    plane, whole = sphere * shares[:, 1:], sphere.sum(axis=0)
    below = whole - (sphere * shares[:, :1]).sum(axis=0)
    loss = np.divide(below, whole, out=np.zeros_like(whole), where=whole > 0).clip(0.0, 1.0)
    return {
        "files": [section.file],
        "time": moment_text(section.time),
        "unix_time_s": section.time,
        "utc_offset_h": section.utc_offset,
        "interpolation": section.interpolation,
        "notes": list(sky.texts),
        "wavelength_nm": wavelength_nm.tolist(),
        "sphere_W_m2_nm": whole.tolist(),
        "irradiance_W_m2_nm": plane.sum(axis=0).tolist(),
        "horizon_loss": loss.tolist(),
        "lobes": [
            {
                "name": plain_name(lobe.name),
                "kind": lobe.kind,
                "param0": lobe.param0,
                "param1": lobe.param1,
                "quaternion": lobe.quaternion.tolist(),
                "zenith_deg": axes[k][0],
                "azimuth_deg": axes[k][1],
                "share_above_horizon": float(shares[k, 0]),
                "share_on_horizontal": float(shares[k, 1]),
                "sphere_W_m2_nm": sphere[k].tolist(),
                "irradiance_W_m2_nm": plane[k].tolist(),
            }
            for k, lobe in enumerate(sky.lobes)
        ],
    }
