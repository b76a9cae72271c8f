"""Background-sky files (DIRSIG BackgroundSkyData, HDF5): reader and writer."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import InputFileError, SceneError
from aomc_sky.extras import optional_module
from aomc_sky.formats.background.checks import check_background, check_storable
from aomc_sky.formats.background.data import (
    EXTRA,
    INFORMING,
    LOBE,
    NM_PER_UM,
    NUMBERS,
    OPTIONAL,
    REFERENCE,
    SI_PER_FILE_UNIT,
    TEXTS,
    WANTED,
    Animation,
    BackgroundFile,
    BackgroundInfo,
    Lobe,
    LobeType,
    ReferenceType,
    animation_of_lobes,
)
from aomc_sky.formats.background.hdf5_members import printable, read_members
from aomc_sky.formats.background.parts import background_of_members
from aomc_sky.formats.report import Report
from aomc_sky.formats.text_file import write_bytes_atomically


def read_background_file(path: str | Path) -> BackgroundFile:
    """Read a background-sky file into our units.

    Members are found by name, whatever their width, byte order and padding; the texts and numbers of ``/Info``
    may stand as attributes of the root instead. What is only for persons (name, author, organization,
    description, file type) may be a text, a list of texts or numbers; anything else there is a warning.
    Quaternions are normalised in float64; ``Param1`` of a Henyey-Greenstein lobe, which has no meaning, becomes 0.

    Parameters
    ----------
    path : str or Path
        The file. [at most 1 GiB]

    Returns
    -------
    BackgroundFile
        Wavelengths in nm and curves in W m-2 nm-1, from micrometres and W cm-2 um-1 in the file.

    Raises
    ------
    InputFileError
        Every problem of the file, codes E500 to E509.
    MissingExtraError
        h5py is not installed: ``pip install "aomc-sky[hdf5]"``.

    Notes
    -----
    A child process opens the file, for a damaged one can end or hang the HDF5 library. No other file is opened,
    and no more memory is taken than a multiple of the size of the file. Cost: 0.3 s.
    """
    report = _report(path)
    members = read_members(path, WANTED, report, extra=EXTRA, informing=INFORMING)
    file = background_of_members(members, report)
    if file is not None:
        check_background(file, _adder(report))
    report.close()
    if file is None:  # background_of_members reports why
        raise AssertionError(f"nothing is reported of {path}")
    return file


def write_background(path: str | Path, background: BackgroundFile) -> None:
    """Write a background-sky file, atomically; equal content gives equal bytes with one version of the library.

    Parameters
    ----------
    path : str or Path
        The file; its folder must exist.
    background : BackgroundFile
        Content in our units; it is stored in the widths of the format, float32 and uint32.

    Raises
    ------
    SceneError
        Values that the reader would refuse, rounded to float32 as they are; nothing is written.
    OutputError
        The operating system refuses; nothing was changed.
    MissingExtraError
        h5py is not installed: ``pip install "aomc-sky[hdf5]"``.
    """
    report = _report(path)
    check_storable(background, _adder(report))
    if not report.has_errors:
        check_background(as_stored(background), _adder(report))
    try:
        report.close()
    except InputFileError as error:
        raise SceneError(str(error)) from None
    write_bytes_atomically(path, encode_background(background))


def _report(path: str | Path) -> Report:
    return Report(path=str(path))


def _adder(report: Report) -> Callable[[str, str, str, str], None]:
    return lambda code, name, found, advice: report.add(code, found, name=printable(name), advice=advice)


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
    """The file, made in memory, for the HDF5 library dies of a full disk where it should report one."""
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


__all__ = [
    "Animation",
    "BackgroundFile",
    "BackgroundInfo",
    "Lobe",
    "LobeType",
    "ReferenceType",
    "animation_of_lobes",
    "read_background_file",
    "write_background",
]
