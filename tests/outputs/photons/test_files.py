"""What every writer of photons promises, whatever its format."""

import io

import numpy as np
import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, photon_writer
from aomc_sky.outputs.photons.npy import HEAD_BYTES
from aomc_sky.source.read.scene import read_scene
from aomc_sky.verify.foreign import open_photons
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


@pytest.mark.parametrize("name", ["photons-0001.raw", "photons-0001.CSV"])
def test_files_without_a_reader_are_refused(name, tmp_path):
    (tmp_path / name).write_bytes(bytes(24))
    with pytest.raises(InputFileError, match="photons of this format cannot be read"):
        open_photons(tmp_path / name, np.array([500.0]))
