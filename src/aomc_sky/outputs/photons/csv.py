"""Photons as text with all digits, in columns of fixed width."""

from __future__ import annotations

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.errors import OutputError
from aomc_sky.outputs.photon_formats import columns_of
from aomc_sky.outputs.photons.files import PhotonWriter, stacked

_DIGITS = {4: 8, 8: 16}
"""Bytes of a float -> digits after the point that distinguish it from its neighbours."""

_OTHER_CHARACTERS = len("+1.e+00") + len(",")


class CsvWriter(PhotonWriter):
    """The CSV files of a source, and their bytes.

    A number is a sign, a digit, a point, 8 digits (float32) or 16 (float64), and an exponent of two digits. Such a
    number can be read without loss, and the size of a file is known before it is made.
    """

    names = ("photons-{:04d}.csv",)

    def __init__(self, source: PhotonSource) -> None:
        super().__init__(source)
        columns = columns_of(source)
        digits = _DIGITS[source.dtype.itemsize]
        self.head = (",".join(columns) + "\n").encode("ascii")
        self._row = ",".join([f"%+.{digits}e"] * len(columns)) + "\n"
        self.row_bytes = len(columns) * (digits + _OTHER_CHARACTERS)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Lines of a batch."""
        text = (self._row * len(batch)) % tuple(stacked(batch).ravel().tolist())
        if len(text) != len(batch) * self.row_bytes:
            raise OutputError("a position or weight lies outside 1e-99 to 1e99 and does not fit the columns")
        return (memoryview(text.encode("ascii")),)
