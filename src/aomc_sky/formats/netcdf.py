"""One variable of a netCDF file, classic or netCDF-4, with its coordinates."""

from __future__ import annotations

import contextlib
import math
import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from aomc_sky.errors import AomcSkyError, FieldError
from aomc_sky.extras import optional_module
from aomc_sky.formats.hdf5_storage import (
    RefusedError,
    allowed_bytes,
    declared_bytes,
    require_hard_link,
    require_own_data,
    require_plain_chunks,
    require_size,
)
from aomc_sky.formats.report import printable
from aomc_sky.formats.text_file import open_data, refuse

EXTRA = "netcdf"
"""The extra that installs xarray and h5netcdf."""

MAX_FILE_BYTES = 1 << 30
MAX_NAMES = 40
_ENGINES = {b"CDF\x01": "scipy", b"CDF\x02": "scipy"}
_NOT_OF_SKY = re.compile(
    r"upwelling|upward|outgoing|reflected|\bleaving\b|\btop of (?:the )?atmosphere\b|\btoa\b|stokes [quv]\b"
    r"|\b(?:below|beneath|under) (?:the )?(?:sea |water )?surface\b|\b(?:sub ?surface|under ?water)\b"
)
_NAMED_OTHERWISE = re.compile(
    r"\b(?:l ?[uw]|up|(?<!over )water|direct|dir|nlw|rrs|err|errors?|uncertaint\w+|unc|std|stdev|standard deviation"
    r"|variance|quality|flags?|masks?|brd?f|reflectances?|transmittances?|albedo|[da]olp|polari[sz]ation|aod|temperature"
    r"|irradiance|phase function|solid angle)\b"
)
"""Words of variables that are not the radiance of the sky: in all that names them, or in the name itself."""
_FLAGS = re.compile(r"\b(?:quality|flags?|masks?|qc)\b")
"""Words of variables that say which radiances are good."""
_LIBRARY = "the netCDF library"


def read_field(
    path: str | Path,
    *,
    variable: str | None = None,
    isel: Mapping[str, int] | None = None,
    stokes: Callable[[Any], tuple[Any, list[str]] | None] = lambda _: None,
) -> Any:
    """Read a field of a netCDF file as a dataset in memory, with its coordinates of numbers and their bounds.

    The field is one variable, by default the only one, or the only one that is called a radiance. It is three where
    `stokes` finds I, Q and U: it returns a dataset and their names, or None. `isel` chooses one index of dimensions
    that are neither angles nor wavelengths. Missing values become NaN, packed ones are unpacked, as the CF conventions
    have it. No other file is opened, whatever the file says. InputFileError (E551 to E553); FieldError;
    MissingExtraError without xarray and h5netcdf.
    """
    with open_netcdf(path, decode_times=False) as (dataset, allowed):
        isel = dict(isel or {})
        done = {dim: k for dim, k in isel.items() if 0 <= k < dataset.sizes.get(dim, 0)}
        whole, more = stokes(dataset.isel(done)) or (dataset, [])
        field, bounds = chosen_field(whole, more[0] if more else variable)
        field = _at_indices(field, isel if whole is dataset else {d: k for d, k in isel.items() if d not in done})
        others = {name: whole[name].variable for name in more[1:]}
        parts = (field, *field.coords.values(), *bounds.values(), *others.values())
        require_size(sum(math.prod(part.shape) * 8 for part in parts), allowed, allowed, "a field")
        read = field.to_dataset(name=field.name or "radiance").assign(others).assign_coords(bounds)
        return read.assign_attrs(dataset.attrs).load()


def lights_beside(path: str | Path) -> list[str]:
    """Variables of a file of this package that have light beside the radiances of its sky: a beam, or lobes."""
    with open_netcdf(path, decode_times=False) as (dataset, _):
        names = {str(name): variable.dims for name, variable in dataset.data_vars.items()}
    shares = [name for name, dims in names.items() if name.startswith("mass_") and dims == ("waveband",)]
    return shares + ["direct_irradiance"] * ("direct_irradiance" in names)


