"""Photons as text: every bit comes back, and files are as long as they were promised."""

from __future__ import annotations

import io

import numpy as np
import pytest

from aomc_sky import Footprint, Scene, TabulatedSky, UniformSky, Wavebands
from aomc_sky.errors import OutputError
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.photons.rows import CsvWriter
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import FootprintShape

BANDS = Wavebands(wavelength_nm=np.array([500.0, 600.0]))


def full_source(precision: str) -> PhotonSource:
    """Photons with positions and weights."""
    table = TabulatedSky(
        wavelength_nm=[500.0], values=np.array([[1.0, 2.0, 0.0, 5.0]]), grid=PatchGrid.regular(2, 2), weighting="listed"
    )
    footprint = Footprint(shape=FootprintShape.CIRCLE, size_x_m=30.0, size_y_m=30.0)
    scene = Scene(wavebands=BANDS, n_photons=[700, 0], components=(table,), footprint=footprint)
    return scene.source(2, precision=precision, weights=True)


def text_of(source: PhotonSource, band: int) -> bytes:
    writer = CsvWriter(source)
    chunks = [bytes(writer.chunks(batch)[0]) for batch in source.batches(band, 256)]
    text = writer.headers((band,))[0] + b"".join(chunks)
    assert len(text) == writer.sizes((band,))[0]
    return text


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_every_bit_comes_back(precision):
    source = full_source(precision)
    text = text_of(source, 0)
    assert text.splitlines()[0] == b"ux,uy,uz,x_m,y_m,weight"
    numbers = np.loadtxt(io.BytesIO(text), delimiter=",", skiprows=1).astype(precision)
    batch = source.photons(0)
    for column, wanted in zip(numbers.T, (batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight), strict=True):
        assert np.array_equal(column.view(f"u{column.itemsize}"), wanted.view(f"u{wanted.itemsize}"))
    assert text_of(source, 1) == b"ux,uy,uz,x_m,y_m,weight\n"


def test_a_point_source_has_directions_alone():
    source = Scene(wavebands=BANDS, n_photons=3, components=(UniformSky(),)).source()
    assert text_of(source, 0).splitlines()[0] == b"ux,uy,uz"


def test_one_digit_less_would_lose_bits():
    ux = full_source("float32").photons(0).ux
    assert any(np.float32(f"{float(v):+.7e}") != v for v in ux)
    assert all(np.float32(f"{float(v):+.8e}") == v for v in ux)


def test_a_number_too_wide_is_an_error():
    source = full_source("float64")
    batch = source.photons(0)
    batch.weight[3] = 1e-120
    with pytest.raises(OutputError, match="1e-99"):
        CsvWriter(source).chunks(batch)
