"""Background-sky files (DIRSIG BackgroundSkyData, HDF5): reader and writer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from aomc_sky.errors import InputFileError, SceneError
from aomc_sky.formats.background.checks import check_background
from aomc_sky.formats.background.data import (
    Animation,
    BackgroundFile,
    BackgroundInfo,
    Lobe,
    LobeType,
    ReferenceType,
    animation_of_lobes,
)
from aomc_sky.formats.background.encoding import as_stored, check_storable, encode_background
from aomc_sky.formats.background.hdf5_members import printable, read_members
from aomc_sky.formats.background.parts import background_of_members
from aomc_sky.formats.background.schema import EXTRA, INFORMING, WANTED
from aomc_sky.formats.text_file import Report, write_bytes_atomically


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
