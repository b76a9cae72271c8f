"""Plans of small scenes through every entrance: does a change of how light is read change a plan, or an error?

    PYTHONPATH=old/src python bench/same_plans.py --write before.json
    PYTHONPATH=new/src python bench/same_plans.py --compare before.json    # exit code 1 where a plan differs

One copy of the script measures both trees: it uses the command line and public names alone, and writes its scenes
itself, of two wavebands. A scene is named by its entrance, by what its files say, and by what its caller says. The
entrances are `run` of a scene of files (run .), of radiances (run absolute.nc) and without files, `perez --out`,
`weather_scene` and `read_scene`. The extras weather, netcdf and hdf5 are needed.

Stored of a scene are the hash of its plan, or the error with its message, and warnings and notes. A changed plan is
explained by the share and the irradiance of each component in each waveband and by other numbers, before and after,
with 6 digits. Where all of these are equal, later digits differ, or the radiance inside a component. Scenes with other
messages, warnings or notes alone are counted; --messages shows them.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import itertools
import json
import re
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky as sky
from aomc_sky.cli.main import main as run_program

INPUTS = Path(__file__).resolve().parent.parent / "inputs"
NM = [500.0, 590.0]
"""The wavebands, which are also wavelengths of the atmosphere and of the tables."""
Sections = dict[str, dict[str, Any]]
"""Section of sky.toml, or argument of `read_scene` -> keys; "" has what is an argument itself."""

# What files say.

AMC = (INPUTS / "sun_and_sky" / "amc.inp").read_text().replace(": 5\n", ": 2\n")
CELLS = list(itertools.product((1, 2), range(1, 7), range(12)))
SKYDIST = "144 6 11 2\n500 590\n" + "".join(f"{k} {i} {j} {7 - i + 0.1 * j * k}\n" for k, i, j in CELLS)
FILES: dict[str, dict[str, str]] = {
    "flag 1": {"amc.inp": re.sub(r"(file\(1\) +: )0", r"\g<1>1", AMC), "skydist.inp": SKYDIST},
    "difcol": {"difcol.inp": "2\n0.55 0.80\n0.72 1.00\n"},
    "difcol all direct": {"difcol.inp": "2\n1.0 0.80\n1.0 1.00\n"},
    "difcol half direct": {"difcol.inp": "2\n0.55 0.80\n1.0 1.00\n"},
    "difcol no green": {"difcol.inp": "2\n0.55 0.0\n0.72 1.00\n"},
}
ATMOSPHERE = {"file": "clear.atmo", "method": "order1", "zenith_bins": 3, "azimuth_bins": 6}
MOON = {"moon_zenith_offset_deg": 0.2, "moon_distance_km": 370000}
MODELS = ("perez", "uniform", "none", "overcast", "cardioidal", "harrison-coombes")
TABLES = ("relative.csv", "absolute.csv", "relative.nc", "absolute.nc", "sunny.csv", "sunny.nc")
TOML: dict[str, Sections] = {
    "dni dhi": {"perez": {"dni": 850, "dhi": 95}},
    "ghi dhi": {"perez": {"ghi": 700, "dhi": 160}},
    "epsilon delta": {"perez": {"epsilon": 2.5, "delta": 0.2}},
    "a to e": {"perez": dict(zip("abcde", (-1.0, -0.32, 10, -3, 0.45), strict=True))},
    "flat": {"perez": {"spectrum": "flat"}},
    "spectrl2": {"perez": {"spectrum": "spectrl2"}},
    "air": {"clear_sky": {"aod_500nm": 0.3, "water_cm": 2.0}},
    "diffuse": {"sky": {"diffuse_irradiance": [0.3, 0.2]}},
    "direct": {"sky": {"direct_irradiance": [0.5, 0.7]}},
    "diffuse 0": {"sky": {"diffuse_irradiance": [0.0, 0.0]}},
    "direct 0": {"sky": {"direct_irradiance": [0.0, 0.0]}},
    "sun": {"sun": {"zenith_deg": 55.5, "azimuth_deg": 12.5}},
    "disc": {"sun": {"disc": True}},
    "polarisation": {"sky": {"polarisation": 0.75}},
    "background": {"background": {"file": "night.h5", "time": "2026-02-14T21:30:00Z", "utc_offset": 1}},
    "atmosphere": {"atmosphere": ATMOSPHERE},
    "moon": {"atmosphere": MOON},
    "cie": {"sky": {"model": "cie", "type": 12}},
    **{name: {"sky": {"model": name}} for name in MODELS},
    **{name: {"sky": {"table": name}} for name in TABLES},
}

# What a caller says, in options and in arguments of both functions.

SAID: dict[str, Sections] = {
    "dni dhi": {"perez": {"dni": 800, "dhi": 120}},
    "ghi dhi": {"perez": {"ghi": 780, "dhi": 140}},
    "epsilon delta": {"perez": {"epsilon": 4, "delta": 0.15}},
    "a to e": {"perez": {"coefficients": (-1, -0.3, 9, -3, 0.4)}},
    "flat": {"perez": {"spectrum": "flat"}},
    "spectrl2": {"perez": {"spectrum": "spectrl2"}},
    "air": {"clear_sky": {"aod_500nm": 0.2, "water_cm": 1.0}},
    "pressure": {"clear_sky": {"pressure_hPa": 1013.25}},
    "limits": {"perez": {"limits": "paper"}},
    "air mass": {"perez": {"air_mass": "kasten-1966"}},
    "extraterrestrial": {"perez": {"extraterrestrial_normal": 1400}},
    "within": {"": {"within": "uniform"}},
    "diffuse only": {"": {"diffuse_only": True}},
    "polarisation": {"": {"polarisation": 0.75}},
    "photons": {"": {"iterations": 5000}},
    "aomc": {"": {"compat": "aomc"}},
    "sun": {"sun": {"zenith_deg": 40.0, "azimuth_deg": 60.0}},
    "zenith": {"sun": {"zenith_deg": 55.0}},
    "azimuth": {"sun": {"azimuth_deg": 80.0}},
    "sun below": {"sun": {"zenith_deg": 95.0}},
    "disc": {"sun": {"disc": True}},
    "no disc": {"sun": {"disc": False}},
    "time": {"weather": {"time": "2026-06-21T09:30Z", "latitude_deg": 54.2, "longitude_deg": 7.9}},
    "altitude": {"weather": {"altitude_m": 3000.0}},
    "night": {"weather": {"time": "2026-06-21T23:30Z", "latitude_deg": 54.2, "longitude_deg": 7.9}},
    "epw": {"weather": {"epw": "two_days.epw", "row": 13}},
    "moon": {"atmosphere": MOON},
    "dni 0": {"perez": {"dni": 0, "dhi": 120}},
    "dhi 0": {"perez": {"dni": 800, "dhi": 0}},
    "dni too bright": {"perez": {"dni": 1500, "dhi": 20}},
    "ghi": {"perez": {"ghi": 760}},
    "ghi too dark": {"perez": {"ghi": 100, "dhi": 140}},
    "kilowatts": {"perez": {"dni": 0.8, "dhi": 0.12}},
    "cie": {"": {"sky": "cie", "sky_options": {"type": 12}}},
    **{name: {"": {"sky": name}} for name in MODELS},
}
NAMES = {
    "zenith_deg": "sun_zenith_deg", "azimuth_deg": "sun_azimuth_deg", "disc": "sun_disc", "iterations": "n_photons",
    "--zenith": "--sun-zenith", "--azimuth": "--sun-azimuth", "--sky-options": "--sky-option",
    "--aod-500nm": "--aod", "--extraterrestrial-normal": "--extraterrestrial",
}  # fmt: skip
"""Arguments of `weather_scene`, and options, that have other names than the keys."""


def glow(zenith: np.ndarray, azimuth: np.ndarray, nm: float) -> np.ndarray:
    """A sky as a function."""
    return 1 + np.cos(zenith) * nm / 500 + 0.2 * np.cos(azimuth)


def field() -> sky.TabulatedSky:
    """The sky of a netCDF file."""
    import xarray

    with xarray.open_dataset("absolute.nc", engine="h5netcdf") as data:
        return sky.TabulatedSky.from_xarray(data.load())


OBJECTS: dict[str, Callable[[], Any]] = {
    "UniformSky in W m-2 nm-1": lambda: sky.UniformSky(irradiance_W_m2_nm=[0.3, 0.2]),
    "TabulatedSky": field,
    "HarrisonCoombesSky": lambda: sky.HarrisonCoombesSky(sun_zenith_deg=40.0, sun_azimuth_deg=60.0),
    "OvercastSky": sky.OvercastSky,
    "a function": lambda: glow,
    "FunctionSky": lambda: sky.FunctionSky(glow, grid=sky.PatchGrid.regular(6, 12)),
    "PerezSky": lambda: sky.PerezSky(epsilon=2.5, delta=0.2, sun_zenith_deg=40.0, sun_azimuth_deg=60.0),
    "RadianceField": lambda: sky.read_radiance_csv("relative.csv"),
}
"""Skies that a caller of Python may say besides; they are made where the files are."""


def parts_of(text: str) -> list[str]:
    return [part for part in text.split(" + ") if part]


def sections_of(table: Mapping[str, Sections], parts: Sequence[str]) -> Sections:
    """What the parts say together."""
    found: Sections = {}
    for section, keys in (item for part in parts for item in table[part].items()):
        found[section] = found.get(section, {}) | keys
    return found


def options_of(said: str) -> str:
    """The options of a command."""
    words = []
    for name, value in (pair for keys in sections_of(SAID, parts_of(said)).values() for pair in keys.items()):
        option = "--" + re.sub("_(deg|m|km)$", "", name).replace("_", "-").lower()
        option = NAMES.get(option, option)
        if isinstance(value, bool):
            words.append(option if value else option.replace("--", "--no-"))
        else:
            text = " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
            words.append(f"{option} {'type=12' if isinstance(value, dict) else text}")
    return " ".join(words)


def arguments_of(said: str, *, flat: bool) -> dict[str, Any]:
    """The arguments of `weather_scene` (flat) or `read_scene`."""
    sections = sections_of(SAID, [part for part in parts_of(said) if part not in OBJECTS])
    found = sections.pop("", {})
    for part in (part for part in parts_of(said) if part in OBJECTS):
        found["sky"] = OBJECTS[part]()
    if "polarisation" in found:
        found["polarisation"] = sky.RayleighPattern(max_degree=found["polarisation"])
    if not flat:
        letters = sections.get("perez", {}).pop("coefficients", ())
        sections.get("perez", {}).update(zip("abcde", letters, strict=False))
        return found | sections
    if "clear_sky" in sections:
        found["clear_sky"] = sky.ClearSky(**sections.pop("clear_sky"))
    return {NAMES.get(name, name): value for keys in (found, *sections.values()) for name, value in keys.items()}


# The scenes: lists of what is said, between semicolons.


def several(text: str) -> list[str]:
    return [one.strip() for one in text.split(";")]


def both(first: str, second: str) -> str:
    """Each of the first with each of the second."""
    return "; ".join(" + ".join(filter(None, pair)) for pair in itertools.product(several(first), several(second)))


ANSWERS = """; difcol; dni dhi; ghi dhi; epsilon delta; a to e; spectrl2; spectrl2 + air; air; dni dhi + flat;
    dni dhi + spectrl2; dni dhi + sun + disc; dni dhi + polarisation; diffuse; direct; diffuse + direct;
    diffuse + direct 0; diffuse 0 + direct; diffuse + direct + sun + disc; dni dhi + diffuse; dni dhi + direct;
    dni dhi + diffuse + direct; dni dhi + spectrl2 + diffuse; spectrl2 + diffuse; spectrl2 + diffuse + direct;
    difcol + dni dhi; difcol + spectrl2; difcol + diffuse; difcol + direct; difcol + diffuse + direct; difcol + disc"""
FEW = "; difcol; dni dhi; dni dhi + spectrl2; spectrl2; diffuse; diffuse + direct; difcol + diffuse"
AMOUNTS = """dni dhi; ghi dhi; epsilon delta; a to e; spectrl2; spectrl2 + air; dni dhi + spectrl2; dni dhi + flat;
    diffuse only; polarisation; disc"""
MORE = """flat; air; limits; within; dni dhi + disc; dni dhi + no disc; dni dhi + diffuse only; dni dhi + polarisation;
    dni dhi + within; dni dhi + limits; dni dhi + air mass; dni dhi + extraterrestrial; dni dhi + air; dni dhi + ghi;
    dni dhi + epsilon delta; spectrl2 + epsilon delta; spectrl2 + a to e; spectrl2 + diffuse only; spectrl2 + disc"""
EDGES = """dni 0; dhi 0; dhi 0 + diffuse only; ghi too dark; kilowatts; spectrl2 + dni 0; spectrl2 + dni too bright"""
SUNS = """zenith; azimuth; sun below; dni dhi + night; time + sun; time + dni dhi; time + spectrl2; time + diffuse only;
    time + altitude + dni dhi; time + altitude + spectrl2; time + altitude + spectrl2 + pressure; epw; epw + spectrl2;
    epw + diffuse only; epw + dni dhi; epw + sun; epw + time"""
OVER = "dni dhi; epsilon delta; spectrl2; diffuse only; epw"
RUNS = {
    both("; flag 1; absolute.nc", ANSWERS): "",
    both("uniform; harrison-coombes; relative.nc", FEW): "",
    both("overcast; cie; cardioidal", "difcol; dni dhi; diffuse + direct"): "",
    both("relative.csv; absolute.csv; sunny.csv", "difcol; dni dhi; dni dhi + spectrl2; diffuse + direct"): "",
    both("sunny.nc", "; difcol; dni dhi; spectrl2; dni dhi + sun; diffuse + direct"): "; time",
    "": f"{AMOUNTS}; {MORE}; {EDGES}; {SUNS}; sun; time",
    "harrison-coombes; absolute.nc": f"{AMOUNTS}; epw",
    both("; absolute.nc", "difcol; dni dhi; diffuse; diffuse + direct; difcol + diffuse + direct"): OVER,
    "flag 1": both("; perez; harrison-coombes", f"{AMOUNTS}; dni dhi + disc; sun"),
    both("flag 1", "; dni dhi; diffuse; diffuse + direct; dni dhi + diffuse + direct"): "perez; uniform",
    "; difcol; diffuse + direct": "uniform; cie; overcast + dni dhi",
    "difcol all direct; difcol half direct; difcol no green": "; diffuse only; dni dhi",
    "difcol": "photons",
    "; difcol; difcol + dni dhi; flag 1": "aomc; aomc + dni dhi",
    both("none; perez; flag 1; absolute.nc", both("; diffuse; dni dhi", "background")): "",
    both("spectrl2; relative.nc; difcol + diffuse; diffuse + direct", "background"): "; dni dhi",
    "; none; background": "none; none + dni dhi",
    "atmosphere": "dni dhi; spectrl2; no disc; diffuse only; polarisation; sun; time; epw; moon; perez + dni dhi",
    both("atmosphere", "; difcol; flag 1; moon; background; sun; dni dhi; polarisation"): "",
}
"""What files say: what callers of `run .` say beside each of them."""
ALONE = f"""{both("sun", f"; {AMOUNTS}; {MORE}; {EDGES}")}; {SUNS}; perez; cardioidal; cardioidal + sun + dni dhi;
    {both("harrison-coombes", both("sun; time + altitude", OVER))};
    {both("uniform; overcast; cie; none", "; sun + dni dhi; sun + spectrl2; epw")}"""
TABLE = f"; {OVER}; disc; time + dni dhi; {both('sun', 'dni dhi; spectrl2; polarisation')}"
PEREZ = f"{both('sun', f'; {AMOUNTS}; {EDGES}; dni dhi + diffuse only; dni dhi + limits')}; {SUNS}"
KEYWORDS = f"""{both("sun", f"; {AMOUNTS}; dni dhi + diffuse only; dni dhi + disc")}; {SUNS};
    {both("harrison-coombes; UniformSky in W m-2 nm-1; TabulatedSky", both("; sun; time + altitude", f"; {OVER}"))};
    sun + dni dhi + photons; sun + dni dhi + a function;
    {both("cie; HarrisonCoombesSky; OvercastSky; FunctionSky; PerezSky; RadianceField", both("sun", "; dni dhi"))}"""
ABSOLUTE = both("UniformSky in W m-2 nm-1; TabulatedSky", "; dni dhi; spectrl2")
MAPPINGS = {
    "; difcol; flag 1": f"""; {AMOUNTS}; zenith + disc; time; time + altitude + spectrl2; epw; air;
        diffuse only + within; {ABSOLUTE}; FunctionSky""",
    "atmosphere": "; moon; dni dhi",
}
"""What files say: what callers of `read_scene` say beside each of them."""


def pairs(table: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What files say, and what a caller says."""
    for files, said in table.items():
        yield from itertools.product(several(files), several(said))


