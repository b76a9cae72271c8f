"""The process that opens a netCDF file for us: xarray reads it, under limits of memory, time and open files.

It takes the file as standard input and opens no file by name. `field` starts it and judges what comes back.
"""

from __future__ import annotations

import io
import math
import sys
import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from aomc_sky.formats.child_process import write_answer
from aomc_sky.system import limit_process

SPARE_BYTES = 384 << 20
"""Memory beyond a multiple of the size of the file. [bytes]"""
UNPACKED_BYTES = 64 << 20
"""What a field may hold beyond a multiple of the size of the file. [bytes]"""
MAX_NAMES = 40
_ENGINES = {b"\x89HDF": "h5netcdf", b"CDF\x01": "scipy", b"CDF\x02": "scipy"}


class RefusedError(Exception):
    """What is wrong with the file: code, what was found, what to write, and the option of the reader that it is of."""


def main(variable: str | None, isel: Mapping[str, int], cpu_s: float) -> None:
    """Read standard input, write the answer, and end."""
    xarray = import_module("xarray")  # an extra
    data = sys.stdin.buffer.read()
    engine = _ENGINES.get(data[:4], "h5netcdf")
    _import_late_parts(xarray, engine)
    limit_process(16 * len(data) + SPARE_BYTES, cpu_s)
    try:
        if engine == "h5netcdf":
            _refuse_other_files(io.BytesIO(data))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of attributes that a library does not know
            with xarray.open_dataset(
                io.BytesIO(data), engine=engine, decode_times=False, decode_coords="all"
            ) as dataset:
                field = _chosen(dataset, variable)
                field = _at_indices(_with_coordinates(field, dataset), isel)
                _refuse_large(field, len(data))
                field = field.load()
    except RefusedError as refusal:
        write_answer({"fault": list(refusal.args)}, {})
        return
    coordinates = {str(name): axis for name, axis in field.coords.items() if axis.dtype.kind in "biuf"}
    head = {
        "fault": None,
        "name": str(field.name),
        "dims": list(map(str, field.dims)),
        "coordinates": {name: [list(map(str, axis.dims)), _texts(axis.attrs)] for name, axis in coordinates.items()},
    }
    write_answer(head, {"": field.values, **{name: axis.values for name, axis in coordinates.items()}})


def _import_late_parts(xarray: Any, engine: str) -> None:
    """Let the libraries import what they import when they are first used: under the limit they may open no file."""
    small = xarray.Dataset({"a": ("b", [1.0], {"scale_factor": 2.0})}, {"b": [1.0]}).to_netcdf(engine=engine)
    xarray.open_dataset(io.BytesIO(bytes(small)), engine=engine, decode_times=False, decode_coords="all").load()


def _refuse_other_files(stream: io.BytesIO) -> None:
    h5py = import_module("h5py")
    with h5py.File(stream, "r") as file:
        for name in file:
            is_here = isinstance(file.get(name, getlink=True), h5py.HardLink)
            item = file[name] if is_here else None
            if not is_here or (isinstance(item, h5py.Dataset) and (item.is_virtual or item.external)):
                raise RefusedError(
                    "E553", f"the data of {name!r} are in another file or place", "write the data into the file", ""
                )


def _chosen(dataset: Any, variable: str | None) -> Any:
    """The variable that is named, the only one, or the only one that says that it is a radiance."""
    numbers = {str(name): one for name, one in dataset.data_vars.items() if one.dtype.kind in "biufc" and one.ndim}
    most = max((one.ndim for one in numbers.values()), default=0)
    names = [name for name, one in numbers.items() if one.ndim == most or name == variable]
    shown = ", ".join(map(repr, names[:MAX_NAMES])) or "none at all"
    if variable is not None:
        if variable not in names:
            message = f"the file has no variable {variable!r} of numbers; it has {shown}"
            raise RefusedError("E710", message, "", "variable")
        return dataset[variable]
    says = [name for name in names if _is_radiance(name, dataset[name].attrs)]
    best = says if len(says) == 1 else names
    if len(best) != 1:
        raise RefusedError(
            "E710", f"the file has {len(names)} variables of numbers: {shown}", 'add variable = "NAME"', "table"
        )
    return dataset[best[0]]


def _with_coordinates(field: Any, dataset: Any) -> Any:
    """The field with the variables over a part of its dimensions, which some programs do not mark as coordinates."""
    beside = {
        name: one
        for name, one in dataset.data_vars.items()
        if name != field.name and one.ndim and one.dtype.kind in "biuf" and {*one.dims} < {*field.dims}
    }
    return field.assign_coords(beside)


def _is_radiance(name: str, attributes: Mapping[str, Any]) -> bool:
    return name.lower() in ("radiance", "sky_radiance") or "radiance" in str(attributes.get("standard_name", ""))


def _at_indices(field: Any, isel: Mapping[str, int]) -> Any:
    for dim, index in isel.items():
        if dim not in field.dims:
            shown = ", ".join(repr(str(one)) for one in field.dims)
            raise RefusedError("E710", f"the field has no dimension {dim!r}; it has {shown}", "", "isel")
        if not 0 <= index < field.sizes[dim]:
            message = f"dimension {dim!r} has indices 0 to {field.sizes[dim] - 1}, not {index}"
            raise RefusedError("E710", message, "", "isel")
    return field.isel(dict(isel))


def _refuse_large(field: Any, n_bytes_of_file: int) -> None:
    sizes = [math.prod(part.shape) * 8 for part in (field, *field.coords.values())]
    allowed = 4 * n_bytes_of_file + UNPACKED_BYTES
    if sum(sizes) > allowed:
        raise RefusedError(
            "E553",
            f"a field of {sum(sizes)} bytes is declared; of a file of this size {allowed} bytes in all are read",
            "write the file with less compression, or only the wavelengths that the scene needs",
            "",
        )


def _texts(attributes: Mapping[str, Any]) -> dict[str, str]:
    return {str(name): str(value)[:200] for name, value in attributes.items()}
