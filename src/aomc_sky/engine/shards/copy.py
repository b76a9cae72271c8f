"""The photon files of a whole run from those of its shards: copied block by block, every block checked."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from aomc_sky.engine.job import MadePhotons, Meter, Progress
from aomc_sky.engine.shards.shard_set import StoredShard
from aomc_sky.errors import OutputError, ShardError
from aomc_sky.outputs.blocks.chunk_pool import ChunkPool
from aomc_sky.outputs.blocks.content_tree import BLOCK
from aomc_sky.outputs.blocks.statistics import PhotonSums
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.photons.files import PhotonFiles
from aomc_sky.outputs.photons.leaves import BlockHashWriter
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.outputs.photons.stored import StoredBlock, StoredPhotons

MAX_DAMAGES = 100
"""Damaged places after which the search for more ends."""


def copy_shards(
    pool: ChunkPool,
    folder: RunFolder,
    shards: Sequence[StoredShard],
    bands: Sequence[int],
    progress: Progress | None = None,
) -> MadePhotons:
    """Copy wavebands one after the other, on the threads of a pool.

    Parameters
    ----------
    pool : ChunkPool
        Threads, and the whole run.
    folder : RunFolder
        Claimed for its plan.
    shards : sequence of StoredShard
        All of one division, in order.
    bands : sequence of int
        Wavebands to copy. [0-based]
    progress : callable, optional
        Called with photons done and photons in all.

    Returns
    -------
    MadePhotons

    Raises
    ------
    ShardError
        Something is damaged; every place is named, up to `MAX_DAMAGES`.
    OutputError
        The operating system refuses, or the disk is known to be too small.
    """
    copy = _ShardCopy(pool, folder, shards, bands)
    try:
        return copy.make(progress)
    except ShardError:
        copy.withdraw()
        raise


class _ShardCopy:
    """A copy under way."""

    def __init__(self, pool: ChunkPool, folder: RunFolder, shards: Sequence[StoredShard], bands: Sequence[int]) -> None:
        self._pool, self._folder, self._shards = pool, folder, shards
        writers = (NpyWriter(pool.source), BlockHashWriter(pool.source))
        self._parts = {band: [PhotonFiles(folder, writer, (band,)) for writer in writers] for band in bands}
        self._finished: list[int] = []
        self._damages: list[str] = []
        folder.require_space(sum(part.n_bytes_missing for parts in self._parts.values() for part in parts))

    def make(self, progress: Progress | None = None) -> MadePhotons:
        """Copy everything."""
        meter, sums = Meter(progress), {}
        meter.total = sum(self._pool.source.n_photons(band) for band in self._parts)
        for band, parts in self._parts.items():
            sums[band] = PhotonSums(self._pool.source.replicates)
            with contextlib.suppress(ShardError), contextlib.ExitStack() as stack:
                if not self._damages:
                    for part in parts:
                        stack.enter_context(part)
                self._copy_band(band, parts, sums[band], meter)
                self._refuse_damaged()  # inside, so that files of this waveband vanish
            if not self._damages:
                self._finished.append(band)
            elif len(self._damages) >= MAX_DAMAGES:
                break
        self._refuse_damaged()
        entries: dict[str, dict[str, Any]] = {}
        for parts in self._parts.values():
            for part in parts:
                entries |= part.entries()
        return MadePhotons(files=entries, sums=sums, emitted=0)

    def withdraw(self) -> None:
        """Remove the files that this copy finished."""
        for band in self._finished:
            for part in self._parts[band]:
                for name in part.names:
                    self._folder.remove(name)

    def _refuse_damaged(self) -> None:
        if self._damages:
            advice = "run each of these shards again (--shard k/K): what is damaged is made anew, and nothing else"
            raise ShardError(self._damages, advice)

    def _copy_band(self, band: int, parts: list[PhotonFiles], sums: PhotonSums, meter: Meter) -> None:
        for stored in self._shards:
            for block in self._blocks(stored, band):
                meter.add(block.n_photons)
                if not self._damages:
                    for part, chunks in zip(parts, (block.chunks, (memoryview(block.leaf),)), strict=True):
                        part.write(chunks)
                    sums.add(block.sums)
            if len(self._damages) >= MAX_DAMAGES:
                return

    def _blocks(self, stored: StoredShard, band: int) -> Iterator[StoredBlock]:
        """Blocks of a shard that agree with their leaves; what does not is noted."""
        source, writer = self._pool.source, NpyWriter(self._pool.source, stored.shard)
        n_photons = source.n_photons(band)
        leaves = self._leaves(stored, band)
        faults = list(_file_faults(stored, writer, band, n_photons))
        self._damages += [f"{stored}: {fault}" for fault in faults]
        if leaves is None or faults:
            return
        spans = list(stored.shard.block_spans(n_photons))
        with (
            StoredPhotons(stored.folder, source, writer, band) as photons,
            contextlib.closing(self._pool.in_order(photons.block, spans)) as blocks,
        ):
            for leaf, span, block in zip(leaves, spans, blocks, strict=True):
                if block.leaf == leaf.tobytes():
                    yield block
                else:
                    self._damages.append(f"{stored}: {_block(band, span)} is damaged")

    def _leaves(self, stored: StoredShard, band: int) -> np.ndarray | None:
        writer = BlockHashWriter(self._pool.source, stored.shard)
        name = writer.names((band,))[0]
        try:
            leaves = writer.read(stored.folder, band)
            if stored.folder.sha256_of(name) == stored.manifest()["files"][name]["sha256"]:
                return leaves
        except (KeyError, OutputError):
            pass
        self._damages.append(f"{stored}: {name} is missing or damaged")
        return None


def _file_faults(stored: StoredShard, writer: NpyWriter, band: int, n_photons: int) -> Iterator[str]:
    """What is wrong with the length or the head of the files of a shard."""
    first, end = stored.shard.photons(n_photons)
    files = (writer.names((band,)), writer.headers((band,)), writer.sizes((band,)), writer.widths)
    for name, head, size, width in zip(*files, strict=True):
        found = stored.folder.size_of(name)
        if found is None:
            yield f"{name} is missing"
        elif found < size:
            place = first + max(found - len(head), 0) // (width * writer.row_dtype.itemsize)
            start = place // BLOCK * BLOCK
            yield f"{name} is cut after {found} of {size} bytes, in {_block(band, (start, min(start + BLOCK, end)))}"
        elif found > size:
            last = ((end - 1) // BLOCK * BLOCK, end)
            after = f" after {_block(band, last)}" if end > first else ", for it holds no photons"
            yield f"{name} is {found - size} bytes too long{after}"
        elif stored.folder.head_of(name, len(head)) != head:
            yield f"{name} begins with another head than that of {end - first} photons of waveband {band + 1}"


def _block(band: int, span: tuple[int, int]) -> str:
    return f"block {span[0] // BLOCK} of waveband {band + 1} (photons {span[0]} to {span[1] - 1})"
