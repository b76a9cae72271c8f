"""Plans that nobody would write but an attacker: small real ones of every kind, and one table of damage to them."""

import functools
import io
import itertools
import json
import os
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.plan import npz_bytes, sha256_of
from tests.support.host_scenes import disc, perez
from tests.support.lobes import lobe_sky

N = 997
WAVEBANDS = [450.0, 550.0]


def _table(law=Law.CELL_MU2, **more):
    grid = sky.PatchGrid.regular(3, 4)
    mass = np.random.default_rng(3).lognormal(0, 1, (2, 12))
    mass[:, 5] = 0.0
    cell = cells_of_grid(grid, law)
    return Component(name="table", law=law, strength=np.ones(2), mass=mass, cell=cell, grid=grid, **more)


def _vectors(seed, most):
    return np.random.default_rng(seed).uniform(-most, most, (2, 12, 2))


def _lobes():
    turn = [np.cos(0.3), np.sin(0.3), 0.0, 0.0]
    shapes = ("hg", 0.8, 0.0, turn), ("ggx", 0.3, 0.5, turn), ("beckmann", 0.2, 0.6, turn)
    return lobe_sky(*shapes, wavelength_nm=[500.0, 501.0], spectra=1.0).lower([500.0, 501.0])


_SCENES = {
    "table": (lambda: (_table(),), {}),
    "solid angle": (
        lambda: (_table(Law.CELL_MU, weight=np.full((2, 12), 0.5)),),
        {"weights": True, "precision": "float64"},
    ),
    "perez": (lambda: perez(3, 4), {}),
    "lobes": (_lobes, {}),
    "sloped": (lambda: (_table(Law.CELL_SLOPED, slope=_vectors(4, 0.9)),), {}),
    "polarised": (lambda: (_table(stokes=_vectors(5, 0.7)),), {}),
    "disc": (lambda: (*disc(20, 0.27), _table()), {}),
    "horizon": (lambda: (*disc(89.9, 0.27), _table()), {"order": "patch"}),
    "beam": (lambda: (*disc(35, 0.0), _table()), {"method": "iid"}),
    "lobes in float64": (_lobes, {"precision": "float64"}),
    "replicates": (lambda: (_table(),), {"replicates": 5}),
    "centre": (lambda: (_table(),), {"placement": "centre"}),
}
KINDS = tuple(_SCENES)


@functools.cache
def plan_of(kind):
    components, options = _SCENES[kind]
    place = sky.Footprint.circle(2.0) if kind == "table" else sky.Footprint()
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=N, components=components(), footprint=place)
    return scene.source(9, **options).plan


class Damage(NamedTuple):
    """One row of the table: what is done to a member or to an option of a plan, and the codes that may answer."""

    kind: str
    member: str
    codes: str
    what: str
    make: Callable[[Any], Any]  #: of the array or the value; `DROP` takes it out

    @property
    def name(self):
        return f"{self.kind}: {self.member} {self.what}"

    def members(self):
        """Members and options of the damaged plan; the arrays are copies."""
        plan = plan_of(self.kind)
        members = {name: array.copy() for name, array in plan.members().items()}
        options = json.loads(json.dumps(plan.options))
        place, name = (options, self.member[8:]) if self.member.startswith("options.") else (members, self.member)
        value = self.make(place.get(name))
        if value is DROP:
            del place[name]
        else:
            place[name] = value
        return members, options

    def file(self):
        """The damaged plan as a file that fits its hash."""
        members = self.members()
        return npz_bytes(*members, sha256_of(*members))


DROP = object()


def _put(index, value):
    def change(array):
        array[index] = value
        return array

    return change


def _to(value):
    return lambda _: value


def _array_damages():
    """Every array of every kind once: missing, of another type, too short, with an axis more, out of range."""
    seen = set()
    for kind in KINDS:
        for name, array in plan_of(kind).members().items():
            if name in seen:
                continue
            seen.add(name)
            other = np.float32 if array.dtype.kind == "f" else np.int32 if array.dtype != np.int8 else np.int16
            if not name.startswith("stokes"):  # without it a plan has no polarisation
                yield Damage(kind, name, "E952", "missing", _to(DROP))
            yield Damage(kind, name, "E953", f"of {np.dtype(other).name}", lambda a, t=other: a.astype(t))
            yield Damage(kind, name, "E953", "with another axis", lambda a: a[..., None])
            if array.dtype.itemsize > 1:
                swapped = array.dtype.newbyteorder(">")
                yield Damage(kind, name, "E953", "in swapped bytes", lambda a, t=swapped: a.astype(t))
            if array.size and not name.startswith(("weight", "slope", "stokes")):
                is_of_patches = name.endswith(("bounds_deg_0", "bounds_deg_1"))
                codes = "E954" if is_of_patches else "E953 E954" if name.startswith(("bounds_", "mass")) else "E953"
                yield Damage(kind, name, codes, "too short", lambda a: np.ascontiguousarray(a[:-1]))
            if array.dtype.kind == "f" and array.size and name != "sky_wavelength_nm":
                for value in (np.nan, np.inf):
                    yield Damage(kind, name, "E954", str(value), _put((0,) * array.ndim, value))


