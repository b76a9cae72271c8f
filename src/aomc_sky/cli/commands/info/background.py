"""What ``aomc-sky info`` tells of a background-sky file: its animations, their keys, its spectra."""

from __future__ import annotations

import datetime
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from aomc_sky.formats.background.data import Animation, BackgroundFile

_SHORT = {1: "hg", 2: "ggx", 3: "beckmann"}
MAX_KEYS_SHOWN = 100


def report_background(path: Path, *, as_json: bool) -> int:
    """Print what a file holds."""
    from aomc_sky.formats.background.file import read_background_file

    file = read_background_file(path)
    print(json.dumps(_summary(path, file)) if as_json else "\n".join(_lines(path, file)))
    return 0


def _summary(path: Path, file: BackgroundFile) -> dict[str, Any]:
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
    return float(np.sum(np.diff(file.wavelength_nm) * (curve[1:] + curve[:-1])) / 2)


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


def _lines(path: Path, file: BackgroundFile) -> Iterator[str]:
    from aomc_sky.cli.table import table
    from aomc_sky.formats.background.hdf5_members import printable

    n_keys = sum(len(keys) for keys in file.animations.values())
    n = len(file.animations)
    yield f"background-sky file {path}, {n} animation{'s' * (n != 1)} with {n_keys} keys"
    for name in ("name", "author", "organization", "description"):
        if text := getattr(file.info, name):
            yield f"{name}: {printable(text)}"
    yield f"file type {file.info.file_type}, format version {file.info.format_version}"
    for name, keys in file.animations.items():
        yield f"\n{printable(name)}: {_reference(keys)}, {len(keys)} keys"
        rows = [_row(key) for key in _animation(keys)["keys"][:MAX_KEYS_SHOWN]]
        yield table(rows, ("day", "type", "g, alpha x", "alpha y", "factor", "quaternion", "curve"))
        if len(keys) > MAX_KEYS_SHOWN:
            yield f"... and {len(keys) - MAX_KEYS_SHOWN} more keys"
    wavelength = file.wavelength_nm
    yield f"\n{len(file.curves)} curves at {wavelength.size} wavelengths, {wavelength[0]:g} to {wavelength[-1]:g} nm"
    rows = [
        (str(k), f"{c.min():.6g}", f"{c.max():.6g}", f"{_integral(file, c):.6g}") for k, c in enumerate(file.curves)
    ]
    yield table(rows[:MAX_KEYS_SHOWN], ("curve", "least", "greatest W m-2 nm-1", "integral W m-2"))


def _row(key: dict[str, Any]) -> tuple[str, ...]:
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
