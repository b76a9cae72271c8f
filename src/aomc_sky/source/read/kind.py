"""Kind of a file or folder, by its name and first bytes, for commands and for messages about a wrong kind."""

from __future__ import annotations

import contextlib
import enum
import itertools
import os
import re
from pathlib import Path

from aomc_sky.errors import InputFileError
from aomc_sky.formats.text_file import refuse
from aomc_sky.system import open_regular


class Kind(enum.Enum):
    """Kinds of files and folders, as messages name them."""

    SCENE = "a scene"
    RUN = "a run"
    BACKGROUND = "a background sky"
    ATMOSPHERE = "an atmosphere"
    TABLE = "a sky file"
    NETCDF = "a netCDF file"
    LAMBBOT = "the table of wavebands of a scene"
    DIFCOL = "the table of direct fractions of a scene"
    SKY_TOML = "the sky.toml of a scene"
    MCPL = "an MCPL file of photons"
    SOURCE = "a source file for aomc_sky.h"
    NPY = "a numpy file of photons"
    RUN_FILE = "a file of a run"
    WEATHER = "a weather file"
    MEASURED = "a measured sky"
    PROGRAM = "a Python program"


_ENDINGS = {
    (".mcpl", ".mcpl.gz"): Kind.MCPL,
    (".h5", ".hdf5"): Kind.BACKGROUND,
    (".atmo",): Kind.ATMOSPHERE,
    (".sky",): Kind.SOURCE,
    (".toml",): Kind.SKY_TOML,
    (".nc", ".nc4", ".cdf"): Kind.NETCDF,
    (".npy",): Kind.NPY,
    (".epw", ".tm2", ".tmy2", ".tmy3"): Kind.WEATHER,
    (".py", ".ipynb"): Kind.PROGRAM,
}
_OF_A_RUN = ("plan.npz", "manifest.json", "counts.csv", "counts.npz")
_TABLES = {"amc": Kind.SCENE, "lambbot": Kind.LAMBBOT, "difcol": Kind.DIFCOL, "skydist": Kind.TABLE}
_FIRST_BYTES = {b"\x93NUMPY": Kind.NPY, b"MCPL": Kind.MCPL, b"AOMC-SKY": Kind.SOURCE, b"\x89HDF": Kind.BACKGROUND}
SCENE_FILES = (*(f"{name}.inp" for name in _TABLES), "sky.toml")
"""Files of a scene, in the order in which they are read."""

_HEAD_BYTES = 65_536
_AMC_LINES = 40
"""First bytes and lines of a file in which labels of amc.inp are looked for."""

_LABEL = re.compile(r"\s*(?:\d+|[a-z])\)|.{44,50}:\s*[-+.\d]")
"""A line of amc.inp: "4)depth (M)", or a colon before column 49."""

_SCENES = (
    "a scene is amc.inp or its folder; a table of radiances has a name in .csv, .tsv, .txt or .dat, a field in .nc"
)
TABLES = (".csv", ".tsv", ".txt", ".dat")
"""Ends of names of tables of radiances; amc.inp may end in the last two."""
_MOST_ENTRIES = 1000
"""Entries of a folder in which scenes are looked for."""


def kind_of_name(name: str) -> Kind | None:
    """Kind of a file by the end, the begin or a part of its name, or None."""
    name = name.lower()
    if name in _OF_A_RUN:
        return Kind.RUN_FILE
    for endings, kind in _ENDINGS.items():
        if name.endswith(endings):
            return kind
    for part, kind in _TABLES.items():
        if name.startswith(part) or f".{part}." in name:
            return kind
    return Kind.MEASURED if name.endswith(TABLES[:2]) else None


def kind_of(path: Path) -> Kind | None:
    """Kind of a file or a folder, or None."""
    if path.is_dir():
        is_run = (path / "manifest.json").exists() or (path / "plan.npz").exists()
        return Kind.RUN if is_run else Kind.SCENE if (path / "amc.inp").exists() else None
    kind = kind_of_name(path.name)
    if kind is None and path.is_file():
        with contextlib.suppress(OSError), open_regular(path) as file:
            start = file.read(8) or b""  # None: nothing yet, as of /proc/kmsg
            kind = next((one for first, one in _FIRST_BYTES.items() if start.startswith(first)), None)
        if kind is None and path.suffix.lower() in TABLES and not _has_label(path):
            return Kind.MEASURED
    return kind


def only_table(folder: Path) -> Path | None:
    """The table of radiances in a folder: the only file with the name of one."""
    tables = [name for name in _entries(folder) if kind_of_name(name) is Kind.MEASURED]
    return folder / tables[0] if len(tables) == 1 else None


def _entries(folder: Path) -> list[str]:
    """Names in a folder, sorted; none where it cannot be read."""
    with contextlib.suppress(OSError):
        return sorted(entry.name for entry in itertools.islice(os.scandir(folder), _MOST_ENTRIES))
    return []