@contextlib.contextmanager
def open_netcdf(path: str | Path, **options: Any) -> Iterator[tuple[Any, int]]:
    """Open a netCDF file as an xarray.Dataset; with it come the bytes that arrays of such a file may declare.

    `options` are those of xarray.open_dataset. No other file is opened. A failure of the library inside the block is an
    InputFileError, as are those of the file (E551 to E553); MissingExtraError without xarray and h5netcdf.
    """
    xarray, h5py = (optional_module(name, extra=EXTRA) for name in ("xarray", "h5py"))
    optional_module("h5netcdf", extra=EXTRA)
    with open_data(path, what="a netCDF file", code="E551") as file:
        size = os.fstat(file.fileno()).st_size
        if size > MAX_FILE_BYTES:
            raise refuse(path, f"the file has {size} bytes; at most {MAX_FILE_BYTES} are read", code="E553")
        if size < 8:
            raise refuse(path, "not a netCDF file: it is too short for one", code="E552")
        try:
            start = file.read(16)
            engine = _ENGINES.get(start[:4], "h5netcdf")
            if start[:4] not in (*_ENGINES, b"\x89HDF"):
                message = (
                    r"not a netCDF file: its first bytes are none of CDF\x01, CDF\x02 (netCDF-3) and \x89HDF (netCDF-4)"
                )
                raise refuse(path, message, advice="write the field as netCDF-4", code="E552")
            if engine == "h5netcdf":
                _look_at_storage(h5py, path, allowed_bytes(size))
            file.seek(0)
            # by its path: where a damaged file has no bytes, h5py asks a Python file object for them without end
            data = file if engine == "scipy" else os.path.abspath(path)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of attributes that a library does not know
                with xarray.open_dataset(data, engine=engine, **options) as dataset:
                    for part in (dataset, *dataset.variables.values()):
                        part.attrs = {name: _text_of(value) for name, value in part.attrs.items()}
                    yield dataset, allowed_bytes(size)
        except AomcSkyError:
            raise
        except RefusedError as refusal:
            raise refuse(path, printable(refusal.message), advice=refusal.advice, code="E553") from None
        except Exception as error:  # the libraries raise their own errors and Python's, whatever the damage is
            reason = printable(str(error) or type(error).__name__)
            advice = "make the file again"
            raise refuse(path, f"{_LIBRARY} cannot read it: {reason}", advice=advice, code="E552") from error


def _text_of(value: Any) -> Any:
    """A text of an attribute without the NUL of C at its end; bytes that are no UTF-8 are Latin-1."""
    value = value.decode("latin-1") if isinstance(value, bytes) else value
    return value.rstrip("\0") if isinstance(value, str) else value


def _look_at_storage(h5py: Any, path: str | Path, allowed: int) -> None:
    """Refuse what lies in other files, and arrays larger than the file can hold: xarray reads axes when it opens it."""
    with h5py.File(path, "r", locking=False) as root:
        for name in root:
            try:
                require_hard_link(root, name)
                item = root[name]
                if isinstance(item, h5py.Dataset):
                    require_own_data(item)
                    if item.ndim == 1:
                        require_size(declared_bytes(item), allowed, allowed, "an axis")
                    require_plain_chunks(item, allowed)
            except RefusedError as refusal:
                if refusal.code == "E503":
                    raise
                message = f"the data of {name!r} are in another file or place"
                raise RefusedError(refusal.code, message, "write the data into the file") from None


def chosen_field(dataset: Any, variable: str | None) -> tuple[Any, dict[str, Any]]:
    """A variable of a dataset with its coordinates of numbers, and the bounds that these name.

    Variables over a part of its dimensions are coordinates, too: some programs do not mark them as such.
    """
    field = dataset[_name_of_field(dataset, variable)]
    beside = {
        name: one
        for name, one in dataset.data_vars.items()
        if name != field.name and one.ndim and one.dtype.kind in "biuf" and {*one.dims} < {*field.dims}
    }
    flags = [
        str(name)
        for name, one in dataset.data_vars.items()
        if name != field.name and {*one.dims} & {*field.dims} and _is_flag(str(name), one.attrs)
    ]
    if flags:
        field = field.assign_attrs({"ancillary_variables": " ".join(flags), **field.attrs})
    texts = [name for name, axis in field.coords.items() if axis.dtype.kind not in "biuf"]
    field = field.drop_vars(texts).assign_coords(beside)
    named = {bounds_name(axis) for axis in field.coords.values()}
    return field, {name: dataset[name].reset_coords(drop=True) for name in named if name in dataset.variables}


