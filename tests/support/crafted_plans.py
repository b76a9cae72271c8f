"""Plans that nobody would write but an attacker: small real ones of every kind, and what is changed in them."""

from __future__ import annotations

import functools
import io
import json
import os
import struct
import warnings
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.plan.plan import Plan
from tests.support.lobes import lobe_components

N = 997
WAVEBANDS = sky.Wavebands(wavelength_nm=np.array([450.0, 550.0]))

Change = Callable[[dict[str, Any], dict[str, Any]], None]


def _table(law: Law = Law.CELL_MU2, *, weight: bool = False) -> Component:
    grid = sky.PatchGrid.regular(3, 4)
    mass = np.random.default_rng(3).lognormal(0, 1, (2, 12))
    mass[:, 5] = 0.0
    more = {"weight": np.full((2, 12), 0.5)} if weight else {}
    cell = cells_of_grid(grid, law)
    return Component(name="table", law=law, strength=np.ones(2), mass=mass, cell=cell, grid=grid, **more)


def _perez() -> tuple[Component, ...]:
    grid = sky.PatchGrid.regular(3, 4)
    model = sky.PerezSky(sun_zenith_rad=0.7, sun_azimuth_rad=0.2, epsilon=8.0, delta=0.1, grid=grid)
    return model.lower([450, 550])


def _disc(zenith: float, radius: float) -> tuple[Component, ...]:
    model = sky.DirectBeam(sun_zenith_deg=zenith, sun_azimuth_deg=200, radius_deg=radius)
    return model.lower([450, 550])


def _lobes() -> tuple[Component, ...]:
    turn = np.array([[np.cos(0.3), np.sin(0.3), 0.0, 0.0]] * 3)
    kinds = ["hg", "ggx", "beckmann"]
    return lobe_components(
        names=kinds,
        kinds=kinds,
        param0=[0.8, 0.3, 0.2],
        param1=[0.0, 0.5, 0.6],
        quaternion=turn,
        irradiance=np.ones((3, 2)),
    )


_SCENES: dict[str, tuple[Callable[[], tuple[Component, ...]], dict[str, Any]]] = {
    "table": (lambda: (_table(),), {}),
    "solid angle": (lambda: (_table(Law.CELL_MU, weight=True),), {"weights": True, "precision": "float64"}),
    "perez": (_perez, {}),
    "lobes": (_lobes, {}),
    "disc": (lambda: (*_disc(20, 0.27), _table()), {}),
    "horizon": (lambda: (*_disc(89.9, 0.27), _table()), {"order": "patch"}),
    "beam": (lambda: (*_disc(35, 0.0), _table()), {"method": "iid"}),
    "lobes in float64": (_lobes, {"precision": "float64"}),
    "replicates": (lambda: (_table(),), {"replicates": 5}),
    "centre": (lambda: (_table(),), {"placement": "centre"}),
}
KINDS = tuple(_SCENES)


@functools.cache
def plan_of(kind: str) -> Plan:
    """A small plan of one kind of scene."""
    components, options = _SCENES[kind]
    scene = sky.Scene(
        wavebands=WAVEBANDS,
        n_photons=N,
        components=components(),
        footprint=sky.Footprint(shape="circle", size_x_m=2.0, size_y_m=2.0) if kind == "table" else sky.Footprint(),
    )
    return scene.source(9, **options).plan


def changed(plan: Plan, change: Change) -> Plan:
    """The plan with something changed; its arrays are copies."""
    arrays: dict[str, Any] = {name: array.copy() for name, array in plan.arrays.items()}
    options = json.loads(json.dumps(plan.options))
    change(arrays, options)
    return Plan(arrays=arrays, options=options)


@dataclass(frozen=True, kw_only=True, slots=True)
class CraftedPlan:
    """One changed plan: its name, the plan it was, the codes that may answer, and the change."""

    name: str
    kind: str
    codes: tuple[str, ...]
    change: Change

    def plan(self) -> Plan:
        """The plan."""
        return changed(plan_of(self.kind), self.change)


@dataclass(frozen=True, kw_only=True, slots=True)
class CraftedFile:
    """A file in the place of plan.npz: its name, and who writes it to a path."""

    name: str
    write: Callable[[Path], None]


# arrays


