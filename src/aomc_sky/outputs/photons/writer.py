"""Writers of photon files: what one says of its files and makes of a block of photons; the formats by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks.shard import WHOLE, Shard
from aomc_sky.source.photons import PhotonBatch

PHOTON_FORMATS = {
    "csv": "aomc_sky.outputs.photons.csv:CsvWriter",
    "mcpl": "aomc_sky.outputs.photons.mcpl:McplWriter",
    "npy": "aomc_sky.outputs.photons.npy:NpyWriter",
    "raw": "aomc_sky.outputs.photons.raw:RawWriter",
}
"""Name of a photon format -> "module:Class"; "none" writes counts and plan only."""


class PhotonWriter(ABC):
    """The files of a source in one format: their names and lengths, and the bytes of each block; it opens no file.

    `bands` are the wavebands [0-based] that share files: one of the groups that `parts` gives.
    """

    has_rows = False  #: the files hold every bit of the photons, in rows of numbers
    row_dtype: np.dtype  #: of the numbers, where there are rows
    widths: tuple[int, ...]  #: numbers of a row of each file, where there are rows
    shard: Shard = WHOLE  #: which of the photons the files hold

    def parts(self, bands: Sequence[int]) -> list[tuple[int, ...]]:
        """Wavebands that share files: by default every one has its own."""
        return [(band,) for band in bands]

    @abstractmethod
    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """Names of the files."""

    @abstractmethod
    def headers(self, bands: tuple[int, ...]) -> tuple[bytes, ...]:
        """Bytes that each file starts with."""

    @abstractmethod
    def sizes(self, bands: tuple[int, ...]) -> tuple[int, ...]:
        """Length of each finished file. [bytes]"""

    @abstractmethod
    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Bytes that a batch adds to each file; they outlive its arrays, which are filled again."""

    def recycle(self, chunks: tuple[memoryview, ...]) -> None:  # noqa: B027
        """Take memory back whose bytes are written; by default every chunk has its own."""


def photon_writer(name: str) -> Any:
    """Return the writer class of a photon format."""
    target = PHOTON_FORMATS.get(name)
    if target is None:
        raise UsageError(f"there is no photon format {name!r}; the formats are {', '.join(PHOTON_FORMATS)} and none")
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)