def _reversed_inside(array):
    array[0, 1:-1] = array[0, 1:-1][::-1]
    return array


def _cut_disc(zenith_deg, radius_deg):
    """Rim, width, chord and centre of a disc that the horizon cuts, as they follow from each other."""
    zenith, radius = np.deg2rad([zenith_deg, radius_deg])
    half_width = np.arcsin(np.sin(radius) / np.sin(zenith)) / (np.pi / 2)
    return np.cos(zenith - radius) ** 2, half_width, 4 * np.sin(radius / 2) ** 2, np.cos(zenith)


_NO_LAW = next(number for number in itertools.count() if number not in set(Law))
_WITH_TABLES = [int(law) for law in Law if law_of(law).tables or law_of(law).has_slopes]

_VALUES = tuple(
    Damage(*row)
    for row in (
        ("table", "cumulative", "E954", "falls", _reversed_inside),
        ("table", "cumulative", "E954", "from 1", _put((0, 0), 1)),
        ("table", "cumulative", "E954", "negative", lambda a: -a),
        ("table", "cumulative", "E954", "2^63 - 1", _put((0, -1), 2**63 - 1)),
        ("table", "requested", "E954", "negative", _put(0, -1)),
        ("table", "requested", "E954", "above 2^62", _put(0, 2**62 + 1)),
        ("table", "row_of_band", "E954", "that is not there", _put(0, 2)),
        ("table", "mass", "E954", "negative", _put((0, 0), -0.1)),
        ("table", "mass", "E954", "above 1", _put((0, 0), 1.1)),
        *(("table", "law", "E954", str(law), lambda a, v=law: np.full_like(a, v)) for law in (_NO_LAW, -1)),
        ("table", "law", "E954", "two in a component", _put(3, 1)),
        *(("table", "law", "E952", f"{v} without tables", _put(slice(None), v)) for v in _WITH_TABLES),
        ("perez", "law", "E952 E954", "4 without a grid", _put(slice(None), 4)),
        ("table", "cell", "E953", "of five columns", lambda a: np.ascontiguousarray(a[:, :5])),
        ("table", "component_start", "E954", "from 1", _put(0, 1)),
        ("table", "component_start", "E954", "too late", _put(-1, 13)),
        ("disc", "component_start", "E954", "falls", _put(1, 13)),
        ("table", "keys", "E954", "of another seed", _put(1, 7)),
        ("table", "options.seed", "E954", "of other keys", _to(10)),
        ("table", "zenith_bounds_deg_0", "E954", "below the horizon", _put((2, 1), 91.0)),
        ("solid angle", "options.weights", "E953", "not asked for", _to(False)),
        ("solid angle", "weight", "E953", "of another shape", lambda a: a[:1].copy()),
        ("table", "shared_0", "E952", "of a table", _to(np.zeros(11))),
        ("table", "cell2", "E952", "is not known", _to(np.zeros(3))),
        ("table", "../cell", "E951 E952", "is a path", _to(np.zeros(3))),
        ("lobes", "horizon_loss", "E952", "without irradiance", _to(DROP)),
        ("perez", "shared_0", "E953", "of ten", lambda a: a[:10].copy()),
        ("horizon", "cell", "E954", "off its rim", _put((0, 0), 0.5)),
        ("horizon", "cell", "E954", "that no try hits", _put((0, 2), 1e-30)),
        ("horizon", "cell", "E954", "of the whole sky", _put((0, 2), 4.0)),
        ("horizon", "cell", "E954", "of a radius of 11 degrees", _put((0, slice(4)), _cut_disc(89.9, 11.0))),
        ("horizon", "cell", "E954", "with a centre below the horizon", _put((0, slice(4)), _cut_disc(90.1, 0.27))),
        *(("lobes", "bounds_1", "E954", f"{bins} bins", _put((0, 3), bins)) for bins in (977.0, 0.0, 2.0**40)),
        ("lobes", "bounds_1", "E954", "of one cell", lambda a: a[:1].copy()),
        ("sloped", "slope_0", "E954", "of -3", _put((0, 0, 1), -3.0)),
        ("sloped", "slope_0", "E952", "missing in law 9", _to(DROP)),
        ("polarised", "stokes_0", "E954", "of 1.1", _put((0, 0, 0), 1.1)),
        ("polarised", "stokes_0", "E954", "with a degree above 1", _put((0, 0), 0.8)),
        ("polarised", "stokes_0", "E953", "of 11 cells", lambda a: a[:, :11].copy()),
        ("polarised", "stokes_0", "E953", "of 3 rows", lambda a: np.concatenate([a, a[:1]])),
    )
)