@cache
def cases() -> dict[str, tuple[str, str | None, str]]:
    """Entrance, what files say (None without amc.inp) and what a caller says, by the name that they make."""
    every: list[tuple[str, str | None, str]] = [
        *(("run .", *pair) for pair in pairs(RUNS)),
        *(("run --wavelengths 500 590", None, said) for said in several(ALONE)),
        *((f"run {table}", None, said) for table in TABLES for said in several(TABLE)),
        *(("perez --wavelengths 500 590", None, said) for said in several(PEREZ)),
        *(("weather_scene", None, said) for said in several(KEYWORDS)),
        *(("read_scene", *pair) for pair in pairs(MAPPINGS)),
    ]
    return {" | ".join(one or "nothing" for one in case if one is not None): case for case in every}


def write_scene(folder: Path, parts: Sequence[str]) -> None:
    """Write amc.inp, lambbot.inp and what the parts say."""
    files = {"amc.inp": AMC, "lambbot.inp": "2\n" + "".join(f"{nm} 0.05 0.0\n" for nm in NM)}
    for part in parts:
        files |= FILES.get(part, {})
    lines = []
    for section, keys in sections_of(TOML, [part for part in parts if part not in FILES]).items():
        lines.append(f"[[{section}]]" if section == "background" else f"[{section}]")
        lines += [f"{name} = {json.dumps(value)}" for name, value in keys.items()]
    files |= {"sky.toml": "\n".join(lines)} if lines else {}
    for name, text in files.items():
        (folder / name).write_text(text)


