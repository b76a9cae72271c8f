"""Functions for a C or Fortran program that starts Python: a scene, then its bands."""

from __future__ import annotations

import difflib
import os
import sys
import warnings
from typing import Any

from aomc_sky.emission.host import CSource
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import InputWarning, ModelLimitWarning, UsageError
from aomc_sky.plan.plan import Plan

READING = ("iterations", "sky", "bins", "weighting", "compat")
SAMPLING = ("allocation", "method", "placement", "order", "precision")


class Opened:
    """A source and the C functions that it has handed out."""

    def __init__(self, photons: PhotonSource) -> None:
        self._photons = photons
        self._sources: dict[int, CSource] = {}

    @property
    def n_bands(self) -> int:
        """Number of wavebands."""
        return self._photons.n_bands

    def source(self, band: int) -> tuple[int, int, int, bool, int, float]:
        """Addresses of photons and numbers, context, whether it is float64, photons and wavelength [nm] of a band."""
        if band not in self._sources:
            self._sources[band] = self._photons.c_source(band)
        source = self._sources[band]
        wavelength = self._photons.plan.bands[band].wavelength_nm
        addresses = source.address, source.numbers_address
        return *addresses, source.context, source.precision.itemsize == 8, source.n, wavelength

    def close(self) -> None:
        """Close every source."""
        for source in self._sources.values():
            source.close()


def parse_options(text: str) -> dict[str, Any]:
    """Read options from words ``name=value``; a UsageError names a bad word."""
    options: dict[str, Any] = {}
    for word in text.split():
        name, equals, value = word.partition("=")
        if not equals or not value:
            raise UsageError(f"option {word!r}: write name=value")
        if name not in READING + SAMPLING:
            near = difflib.get_close_matches(name, READING + SAMPLING, 1)
            hint = f"; did you mean {near[0]!r}?" if near else f"; the options are {', '.join(READING + SAMPLING)}"
            raise UsageError(f"unknown option {name!r}{hint}")
        if name in options:
            raise UsageError(f"option {name!r} is given twice")
        if name == "iterations" and not (value.isascii() and value.isdigit()):
            raise UsageError(f"iterations must be a whole number, got {value!r}")
        options[name] = int(value) if name == "iterations" else value
    return options


def open_scene(path: bytes, seed: int, options: str) -> Opened:
    """Open amc.inp or the folder of a scene."""
    from aomc_sky.source.read.scene import read_scene

    chosen = parse_options(options)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = read_scene(os.fsdecode(path), **{name: chosen[name] for name in READING if name in chosen})
        source = scene.source(seed, **{name: chosen[name] for name in SAMPLING if name in chosen})
    for warning in caught:
        if issubclass(warning.category, InputWarning | ModelLimitWarning):
            print(f"aomc-sky: warning: {warning.message}", file=sys.stderr)
    return Opened(source)


def open_run(folder: bytes) -> Opened:
    """Open a run folder by its plan."""
    return Opened(PhotonSource.from_plan(Plan.load(os.path.join(os.fsdecode(folder), "plan.npz"))))