def not_a_scene(amc: Path) -> InputFileError | None:
    """The error for a path that was given for amc.inp and is of another kind, or None."""
    is_folder = amc.name == "amc.inp" and not os.path.lexists(amc) and amc.parent.is_dir()
    path = amc.parent if is_folder else amc
    kind = kind_of(path)
    if kind is Kind.RUN:
        return refuse(
            path, "this is a run folder; amc.inp belongs here", advice=f"`aomc-sky info {path}` shows the run"
        )
    if path.is_dir():
        return _no_scene_here(path) if kind is None else None
    beside = path.with_name("amc.inp")
    if beside.is_file() and not os.path.lexists(path):
        return refuse(path, f"there is no such file; did you mean {beside}?")
    if not os.path.lexists(path) and kind is not Kind.SCENE:
        what = "file" if path.suffix else "file or folder"
        return refuse(path, f"there is no such {what}", advice="name amc.inp or the folder that holds it")
    if kind is Kind.SCENE or not path.is_file():
        return None
    if kind is None:
        return None if _has_label(path) else refuse(path, "this is not an amc.inp", advice=_SCENES)
    default = f"write {beside}" if beside.is_file() else "name amc.inp, which says how the files beside it are used"
    advice = {
        Kind.WEATHER: f"a run takes one hour of it: `aomc-sky run --weather {path} --row N --wavelengths 443 555 "
        "--out OUT`",
        Kind.MEASURED: "read it by sky.read_radiance_csv",
        Kind.ATMOSPHERE: f"`aomc-sky atmosphere {path} --out sky.nc` solves it; for photons name amc.inp, with "
        f'[atmosphere] and file = "{path.name}" in sky.toml beside it',
        Kind.BACKGROUND: "a scene adds it by [[background]] of sky.toml; a field of radiances has a name in .nc",
        Kind.NPY: "`aomc-sky verify --scene AMC_INP FILE` checks photons; radiances go into sky.TabulatedSky (Python)",
        Kind.MCPL: f"`aomc-sky verify --scene AMC_INP {path}` checks photons",
        Kind.SOURCE: f"`aomc-sky info {path}` shows it; C, C++, CUDA and Fortran read it by aomc_sky.h",
        Kind.PROGRAM: f"run it by Python: python {path}; there aomc_sky.write_run makes a run folder",
    }.get(kind, default)
    if kind in (Kind.RUN_FILE, Kind.NPY, Kind.MCPL, Kind.SOURCE) and kind_of(path.parent) is Kind.RUN:
        advice = f"`aomc-sky info {path.parent}` shows the run that it is of"
    return refuse(path, f"this is {kind.value}; amc.inp belongs here", advice=advice)


def _has_label(path: Path) -> bool:
    """Whether a line of a file begins as in amc.inp, or the file has no lines at all."""
    lines: list[str] = []
    with contextlib.suppress(OSError), open_regular(path) as file:
        lines = (file.read(_HEAD_BYTES) or b"").decode("latin-1").splitlines()[:_AMC_LINES]
    return not lines or any(_LABEL.match(line) for line in lines)


def _no_scene_here(folder: Path) -> InputFileError | None:
    """The error of a folder without amc.inp that has another spelling of it, scenes below it, or one table."""
    entries = _entries(folder)
    meant = [folder / name for name in entries if name.lower() == "amc.inp"][:1]
    meant = meant or [folder / name for name in entries if (folder / name / "amc.inp").is_file()]
    meant = meant or [path for path in (only_table(folder),) if path]
    if not meant:
        return None
    named = " or ".join(map(str, meant[:3])) + (f" or {len(meant) - 3} more" if len(meant) > 3 else "")
    return refuse(folder, f"there is no amc.inp in this folder; did you mean {named}?")


def not_a_run(path: Path) -> InputFileError:
    """The error for a path that is not a run folder."""
    kind = kind_of(path)
    if kind is Kind.SCENE:
        run = (path if path.is_dir() else path.parent) / "aomc-sky-out"
        is_there = kind_of(run) is Kind.RUN
        advice = f"name its run, {run}" if is_there else f"run it first: aomc-sky run {path}"
        return refuse(path, "this is a scene; a run folder belongs here", advice=advice)
    advice = "name the folder that `aomc-sky run --out` wrote"
    if path.is_dir():
        return refuse(path, "this folder holds no plan.npz, so it is not a run", advice=advice)
    if not path.exists():
        return refuse(path, "there is no such folder", advice=advice)
    if kind_of(path.parent) is Kind.RUN:
        advice = f"write {path.parent}"
    return refuse(path, f"this is {kind.value if kind else 'a file'}; a run folder belongs here", advice=advice)