def _put(name: str, index: Any, value: Any) -> Change:
    def change(arrays: dict[str, Any], _: dict[str, Any]) -> None:
        arrays[name][index] = value

    return change


def _make(name: str, make: Callable[[Any], Any]) -> Change:
    def change(arrays: dict[str, Any], _: dict[str, Any]) -> None:
        arrays[name] = make(arrays[name])

    return change


def _drop(name: str) -> Change:
    return lambda arrays, _: arrays.pop(name)


def _add(name: str, value: Any) -> Change:
    def change(arrays: dict[str, Any], _: dict[str, Any]) -> None:
        arrays[name] = value

    return change


def _option(name: str, value: Any) -> Change:
    def change(_: dict[str, Any], options: dict[str, Any]) -> None:
        options[name] = value

    return change


def _no_option(name: str) -> Change:
    return lambda _, options: options.pop(name)


def _of_every_array() -> Iterator[tuple[str, str, str, Change]]:
    """Every array of every kind once: missing, of another type, too short, with an axis more, out of range."""
    seen: set[str] = set()
    for kind in KINDS:
        for name, array in plan_of(kind).arrays.items():
            if name in seen:
                continue
            seen.add(name)
            other = np.float32 if array.dtype.kind == "f" else np.int32 if array.dtype != np.int8 else np.int16
            is_bounds_of_table = name.endswith(("bounds_deg_0", "bounds_deg_1"))
            yield f"no {name}", kind, "E952", _drop(name)
            yield f"{name} of {np.dtype(other).name}", kind, "E953", _make(name, lambda a, t=other: a.astype(t))
            yield f"{name} with another axis", kind, "E953", _make(name, lambda a: a[..., None])
            swapped = array.dtype.newbyteorder(">")
            if array.dtype.itemsize > 1:
                yield f"{name} with its bytes swapped", kind, "E953", _make(name, lambda a, t=swapped: a.astype(t))
            if array.size and name != "weight":
                short = "E954" if is_bounds_of_table else "E953"
                if name.startswith("bounds_") or name == "mass":
                    short = "E953 E954"
                yield f"{name} too short", kind, short, _make(name, lambda a: np.ascontiguousarray(a[:-1]))
            if array.dtype.kind == "f" and array.size:
                where = (0,) * array.ndim
                if name != "sky_wavelength_nm":
                    yield f"{name} NaN", kind, "E954", _put(name, where, np.nan)
                    yield f"{name} infinite", kind, "E954", _put(name, where, np.inf)


def _wrong_values() -> Iterator[tuple[str, str, str, Change]]:
    def shuffle(a: np.ndarray) -> np.ndarray:
        a[0, 1:-1] = a[0, 1:-1][::-1]
        return a

    yield "cumulative falls", "table", "E954", _make("cumulative", shuffle)
    yield "cumulative from 1", "table", "E954", _put("cumulative", (0, 0), 1)
    yield "cumulative negative", "table", "E954", _make("cumulative", lambda a: -a)
    yield "-600000 photons", "table", "E954", _put("cumulative", (slice(None), -1), -600_000)
    yield "cumulative of 2^63 - 1", "table", "E954", _put("cumulative", (0, -1), 2**63 - 1)
    yield "requested negative", "table", "E954", _put("requested", 0, -1)
    yield "requested more than 2^62", "table", "E954", _put("requested", 0, 2**62 + 1)
    yield "a row that is not there", "table", "E954", _put("row_of_band", 0, 2)
    yield "a row of -1", "table", "E954", _put("row_of_band", 0, -1)
    yield "a negative mass", "table", "E954", _put("mass", (0, 0), -0.1)
    for value in (99, -1, 10, 127):
        yield f"law {value}", "table", "E954", _make("law", lambda a, v=value: np.full_like(a, v))
    yield "two laws in a component", "table", "E954", _put("law", 3, 1)
    yield "law 4 with cells of a table", "table", "E952 E954", _make("law", lambda a: np.full_like(a, 4))
    yield "law 4 without a grid", "table", "E954", _law_without_grid
    for value in (5, 6, 7, 8, 9):
        yield f"law {value} without its tables", "table", "E952", _make("law", lambda a, v=value: np.full_like(a, v))
    yield "cells of five columns", "table", "E953", _make("cell", lambda a: np.ascontiguousarray(a[:, :5]))
    yield "component starts at 1", "table", "E954", _put("component_start", 0, 1)
    yield "component ends too late", "table", "E954", _put("component_start", -1, 13)
    yield "components that fall", "disc", "E954", _put("component_start", 1, 13)
    yield "an empty component", "disc", "E954", _put("component_start", 1, 0)
    yield "keys of another seed", "table", "E954", _put("keys", 1, 7)
    yield "seed of other keys", "table", "E954", _option("seed", 10)
    yield "rings below the horizon", "table", "E954", _put("zenith_bounds_deg_0", (2, 1), 91.0)
    yield "a ring that ends before it begins", "table", "E954", _put("zenith_bounds_deg_0", (1, 1), 10.0)
    yield "weights nobody asked for", "solid angle", "E953", _option("weights", False)
    yield "weights of another shape", "solid angle", "E953", _make("weight", lambda a: a[:1].copy())
    yield "a grid for a disc", "disc", "E952", _add("zenith_bounds_deg_0", np.array([[0.0, 90.0]]))
    yield "tables for a table", "table", "E952", _add("shared_0", np.zeros(11))
    yield "a component that is not there", "table", "E952", _add("shared_7", np.zeros(11))
    yield "an array nobody knows", "table", "E952", _add("cell2", np.zeros(3))
    yield "an array with a name of a path", "table", "E951 E952", _add("../cell", np.zeros(3))
    yield "irradiance without its loss", "lobes", "E952", _drop("horizon_loss")


