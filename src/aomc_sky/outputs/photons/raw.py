"""Photons as bare float32 records."""

from __future__ import annotations

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.outputs.photon_formats import columns_of
from aomc_sky.outputs.photons.files import PhotonWriter, stacked

_RECORD = np.dtype("<f4")


class RawWriter(PhotonWriter):
    """The raw files of a source, and their bytes."""

    names = ("photons-{:04d}.raw",)

    def __init__(self, source: PhotonSource) -> None:
        super().__init__(source)
        self.row_bytes = len(columns_of(source)) * _RECORD.itemsize

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Records of a batch."""
        rows = stacked(batch).astype(_RECORD, copy=False)
        return (rows.data.cast("B") if rows.size else memoryview(b""),)
