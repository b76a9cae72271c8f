"""What every writer of photons promises, whatever its format."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky import Footprint, Scene, TabulatedSky, Wavebands
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.photons.files import PHOTON_FORMATS, photon_writer
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import FootprintShape


def full_source(precision: str) -> PhotonSource:
    """Photons with positions and weights."""
    table = TabulatedSky(
        wavelength_nm=[500.0], values=np.array([[1.0, 2.0, 0.0, 5.0]]), grid=PatchGrid.regular(2, 2), weighting="listed"
    )
    footprint = Footprint(shape=FootprintShape.CIRCLE, size_x_m=30.0, size_y_m=30.0)
    bands = Wavebands(wavelength_nm=np.array([500.0]))
    scene = Scene(wavebands=bands, n_photons=700, components=(table,), footprint=footprint)
    return scene.source(2, precision=precision, weights=True)


@pytest.mark.parametrize("name", sorted(PHOTON_FORMATS))
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_chunks_outlive_the_arrays_of_their_batch(name, precision):
    """A pool fills the arrays of a batch again while the bytes of the one before wait to be written."""
    source = full_source(precision)
    batch = source.photons(0)
    chunks = photon_writer(name)(source).chunks(batch)
    written = [bytes(chunk) for chunk in chunks]
    for array in (batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight):
        assert array is not None
        array[:] = 0.5
    assert [bytes(chunk) for chunk in chunks] == written