def _law_without_grid(arrays: dict[str, Any], _: dict[str, Any]) -> None:
    del arrays["zenith_bounds_deg_0"], arrays["azimuth_bounds_deg_0"]
    arrays["law"][:] = 4


def _two_perez_skies(arrays: dict[str, Any], options: dict[str, Any]) -> None:
    for name in ("zenith_bounds_deg", "azimuth_bounds_deg", "shared", "bounds"):
        arrays[f"{name}_1"] = arrays[f"{name}_0"].copy()
    for name in ("law", "cell"):
        arrays[name] = np.concatenate([arrays[name], arrays[name]])
    arrays["mass"] = np.hstack([arrays["mass"], 0 * arrays["mass"]])
    last = arrays["cumulative"][:, -1:]
    arrays["cumulative"] = np.hstack([arrays["cumulative"], np.repeat(last, 12, axis=1)])
    arrays["component_start"] = np.array([0, 12, 24])
    options |= {"components": ["perez", "again"], "azimuth_first_index": [0, 0]}


def _wrong_tables() -> Iterator[tuple[str, str, str, Change]]:
    yield "two Perez skies", "perez", "E952 E954", _two_perez_skies
    yield "shared of ten", "perez", "E953", _make("shared_0", lambda a: a[:10].copy())
    yield "bounds of three columns", "perez", "E953", _make("bounds_0", lambda a: a[:, :3].copy())
    yield "a disc off its rim", "horizon", "E954", _put("cell", (0, 0), 0.5)
    yield "a disc that no try hits", "horizon", "E954", _put("cell", (0, 2), 1e-30)
    yield "a disc of the whole sky", "horizon", "E954", _put("cell", (0, 2), 4.0)
    yield "shared of eleven", "lobes", "E953", _make("shared_1", lambda a: np.append(a, 0.0))
    yield "envelopes of seven columns", "lobes", "E953", _make("bounds_1", lambda a: a[:, :7].copy())
    yield "bins that are no power of two", "lobes", "E954", _put("bounds_1", (0, 3), 977.0)
    yield "half a bin", "lobes", "E954", _put("bounds_1", (0, 3), 0.5)
    yield "no bin", "lobes", "E954", _put("bounds_1", (0, 3), 0.0)
    yield "2^40 bins", "lobes", "E954", _put("bounds_1", (0, 3), 2.0**40)
    yield "an envelope of one cell", "lobes", "E954", _make("bounds_1", lambda a: a[:1].copy())
    yield "a lobe whose name has a comma", "lobes", "E955", _option("components", ["hg", "ggx,", "beckmann"])
    yield "tables of a method that was removed", "table", "E952", _add("sobol_keys", np.zeros(2, np.uint64))