def write_shared(folder: Path) -> None:
    """Write the tables of radiances, and copy an hour's weather, a night and an atmosphere."""
    import xarray

    for name in ("weather/two_days.epw", "night_sky/night.h5", "atmosphere_sky/clear.atmo"):
        shutil.copy(INPUTS / name, folder)
    zenith, azimuth = np.arange(7.5, 90.0, 15.0), np.arange(15.0, 360.0, 30.0)
    green = 0.05 * (1 + np.cos(np.radians(zenith)))[:, None] * (1 + 0.3 * np.cos(np.radians(azimuth - 60)))
    axes = {
        "wavelength": ("wavelength", NM, {"units": "nm"}),
        "zenith": ("zenith", zenith, {"units": "degree"}),
        "azimuth": ("azimuth", azimuth, {"units": "degree", "azimuth_convention": "counterclockwise from east"}),
    }
    made = xarray.DataArray(np.stack([green, 0.7 * green]), axes, tuple(axes), name="radiance")
    rows = [f"{zenith[i]},{azimuth[j]},{one:.5f},{0.7 * one:.5f}" for (i, j), one in np.ndenumerate(green)]
    for kind, unit in (("relative", "relative"), ("absolute", "W m-2 nm-1 sr-1"), ("sunny", "W m-2 nm-1 sr-1")):
        head = ["# azimuth: counterclockwise from east", f"# radiance unit: {unit}"]
        made.attrs = {} if kind == "relative" else {"units": unit}
        if kind == "sunny":
            head += ["# sun zenith: 35", "# sun azimuth: 65 counterclockwise from east"]
            made.attrs |= {"sun_zenith_deg": 35.0, "sun_azimuth_deg": 65.0}
        text = "\n".join([*head, "zenith_deg,azimuth_deg,L_500,L_590", *rows, ""])
        (folder / f"{kind}.csv").write_text(text)
        made.to_netcdf(folder / f"{kind}.nc", engine="h5netcdf")


