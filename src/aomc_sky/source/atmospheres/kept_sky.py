"""The sky of an atmosphere from the cache where it was solved before, with the bits of a new solution.

Its key is the hash of the medium, of what lights it, of the patches, and of all that can change a bit on the way: the
text of this package, the versions of the libraries that compute, and what the processor can do. What stands in the
cache is checked like any other file: numbers of a stated shape, nothing that could run.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import math
import os
import platform
import time
import warnings
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.atmosphere.lights import GroundBeam, Moon
from aomc_sky.atmosphere.medium import Medium, contents, scatterers
from aomc_sky.atmosphere.sky.method import METHODS
from aomc_sky.atmosphere.sky.solved import SkyField, SolvedSky
from aomc_sky.atmosphere.twilight import ExactOnce
from aomc_sky.cache import Cache, DamagedEntryError
from aomc_sky.errors import CacheWarning, InputWarning, ModelLimitWarning
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.atmosphere import AtmosphereSky, Solution
from aomc_sky.system import c_library_release

_REPORTED = (InputWarning, ModelLimitWarning)
"""What a solution may warn of, and warns of again when it comes from the cache."""

_LIBRARIES = ("numpy", "scipy", "numba", "llvmlite")
_SWITCHES = ("NUMBA_", "NPY_", "OPENBLAS_", "MKL_", "OMP_")
_IDLE_SWITCHES = ("NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS")


def kept_sky(
    cache: Cache | None,
    *,
    medium: Medium,
    sun_zenith_deg: float,
    sun_azimuth_deg: float = 0.0,
    method: str = "auto",
    n_orders: int | None = None,
    grid: PatchGrid,
    disc: bool = True,
    moon: Moon | None = None,
    ground_radiance: np.ndarray | None = None,
    n_paths: int | None = None,
) -> AtmosphereSky:
    """`AtmosphereSky` of these arguments, from the cache where it has the solution; else solved, and kept there.

    The same bits and the same warnings in both cases. A CacheWarning reports an entry that was damaged. None is no
    cache.
    """
    lights = (sun_zenith_deg, sun_azimuth_deg, method, n_orders, moon, ground_radiance, n_paths)
    key = None if cache is None else _key(medium, grid, lights)
    make = functools.partial(
        AtmosphereSky, medium=medium, sun_zenith_deg=sun_zenith_deg, sun_azimuth_deg=sun_azimuth_deg, method=method,
        n_orders=n_orders, grid=grid, disc=disc, moon=moon, ground_radiance=ground_radiance, n_paths=n_paths,
    )  # fmt: skip
    if cache is None or key is None:
        return make()
    try:
        started, content = time.perf_counter(), cache.read(key)
        if content is not None:
            solution, reported = _decoded(content, medium, sun_zenith_deg, moon, grid)
            solution.solved.seconds["cache"] = time.perf_counter() - started
            _report(reported)
            return make(solution=solution)
    except DamagedEntryError as damage:
        text = f"{cache.path(key)}: this kept solution of an atmosphere is damaged ({damage}); it is solved anew"
        warnings.warn(text, CacheWarning, stacklevel=2)
    sky, reported, is_all = _solved(make)
    if is_all:
        cache.write(key, _encoded(sky, reported))
    _report(reported)
    return sky


def _solved(make: Callable[[], AtmosphereSky]) -> tuple[AtmosphereSky, list[tuple[str, str]], bool]:
    """Solve; what the package warns of, for `_report`; and whether nobody else warned, whom it could not repeat."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sky = make()
    reported = [(one.category.__name__, str(one.message)) for one in caught if one.category in _REPORTED]
    for one in caught:
        if one.category not in _REPORTED:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
    return sky, reported, len(reported) == len(caught)


def _report(reported: Sequence[tuple[str, str]]) -> None:
    categories = {category.__name__: category for category in _REPORTED}
    for name, text in reported:
        warnings.warn(text, categories[name], stacklevel=3)


