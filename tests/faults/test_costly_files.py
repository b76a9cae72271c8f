"""Rows 11 and 50 of the matrix: a few bytes that declare gigabytes, files without an end, files of a million rows."""

import io
import os

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import InputFileError
from aomc_sky.formats import text_file
from aomc_sky.formats.aomc import skydist
from aomc_sky.source.read import kind
from tests.support.fault_rows import command, launched, photons_of_band, row, row_id
from tests.support.processes import limited
from tests.support.scenes import copy_scene

MOST_MB = 250
"""Python, numpy and the package take 100 to 130 MB of it."""
ABSENT = {
    "3000 x 3000 x 2": ("run amc.inp", "4 3000 2999 2\n550.0 650.0\n1 1 0 1.0\n1 2 1 1.0\n2 1 0 1.0\n2 2 1 1.0\n"),
    "2 x 33554431": ("validate skydist.inp", "2 2 33554430 1\n550.0\n1 1 0 1.0\n1 2 1 1.0\n"),
    "33554431 x 2": ("info amc.inp", "2 33554431 1 1\n550.0\n1 1 0 1.0\n1 2 1 1.0\n"),
}


@pytest.mark.parametrize("name", ABSENT, ids=[row_id(11, f"absent-bins-{name}") for name in ABSENT])
def test_absent_bins_are_refused_before_they_take_memory(name, scene):
    words, text = ABSENT[name]
    (scene / "skydist.inp").write_text(text)
    ended = limited(scene, *words.split())
    assert ended.code == 3, ended.err
    assert "error[E304]: sky_zenith: " in ended.err
    assert ended.peak_mb < MOST_MB


@row(11, "limit-given")
def test_a_given_limit_is_one_of_files_and_plans_too(fault, scene, tmp_path, told):
    """Sixty-four thousand bins with three lit ones: 20 MB in all; at 30 MB the table fits, and its run does not."""
    (scene / "skydist.inp").write_text("3 160 399 1\n550.0\n1 1 0 1.0\n1 2 1 1.0\n1 160 399 2.0\n")
    for limit, code in (("17M", 3), ("30M", 2), ("1G", 0)):
        words = ("--iterations", 1000, "-q", "--out", tmp_path / "out", "--max-memory", limit)
        assert ("write --max-memory 1G" in told("run", scene, *words, code=code).err) == bool(code)
    assert set(launched(tmp_path / "out").values()) == {1000}


@row(11, "plan-of-many-wavebands")
def test_a_plan_is_refused_before_it_takes_memory(fault):
    """A fine grid fits, and four hundred times its counts do not."""
    grid = sky.PatchGrid.regular(500, 1000)
    table = sky.TabulatedSky(wavelength_nm=[500.0], values=np.ones((1, grid.n_patches)), grid=grid)
    scene = sky.Scene(wavebands=np.linspace(400, 700, 400), n_photons=10, components=table.lower(np.array([500.0])))
    with pytest.raises(sky.AomcSkyError, match=r"takes about 4\.\d GiB of memory, more than the 2\.0 GiB") as caught:
        scene.source()
    assert caught.value.exit_code == 2


@row(50, "equal-rows")
def test_equal_rows_are_read_as_fast_as_others(fault, tmp_path, monkeypatch):
    """By the reader of plain files, with the table that the other reader makes."""
    path = tmp_path / "skydist.inp"
    path.write_text("6 2 1 1\n550\n1 1 0 2.5\n1 2 1 4.0\n1 1 0 2.50\n1 2 1 4\n1 1 0 2.5\n1 1 1 0\n")
    tables = []
    for name, without in (("read_rows_fast", lambda *_: None), ("read_rows", None)):
        with monkeypatch.context() as patched:
            patched.setattr(skydist, name, without)
            tables.append(skydist.read_skydist(path))
    slow, fast = tables
    assert np.array_equal(fast.radiance, slow.radiance)
    assert np.array_equal(fast.line, slow.line)
    assert fast.line.max() == 8


@row(50, "equal-rows-of-a-broken-file")
def test_rows_of_a_file_with_doubts_take_the_short_way_too(fault, tmp_path, monkeypatch):
    """One row with commas sends the file to the slow reader, which scans that row alone."""
    path = tmp_path / "skydist.inp"
    path.write_text("5001 2 1 1\n550\n" + "1 1 0 2.5\n" * 5000 + "1,1,0,2.5\n")
    scanned, real = [], skydist.ListScanner.record

    def record(self, index, *rest, **more):
        scanned.append(index)
        return real(self, index, *rest, **more)

    monkeypatch.setattr(skydist.ListScanner, "record", record)
    table = skydist.read_skydist(path)
    assert table.radiance.sum() == 2.5
    assert len(scanned) < 10
    path.write_text("6 2 1 1\n550\n" + "1 1 0 2.5\n" * 5000)  # rows beyond a wrong count are counted the short way
    with pytest.raises(InputFileError, match="the header says 6 rows, the file has 5000"):
        skydist.read_skydist(path)
    assert len(scanned) < 20


