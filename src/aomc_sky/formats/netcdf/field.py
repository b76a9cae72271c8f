"""One variable of a netCDF file with its coordinates, read by a process of its own."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from aomc_sky.extras import optional_module
from aomc_sky.formats.child_process import answer_of_child, opened, parsed_answer, printable
from aomc_sky.formats.text_file import refuse

EXTRA = "netcdf"
MAX_FILE_BYTES = 1 << 30
_CHILD = "aomc_sky.formats.netcdf.child"
_LIBRARY = "the netCDF library"


class FieldRefusedError(Exception):
    """A variable or an index that the file does not have: message, advice and the name of the argument it is of."""

    def __init__(self, message: str, advice: str, argument: str) -> None:
        self.advice, self.argument = advice, argument
        super().__init__(message)


@dataclass(frozen=True, kw_only=True, slots=True)
class FieldCoordinate:
    """A coordinate of numbers."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: dict[str, str]


@dataclass(frozen=True, kw_only=True, slots=True)
class GriddedField:
    """A variable as `aomc_sky.TabulatedSky.from_xarray` takes it: the members of an xarray.DataArray that it reads."""

    name: str
    dims: tuple[str, ...]
    values: np.ndarray
    coords: Mapping[str, FieldCoordinate] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the values."""
        return self.values.shape


def read_field(path: str | Path, *, variable: str | None = None, isel: Mapping[str, int] | None = None) -> GriddedField:
    """Read a variable of a netCDF file, by default the only one, or the only one that is called a radiance.

    `isel` chooses one index of dimensions that are neither angles nor wavelengths. Missing values become NaN, packed
    ones are unpacked, as the CF conventions have it. No other file is opened, whatever the file says. InputFileError
    (E551 to E553); `FieldRefusedError`; MissingExtraError without xarray and h5netcdf.
    """
    for name in ("xarray", "h5netcdf", "h5py"):
        optional_module(name, extra=EXTRA)
    with opened(path, what="a netCDF file", code="E551") as file:
        size = os.fstat(file.fileno()).st_size
        if size > MAX_FILE_BYTES:
            raise refuse(path, f"the file has {size} bytes; at most {MAX_FILE_BYTES} are read", code="E553")
        if size < 8:
            raise refuse(path, "not a netCDF file: it is too short for one", code="E552")
        cpu_s = 5.0 + size / 2e6
        task = [variable, dict(isel or {}), cpu_s]
        answer = answer_of_child(path, file, _CHILD, task, cpu_s=cpu_s, library=_LIBRARY, code="E552")
    try:
        head, arrays = parsed_answer(answer)
        if head["fault"] is None:
            axes = {
                name: FieldCoordinate(dims=tuple(dims), values=arrays[name], attrs=attrs)
                for name, (dims, attrs) in head["coordinates"].items()
            }
            return GriddedField(name=head["name"], dims=tuple(head["dims"]), values=arrays[""], coords=axes)
        code, message, advice, argument = head["fault"]
    except (ValueError, TypeError, KeyError, EOFError) as error:  # the child died in the middle of its answer
        raise refuse(path, f"{_LIBRARY} cannot read it: the file is damaged", code="E552") from error
    if argument:
        raise FieldRefusedError(printable(message), advice, argument)
    raise refuse(path, printable(message), advice=advice, code=code)