def _key(medium: Medium, grid: PatchGrid, lights: tuple[Any, ...]) -> str | None:
    """Hash of everything that a solution follows from, None of a medium that no description can say."""
    of_medium = contents(medium)
    if of_medium is None:
        return None
    digest = hashlib.sha256()
    patches = (grid.zenith_bounds_deg, grid.azimuth_bounds_deg)
    for part in (_of_code(), _of_machine(), of_medium, patches, lights):
        _add(digest, part)
    return digest.hexdigest()


def _add(digest: Any, value: Any) -> None:
    """Add a value with its kind and its length, so that no two different ones give the same bytes."""
    if isinstance(value, np.ndarray):
        digest.update(f"array {value.dtype.str} {value.shape} ".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, tuple):
        digest.update(f"tuple {len(value)} ".encode())
        for one in value:
            _add(digest, one)
    elif dataclasses.is_dataclass(value):
        _add(digest, (type(value).__name__, *(getattr(value, one.name) for one in dataclasses.fields(value))))
    else:
        text = float(value).hex() if isinstance(value, float) else str(value)
        digest.update(f"{type(value).__name__} {len(text)} {text} ".encode())


@functools.cache
def _of_code() -> tuple[str, ...]:
    """The text of the package, and the versions of the libraries that compute."""
    digest, root = hashlib.sha256(), Path(aomc_sky.__file__).parent
    for path in sorted(root.rglob("*.py")):
        digest.update(f"{path.relative_to(root).as_posix()} ".encode() + path.read_bytes())
    return (aomc_sky.__version__, digest.hexdigest(), *map(_release, _LIBRARIES))


def _release(library: str) -> str:
    """What tells versions of a library apart: the text of its own file about it, which costs no import."""
    spec = find_spec(library)
    folder = Path(spec.origin).parent if spec is not None and spec.origin else Path()
    texts = [path.read_text() for path in (folder / "_version.py", folder / "version.py") if path.is_file()]
    return "\n".join([library, *texts])


def _of_machine() -> tuple[str, ...]:
    """What may change the last bit of a function: the processor's abilities, the C library, the switches of others."""
    core = getattr(np, "_core", None) or np.core
    features = getattr(core._multiarray_umath, "__cpu_features__", {})
    switches = (
        f"{name}={value}"
        for name, value in sorted(os.environ.items())
        if name.startswith(_SWITCHES) and name not in _IDLE_SWITCHES
    )
    abilities = sorted(name for name, is_there in features.items() if is_there)
    return (platform.system(), platform.machine(), c_library_release(), *abilities, *switches)


_MOST_HEAD = 2**16
_FIELDS = ("once", "more", "glow")
_NUMBERS = ("resolution_error", "series_error", "visible_share", "glow_error")
"""Of `SolvedSky`; the change of the patches stands behind them."""


def _encoded(sky: AtmosphereSky, reported: Sequence[tuple[str, str]]) -> bytes:
    """A line of JSON about the solution and its arrays, and the arrays behind it, float64 with their low byte first."""
    solved = sky.solved
    fields = {name: getattr(solved, name) for name in _FIELDS}
    series = {name: field for name, field in fields.items() if isinstance(field, SkyField)}
    arrays = {name: field.coefficient for name, field in series.items()}
    arrays |= {
        "truncation": solved.truncation,
        "depth": solved.direct.optical_depth,
        "irradiance": solved.direct.irradiance,
        "numbers": np.array([*(getattr(solved, name) for name in _NUMBERS), sky.patch_change]),
        "patch_mean": sky.patch_mean,
    }
    if solved.node_error is not None:
        arrays["node_error"] = solved.node_error
    about = {
        "method": solved.method,
        "n_orders": solved.n_orders,
        "n_paths": solved.n_paths,
        "reason": solved.reason,
        "has_moon": solved.moon is not None,
        "mirrored": [name for name, field in series.items() if field.is_mirrored],
        "warnings": [list(one) for one in reported],
        "arrays": {name: list(array.shape) for name, array in arrays.items()},
    }
    head = json.dumps(about, allow_nan=False).encode("ascii") + b"\n"
    return head + b"".join(np.ascontiguousarray(array).astype("<f8").tobytes() for array in arrays.values())