class Endless(io.RawIOBase):
    """What gives bytes for ever, or none and no end, as a ring of the kernel does."""

    def __init__(self, piece):
        self.n_read, self._piece = 0, piece

    def read(self, size=-1):
        self.n_read += size
        return self._piece


@pytest.mark.parametrize(
    "piece", [b"1 1 0 1.0\n" * 100_000, None], ids=[row_id(50, "no-end"), row_id(50, "nothing-yet")]
)
def test_a_file_without_an_end_has_a_limit(piece, tmp_path, monkeypatch):
    path = tmp_path / "kmsg"
    path.touch()
    endless = Endless(piece)
    monkeypatch.setattr(text_file, "open_regular", lambda _: endless)
    with pytest.raises(InputFileError, match=r"error\[E101\]: the file has no end"):
        text_file.read_bytes(path)
    assert endless.n_read < 10 * text_file.UNSIZED_BYTES


@row(50, "nothing-yet-in-binary-files")
def test_a_binary_file_that_gives_nothing_is_refused(fault, tmp_path, monkeypatch):
    """A file of /proc states no size, and says that there is nothing yet."""
    reading, writing = os.pipe()
    os.set_blocking(reading, False)
    monkeypatch.setattr(text_file, "open_regular", lambda _: os.fdopen(reading, "rb"))
    with pytest.raises(InputFileError, match=r"error\[E801\]: not a regular file"):
        text_file.open_data(tmp_path / "kmsg", what="an MCPL file", code="E801")
    os.close(writing)


@row(50, "nothing-yet-in-a-file-of-any-name")
def test_the_kind_of_a_file_is_found_without_waiting(fault, tmp_path, monkeypatch):
    path = tmp_path / "kmsg"
    path.touch()
    monkeypatch.setattr(kind, "open_regular", lambda _: Endless(None))
    assert kind.kind_of(path) is None


@row(50, "pieces")
def test_rows_are_the_same_however_the_file_is_cut(fault, tmp_path, monkeypatch):
    path = tmp_path / "skydist.inp"
    value = np.add.outer(np.arange(20) * 31, np.arange(900)) % 97 + 0.125
    text = "".join(f"1 {z + 1} {a} {value[z, a]}\n" for z in range(20) for a in range(900))
    path.write_text("18000 20 899 1\n550\n" + text.rstrip("\n"))
    assert value.size > skydist._PIECE_ROWS
    monkeypatch.setattr(skydist, "read_rows", None)
    table = skydist.read_skydist(path)
    assert np.array_equal(table.radiance[0], value)
    assert np.array_equal(table.line[0].ravel(), np.arange(3, 18003))


@row(50, "hundreds-of-backgrounds")
def test_one_file_in_many_tables_is_made_a_sky_once(fault, tmp_path, monkeypatch):
    """Six hundred tables of one file at three times; what costs is done once for the file and once for a time."""
    pytest.importorskip("h5py")
    from aomc_sky.skies.lobes import light
    from aomc_sky.skies.lobes import sky as lobe_sky
    from aomc_sky.source.read.scene import read_scene

    scene = copy_scene("night_sky", tmp_path).parent
    times = [f"2026-02-14T21:{minute}:00Z" for minute in (10, 20, 30)]
    table = '[[background]]\nfile = "night.h5"\ntime = {}\n'
    (scene / "sky.toml").write_text('[sky]\nmodel = "none"\n' + "".join(table.format(time) for time in times * 200))
    made: dict[str, int] = {}

    def counted(module, name):
        real = getattr(module, name)

        def count(*given, **more):
            made[name] = made.get(name, 0) + 1
            return real(*given, **more)

        return count

    for module, name in ((light, "background_sky"), (light, "background_at"), (lobe_sky, "_unit_lobes")):
        monkeypatch.setattr(module, name, counted(module, name))
    n_lobes = len(read_scene(scene).components)
    assert n_lobes % 600 == 0
    assert made["background_sky"] == 1
    assert made["background_at"] == 3
    assert 0 < made["_unit_lobes"] <= 3


@row(11, "sparse-table-on-a-fine-grid")
def test_a_sparse_table_on_a_fine_grid_is_read(fault, scene, tmp_path):
    (scene / "skydist.inp").write_text("2 600 1199 1\n550.0\n1 1 0 1.0\n1 600 1199 3.0\n")
    assert command("run", scene, "--iterations", 4000, "--format", "none", "-q", "--out", tmp_path / "out") == 0
    for band in (1, 2, 3):
        assert photons_of_band(tmp_path / "out", band) == {(1, 0): 1000, (600, 1199): 3000}