# What is found.


def numbers_of(values: Any, name: str = "") -> dict[str, str]:
    """Numbers of options, with 6 digits, by their names."""
    if isinstance(values, (list, tuple)):
        values = dict(enumerate(values))
    if isinstance(values, Mapping):
        inner = (numbers_of(value, f"{name} {key}") for key, value in values.items())
        return {path: shown for one in inner for path, shown in one.items()}
    return {name.strip(): f"{values:.6g}"} if isinstance(values, (int, float)) else {}


def summary_of(source: sky.PhotonSource, options: Mapping[str, Any]) -> dict[str, Any]:
    """Share and irradiance of the components in each waveband, and other numbers."""
    light, numbers = [], numbers_of(options)
    for band, nm in enumerate(source.plan.wavelength_nm.tolist()):
        shares = [f"{c.name} {c.mass.sum():.6g}" for c in source.components_of(band)]
        known = (source.irradiance(band) or {}).values()
        units = [f" ({irradiance:.6g} W m-2 nm-1)" for irradiance in known] or [""] * len(shares)
        light.append(f"{nm:g} nm: " + ", ".join(map("".join, zip(shares, units, strict=True))))
        numbers[f"photons at {nm:g} nm"] = str(source.n_photons(band))
        numbers[f"mean cosine at {nm:g} nm"] = f"{source.exact_moments(band).mean_mu:.6g}"
    return {"plan": source.plan.sha256, "light": light, "numbers": numbers}


