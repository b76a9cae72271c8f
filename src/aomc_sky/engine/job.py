"""Photons into the files of a run or shard: what stands there is checked, what is missing or damaged is made."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from aomc_sky.kernels.backend import expect_photons
from aomc_sky.outputs.blocks.chunk_pool import ChunkPool
from aomc_sky.outputs.blocks.statistics import PhotonSums
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.photons.files import PhotonFiles, photon_files
from aomc_sky.outputs.photons.leaves import BlockHashWriter
from aomc_sky.outputs.photons.stored import StoredPhotons

Progress = Callable[[int, int], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class MadePhotons:
    """What stands in the folder now.

    Parameters
    ----------
    files : dict
        Bytes and SHA-256 of every photon file and every file of leaves by its name.
    sums : dict
        Sums over the photons of every waveband. [0-based]
    emitted : int
        Photons that had to be made.
    """

    files: dict[str, dict[str, Any]]
    sums: dict[int, PhotonSums]
    emitted: int


class Meter:
    """Photons done and photons in all, told as they change.

    Parameters
    ----------
    progress : callable, optional
        Called with both.
    """

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self.done = self.total = 0

    def add(self, n_photons: int) -> None:
        """So many more are done."""
        self.done += n_photons
        if self._progress:
            self._progress(self.done, self.total)


class _BandFiles:
    """The files that hold one waveband alone.

    Notes
    -----
    Leaves get their name before the photons that they are of, so photons without leaves are not of a run that
    was killed. Photons that do not agree with their leaves are made again together with these, for nobody
    knows which of the two is damaged.
    """

    def __init__(self, band: int, own: list[PhotonFiles], leaves: PhotonFiles) -> None:
        self.band, self.own, self.leaves = band, own, leaves
        self.kept = [part for part in own if part.is_finished] if leaves.is_finished else []
        self.sums: PhotonSums | None = None

    @property
    def checkable(self) -> list[PhotonFiles]:
        """Finished files whose photons can be compared with their leaves."""
        return [part for part in self.kept if part.writer.has_rows]

    @property
    def missing(self) -> list[PhotonFiles]:
        """Files to make, the leaves last so that they are closed first."""
        agree = self.sums is not None
        return [*(part for part in self.own if part not in self.kept), *([] if agree else [self.leaves])]

    def check(self, pool: ChunkPool, folder: RunFolder, meter: Meter) -> None:
        """Read what is there; keep it if every block agrees with its leaf."""
        wanted = self.leaves.writer.read(folder, self.band) if self.checkable else None
        for part in self.checkable:
            self.sums = _stored_sums(pool, folder, part.writer, self.band, wanted, meter)
            if self.sums is None:
                self.kept = []
                return


def _stored_sums(
    pool: ChunkPool, folder: RunFolder, writer: Any, band: int, wanted: Any, meter: Meter
) -> PhotonSums | None:
    """Sums over the photons of finished files, None where a block does not agree with its leaf."""
    sums = PhotonSums(pool.source.replicates)
    spans = writer.shard.block_spans(pool.source.n_photons(band))
    with (
        StoredPhotons(folder, pool.source, writer, band) as stored,
        contextlib.closing(pool.in_order(stored.block, spans)) as blocks,
    ):
        for leaf, block in zip(wanted, blocks, strict=True):
            if block.leaf != leaf.tobytes():
                meter.total += sums.n_photons  # read in vain
                return None
            sums.add(block.sums)
            meter.add(block.n_photons)
    return sums


class PhotonJob:
    """The photon files of a run or shard and their leaves: made where they are missing or damaged.

    Parameters
    ----------
    pool : ChunkPool
        What makes the photons; it knows the run and the shard.
    folder : RunFolder
        Claimed for the plan of the run.
    writers : sequence
        Of `outputs.PHOTON_FORMATS`, for the same run and shard.
    bands : sequence of int
        Which wavebands. [0-based]

    Raises
    ------
    OutputError
        The disk is known to be too small.
    """

    def __init__(self, pool: ChunkPool, folder: RunFolder, writers: Sequence[Any], bands: Sequence[int]) -> None:
        self._pool, self._folder = pool, folder
        parts = photon_files(folder, writers, bands)
        leaves = BlockHashWriter(pool.source, pool.shard)
        self._bands = [
            _BandFiles(band, [part for part in parts if part.bands == (band,)], PhotonFiles(folder, leaves, (band,)))
            for band in bands
        ]
        self._shared = [part for part in parts if len(part.bands) > 1 and not part.is_finished]
        self._every = [*parts, *(files.leaves for files in self._bands)]
        folder.require_space(sum(part.n_bytes_missing for part in self._every))

    def make(self, progress: Progress | None = None) -> MadePhotons:
        """Make the files that are missing or damaged, and the sums of all wavebands.

        Parameters
        ----------
        progress : callable, optional
            Called with photons done and photons in all; finished photons that are read count too.

        Returns
        -------
        MadePhotons

        Raises
        ------
        OutputError
            The operating system refuses; nothing half is left.
        """
        n_photons = {files.band: _n_photons(self._pool, files.band) for files in self._bands}
        expect_photons(sum(n_photons.values()))
        meter = Meter(progress)
        for files in self._bands:
            n_passes = len(files.checkable) + bool(self._shared or not files.checkable)
            meter.total += n_passes * n_photons[files.band]
        for files in self._bands:
            files.check(self._pool, self._folder, meter)
        sums: dict[int, PhotonSums] = {}
        emitted = 0
        with contextlib.ExitStack() as stack:
            for part in self._shared:
                stack.enter_context(part)
            for files in self._bands:
                if files.sums is None or files.missing or self._shared:
                    files.sums = _emit(self._pool, files, self._shared, meter)
                    emitted += n_photons[files.band]
                sums[files.band] = files.sums
        entries: dict[str, dict[str, Any]] = {}
        for of_part in self._pool.in_order(PhotonFiles.entries, self._every):
            entries |= of_part
        return MadePhotons(files=entries, sums=sums, emitted=emitted)


def _n_photons(pool: ChunkPool, band: int) -> int:
    first, end = pool.shard.photons(pool.source.n_photons(band))
    return end - first


def _emit(pool: ChunkPool, files: _BandFiles, shared: list[PhotonFiles], meter: Meter) -> PhotonSums:
    sums = PhotonSums(pool.source.replicates)
    with contextlib.ExitStack() as stack:
        parts = [*(stack.enter_context(part) for part in files.missing), *shared]
        for chunks, blocks, n in pool.chunks(files.band, [part.writer for part in parts]):
            for part, chunk in zip(parts, chunks, strict=True):
                part.write(chunk)
            sums.add(blocks)
            meter.add(n)
    return sums
