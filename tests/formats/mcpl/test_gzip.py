"""MCPL files packed by gzip: read in a stream, as libmcpl reads them, and what is cut, damaged or a lie is told."""

import gzip
import itertools
import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.formats.mcpl.file import check_mcpl, read_mcpl
from aomc_sky.formats.mcpl.header import McplHeader, encode_header
from tests.support.limits import answers_within_limits
from tests.support.mcpl import COUNT_OFFSET, encoded, oracle, random_particles

N = 400
HEADER = McplHeader(n_particles=3, weight=1.0, pdg_code=22, has_user_flags=True, comments=("first",))


def good(n=3):
    header = replace(HEADER, n_particles=n)
    records = np.zeros(n, header.record)
    records["packed"] = (0.6, 0.0, 1.0)
    return encoded(header, records)


@pytest.mark.parametrize("pieces", [1, 3])
def test_a_packed_file_is_read_as_libmcpl_does(pieces, tmp_path):
    """In one member of gzip or in several, which the standard puts together."""
    library, plain = oracle(), tmp_path / "x.mcpl"
    library.write(plain, McplHeader(n_particles=N, has_user_flags=True), [random_particles(N, 3)])
    data, packed = plain.read_bytes(), tmp_path / "y.mcpl.gz"
    cuts = np.linspace(0, len(data), pieces + 1).astype(int)
    packed.write_bytes(b"".join(gzip.compress(data[a:b]) for a, b in itertools.pairwise(cuts)))
    ours, theirs = read_mcpl(packed), library.read(packed)
    assert ours.is_packed
    assert ours.header == read_mcpl(plain).header
    assert np.array_equal(ours.particles().energy, theirs["ekin"])
    assert np.array_equal(ours.particles().user_flags, theirs["userflags"])
    blocks = list(ours.blocks(150))
    assert [(b.start, len(b)) for b in blocks] == [(0, 150), (150, 150), (300, 100)]
    assert np.array_equal(np.concatenate([b.direction for b in blocks]), read_mcpl(plain).particles().direction)
    for start, stop in ((0, 1), (7, 9), (399, 400), (400, 400), (5, 5)):
        assert np.array_equal(ours.particles(start, stop).direction, read_mcpl(plain).particles(start, stop).direction)
    assert [(b.start, len(b)) for b in ours.blocks(100, 250, 380)] == [(250, 50), (300, 80)]


def test_a_packed_file_is_known_by_its_bytes_and_stands_in_the_place_of_a_missing_one(tmp_path):
    """mcpltool goes by the name; people rename files."""
    (tmp_path / "x.mcpl.gz").write_bytes(gzip.compress(good()))
    assert read_mcpl(tmp_path / "x.mcpl").path == tmp_path / "x.mcpl.gz"
    assert len(read_mcpl(tmp_path / "x.mcpl").particles()) == 3
    (tmp_path / "x.mcpl").write_bytes(good(5))
    assert len(read_mcpl(tmp_path / "x.mcpl")) == 5
    with pytest.raises(InputFileError, match="E801"):
        read_mcpl(tmp_path / "y.mcpl")
    (tmp_path / "y.mcpl").symlink_to(tmp_path / "nowhere")
    (tmp_path / "y.mcpl.gz").write_bytes(gzip.compress(good()))
    with pytest.raises(InputFileError, match="E801"):  # somebody meant that link
        read_mcpl(tmp_path / "y.mcpl")
    (tmp_path / "x.mcpl").write_bytes(gzip.compress(good()))
    (tmp_path / "y.mcpl.gz").write_bytes(good())
    assert len(read_mcpl(tmp_path / "x.mcpl").particles()) == len(read_mcpl(tmp_path / "y.mcpl.gz").particles()) == 3


def with_count(data, n):
    return data[:COUNT_OFFSET] + struct.pack("<Q", n) + data[COUNT_OFFSET + 8 :]


GOOD = good(2000)
PACKED = gzip.compress(GOOD, mtime=0)
BROKEN = {
    "cut": ("E806", PACKED[:-9]), "cut in the check sum": ("E806", PACKED[:-3]),
    "cut in the head": ("E806", gzip.compress(good(), 0)[:40]), "two bytes": ("E806", b"\x1f\x8b"),
    "a byte of the check sum": ("E806", PACKED[:-8] + bytes([PACKED[-8] ^ 1]) + PACKED[-7:]),
    "a byte of the length": ("E806", PACKED[:-1] + b"\x7f"), "no deflate": ("E806", PACKED[:10] + b"\xff" * 50),
    "another method": ("E806", b"\x1f\x8b\x07" + PACKED[3:]), "more behind it": ("E806", PACKED + b"more"),
    "nothing packed": ("E802", gzip.compress(b"")), "no mcpl": ("E802", gzip.compress(b"text" * 100)),
    "packed twice": ("E802", gzip.compress(PACKED)), "a record too few": ("E804", gzip.compress(GOOD[:-5])),
    "a record too many": ("E804", gzip.compress(GOOD + bytes(32))),
    "never closed": ("E804", gzip.compress(with_count(GOOD, 0))),
    "ten to the 18": ("E804", gzip.compress(with_count(GOOD, 10**18))),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken_packed_files_have_their_code(name, tmp_path):
    code, data = BROKEN[name]
    (tmp_path / "x.mcpl.gz").write_bytes(data)
    with pytest.raises(InputFileError) as caught:
        check_mcpl(tmp_path / "x.mcpl.gz")
    assert [problem.code for problem in caught.value.problems] == [code]


def bomb(path, head, n_bytes):
    """A head and megabytes of zeros behind it, of which one is packed and stands there again and again."""
    block, n_blocks, crc = bytes(1 << 20), n_bytes >> 20, zlib.crc32(head)
    for _ in range(n_blocks):
        crc = zlib.crc32(block, crc)
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    first, again = (packer.compress(data) + packer.flush(zlib.Z_FULL_FLUSH) for data in (head, block))
    tail = packer.flush() + struct.pack("<II", crc, len(head) + n_bytes)
    path.write_bytes(b"\x1f\x8b\x08" + bytes(7) + first + again * n_blocks + tail)


READERS = """
from aomc_sky.formats.mcpl.file import check_mcpl, read_mcpl
def read_some(path):
    n = 0
    for block in read_mcpl(path).blocks():
        n += len(block)
        if n > 200_000:
            break
readers = (read_some,)
"""


@pytest.mark.parametrize("kind", ["many records", "endless comment", "many comments"])
def test_bombs_cost_little(kind, tmp_path):
    """256 MiB in a quarter of a megabyte: records stream through, and a head ends where heads end."""
    path, n_bytes, head = tmp_path / "x.mcpl.gz", 1 << 28, encode_header(HEADER)
    heads = {
        "many records": with_count(head, n_bytes // HEADER.record.itemsize),
        "endless comment": head[:56] + struct.pack("<I", n_bytes),
        "many comments": head[:16] + struct.pack("<I", n_bytes // 4) + head[20:48],
    }
    bomb(path, heads[kind], n_bytes)
    assert path.stat().st_size < 300_000
    # the whole would be 256 MiB more, and Python with numpy is 50
    assert answers_within_limits(READERS, path) == ["read" if kind == "many records" else "E803"]