_OPTIONS = {
    "stream": ("aomc-sky/0", None),
    "seed": (-1, 2**64, True, 9.0),
    "method": (["stratified"], "iid"),
    "allocation": ("multinomial ",),
    "placement": ("anywhere",),
    "order": (3,),
    "precision": ("float16",),
    "weights": (1,),
    "replicates": (0, 2**40),
    "footprint": (["hexagon", 1.0, 1.0], ["circle", 1.0, 2.0], ["circle", float("nan"), 1.0], ["point"]),
    "components": ([], ["a", "b"], [7], "t", ["a,b"], ["\x1b[2J"], ["\u202e"], ["x" * 300]),
    "azimuth_first_index": ([0.5], [], [2**70], [2**31 + 1], [-(2**31) - 1]),
    "colour": ("blue",),
}
"""Values of options that no plan has."""


def _option_damages():
    for name in plan_of("table").options:
        yield Damage("table", f"options.{name}", "E955", "missing", _to(DROP))
    for name, values in _OPTIONS.items():
        for value in values:
            yield Damage("table", f"options.{name}", "E955", repr(value)[:24], _to(value))
    yield Damage("disc", "options.components", "E955", "one name twice", _to(["a", "a"]))
    yield Damage("lobes", "options.components", "E955", "with a comma", _to(["hg", "ggx,", "beckmann"]))
    yield Damage("lobes", "options.allocation", "E955", "aomc with lobes", _to("aomc"))
    yield Damage("replicates", "options.allocation", "E955", "aomc with replicates", _to("aomc"))


@functools.cache
def damages():
    return (*_array_damages(), *_VALUES, *_option_damages())


# files


def _rewritten(change, **zip_options):
    """A plan whose members are changed as bytes of npy files."""

    def write(path):
        with zipfile.ZipFile(io.BytesIO(plan_of("table").to_bytes())) as stored:
            members = {name: stored.read(name) for name in stored.namelist()}
        with zipfile.ZipFile(path, "w", **zip_options) as file:
            for name, data in change(members).items():
                file.writestr(name, data)

    return write


def _bytes(change):
    return lambda path: path.write_bytes(change(plan_of("table").to_bytes()))


def _npy(head, data=b"", version=b"\x01\x00"):
    text = head.encode().ljust(117) + b"\n"
    return b"\x93NUMPY" + version + struct.pack("<H", len(text)) + text + data


def _with(name, data):
    return _rewritten(lambda members: {**members, name: data})


def _head(shape, descr="'<f8'", order=False):
    return f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"


def _bomb(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        file.writestr("mass.npy", _npy(_head("(4, 8388608)")) + bytes(1 << 28))


def _overlaid(path):
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


def _options_file(text):
    return _with("options.npy", _npy(_head(f"({len(text)},)", "'|u1'"), text))


def _sparse(path):
    with path.open("wb") as file:
        file.truncate(2**34 + 2**20)


def _names():
    odd = "../law.npy", "/etc/law.npy", "law", "..npy", "läw.npy", "x" * 99
    for name in odd:
        yield f"a member {name[:12]!r}", _with(name, _npy(_head("(0,)")))


DAMAGED_FILES = dict(
    (
        ("a pipe", os.mkfifo),
        ("a folder", Path.mkdir),
        ("a device", lambda path: path.symlink_to("/dev/zero")),
        ("a link to nowhere", lambda path: path.symlink_to(path.with_name("nowhere"))),
        ("empty", _bytes(lambda _: b"")),
        ("text", _bytes(lambda _: b"cumulative = 1\n" * 50)),
        ("cut in half", _bytes(lambda data: data[: len(data) // 2])),
        ("a pickle", _bytes(lambda _: b"\x80\x04\x95\x0e\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94.")),
        ("larger than any plan", _sparse),
        ("packed", _rewritten(lambda members: members, compression=zipfile.ZIP_DEFLATED)),
        ("a bomb", _bomb),
        ("members over each other", _overlaid),
        ("no options", _rewritten(lambda members: {n: d for n, d in members.items() if n != "options.npy"})),
        ("options that are no JSON", _options_file(b"{")),
        ("options that are a list", _options_file(b"[]")),
        ("options in another code", _options_file(b"\xff\xfe{}")),
        ("options without a floor", _options_file(b"[" * 200_000)),
        ("no numpy array", _with("mass.npy", b"mass")),
        ("an array of version 3", _with("mass.npy", _npy(_head("(0,)"), version=b"\x03\x00"))),
        ("an array of objects", _with("mass.npy", _npy(_head("(1,)", "'|O'"), b"\x80\x04K\x01."))),
        ("an array of records", _with("mass.npy", _npy(_head("(0,)", "[('a', '<f8')]")))),
        ("an array in Fortran order", _with("mass.npy", _npy(_head("(0, 0)", order=True)))),
        ("an array of 10^15", _with("mass.npy", _npy(_head("(1000000000000000,)")))),
        ("an array of -1", _with("mass.npy", _npy(_head("(-1,)")))),
        ("an array with code for its head", _with("mass.npy", _npy("__import__('os').abort()"))),
        ("an array with a long head", _with("mass.npy", _npy(_head("(" + "1, " * 3000 + ")")))),
        *_names(),
    )
)
"""Files that are no plan, each refused with E951 (a link to nowhere, a folder and a device among them)."""
