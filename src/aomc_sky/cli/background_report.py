"""What a background-sky file holds: its animations and spectra, and at one time its lobes and their irradiance."""

from __future__ import annotations

import argparse
import datetime
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import table
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    import numpy as np

    from aomc_sky.formats.background.data import Animation, BackgroundFile
    from aomc_sky.source.backgrounds.light import LobeScene

_SHORT = {1: "hg", 2: "ggx", 3: "beckmann"}
MAX_KEYS_SHOWN = 100


MAX_LOBES, MAX_WAVELENGTHS, MAX_COLUMNS = 100, 40, 6


def report_background(arguments: argparse.Namespace) -> int:
    """Print what the file holds, or with --time the lobes of that time."""
    path = Path(arguments.path)
    if arguments.time is not None:
        try:
            time_s = cli_options.moment(arguments.time)
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"--time: {error}") from None
        scene = lobe_scene(arguments, time_s)
        print(json.dumps(as_json(scene)) if arguments.json else as_text(scene))
        return 0
    if arguments.wavelength is not None or arguments.animation is not None:
        raise UsageError("--wavelength and --animation need --time, the time of the lobes that are shown")
    from aomc_sky.formats.background.file import read_background_file

    file = read_background_file(path)
    print(json.dumps(_background_summary(path, file)) if arguments.json else "\n".join(_background_lines(path, file)))
    return 0


def lobe_scene(arguments: argparse.Namespace, time_s: float) -> LobeScene:
    """The lobes of a file at one time, as the options of `add_background_options` choose them."""
    from aomc_sky.formats.sky_toml.keys import BackgroundSection
    from aomc_sky.source.backgrounds.light import read_lobe_scene

    section = BackgroundSection(
        file=arguments.path,
        time=time_s,
        animation=None if arguments.animation is None else tuple(arguments.animation),
        utc_offset=arguments.utc_offset,
        interpolation=arguments.interpolation,
    )
    return read_lobe_scene(section, arguments.wavelength)


def _background_summary(path: Path, file: BackgroundFile) -> dict[str, Any]:
    info = file.info
    return {
        "format": "background sky",
        "path": str(path),
        "info": {name: getattr(info, name) for name in info.__slots__},
        "animations": {name: _animation(keys) for name, keys in file.animations.items()},
        "wavelength_nm": file.wavelength_nm.tolist(),
        "curves": [
            {"least": float(c.min()), "greatest": float(c.max()), "integral": _integral(file, c)} for c in file.curves
        ],
        "curve_unit": "W m-2 nm-1",
    }


def _integral(file: BackgroundFile, curve: np.ndarray) -> float:
    """Irradiance over all wavelengths, by trapezoids. [W m-2]"""
    width = file.wavelength_nm[1:] - file.wavelength_nm[:-1]
    return float((width * (curve[1:] + curve[:-1])).sum() / 2)


def _animation(keys: Animation) -> dict[str, Any]:
    return {
        "reference": keys.reference.name.lower(),
        "time_point_s": keys.time_point_s,
        "keys": [
            {
                "relative_time_days": float(keys.relative_time_days[k]),
                "type": _SHORT[int(keys.lobe_type[k])],
                "param0": float(keys.param0[k]),
                "param1": float(keys.param1[k]),
                "coefficient": float(keys.coefficient[k]),
                "quaternion": keys.quaternion[k].tolist(),
                "curve": int(keys.curve_index[k]),
            }
            for k in range(len(keys))
        ],
    }


def _background_lines(path: Path, file: BackgroundFile) -> Iterator[str]:
    from aomc_sky.formats.report import printable

    n_keys = sum(len(keys) for keys in file.animations.values())
    n = len(file.animations)
    yield f"background-sky file {path}, {n} animation{'s' * (n != 1)} with {n_keys} keys"
    for name in ("name", "author", "organization", "description"):
        if text := getattr(file.info, name):
            yield f"{name}: {printable(text)}"
    yield f"file type {file.info.file_type}, format version {file.info.format_version}"
    for name, keys in file.animations.items():
        yield f"\n{printable(name)}: {_reference(keys)}, {len(keys)} keys"
        rows = [_key_row(key) for key in _animation(keys)["keys"][:MAX_KEYS_SHOWN]]
        yield table(rows, ("day", "type", "g, alpha x", "alpha y", "factor", "quaternion", "curve"))
        if len(keys) > MAX_KEYS_SHOWN:
            yield f"... and {len(keys) - MAX_KEYS_SHOWN} more keys"
    wavelength = file.wavelength_nm
    yield f"\n{len(file.curves)} curves at {wavelength.size} wavelengths, {wavelength[0]:g} to {wavelength[-1]:g} nm"
    rows = [
        (str(k), f"{c.min():.6g}", f"{c.max():.6g}", f"{_integral(file, c):.6g}") for k, c in enumerate(file.curves)
    ]
    yield table(rows[:MAX_KEYS_SHOWN], ("curve", "least", "greatest W m-2 nm-1", "integral W m-2"))