def _wrong_options() -> Iterator[tuple[str, str, str, Change]]:
    for name in plan_of("table").options:
        yield f"no option {name}", "table", "E955", _no_option(name)
    for name, value in (
        ("stream", "aomc-sky/0"),
        ("stream", None),
        ("seed", "9"),
        ("seed", -1),
        ("seed", 2**64),
        ("seed", True),
        ("seed", 9.0),
        ("method", "best"),
        ("method", ["stratified"]),
        ("method", "iid"),
        ("method", "sobol"),
        ("allocation", "lottery"),
        ("allocation", "multinomial "),
        ("placement", "sobol"),
        ("placement", "anywhere"),
        ("order", 3),
        ("precision", "float16"),
        ("precision", "O"),
        ("weights", 1),
        ("replicates", 0),
        ("replicates", 2**40),
        ("replicates", "1"),
        ("footprint", ["hexagon", 1.0, 1.0]),
        ("footprint", ["circle", 1.0, 2.0]),
        ("footprint", ["circle", float("nan"), 1.0]),
        ("footprint", ["rectangle", 1e400, 1.0]),
        ("footprint", ["point"]),
        ("components", []),
        ("components", ["a", "b"]),
        ("components", [7]),
        ("components", "t"),
        ("components", ["a,b"]),
        ("components", ["\x1b[2J"]),
        ("components", ["two\nlines"]),
        ("components", ["\u202e"]),
        ("components", ["x" * 300]),
        ("azimuth_first_index", [0.5]),
        ("azimuth_first_index", []),
        ("azimuth_first_index", [2**70]),
    ):
        yield f"option {name} {str(value)[:24]!r}", "table", "E955", _option(name, value)
    yield "an option nobody knows", "table", "E955", _option("colour", "blue")
    yield "two names that are one", "disc", "E955", _option("components", ["a", "a"])
    yield "aomc with a lobe", "lobes", "E954 E955", _option("allocation", "aomc")
    yield "aomc with replicates", "replicates", "E955", _option("allocation", "aomc")


@functools.cache
def crafted_plans() -> tuple[CraftedPlan, ...]:
    """All changed plans; the names are different."""
    found = [*_of_every_array(), *_wrong_values(), *_wrong_tables(), *_wrong_options()]
    return tuple(CraftedPlan(name=n, kind=k, codes=tuple(c.split()), change=change) for n, k, c, change in found)


# files


def _rewritten(change: Callable[[dict[str, bytes]], dict[str, bytes]], **zip_options: Any) -> Callable[[Path], None]:
    """A plan whose members are changed as bytes of npy files."""

    def write(path: Path) -> None:
        with zipfile.ZipFile(io.BytesIO(plan_of("table").to_bytes())) as stored:
            members = {name: stored.read(name) for name in stored.namelist()}
        with zipfile.ZipFile(path, "w", **zip_options) as file:
            for name, data in change(members).items():
                file.writestr(name, data)

    return write


def _bytes(change: Callable[[bytes], bytes]) -> Callable[[Path], None]:
    return lambda path: _none(path.write_bytes(change(plan_of("table").to_bytes())))


def _none(_: object) -> None:
    return None


def _npy(head: str, data: bytes = b"", version: bytes = b"\x01\x00") -> bytes:
    text = head.encode().ljust(117) + b"\n"
    return b"\x93NUMPY" + version + struct.pack("<H", len(text)) + text + data


def _with(name: str, data: bytes) -> Callable[[Path], None]:
    return _rewritten(lambda members: {**members, name: data})


def _head(shape: object, descr: str = "'<f8'", order: bool = False) -> str:
    return f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"


def _double(path: Path) -> None:
    _rewritten(lambda members: members)(path)
    with zipfile.ZipFile(path, "a") as file, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of zipfile: a duplicate name
        file.writestr("law.npy", _npy(_head("(0,)")))


def _bomb(path: Path) -> None:
    zeros = bytes(1 << 20)
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file,
        file.open("mass.npy", "w", force_zip64=True) as member,
    ):
        member.write(_npy(_head("(4, 8388608)")))
        for _ in range(256):
            member.write(zeros)


def _overlaid(path: Path) -> None:
    """One member of a megabyte under two hundred names."""
    data = _npy(_head("(131072,)"), bytes(1 << 20))
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a000.npy", data)
        for k in range(1, 200):
            info = zipfile.ZipInfo(f"a{k:03d}.npy")
            info.file_size = info.compress_size = len(data)
            info.CRC, info.header_offset = file.infolist()[0].CRC, 0
            file.filelist.append(info)
            file.NameToInfo[info.filename] = info


