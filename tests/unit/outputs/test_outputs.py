"""Writers and counts: their bytes, their sizes, and what they cost."""

from __future__ import annotations

import io

import numpy as np
import pytest

from aomc_sky.errors import AomcSkyError, UsageError
from aomc_sky.outputs import counts
from aomc_sky.outputs.blocks.blocks import BLOCK, ChunkPool
from aomc_sky.outputs.blocks.statistics import BlockSums, PhotonSums, block_sums
from aomc_sky.outputs.manifest import read_manifest
from aomc_sky.outputs.photons.files import PHOTON_FORMATS, photon_writer
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.read.scene import read_scene
from tests.support.shared import INPUTS


@pytest.fixture(scope="module")
def source() -> PhotonSource:
    return read_scene(INPUTS / "document_example", iterations=3 * BLOCK + 5).source(seed=3)


@pytest.fixture(scope="module")
def dense() -> PhotonSource:
    return read_scene(INPUTS / "clear_day").source()


@pytest.mark.parametrize("name", sorted(PHOTON_FORMATS))
@pytest.mark.parametrize("iterations", [1, 1000])
def test_headers_and_chunks_have_the_promised_size(name, iterations):
    source = read_scene(INPUTS / "document_example", iterations=iterations).source(seed=3)
    writer = photon_writer(name)(source)
    bands = list(range(source.n_bands))
    for part in writer.parts(bands):
        files = [io.BytesIO() for _ in writer.names(part)]
        for file, head in zip(files, writer.headers(part), strict=True):
            file.write(head)
        for band in part:
            for batch in source.batches(band, 300):
                for file, chunk in zip(files, writer.chunks(batch), strict=True):
                    file.write(chunk)
        assert tuple(len(file.getvalue()) for file in files) == writer.sizes(part)
    assert sorted(band for part in writer.parts(bands) for band in part) == bands


def test_an_npy_header_is_numpys_own(source):
    writer = photon_writer("npy")(source)
    batch = source.photons(0)
    buffer = io.BytesIO()
    np.save(buffer, batch.directions)
    assert writer.headers((0,))[0] + bytes(writer.chunks(batch)[0]) == buffer.getvalue()


def test_unknown_formats_are_refused():
    with pytest.raises(UsageError, match="and none"):
        photon_writer("hdf5")


def test_the_pool_keeps_order_and_memory(source):
    with ChunkPool(source, 5) as pool:
        writer = photon_writer("npy")(source)
        pieces = [(bytes(chunks[0][0]), n) for chunks, _, n in pool.chunks(2, [writer])]
        assert len(pool._free) <= 5
    assert [n for _, n in pieces] == [BLOCK, BLOCK, BLOCK, 5]
    assert b"".join(data for data, _ in pieces) == source.photons(2).directions.tobytes()


def test_block_sums_do_not_depend_on_the_kernels(source):
    from aomc_sky.kernels.batches import plain_statistics
    from aomc_sky.kernels.batches.statistics import block_sums as compiled

    uz = source.photons(0, 0, BLOCK).uz
    assert compiled(uz) == plain_statistics.block_sums(uz) == block_sums(uz)


def test_sums_of_horizontal_photons_and_of_none():
    def block(mu, inverse):
        return BlockSums(replicate=0, n_photons=1, mu=mu, inverse=inverse, weight=1.0, weighted_inverse=inverse)

    sums = PhotonSums()
    assert sums.mean("mu") is None
    assert sums.planar_over_scalar() is None
    sums.add([block(0.5, 2.0), block(0.0, np.inf)])
    assert (sums.mean("mu"), sums.planar_over_scalar(), sums.mean("weight")) == (0.25, 0.0, 1.0)
    assert sums.mean("weighted_inverse") == np.inf


def test_counts_csv_columns_and_bounds(source):
    lines = counts.counts_csv(source, [0, 2]).decode().splitlines()
    assert lines[0] == counts.COLUMNS
    first = lines[1].split(",")
    assert first[:1] + first[3:10] == ["1", "sky", "1", "0", "0.0", "45.0", "0.0", "120.0"]
    assert {line.split(",")[0] for line in lines[1:]} == {"1", "3"}
    assert len(lines) - 1 == counts.n_rows(source, [0, 2])


def test_components_without_patches_leave_their_columns_empty():
    beam = read_scene(INPUTS / "beam_only").source()
    rows = [line.split(",") for line in counts.counts_csv(beam, [0]).decode().splitlines()[1:]]
    assert [row[3:10] for row in rows] == [["direct", "", "", "", "", "", ""]]
    assert rows[0][2] == ""
    assert int(rows[0][-1]) == beam.n_photons(0)


def test_a_dense_sky_has_a_line_for_every_patch_with_mass(dense):
    bands = list(range(dense.n_bands))
    data = counts.counts_csv(dense, bands)
    rows = data.count(b"\n") - 1
    assert rows == counts.n_rows(dense, bands)
    assert rows > 30_000


def test_a_large_table_becomes_npz(dense, monkeypatch):
    monkeypatch.setattr(counts, "MAX_CSV_ROWS", 1000)
    name, data = counts.counts_file(dense, [0])
    assert name == "counts.npz"
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        assert np.array_equal(stored["photons"], dense.counts[[0]])
        assert np.array_equal(stored["mass"][0], dense.mass(0))
        assert stored["waveband"].tolist() == [1]
        assert stored["cell"].size == dense.plan.n_cells


WRONG_BAND = (
    '{"schema": "aomc-sky-manifest/1", "plan_sha256": "", "seed": 0, '
    '"options": {"formats": []}, "bands": [{}], "content": null, "files": {}, "notes": []}'
)
NO_CONTENT = WRONG_BAND.replace("{}]", "]").replace('"content": null, ', "")


@pytest.mark.parametrize("text", ["", "[]", "{}", WRONG_BAND, NO_CONTENT, '{"schema": "aomc-sky-manifest/1"}', "\xff"])
def test_damaged_manifests_are_told(tmp_path, text):
    (tmp_path / "manifest.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(AomcSkyError, match="manifest"):
        read_manifest(tmp_path / "manifest.json")