def _decoded(
    content: bytes, medium: Medium, sun_zenith_deg: float, moon: Moon | None, grid: PatchGrid
) -> tuple[Solution, list[tuple[str, str]]]:
    """What `_encoded` wrote of a sky of these arguments, and its warnings; DamagedEntryError for anything else."""
    head, _, body = content.partition(b"\n")
    try:
        about = json.loads(head if len(head) <= _MOST_HEAD else b"")
        found = _arrays(about["arrays"], body)
        reported = [(str(name), str(text)) for name, text in about["warnings"]]
        numbers, mirrored = found["numbers"], about["mirrored"]
        series = {
            name: SkyField(coefficient=found[name], is_mirrored=name in mirrored) for name in _FIELDS if name in found
        }
        _check(about, found, reported, medium, grid)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise DamagedEntryError("it is not in the form of this version") from error
    sun = math.radians(sun_zenith_deg)
    solved = SolvedSky(
        medium=medium,
        sun_zenith_rad=sun,
        once=series.get("once") or ExactOnce(medium=medium, sun_zenith_rad=sun),
        more=series.get("more"),
        glow=series.get("glow"),
        direct=GroundBeam(
            sun_zenith_rad=sun,
            sun_angular_radius_rad=medium.sun_angular_radius_rad,
            optical_depth=found["depth"],
            irradiance=found["irradiance"],
        ),
        method=about["method"],
        n_orders=about["n_orders"],
        n_paths=about["n_paths"],
        reason=about["reason"],
        moon=moon if about["has_moon"] else None,
        truncation=found["truncation"],
        node_error=found.get("node_error"),
        seconds={},
        **dict(zip(_NUMBERS, numbers[:-1].tolist(), strict=True)),
    )
    return Solution(solved=solved, patch_mean=found["patch_mean"], patch_change=float(numbers[-1])), reported


def _arrays(shapes: dict[str, list[int]], body: bytes) -> dict[str, np.ndarray]:
    """Arrays by their names, which take all the bytes there are."""
    values, found, start = np.frombuffer(body, "<f8"), {}, 0
    for name, shape in shapes.items():
        if not all(type(n) is int and n >= 0 for n in shape):
            raise ValueError("a length is no whole number")
        n_values = math.prod(shape)
        found[name] = values[start : start + n_values].reshape(shape).astype(np.float64)
        start += n_values
    if start != values.size:
        raise ValueError("numbers are left")
    return found


def _check(
    about: dict[str, Any],
    found: dict[str, np.ndarray],
    reported: Sequence[tuple[str, str]],
    medium: Medium,
    grid: PatchGrid,
) -> None:
    """Raise a ValueError for what no solution of this medium in these patches can be."""
    n_wl = medium.wavelength_nm.size
    n_listed = found["patch_mean"].shape[1]
    shapes = {
        "once": (n_wl, len(scatterers(medium)), None, None),
        "more": (n_wl, None, None, None),
        "glow": (n_wl, None, None, None),
        "truncation": (n_wl,),
        "depth": (n_wl,),
        "irradiance": (n_wl,),
        "numbers": (len(_NUMBERS) + 1,),
        "patch_mean": (n_wl, n_listed, grid.n_patches),
        "node_error": (n_wl, None, None),
    }
    is_right = all(_fits(array.shape, shapes[name]) for name, array in found.items())
    is_right &= all(type(about[name]) is int and about[name] >= 0 for name in ("n_orders", "n_paths"))
    is_right &= about["method"] in METHODS[1:] and type(about["reason"]) is str and type(about["has_moon"]) is bool
    is_right &= {name for name, _ in reported} <= {category.__name__ for category in _REPORTED}
    is_right &= all(np.isfinite(found[name]).all() for name in found if name not in ("truncation", "depth"))
    is_right &= all((found[name] >= 0).all() for name in ("patch_mean", "irradiance", "numbers"))
    is_right &= not np.isnan(found["depth"]).any()
    if not is_right:
        raise ValueError("a value is out of range")


def _fits(shape: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(shape) == len(wanted) and all(w is None or n == w for n, w in zip(shape, wanted, strict=True))
