"""What every writer of photons promises, text of which every bit comes back, and numpy files that are read again."""

import io
from pathlib import Path

import numpy as np
import pytest

from aomc_sky import Footprint, PatchGrid, Scene, TabulatedSky, UniformSky
from aomc_sky.errors import InputFileError, OutputError
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, photon_writer
from aomc_sky.outputs.photons.csv import CsvWriter
from aomc_sky.outputs.photons.files import BLOCK, ChunkPool
from aomc_sky.outputs.photons.npy import HEAD_BYTES, read_photons_npy
from aomc_sky.source.read.scene import read_scene
from aomc_sky.verify.foreign import open_photons
from tests.support.sampled import table_of
from tests.support.shared import INPUTS


@pytest.mark.parametrize("name", sorted(PHOTON_FORMATS))
@pytest.mark.parametrize("iterations", [1, 1000])
def test_headers_and_chunks_have_the_promised_size(name, iterations):
    source = read_scene(INPUTS / "document_example", iterations=iterations).source(seed=3)
    writer = photon_writer(name)(source)
    bands = list(range(source.n_bands))
    for part in writer.parts(bands):
        layouts = writer.layouts(part)
        files = [io.BytesIO(layout.head) for layout in layouts]
        for file in files:
            file.seek(0, io.SEEK_END)
        for band in part:
            for batch in source.batches(band, 300):
                for file, chunk in zip(files, writer.chunks(batch), strict=True):
                    file.write(chunk)
        assert [len(file.getvalue()) for file in files] == [layout.size for layout in layouts]
    assert sorted(band for part in writer.parts(bands) for band in part) == bands


def test_an_npy_header_is_numpys_own_on_a_page():
    source = read_scene(INPUTS / "document_example", iterations=77).source(seed=3)
    writer = photon_writer("npy")(source)
    batch = source.photons(0)
    data = writer.layouts((0,))[0].head + bytes(writer.chunks(batch)[0])
    buffer = io.BytesIO()
    np.save(buffer, batch.directions)
    text = data[10 : HEAD_BYTES - 1].rstrip()
    assert text in buffer.getvalue()  # the same words, and more blanks behind them
    assert len(data) == HEAD_BYTES + batch.directions.nbytes
    assert np.array_equal(np.load(io.BytesIO(data)), batch.directions)


def test_files_without_a_reader_are_refused(tmp_path):
    for name in ("photons-0001.raw", "photons-0001.CSV"):
        (tmp_path / name).write_bytes(bytes(24))
        with pytest.raises(InputFileError, match="photons of this format cannot be read"):
            open_photons(tmp_path / name, np.array([500.0]))


def weighted_source(precision):
    """Photons with positions and weights in the first of two wavebands, none in the second."""
    table = table_of([[1.0, 2.0], [0.0, 5.0]])
    scene = Scene(wavebands=[500.0, 600.0], n_photons=[700, 0], components=table, footprint=Footprint.circle(30.0))
    return scene.source(2, precision=precision, weights=True)


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


def test_positions_come_before_weights_and_stokes_vectors_last():
    values = np.random.default_rng(2).uniform(0.5, 1, (1, 12))
    table = TabulatedSky(
        wavelength_nm=[550.0], values=values, values_q=values * 0.3, values_u=values * -0.2, weighting="solid-angle",
        grid=PatchGrid.regular(3, 4),
    )  # fmt: skip
    scene = Scene(wavebands=[550.0], n_photons=500, components=table, footprint=Footprint.circle(2.0))
    source = scene.source(weights=True, precision="float64")
    batch = source.photons(0)
    expected = np.stack([getattr(batch, name) for name in ("ux", "uy", "uz", "x", "y", "weight", "q", "u")], axis=-1)
    text = text_of(source, 0)
    assert text.splitlines()[0] == b"ux,uy,uz,x_m,y_m,weight,q,u"
    np.testing.assert_array_equal(np.loadtxt(io.BytesIO(text), delimiter=",", skiprows=1), expected)
    raw = bytes(photon_writer("raw")(source).chunks(batch)[0])
    np.testing.assert_array_equal(np.frombuffer(raw, "<f4").reshape(-1, 8), expected.astype("<f4"))


def test_text_has_as_many_columns_and_digits_as_it_needs():
    source = Scene(wavebands=[500.0], n_photons=3, components=(UniformSky(),)).source()
    assert text_of(source, 0).splitlines()[0] == b"ux,uy,uz"
    ux = weighted_source("float32").photons(0).ux
    assert any(np.float32(f"{float(v):+.7e}") != v for v in ux)
    assert all(np.float32(f"{float(v):+.8e}") == v for v in ux)
    source = weighted_source("float64")
    batch = source.photons(0)
    batch.weight[3] = 1e-120
    with pytest.raises(OutputError, match="1e-99"):
        CsvWriter(source).chunks(batch)


@pytest.mark.parametrize("dtype", ["<f4", ">f4", "<f8", ">f8"])
@pytest.mark.parametrize("shape", [(0, 3), (7, 3), (BLOCK, 4), (2 * BLOCK + 1,), (2 * BLOCK + 1, 3)])
@pytest.mark.parametrize("order", "CF")
def test_rows_come_back(tmp_path, dtype, shape, order):
    rows = np.arange(float(np.prod(shape))).reshape(shape).astype(dtype, order=order)
    np.save(tmp_path / "x.npy", rows)
    file = read_photons_npy(tmp_path / "x.npy", n_columns=(1, 3, 4))
    blocks = list(file.blocks())
    assert file.n_photons == len(rows)
    assert all(len(block) <= BLOCK for block in blocks)
    assert np.array_equal(np.concatenate([*blocks, np.zeros((0, file.n_columns))]).reshape(shape), rows)


def test_no_regular_file(tmp_path):
    for path in (tmp_path, tmp_path / "nowhere.npy", Path("/dev/null"), Path("a\0b")):
        with pytest.raises(InputFileError, match="E901"):
            read_photons_npy(path)


@pytest.mark.parametrize("order", "CF")
def test_a_file_that_becomes_shorter(tmp_path, order):
    path = tmp_path / "x.npy"
    np.save(path, np.zeros((100, 3), order=order))
    file = read_photons_npy(path)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputFileError, match="E903"):
        list(file.blocks())


def test_the_pool_keeps_order():
    """A pipe takes the bytes as they come: threads that end early wait."""
    source = read_scene(INPUTS / "document_example", iterations=3 * BLOCK + 5).source(seed=3)
    starts, pieces = [], []

    def write(band, start, chunks):
        starts.append(start)
        pieces.append(bytes(chunks[0]))

    with ChunkPool(source, 5) as pool:
        sums = pool.emit(2, [(photon_writer("npy")(source), write)], lambda n: None)
    assert starts == [0, BLOCK, 2 * BLOCK, 3 * BLOCK]
    assert sums.n_photons == 3 * BLOCK + 5
    assert b"".join(pieces) == source.photons(2).directions.tobytes()
