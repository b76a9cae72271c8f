"""The bytes of a background-sky file, and the content that a reader will find in them."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from aomc_sky.extras import optional_module
from aomc_sky.formats.background.data import Animation, BackgroundFile, ReferenceType
from aomc_sky.formats.background.schema import (
    EXTRA,
    LOBE,
    NM_PER_UM,
    NUMBERS,
    OPTIONAL,
    REFERENCE,
    SI_PER_FILE_UNIT,
    TEXTS,
)

Add = Callable[[str, str, str, str], None]


def check_storable(background: BackgroundFile, add: Add) -> None:
    """Report shapes that do not fit each other, names and texts that HDF5 does not hold, numbers too large.

    Parameters
    ----------
    background : BackgroundFile
        What is to be written.
    add : callable
        Takes code, place, message and advice of each fault.
    """
    shape = background.curves.shape
    if background.wavelength_nm.ndim != 1 or len(shape) != 2 or shape[1] != background.wavelength_nm.size or 0 in shape:
        found = f"shape {shape} with wavelengths of shape {background.wavelength_nm.shape}"
        add("E505", "curves", found, "give (curves, wavelengths) and (wavelengths,), both at least 1")
    for field in TEXTS.values():
        if not _is_text(getattr(background.info, field)):
            add("E505", field, "a text with NUL characters or lone surrogates", "leave them out")
    for field in NUMBERS.values():
        if not 0 <= getattr(background.info, field) < 2**32:
            add("E505", field, f"{getattr(background.info, field)}; allowed: 0 to 2^32 - 1", "write such a number")
    if not background.animations:
        add("E504", "animations", "no animation", "give at least one lobe")
    for name, keys in background.animations.items():
        if not _is_text(name) or "/" in name or name in ("", ".", ".."):
            add("E502", repr(name), "not a name of an animation", "leave out slashes and NUL, and give it letters")
        if not 0 <= keys.time_point_s < 2**64:
            found = f"time point {keys.time_point_s} s; allowed: 0 to 2^64 - 1"
            add("E507", name, found, "count from 1970-01-01 UTC")
        n = len(keys)
        columns = (keys.param0, keys.param1, keys.coefficient, keys.curve_index, keys.relative_time_days)
        if keys.lobe_type.ndim != 1 or any(c.shape != (n,) for c in columns) or keys.quaternion.shape != (n, 4):
            add("E505", name, "its arrays have different lengths", "use animation_of_lobes")


def _is_text(text: str) -> bool:
    return "\0" not in text and not any("\ud800" <= c <= "\udfff" for c in text)


def as_stored(background: BackgroundFile) -> BackgroundFile:
    """The content rounded to the widths of the file."""
    return replace(
        background,
        animations={
            name: replace(
                keys,
                param0=_rounded(keys.param0),
                param1=_rounded(keys.param1),
                coefficient=_rounded(keys.coefficient),
                relative_time_days=_rounded(keys.relative_time_days),
            )
            for name, keys in background.animations.items()
        },
        wavelength_nm=_rounded(background.wavelength_nm / NM_PER_UM) * NM_PER_UM,
        curves=_rounded(background.curves / SI_PER_FILE_UNIT) * SI_PER_FILE_UNIT,
    )


def encode_background(background: BackgroundFile) -> bytes:
    """The file, made in memory, for the HDF5 library dies of a full disk where it should report one.

    Parameters
    ----------
    background : BackgroundFile
        Content without faults.
    """
    h5py = optional_module("h5py", extra=EXTRA)
    buffer = io.BytesIO()
    # the oldest layout has no times of creation; every version of the library reads it
    with h5py.File(buffer, "w", libver="earliest", track_order=False) as file:
        info = file.create_group("Info")
        for name, field in NUMBERS.items():
            info.create_dataset(name, data=np.array([getattr(background.info, field)], "<u4"), track_times=False)
        for name, field in TEXTS.items():
            text = getattr(background.info, field)
            if text or name not in OPTIONAL:
                info.create_dataset(name, data=[text], dtype=h5py.string_dtype(), track_times=False)
        animations = file.create_group("LobeAnims")
        for name in sorted(background.animations):
            _write_animation(animations.create_group(name), background.animations[name])
        samples = _single(background.wavelength_nm / NM_PER_UM)[np.newaxis]
        file.create_dataset("SpectralCurves", data=_single(background.curves / SI_PER_FILE_UNIT), track_times=False)
        file.create_dataset("SpectralSamples", data=samples, track_times=False)
    return buffer.getvalue()


def _write_animation(group: Any, keys: Animation) -> None:
    lobes = np.zeros(len(keys), LOBE)
    lobes["Type"] = keys.lobe_type
    lobes["Param0"], lobes["Param1"], lobes["Coeff"] = keys.param0, keys.param1, keys.coefficient
    lobes["LocalTransform"], lobes["CurveIndex"] = keys.quaternion, keys.curve_index
    lobes["RelativeTime"] = keys.relative_time_days
    reference = np.zeros(1, REFERENCE)
    reference["Type"] = ReferenceType(keys.reference)
    reference["TimePoint"] = keys.time_point_s
    group.create_dataset("Lobes", data=lobes, track_times=False)
    group.create_dataset("ReferenceTime", data=reference, track_times=False)


def _single(values: np.ndarray) -> np.ndarray:
    """Rounded to float32; what is too large becomes infinite, which the checks refuse."""
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(values, np.float64).astype("<f4")


def _rounded(values: np.ndarray) -> np.ndarray:
    return _single(values).astype(np.float64)
