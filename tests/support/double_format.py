"""The photon format of docs/architecture.md, whose files do not end in its name."""

from aomc_sky.outputs.photons.files import PhotonWriter


class DoubleWriter(PhotonWriter):
    """Directions as bare float64 records, one file for each waveband."""

    names = ("photons-{:04d}.f64",)
    row_bytes = 24

    def chunks(self, batch):
        return (memoryview(batch.directions.astype("<f8").tobytes()),)
