"""Photons as bare float32 records."""

from __future__ import annotations

import numpy as np

from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.outputs.photons.files import FileLayout, PhotonWriter, stacked

_RECORD = np.dtype("<f4")


class RawWriter(PhotonWriter):
    """Which raw files a source needs, and their bytes."""

    names = ("photons-{:04d}.raw",)

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The file of a waveband: no head, records of float32 start at once."""
        width = 3 + 2 * self.source.has_positions + self.source.has_weights
        n = self.source.n_photons(bands[0])
        return (FileLayout(self.names[0].format(bands[0] + 1), b"", width * _RECORD.itemsize, n),)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Records of a batch."""
        rows = stacked(batch).astype(_RECORD, copy=False)
        return (rows.data.cast("B") if rows.size else memoryview(b""),)