def by_command(words: str) -> dict[str, Any]:
    """The plan of a run, or the error that is printed."""
    out, err = io.StringIO(), io.StringIO()
    code: str | int | None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = run_program(f"{words} --format none --json --seed 1 --out out".split())
        except SystemExit as left:
            code = left.code
    values, said = json.loads(out.getvalue()), {"warnings": err.getvalue().splitlines()}
    if code:
        problems = values["error"]["problems"]
        codes = " ".join(dict.fromkeys(one["code"] for one in problems))
        texts = ["; ".join(filter(None, (one["message"], one["advice"]))) for one in problems]
        return {"error": f"exit {code}, {codes}: {' / '.join(texts)}", **said}
    manifest = values if "plan_sha256" in values else values["run"]
    source = sky.PhotonSource.from_plan(sky.Plan.load("out/plan.npz"))
    found = summary_of(source, manifest["options"]["scene"]) | {"plan": manifest["plan_sha256"]}
    return {**found, "notes": manifest["notes"], **said}


def by_python(entrance: str, said: str) -> dict[str, Any]:
    """The plan of a scene, or the error that is raised."""
    try:
        if entrance == "read_scene":
            scene = sky.read_scene(".", **arguments_of(said, flat=False))
        else:
            scene = sky.weather_scene(wavebands=NM, **arguments_of(said, flat=True))
        return {**summary_of(scene.source(seed=1), scene.options), "notes": list(scene.notes)}
    except sky.AomcSkyError as error:
        return {"error": f"{type(error).__name__}: {error}"}