def _key_row(key: dict[str, Any]) -> tuple[str, ...]:
    quaternion = " ".join(f"{q:.6g}" for q in key["quaternion"])
    param1 = "-" if key["type"] == "hg" else f"{key['param1']:g}"
    numbers = f"{key['relative_time_days']:g}", key["type"], f"{key['param0']:g}", param1, f"{key['coefficient']:g}"
    return *numbers, quaternion, str(key["curve"])


def _reference(keys: Animation) -> str:
    if keys.reference.name != "ABSOLUTE":
        return keys.reference.name.lower()
    try:
        text = datetime.datetime.fromtimestamp(keys.time_point_s, datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    except (OverflowError, OSError, ValueError):  # beyond the year 9999
        text = f"{keys.time_point_s} s since 1970"
    return f"absolute from {text}"


def as_json(scene: LobeScene) -> dict[str, Any]:
    """Lobes and irradiances as JSON values. [W m-2 nm-1, nm, deg]"""
    from aomc_sky.formats.sky_toml.rules import moment_text
    from aomc_sky.source.backgrounds.light import axis_of

    first = scene.section
    sphere, plane = scene.irradiance(), scene.irradiance(above="projected")
    return {
        "files": [first.file],
        "time": moment_text(first.time),
        "unix_time_s": first.time,
        "utc_offset_h": first.utc_offset,
        "interpolation": first.interpolation,
        "wavelength_nm": scene.wavelength_nm.tolist(),
        "sphere_W_m2_nm": sphere.sum(axis=0).tolist(),
        "irradiance_W_m2_nm": plane.sum(axis=0).tolist(),
        "horizon_loss": scene.horizon_loss.tolist(),
        "lobes": [
            {
                "name": name,
                "kind": lobe.kind,
                "param0": lobe.param0,
                "param1": lobe.param1,
                "quaternion": lobe.quaternion.tolist(),
                "zenith_deg": axis_of(lobe)[0],
                "azimuth_deg": axis_of(lobe)[1],
                "share_above_horizon": scene.share(lobe, "plain"),
                "share_on_horizontal": scene.share(lobe, "projected"),
                "sphere_W_m2_nm": sphere[k].tolist(),
                "irradiance_W_m2_nm": plane[k].tolist(),
            }
            for k, (name, lobe) in enumerate(scene.lobes)
        ],
    }


def as_text(scene: LobeScene) -> str:
    """Lobes for a person."""
    values = as_json(scene)
    lines = [
        f"{', '.join(values['files'])} at {values['time']}, local midnight {values['utc_offset_h']:+g} h from UTC, "
        f"{values['interpolation']} between keys",
        "",
    ]
    if not values["lobes"]:
        lines.append("no lobe has light at this time")
    else:
        lines += [*_lobe_lines(values), "", *_irradiance_lines(values)]
    return "\n".join(lines)


def _lobe_lines(values: dict[str, Any]) -> list[str]:
    rows = [
        (
            lobe["name"],
            lobe["kind"],
            f"{lobe['param0']:g}",
            "-" if lobe["kind"] == "hg" else f"{lobe['param1']:g}",
            f"{lobe['zenith_deg']:.3f}",
            f"{lobe['azimuth_deg']:.3f}",
            f"{lobe['share_above_horizon']:.6f}",
            f"{lobe['share_on_horizontal']:.6f}",
        )
        for lobe in values["lobes"][:MAX_LOBES]
    ]
    head = ("lobe", "kind", "g, alpha x", "alpha y", "zenith", "azimuth", "above", "on plane")
    lines = [
        "shares of each lobe above the horizon and on a horizontal plane; azimuth from +x (east) towards +y (north)",
        table(rows, head),
    ]
    hidden = len(values["lobes"]) - len(rows)
    return lines if hidden <= 0 else [*lines, f"... and {hidden} more lobes (--json has all)"]


def _irradiance_lines(values: dict[str, Any]) -> list[str]:
    by_light = sorted(values["lobes"], key=lambda lobe: -max(lobe["irradiance_W_m2_nm"]))
    shown = by_light[:MAX_COLUMNS]
    rows = [
        (
            f"{wavelength:g}",
            f"{values['sphere_W_m2_nm'][k]:.5g}",
            f"{values['irradiance_W_m2_nm'][k]:.5g}",
            f"{values['horizon_loss'][k]:.6f}",
            *(f"{lobe['irradiance_W_m2_nm'][k]:.4g}" for lobe in shown),
        )
        for k, wavelength in enumerate(values["wavelength_nm"][:MAX_WAVELENGTHS])
    ]
    lines = [
        "irradiance over the sphere, and Ed on a horizontal plane, of all lobes and of each [W m-2 nm-1]; "
        "below: share from below the horizon",
        table(rows, ("nm", "sphere", "Ed", "below", *(lobe["name"] for lobe in shown))),
    ]
    if len(values["wavelength_nm"]) > MAX_WAVELENGTHS or len(by_light) > len(shown):
        lines.append(f"... {len(values['wavelength_nm'])} wavelengths, {len(by_light)} lobes (--json has all)")
    return lines
