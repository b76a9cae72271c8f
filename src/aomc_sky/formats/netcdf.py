"""A netCDF file, classic or netCDF-4, as xarray has it, with limits."""

from __future__ import annotations

import contextlib
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aomc_sky.errors import AomcSkyError
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
_ENGINES = {b"CDF\x01": "scipy", b"CDF\x02": "scipy"}
_LIBRARY = "the netCDF library"


def lights_beside(path: str | Path) -> list[str]:
    """Variables of a file of this package that have light beside the radiances of its sky: a beam, or lobes."""
    with open_netcdf(path, decode_times=False) as (dataset, _):
        names = list(map(str, dataset.data_vars))
    shares = [name for name in names if name.startswith("mass_")]
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
