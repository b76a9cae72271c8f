"""The source in a file, which ``aomc_sky.h`` reads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.source_file import head_of
from aomc_sky.errors import UsageError, require_kind
from aomc_sky.formats.text_file import refuse, write_bytes_atomically
from aomc_sky.system import FileKindError, open_regular, prepare_target

_MAX_BYTES = 2**34


def read_source_head(path: Path) -> dict[str, Any]:
    """What a source file says of itself: layout, stream, precision, plan, size and bands, as JSON values.

    InputFileError if it is none, or damaged; E971.
    """
    advice = "name a file that `aomc-sky run --format source` or `export --to source` wrote"
    try:
        with open_regular(path) as file:
            data = file.read(_MAX_BYTES)
    except (OSError, FileKindError) as error:
        raise refuse(path, f"cannot be read: {error}", code="E971", advice=advice) from None
    found = head_of(data)
    if found is None:
        raise refuse(path, "is no source file of this layout, or it is damaged", code="E971", advice=advice)
    return found


def write_source(source: PhotonSource, path: str | Path) -> None:
    """Write a source as one file, with which any code makes its photons without Python.

    The header ``aomc_sky.h`` (in the folder of ``aomc-sky info --include-dir``) reads it: C, C++, CUDA and Fortran get
    the photons of `PhotonSource.photons`, bit for bit. The file has up to a megabyte for each waveband of 32 400
    patches, however many photons there are, and a part of that again for each further replicate.

    Parameters
    ----------
    source : PhotonSource
        Where the photons come from.
    path : str or Path
        The file, replaced atomically; its folder must exist.

    Raises
    ------
    OutputError
        The operating system refuses, or the disk is full; nothing half-written is left.

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=100, components="uniform")
    >>> sky.write_source(scene.source(seed=1), "day.sky")
    """
    require_kind(source, PhotonSource, "write_source(scene.source(seed=1), path)")
    target = Path(path)
    if not target.name:
        raise UsageError(f"expected the name of a file such as day.sky, got {str(path)!r}")
    data = source.to_bytes()
    prepare_target(target)
    write_bytes_atomically(target, data)
