"""Photons as text: every bit comes back, and files are as long as they were promised."""

import io

import numpy as np
import pytest

from aomc_sky import Scene, UniformSky
from aomc_sky.errors import OutputError
from aomc_sky.outputs.photons.csv import CsvWriter
from tests.support.scenes import weighted_source


def text_of(source, band):
    writer = CsvWriter(source)
    chunks = [bytes(writer.chunks(batch)[0]) for batch in source.batches(band, 256)]
    text = writer.layouts((band,))[0].head + b"".join(chunks)
    assert len(text) == writer.layouts((band,))[0].size
    return text


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_every_bit_comes_back(precision):
    source = weighted_source(precision)
    text = text_of(source, 0)
    assert text.splitlines()[0] == b"ux,uy,uz,x_m,y_m,weight"
    numbers = np.loadtxt(io.BytesIO(text), delimiter=",", skiprows=1).astype(precision)
    batch = source.photons(0)
    for column, wanted in zip(numbers.T, (batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight), strict=True):
        assert np.array_equal(column.view(f"u{column.itemsize}"), wanted.view(f"u{wanted.itemsize}"))
    assert text_of(source, 1) == b"ux,uy,uz,x_m,y_m,weight\n"


def test_a_point_source_has_directions_alone():
    source = Scene(wavebands=[500.0], n_photons=3, components=(UniformSky(),)).source()
    assert text_of(source, 0).splitlines()[0] == b"ux,uy,uz"


def test_one_digit_less_would_lose_bits():
    ux = weighted_source("float32").photons(0).ux
    assert any(np.float32(f"{float(v):+.7e}") != v for v in ux)
    assert all(np.float32(f"{float(v):+.8e}") == v for v in ux)


def test_a_number_too_wide_is_an_error():
    source = weighted_source("float64")
    batch = source.photons(0)
    batch.weight[3] = 1e-120
    with pytest.raises(OutputError, match="1e-99"):
        CsvWriter(source).chunks(batch)