def found_of(name: str, shared: str) -> dict[str, Any]:
    """Everything that is stored of a scene."""
    entrance, files, said = cases()[name]
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        shutil.copytree(shared, folder, dirs_exist_ok=True)
        if files is not None:
            write_scene(Path(folder), parts_of(files))
        with contextlib.chdir(folder):
            try:
                is_python = entrance in ("read_scene", "weather_scene")
                found = by_python(entrance, said) if is_python else by_command(f"{entrance} {options_of(said)}")
            except Exception as error:  # a fault of the program
                place = traceback.extract_tb(error.__traceback__)[-1]
                found = {"crash": f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})"}
    texts = [f"{one.category.__name__}: {one.message}" for one in caught]
    return {**found, "warnings": [*found.get("warnings", []), *texts]}


# Before and after.

EQUAL, ANOTHER = "equal", "another plan"
LISTED = (ANOTHER, "an error, was a plan", "a plan, was an error", "a crash", "gone")
WORDS = ("an error, another one or its message", "the same plan, other warnings or notes")
"""Verdicts: scenes of `LISTED` are printed, those of `WORDS` only where they are asked for."""


def verdict_of(before: Mapping[str, Any], after: Mapping[str, Any] | None) -> str:
    """What is said of a scene that was measured twice."""
    if after is None or "crash" in after:
        return "gone" if after is None else "a crash"
    if ("plan" in before) != ("plan" in after):
        return "a plan, was an error" if "plan" in after else "an error, was a plan"
    if before.get("plan") != after.get("plan"):
        return ANOTHER
    is_equal = all(before.get(name) == after.get(name) for name in ("error", "warnings", "notes"))
    return EQUAL if is_equal else WORDS["plan" in after]


