"""A stretch of a waveband, written by any process into the middle of the files of a run; and the end of these files."""

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
from aomc_sky.outputs.photons.stored import StoredPhotons
from aomc_sky.source.photon_source import PhotonSource

STRETCH_PHOTONS = 1 << 20
"""Photons of a stretch, more where a run would have beyond `MAX_STRETCHES` of them."""

MAX_STRETCHES = 1000

_READ_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True, slots=True)
class Stretch:
    """Part of a waveband that is one task.

    Parameters
    ----------
    band : int
        Which waveband. [0-based]
    part : Shard
        Which of its blocks.
    """

    band: int
    part: Shard


@dataclass(frozen=True, kw_only=True, slots=True)
class MadeStretch:
    """What stands in the files of a run now.

    Parameters
    ----------
    stretch : Stretch
        Which photons.
    sums : PhotonSums
        Sums over its photons.
    word_sum : int
        Sum of the words of its rows in all files. [modulo 2**64]
    emitted : int
        Photons that had to be made.
    """

    stretch: Stretch
    sums: PhotonSums
    word_sum: int
    emitted: int

    @property
    def n_photons(self) -> int:
        """Photons of the stretch."""
        return self.sums.n_photons


def stretches_of(source: PhotonSource, bands: Sequence[int]) -> dict[int, list[Stretch]]:
    """How a run of all these wavebands is divided: by its photons alone, so any cluster goes on where another ended."""
    most = max(1, MAX_STRETCHES // len(bands))
    found = {}
    for band in bands:
        count = min(max(1, -(-source.n_photons(band) // STRETCH_PHOTONS)), most)
        parts = (Shard(index=k + 1, count=count, mark=PART[1:]) for k in range(count))
        found[band] = [Stretch(band=band, part=part) for part in parts]
    return found


def make_stretch(source: PhotonSource, folder: RunFolder, stretch: Stretch) -> MadeStretch:
    """Write the photons of a stretch into files that are reserved, then their leaves, which say that it is done.

    Parameters
    ----------
    source : PhotonSource
        The run.
    folder : RunFolder
        Where `NpyParts.reserve` made the files of the waveband.
    stretch : Stretch
        Which photons.

    Returns
    -------
    MadeStretch
        One that agrees with its leaves is only read.

    Raises
    ------
    OutputError
        The operating system refuses.

    Notes
    -----
    Any number of processes may make one stretch at once: they write the same bytes at the same places.
    """
    band, files = stretch.band, NpyParts(source)
    leaves = BlockHashWriter(source, stretch.part)
    stored = _stored(source, folder, stretch, leaves)
    if stored is not None:
        return stored
    n_photons, sums, total = 0, PhotonSums(source.replicates), 0
    first = stretch.part.photons(source.n_photons(band))[0]
    with (
        ChunkPool(source, 1, stretch.part) as pool,
        PhotonFiles(folder, leaves, (band,)) as done,
        files.filling(folder, band) as put,
    ):
        for (rows, leaf), blocks, n in pool.chunks(band, [NpyWriter(source, stretch.part), leaves]):
            put(first + n_photons, rows)
            done.write(leaf)
            sums.add(blocks)
            total += word_sum(rows)
            n_photons += n
    return MadeStretch(stretch=stretch, sums=sums, word_sum=total % (1 << 64), emitted=n_photons)


def _stored(source: PhotonSource, folder: RunFolder, stretch: Stretch, leaves: BlockHashWriter) -> MadeStretch | None:
    """What an earlier run left of a stretch, None where there is no end of it or a block that is damaged."""
    try:
        wanted = leaves.read(folder, stretch.band)
    except OutputError:
        return None
    spans = stretch.part.block_spans(source.n_photons(stretch.band))
    sums, total = PhotonSums(source.replicates), 0
    with StoredPhotons(folder, source, NpyParts(source), stretch.band) as photons:
        for leaf, span in zip(wanted, spans, strict=True):
            block = photons.block(span)
            if block.leaf != leaf.tobytes():
                return None
            sums.add(block.sums)
            total += word_sum(block.chunks)
    return MadeStretch(stretch=stretch, sums=sums, word_sum=total % (1 << 64), emitted=0)


def seal_band(
    source: PhotonSource, folder: RunFolder, made: Sequence[tuple[Stretch, int]]
) -> dict[str, dict[str, Any]]:
    """Give the files of a waveband their final names.

    Parameters
    ----------
    source : PhotonSource
        The run.
    folder : RunFolder
        Where they stand.
    made : sequence of (Stretch, int)
        All stretches of the waveband in order, with the sums of their words.

    Returns
    -------
    dict
        Bytes and SHA-256 of every file by its name.

    Raises
    ------
    OutputError
        The operating system refuses, or what is read is not what was written.
    """
    band = made[0][0].band
    photons, leaves = (PhotonFiles(folder, writer(source), (band,)) for writer in (NpyWriter, BlockHashWriter))
    if photons.is_finished and leaves.is_finished:  # by a worker that was lost before it could say so
        return photons.entries() | leaves.entries()
    with leaves:
        for stretch, _ in made:
            of_stretch = BlockHashWriter(source, stretch.part).read(folder, band)
            leaves.write((memoryview(of_stretch.tobytes()),))
    entries = _hashed(source, folder, made) | leaves.entries()
    for part, name in zip(NpyParts(source).names((band,)), photons.names, strict=True):
        folder.finish(part, name)
    return entries


def _hashed(source: PhotonSource, folder: RunFolder, made: Sequence[tuple[Stretch, int]]) -> dict[str, dict[str, Any]]:
    """Entries of filled files, once every stretch of them is what a worker wrote."""
    band, parts, final = made[0][0].band, NpyParts(source), NpyWriter(source)
    heads, sizes = parts.headers((band,)), parts.sizes((band,))
    digests = [hashlib.sha256(head) for head in heads]
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(folder.reading(name)) for name in parts.names((band,))]
        for file, head in zip(files, heads, strict=True):
            file.seek(len(head))
        for stretch, wanted in made:
            first, end = stretch.part.photons(source.n_photons(band))
            found = 0
            for file, digest, width in zip(files, digests, parts.widths, strict=True):
                for piece in _pieces(file, (end - first) * width * parts.row_dtype.itemsize):
                    digest.update(piece)
                    found += word_sum((piece,))
            if found % (1 << 64) != wanted:
                raise _lost(folder, source, stretch)
    names = final.names((band,))
    return {
        name: {"bytes": size, "sha256": digest.hexdigest()}
        for name, size, digest in zip(names, sizes, digests, strict=True)
    }


def _pieces(file: Any, n_bytes: int) -> Iterator[bytes]:
    while n_bytes > 0 and (piece := file.read(min(n_bytes, _READ_BYTES))):
        n_bytes -= len(piece)
        yield piece


def _lost(folder: RunFolder, source: PhotonSource, stretch: Stretch) -> OutputError:
    """Leave the stretch to be made again, and say so."""
    folder.remove(BlockHashWriter(source, stretch.part).names((stretch.band,))[0])
    first, end = stretch.part.photons(source.n_photons(stretch.band))
    return OutputError(
        f"{folder.path}: photons {first} to {end - 1} of waveband {stretch.band + 1} are not what was written: the "
        "file system lost some, or another process wrote there. The same command makes these again"
    )