def _encrypted(data: bytes) -> bytes:
    at = data.index(b"PK\x01\x02")
    return data[: at + 8] + b"\x01" + data[at + 9 :]


def _options_file(text: bytes) -> Callable[[Path], None]:
    return _with("options.npy", _npy(_head(f"({len(text)},)", "'|u1'"), text))


def _middle_byte(data: bytes) -> bytes:
    at = data.index(b"mass.npy") + 300
    return data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**34 + 2**20)


def _long_directory(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as file:
        for k in range(40):
            file.writestr(f"a{k}.npy", b"")
    data = path.read_bytes()
    end = data.rindex(b"PK\x05\x06")
    path.write_bytes(data[: end + 12] + struct.pack("<L", 2**31) + data[end + 16 :])


def _device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _names() -> Iterator[tuple[str, Callable[[Path], None]]]:
    for name in (
        "../law.npy",
        "/tmp/law.npy",
        "a/law.npy",
        "law",
        "law.npy.gz",
        "..npy",
        "law .npy",
        "l\u00e4w.npy",
        "x" * 99,
    ):
        yield f"a member {name[:12]!r}", _with(name, _npy(_head("(0,)")))


CRAFTED_FILES = tuple(
    CraftedFile(name=name, write=write)
    for name, write in (
        ("a pipe", os.mkfifo),
        ("a folder", Path.mkdir),
        ("a device", _device),
        ("a link to nowhere", lambda path: path.symlink_to(path.with_name("nowhere"))),
        ("empty", _bytes(lambda _: b"")),
        ("text", _bytes(lambda _: b"cumulative = 1\n" * 50)),
        ("a zip file without members", _bytes(lambda _: b"PK\x05\x06" + bytes(18))),
        ("cut in half", _bytes(lambda data: data[: len(data) // 2])),
        ("cut by a byte", _bytes(lambda data: data[:-1])),
        ("a bit of a mass", _bytes(_middle_byte)),
        ("encrypted", _bytes(_encrypted)),
        ("a pickle", _bytes(lambda _: b"\x80\x04\x95\x0e\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94.")),
        ("larger than any plan", _sparse),
        ("a directory that is too long", _long_directory),
        ("packed", _rewritten(lambda members: members, compression=zipfile.ZIP_DEFLATED)),
        ("packed once more", _rewritten(lambda members: members, compression=zipfile.ZIP_LZMA)),
        ("a bomb", _bomb),
        ("members over each other", _overlaid),
        ("a member twice", _double),
        ("no options", _rewritten(lambda members: {n: d for n, d in members.items() if n != "options.npy"})),
        ("options that are no JSON", _options_file(b"{")),
        ("options that are a list", _options_file(b"[]")),
        ("options in another code", _options_file(b"\xff\xfe{}")),
        ("options without a floor", _options_file(b"[" * 200_000)),
        ("options of floats", _with("options.npy", _npy(_head("(2,)"), bytes(16)))),
        ("no numpy array", _with("mass.npy", b"mass")),
        ("an array of nothing", _with("mass.npy", b"")),
        ("an array of version 3", _with("mass.npy", _npy(_head("(0,)"), version=b"\x03\x00"))),
        ("an array of objects", _with("mass.npy", _npy(_head("(1,)", "'|O'"), b"\x80\x04K\x01."))),
        ("an array of records", _with("mass.npy", _npy(_head("(0,)", "[('a', '<f8')]")))),
        ("an array of text", _with("mass.npy", _npy(_head("(1,)", "'<U2'"), bytes(8)))),
        ("an array in Fortran order", _with("mass.npy", _npy(_head("(0, 0)", order=True)))),
        ("an array of 10^15", _with("mass.npy", _npy(_head("(1000000000000000,)")))),
        ("an array of 2^70", _with("mass.npy", _npy(_head(f"({2**70},)")))),
        ("an array of -1", _with("mass.npy", _npy(_head("(-1,)")))),
        ("an array with code for its head", _with("mass.npy", _npy("__import__('os').abort()"))),
        ("an array with a long head", _with("mass.npy", _npy(_head("(" + "1, " * 3000 + ")")))),
        *_names(),
    )
)
"""Files that are no plan, each refused with E951 (a link to nowhere, a folder and a device among them)."""