def lines_of(before: Mapping[str, Any], after: Mapping[str, Any], *, messages: bool) -> Iterator[str]:
    """Plan, light and numbers, or the error, before and after; with `messages` also warnings and notes that differ."""
    is_one_kind = ("plan" in before) == ("plan" in after)
    for sign, one, other in (("-", before, after), ("+", after, before)):
        plan = f"{one['plan'][:16]}  {'; '.join(one['light'])}" if "plan" in one else ""
        yield " ".join(f"{sign} {plan or one.get('error') or one.get('crash', '')}".split())
        for kind in ("warnings", "notes") if messages and is_one_kind else ():
            yield from (f"{sign}   {kind}: {text}" for text in one.get(kind, ()) if text not in other.get(kind, ()))
    old, new = (one.get("numbers", {}) for one in (before, after))
    for name in (name for name in old | new if old and new and old.get(name) != new.get(name)):
        yield f"    {name}: {old.get(name, 'absent')} -> {new.get(name, 'absent')}"


def compare(before: Mapping[str, Any], after: Mapping[str, Any], *, messages: bool) -> bool:
    """Print what differs; whether more than words do."""
    verdicts = {name: verdict_of(before[name], after.get(name)) for name in before}
    for verdict in (*LISTED, *(WORDS if messages else ())):
        for name in (name for name, its in verdicts.items() if its == verdict):
            print(f"{verdict}: {name}", *lines_of(before[name], after.get(name, {}), messages=messages), sep="\n  ")
    counts = Counter(verdicts.values())
    print(*(f"{counts[verdict]:6d}  {verdict}" for verdict in (EQUAL, *WORDS, *LISTED)), sep="\n")
    print(f"{len(after.keys() - before.keys()):6d}  new, not compared")
    return any(counts[verdict] for verdict in LISTED)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", type=Path, metavar="FILE.json", help="store what was found")
    parser.add_argument("--compare", type=Path, metavar="FILE.json", help="compare with what was stored")
    parser.add_argument("--messages", action="store_true", help="show messages, warnings and notes that differ")
    parser.add_argument("--only", default="", metavar="TEXT", help="scenes with this text in their names")
    arguments = parser.parse_args()
    began, names = time.perf_counter(), [name for name in cases() if arguments.only in name]
    with tempfile.TemporaryDirectory() as shared, ProcessPoolExecutor(2) as pool:
        write_shared(Path(shared))
        found = dict(zip(names, pool.map(partial(found_of, shared=shared), names, chunksize=8), strict=True))
    kinds = Counter(next(kind for kind in ("plan", "error", "crash") if kind in one) for one in found.values())
    print(f"{Path(sky.__file__).parent}: {time.perf_counter() - began:.0f} s, {dict(kinds)}", file=sys.stderr)
    if arguments.write:
        arguments.write.write_text(json.dumps(found, indent=1))
    if arguments.compare:
        stored = json.loads(arguments.compare.read_text())
        before = {name: one for name, one in stored.items() if arguments.only in name}
        return int(compare(before, found, messages=arguments.messages))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
