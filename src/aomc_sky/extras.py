"""Packages that only some features need: imported on first use, and named in the error when they are absent."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from aomc_sky.errors import MissingExtraError
from aomc_sky.float_mode import in_default_mode


@in_default_mode  # the import of h5py ends the process where numbers are rounded up
def optional_module(name: str, *, extra: str) -> ModuleType:
    """Import a module of an optional dependency; `extra` is the extra of this package that installs it."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        # the missing module may also be a dependency of this one
        raise MissingExtraError(
            f"this needs the package {error.name or name}, which is not installed: type "
            f'pip install ".[{extra}]" in the source folder of aomc-sky, which is in no package index yet'
        ) from error