def bounds_name(coordinate: Any) -> str:
    """Name of the CF bounds of a coordinate, or an empty text; xarray has it among attributes or the encoding."""
    return str({**getattr(coordinate, "encoding", {}), **coordinate.attrs}.get("bounds", ""))


def _is_of_sky(name: str, attributes: Mapping[str, Any]) -> bool:
    """Whether a variable may be light of the sky: not from below, no uncertainty, no further Stokes parameter."""
    names = f"{name} {attributes.get('standard_name', '')}"
    short, text = (re.sub(r"[\W_]+", " ", one.lower()) for one in (names, f"{names} {attributes.get('long_name', '')}"))
    return _NOT_OF_SKY.search(text) is None and _NAMED_OTHERWISE.search(short) is None


def _is_flag(name: str, attributes: Mapping[str, Any]) -> bool:
    """Whether a variable says which radiances are good."""
    return "flag_meanings" in attributes or _FLAGS.search(re.sub(r"[\W_]+", " ", name.lower())) is not None


def _name_of_field(dataset: Any, variable: str | None) -> str:
    """The variable that is named, the only one, or the only one that says that it is a radiance."""
    edges = {bounds_name(one) for one in dataset.variables.values()}
    edges |= {word for one in dataset.variables.values() for word in str(one.attrs.get("cell_measures", "")).split()}
    numbers = {
        str(name): one
        for name, one in dataset.data_vars.items()
        if one.dtype.kind in "biufc" and one.ndim and name not in edges
    }
    most = max((one.ndim for one in numbers.values()), default=0)
    says = [name for name, one in numbers.items() if _is_radiance(name, one.attrs)]
    names = [name for name, one in numbers.items() if one.ndim == most or name in (variable, *says)]
    shown = ", ".join(map(repr, names[:MAX_NAMES])) or "none at all"
    if variable is not None and variable not in names:
        message = f"the file has no variable {variable!r} of numbers; it has {shown}"
        raise FieldError(printable(message), argument="variable")
    best = [variable] if variable is not None else says if len(says) == 1 else names
    if not best:
        advice = "write a group into a file of its own: xarray.open_dataset(path, group='NAME').to_netcdf('field.nc')"
        raise FieldError("the file has no variables of numbers outside of groups", advice)
    if len(best) == 1 and variable is None and not _is_of_sky(best[0], numbers[best[0]].attrs):
        message = f"the variable {best[0]!r} is not the light of the sky by its name"
        raise FieldError(printable(message), f"if it is, write --variable {best[0]} (variable=)")
    if len(best) > 1:
        message = f"the file has {len(names)} variables of numbers: {shown}"
        raise FieldError(printable(message), f"choose one: --variable {best[0]} (variable=)")
    return best[0]


def _is_radiance(name: str, attributes: Mapping[str, Any]) -> bool:
    standard = str(attributes.get("standard_name", "")).replace("irradiance", "")
    return name.lower() in ("radiance", "sky_radiance") or "radiance" in standard


def _at_indices(field: Any, isel: Mapping[str, int]) -> Any:
    for dim, index in isel.items():
        if dim not in field.dims:
            shown = ", ".join(repr(str(one)) for one in field.dims)
            message = f"the field has no dimension {dim!r}; it has {shown}"
            raise FieldError(printable(message), argument="isel")
        if not 0 <= index < field.sizes[dim]:
            message = f"dimension {dim!r} has indices 0 to {field.sizes[dim] - 1}, not {index}"
            raise FieldError(printable(message), argument="isel")
    return field.isel(isel)
