"""The source in a file, which ``aomc_sky.h`` reads."""

from __future__ import annotations

from pathlib import Path

from aomc_sky.atomic_file import prepare_target
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import UsageError, require_kind
from aomc_sky.formats.text_file import write_bytes_atomically

SOURCE_FILE = "source.sky"
"""Its name in a run folder."""


def write_source(source: PhotonSource, path: str | Path) -> None:
    """Write a source as one file, with which any code makes its photons without Python.

    The header ``aomc_sky.h`` (in the folder of ``aomc-sky info --include-dir``) reads it: C, C++, CUDA and Fortran get
    the photons of `PhotonSource.photons`, bit for bit. The file has about half a megabyte for each waveband of 32 400
    patches, however many photons there are.

    Parameters
    ----------
    source : PhotonSource
        Where the photons come from.
    path : str or Path
        The file, replaced atomically; its folder must exist.

    Raises
    ------
    UsageError
        The source has positions over a footprint, weights or replicates, which the file does not hold.
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
