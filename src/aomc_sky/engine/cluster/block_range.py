"""Blocks of a waveband that any process writes into the middle of the files of a run; and the end of these files."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from aomc_sky.errors import OutputError
from aomc_sky.outputs.blocks.chunk_pool import ChunkPool
from aomc_sky.outputs.blocks.shard import Shard
from aomc_sky.outputs.blocks.statistics import PhotonSums
from aomc_sky.outputs.folder.run_folder import PART, RunFolder
from aomc_sky.outputs.photons.files import PhotonFiles
from aomc_sky.outputs.photons.leaves import BlockHashWriter
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.outputs.photons.npy_parts import NpyParts, word_sum
from aomc_sky.outputs.photons.stored import compared_blocks
from aomc_sky.source.photon_source import PhotonSource

RANGE_PHOTONS = 1 << 20
"""Photons of a range, more where a run would have beyond `MAX_RANGES` of them."""

MAX_RANGES = 1000

_READ_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True, slots=True)
class BlockRange:
    """Part of a waveband that is one task."""

    band: int  #: which waveband [0-based]
    shard: Shard  #: which of its blocks


@dataclass(frozen=True, kw_only=True, slots=True)
class MadeRange:
    """What stands in the files of a run now."""

    block_range: BlockRange
    sums: PhotonSums  #: over its photons
    word_sum: int  #: sum of the words of its rows in all files [modulo 2**64]
    emitted: int  #: photons that had to be made

    @property
    def n_photons(self) -> int:
        """Photons of the range."""
        return self.sums.n_photons


def block_ranges(source: PhotonSource, bands: Sequence[int]) -> dict[int, list[BlockRange]]:
    """How a run of all these wavebands is divided: by its photons alone, so any cluster goes on where another ended."""
    most = max(1, MAX_RANGES // len(bands))
    ranges = {}
    for band in bands:
        count = min(max(1, -(-source.n_photons(band) // RANGE_PHOTONS)), most)
        shards = (Shard(index=k + 1, count=count, mark=PART[1:]) for k in range(count))
        ranges[band] = [BlockRange(band=band, shard=shard) for shard in shards]
    return ranges


def make_range(source: PhotonSource, folder: RunFolder, block_range: BlockRange) -> MadeRange:
    """Write photons into files that `NpyParts.reserve` made, then their leaves, which say that they are done.

    A range that agrees with its leaves is only read. Any number of processes may make one range at once: they
    write the same bytes at the same positions.
    """
    band, shard, files = block_range.band, block_range.shard, NpyParts(source)
    leaves = BlockHashWriter(source, shard)
    with ChunkPool(source, 1, shard) as pool:
        stored = _stored(pool, folder, block_range, leaves)
        if stored is not None:
            return stored
        n_photons, sums, total = 0, PhotonSums(source.replicates), 0
        first = shard.photons(source.n_photons(band))[0]
        with PhotonFiles(folder, leaves, (band,)) as done, files.filling(folder, band) as put:
            for (rows, leaf), blocks, n in pool.chunks(band, [NpyWriter(source, shard), leaves]):
                put(first + n_photons, rows)
                done.write(leaf)
                sums.add(blocks)
                total += word_sum(rows)
                n_photons += n
    return MadeRange(block_range=block_range, sums=sums, word_sum=total % (1 << 64), emitted=n_photons)


def _stored(pool: ChunkPool, folder: RunFolder, block_range: BlockRange, leaves: BlockHashWriter) -> MadeRange | None:
    """What an earlier run left of a range, None where its leaves are missing or a block is damaged."""
    source, band = pool.source, block_range.band
    try:
        expected = leaves.read(folder, band)
    except OutputError:
        return None
    sums, total = PhotonSums(source.replicates), 0
    compared = compared_blocks(pool, folder, NpyParts(source), band, block_range.shard, expected)
    with contextlib.closing(compared) as blocks:
        for block, agrees in blocks:
            if not agrees:
                return None
            sums.add(block.sums)
            total += word_sum(block.chunks)
    return MadeRange(block_range=block_range, sums=sums, word_sum=total % (1 << 64), emitted=0)


def finish_band(
    source: PhotonSource, folder: RunFolder, made: Sequence[tuple[BlockRange, int]]
) -> dict[str, dict[str, Any]]:
    """Give the files of a waveband their final names; return the bytes and SHA-256 of every file by its name.

    `made` are all ranges of the waveband in order, with the sums of their words; OutputError where what is read is
    not what was written.
    """
    band = made[0][0].band
    photons, leaves = (PhotonFiles(folder, writer(source), (band,)) for writer in (NpyWriter, BlockHashWriter))
    if photons.is_finished and leaves.is_finished:  # by a worker that was lost before it could report so
        return photons.entries() | leaves.entries()
    with leaves:
        for block_range, _ in made:
            of_range = BlockHashWriter(source, block_range.shard).read(folder, band)
            leaves.write((memoryview(of_range.tobytes()),))
    entries = _hashed(source, folder, made) | leaves.entries()
    for part, name in zip(NpyParts(source).names((band,)), photons.names, strict=True):
        folder.finish(part, name)
    return entries


def _hashed(
    source: PhotonSource, folder: RunFolder, made: Sequence[tuple[BlockRange, int]]
) -> dict[str, dict[str, Any]]:
    """Entries of filled files, once every range of them is what a worker wrote."""
    band, parts = made[0][0].band, NpyParts(source)
    heads, sizes = parts.headers((band,)), parts.sizes((band,))
    digests = [hashlib.sha256(head) for head in heads]
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(folder.reading(name)) for name in parts.names((band,))]
        for file, head in zip(files, heads, strict=True):
            file.seek(len(head))
        for block_range, expected in made:
            first, end = block_range.shard.photons(source.n_photons(band))
            total = 0
            for file, digest, width in zip(files, digests, parts.widths, strict=True):
                for piece in _pieces(file, (end - first) * width * parts.row_dtype.itemsize):
                    digest.update(piece)
                    total += word_sum((piece,))
            if total % (1 << 64) != expected:
                raise _lost(folder, source, block_range)
    names = NpyWriter(source).names((band,))
    return {
        name: {"bytes": size, "sha256": digest.hexdigest()}
        for name, size, digest in zip(names, sizes, digests, strict=True)
    }


def _pieces(file: Any, n_bytes: int) -> Iterator[bytes]:
    while n_bytes > 0 and (piece := file.read(min(n_bytes, _READ_BYTES))):
        n_bytes -= len(piece)
        yield piece


def _lost(folder: RunFolder, source: PhotonSource, block_range: BlockRange) -> OutputError:
    """Leave the range to be made again, and say so."""
    band = block_range.band
    folder.remove(BlockHashWriter(source, block_range.shard).names((band,))[0])
    first, end = block_range.shard.photons(source.n_photons(band))
    return OutputError(
        f"{folder.path}: photons {first} to {end - 1} of waveband {band + 1} are not what was written: the "
        "file system lost some, or another process wrote there. The same command makes these again"
    )
