"""Photons as bare little-endian float32 records: ux, uy, uz, then x, y and the weight where there are any."""

from __future__ import annotations

import numpy as np

from aomc_sky.outputs.photons.writer import PhotonWriter
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch

_RECORD = np.dtype("<f4")


class RawWriter(PhotonWriter):
    """Which raw files a source needs, and their bytes."""

    row_dtype = _RECORD

    def __init__(self, source: PhotonSource) -> None:
        self._source = source
        self.has_rows = source.dtype == np.float32  # records are float32 always
        self.widths = (3 + (2 if source.has_positions else 0) + (1 if source.has_weights else 0),)

    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """The file of a part."""
        return (f"photons-{bands[0] + 1:04d}.raw",)

    def headers(self, bands: tuple[int, ...]) -> tuple[bytes, ...]:
        """Nothing: records start at once."""
        return (b"",)

    def sizes(self, bands: tuple[int, ...]) -> tuple[int, ...]:
        """Length of the finished file. [bytes]"""
        return (self._source.n_photons(bands[0]) * self.widths[0] * _RECORD.itemsize,)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Records of a batch."""
        columns = [batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight]
        rows = np.stack([c for c in columns if c is not None], axis=-1).astype(_RECORD, copy=False)
        return (rows.data.cast("B") if rows.size else memoryview(b""),)
